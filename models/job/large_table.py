"""What large displacement makes of the spread, in a table, and of which samples, in words."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from .outcome import Outcome
from .remarks import without_equilibrium
from .tables import aligned, markdown, with_error

EXPLAINED = """\
Mean and standard deviation of the position of {point} over the samples, in metres, by linear mechanics and at large
displacement, at the poses that are singular or at which the two differ by a tenth of the spread; in brackets the
standard error of the last digits. Large displacement takes each sample's links, joints and clearances to the stable
equilibrium to which its load leads; `{file}` holds it for all poses."""
HEADING = "Where linear mechanics does not hold, beside the samples at large displacement:"


def failed_samples(outcome: Outcome) -> list[str]:
    """Sentences where large displacement is not that of all samples."""
    return [*_first(outcome), *_lost(outcome)]


def _lost(outcome: Outcome) -> list[str]:
    """How many samples came to no equilibrium, and at which poses."""
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
    """Pose, linear and large means and deviations, their standard errors, and the status, of the poses that need it.

    Those are the poses that can be assembled and at which linear mechanics does not hold.
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
    """Paragraphs for a terminal of that width; none where no pose needs the table."""
    found = as_text(outcome, width)
    return [HEADING, found] if found else []


def as_text(outcome: Outcome, width: int | None = None) -> str:
    """The table for a terminal of that width; empty where no pose needs it."""
    found = _cells(outcome)
    return aligned([_heading(outcome), *found], width) if found else ""


def section(outcome: Outcome, point: str, file: str) -> list[str]:
    """The section of the report on a point, whose full table is in a file."""
    return ["### Large displacement", EXPLAINED.format(point=point, file=file), as_markdown(outcome)]


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
