"""Derivatives of a result by coordinates of nodes, rotations of bodies and sizes of sections, from its adjoint.

With u the displacements and z those of the adjoint, the derivative of the result is that of ``z . (f - K u)`` with both
kept: a sum over the members, each evaluated at neighbouring shapes (differences of sixth order, whose error is hardly
more than rounding). Rigid links rotate with their arms and transfer their forces. No further solve is needed
(Choi & Kim, *Structural Sensitivity Analysis and Optimization 1*, 2005, ch. 2; semi-analytical method).
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterator
from dataclasses import dataclass, fields, is_dataclass, replace
from typing import Any

import numpy as np

from ..batch import Array, aligned, rotated
from ..batched.plan import Plan
from ..composed import OfAnother
from ..errors import FrameError
from ..protocol import LineElement
from ..structure.member_loads import applied_stacks, equivalent, strain_forces, weight_forces
from ..structure.topology import Group, Piece
from .adjoint import Adjoint
from .equilibrium import Statics
from .kinematic_edge import KinematicEdge
from .link_forces import working_forces

# Relative step of the differences, and their weights over one, two and three steps.
STEP = 1e-3
WEIGHTS = ((1.0, 0.75), (2.0, -0.15), (3.0, 1.0 / 60.0))
# Sections of a beam, and what goes before the names of their sizes.
_SECTIONS = {"section": "", "end": "end."}


@dataclass(frozen=True, eq=False)
class MemberWork:
    """Displacements of the solution and of the adjoint, and the forces in rigid links, for the whole batch.

    Attributes
    ----------
    moved, adjoint
        Displacements of the nodes, global, (..., nodes, 6).
    arms
        Rigid links of the tree, by their number among the edges.
    forces, adjoint_forces
        By that number: force conjugate to its relative displacement, (..., 6), under the loads and under those of the
        adjoint.
    """

    moved: Array
    adjoint: Array
    arms: dict[int, KinematicEdge]
    forces: dict[int, Array]
    adjoint_forces: dict[int, Array]

    @classmethod
    def empty(cls, statics: Statics, shape: tuple[int, ...]) -> MemberWork:
        """Zeros for a batch of `shape`, to be filled part by part with `enter`."""
        edges = enumerate(statics.kinematics.links)
        arms = {k: link for k, link in edges if link.arm is not None and link.sign != 0.0}
        moved, adjoint = (np.zeros((*shape, statics.kinematics.count, 6)) for _ in range(2))
        forces, others = ({k: np.zeros((*shape, 6)) for k in arms} for _ in range(2))
        return cls(moved, adjoint, arms, forces, others)

    def enter(self, where: Any, adjoint: Adjoint, index: int, constrained: list[Array]) -> None:
        """Fill in a part of the batch, for result `index` of an adjoint, with its `Adjoint.constrained` forces."""
        state = adjoint.state
        found = working_forces(state) if self.arms else []
        self.moved[where] = state.displacements
        self.adjoint[where] = adjoint.displacements[index]
        for k in self.arms:
            self.forces[k][where] = found[k]
            self.adjoint_forces[k][where] = constrained[k]


def by_coordinates(plan: Plan, work: MemberWork) -> dict[str, Array]:
    """Derivatives by the coordinates of each node, (..., 3); for a node on a body, in the body's axes.

    Raises
    ------
    FrameError
        If a member has a preload, or rigid links close loops.
    """
    frame, topology = plan.frame, plan.topology
    _check(plan)
    out = {name: np.zeros((*work.moved.shape[:-2], 3)) for name in frame.nodes}
    names = list(topology.number)

    def add(name: str, value: Array, body: Any) -> None:
        own = frame.nodes[name].body
        if own is not None and body is None:
            value = rotated(np.swapaxes(aligned(frame.bodies[own].axes, value.ndim - 1, 2), -1, -2), value)
        out[name] = out[name] + value

    for group in topology.groups:
        slope = np.stack([_difference(plan, group, work, _shifted(group, k)) for k in range(3)], axis=-1)
        for at, piece in enumerate(group.pieces):
            member = frame.members[topology.pieces[piece].member]
            for name, sign in ((member.end, 1.0), (member.start, -1.0)):
                add(name, sign * slope[at], group.body)
    for link, slope in _by_arms(work):
        for node, sign in ((link.child, 1.0), (link.parent, -1.0)):
            add(names[node], sign * slope, None)
    return out


def _by_arms(work: MemberWork) -> Iterator[tuple[KinematicEdge, Array]]:
    """Rigid links, and derivatives by a shift of the node that each carries, global, (..., 3)."""
    for k, link in work.arms.items():
        forces = (link.sign * link.out(each[k]) for each in (work.forces, work.adjoint_forces))
        pulled = [np.asarray(force, np.float64)[..., :3] for force in forces]
        turns = [each[..., link.parent, 3:] for each in (work.adjoint, work.moved)]
        yield link, np.cross(pulled[0], turns[0]) + np.cross(pulled[1], turns[1])


def by_rotations(plan: Plan, work: MemberWork) -> dict[str, Array]:
    """Derivatives by a small rotation of each body with its members and rigid links about its origin, (..., 3).

    The rotation vector is in global axes; loads and the axes of joints stay as they are.
    """
    frame, topology = plan.frame, plan.topology
    _check(plan)
    out = {name: np.zeros((*work.moved.shape[:-2], 3)) for name in frame.bodies}
    nodes = list(frame.nodes.values())
    for group in topology.groups:
        if group.body is None:
            continue
        slope = np.stack([_difference(plan, group, work, _rotated(group, k)) for k in range(3)], axis=-1)
        for at, piece in enumerate(group.pieces):
            body = frame.nodes[frame.members[topology.pieces[piece].member].start].body
            assert body is not None
            out[body] = out[body] + slope[at]
    for link, slope in _by_arms(work):
        body = nodes[link.child].body
        if body is not None and link.arm is not None:
            out[body] = out[body] + np.cross(np.asarray(link.sign * link.arm, np.float64), slope)
    return out


def by_sizes(plan: Plan, work: MemberWork) -> dict[str, dict[str, Array]]:
    """By member whose element has a section: derivatives by each of its sizes, (...); of the far end as ``end.y``."""
    topology = plan.topology
    out: dict[str, dict[str, Array]] = {}
    for group in topology.groups:
        for pieces, name, size, change in _sizes(plan, group):
            slope = _difference(plan, pieces, work, change) / np.asarray(size, np.float64)
            for at, piece in enumerate(pieces.pieces):
                of = out.setdefault(topology.pieces[piece].member, {})
                of[name] = of.get(name, 0.0) + slope[at]
    return out


Change = Callable[[float], Group]
Larger = Callable[[float], LineElement]


def _shifted(group: Group, component: int) -> Change:
    """Change of a group: its chords are longer along one axis by a fraction of their length."""
    length = np.linalg.norm(group.chord, axis=-1)[..., None]
    element = group.element

    def change(step: float) -> Group:
        chord = group.chord + step * length * np.eye(3)[component]
        if not isinstance(element, OfAnother):
            return group.between(chord)
        return group.between(chord, element.of_length(np.linalg.norm(chord, axis=-1)))

    return change


def _rotated(group: Group, component: int) -> Change:
    """Change of a group: its body is rotated about a global axis."""

    def change(step: float) -> Group:
        assert group.body is not None
        y, z = (component + 1) % 3, (component + 2) % 3
        turn = np.eye(3)
        turn[y, y] = turn[z, z] = np.cos(step)
        turn[z, y], turn[y, z] = np.sin(step), -np.sin(step)
        return replace(group, body=turn @ group.body)

    return change


def _sizes(plan: Plan, group: Group) -> Iterator[tuple[Group, str, Any, Change]]:
    """Pieces of a group, a size of their members' sections by name, and the pieces with it larger by a share."""
    pieces = [plan.topology.pieces[piece] for piece in group.pieces]
    wholes = [plan.frame.members[piece.member].element for piece in pieces]
    if all(piece.count == 1 or _uniform(whole) for piece, whole in zip(pieces, wholes, strict=True)):
        for name, size, larger in _larger(group.element):
            yield group, name, size, _made_larger(group, larger)
        return
    # the pieces of a taper have their shares of the sizes of its member: alike where they lie alike in one element
    alike: dict[tuple[Hashable, int, int], list[int]] = {}
    for at, (piece, whole) in enumerate(zip(pieces, wholes, strict=True)):
        alike.setdefault((whole.kind, piece.index, piece.count), []).append(at)
    for same in alike.values():
        some = group.part(np.array(same))
        for name, size, larger in _larger(wholes[same[0]]):
            yield some, name, size, _made_larger(some, larger, pieces[same[0]])


