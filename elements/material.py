"""The linear elastic, isotropic material of a beam."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf

import numpy as np
from numpy.typing import ArrayLike

from ..framework.batch import numbers
from ..framework.errors import FrameError
from ..framework.lazily import cached_property
from .parameters import (
    Real,
    as_real,
    common_shape,
    derived_numbers,
    extent,
    not_negative,
    number,
    positive,
    positive_with_extent,
    require,
    shape_of,
)


@dataclass(frozen=True, eq=False, init=False)
class Material:
    """Young's modulus, shear modulus and density.

    Give `nu` or `G`; the other follows from ``G = E / (2 (1 + nu))`` (Timoshenko & Goodier,
    *Theory of Elasticity*, 3rd ed., ch. 1). Any of the numbers may be an array.

    Parameters
    ----------
    E : array_like
        Young's modulus, (...), force per area, above zero.
    nu : array_like, optional
        Poisson's ratio, (...), between -1 and 0.5, ends excluded.
    G : array_like, optional
        Shear modulus, (...), force per area, above zero. It may be chosen independently of E (for timber, say):
        the `nu` that follows from it need not lie between -1 and 0.5.
    density : array_like
        Mass per volume, (...), zero or above.

    Raises
    ------
    FrameError
        If a number is out of its range, or unless exactly one of `nu` and `G` is given.

    Examples
    --------
    >>> from linkframe.elements import Material
    >>> steel = Material(E=200e9, nu=0.25, density=7850.0)
    >>> steel.G
    80000000000.0
    """

    E: Real
    nu: Real
    G: Real
    density: Real

    def __init__(
        self,
        *,
        E: ArrayLike,
        nu: ArrayLike | None = None,
        G: ArrayLike | None = None,
        density: ArrayLike = 0.0,
    ) -> None:
        young, (least, most) = positive_with_extent("Material", "E", E)
        if G is None and nu is not None:
            ratio = number("Material", "nu", nu)
            if not (type(ratio) is float and -1.0 < ratio < 0.5):
                inside = (np.asarray(ratio) > -1.0) & (np.asarray(ratio) < 0.5)
                require("Material", "nu", np.asarray(ratio), inside, "between -1 and 0.5, ends excluded")
                common_shape("Material", {"E": np.shape(young), "nu": np.shape(ratio)})
            shear = young / (2.0 * (1.0 + ratio))
        elif nu is None and G is not None:
            shear = positive("Material", "G", G)
            common_shape("Material", {"E": np.shape(young), "G": np.shape(shear)})
            ratio = as_real(numbers(young / (2.0 * shear) - 1.0, "Material: nu"))
        else:
            raise FrameError(f"Material: nu = {nu!r}, G = {G!r}: give one of the two, nu or G")
        # as most often: G has the shape of E, and is in the range of floats where its extremes are
        plain = G is None and isinstance(ratio, float) and _in_range(least, most, 2.0 * (1.0 + ratio))
        if not plain:
            shear = derived_numbers("Material", {"G": shear})["G"]
        elif isinstance(shear, np.ndarray):
            shear.setflags(write=False)
        dense = not_negative("Material", "density", density)
        shape = np.shape(young)
        if not (plain and isinstance(dense, float)):
            shape = common_shape("Material", {"E": shape, "G": np.shape(shear), "density": np.shape(dense)})
        vars(self).update(E=young, nu=ratio, G=shear, density=dense, shape=shape, _range=(least, most))

    @cached_property
    def _range(self) -> tuple[float, float]:
        """Least and greatest Young's modulus over the batch."""
        if isinstance(self.E, float):
            return self.E, self.E
        return extent(self.E)

    @cached_property
    def shape(self) -> tuple[int, ...]:
        """Batch shape: the broadcast of moduli and density."""
        return shape_of(self.E, self.G, self.density)


def _in_range(least: float, most: float, by: float) -> bool:
    """Whether numbers between these are positive floats after they are divided."""
    return least / by > 0.0 and most / by < inf
