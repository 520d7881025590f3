"""The joint forces by unit offsets in the joints, which couple the clearances of a frame."""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..batch import Array, Shape
from ..composed import Unstrained
from ..description import Description
from ..dofs import DISPLACEMENTS
from ..entries import WHOLE, Change
from ..errors import FrameError
from ..joint_protocol import JointElement
from ..program.sweep import LONG
from ..protocol import LineElement
from ..structure.constraints import Contradiction
from ..structure.parts import total
from .contact_state import ClearanceComponents, sizes
from .unit_motions import Solvers, UnitMotions, UnitMotionsPerEntry

# A function that returns whether components carry a force at the entries, (n, ...).
Bearing = Callable[[], NDArray[np.bool_]]
# Decreases of forces, (n, n, ...), entries at which they are unknown, (...), and thresholds of rounding, (n, n, ...).
Answer = tuple[Array, NDArray[np.bool_], Array]

# A stiffness against offsets below _UNRESISTED times that of the members is rounding. Up to _DOUBTFUL times that it may
# be, if the unit offset moves nodes by many times as much, which is examined for up to _MOST numbers.
_UNRESISTED, _DOUBTFUL, _MOST = 1e-13, 1e5, 2**24
# Up to this many entries the stiffness of each entry costs no more than a common one.
_FEW = 1000


@dataclass(frozen=True)
class Resistance:
    """The resistance of a frame to offsets in its joints; batch axes over which nothing varies have size one.

    Attributes
    ----------
    stiffness
        Decrease of the force in each component per unit offset in each, (n, n, ...); zero where it is no more than the
        rounding of the members' stiffness.
    members
        Stiffness of the members, (n, ...).
    unknown
        Entries at which an offset moves a mechanism that the loads do not, so that the stiffness is unknown, (...).
    unfit
        Entries at which ideal joints close a loop of rigid links with which no offset is compatible, as for links in
        one line, (...).
    motions
        Solution for a unit offset in each component; None if some offsets move a mechanism.
    """

    stiffness: Array
    members: Array
    unknown: NDArray[np.bool_]
    unfit: NDArray[np.bool_]
    motions: UnitMotions | None


def against_offsets(
    frame: Description,
    components: ClearanceComponents,
    bearing: Bearing,
    lost: NDArray[np.bool_],
    solvers: Solvers,
    loaded: Sequence[int] | None,
) -> Resistance:
    """The resistance of a frame to offsets in its joints.

    Whether an offset causes any force depends on the geometry, not on the stiffness of what resists. So it is first
    found for a frame with the same stiffness for all entries; if offsets cause no force, that suffices.

    Parameters
    ----------
    frame
        The frame.
    components
        Components of its joints.
    bearing
        Function that returns which of them carry a force, (n, ...): only these count if others move a mechanism.
    lost
        Mask of the entries that need no result, (...).
    solvers
        Functions that return linear solutions of a description, without clearances.
    loaded
        DOF numbers of the loads on the frame; None if offsets are known to cause forces.

    Raises
    ------
    FrameError
        If at all entries ideal joints close a loop of rigid links with which no offset is compatible.
    """
    joints = {name: joint.element for name, joint in frame.joints.items()}
    members = {name: member.element for name, member in frame.members.items()}
    whole = len(frame.shape)
    if loaded is not None and math.prod(frame.shape) > _FEW and all(_alike(element) for element in joints.values()):
        bearings, alike = {name: each.typical() for name, each in joints.items()}, _typical_members(frame)
        if _entries(frame, bearings, alike) < _entries(frame, joints, members):
            found = _answer(_bare(frame, bearings, alike), whole, components, bearing, lost, solvers, loaded)
            varies = any(element.stiffness.size > 6 for element in joints.values())
            varies = varies or any(alike[name] is not element for name, element in members.items())
            if not (varies and found.stiffness.any()):
                return found
    return _answer(_bare(frame, joints, members), whole, components, bearing, lost, solvers, loaded)


