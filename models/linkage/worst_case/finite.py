"""Worst case of clearances that are not small: contact in a rigid linkage, with finite rotations."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from ....framework.batch import Array
from ..derivatives.position_sensitivity import PositionSensitivity
from ..description.linkage_description import LinkageDescription
from ..statics.frame import Builder


@dataclass(frozen=True, eq=False, repr=False)
class FiniteWorstCase:
    """Displacement of a point that a force pulls until all joints are in contact; made by `WorstCase.finite`.

    Attributes
    ----------
    direction
        Unit vector of the force, (..., 3).
    displacement
        Displacement of the point, (..., 3), with finite rotations; NaN where no stable contact was found.
    first_order
        Displacement in the worst case to first order, (..., 3).
    """

    direction: Array
    displacement: Array
    first_order: Array

    def __repr__(self) -> str:
        off = self.difference
        text = (
            f"first order is off by up to {100.0 * np.nanmax(np.abs(off)):.2g} %" if np.isfinite(off).any() else "none"
        )
        return f"<FiniteWorstCase of shape {self.reach.shape}: {text}>"

    @property
    def reach(self) -> Array:
        """Displacement in the direction of the force, (...)."""
        return np.asarray(np.sum(self.displacement * self.direction, axis=-1))

    @property
    def difference(self) -> Array:
        """Relative difference of `reach` from its value to first order, (...); negative where it is less."""
        expected = np.sum(self.first_order * self.direction, axis=-1)
        return np.asarray(self.reach / np.where(expected > 0.0, expected, np.nan) - 1.0)


def finite(
    by: PositionSensitivity, clearances: Mapping[str, Array], direction: Array, first_order: Array
) -> FiniteWorstCase:
    """Displacement of a point of the rigid linkage under a force, with the given clearances; see `WorstCase.finite`."""
    motion = replace(by.motion, linkage=rigid(by.linkage, clearances))
    built = Builder(motion, clearance=True)
    node = built.nodes.of(by.link, by.point)
    n = np.where(np.isfinite(direction), direction, 0.0)
    built.frame.load(node, fx=n[..., 0], fy=n[..., 1], fz=n[..., 2])
    displacement = built.frame.solve(large=True).displacement(node)[..., :3]
    return FiniteWorstCase(direction, displacement, first_order)


def rigid(linkage: LinkageDescription, clearances: Mapping[str, Array]) -> LinkageDescription:
    """The linkage with rigid links, ideal joints and the given clearances, without springs and loads."""
    out = linkage.alike()
    out.links = {name: replace(link, beams={}, mass=None, inertia=None) for name, link in linkage.links.items()}
    out.joints = {
        name: replace(pair, stiffness=None, contact=None, clearance=clearances.get(name))
        for name, pair in linkage.joints.items()
    }
    out.springs, out.loads = [], []
    return out
