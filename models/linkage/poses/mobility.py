"""Degrees of freedom of a linkage: the Grübler-Kutzbach count, and the actual mobility."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ....framework.batch import Array
from ....framework.renamed import RenamedAttribute
from ..description.linkage_description import LinkageDescription
from .configuration import ALIKE, FEW_DIGITS, Configurations, Entry, null_space

# Lengths of trial motions, in radians and extents of the linkage, and their number: FAR leads away from a reference
# configuration that may be singular, NEAR is so short that curvature does not count.
FAR, NEAR, TRIALS = 0.05, 1e-3, 8


@dataclass(frozen=True)
class Mobility:
    """Degrees of freedom of a linkage, its drives released.

    Attributes
    ----------
    kutzbach
        The count of M. Grübler and K. Kutzbach, ``d (links - joints) + sum of the joints' freedoms`` with the ground
        not among the links; d is 3 in the plane and 6 in space.
    kutzbach_spatial
        The same with d = 6 in any case.
    planar
        Whether all joints move in one plane, so that d is 3.
    actual
        Dimension of the motions that are possible: degrees of freedom at a position near the reference configuration.
    instantaneous
        Degrees of freedom of the velocities in the reference configuration. More than `actual` where that is singular,
        or where what moves at first does not get far.
    idle
        Links with an idle (passive) degree of freedom: they can move, such as turn about their own line between two
        balls, while all others and the drives stand still.
    nearly
        Degrees of freedom of the velocities in the reference configuration where equations that differ by less than
        1e-3 count as one. More than `instantaneous` where the points of an overconstrained linkage have too few digits.
    redundant
        Joint and component of constraints that others already hold, as many as there are; components are in
        the joint's axes. Which of several that do the same are named is a choice: those of joints that close a loop.
    """

    kutzbach: int
    kutzbach_spatial: int
    planar: bool
    actual: int
    instantaneous: int
    idle: tuple[str, ...]
    nearly: int
    redundant: tuple[tuple[str, str], ...]

    true = RenamedAttribute("actual")
    by_count = RenamedAttribute("kutzbach")
    by_count_in_space = RenamedAttribute("kutzbach_spatial")

    def __str__(self) -> str:
        plane = f"{self.kutzbach} planar, " if self.planar else ""
        lines = [f"mobility {self.actual} (Grübler-Kutzbach: {plane}{self.kutzbach_spatial} spatial)"]
        if self.instantaneous != self.actual:
            freedoms = "1 degree of freedom" if self.instantaneous == 1 else f"{self.instantaneous} degrees of freedom"
            lines.append(f"singular in the reference configuration: {freedoms} of velocity")
        if self.idle:
            lines.append(f"idle (passive) degrees of freedom: {', '.join(self.idle)}")
        joints = dict.fromkeys(joint for joint, _ in self.redundant)
        if joints:
            parts = (f"{j} ({' '.join(c for name, c in self.redundant if name == j)})" for j in joints)
            noun = "constraint" if len(self.redundant) == 1 else "constraints"
            lines.append(f"{len(self.redundant)} redundant {noun}: {', '.join(parts)}")
        if joints and self.actual == 0 < self.nearly:
            lines.append(FEW_DIGITS)
        return "\n".join(lines)


def mobility(linkage: LinkageDescription, tolerance: float = 0.0, entry: Entry = None) -> Mobility:
    """Degrees of freedom of a linkage: by count, and actual.

    The velocities that the joints permit in the reference configuration are the null space of the Jacobian of the
    closing equations, found by singular values. Whether they belong to finite motions is tried by steps along random
    ones, each corrected to a closed position by the Gauss-Newton method: a step that falls back to the reference
    configuration is no motion. From a position reached, which is regular even if the reference configuration is not,
    the independent directions that can be reached in the same way are counted.
    """
    space = Configurations(linkage, tolerance, entry)
    true, state = generic(space)
    planar = is_planar(linkage)
    return Mobility(
        kutzbach=count(linkage, 3 if planar else 6),
        kutzbach_spatial=count(linkage, 6),
        planar=planar,
        actual=true,
        instantaneous=space.free(space.reference_state).shape[1],
        idle=space.idle(state),
        nearly=null_space(space.jacobian(space.reference_state), share=ALIKE).shape[1],
        redundant=redundant(space, state),
    )


def generic(space: Configurations) -> tuple[int, Array]:
    """Mobility, and a regular state near the reference configuration.

    If several motions cross at the reference configuration, it is that of the largest dimension.
    """
    reference_state = space.reference_state
    freedoms = space.free(reference_state).shape[1]
    near = [state for state, _ in neighbours(space, reference_state, FAR, TRIALS)]
    each = [space.free(state).shape[1] for state in near]
    if not near or all(freedom == freedoms for freedom in each):
        return dimension(space, reference_state), reference_state
    best = max(zip(near, each, strict=True), key=lambda one: (dimension(space, one[0]), -one[1]))
    return dimension(space, best[0]), best[0]


def dimension(space: Configurations, state: Array) -> int:
    """Number of independent directions in which closed states lie around one."""
    freedoms = space.free(state).shape[1]
    moves = [move for _, move in neighbours(space, state, NEAR, freedoms + 2)]
    if not moves:
        return 0
    values = np.linalg.svd(np.stack(moves), compute_uv=False)
    return int(np.count_nonzero(values > 0.02 * values[0]))


def neighbours(space: Configurations, state: Array, step: float, trials: int) -> list[tuple[Array, Array]]:
    """Closed states one random step away, with the displacements of the links; without those that fell back."""
    free, start = space.free(state), space.places(state)
    draws = np.random.default_rng(0).normal(size=(trials, free.shape[1]))
    found = []
    for draw in draws if free.shape[1] else ():
        aim = space.advanced(state, step * (free @ draw) / np.linalg.norm(draw))
        there = space.closed(aim)
        if there is not None:
            move = (space.places(there) - start).ravel()
            if np.abs(move).max() > 0.1 * np.abs(space.places(aim) - start).max():
                found.append((there, move))
    return found


def count(linkage: LinkageDescription, freedoms: int) -> int:
    """Grübler-Kutzbach count, with 3 degrees of freedom a link in the plane or 6 in space."""
    joints = linkage.joints.values()
    return freedoms * (len(linkage.links) - len(joints)) + sum(joint.kind.freedom for joint in joints)


def is_planar(linkage: LinkageDescription) -> bool:
    """Whether every joint moves parallel to one plane.

    Axes of rotation are perpendicular to it, sliding axes lie in it, and all other joints are planar or fixed.
    """
    normals, slides = [], []
    for joint in linkage.joints.values():
        axis = joint.axes[..., 2].reshape(-1, 3)
        if joint.kind.name in ("revolute", "planar"):
            normals.append(axis)
        elif joint.kind.name == "prismatic":
            slides.append(axis)
        elif joint.kind.name != "fixed":
            return False
    along = np.concatenate(slides) if slides else np.zeros((1, 3))
    if normals:
        across = np.concatenate(normals)
        return bool(np.abs(np.cross(across, across[0])).max() < 1e-9 and np.abs(along @ across[0]).max() < 1e-9)
    values = np.linalg.svd(along, compute_uv=False)
    return len(values) < 3 or bool(values[2] < 1e-9)


def redundant(space: Configurations, state: Array) -> tuple[tuple[str, str], ...]:
    """Constraints that depend on those before them, by joint and component."""
    basis = np.zeros((0, len(space.mechanism.columns)))
    found = []
    for name, row in zip(space.mechanism.rows, space.in_joint_axes(state), strict=True):
        # twice, as the first orthogonalisation leaves rounding errors
        rest = row - (row @ basis.T) @ basis
        rest = rest - (rest @ basis.T) @ basis
        if np.linalg.norm(rest) > space.dependent:
            basis = np.vstack([basis, rest / np.linalg.norm(rest)])
        else:
            found.append(name)
    return tuple(found)
