"""The cheapest fits of the joints that keep a point in its tolerance zone at every pose."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import accumulate

import numpy as np

from ....framework.batch import Array
from ....framework.errors import FrameError
from ...fits.allocation import allocate, relative_cost
from ...fits.iso286 import Fit, fit
from ..derivatives.position_sensitivity import PositionSensitivity, position_sensitivity, with_redundant_rows
from ..poses.classified import ClassifiedPoses
from ..zone import check_radius
from .limits import Given
from .region import ReachableRegion
from .worst_case import WorstCase, worst_case_by

# Running fits from precise to loose.
FITS = ("H6/g5", "H7/h6", "H7/g6", "H8/f7", "H8/e8", "H9/d9")
# Share of the limit by which integer programming may exceed it.
PASSED = 1e-6
# Name of all deviations but the clearances that are chosen, which count as one contributor.
OTHERS = "all other tolerances"

Costs = Mapping[str, float] | Callable[[Fit], float]


@dataclass(frozen=True, eq=False, repr=False)
class FitAllocation:
    """The cheapest fits; made by `Motion.allocate`.

    Attributes
    ----------
    fits
        Fit of each joint, by name.
    cost
        Total cost of the fits.
    limit
        Largest displacement allowed, length.
    combine
        How deviations add up, ``"worst case"`` or ``"statistical"``.
    greatest
        Largest displacement with these fits, length, (...).
    direction
        Unit vector of that displacement, (..., 3).
    worst
        The worst case with these fits.
    """

    fits: Mapping[str, Fit]
    cost: float
    limit: float
    combine: str
    greatest: Array
    direction: Array
    worst: WorstCase

    @property
    def clearances(self) -> dict[str, float]:
        """Greatest offset of the pin of each joint, as `Linkage.revolute` takes it for its clearance, length."""
        return {joint: each.offset for joint, each in self.fits.items()}

    @property
    def binding(self) -> tuple[tuple[int, ...], ...]:
        """Critical poses: indices in the batch of those whose displacement is within a thousandth of the largest."""
        found = np.argwhere(self.greatest >= 0.999 * self.greatest.max())
        return tuple(tuple(int(k) for k in each) for each in found)

    def shares(self) -> dict[str, float]:
        """Share of each contributor in the displacement at the critical pose; they add up to 1.

        Returns
        -------
        dict
            By name, the largest first: shares of the displacement, or of its square if deviations add up statistically.
        """
        at = np.unravel_index(np.argmax(self.greatest), self.greatest.shape)
        table = self.worst.contributors(self.direction)
        power = 1 if self.combine == "worst case" else 2
        reach = dict(zip(table.names, (table.reach[at] ** power).tolist(), strict=True))
        whole = sum(reach.values()) or 1.0
        return {name: each / whole for name, each in sorted(reach.items(), key=lambda pair: -pair[1])}

    def __repr__(self) -> str:
        """Fits, cost, and the critical pose with its largest contributors."""
        parts = ", ".join(f"{joint} {each.name}" for joint, each in self.fits.items())
        where = ", ".join(map(str, self.binding[0]))
        at = f" at pose {where}" if where else ""
        blamed = ", ".join(f"{name} {100.0 * share:.0f} %" for name, share in [*self.shares().items()][:3])
        used = f"{self.greatest.max():.4g} of {self.limit:.4g} used{at} ({blamed})"
        return f"<FitAllocation: {parts}; cost {self.cost:.4g}; {self.combine}: {used}>"


def allocate_fits(
    motion: ClassifiedPoses,
    point: str,
    limit: float,
    link: str | None,
    diameters: Mapping[str, float],
    fits: Sequence[str],
    costs: Costs | None,
    combine: str,
    given: Given,
) -> FitAllocation:
    """The cheapest fits that keep a point in its zone at every pose; see `Motion.allocate`.

    Each row of the integer program is the limit at one pose in one direction. Out of infinitely many directions, only
    those are added in which a choice of fits exceeds the limit, until a choice keeps it everywhere (cutting planes:
    J. E. Kelley, 1960). As the rows exclude no choice that keeps the limit, it is the cheapest of all.
    """
    if combine not in ("worst case", "statistical"):
        raise FrameError(f"combine is {combine!r}: choose 'worst case' or 'statistical'")
    check_radius(point, limit)
    choices = _choices(motion, diameters, fits, costs, given)
    table = {joint: {each.name: (each.offset, cost) for each, cost in some} for joint, some in choices.items()}
    program = _Program(position_sensitivity(motion, point, link), given, tuple(choices), combine)
    tightest, loosest = (
        {joint: pick(each.offset for each, _ in some) for joint, some in choices.items()} for pick in (min, max)
    )
    program.check(tightest, float(limit))
    rows = [program.rows(loosest, None)]
    while True:
        effects = {name: np.concatenate([row[name] for row in rows]) for name in (*choices, OTHERS)}
        found = allocate(effects, {**table, OTHERS: {"": (1.0, 0.0)}}, limit, combine=combine)
        chosen = {joint: fit(diameters[joint], found.chosen[joint]) for joint in choices}
        offsets = {joint: each.offset for joint, each in chosen.items()}
        greatest, direction, worst = program.reached(offsets)
        if np.all(greatest <= limit * (1.0 + PASSED)):
            return FitAllocation(chosen, found.cost, float(limit), combine, greatest, direction, worst)
        rows.append(program.rows(offsets, limit * (1.0 + PASSED)))


@dataclass(frozen=True, eq=False)
class _Program:
    """Integer program for the clearances of the chosen joints, with all other deviations given."""

    by: PositionSensitivity
    given: Given
    joints: tuple[str, ...]
    combine: str

    @cached_property
    def _rows(self) -> PositionSensitivity:
        return with_redundant_rows(self.by)

    def worst(self, offsets: Mapping[str, float]) -> WorstCase:
        """The worst case with these clearances."""
        clearances = {**self.given.clearances, **offsets}
        return worst_case_by(self.by, self._rows, replace(self.given, clearances=clearances))

    def reached(self, offsets: Mapping[str, float]) -> tuple[Array, Array, WorstCase]:
        """Largest displacement (...), its direction (..., 3), and the worst case, with these clearances."""
        worst = self.worst(offsets)
        if self.combine == "worst case":
            return worst.greatest, worst.direction, worst
        columns = worst.position.columns
        values, vectors = np.linalg.eigh(columns @ np.swapaxes(columns, -1, -2))
        return np.sqrt(np.maximum(values[..., -1], 0.0)), vectors[..., -1], worst

    def check(self, tightest: Mapping[str, float], limit: float) -> None:
        """Refuse limits that no choice keeps, and deviations whose effects do not add up."""
        worst = self.worst(dict.fromkeys(self.joints, 1.0))
        lost = np.argwhere(~np.isfinite(worst.position.columns).all(axis=(-1, -2)))
        if len(lost):
            where = ", ".join(map(str, lost[0].tolist()))
            raise FrameError(f"at pose {where} nothing is known to first order, as at a dead point: leave it out")
        if worst.position.stress is not None:
            raise FrameError(
                "clearances open redundant constraints of this linkage, so that the effect of one depends on the "
                "others: allocate is for linkages without such constraints"
            )
        if self.combine == "statistical" and worst.position.centre.any():
            raise FrameError("deviations that add up statistically must be symmetric: give half widths, not pairs")
        greatest = self.reached(tightest)[0]
        if greatest.max() > limit * (1.0 + PASSED):
            where = ", ".join(str(int(k)) for k in np.unravel_index(np.argmax(greatest), greatest.shape))
            raise FrameError(
                f"no fits hold {limit:g}: with the tightest of all joints {self.by.point} goes {greatest.max():.4g} far"
                f"{f' at pose {where}' if where else ''}; allow as much, or give finer fits"
            )

    def rows(self, offsets: Mapping[str, float], limit: float | None) -> dict[str, Array]:
        """New rows: displacement by a unit of each clearance in the directions of the largest displacement, by joint.

        There is one for each pose at which the choice exceeds the limit, or for every pose if `limit` is None.
        """
        greatest, direction, _ = self.reached(offsets)
        which = np.full(greatest.shape, True) if limit is None else greatest > limit
        own, rest = self._apart
        lengths = self._lengths(own.position, direction)[which]
        blamed = np.array([each.name for each in own.limits])
        sums = {joint: self._sum(lengths[:, blamed == f"joint {joint}"]) for joint in self.joints}
        along = np.abs(np.sum(rest.position.centre * direction, axis=-1))
        others = self._sum(self._lengths(rest.position, direction)) + along
        return {**sums, OTHERS: others[which]}

    @cached_property
    def _apart(self) -> tuple[WorstCase, WorstCase]:
        """The worst case with unit clearances, and that of all other deviations."""
        alone = replace(self, given=replace(self.given, end_play={}))
        return alone.worst(dict.fromkeys(self.joints, 1.0)), self.worst(dict.fromkeys(self.joints, 0.0))

    def _sum(self, lengths: Array) -> Array:
        power = 1 if self.combine == "worst case" else 2
        return np.asarray(np.sum(lengths**power, axis=-1) ** (1.0 / power))

    @staticmethod
    def _lengths(region: ReachableRegion, n: Array) -> Array:
        """Displacement by each contributor in directions `n` (..., 3), (..., contributors)."""
        along = (n[..., None, :] @ region.columns)[..., 0, :]
        starts = [0, *accumulate(region.sizes)][:-1]
        return np.asarray(np.sqrt(np.add.reduceat(along * along, starts, axis=-1)))


def _choices(
    motion: ClassifiedPoses, diameters: Mapping[str, float], fits: Sequence[str], costs: Costs | None, given: Given
) -> dict[str, list[tuple[Fit, float]]]:
    """By joint: its possible fits with their costs, checked."""
    if not diameters or not fits:
        raise FrameError("allocate was given no joints or no fits: give diameters={'B': 0.01, ...} and names of fits")
    for joint in diameters:
        motion.linkage.joint(joint)
        if joint in given.clearances:
            raise FrameError(f"joint {joint!r} has a diameter and a clearance: give one of them")
    return {
        joint: [(each, _cost(each, costs)) for each in (_running(diameter, name) for name in fits)]
        for joint, diameter in diameters.items()
    }


def _running(diameter: float, name: str) -> Fit:
    found = fit(diameter, name)
    if found.least_clearance < 0.0:
        raise FrameError(
            f"fit {found.name} of {diameter:g} m can have an interference of {-found.least_clearance:.2g} m, so that "
            "its pin does not turn: give fits with clearance"
        )
    return found


def _cost(each: Fit, costs: Costs | None) -> float:
    if costs is None or callable(costs):
        return float((costs or relative_cost)(each))
    if each.name not in costs:
        raise FrameError(f"costs have no fit {each.name}: give one for each, or a function of the fit")
    return float(costs[each.name])
