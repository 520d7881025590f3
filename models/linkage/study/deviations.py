"""Limits of deviations in a study, for the worst case, and each contributor's shares in it and in the variance."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from ....framework.batch import Array
from ...distributions import Distribution, ends
from ..derivatives.position_sensitivity import position_sensitivity, with_redundant_rows
from ..motion import Motion
from ..worst_case.contributors import Contributors
from ..worst_case.limits import Given, Limit, limits
from ..worst_case.worst_case import WorstCase
from .parts import OF_CLEARANCE
from .sampled import SampledDisplacement
from .tolerances import Tolerance

# Step of the central differences, as a share of the half width of a tolerance.
STEP = 3e-3
# Probabilities at which quantiles are taken of a distribution that does not give its standard deviation.
MIDDLES = (np.arange(4096) + 0.5) / 4096


def worst_cases(motion: Motion, sampled: SampledDisplacement, *, clearances: bool = True) -> dict[str, WorstCase]:
    """By point: the worst case of all tolerances and, if `clearances`, of clearances at their upper limits."""
    upper_limits = dict(_clearances(sampled.tolerances))
    # with contact in any direction, that at nominal numbers is among them and is not added
    slopes = _slopes(sampled, _others(sampled.tolerances), clearance=not clearances) | dict(sampled.heat)
    found = {}
    for index, point in enumerate(sampled.points):
        by = position_sensitivity(motion, point, None)
        full = with_redundant_rows(by)
        own = list(limits(full, Given(upper_limits, {}, {}, {}, {}, {}))) if clearances else []
        for name, slope in slopes.items():
            columns = np.zeros((*motion.shape, full.rows, 1))
            columns[..., :3, 0] = slope[index].reshape(*motion.shape, 3)
            columns[..., 3:6, 0] = np.nan  # rotations of the link are not computed
            lower, upper = reach(sampled.tolerances[name])
            own.append(Limit(name, columns, np.array(0.5 * (upper - lower)), np.array(0.5 * (upper + lower))))
        found[point] = WorstCase(by, tuple(own))
    return found


def contributors(worst: WorstCase, tolerances: Mapping[str, Tolerance]) -> Contributors:
    """Shares in the largest displacement; variances of clearances are uniform, those of tolerances by distribution."""
    found, n = worst.contributors(), np.nan_to_num(worst.direction, nan=1.0)
    variance = found.variance.copy()
    for limit in worst.limits:
        if limit.name in tolerances and not limit.joint:
            along = np.sum(limit.by[..., :3, 0] * n, axis=-1)
            variance[..., found.names.index(limit.name)] = (along * deviation(tolerances[limit.name].distribution)) ** 2
    return Contributors(found.names, found.reach, variance)


def reach(tolerance: Tolerance) -> tuple[float, float]:
    """Lower and upper deviation from the nominal value: limits of the distribution, or three standard deviations."""
    middle = nominal_draw(tolerance)
    lower, upper = ends(tolerance.distribution)
    return lower - middle, upper - middle


def nominal_draw(tolerance: Tolerance) -> float:
    """The draw at which the numbers have their nominal values."""
    return 0.0 if tolerance.relative else next(iter(tolerance.nominal.values()))


def deviation(distribution: Distribution) -> float:
    """Standard deviation of a distribution, by its quantiles if it has no method `std`."""
    own: Any = getattr(distribution, "std", None)
    return float(own()) if callable(own) else float(np.std(distribution.ppf(MIDDLES)))


def _clearances(tolerances: Mapping[str, Tolerance]) -> list[tuple[str, float]]:
    """Upper limits of clearances by joint."""
    found = []
    for each in tolerances.values():
        upper = reach(each)[1]
        for place, nominal in each.nominal.items():
            if place[0] == "joints" and place[2] == "clearance":
                found.append((str(place[1]), nominal * (1.0 + upper) if each.relative else nominal + upper))
    return found


def _others(tolerances: Mapping[str, Tolerance]) -> dict[str, Tolerance]:
    """The tolerances without clearances and contact angles."""
    found = {}
    for name, each in tolerances.items():
        rest = {k: v for k, v in each.nominal.items() if not (k[0] == "joints" and k[2] in OF_CLEARANCE)}
        if rest:
            found[name] = replace(each, nominal=rest)
    return found


def _slopes(sampled: SampledDisplacement, tolerances: Mapping[str, Tolerance], *, clearance: bool) -> dict[str, Array]:
    """By tolerance: derivative of the displacement by its draw, (points, poses, 3), all computed in one batch.

    With `clearance` it includes the displacement by clearances, whose contact may depend on the tolerance.
    """
    if not tolerances:
        return {}
    count, draws, steps = 2 * len(tolerances), {}, {}
    for k, (name, each) in enumerate(tolerances.items()):
        lower, upper = reach(each)
        steps[name] = STEP * 0.5 * (upper - lower)
        draws[name] = np.full(count, nominal_draw(each))
        draws[name][2 * k] += steps[name]
        draws[name][2 * k + 1] -= steps[name]
    moved, _ = replace(sampled, tolerances=tolerances).moved(draws, clearance=clearance)
    return {
        name: (moved[:, :, 2 * k] - moved[:, :, 2 * k + 1]) / (draws[name][2 * k] - draws[name][2 * k + 1])
        for k, name in enumerate(tolerances)
    }
