"""Table 1: mean and spread of P at every pose, beside the values that the paper prints."""

from __future__ import annotations

import csv
from collections.abc import Iterator
from dataclasses import dataclass
from importlib.resources import files
from io import StringIO
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..job.tables import aligned, markdown, readable, separated, with_error

if TYPE_CHECKING:
    from .result import Result

Array = NDArray[np.float64]

COLUMNS = ("theta_deg", "x_m", "y_m", "mu_x_m", "mu_y_m", "sigma_x_m", "sigma_y_m", "kappa", "kappa_scaled", "status")
ERROR_COLUMNS = tuple(f"se_{name}" for name in ("mu_x_m", "mu_y_m", "sigma_x_m", "sigma_y_m"))
LARGE_COLUMNS = ("large_mu_x_m", "large_mu_y_m", "large_sigma_x_m", "large_sigma_y_m")
PRINTED_COLUMNS = ("mu_x", "mu_y", "sigma_x", "sigma_y", "kappa")


# x in the paper's linkage from which its means of x are measured, and decimals that it prints, metres.
ORIGIN, DIGITS = 0.1, 4


@dataclass(frozen=True, eq=False)
class Printed:
    """Table 1 of the paper, under the headings that fit its numbers; each array is (rows,).

    The paper heads its columns μ_x, μ_y, σ_x, σ_y. The numbers are, in this order, μ_x − l, σ_x, μ_y, σ_y: the third
    is negative below the ground line and follows l sin θ, as no standard deviation can.

    Attributes
    ----------
    theta
        Drive angles, degrees.
    mean_x, mean_y
        Means of the position of P, metres, from A. The paper prints the first from x = l.
    std_x, std_y
        Standard deviations of the position of P, metres.
    kappa
        Condition numbers.
    """

    theta: Array
    mean_x: Array
    mean_y: Array
    std_x: Array
    std_y: Array
    kappa: Array

    @property
    def regular(self) -> NDArray[np.bool_]:
        """Rows that are not round-off: drive angles that are no multiple of 180°, (rows,)."""
        return np.asarray(self.theta % 180.0 != 0.0)

    def row(self, degrees: float) -> tuple[float, ...] | None:
        """Values in the order of `PRINTED_COLUMNS` at a drive angle in degrees; None where none are printed."""
        found = np.flatnonzero(np.isclose(self.theta, degrees, rtol=0.0, atol=1e-9))
        if not found.size:
            return None
        columns = (self.mean_x, self.mean_y, self.std_x, self.std_y, self.kappa)
        return tuple(float(column[found[0]]) for column in columns)


def printed() -> Printed:
    """Table 1 as printed, read from the data that ships with the package.

    Returns
    -------
    Printed
        The table under its corrected headings.

    Examples
    --------
    >>> printed().row(30.0)
    (0.1889, 0.0499, 0.0003, 0.0004, 568990000.0)
    """
    text = files(__package__).joinpath("data/table1.csv").read_text(encoding="utf-8")
    columns = {
        name: np.array(values, dtype=np.float64) for name, *values in zip(*csv.reader(StringIO(text)), strict=True)
    }
    return Printed(
        theta=columns["theta_deg"],
        mean_x=np.round(columns["mu_x_printed"] + ORIGIN, DIGITS),
        std_x=columns["mu_y_printed"],
        mean_y=columns["sigma_x_printed"],
        std_y=columns["sigma_y_printed"],
        kappa=columns["kappa_printed"],
    )


def about_errors(result: Result) -> str:
    """What the standard errors in the tables are, and what they have in common."""
    return (
        "In brackets: one standard error of sampling, in units of the last digit. All poses share the same"
        f" {result.inputs.samples} draws, so that their sampling errors go together: a trend along the column may be"
        " that of the draws."
    )


def rows(result: Result) -> Iterator[tuple[float | str | None, ...]]:
    """Rows of the table: `COLUMNS`, then `PRINTED_COLUMNS` (None where the paper prints nothing)."""
    table = printed() if result.inputs.is_paper_linkage else None
    numbers = np.column_stack(
        [result.degrees, result.rigid[:, :2], result.mean[:, :2], result.std[:, :2], result.kappa, result.kappa_scaled]
    )
    for values, status in zip(numbers.tolist(), result.marked_status.tolist(), strict=True):
        beside = table.row(values[0]) if table else None
        yield (*values, status, *(beside or (None,) * len(PRINTED_COLUMNS)))


def as_csv(result: Result) -> str:
    """The table as comma-separated values at full precision; NaN and what is not printed stay empty."""
    large = result.large
    names = (*LARGE_COLUMNS, *(f"se_{name}" for name in LARGE_COLUMNS))
    beside = [result.rigid + large.mean, large.std, large.standard_error, large.std_standard_error]
    errors = [result.standard_error, result.std_standard_error]
    numbers = np.hstack([each[:, :2] for each in (*beside, *errors)]).tolist()
    heading = [*COLUMNS, *(f"printed_{name}" for name in PRINTED_COLUMNS), *names, *ERROR_COLUMNS]
    return separated(heading, [(*row, *more) for row, more in zip(rows(result), numbers, strict=True)])


def as_text(result: Result) -> str:
    """The table for a terminal, metres and degrees; right of the bar what the paper prints."""
    lines = [[*ours, *(["│", *theirs] if theirs else []), status] for ours, theirs, status in _cells(result)]
    return aligned(lines)


def as_markdown(result: Result) -> str:
    """The table for the report, metres and degrees."""
    heading, *body = ([*ours, *theirs, status] for ours, theirs, status in _cells(result, mark="printed "))
    return markdown(heading, body)


def _cells(result: Result, mark: str = "") -> Iterator[tuple[list[str], list[str], str]]:
    """A heading, then a row a pose: this run's numbers, the printed ones, the status."""
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
