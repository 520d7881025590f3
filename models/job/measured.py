"""Measured positions of a point compared with those that a job predicts, with the band of its tolerances."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ...framework.errors import FrameError
from ..measured.comparison import Comparison, compare
from ..measured.table import Measured
from .tables import aligned, markdown, readable, separated

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

LEVEL = 0.95
AXES = "xyz"
# Largest numbers of poses that the report names and shows; the file has all of them.
MOST_NAMED, MOST_SHOWN = 8, 40
# Factors from the units of drives to radians, and symbols of the units.
UNITS = {"rad": 1.0, "deg": np.pi / 180.0}
SIGNS = {"rad": "rad", "deg": "°"}
# Name of this work in progress messages, file of the table, and file of the figure with its caption.
MEASURED_WAY, TABLE_FILE, FIGURE_FILE = "at measured poses", "measured.csv", "measured.png"
CAPTION = "Measured less predicted position, with the bands of measurement and tolerances together."

TABLE = """\
Measured less predicted position of {point}, in mm, and over its standard uncertainty, that of the measurement and of
the tolerances together. The prediction is the mean of the samples, or without tolerances the displaced position of the
nominal linkage. Chi squared is by the covariance of the components of each pose, as are the poses that are outside:
those whose own is greater than that of {level:g} % of the poses. Poses count as independent, but tolerances move the
linkage alike at all of them: where they outweigh the measurement, p says too much. All at full precision:
`measured.csv`."""


@dataclass(frozen=True, eq=False)
class DriveValues:
    """Values of a driven coordinate.

    Attributes
    ----------
    values
        The coordinate at every pose, in `unit`, (poses,), or (1,) if it is the same at all poses.
    unit
        ``rad``, ``deg``, or empty for a length.
    """

    values: Array
    unit: str

    @property
    def sign(self) -> str:
        """Symbol of the unit for labels."""
        return SIGNS.get(self.unit, "m")

    @property
    def factor(self) -> float:
        """Factor from the unit to radians, or 1 for lengths."""
        return UNITS.get(self.unit, 1.0)


@dataclass(frozen=True, eq=False)
class MeasuredPoint:
    """Measured positions of a point.

    Attributes
    ----------
    file
        File of the table.
    point
        Name of the point.
    level
        Probability with which a pose should lie within its band.
    table
        Contents of the table.
    """

    file: Path
    point: str
    level: float
    table: Measured

    @property
    def about(self) -> list[object]:
        """Everything that the samples at the measured poses depend on."""
        drives = {name: values.tolist() for name, values in self.table.drives.items()}
        return [self.point, len(self.table.position), drives]

    def drive_values(self, drives: Mapping[str, DriveValues]) -> dict[str, Array]:
        """Values of the drives in the table, by name and in their units, (poses,) each.

        Empty if the table has no drives: then its poses are those of the job.

        Parameters
        ----------
        drives
            Drives of the job, by name.

        Raises
        ------
        FrameError
            If the table has a column that is not a drive, one whose unit is not clear or does not fit the drive, no
            column for a drive with several values, or without such columns another number of poses than the job.
        """
        own, name = self.table.drives, self.file.name
        for column in own:
            if column not in drives:
                raise FrameError(
                    f"{name} has a column {column!r}, which is no drive: the drives are {', '.join(drives)}, with the "
                    "unit [deg] or [rad] behind the name of an angle and none behind that of a length"
                )
            _check_unit(name, column, self.table.units.get(column), drives[column].unit)
        for key, drive in drives.items() if own else ():
            if key not in own and len(drive.values) > 1:
                raise FrameError(f"{name} has no column {key!r} with the values of that drive: give it")
        count, poses = len(self.table.position), max(len(drive.values) for drive in drives.values())
        if count != poses and not (own or poses == 1):
            key, drive = next(iter(drives.items()))
            column = f"{key} [deg]" if drive.unit == "deg" else key
            raise FrameError(
                f"{name} has {count} measured poses and no columns with values of drives, and the run has {poses} "
                f"poses: give it a column {column!r}"
            )
        return {key: _as_written(own[key] / drives[key].factor) for key in own}


def _check_unit(name: str, drive: str, given: str | None, wanted: str) -> None:
    """Refuse a column whose unit does not fit the drive, or which has none where the job has degrees."""
    if wanted == "deg" and given == "":
        raise FrameError(
            f"{name} has a column {drive!r} without a unit, and the job has that drive in degrees: name the column "
            f"'{drive} [deg]' or '{drive} [rad]'"
        )
    if not wanted and given:
        raise FrameError(
            f"{name} has a column '{drive} [{given}]', and that drive is a length: name the column {drive!r}, with "
            "lengths in metres"
        )


def _as_written(values: Array) -> Array:
    """Without the rounding of degrees that were turned into radians and back: to 15 digits, 30 and not 29.999..."""
    return np.array([float(f"{value:.15g}") for value in values.tolist()])


@dataclass(frozen=True, eq=False)
class MeasuredOutcome:
    """Measured positions compared with predicted ones.

    Attributes
    ----------
    given
        The measured positions.
    drives
        Drives at the measured poses, by their names in the tables.
    predicted
        Positions that the job predicts, (poses, 3).
    comparison
        Residuals, and the poses outside the band.
    """

    given: MeasuredPoint
    drives: Mapping[str, DriveValues]
    predicted: Array
    comparison: Comparison

    @classmethod
    def of(
        cls, given: MeasuredPoint, drives: Mapping[str, DriveValues], predicted: Array, covariance: Array
    ) -> MeasuredOutcome:
        """Comparison with predicted positions (poses, 3) and their covariance (poses, 3, 3).

        If some direction then has no uncertainty, as with a single tolerance and a measurement without uncertainty, the
        deviations of the components are used instead, as if these were independent.
        """
        spread = np.nan_to_num(covariance)
        try:
            found = compare(predicted, given.table, covariance=spread, level=given.level)
        except FrameError:
            deviation = np.sqrt(np.diagonal(spread, axis1=1, axis2=2))
            found = compare(predicted, given.table, deviation=deviation, level=given.level)
        return cls(given, drives, predicted, found)

    def as_csv(self) -> str:
        """Table with all numbers at full precision, one row for each pose."""
        found = self.comparison
        vectors = {
            "measured": self.given.table.position,
            "predicted": self.predicted,
            "residual": found.residual,
            "uncertainty": np.where(np.isfinite(found.residual), found.uncertainty, np.nan),
            "normalised": found.normalised,
        }
        columns = {f"{name}_{axis}": each[:, k] for name, each in vectors.items() for k, axis in enumerate(AXES)}
        numbers = np.column_stack([*self._values.values(), *columns.values()]).tolist()
        rows = ([*row, "outside" if off else ""] for row, off in zip(numbers, found.outside.tolist(), strict=True))
        drives = (f"{name}_{drive.unit}" if drive.unit else name for name, drive in self.drives.items())
        return separated([*drives, *columns, "band"], rows)

    def in_words(self) -> str:
        """Sentences with chi squared and the poses outside the band."""
        found, point = self.comparison, self.given.point
        outside = np.flatnonzero(found.outside)
        head = (
            f"Measured {point} against the prediction: chi squared {found.chi_squared:.4g} of {found.count} components "
            f"(p = {found.p_value:.2g}), greatest residual {1e3 * np.nanmax(np.abs(found.residual)):.3g} mm; "
        )
        band = f"the {100.0 * found.level:g} % band"
        if not outside.size:
            return f"{head}every pose lies within {band}."
        some = ", ".join(self._where(int(k)) for k in outside[:MOST_NAMED]) + (" ..." * (outside.size > MOST_NAMED))
        return f"{head}{outside.size} of {len(found.outside)} poses outside {band}: {some}."

    def section(self) -> Iterator[str]:
        """Paragraphs of the report."""
        yield "## Measured"
        yield self.in_words()
        yield self._explained
        heading, rows = self._table()
        yield markdown(heading, rows)
        if more := len(self.comparison.outside) - len(rows):
            yield f"{more} more in `{TABLE_FILE}`."

    def as_text(self) -> str:
        """The section for a page that is not in Markdown."""
        heading, rows = self._table()
        return "\n\n".join([self.in_words(), self._explained.replace("`", ""), aligned([heading, *rows])])

    def draw(self) -> Figure:
        """Plot the residuals with their bands, over the drive if only one moves."""
        moved = [name for name, values in self._values.items() if np.ptp(values)]
        over = None
        if len(moved) == 1:
            over = f"{moved[0]} [{self.drives[moved[0]].sign}]", self._values[moved[0]]
        found = self.comparison.plot(over=over).figure
        assert found is not None
        return found  # type: ignore[return-value]

    @property
    def _values(self) -> dict[str, Array]:
        """Values of the drives, (poses,) each."""
        count = len(self.predicted)
        return {name: np.array(np.broadcast_to(drive.values, (count,))) for name, drive in self.drives.items()}

    @property
    def _explained(self) -> str:
        return TABLE.format(point=self.given.point, level=100.0 * self.comparison.level)

    def _table(self) -> tuple[list[str], list[list[str]]]:
        """Heading and rows."""
        found, values = self.comparison, self._values
        there = [k for k in range(3) if np.isfinite(found.residual[:, k]).any()]
        heading = [*values, *(f"{name} {AXES[k]}" for name in ("residual", "normalised") for k in there), "band"]
        rows = []
        for pose in range(min(len(found.outside), MOST_SHOWN)):
            cells = [f"{each[pose]:g}" for each in values.values()]
            cells += [readable(float(1e3 * found.residual[pose, k]), ".4g") for k in there]
            cells += [readable(float(found.normalised[pose, k]), ".2f") for k in there]
            rows.append([*cells, "outside" if found.outside[pose] else ""])
        return heading, rows

    def _where(self, pose: int) -> str:
        signs = {name: "°" if drive.sign == "°" else f" {drive.sign}" for name, drive in self.drives.items()}
        return ", ".join(f"{name} = {values[pose]:g}{signs[name]}" for name, values in self._values.items())
