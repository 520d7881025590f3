"""Table 1: mean and spread of P at every pose, and the values that the paper prints."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from ..job.tables import BAR, aligned, markdown, readable, separated, with_error
from .printed import PRINTED_COLUMNS, printed

if TYPE_CHECKING:
    from .result import Result

COLUMNS = ("theta_deg", "x_m", "y_m", "mu_x_m", "mu_y_m", "sigma_x_m", "sigma_y_m", "kappa", "kappa_scaled", "status")
ERROR_COLUMNS = tuple(f"se_{name}" for name in ("mu_x_m", "mu_y_m", "sigma_x_m", "sigma_y_m"))
LARGE_COLUMNS = ("large_mu_x_m", "large_mu_y_m", "large_sigma_x_m", "large_sigma_y_m")


def about_errors(result: Result) -> str:
    """Explanation of the standard errors in the tables, which are correlated over the poses."""
    return (
        "In brackets: one standard error of sampling, in units of the last digit. All poses share the same"
        f" {result.inputs.samples} draws, so that their sampling errors go together: a trend along the column may be"
        " that of the draws."
    )


def rows(result: Result) -> Iterator[tuple[float | str | None, ...]]:
    """Rows of the table: `COLUMNS`, then `PRINTED_COLUMNS` (None at poses that are not printed)."""
    table = printed() if result.inputs.is_paper_linkage else None
    numbers = np.column_stack(
        [result.degrees, result.rigid[:, :2], result.mean[:, :2], result.std[:, :2], result.kappa, result.kappa_scaled]
    )
    for values, status in zip(numbers.tolist(), result.marked_status.tolist(), strict=True):
        beside = table.row(values[0]) if table else None
        yield (*values, status, *(beside or (None,) * len(PRINTED_COLUMNS)))


def as_csv(result: Result) -> str:
    """The table as comma-separated values at full precision; NaN and values that are not printed are empty."""
    large = result.large
    names = (*LARGE_COLUMNS, *(f"se_{name}" for name in LARGE_COLUMNS))
    beside = [result.rigid + large.mean, large.std, large.standard_error, large.std_standard_error]
    errors = [result.standard_error, result.std_standard_error]
    numbers = np.hstack([each[:, :2] for each in (*beside, *errors)]).tolist()
    heading = [*COLUMNS, *(f"printed_{name}" for name in PRINTED_COLUMNS), *names, *ERROR_COLUMNS]
    return separated(heading, [(*row, *more) for row, more in zip(rows(result), numbers, strict=True)])


def as_text(result: Result, width: int | None = None) -> str:
    """The table for a terminal of the given width, metres and degrees, with the paper's values right of the bar."""
    lines = [[*ours, *([BAR, *theirs] if theirs else []), status] for ours, theirs, status in _cells(result)]
    return aligned(lines, width)


def as_markdown(result: Result) -> str:
    """The table for the report, metres and degrees."""
    heading, *body = ([*ours, *theirs, status] for ours, theirs, status in _cells(result, mark="printed "))
    return markdown(heading, body)


def _cells(result: Result, mark: str = "") -> Iterator[tuple[list[str], list[str], str]]:
    """The heading, then a row for each pose: this run's numbers, the printed ones, the status."""
    names = ["θ", "x", "y", "μ_x", "μ_y", "σ_x", "σ_y", "κ", "κ scaled"]
    beside = [f"{mark}{name}" for name in ("μ_x", "μ_y", "σ_x", "σ_y", "κ")] if result.inputs.is_paper_linkage else []
    yield names, beside, "status"
    shown = ["g", *["z.6f"] * 4, *[".2e"] * 4]
    sampled = np.hstack([result.standard_error[:, :2], result.std_standard_error[:, :2]]).tolist()
    for row, errors in zip(rows(result), sampled, strict=True):
        numbers, status, theirs = row[: len(names)], str(row[len(names)]), row[len(names) + 1 :]
        beside_them = [np.nan] * 3 + errors + [np.nan] * 2
        yield (
            [with_error(*each) for each in zip(map(_number, numbers), beside_them, shown, strict=True)],
            [readable(value, ".4g") for value in theirs[: len(beside)]],
            status,
        )


def _number(value: float | str | None) -> float:
    assert isinstance(value, float)
    return value