def _made_larger(group: Group, larger: Larger, piece: Piece | None = None) -> Change:
    """A group whose element is larger by a share, or of that the part that a `piece` is."""

    def change(step: float) -> Group:
        element = larger(step)
        return replace(group, element=element if piece is None else element.part(piece.index, piece.count))

    return change


def _uniform(element: LineElement) -> bool:
    """Whether the parts of an element have its own section."""
    whole, part = (each.innermost if isinstance(each, OfAnother) else each for each in (element, element.part(0, 2)))
    return all(getattr(whole, field, None) is getattr(part, field, None) for field in _SECTIONS)


def _larger(whole: LineElement) -> Iterator[tuple[str, Any, Larger]]:
    """Sizes of an element's sections by name, and the element with one of them larger by a share."""
    element: Any = whole.innermost if isinstance(whole, OfAnother) else whole
    own = {each.name for each in fields(element)} if is_dataclass(element) else set()
    for field, prefix in _SECTIONS.items():
        section = getattr(element, field, None) if field in own else None
        if section is None or not hasattr(section, "sizes"):
            continue
        for name, size in section.sizes().items():

            def larger(step: float, field: str = field, name: str = name, section: Any = section) -> LineElement:
                other = replace(section, **{name: getattr(section, name) * (1.0 + step)})
                found: LineElement = _made_again(element, field, other)
                return whole.of_innermost(found) if isinstance(whole, OfAnother) else found

            yield prefix + name, size, larger


