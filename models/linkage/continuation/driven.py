"""Check that the drives determine the motion: no undriven degree of freedom moves a point, and no drive is too many."""

from __future__ import annotations

import functools
from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from ....framework.batch import Array
from ....framework.errors import FrameError
from ..description.parts import GROUND
from ..kinematics.blocks import blocks, cut_all
from ..kinematics.closed_poses import Pose
from ..kinematics.dimensions import by_component
from ..kinematics.loops import Loops
from ..kinematics.terms import Value
from .start import jacobian_at, rank_of

# Motion, in units of the linkage's size and radians, below which a point or link counts as at rest.
STILL = 1e-6
# Relative difference below which two equations may have been meant to be equal, and the gap, as a share of the size,
# that this may cause.
ALIKE = 1e-3


def check_driven(loops: Loops, parameters: Sequence[float], start: Pose, member: int) -> None:
    """Check that no undriven degree of freedom moves a point; the spin of a rod between two balls moves none.

    A linkage without drives is accepted: it rests in the reference configuration.

    Parameters
    ----------
    loops
        The loops of the linkage.
    parameters, start
        Dimensions of the member of the batch that is looked at, and its reference configuration.
    member
        Its number.

    Raises
    ------
    FrameError
        If one does; the message names the joints that it moves.
    """
    linkage = loops.mechanism.linkage
    if loops.determined or not linkage.drives:
        return
    speeds = _speeds(loops, parameters, start, member)
    points = np.array([v for _, at in speeds.values() for v in at.values()]).reshape(-1, free_motions(loops))
    count = int(np.count_nonzero(np.linalg.svd(points, compute_uv=False) > STILL))
    if not count:
        return
    moving = []
    for name, pair in linkage.joints.items():
        driven = linkage.drives.get(name, ())
        rest = [coordinate for coordinate in pair.kind.coordinates if coordinate not in driven]
        if rest and _moves(speeds, pair.first, pair.second, pair.point):
            moving.append(f"{name} ({' and '.join(rest)} too)" if driven else name)
    raise FrameError(
        f"underdetermined: {_number(count, 'degree')} of freedom {'has' if count == 1 else 'have'} no drive (driven: "
        f"{', '.join(linkage.drives)}): also drive {' or '.join(moving[:6])}"
    )


def free_motions(loops: Loops) -> int:
    """Number of motions that are possible with the drives locked."""
    return loops.columns - loops.linear.rank


Speeds = dict[str, tuple[Array, dict[str, Array]]]


def _speeds(loops: Loops, parameters: Sequence[float], start: Pose, member: int) -> Speeds:
    """Of each link and the ground: angular velocity and velocity of its points, (3, k), by the k free motions."""
    mechanism, linkage = loops.mechanism, loops.mechanism.linkage
    free = np.zeros((len(mechanism.columns), free_motions(loops)))
    jacobian = jacobian_at(loops, start.state, parameters)
    right = np.linalg.svd(jacobian)[2] if jacobian.size else np.eye(loops.columns)
    free[mechanism.unknown] = right[loops.linear.rank :].T
    still = np.zeros((3, free.shape[1]))
    out: Speeds = {GROUND: (still, dict.fromkeys(linkage.points, still))}
    none = (0.0,) * len(free)
    poses = np.array(mechanism.poses[0](start.state, parameters)).reshape(-1, 4, 3)
    every = np.array([mechanism.rates[0](start.state, parameters, v, none) for v in free.T.tolist()])
    for k, (name, link) in enumerate(linkage.links.items()):
        pose, rates = poses[k], every.reshape(free.shape[1], len(linkage.links), 12)[:, k]
        omega, velocity, body = rates[:, :3], rates[:, 3:6], mechanism.bodies[name]
        at = {}
        for point in link.points:
            own = mechanism.place(name, point) - body.place
            along = np.einsum("...ji,...j->...i", body.reference_axes, own) / by_component(mechanism.size)
            arm = np.broadcast_to(along, (*linkage.shape, 3)).reshape(-1, 3)[member] @ pose[1:]
            at[point] = (velocity + np.cross(omega, arm)).T
        out[name] = omega.T, at
    return out


def _moves(speeds: Speeds, first: str, second: str, point: str) -> bool:
    """Whether a free motion moves two links relative to each other where they are joined."""
    (turn, here), (other, there) = speeds[first], speeds[second]
    difference = np.concatenate([other - turn, there[point] - here[point]])
    return bool(np.abs(difference).max(initial=0.0) > STILL)


