"""The joint forces by unit offsets in the joints, which couple the clearances of a frame."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..batch import Array, Shape, aligned
from ..description import Description
from ..dofs import DISPLACEMENTS
from ..errors import FrameError
from ..structure.constraints import Contradiction
from .contact_state import ClearanceComponents, sizes
from .member_stiffness import member_stiffness
from .unit_motions import Solvers, UnitMotions, UnitMotionsPerEntry
from .without_loads import at_first_entry, elements_of, typical_elements, typical_members, without_loads

# A function that returns whether components carry a force at the entries, (n, ...).
Bearing = Callable[[], NDArray[np.bool_]]
# Decreases of forces, (n, n, ...), entries at which they are unknown, (...), and thresholds of rounding, (n, n, ...).
Answer = tuple[Array, NDArray[np.bool_], Array]

# A stiffness against offsets below _UNRESISTED times that of the members is rounding. Where that against one of them is
# up to _DOUBTFUL times as much it may be, too, as unit offsets move nodes by many times as much.
_UNRESISTED, _DOUBTFUL = 1e-13, 1e5
# Above this many all offsets are found in one pass.
_SOME = 2**11


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
    known: UnitMotions | None = None,
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
    known
        The motions by unit offsets, if they have been found together with the loads; else None.

    Raises
    ------
    FrameError
        If at all entries ideal joints close a loop of rigid links with which no offset is compatible.
    """
    joints, members = elements_of(frame)
    whole = len(frame.shape)
    common = None if known is not None or loaded is None else typical_elements(frame)
    if common is not None:
        bearings, typical = common
        found = _answer(without_loads(frame, bearings, typical), whole, components, bearing, lost, solvers, loaded)
        varies = any(element.stiffness.size > 6 for element in joints.values())
        varies = varies or any(typical[name] is not element for name, element in members.items())
        if not (varies and found.stiffness.any()):
            return found
    return _answer(without_loads(frame, joints, members), whole, components, bearing, lost, solvers, loaded, known)


def resists_at_first_entry(frame: Description, components: ClearanceComponents, solvers: Solvers) -> bool:
    """Whether at the first batch entry alone offsets cause forces; False where that cannot be told."""
    joints = {name: joint.element.typical() for name, joint in frame.joints.items()}
    if any(each.shape for each in joints.values()):
        return False
    bare = without_loads(at_first_entry(frame), joints, typical_members(frame))
    if bare.shape:
        return False
    none = np.zeros((), dtype=bool)
    try:
        found = _answer(bare, 0, components, lambda: np.ones(len(components.pairs), dtype=bool), none, solvers, None)
    except FrameError:
        return False
    return bool(found.stiffness.any())


def _answer(
    bare: Description,
    whole: int,
    components: ClearanceComponents,
    bearing: Bearing,
    lost: NDArray[np.bool_],
    solvers: Solvers,
    loaded: Sequence[int] | None,
    known: UnitMotions | None = None,
) -> Resistance:
    count = len(components.pairs)
    out = _everywhere(lost, bare.shape)
    if out.any():
        bare.exclude(out)
    fitting = None if known is None else (known, np.zeros(bare.shape, dtype=bool))
    motions, unfit = fitting or _fitting(bare, out, components, solvers, loaded)
    members = _members(motions, components)
    unknown, determinate = np.zeros(bare.shape, dtype=bool), True
    stiffness = None if out.any() else _well_known(motions, members, components)
    if stiffness is None:
        determinate = not np.isnan(motions.forces[..., ~out]).any()
        stiffness, unknown = _examined(bare, components, (motions, members), (lost, out), bearing, solvers)
    new = (1,) * (whole - unknown.ndim)
    return Resistance(
        stiffness.reshape(count, count, *new, *stiffness.shape[2:]),
        members.reshape(count, *(1,) * (whole + 1 - members.ndim), *members.shape[1:]),
        unknown,
        unfit,
        motions if determinate else None,
    )


