"""Worst case of a file's clearances and tolerances, for its page."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from ....framework.batch import Array
from ...distributions import SIGMAS, ends
from ..derivatives.position_sensitivity import PositionSensitivity, position_sensitivity, with_redundant_rows
from ..files.toml import Path as Place
from ..motion import Motion
from ..study.tolerances import Tolerance
from ..worst_case.limits import Given, Limit, limits
from ..worst_case.worst_case import WorstCase

LEFT_OUT = "Not among the worst cases, as they do not move the rigid linkage or not to first order: {names}."
ENDS = (
    "Tolerances go to the ends of their distributions; where these have none, to the quantiles that lie {deviations:g} "
    "standard deviations from the mean of a normal distribution."
)


def worst_case_of(
    motion: Motion, point: str, tolerances: Mapping[str, Tolerance]
) -> tuple[WorstCase | None, list[str]]:
    """The worst case of a file's clearances and tolerances, None if nothing deviates; and notes on it.

    Parameters
    ----------
    motion
        Motion of the linkage of the file.
    point
        The point that the page is about.
    tolerances
        Tolerances of the file by name. Only those of clearances, points and reference values of drives have an effect
        on the rigid linkage.
    """
    if not tolerances and all(pair.clearance is None for pair in motion.linkage.joints.values()):
        return None, []
    by = with_redundant_rows(position_sensitivity(motion, point, None))
    clearances: dict[str, Array] = {}
    found, left_out = list[Limit](), list[str]()
    for name, tolerance in tolerances.items():
        reach = ends(tolerance.distribution)
        kinds = {(place[0], place[2]) if len(place) > 2 else () for place in tolerance.nominal}
        if kinds == {("joints", "clearance")}:
            clearances |= _greatest(tolerance, reach[1])
        elif limit := _limit(by, tolerance, reach):
            found.append(limit)
        else:
            left_out.append(name)
    found = [*limits(by, Given(clearances, {}, {}, {}, {}, {})), *found]
    notes = [ENDS.format(deviations=SIGMAS)] if len(left_out) < len(tolerances) else []
    notes += [LEFT_OUT.format(names=", ".join(left_out))] if left_out else []
    return (WorstCase(by, tuple(found)) if found else None), notes


def _greatest(tolerance: Tolerance, end: float) -> Iterator[tuple[str, Array]]:
    """The largest clearance of each joint that the tolerance names."""
    for place in tolerance.nominal:
        yield str(place[1]), np.maximum(tolerance.samples(place, np.asarray(end)), 0.0)


def _limit(by: PositionSensitivity, tolerance: Tolerance, ends: tuple[float, float]) -> Limit | None:
    """Limit of a tolerance of points and reference values of drives; None if it has other numbers."""
    total: Array | float = 0.0
    for place, nominal in tolerance.nominal.items():
        column = _column(by, place)
        if column is None:
            return None
        total = total + (nominal * column if tolerance.relative else column)
    start = 0.0 if tolerance.relative else next(iter(tolerance.nominal.values()))
    radius, middle = 0.5 * (ends[1] - ends[0]), 0.5 * (ends[1] + ends[0]) - start
    return Limit(", ".join(tolerance.names), np.asarray(total)[..., None], np.asarray(radius), np.asarray(middle))


def _column(by: PositionSensitivity, place: Place) -> Array | None:
    """Derivative of the point's position by a number of the file, (..., 6 or more); None if it has none."""
    match place:
        case ("points", str(point), int(axis)):
            return by.points[point][..., axis]
        case ("joints", str(joint), "reference", *rest):
            kind, driven = by.linkage.joint(joint).kind, by.linkage.drives.get(joint, ())
            coordinate = kind.coordinates[int(rest[0]) if rest else 0]
            # at a given value of the drive, a larger reference value means less motion from the reference configuration
            return -by.drives[joint][..., driven.index(coordinate)] if coordinate in driven else None
    return None
