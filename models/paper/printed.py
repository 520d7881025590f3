"""Table 1 as the paper prints it, under the headings that fit its numbers."""

from __future__ import annotations

import csv
from dataclasses import dataclass
from importlib.resources import files
from io import StringIO

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

PRINTED_COLUMNS = ("mu_x", "mu_y", "sigma_x", "sigma_y", "kappa")

# x from which the paper's means of x are measured, metres, and number of decimals that it prints.
ORIGIN, DIGITS = 0.1, 4


@dataclass(frozen=True, eq=False)
class Printed:
    """Table 1 of the paper, under the headings that fit its numbers; each array is (rows,).

    The paper's headings are μ_x, μ_y, σ_x, σ_y. The numbers are, in this order, μ_x − l, σ_x, μ_y, σ_y: the third is
    negative below the ground line and follows l sin θ, which a standard deviation cannot.

    Attributes
    ----------
    theta
        Drive angles, degrees.
    mean_x, mean_y
        Means of the position of P, metres, measured from A. The paper measures x from x = l.
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
        """Rows that are not round-off: those with drive angles that are not multiples of 180°, (rows,)."""
        return np.asarray(self.theta % 180.0 != 0.0)

    def row(self, degrees: float) -> tuple[float, ...] | None:
        """Values in the order of `PRINTED_COLUMNS` at a drive angle in degrees; None if it is not printed."""
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
        The table with corrected headings.

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
