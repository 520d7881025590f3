"""What can be asked of a solution, as linear functions of its displacements: their values, and what does work on them.

A displacement is asked for by a unit force; the force in a spring by a unit opening of it, which is the force k on what
it joins; the force that holds an ideal component by a unit opening of that component (Müller-Breslau's principle).
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import FrameError
from ..structure.tree import ABOUT, ALONG
from .kinematics import Link, Real, extended, sheared

if TYPE_CHECKING:
    from .equilibrium import Equilibrium

KINDS = ("displacement", "reaction", "joint_displacement", "joint_force", "end_forces")


@dataclass
class Asked:
    """Results of one name, m of them.

    Attributes
    ----------
    value
        From the displacements, in extended precision, (..., m); without what holds ideal components.
    doubt
        What rounding of the stiffness leaves undetermined in `value` itself, (..., m).
    forces
        On the nodes (m, ..., nodes, 6), that do work equal to the result.
    pulls
        The same on the openings of links: by number of the link (m, ..., 6).
    imposed
        Unit openings: by number of the link (m, 6).
    """

    value: Real
    doubt: Real
    forces: Real | None = None
    pulls: dict[int, Real] = field(default_factory=dict)
    imposed: dict[int, Real] = field(default_factory=dict)


def checked(kind: str) -> str:
    """A kind of result that is known.

    Raises
    ------
    FrameError
        Where it is not.
    """
    if kind not in KINDS:
        raise FrameError(f"results {kind!r} are unknown: use one of {', '.join(KINDS)}")
    return kind


def asked(state: Equilibrium, name: str, kind: str) -> Asked:
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
    return _opening(state, index) if kind == "joint_displacement" else _force(state, index, kind == "reaction")


def _link(state: Equilibrium, name: str, kind: str) -> int:
    links = state.kinematics.links
    return next(k for k, link in enumerate(links) if link.edge.kind == kind and link.edge.name == name)


def _displacement(state: Equilibrium, name: str) -> Asked:
    node = state.plan.topology.number[name]
    forces = np.zeros((6, *(1,) * state.ndim, state.kinematics.count, 6))
    forces.reshape(6, -1, 6)[:, node] = np.eye(6)
    return Asked(state.displacements[..., node, :], state.fine * state.sizes[..., node, :], forces)


def _opening(state: Equilibrium, index: int) -> Asked:
    unit, link = np.eye(6).reshape(6, *(1,) * state.ndim, 6), state.kinematics.links[index]
    doubt = state.fine * link.spread(state.opening_sizes[index])
    return Asked(link.whole(state.openings[index]), doubt, pulls={index: link.worked(unit)})


def _force(state: Equilibrium, index: int, reaction: bool) -> Asked:
    sign = -1.0 if reaction else 1.0
    link: Link = state.kinematics.links[index]
    held = np.isin(np.arange(6), link.edge.ideal)
    unit = np.eye(6).reshape(6, *(1,) * state.ndim, 6)
    pulls = sign * unit * state.stiffness[index]
    opened = sign * np.where(held, np.eye(6), 0.0)
    imposed = opened.reshape(6, *(1,) * state.ndim, 6)
    doubt = state.fine * state.stiffness[index] * state.opening_sizes[index]
    value = sign * state.pulls[index]
    if link.lead is not None:
        value, doubt = link.exerted(value), sheared(doubt, ABOUT, ALONG, np.abs(link.lead))
        pulls, imposed = _exerted(link, pulls), _exerted(link, imposed)
    return Asked(value, doubt, pulls={index: pulls}, imposed={index: imposed})


def _exerted(link: Link, forces: Any) -> Any:
    """Force and moment of a screw, by what they come of (6, ..., 6), from the forces on its coordinates."""
    lead = np.asarray(link.lead)[..., None]
    shape = np.broadcast_shapes(forces.shape, (1, *lead.shape))
    out = extended(np.broadcast_to(forces, shape)).copy()
    out[ABOUT] -= lead * out[ALONG]
    return out


def _end_forces(state: Equilibrium, name: str) -> Asked:
    pieces = state.plan.topology.pieces_of[name]
    parts = [(pieces[0], slice(0, 6)), (pieces[-1], slice(6, 12))]
    values, doubts, forces = [], [], []
    for piece, end in parts:
        group, at = state.place(piece)
        springs = state.springs[group]
        rows = springs.local_rows[..., at, :, :]
        pull = state.member_pulls[group][..., at, :]
        loads, sizes = state.loads.ends(piece)
        values.append((np.einsum("...ij,...i->...j", rows, pull) - loads)[..., end])
        roundings = springs.roundings * state.rounding
        doubt = roundings * np.einsum("...ij,...i->...j", np.abs(rows), np.abs(pull)) + sizes
        doubts.append(
            (doubt + state.fine * np.einsum("...ij,...i->...j", np.abs(rows), state.pull_sizes(group, at)))[..., end]
        )
        acting = (springs.stiffness[..., at, :, None] * rows)[..., end]
        shape = np.broadcast_shapes(acting.shape[:-2], (1,) * state.ndim)
        pulls: Any = extended(np.zeros((*shape, 6, *springs.stiffness.shape[-2:])))
        pulls[..., at, :] = np.swapaxes(acting, -1, -2)
        pulls = np.moveaxis(pulls, -3, 0)
        forces.append(springs.forces(pulls, state.kinematics.count))
    return Asked(np.concatenate(values, axis=-1), np.concatenate(doubts, axis=-1), np.concatenate(_alike(forces)))


def _alike(arrays: list[Any]) -> list[Any]:
    shape = np.broadcast_shapes(*(array.shape[1:] for array in arrays))
    return [np.broadcast_to(array, (len(array), *shape)) for array in arrays]