def _entries(frame: Description, joints: Mapping[str, JointElement], members: Mapping[str, LineElement]) -> int:
    """Number of batch entries of the frame with the given joints and members, without loads."""
    places = (node.coordinates.shape[:-1] for node in frame.nodes.values())
    bodies = (shape for body in frame.bodies.values() for shape in (body.origin.shape[:-1], body.axes.shape[:-2]))
    shapes = [*(each.shape for each in joints.values()), *(each.shape for each in members.values())]
    return math.prod(np.broadcast_shapes(*places, *bodies, *shapes))


def resists_at_first_entry(frame: Description, components: ClearanceComponents, solvers: Solvers) -> bool:
    """Whether at the first batch entry alone offsets cause forces; False where that cannot be told."""
    joints = {name: joint.element.typical() for name, joint in frame.joints.items()}
    if any(each.shape for each in joints.values()):
        return False
    bare = _bare(frame, joints, _typical_members(frame), change=_first)
    if bare.shape:
        return False
    none = np.zeros((), dtype=bool)
    try:
        found = _answer(bare, 0, components, lambda: np.ones(len(components.pairs), dtype=bool), none, solvers, None)
    except FrameError:
        return False
    return bool(found.stiffness.any())


def _alike(element: JointElement) -> bool:
    """Whether each component is free at all batch entries or at none."""
    free = (element.stiffness == 0.0).reshape(-1, 6)
    return bool(np.all(free.all(axis=0) == free.any(axis=0)))


def _typical_members(frame: Description) -> dict[str, LineElement]:
    """The elements of members as they are at the first entry, where that says what they resist at all entries.

    That is so if they resist every deformation there, and what they resist does not depend on their own numbers.
    """
    members: dict[Hashable, list[str]] = {}
    for name, member in frame.members.items():
        members.setdefault(member.element.kind, []).append(name)
    out: dict[str, LineElement] = {}
    for names in members.values():
        element = frame.members[names[0]].element
        if element.shape and (element.deforms_as is not None or not element.has_springs):
            first = element.cut(_first)
            lengths = np.array([_first(frame.length(name), 0) for name in names])
            element = first if np.all(first.spring_stiffness(lengths) > 0.0) else element
        out |= dict.fromkeys(names, element)
    return {name: out[name] for name in frame.members}


def _first(array: NDArray[Any], trailing: int) -> NDArray[Any]:
    """An array (..., trailing) at the first batch entry, without batch axes."""
    return np.asarray(array[(0,) * (array.ndim - trailing)])


def _answer(
    bare: Description,
    whole: int,
    components: ClearanceComponents,
    bearing: Bearing,
    lost: NDArray[np.bool_],
    solvers: Solvers,
    loaded: Sequence[int] | None,
) -> Resistance:
    count = len(components.pairs)
    out = _everywhere(lost, bare.shape)
    if out.any():
        bare.exclude(out)
    motions, unfit = _fitting(bare, out, components, solvers, loaded)
    found = -motions.forces
    if out.any():
        found[..., out] = 0.0
    unknown = np.asarray(np.isnan(found).any(axis=(0, 1)))
    determinate = not unknown.any()
    members = _members(motions, components)
    root = np.sqrt(members)
    least = _UNRESISTED * root[:, None] * root
    size = np.abs(found)
    with np.errstate(invalid="ignore"):
        above = size > least
        doubtful = above.any() and bool((above & (size <= _DOUBTFUL * least)).any())
    if doubtful:
        moved = np.where(unknown | out, 1.0, _largest_motions(motions, components))
        least = least * moved[:, None] * moved
    if not determinate:
        borne = _alike_within(bearing(), lost, bare.shape)
        found, unknown, least = _of_loaded(bare, components, borne, (found, unknown, least), solvers)
    elif not above.any():
        found = np.zeros((count, count, *(1,) * (found.ndim - 2)))
    found = 0.5 * (found + np.swapaxes(found, 0, 1))
    found = found if determinate else np.nan_to_num(found)
    stiffness = np.where(np.abs(found) > least, found, 0.0)
    new = (1,) * (whole - unknown.ndim)
    return Resistance(
        stiffness.reshape(count, count, *new, *stiffness.shape[2:]),
        members.reshape(count, *(1,) * (whole + 1 - members.ndim), *members.shape[1:]),
        unknown,
        unfit,
        motions if determinate else None,
    )


