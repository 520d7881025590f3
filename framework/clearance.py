"""Equilibrium of a frame whose joints have clearance: where each journal rests in its bearing.

A joint of stiffness k and clearance ε holds the energy ``W(δ) = min over |o| ≤ ε of k/2 |δ − o|²``: it is the joint
without clearance, its springs about an offset o that lies where the energy of the whole frame is least,

    minimise  ½ o·S o − f·o   subject to |o_j| ≤ ε_j in each joint,

with f the forces in the joints of the frame without clearance and S their fall for a unit offset in each. So the frame
is solved once under its loads and once for the unit offsets, whatever it holds, k = inf included; what is left is a
problem of two or three numbers a joint, see `balls`. Where joint forces follow from equilibrium alone, S vanishes and
the journals lie along them, ``o = ε f/|f|``: the extreme point of what the linkage can reach in the load's direction.
"""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from .batch import Array, aligned, turned
from .contact import CLOSED, MECHANISM, UNRESOLVED, Contact
from .dofs import DISPLACEMENTS
from .errors import MechanismWarning
from .frame import Frame
from .parts import total
from .plan import Plan
from .resting import Play, Rest
from .stage import collapsed

if TYPE_CHECKING:
    from .solution import Solution

# A stiffness against offsets below this share of the members' is the rounding of none.
_LOOSE = 1e-13


def loose_joints(frame: Frame) -> list[str]:
    """Names of the joints with clearance."""
    return [name for name, joint in frame.joints.items() if joint.element.clearance.any()]


def contacts(frame: Frame, tight: Solution) -> dict[str, Contact]:
    """Contacts at equilibrium of a frame with clearances.

    Parameters
    ----------
    frame
        The frame.
    tight
        Its solution without clearances.
    """
    play = _play(frame)
    with warnings.catch_warnings():
        # Entries that are mechanisms have no contact, which their state tells.
        warnings.simplefilter("ignore", MechanismWarning)
        force = np.stack([tight.joint_force(name)[..., k] for name, k in play.pairs])
        stiffness, members = _against_offsets(frame, play)
    radius = np.stack([np.broadcast_to(frame.joints[name].element.clearance, frame.shape) for name in play.names])
    rest = Rest(play, stiffness, members, np.nan_to_num(force), radius, _load(tight.plan))
    state = np.where(np.isnan(force).any(axis=0), MECHANISM, rest.state)
    return {name: _contact(frame, rest, j, np.asarray(state[j])) for j, name in enumerate(play.names)}


def _play(frame: Frame) -> Play:
    names = loose_joints(frame)
    play = [frame.joints[name].element.play for name in names]
    return Play(names, np.repeat(np.arange(len(names)), [len(p) for p in play]), [k for p in play for k in p])


def offsets(frame: Frame, found: dict[str, Contact]) -> Frame:
    """The frame with each journal where it rests, as offsets of its joints."""
    out = frame.copy()
    for name, contact in found.items():
        for k in frame.joints[name].element.play:
            own = frame.offsets.get(name, {}).get(k, np.zeros(()))
            out.offset(name, **{DISPLACEMENTS[k]: own + contact.offset[..., k % 3]})
    return out


def _against_offsets(frame: Frame, play: Play) -> tuple[Array, Array]:
    """Fall of the force in each component for a unit offset in each, (n, n, ...), and the members' stiffness, (n, ...).

    What is no more than the rounding of the members' stiffness is set to zero.
    """
    from .solution import Solution

    bare, count = _bare(frame), len(play.pairs)
    unit = np.eye(count).reshape(count, count, *(1,) * len(bare.shape))
    for index, (name, k) in enumerate(play.pairs):
        bare.offset(name, **{DISPLACEMENTS[k]: unit[index]})
    solution = Solution.of(bare)
    found = -np.stack([solution.joint_force(name)[..., k] for name, k in play.pairs])
    found = np.nan_to_num(0.5 * (found + np.swapaxes(found, 0, 1)))
    members = _members(solution.plan, play)
    root = np.sqrt(members)
    return np.where(np.abs(found) > _LOOSE * root[:, None] * root, found, 0.0), members


def _bare(frame: Frame) -> Frame:
    """The frame without loads, offsets and displacements of supports."""
    out = Frame()
    for name, body in frame.bodies.items():
        out.body(name, body.origin, body.axes)
    for name, node in frame.nodes.items():
        out.node(name, node.coordinates, node.body)
    for name, member in frame.members.items():
        out.add(name, member.element, member.start, member.end)
    for name, joint in frame.joints.items():
        out.add(name, joint.element, joint.first, joint.second)
    out.ties = list(frame.ties)
    for name, held in frame.supports.items():
        out.fix(name, *(DISPLACEMENTS[k] for k in held))
    return out


def _members(plan: Plan, play: Play) -> Array:
    """Largest stiffness of a member's end, against translation or rotation, by component, (n, ...)."""
    largest = [np.zeros((1,) * len(plan.grid.shape)), np.zeros((1,) * len(plan.grid.shape))]
    for a, row in plan.matrix.items():
        value = np.asarray(total(row.get(a, {}))[1], dtype=np.float64)
        largest[a % 6 // 3] = np.maximum(largest[a % 6 // 3], value)
    return np.stack([largest[k // 3][0] for k in play.component])


def _load(plan: Plan) -> Array:
    """Largest load on a node, moments as forces at the size of the frame, (...)."""
    out: Array = np.zeros(plan.frame.shape)
    for a, by_source in plan.forces.items():
        value = np.abs(np.asarray(collapsed(by_source, plan.knowns.values), dtype=np.float64))
        out = np.maximum(out, value / (plan.frame.size if a % 6 >= 3 else 1.0))
    return out


def _contact(frame: Frame, rest: Rest, j: int, state: NDArray[np.str_]) -> Contact:
    """The contact of one joint, its normal turned into global axes."""
    name, closed = rest.play.names[j], np.asarray(state == CLOSED)
    element = frame.joints[name].element
    offset, pull = np.zeros((2, *frame.shape, 3))
    for index in np.flatnonzero(rest.play.own == j):
        offset[..., rest.play.component[index] % 3] = rest.offset[index]
        pull[..., rest.play.component[index] % 3] = rest.force[index]
    along = np.where((rest.radius[j] > 0.0)[..., None], offset, pull)
    length = np.linalg.norm(along, axis=-1)
    normal = along / np.where(closed, length, 1.0)[..., None]
    normal = normal if element.axes is None else turned(aligned(element.axes, len(frame.shape), 2), normal)
    gap = np.where(closed, 0.0, rest.radius[j] - np.linalg.norm(offset, axis=-1))
    unknown = np.where((state == MECHANISM) | (state == UNRESOLVED), np.nan, 0.0)
    return Contact(
        name,
        state,
        np.where(closed[..., None], normal, unknown[..., None]),
        np.where(closed, rest.size[j], unknown),
        gap + unknown,
        offset,
    )
