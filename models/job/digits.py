"""Number of certain digits of each column of a job's table."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from .outcome import Outcome
from .tables import aligned, markdown

Array = NDArray[np.float64]

EPS = float(np.finfo(np.float64).eps)

EXPLAINED = """\
Numerical error, of the poses that are regular: `μ` and `σ` by the error bounds of all samples, `κ` by Weyl's theorem.
These digits are those of the samples that were drawn; how near their mean and deviation are to those of the whole
population is told by the standard error by sampling, which is far greater and falls with the square root of the number
of samples. How far linear mechanics holds is another matter (see the status)."""


def certain_digits(outcome: Outcome) -> Iterator[tuple[str, float, int, str]]:
    """By column: its largest absolute error, and the fewest certain significant digits with their pose.

    Parameters
    ----------
    outcome
        Outcome of the job.

    Yields
    ------
    tuple
        Name, bound on the error, digits, and the pose in words.
    """
    regular = outcome.regular
    drives = np.array(outcome.drives)[regular]
    for name, (every, errors) in _columns(outcome).items():
        value, error = every[regular], np.broadcast_to(errors, every.shape)[regular]
        if not value.size or np.isnan(value).any() or np.isnan(error).any():
            continue
        size = np.maximum(np.abs(value), np.finfo(float).tiny)
        digits = np.clip(np.floor(-np.log10(np.maximum(error / size, EPS))), 0, 15).astype(int)
        worst = int(np.argmin(digits))
        yield name, float(error.max()), int(digits[worst]), str(drives[worst])


def _columns(outcome: Outcome) -> dict[str, tuple[Array, Array]]:
    """By name of a column: its values and bounds on their errors, (poses,) each."""
    bound, place = outcome.error_bound, np.asarray(outcome.place_error)
    widened = bound * np.sqrt(outcome.count / max(outcome.count - 1, 1))
    means, moved = (outcome.mean, place + bound), (outcome.mean - outcome.rigid, bound)
    whole = {"": (outcome.rigid, place), "μ_": means} if np.isfinite(place) else {"u_": moved}
    if outcome.count > 1:
        whole["σ_"] = outcome.std, widened
    found = {
        f"{name}{'xyz'[k]}": (value[:, k], error[:, k] if error.ndim else error)
        for name, (value, error) in whole.items()
        for k in outcome.axes
    }
    for name, kappa in (("κ", outcome.kappa), ("κ scaled", outcome.kappa_scaled)):
        found[name] = kappa, outcome.unknowns * EPS * kappa**2
    return found


def section(outcome: Outcome) -> list[str]:
    """The section of the report."""
    return ["### Digits", EXPLAINED, as_markdown(outcome)]


def as_markdown(outcome: Outcome) -> str:
    """Table of the certain digits for the report, with the standard errors of sampling."""
    heading, rows = _table(outcome)
    return markdown(heading, rows, left=1)


def as_text(outcome: Outcome) -> str:
    """The table with its explanation, for a page that is not in Markdown."""
    heading, rows = _table(outcome)
    return "\n\n".join([EXPLAINED.replace("`", ""), aligned([heading, *rows])])


def _table(outcome: Outcome) -> tuple[list[str], list[list[str]]]:
    """Heading and rows."""
    sampling = _sampling_errors(outcome)
    rows = [
        [name, f"{error:.1e}", str(digits), pose, sampling.get(name, "–")]
        for name, error, digits, pose in certain_digits(outcome)
    ]
    least = f"fewest at {outcome.heading}"
    return ["column", "greatest numerical error", "digits free of it", least, "standard error by sampling"], rows


def _sampling_errors(outcome: Outcome) -> dict[str, str]:
    """Least and largest standard error of each sampled column over the regular poses."""
    if outcome.count < 2 or not outcome.regular.any():
        return {}
    columns = {"μ": outcome.standard_error, "u": outcome.standard_error, "σ": outcome.std_standard_error}
    return {
        f"{name}_{'xyz'[axis]}": f"{each[:, axis].min():.1e} … {each[:, axis].max():.1e}"
        for name, errors in columns.items()
        for each in [errors[outcome.regular]]
        for axis in outcome.axes
    }