def _fitting(
    bare: Description,
    out: NDArray[np.bool_],
    components: ClearanceComponents,
    solvers: Solvers,
    loaded: Sequence[int] | None,
) -> tuple[UnitMotions, NDArray[np.bool_]]:
    """The solution for unit offsets in each component, and entries with incompatible offsets, (...).

    The latter are left out of the bare frame from then on.
    """
    every = np.ones(len(components.pairs), dtype=bool)
    try:
        return _motions(bare.copy(), components, every, solvers, loaded), np.zeros_like(out)
    except Contradiction as error:
        unfit = np.asarray(np.broadcast_to(error.entries, (len(every), *bare.shape)).any(axis=0))
        if (unfit | out).all():
            raise FrameError(
                f"joints {', '.join(components.names)} have clearance, but ideal ones among them close a loop of rigid "
                f"links, in which no offset fits ({error}): give one of them a finite stiffness"
            ) from error
    bare.exclude(unfit)
    return _motions(bare.copy(), components, every, solvers, loaded), unfit


def _of_loaded(
    bare: Description, components: ClearanceComponents, bearing: NDArray[np.bool_], first: Answer, solvers: Solvers
) -> Answer:
    """The result where some offset moves a mechanism, from the components alone that carry a force there.

    Parameters
    ----------
    bare
        The frame without loads.
    components
        Components of its joints.
    bearing
        Whether they carry a force at each entry, (n, ...).
    first
        The result of all components, see `Answer`.
    solvers
        Functions that return linear solutions of a description.
    """
    found, unknown, least = first
    count, shape = len(bearing), bearing.shape[1:]
    new = (1,) * (len(shape) - unknown.ndim)
    found, least = (each.reshape(count, count, *new, *each.shape[2:]) for each in (found, least))
    unknown = unknown.reshape((*new, *unknown.shape))
    partly = unknown & ~bearing.all(axis=0)
    found = np.where(partly, 0.0, found) if partly.any() else found
    here = partly & bearing.any(axis=0)
    for pattern in np.unique(bearing[:, here], axis=1).T:
        own = here & (bearing == pattern.reshape(count, *(1,) * len(shape))).all(axis=0)
        some = bare.copy()
        some.exclude(_everywhere(~own, bare.shape))
        falls = -_motions(some, components, pattern, solvers).forces
        falls = falls.reshape(found.shape[:2] + new + bare.shape)
        apart = (pattern[:, None] & pattern).reshape(count, count, *(1,) * len(shape))
        coupled = np.abs(np.where(apart, 0.0, falls)) > least
        known = own & ~np.asarray(np.isnan(falls).any(axis=(0, 1)) | coupled.any(axis=(0, 1)))
        if known.any():
            found, unknown = np.where(known & apart, falls, found), unknown & ~known
    return found, unknown, least


def _alike_within(bearing: NDArray[np.bool_], lost: NDArray[np.bool_], shape: Shape) -> NDArray[np.bool_]:
    """Whether components carry a force, (n, ...): for a smaller batch of a `shape` if the answer is the same for all
    entries with results that belong to each of its entries.
    """
    axes = _shared_axes(lost, shape)
    along = tuple(axis + 1 for axis in axes)
    some = np.asarray((bearing & ~lost).any(axis=along, keepdims=True))
    every = np.asarray((bearing | lost).all(axis=along, keepdims=True))
    uniform = bool(((some == every) | lost.all(axis=axes, keepdims=True)).all())
    return some.reshape(len(bearing), *shape) if uniform else np.asarray(bearing & ~lost)


def _everywhere(lost: NDArray[np.bool_], shape: Shape) -> NDArray[np.bool_]:
    """Entries of a smaller batch of a `shape` for which all entries of the batch are `lost`."""
    found: NDArray[np.bool_] = np.asarray(lost.all(axis=_shared_axes(lost, shape), keepdims=True))
    return found.reshape(found.shape[lost.ndim - len(shape) :])


