"""Requested results as linear functions of the displacements: their values, and the unit loads whose work equals them.

For a displacement that is a unit force; for the force in a spring, a unit relative displacement of it, which means
forces k on the nodes it joins; for a constraint force, a unit relative displacement of its ideal component
(Müller-Breslau's principle).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..dofs import DISPLACEMENTS, FORCES, component
from ..errors import FrameError
from ..structure.edge import ABOUT, ALONG
from .deformations import on_nodes
from .equilibrium import EquilibriumResidual
from .kinematic_edge import KinematicEdge, Real, extended, sheared
from .link_forces import working_forces

KINDS = ("displacement", "reaction", "joint_displacement", "joint_force", "end_forces")


@dataclass
class RequestedResults:
    """The m results of one kind at a node, joint or member.

    Attributes
    ----------
    value
        Values from the displacements, in extended precision, (..., m); without constraint forces of ideal components.
    error_bound
        Bound on the error of `value` at the given displacements by rounding of the stiffness, (..., m).
    forces
        Forces on the nodes (m, ..., nodes, 6), whose work equals the result.
    generalised_forces
        The same on the relative displacements of links: by number of the link (m, ..., 6).
    imposed
        Unit relative displacements: by number of the link (m, 6).
    sizes
        Sizes of `forces`, (m, ..., nodes, 6); None if they are no sums.
    unresolved
        Bound on the error of the result by rounding of the stiffness in a motion of unit energy norm, (..., m).
    """

    value: Real
    error_bound: Real
    forces: Real | None = None
    generalised_forces: dict[int, Real] = field(default_factory=dict)
    imposed: dict[int, Real] = field(default_factory=dict)
    sizes: Real | None = None
    unresolved: Real | float = 0.0

    def only(self, indices: Sequence[int] | None) -> RequestedResults:
        """Some of the results.

        Parameters
        ----------
        indices
            Their numbers; all of them where None.
        """
        if indices is None:
            return self
        some = list(indices)
        return RequestedResults(
            self.value[..., some],
            self.error_bound[..., some],
            None if self.forces is None else self.forces[some],
            {k: each[some] for k, each in self.generalised_forces.items()},
            {k: each[some] for k, each in self.imposed.items()},
            None if self.sizes is None else self.sizes[some],
            self.unresolved[..., some] if isinstance(self.unresolved, np.ndarray) else self.unresolved,
        )


def checked(kind: str) -> str:
    """The kind of result, if it is known.

    Raises
    ------
    FrameError
        Where it is not.
    """
    if kind not in KINDS:
        raise FrameError(f"results {kind!r} are unknown: use one of {', '.join(KINDS)}")
    return kind


def numbered(kind: str, components: Sequence[str]) -> tuple[int, ...]:
    """Numbers of components of a kind of result.

    Raises
    ------
    FrameError
        Where one is unknown, or the results are end forces, of which there are twelve.
    """
    if checked(kind) == "end_forces":
        raise FrameError("components of end forces: leave them out, or ask for those of a reaction or joint force")
    names = FORCES if kind in ("reaction", "joint_force") else DISPLACEMENTS
    return tuple(component(name, names) for name in components)


def requested(state: EquilibriumResidual, name: str, kind: str) -> RequestedResults:
    """The results of a kind at a node, joint or member.

    Parameters
    ----------
    state
        Solution of a frame in extended precision.
    name
        Node, joint or member.
    kind
        One of `KINDS`.
    """
    if kind == "displacement":
        return _displacement(state, name)
    if kind == "end_forces":
        return _end_forces(state, name)
    index = _link(state, name, "support" if kind == "reaction" else "joint")
    return (
        _relative_displacement(state, index)
        if kind == "joint_displacement"
        else _force(state, index, kind == "reaction")
    )


def _link(state: EquilibriumResidual, name: str, kind: str) -> int:
    links = state.kinematics.links
    return next(k for k, link in enumerate(links) if link.edge.kind == kind and link.edge.name == name)


def _displacement(state: EquilibriumResidual, name: str) -> RequestedResults:
    node = state.plan.topology.number[name]
    forces = np.zeros((6, *(1,) * state.ndim, state.kinematics.count, 6))
    forces.reshape(6, -1, 6)[:, node] = np.eye(6)
    return RequestedResults(state.displacements[..., node, :], state.fine * state.sizes[..., node, :], forces)


def _relative_displacement(state: EquilibriumResidual, index: int) -> RequestedResults:
    unit, link = np.eye(6).reshape(6, *(1,) * state.ndim, 6), state.kinematics.links[index]
    error_bound = state.fine * link.spread(state.displacement_sizes[index])
    return RequestedResults(
        link.whole(state.relative_displacements[index]), error_bound, generalised_forces={index: link.worked(unit)}
    )


def _force(state: EquilibriumResidual, index: int, reaction: bool) -> RequestedResults:
    sign = -1.0 if reaction else 1.0
    link: KinematicEdge = state.kinematics.links[index]
    constrained = np.isin(np.arange(6), link.edge.ideal)
    unit = np.eye(6).reshape(6, *(1,) * state.ndim, 6)
    generalised_forces = sign * unit * state.stiffness[index]
    opened = sign * np.where(constrained, np.eye(6), 0.0)
    error_bound = state.fine * state.stiffness[index] * state.displacement_sizes[index]
    value = sign * state.generalised_forces[index]
    imposed = {index: opened.reshape(6, *(1,) * state.ndim, 6)}
    for load_share in (each for each in state.load_shares if index in each.place):
        for k, more in load_share.relative_displacements(index):
            imposed[k] = imposed.get(k, 0.0) + sign * more
        forces = dict(enumerate(working_forces(state)))
        made = np.abs(forces[index]) + load_share.sizes(index, forces)
        error_bound = error_bound + np.where(constrained, load_share.rounding[..., None] * made, 0.0)
    if link.lead is not None:
        value, error_bound = link.exerted(value), sheared(error_bound, ABOUT, ALONG, np.abs(link.lead))
        generalised_forces = _exerted(link, generalised_forces)
        imposed = {k: _exerted(link, each) for k, each in imposed.items()}
    return RequestedResults(value, error_bound, generalised_forces={index: generalised_forces}, imposed=imposed)


def _exerted(link: KinematicEdge, forces: Any) -> Any:
    """Force and moment (6, ..., 6) of a screw, from the forces on its coordinates."""
    lead = np.asarray(link.lead)[..., None]
    shape = np.broadcast_shapes(forces.shape, (1, *lead.shape))
    out = extended(np.broadcast_to(forces, shape)).copy()
    out[ABOUT] -= lead * out[ALONG]
    return out


def _end_forces(state: EquilibriumResidual, name: str) -> RequestedResults:
    pieces = state.plan.topology.pieces_of[name]
    ends = [_end(state, pieces[0], slice(0, 6)), _end(state, pieces[-1], slice(6, 12))]
    values, error_bounds, unresolved = (
        [getattr(end, each) for end in ends] for each in ("value", "error_bound", "unresolved")
    )
    forces, sizes = ([getattr(end, each) for end in ends] for each in ("forces", "sizes"))
    return RequestedResults(
        np.concatenate(values, axis=-1),
        np.concatenate(error_bounds, axis=-1),
        np.concatenate(_alike(forces)),
        sizes=np.concatenate(_alike(sizes)),
        unresolved=np.concatenate(np.broadcast_arrays(*unresolved), axis=-1),
    )


def _end(state: EquilibriumResidual, piece: int, end: slice) -> RequestedResults:
    """Forces on one end of a piece: those of its springs times their rows, less the equivalent loads.

    ``R = a^T k e(u) - p`` with the rows a. Rounding of k and of the deformations e changes the spring forces, and by
    ``a^T`` the result; in a motion w of which only the energy norm is known, by at most that norm times
    ``|k^-1/2 dk a|``.
    """
    group, at = state.place(piece)
    springs, count = state.springs[group], state.kinematics.count
    rows = springs.local_rows[..., at, :, end]
    generalised_force = state.member_forces[group][..., at, :]
    loads, sizes = state.loads.ends(piece)
    value = np.einsum("...ij,...i->...j", rows, generalised_force) - loads[..., end]
    off = state.force_error_bounds[group][..., at, :] + state.fine * np.abs(generalised_force)
    error_bound = np.einsum("...ij,...i->...j", np.abs(rows), off) + sizes[..., end]
    acting = np.swapaxes(springs.stiffness[..., at, :, None] * rows, -1, -2)
    shape = np.broadcast_shapes(acting.shape[:-1], (1,) * (state.ndim + 1))
    generalised_forces, by = (extended(np.zeros((*shape, *springs.stiffness.shape[-2:]))) for _ in range(2))
    generalised_forces[..., at, :], by[..., at, :] = acting, np.swapaxes(rows, -1, -2)
    generalised_forces, by = np.moveaxis(generalised_forces, -3, 0), np.moveaxis(by, -3, 0)
    unresolved = np.sqrt(np.moveaxis(springs.work(springs.uncertain(by, state.rounding)), 0, -1))
    return RequestedResults(
        value,
        error_bound,
        on_nodes(np.zeros((count, 6)), [(springs, springs.forces(generalised_forces))]),
        sizes=on_nodes(np.zeros((count, 6)), [(springs, springs.spread_forces(np.abs(generalised_forces)))]),
        unresolved=unresolved,
    )


def _alike(arrays: list[Any]) -> list[Any]:
    shape = np.broadcast_shapes(*(array.shape[1:] for array in arrays))
    return [np.broadcast_to(array, (len(array), *shape)) for array in arrays]
