"""The linear elastic, isotropic material of a beam."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from ..framework.batch import numbers
from ..framework.errors import FrameError
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
            inside = (np.asarray(ratio) > -1.0) & (np.asarray(ratio) < 0.5)
            require("Material", "nu", np.asarray(ratio), inside, "between -1 and 0.5, ends excluded")
            common_shape("Material", {"E": np.shape(young), "nu": np.shape(ratio)})
            shear = young / (2.0 * (1.0 + ratio))
        elif nu is None and G is not None:
            shear = positive("Material", "G", G)
            common_shape("Material", {"E": np.shape(young), "G": np.shape(shear)})
            ratio = young / (2.0 * shear) - 1.0
        else:
            raise FrameError(f"Material: nu = {nu!r}, G = {G!r}: give one of the two, nu or G")
        object.__setattr__(self, "E", young)
        object.__setattr__(self, "nu", as_real(numbers(ratio, "Material: nu")))
        object.__setattr__(self, "G", derived_numbers("Material", {"G": shear})["G"])
        object.__setattr__(self, "density", not_negative("Material", "density", density))
        common_shape("Material", {name: np.shape(getattr(self, name)) for name in ("E", "G", "density")})

    @cached_property
    def shape(self) -> tuple[int, ...]:
        """Batch shape: the broadcast of moduli and density."""
        return shape_of(self.E, self.G, self.density)
