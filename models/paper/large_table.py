"""What large displacement makes of the spread, in a table, and of which samples, in words."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..job.remarks import without_equilibrium
from ..job.tables import aligned, markdown, readable, with_error
from .result import Result

HEADING = ("θ", *(f"{name} {way}" for way in ("linear", "large") for name in ("μ_x", "μ_y", "σ_x", "σ_y")), "status")
# Samples of a pose that are named one by one.
MOST_NAMED = 5
EXPLAINED = """\
Mean and standard deviation of the position of P over the samples, in metres, by linear mechanics and at large
displacement, at the poses that are singular or at which the two differ by a tenth of the spread; in brackets the
standard error of the last digits. Large displacement takes each sample's links, joints and clearances to the stable
equilibrium to which its load leads; `table1.csv` holds it for all poses."""


def told(result: Result) -> list[str]:
    """Sentences where large displacement is not that of all samples."""
    return [*_first(result), *_lost(result)]


def _lost(result: Result) -> list[str]:
    """How many samples came to no equilibrium, and at which poses."""
    large = result.large
    lost = np.isnan(large.samples[..., 0]) & result.closes[:, None]
    at = [f"θ = {result.degrees[pose]:g}°" for pose in np.flatnonzero(lost.any(axis=1))]
    return without_equilibrium(int(lost.sum()), (len(lost), large.n), at, result.inputs.nan_policy)


def _first(result: Result) -> list[str]:
    n, samples = result.large.n, result.inputs.samples
    if n == samples:
        return []
    return [
        f"Large displacement is that of the first {n} of the {samples} samples, as each of them takes as "
        "long as hundreds by linear mechanics; where the two are compared, it is on the same samples."
    ]


def passages(result: Result) -> Iterator[str]:
    """A sentence for each pose at which samples ended near the other branch, and what they do to the spread."""
    large = result.large
    for pose in np.flatnonzero(large.passed.any(axis=1)):
        passed, moved = large.passed[pose], large.samples[pose, :, :2]
        others = moved[~passed & np.isfinite(moved).all(axis=-1)]
        rest = others.std(axis=0, ddof=1) if len(others) > 1 else np.full(2, np.nan)
        numbers = np.flatnonzero(passed)
        named = ", ".join(map(str, numbers[:MOST_NAMED])) + (" ..." if len(numbers) > MOST_NAMED else "")
        farthest = 1e3 * np.linalg.norm(moved[passed], axis=-1).max()
        without = " and ".join(readable(value, ".2e") for value in rest)
        one = len(numbers) == 1
        yield (
            f"At {result.degrees[pose]:g}° {len(numbers)} of {len(passed)} samples at large displacement"
            f" {'has' if one else 'have'} passed through the line of coupler and rocker and {'ends' if one else 'end'}"
            f" on the side of the other branch, P up to {farthest:.1f} mm from its rigid position (number {named} of"
            f" samples.npz, counted from 0); without {'it' if one else 'them'} σ_x and σ_y are {without} m."
        )


def rows(result: Result) -> Iterator[tuple[float, list[float], list[float], str]]:
    """Angle, linear and large means and deviations, their standard errors, and the status, of the poses that need it.

    Those are the poses that can be assembled and at which linear mechanics does not hold.
    """
    large = result.large
    numbers = (result.mean, result.std, result.rigid + large.mean, large.std)
    errors = (result.standard_error, result.std_standard_error, large.standard_error, large.std_standard_error)
    needed = result.assembled & (result.marked_status != "regular")
    values, doubts = (np.hstack([each[needed, :2] for each in columns]).tolist() for columns in (numbers, errors))
    yield from zip(result.degrees[needed].tolist(), values, doubts, result.marked_status[needed].tolist(), strict=True)


def as_text(result: Result) -> str:
    """The table for a terminal; empty where no pose needs it."""
    found = _cells(result)
    return aligned([HEADING, *found]) if found else ""


def as_markdown(result: Result) -> str:
    """The table for the report."""
    found = _cells(result)
    return markdown(HEADING, found) if found else "Linear mechanics holds at all poses."


def _cells(result: Result) -> list[list[str]]:
    return [
        [f"{angle:g}°", *(with_error(*each) for each in zip(values, doubts, _FORMS, strict=True)), status]
        for angle, values, doubts, status in rows(result)
    ]


_FORMS = (*["z.6f"] * 2, *[".2e"] * 2) * 2
