"""State of each pose of a motion: regular, near a dead point, or singular, with the type and the joint."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ....framework.batch import Array
from ....framework.states import States, words
from ..description.parts import GROUND
from ..kinematics.extent import extent
from ..kinematics.linear import matrices
from ..kinematics.spindles import turning_units
from .kinematics import Kinematics
from .moving_joints import MOVES, moving_joints
from .states import PoseState, closure_states, singular_states

Bools = NDArray[np.bool_]
# Conditioning below which a pose is singular: a pose next to a dead point is accurate to half the digits at best.
SINGULAR = 1e-7
# Conditioning below which a pose is near a dead point; some 2° from it for a four-bar with bars of similar length.
NEAR = 1e-2
# Number of poses around the reference configuration from which typical speeds are taken, and their distance from it.
PROBES, BESIDE = 5, 0.1
# Number of links beyond which their motions are found together: one by one they take a time that grows with its square.
MANY = 12
# Ratio to the typical speed below which a speed counts as zero.
STILL = 1e-9


def conditioning(motion: Kinematics) -> tuple[Array, Array]:
    """Conditioning of each pose, (...), and at singular poses the free motions of the unknowns, (..., n, k).

    The conditioning is the ratio of the least to the largest singular value of the closing equations by the unknown
    coordinates, with lengths in units of the linkage's extent: 0 where something moves with the drives locked. Singular
    values that always vanish, as for a rod that can spin, do not count. If sets of loops close one after the other,
    each has its own ratio, in units of its own extent, and the least counts, so that a chain is not near a dead point
    because it is long.

    Poses with fewer than k free motions have zeros for the others; regular poses have zeros only.
    """
    loops = motion.assembly.loops
    shape, n, rank = motion.assembly.shape, loops.columns, loops.linear.rank
    if not rank:
        return np.ones(shape), np.zeros((*shape, n, 1))
    equations = _Equations(motion)
    ratio = np.where(motion.assembly.closed, _constraint_stiffness(motion, equations), np.nan)
    bad = np.broadcast_to(ratio < SINGULAR, shape)
    free = _free(equations.at(bad), rank) if bad.any() else np.zeros((0, n, 1))
    least = np.zeros((*shape, n, free.shape[-1]))
    least[bad] = free
    return np.broadcast_to(ratio, shape), least / equations.units[1][..., :, None]


class _Equations:
    """Closing equations by the unknown coordinates, with lengths in units of the linkage's extent.

    They stand block by block, as few of those of many loops differ from zero.

    Attributes
    ----------
    units
        Factor of each row (..., m), divisor of each column (..., n), of the linkage's batch shape.
    """

    def __init__(self, motion: Kinematics) -> None:
        self.motion, mechanism, loops = motion, motion.mechanism, motion.assembly.loops
        with np.errstate(all="ignore"):
            self.entries = mechanism.newton[1](motion.assembly.state, mechanism.parameters)[loops.rows :]
        sizes = extent(mechanism.linkage)
        rows = _units([mechanism.rows[i][1] for i in mechanism.active], mechanism.size / sizes)
        self.units = rows, _column_units(motion, sizes)
        self.shape = rows.shape[-1], loops.columns

    def of(self, rows: Sequence[int], columns: Sequence[int]) -> Array:
        """Coefficients of some rows and columns, (..., m, n); 1 at poses that are not closed."""
        n, there = self.shape[1], self.motion.assembly.closed[..., None, None]
        own = matrices([[self.entries[i * n + j] for j in columns] for i in rows])
        return np.asarray(
            np.where(there, own, 1.0) * self.units[0][..., rows, None] / self.units[1][..., None, columns]
        )

    def at(self, poses: Bools) -> Array:
        """All coefficients of k chosen poses, (k, m, n)."""
        out = np.zeros((int(poses.sum()), *self.shape))
        for place, entry in enumerate(self.entries):
            if isinstance(entry, np.ndarray):
                out[:, *divmod(place, self.shape[1])] = np.broadcast_to(entry, poses.shape)[poses]
            elif entry:
                out[:, *divmod(place, self.shape[1])] = entry
        rows, columns = (np.broadcast_to(x, (*poses.shape, x.shape[-1]))[poses] for x in self.units)
        return np.asarray(out * rows[:, :, None] / columns[:, None, :])


def _units(components: Sequence[str], length: Array) -> Array:
    """Units of some components, (..., n): a length (...) for displacements and 1 for rotations."""
    slides = np.array([component[0] == "u" for component in components], dtype=bool)
    return np.where(slides, length[..., None], 1.0)


def _column_units(motion: Kinematics, sizes: Array) -> Array:
    """Units of the unknown coordinates, (..., n): extents of the linkage and radians.

    Angles of spindles count as the travel of their screws: with a fine screw they turn fast, near no dead point.
    """
    mechanism, linkage = motion.mechanism, motion.linkage
    names = [mechanism.columns[k] for k in mechanism.unknown]
    units = _units([component for _, component in names], mechanism.size / sizes)
    for place, unit in turning_units(linkage, names, sizes).items():
        units[..., place] = unit
    return units


def _free(matrix: Array, rank: int) -> Array:
    """Free motions (poses, n, k) of singular equations (poses, m, n) of a rank: one at least."""
    _, values, right = np.linalg.svd(matrix)
    free = values[:, :rank] < SINGULAR * values[:, :1]
    free[:, -1] = True
    count = int(free.sum(axis=1).max(initial=1))
    chosen = right[:, rank - count : rank] * free[:, -count:, None]
    return np.asarray(np.swapaxes(chosen, 1, 2))


def _constraint_stiffness(motion: Kinematics, equations: _Equations) -> Array:
    """Least over greatest singular value of the closing equations, the least of those of sets of loops that close one
    after the other, (...)."""
    mechanism, linear = motion.mechanism, motion.assembly.loops.linear
    if not linear.square or len(linear.blocks) < 2:
        values = np.linalg.svd(equations.of(*map(range, equations.shape)), compute_uv=False)
        return np.asarray(values[..., linear.rank - 1] / values[..., 0])
    whole = extent(motion.linkage)
    found = []
    for rows, columns in linear.blocks:
        names = [mechanism.unknown[k] for k in columns]
        joints = {mechanism.rows[mechanism.active[i]][0] for i in rows} | {mechanism.columns[k][0] for k in names}
        span = _span(motion, joints)
        share = whole / np.where(span > 0.0, span, whole)
        turns = _units([mechanism.rows[mechanism.active[i]][1] for i in rows], share)
        lengths = _units([mechanism.columns[k][1] for k in names], share)
        own = equations.of(rows, columns) * turns[..., :, None] / lengths[..., None, :]
        values = np.linalg.svd(own, compute_uv=False)
        # a single equation counts by its size: it is a cosine, or an arm in units of the extent
        found.append(values[..., -1] / (values[..., 0] if len(rows) > 1 else 1.0))
    return np.asarray(np.min(found, axis=0))


def _span(motion: Kinematics, joints: Iterable[str]) -> Array:
    """Extent of the positions of some joints in the reference configuration, (...)."""
    linkage = motion.linkage
    places = np.stack(np.broadcast_arrays(*(linkage.points[linkage.joints[name].point] for name in joints)))
    return np.asarray(np.ptp(places, axis=0).max(axis=-1))


def pose_states(motion: Kinematics, conditioned: tuple[Array, Array]) -> tuple[States, NDArray[np.str_]]:
    """State of each pose and its text, (...) of the assembly; see `PoseState` and `Motion.status`.

    `conditioned` is the result of `conditioning`.
    """
    ratio, least = conditioned
    still = standing_still(motion)
    none = np.zeros(motion.assembly.shape, dtype=bool)
    state = singular_states(ratio, NEAR, SINGULAR, np.any([none, *still.values()], axis=0))
    status = words(state, PoseState).astype("<U200")
    for joint, where in reversed(list(still.items())):
        lost = "is stationary" if len(motion.drives.rates) == 1 else "loses a degree of freedom"
        status[where & (state == PoseState.SINGULAR_INVERSE)] = (
            f"singular (inverse-kinematic, type I; joint {joint} {lost})"
        )
    released = state == PoseState.SINGULAR_DIRECT
    if released.any():
        status[released] = [
            f"singular (direct-kinematic, type II; dead point of {joint})"
            for joint in released_joints(motion, released, least)
        ]
    closure = closure_states(motion.assembly.reached, motion.assembly.other)
    text = closure == PoseState.REGULAR
    return np.where(text, state, closure), np.where(text, status, motion.closure_status)


def released_joints(motion: Kinematics, chosen: Bools, least: Array) -> NDArray[np.str_]:
    """The joint that moves with the drives locked at each of the chosen poses, (k,)."""
    mechanism, shape = motion.mechanism, motion.assembly.shape
    state, parameters = (
        [np.broadcast_to(x, shape)[chosen] for x in entries]
        for entries in (motion.assembly.state, mechanism.parameters)
    )
    velocities = np.zeros((len(mechanism.columns), int(chosen.sum()), least.shape[-1]))
    velocities[mechanism.unknown] = np.moveaxis(least[chosen], 1, 0)
    return moving_joints(mechanism, state, parameters, list(velocities))


def standing_still(motion: Kinematics) -> dict[str, Bools]:
    """By joint, whether some motion of the drives leaves its point at rest that moves it at other poses, (...).

    If there are more drives than a point has directions, the link as a whole is considered. Typical speeds come from
    poses around the reference configuration, so that the result does not depend on the batch.
    """
    count = len(motion.drives.rates)
    if not 0 < count <= 6:
        return {}
    speeds = Speeds(motion)
    by_point: dict[str, Bools] = {}
    by_link: dict[str, Bools] = {}
    for name in sorted(motion.linkage.joints):
        joint = motion.linkage.joints[name]
        link = joint.first if joint.second == GROUND else joint.second
        slides = joint.pitch is not None or "u" in "".join(joint.kind.coordinates)
        moves, lost = (False, None) if slides or count > 3 else speeds.lost(joint.point, link)
        found = by_point
        if not moves and (slides or count > 1):
            (_, lost), found = speeds.lost(None, link), by_link
        if lost is not None:
            found[name] = lost
    return by_point | by_link


class Speeds:
    """Speeds of points and links per unit rate of the drives, at the poses of a motion and around the reference.

    Parameters
    ----------
    motion
        The motion.
    """

    def __init__(self, motion: Kinematics) -> None:
        self.motion, self.size, self.count = motion, extent(motion.linkage), len(motion.drives.rates)
        self.motions = _evaluated(unit_motions(motion))

    @cached_property
    def around(self) -> list[Kinematics]:
        """Poses around the reference configuration, moved by each drive in turn."""
        return _evaluated(unit_motions(_around(self.motion)))

    def lost(self, point: str | None, link: str) -> tuple[bool, Bools | None]:
        """Whether all motions of the drives move a point or link in general; poses where one does not, (...)."""
        here = self._least(self.motions, point, link)
        if not np.any(here < MOVES):
            return True, None
        usual = self._usual(point, link)
        lost = (here < STILL * usual) & (usual > MOVES)
        return bool(np.all(usual > MOVES)), lost if lost.any() else None

    def _usual(self, point: str | None, link: str) -> Array:
        """Typical least speed, from poses around the reference configuration; kept with the mechanism."""
        known, key = self.motion.mechanism.usual_speeds, (self.motion.tolerance, point, link)
        if key in known:
            return known[key]
        usual = np.asarray(np.nanmax(self._least(self.around, point, link), axis=0, initial=0.0))
        if not usual.ndim:
            known[key] = usual
        return usual

    def _least(self, motions: Sequence[Kinematics], point: str | None, link: str) -> Array:
        return singular_speeds(motions, point, link, self.size)[..., self.count - 1]


def _evaluated(motions: Iterable[Kinematics]) -> list[Kinematics]:
    """The motions; those of many links with all links evaluated together."""
    out = list(motions)
    for motion in out:
        if len(motion.linkage.links) > MANY:
            motion.evaluate_links(rates=True)
    return out


def _around(motion: Kinematics) -> Kinematics:
    """Some poses around the reference configuration, along a first axis."""
    linkage = motion.linkage
    values: dict[str, Array] = {}
    for place, name in enumerate(sorted(linkage.drives)):
        pair, components = linkage.joint(name), linkage.drives[name]
        chosen = pair.kind.places_of(components)
        scales = [motion.mechanism.size if component[0] == "u" else 1.0 for component in components]
        units = np.stack(np.broadcast_arrays(*scales), axis=-1)
        steps = np.random.default_rng(place).uniform(-BESIDE, BESIDE, (PROBES, len(chosen)))
        steps[0] = 0.0
        at = pair.reference[..., chosen]
        given = at + steps.reshape(PROBES, *(1,) * len(linkage.shape), len(chosen)) * units
        values[name] = given if len(chosen) > 1 else given[..., 0]
    return Kinematics.of(linkage, values, {}, {}, tolerance=motion.tolerance)


def unit_motions(motion: Kinematics) -> Iterator[Kinematics]:
    """The motion with each drive in turn at unit rate and the others at rest."""
    count = len(motion.drives.rates)
    for drive in range(count):
        rates = [np.asarray(float(k == drive)) for k in range(count)]
        still = [np.zeros(())] * count
        drives = motion.drives._replace(rates=rates, accelerations=still, full_shape=motion.drives.shape)
        yield replace(motion, drives=drives)


def singular_speeds(motions: Sequence[Kinematics], point: str | None, link: str, size: Array) -> Array:
    """Singular values (..., k) of the velocity, in units of `size` (...), of a point by the rates of the drives.

    Without a point, those of the velocity and angular velocity of the link: a sliding link has no single point to judge
    by.
    """
    speeds = np.stack([_speed(motion, point, link, size) for motion in motions], axis=-1)
    there = np.asarray(np.isfinite(speeds).all(axis=(-2, -1), keepdims=True))
    values = np.linalg.svd(np.where(there, speeds, 0.0), compute_uv=False)
    return np.where(there[..., 0], values, np.nan)


def _speed(motion: Kinematics, point: str | None, link: str, size: Array) -> Array:
    if point is not None:
        return motion.velocity(point, link) / size[..., None]
    first = motion.velocity(motion.linkage.links[link].points[0], link) / size[..., None]
    return np.concatenate([first, motion.angular_velocity(link)], axis=-1)