def remedy(loops: Loops, gap: float, size: float) -> str:
    """What to tell of a pose of a linkage of some size that has a gap, a length: too many drives, or too few digits.

    Both show in more equations than there are independent ones; nothing where it is neither.
    """
    if too_many := too_many_drives(loops):
        return f"; {too_many}: their values do not agree"
    if loops.mechanism.begun is not None and loops.rows > loops.linear.rank and gap < ALIKE * size:
        return "; overconstrained: give the points with more digits, or accept this gap with tolerance="
    return ""


def too_many_drives(loops: Loops) -> str:
    """How many drives there are for how many degrees of freedom, if they are more; else nothing."""
    mechanism = loops.mechanism
    if mechanism.begun is None or loops.rows == loops.linear.rank:
        return ""
    nominal, _, start = mechanism.begun
    matrix = mechanism.all_entries[0](tuple(start.state), tuple(nominal))
    columns = len(mechanism.columns)
    freedoms = columns - rank_of(np.array(matrix, dtype=np.float64).reshape(-1, columns), ALIKE)
    drives, taken = len(mechanism.driven), freedoms - free_motions(loops)
    return f"{_number(drives, 'drive')} for {_number(taken, 'degree')} of freedom" if drives > taken else ""


def check_rates(
    loops: Loops,
    state: Sequence[Value],
    parameters: Sequence[Value],
    v: Sequence[Value],
    w: Sequence[Value],
    closed: NDArray[np.bool_],
) -> None:
    """Check that the rates of more drives than there are degrees of freedom agree, to a thousandth.

    Parameters
    ----------
    loops
        The loops of the linkage.
    state, parameters
        Closed states and dimensions.
    v, w
        All velocity coordinates and their time derivatives.
    closed
        Which poses are assembled, (...).

    Raises
    ------
    FrameError
        If with these rates or accelerations the loops would open; the message names the pose.
    """
    for block in blocks(closed.shape):
        given = (cut_all(each, block) for each in (state, parameters, v, w))
        for what, opening, size in _openings(loops, *given):
            wrong = closed[block] & (opening > ALIKE * size)
            if np.any(wrong):
                first = np.argwhere(wrong)[0] + [part.start or 0 for part in block]
                at = f" at pose {', '.join(map(str, first))}" if len(first) else ""
                raise FrameError(
                    f"{too_many_drives(loops)}: their {what} do not agree{at}: give {what} that leave the loops closed"
                )


def _openings(
    loops: Loops, state: Sequence[Value], parameters: Sequence[Value], v: Sequence[Value], w: Sequence[Value]
) -> Iterator[tuple[str, Value, Value]]:
    """How fast the loops open, at which acceleration, and the size of the terms that should cancel, (...) each."""
    mechanism, m, n = loops.mechanism, loops.rows, loops.columns
    with np.errstate(all="ignore"):
        entries = mechanism.full[1](state, parameters)[m:]
        by = [*mechanism.unknown, *mechanism.driven]
        f = len(by) - n
        rows = [[*entries[i * n : i * n + n], *entries[(m * n) + i * f : (m * n) + i * f + f]] for i in range(m)]

        def sums(rates: Sequence[Value]) -> list[tuple[Value, Value]]:
            terms = [[x * rates[k] for x, k in zip(row, by, strict=True)] for row in rows]
            return [(sum(each), sum(map(abs, each))) for each in terms]

        speeds = sums(v)
        yield "rates", *_largest(speeds)
        # the parts of the bias may cancel, as where a link does not turn: each is as large as a speed times a rate
        fastest: Value = functools.reduce(np.maximum, [np.abs(v[k]) for k in by])
        both = zip(mechanism.bias[1](state, parameters, v, w), sums(w), speeds, strict=True)
        yield "accelerations", *_largest([(whole, size + speed * fastest) for whole, (_, size), (_, speed) in both])


def _largest(rows: Sequence[tuple[Value, Value]]) -> tuple[Value, Value]:
    """Largest size of both over all rows, (...) each."""
    one, other = zip(*rows, strict=True)
    return functools.reduce(np.maximum, map(abs, one)), functools.reduce(np.maximum, other)


def _number(count: int, noun: str) -> str:
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"
