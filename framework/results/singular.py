"""The free motions of a mechanism: displacements of nodes, motion in the joints, and the work of the loads on them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..batch import Array
from ..batched.plan import Plan
from ..dofs import DISPLACEMENTS
from ..error_bounds.compliance import DenseCompliance
from ..error_bounds.equilibrium import EquilibriumResidual, Statics
from ..error_bounds.kinematic_edge import Real, extended
from ..error_bounds.resolved import MOST, ill_conditioned_state
from ..errors import FrameError
from ..listing import number as told_number
from ..listing import text_table
from ..solvers.sparse import SparseSolver
from .constrained import ZERO
from .status import length_scale


@dataclass(frozen=True, eq=False, repr=False)
class FreeMotion:
    """Infinitesimal motions of one batch entry that nothing resists.

    If the loads do work on any motion, it is the first one; they do none on the others. The largest displacement of
    each is one, rotations being multiplied by the length of the longest member.

    Attributes
    ----------
    count
        Number of independent motions.
    joints
        By joint: relative displacement in its axes, (count, 6).
    work
        By loaded node: work of its load on each motion, (count,); loads on members are included at their ends.
    drive
        Work of all loads, offsets and prescribed displacements on each motion, (count,).
    solvable
        Whether the loads are in equilibrium: they do no work on any motion, to rounding.
    """

    count: int
    joints: dict[str, Array]
    work: dict[str, Array]
    drive: Array
    solvable: bool
    _displacements: dict[str, Array]

    def __repr__(self) -> str:
        """The motions of the joints as a short table."""
        if not self.count:
            return f"FreeMotion: none of {len(self._displacements)} nodes"
        does = "the load does work on the first" if not self.solvable else "the load does no work on them"
        rows = [
            [name, str(k + 1), *map(told_number, np.where(np.abs(moved[k]) > 1e-9, moved[k], 0.0))]
            for name, moved in self.joints.items()
            for k in range(self.count)
            if np.abs(moved[k]).max() > 1e-9
        ]
        noun = "motion" if self.count == 1 else "motions"
        title = f"FreeMotion: {self.count} {noun} of {len(self._displacements)} nodes; {does}"
        return text_table(title, ["joint", "motion", *DISPLACEMENTS], rows) if rows else title

    def displacement(self, node: str) -> Array:
        """Displacement and rotation of a node in each motion, in global axes.

        Parameters
        ----------
        node
            Name of the node.

        Returns
        -------
        ndarray
            ``ux uy uz rx ry rz``, (count, 6), scaled so that the largest displacement of the motion is one.

        Raises
        ------
        FrameError
            If the node is unknown.
        """
        if node not in self._displacements:
            raise FrameError(f"node {node!r} is unknown: known are {', '.join(self._displacements)}")
        return self._displacements[node]


def free_motion(plan: Plan, entry: tuple[int, ...], *, solvable: bool) -> FreeMotion:
    """Free motions at a batch entry; `solvable` tells whether its loads are in equilibrium."""
    state = _state(plan, entry)
    shapes = _shapes(plan, state)
    none: list[Real | None] = [None] * len(state.kinematics.links)
    coordinates = state.kinematics.coordinates(state.unknowns, extended(shapes), none)
    residual = state.residual
    drive = np.sum(coordinates * residual, axis=(-1, -2))
    shapes = _driven(shapes, drive)
    coordinates = state.kinematics.coordinates(state.unknowns, extended(shapes), none)
    moved = state.kinematics.displacements(coordinates)
    size = np.array([1.0, 1.0, 1.0] + 3 * [length_scale(plan, entry)])
    if len(shapes):
        largest = np.abs(moved * size).max(axis=(-1, -2), keepdims=True)
        coordinates, moved = coordinates / largest, moved / largest
    relative_displacements = state.kinematics.relative_displacements(coordinates, moved)
    joints = {
        link.edge.name: np.broadcast_to(link.whole(relative_displacement), (len(shapes), 6)).astype(np.float64)
        for link, relative_displacement in zip(state.kinematics.links, relative_displacements, strict=True)
        if link.edge.kind == "joint" and link.edge.name is not None
    }
    number, forces, frame = plan.topology.number, state.loads.forces, plan.frame
    loaded = {node: forces[..., number[node], :] for node in frame.nodes if np.any(forces[..., number[node], :])}
    drive = np.sum(coordinates * residual, axis=(-1, -2))
    return FreeMotion(
        count=len(shapes),
        joints=joints,
        work={node: np.sum(moved[..., number[node], :] * f, axis=-1).astype(np.float64) for node, f in loaded.items()},
        drive=drive.astype(np.float64),
        solvable=solvable,
        _displacements={
            name: moved[..., number[node], :].astype(np.float64)
            for name, node in ({node: node for node in frame.nodes} | frame.aliases).items()
        },
    )


def _state(plan: Plan, entry: tuple[int, ...]) -> EquilibriumResidual:
    """The equilibrium equations of the entry in the undeformed shape, under its loads."""
    index = tuple(np.array([k]) for k in entry) or None
    state = ill_conditioned_state(Statics(plan), index, plan.unknowns)

    def only(array: Real, trailing: int) -> Real:
        return state.change(array, trailing).reshape(array.shape[array.ndim - trailing :])

    return EquilibriumResidual(state.statics, only, plan.unknowns, extended(np.zeros(len(plan.unknowns))), 0)


def _shapes(plan: Plan, state: EquilibriumResidual) -> Array:
    """Values of the unknowns in each free motion, (count, n), by singular value decomposition of the deformations."""
    if plan.large and len(plan.unknowns) > MOST:
        return SparseSolver(plan).motions().T
    found = DenseCompliance(state.double, state.double_springs, state.stiffness, plan.unknowns)
    _, values, rows = np.linalg.svd(found.scaled)
    rank = int(np.sum(values > ZERO * np.sqrt(len(plan.unknowns))))
    shapes: Array = rows[rank:] * found.root
    return shapes


def _driven(shapes: Array, drive: Real) -> Array:
    """The motions rotated among themselves so that all work is done on the first, and is positive."""
    weights = drive.astype(np.float64)
    size = np.hypot.reduce(weights)
    if not size > 0.0:
        return shapes
    turn, _ = np.linalg.qr(np.column_stack([weights / size, np.eye(len(weights))]))
    turn = turn[:, : len(weights)]
    turn[:, 0] *= np.sign(turn[:, 0] @ weights)
    rotated: Array = turn.T @ shapes
    return rotated
