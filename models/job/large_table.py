"""Table of the spread at large displacement, and sentences on its samples and on those that pass a singular pose."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from .outcome import Outcome
from .remarks import without_equilibrium
from .tables import aligned, markdown, readable, with_error

EXPLAINED = """\
Mean and standard deviation of the position of {point} over the samples, in metres, by linear mechanics and at large
displacement, at the poses that are singular or at which the two differ by a tenth of the spread; in brackets the
standard error of the last digits. Large displacement takes each sample's links, joints and clearances to the stable
equilibrium to which its load leads; `{file}` holds it for all poses."""
HEADING = "Where linear mechanics does not hold, beside the samples at large displacement:"
# Largest number of samples of a pose that are named individually.
MOST_NAMED = 5


def failed_samples(outcome: Outcome) -> list[str]:
    """Sentences on samples without large displacement: those left out, and those without an equilibrium."""
    return [*_first(outcome), *_lost(outcome)]


def _lost(outcome: Outcome) -> list[str]:
    """Sentence on the samples without an equilibrium, and their poses."""
    large = outcome.large
    lost = np.isnan(large.samples[..., 0]) & outcome.closes[:, None]
    at = [f"{outcome.heading} = {outcome.drives[pose]}" for pose in np.flatnonzero(lost.any(axis=1))]
    return without_equilibrium(int(lost.sum()), (len(lost), large.n), at, outcome.nan_policy)


def _first(outcome: Outcome) -> list[str]:
    n, samples = outcome.large.n, outcome.count
    if n == samples:
        return []
    return [
        f"Large displacement is that of the first {n} of the {samples} samples, as each of them takes as "
        "long as hundreds by linear mechanics; where the two are compared, it is on the same samples."
    ]


def rows(outcome: Outcome) -> Iterator[tuple[str, list[float], list[float], str]]:
    """Rows for the assembled poses outside the linear range.

    Pose, means and deviations by linear mechanics and at large displacement, their standard errors, and the status.
    """
    large, shown, step = outcome.large, list(outcome.axes), 1 if outcome.count > 1 else 2
    numbers = (outcome.mean, outcome.std, outcome.rigid + large.mean, large.std)[::step]
    errors = (outcome.standard_error, outcome.std_standard_error, large.standard_error, large.std_standard_error)
    needed = np.flatnonzero(outcome.assembled & (outcome.marked_status != "regular"))
    values, uncertainties = (
        np.hstack([each[needed][:, shown] for each in columns]) for columns in (numbers, errors[::step])
    )
    for row, pose in enumerate(needed):
        yield outcome.drives[pose], values[row].tolist(), uncertainties[row].tolist(), str(outcome.marked_status[pose])


def passage(outcome: Outcome, width: int | None = None) -> list[str]:
    """Paragraphs for a terminal of the given width, without a table if no pose needs it."""
    found = as_text(outcome, width)
    return [*([HEADING, found] if found else []), *passages(outcome)]


def as_text(outcome: Outcome, width: int | None = None) -> str:
    """The table for a terminal of the given width; empty if no pose needs it."""
    found = _cells(outcome)
    return aligned([_heading(outcome), *found], width) if found else ""


def section(outcome: Outcome, file: str) -> list[str]:
    """The section of the report; the full table is in `file`."""
    explained = EXPLAINED.format(point=outcome.point, file=file)
    return ["### Large displacement", explained, as_markdown(outcome), *passages(outcome)]


def as_markdown(outcome: Outcome) -> str:
    """The table for the report."""
    found = _cells(outcome)
    return markdown(_heading(outcome), found) if found else "Linear mechanics holds at all poses."


def _heading(outcome: Outcome) -> list[str]:
    kinds = ("μ_", "σ_") if outcome.count > 1 else ("",)
    names = (f"{name}{'xyz'[axis]} {way}" for way in ("linear", "large") for name in kinds for axis in outcome.axes)
    return [outcome.heading, *names, "status"]


def _cells(outcome: Outcome) -> list[list[str]]:
    width = len(outcome.axes)
    forms = (*["z.6f"] * width, *[".2e"] * width * (outcome.count > 1)) * 2
    return [
        [drive, *(with_error(*each) for each in zip(values, uncertainties, forms, strict=True)), status]
        for drive, values, uncertainties, status in rows(outcome)
    ]


def passages(outcome: Outcome) -> Iterator[str]:
    """A sentence for each pose at which samples pass to the other branch, with the spread of the others."""
    large, axes = outcome.large, list(outcome.axes)
    names = " and ".join(f"σ_{'xyz'[axis]}" for axis in axes)
    for pose in np.flatnonzero(large.passed.any(axis=1)):
        passed, moved = large.passed[pose], large.samples[pose][:, axes]
        others = moved[~passed & np.isfinite(moved).all(axis=-1)]
        rest = others.std(axis=0, ddof=1) if len(others) > 1 else np.full(len(axes), np.nan)
        numbers = np.flatnonzero(passed)
        named = ", ".join(map(str, numbers[:MOST_NAMED])) + (" ..." if len(numbers) > MOST_NAMED else "")
        farthest = 1e3 * np.linalg.norm(moved[passed], axis=-1).max()
        without = " and ".join(readable(value, ".2e") for value in rest)
        one = len(numbers) == 1
        yield (
            f"At {outcome.drives[pose]} {len(numbers)} of {len(passed)} samples at large displacement"
            f" {'has' if one else 'have'} passed through {outcome.singular_place} and {'ends' if one else 'end'}"
            f" on the side of the other branch, {outcome.point} up to {farthest:.1f} mm from its rigid position (number"
            f" {named} of samples.npz, counted from 0); without {'it' if one else 'them'} {names} are {without} m."
        )
