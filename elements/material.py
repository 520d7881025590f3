"""The linear elastic, isotropic material of a beam."""

from __future__ import annotations

from dataclasses import dataclass

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
    not_negative,
    number,
    positive,
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
        young = positive("Material", "E", E)
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
        shear = derived_numbers("Material", {"G": shear})["G"]
        dense = not_negative("Material", "density", density)
        shape = common_shape("Material", {"E": np.shape(young), "G": np.shape(shear), "density": np.shape(dense)})
        vars(self).update(E=young, nu=ratio, G=shear, density=dense, shape=shape)

    @cached_property
    def _range(self) -> tuple[float, float]:
        """Least and greatest Young's modulus over the batch."""
        if isinstance(self.E, float):
            return self.E, self.E
        return float(self.E.min(initial=np.inf)), float(self.E.max(initial=0.0))

    @cached_property
    def shape(self) -> tuple[int, ...]:
        """Batch shape: the broadcast of moduli and density."""
        return shape_of(self.E, self.G, self.density)