def _made_again(element: Any, field: str, section: Any) -> Any:
    """The element with another section."""
    try:
        return replace(element, **{field: section})
    except TypeError as error:
        kind = type(element).__name__
        raise FrameError(
            f"sensitivity to sections: {kind} cannot be made with another {field} ({error}): let it take the "
            f"parameters of a dataclass, its {field} among them, or ask for members, the derivatives by stiffnesses"
        ) from error


def _difference(plan: Plan, group: Group, work: MemberWork, change: Change) -> Array:
    """Derivative of the work of a group's pieces by the fraction of a change, (n, ...)."""
    total: Any = 0.0
    for steps, weight in WEIGHTS:
        ahead, behind = (_work(plan, change(sign * steps * STEP), work) for sign in (1.0, -1.0))
        total = total + weight / STEP * (ahead - behind)
    length = np.linalg.norm(group.chord, axis=-1)
    found = np.asarray(total, dtype=np.float64)
    return found / length if change(STEP).chord is not group.chord else found


def _work(plan: Plan, group: Group, work: MemberWork) -> Array:
    """Work ``z . (f - K u)`` of the pieces of a group, (n, ...)."""
    u, z = (_local(group, displacements) for displacements in (work.moved, work.adjoint))
    stiffness, rows = group.element.springs(group.length)
    strained, worked = ((rows @ each[..., None])[..., 0] for each in (u, z))
    return np.asarray(np.sum(z * _loads(plan, group), axis=-1) - np.sum(stiffness * strained * worked, axis=-1))


def _local(group: Group, displacements: Array) -> Array:
    """Displacements of both ends (n, ..., 12) in the local axes of the pieces."""
    ends = np.moveaxis(displacements[..., group.nodes, :], -3, 0)
    return rotated(group.local_axes, ends.reshape(*ends.shape[:-2], 12))


def _loads(plan: Plan, group: Group) -> Array:
    """Equivalent forces on both ends of the pieces, (n, ..., 12), local."""
    every = np.arange(len(group.pieces))
    out = equivalent(group, every, weight_forces(plan.topology, group, every)) + strain_forces(group, every)
    for at, forces in applied_stacks(plan.topology, group):
        own = equivalent(group, at, forces)
        out = np.array(np.broadcast_to(out, (len(every), *np.broadcast_shapes(out.shape[1:], own.shape[1:]))))
        out[at] += own
    return out


def _check(plan: Plan) -> None:
    for name, member in plan.frame.members.items():
        if np.any(member.element.tension):
            raise FrameError(
                f"sensitivity to nodes: member {name!r} has a force at rest, which turns with it: load its ends instead"
            )
    if plan.tree.elimination.rows and any(edge.kind == "rigid" for edge, _ in plan.tree.closing):
        raise FrameError("sensitivity to nodes: rigid links close a loop: leave out one of them")
