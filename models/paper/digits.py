"""How many digits of each column of Table 1 are certain."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..job.tables import markdown

if TYPE_CHECKING:
    from .result import Result

Array = NDArray[np.float64]

EPS = float(np.finfo(np.float64).eps)
# Roundings in the position of a point by the closed form, for the sum of the lengths it is made of.
CLOSED_FORM = 8.0
# Displacements of the frame's eight nodes: the size of the matrix that the condition number is of.
SIZE = 48

EXPLAINED = """\
Numerical error, of the poses that are regular: `μ` and `σ` by the error bounds of all samples, `κ` by Weyl's theorem.
These digits are those of the samples that were drawn; how near their mean and deviation are to those of the whole
population is told by the standard error by sampling, which is far greater and falls with the square root of the number
of samples. How far linear mechanics holds is another matter (see the status)."""


def certain_digits(result: Result) -> Iterator[tuple[str, float, int, float]]:
    """By column: its greatest absolute error, and the fewest significant digits that are certain with the pose.

    Parameters
    ----------
    result
        The run.

    Yields
    ------
    tuple
        Name, bound on the error, digits, drive angle in degrees.
    """
    regular = result.regular
    bound = result.error_bound[regular]
    inputs = result.inputs
    place = np.full(bound.shape, CLOSED_FORM * EPS * (inputs.crank + inputs.ground + inputs.coupler + inputs.rocker))
    spread = bound * np.sqrt(inputs.samples / max(inputs.samples - 1, 1))
    columns = {
        "x": (result.rigid[regular, 0], place[:, 0]),
        "y": (result.rigid[regular, 1], place[:, 1]),
        "μ_x": (result.mean[regular, 0], place[:, 0] + bound[:, 0]),
        "μ_y": (result.mean[regular, 1], place[:, 1] + bound[:, 1]),
        "σ_x": (result.std[regular, 0], spread[:, 0]),
        "σ_y": (result.std[regular, 1], spread[:, 1]),
        "κ": (result.kappa[regular], SIZE * EPS * result.kappa[regular] ** 2),
        "κ scaled": (result.kappa_scaled[regular], SIZE * EPS * result.kappa_scaled[regular] ** 2),
    }
    for name, (value, error) in columns.items():
        if np.isnan(value).any():
            continue
        size = np.maximum(np.abs(value), np.finfo(float).tiny)
        digits = np.clip(np.floor(-np.log10(np.maximum(error / size, EPS))), 0, 15).astype(int)
        worst = int(np.argmin(digits))
        yield name, float(error.max()), int(digits[worst]), float(result.degrees[regular][worst])


def as_markdown(result: Result) -> str:
    """The digits as a table for the report, and beside them what sampling leaves uncertain."""
    sampling = _sampling_errors(result)
    rows = [
        [name, f"{error:.1e}", str(digits), f"{pose:g}°", sampling.get(name, "–")]
        for name, error, digits, pose in certain_digits(result)
    ]
    heading = ["column", "greatest numerical error", "digits free of it", "fewest at θ", "standard error by sampling"]
    return markdown(heading, rows, left=1)


def _sampling_errors(result: Result) -> dict[str, str]:
    """Least and greatest standard error over the regular poses of each sampled column."""
    columns = {"μ": result.standard_error, "σ": result.std_standard_error}
    return {
        f"{name}_{'xy'[axis]}": f"{errors[result.regular, axis].min():.1e} … {errors[result.regular, axis].max():.1e}"
        for name, errors in columns.items()
        for axis in (0, 1)
    }