def _well_known(motions: UnitMotions, members: Array, components: ClearanceComponents) -> Array | None:
    """The stiffness against offsets with rounding set to zero; None where offsets move a mechanism, see `_examined`.

    Numbers that are far above rounding at all entries, or at none, need no look at each entry.
    """
    stiffness = motions.stiffness
    batch = tuple(range(2, stiffness.ndim))
    if not stiffness.size:
        return None
    low, high = stiffness.min(axis=batch), stiffness.max(axis=batch)
    if np.isnan(low).any():
        return None
    root = np.sqrt(members)
    weakest, strongest = (most(root, axis=tuple(range(1, root.ndim))) for most in (np.min, np.max))
    unresisted = np.maximum(np.abs(low), np.abs(high)) <= _UNRESISTED * weakest[:, None] * weakest
    if unresisted.all():
        return np.zeros((*low.shape, *(1,) * len(batch)))
    doubtful = np.zeros(stiffness.shape[2:], dtype=bool)
    zero: dict[tuple[int, int], Any] = dict.fromkeys(zip(*np.nonzero(unresisted), strict=True), True)
    for i, j in np.argwhere(np.triu(~unresisted)).tolist():
        number, share = stiffness[i, j], _UNRESISTED * (_DOUBTFUL if i == j else 1.0)
        if max(low[i, j], -high[i, j], np.abs(number).min()) > share * strongest[i] * strongest[j]:
            continue
        size, rounding = np.abs(number), _UNRESISTED * root[i] * root[j]
        zero[i, j] = zero[j, i] = size <= rounding
        if i == j:
            doubtful |= (size > rounding) & (size <= _DOUBTFUL * rounding)
    if zero or doubtful.any():
        stiffness = stiffness.copy()
    for at, where in zero.items():
        stiffness[at] = np.where(where, 0.0, stiffness[at])
    if doubtful.any():
        some = stiffness[:, :, doubtful]
        rounding = np.broadcast_to(root, stiffness.shape[1:])[:, doubtful]
        rounding = rounding * _largest_motions(motions, components)[:, doubtful]
        stiffness[:, :, doubtful] = np.where(np.abs(some) > _UNRESISTED * rounding[:, None] * rounding, some, 0.0)
    return stiffness


def _examined(
    bare: Description,
    components: ClearanceComponents,
    solved: tuple[UnitMotions, Array],
    left: tuple[NDArray[np.bool_], NDArray[np.bool_]],
    bearing: Bearing,
    solvers: Solvers,
) -> tuple[Array, NDArray[np.bool_]]:
    """The stiffness against offsets with rounding set to zero entry by entry, and the entries at which it is unknown.

    Parameters
    ----------
    bare, components, bearing, solvers
        The frame without loads, and as for `against_offsets`.
    solved
        Its solution for unit offsets, and the stiffness of its members, (n, ...).
    left
        Entries that need no result, of the frame with and without loads.
    """
    (motions, members), (lost, out), count = solved, left, len(components.pairs)
    found = -motions.forces
    if out.any():
        found[..., out] = 0.0
    unknown = np.asarray(np.isnan(found).any(axis=(0, 1)))
    determinate = not unknown.any()
    root = np.sqrt(members)
    least = np.broadcast_to(_UNRESISTED * root[:, None] * root, found.shape)
    size = np.abs(found)
    with np.errstate(invalid="ignore"):
        above = size > least
        each = np.arange(count)
        doubtful = np.asarray((above & (size <= _DOUBTFUL * least))[each, each].any(axis=0))
    if doubtful.any():
        moved = np.where(doubtful & ~(unknown | out), _largest_motions(motions, components), 1.0)
        least = least * moved[:, None] * moved
    if not determinate:
        borne = _alike_within(bearing(), lost, bare.shape)
        found, unknown, least = _of_loaded(bare, components, borne, (found, unknown, least), solvers)
    elif not above.any():
        found = np.zeros((count, count, *(1,) * (found.ndim - 2)))
    found = 0.5 * (found + np.swapaxes(found, 0, 1))
    found = found if determinate else np.nan_to_num(found)
    return np.where(np.abs(found) > least, found, 0.0), unknown


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
    largest = motions.largest() if frame.size else None
    if largest is None:
        return np.ones((len(is_rotation), *motions.shape))
    size = sizes(frame)
    arms = np.where(is_rotation.reshape(-1, *(1,) * len(motions.shape)), 1.0 / size, 1.0)
    out: Array = np.maximum(1.0, arms * np.maximum(largest[0], largest[1] * size))
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
    if solvers.per_unit is not None and math.prod(bare.shape) > _SOME and asked.all():
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


def _members(motions: UnitMotions, components: ClearanceComponents) -> Array:
    """Largest stiffness of a member against translation or rotation, as fits each component, (n, ...)."""
    ndim, kinds = len(motions.shape), []
    for each in member_stiffness(motions.plan):
        # unit offsets may stand along a first axis, over which members do not vary
        kinds.append(aligned(each.reshape(each.shape[1:]) if each.ndim > ndim else each, ndim))
    asked = [k // 3 for k in components.component]
    if len(set(asked)) == 1:
        return np.broadcast_to(kinds[asked[0]], (len(asked), *kinds[asked[0]].shape))
    return np.stack(np.broadcast_arrays(*(kinds[kind] for kind in asked)))
