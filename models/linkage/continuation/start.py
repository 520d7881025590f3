"""Where the motion starts: the reference configuration, closed."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ....framework.batch import Array
from ....framework.errors import FrameError
from ..kinematics.closed_poses import Pose
from ..kinematics.elimination import order_of
from ..kinematics.extent import extent
from ..kinematics.loops import Loops
from ..kinematics.mechanism import Mechanism
from ..kinematics.nearest import nearest, open_by_one, widest
from ..kinematics.spindles import turning_units

# The equations have as many independent ones as singular values above this share of the largest.
INDEPENDENT = 1e-8
# A reference configuration is closed where its loops are open by less than this share of the size.
CLOSED = 1e-12
# How many members of a batch are tried for one that leads the others.
LEADERS = 64


def middle_first(mechanism: Mechanism) -> list[tuple[int, list[float]]]:
    """Numbers and dimensions of some members of the batch, that which lies nearest the middle of it first."""
    shape = mechanism.linkage.shape
    if not shape:
        return [(0, [float(x) for x in mechanism.parameters])]
    if 0 in shape:
        raise FrameError(f"the batch shape of the linkage is {shape}, without entries: give its points at least one")
    away = np.zeros(shape)
    for value in mechanism.parameters:
        if isinstance(value, np.ndarray):
            away = away + ((value - value.mean()) / (value.std() or 1.0)) ** 2
    flat_away, few = away.ravel(), min(LEADERS, away.size)
    nearest_few = np.flatnonzero(flat_away <= np.partition(flat_away, few - 1)[few - 1])
    order = nearest_few[np.argsort(flat_away[nearest_few], kind="stable")][:LEADERS]
    flat = [np.broadcast_to(x, shape).ravel()[order] for x in mechanism.parameters]
    return [(member, [float(x[k]) for x in flat]) for k, member in enumerate(order.tolist())]


def leader(mechanism: Mechanism, tolerance: float) -> tuple[int, list[float], Loops, Pose]:
    """Number, dimensions, loops and reference configuration of the member that leads the others: the first with one.

    Raises
    ------
    FrameError
        As `started`, where none has.
    """
    refused: FrameError | None = None
    for member, nominal in middle_first(mechanism):
        try:
            return member, nominal, *started(mechanism, nominal, tolerance, member)
        except FrameError as error:
            refused = refused or error
    assert refused is not None
    raise refused


def started(
    mechanism: Mechanism, nominal: Sequence[float], tolerance: float = 0.0, member: int = 0
) -> tuple[Loops, Pose]:
    """The loops with the rank of their equations, and the closed reference configuration of a member of the batch.

    Raises
    ------
    FrameError
        If the reference configuration cannot be closed, or is singular so that nothing says which way it goes.
    """
    loops = Loops(mechanism, None, tolerance)
    state = _closed_reference(loops, nominal, member)
    jacobian = jacobian_at(loops, state, nominal)
    units = _units(mechanism, member)
    rank, full = _rank(loops, jacobian / units), min(loops.rows, loops.columns)
    if rank < full:
        general = _general_rank(loops, state, nominal, units)
        if general > rank:
            raise FrameError(
                "the reference configuration is singular, so that the drives do not determine which way the linkage "
                "goes: give the points of another pose of the branch that is meant"
            )
        loops = Loops(mechanism, rank, tolerance)
    loops.linear.project(jacobian)
    loops.linear.order = order_of(loops.linear, jacobian)
    start = loops.close(state, nominal)
    if start is None:
        raise FrameError("the reference configuration is next to a singular one: give the points of another pose")
    return loops, start


def _closed_reference(loops: Loops, nominal: Sequence[float], member: int) -> list[float]:
    closed = max(CLOSED, loops.tolerance)
    if open_by_one(loops, loops.reference_state, nominal) < CLOSED:
        return list(loops.reference_state)
    near = loops.close(list(loops.reference_state), nominal)
    if near is not None and open_by_one(loops, near.state, nominal) < closed:
        return near.state
    best, error = nearest(loops, [np.array(x) for x in loops.reference_state], nominal)
    state = [float(x) for x in best]
    if not error < closed:
        row = int(widest(loops, state, nominal))
        sizes = np.broadcast_to(loops.mechanism.size, loops.mechanism.linkage.shape)
        raise not_assembled(loops.mechanism.rows[row][0], float(error) * float(sizes.reshape(-1)[member]))
    return state


def not_assembled(joint: str, gap: float) -> FrameError:
    """What to say of a reference configuration with a gap, a length, at a joint."""
    return FrameError(
        f"the reference configuration cannot be assembled: a gap of {gap:.3g} remains at joint {joint!r}: "
        "align the joint's axes, change the lengths, or accept the gap with tolerance="
    )


def _general_rank(loops: Loops, state: Sequence[float], nominal: Sequence[float], units: Array) -> int:
    """Rank at a pose near `state`, in general position on the closed poses."""
    rng = np.random.default_rng(0)
    n, f = loops.columns, len(loops.mechanism.driven)
    ranks = []
    for _ in range(3):
        step = 1e-2 * rng.standard_normal(n + f)
        moved = loops.advance(list(state), step[:n].tolist())
        for k, place in enumerate(loops.driven_states if not loops.driven_spherical else []):
            moved[place] = moved[place] + float(step[n + k])
        best, error = nearest(loops, [np.array(x) for x in moved], nominal, free=not loops.driven_spherical)
        if error < max(1e-10, loops.tolerance):
            ranks.append(_rank(loops, jacobian_at(loops, [float(x) for x in best], nominal) / units))
    return max(ranks, default=0)


def _units(mechanism: Mechanism, member: int) -> Array:
    """Units of the unknowns of a member, (n,): the angle of a spindle counts as the travel of its screw.

    With a fine screw a spindle turns so far that what it does for the equations, per radian, looks like rounding.
    """
    out, linkage = np.ones(len(mechanism.columns)), mechanism.linkage
    if not mechanism.pitches:
        return out[mechanism.unknown]
    for place, unit in turning_units(linkage, mechanism.columns, extent(linkage)).items():
        out[place] = unit.reshape(-1)[member]
    return out[mechanism.unknown]


def _rank(loops: Loops, jacobian: Array) -> int:
    """Rank of the closing equations in the unknowns, by their Jacobian in units of these."""
    return rank_of(jacobian, max(INDEPENDENT, 10.0 * loops.tolerance))


def rank_of(matrix: Array, share: float) -> int:
    """Number of singular values above a share of the largest."""
    values = np.linalg.svd(matrix, compute_uv=False)
    return int(np.count_nonzero(values > share * max(values.max(initial=0.0), 1e-300)))


def jacobian_at(loops: Loops, state: Sequence[float], parameters: Sequence[float]) -> Array:
    """Jacobian (m, n) of the closing equations by the unknowns at one state."""
    entries = loops.mechanism.newton[0](state, parameters)[loops.rows :]
    return np.array(entries, dtype=np.float64).reshape(loops.rows, loops.columns)