def _shared_axes(lost: NDArray[np.bool_], shape: Shape) -> tuple[int, ...]:
    """Batch axes of `lost` along which a batch of a `shape` does not vary."""
    extra = lost.ndim - len(shape)
    return tuple(axis for axis in range(lost.ndim) if axis < extra or shape[axis - extra] == 1)


def _largest_motions(motions: UnitMotions, components: ClearanceComponents) -> Array:
    """Largest displacement of a node by a unit offset in each component, (n, ...), at least one.

    The rounding of a force, recovered by a stiffness, is proportional to the displacements.
    """
    frame, is_rotation = motions.solution.frame, components.is_rotation
    shape = motions.forces.shape[1:]
    if 6 * len(frame.nodes) * math.prod(shape) > _MOST or not frame.size:
        return np.ones(shape)
    moved = np.abs(motions.nodal())
    length, angle = moved[..., :3].max(axis=(-1, -2)), moved[..., 3:].max(axis=(-1, -2))
    size = sizes(frame)
    arms = np.where(is_rotation.reshape(-1, *(1,) * (len(shape) - 1)), 1.0 / size, 1.0)
    out: Array = np.maximum(1.0, arms * np.maximum(length, angle * size))
    return out


def _motions(
    bare: Description,
    components: ClearanceComponents,
    asked: NDArray[np.bool_],
    solvers: Solvers,
    loaded: Sequence[int] | None = None,
) -> UnitMotions:
    """The solution for unit offsets in the components in the mask `asked`."""
    count = len(components.pairs)
    if solvers.per_unit is not None and math.prod(bare.shape) >= LONG and asked.all():
        with suppress(Contradiction):  # which is told of each offset alone
            found = UnitMotionsPerEntry.of(bare.copy(), components.pairs, solvers.per_unit, loaded)
            if found is not None:
                return found
    unit = np.eye(count).reshape(count, count, *(1,) * len(bare.shape))
    for index in np.flatnonzero(asked):
        name, k = components.pairs[index]
        bare.offset(name, **{DISPLACEMENTS[k]: unit[index]})
    one_by_one = UnitMotions(solvers.of(bare).silenced(), components.pairs)
    one_by_one.forces  # noqa: B018  # where no offset fits, the error is raised here
    return one_by_one


def _bare(
    frame: Description,
    joints: Mapping[str, JointElement],
    members: Mapping[str, LineElement],
    change: Change = WHOLE,
) -> Description:
    """The frame with the given joints and members, without loads, free strains, offsets and imposed displacements.

    It has the places to which `change` leads.
    """
    out = Description()
    for name, body in frame.bodies.items():
        out.body(name, change(body.origin, 1), change(body.axes, 2))
    for name, node in frame.nodes.items():
        out.node(name, change(node.coordinates, 1), node.body)
    for name, member in frame.members.items():
        out.add(name, members[name], member.start, member.end)
        if members[name].free_strain(np.zeros(())) is not None:
            out.members[name] = out.members[name]._replace(element=Unstrained(members[name]))
    for name, joint in frame.joints.items():
        out.add(name, joints[name], joint.first, joint.second)
    out.ties = list(frame.ties)
    for name, constrained in frame.supports.items():
        out.fix(name, *(DISPLACEMENTS[k] for k in constrained))
    return out


def _members(motions: UnitMotions, components: ClearanceComponents) -> Array:
    """Largest stiffness of a member's end against translation or rotation, as fits each component, (n, ...)."""
    plan = motions.plan
    largest = [np.zeros((1,) * len(plan.grid.shape)), np.zeros((1,) * len(plan.grid.shape))]
    for a in plan.matrix:
        value = np.asarray(total(plan.chained.scale(a))[1], dtype=np.float64)
        largest[a % 6 // 3] = np.maximum(largest[a % 6 // 3], value)
    counted = len(plan.grid.shape) == motions.forces.ndim - 1  # unit offsets along the first axis, of which one serves
    return np.stack([largest[k // 3][0] if counted else largest[k // 3] for k in components.component])
