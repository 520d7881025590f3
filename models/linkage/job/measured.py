"""Measured positions of a point beside what the job predicts for them, with the band of the tolerances."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ....framework.batch import Array
from ....framework.errors import FrameError
from ...job.tables import markdown, readable, separated
from ...measured.comparison import Comparison, compare
from ...measured.table import Measured, read_measured
from ..files.source import Source, shown_value
from ..linkage import Linkage

LEVEL = 0.95
AXES = "xyz"
# Poses that the report names and shows; the table beside it has all.
MOST_NAMED, MOST_SHOWN = 8, 40

TABLE = """\
Measured less predicted position of {point}, in mm, and over its standard uncertainty, that of the measurement and of
the tolerances together. The prediction is the mean of the samples, or without tolerances the displaced position of the
linkage as the file has it. A pose is outside where the sum of squares of its normalised residuals is greater than that
of {level:g} % of the poses. All at full precision: `measured.csv`."""


@dataclass(frozen=True, eq=False)
class MeasuredPoint:
    """What was measured, and of which point.

    Attributes
    ----------
    file
        The table.
    point
        The point.
    level
        Probability with which a pose should lie within its band.
    table
        What it holds.
    """

    file: Path
    point: str
    level: float
    table: Measured


@dataclass(frozen=True, eq=False)
class MeasuredOutcome:
    """Measured positions beside predicted ones.

    Attributes
    ----------
    given
        What was measured.
    drives
        Values of the drives at the measured poses by their names in the tables, (poses,) each.
    predicted
        Position that the job predicts, (poses, 3).
    comparison
        Residuals and what lies outside.
    """

    given: MeasuredPoint
    drives: Mapping[str, Array]
    predicted: Array
    comparison: Comparison

    @classmethod
    def of(
        cls, given: MeasuredPoint, drives: Mapping[str, Array], predicted: Array, deviation: Array
    ) -> MeasuredOutcome:
        """From the prediction and its standard deviation, (poses, 3) each."""
        found = compare(predicted, given.table, deviation=np.nan_to_num(deviation), level=given.level)
        if not found.count:
            raise FrameError(f"no measured pose of {given.point} has a predicted position: check drives and their unit")
        return cls(given, drives, predicted, found)

    def as_csv(self) -> str:
        """All at full precision, one row a pose."""
        found = self.comparison
        vectors = {
            "measured": self.given.table.position,
            "predicted": self.predicted,
            "residual": found.residual,
            "uncertainty": np.where(np.isfinite(found.residual), found.uncertainty, np.nan),
            "normalised": found.normalised,
        }
        columns = {f"{name}_{axis}": each[:, k] for name, each in vectors.items() for k, axis in enumerate(AXES)}
        numbers = np.column_stack([*self.drives.values(), *columns.values()]).tolist()
        rows = ([*row, "outside" if off else ""] for row, off in zip(numbers, found.outside.tolist(), strict=True))
        return separated([*self.drives, *columns, "band"], rows)

    def in_words(self) -> str:
        """Chi squared, and which poses lie outside."""
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
        found = self.comparison
        yield "## Measured"
        yield self.in_words()
        yield TABLE.format(point=self.given.point, level=100.0 * found.level)
        there = [k for k in range(3) if np.isfinite(found.residual[:, k]).any()]
        heading = [*self.drives, *(f"{name} {AXES[k]}" for name in ("residual", "normalised") for k in there), "band"]
        normalised = np.where(np.isfinite(found.residual), found.normalised, np.nan)
        rows = []
        for pose in range(min(len(found.outside), MOST_SHOWN)):
            cells = [f"{values[pose]:g}" for values in self.drives.values()]
            cells += [readable(float(1e3 * found.residual[pose, k]), ".4g") for k in there]
            cells += [readable(float(normalised[pose, k]), ".2f") for k in there]
            rows.append([*cells, "outside" if found.outside[pose] else ""])
        yield markdown(heading, rows)
        if len(found.outside) > MOST_SHOWN:
            yield f"{len(found.outside) - MOST_SHOWN} more in `measured.csv`."

    def _where(self, pose: int) -> str:
        return ", ".join(f"{name} = {values[pose]:g}" for name, values in self.drives.items())


def read_measured_point(source: Source, linkage: Linkage, points: tuple[str, ...]) -> MeasuredPoint | None:
    """What the table ``[measured]`` of a file says; None where there is none.

    Raises
    ------
    FrameError
        With the line of what is wrong.
    """
    if "measured" not in source.data:
        return None
    table = source.table(("measured",), ("file",), ("point", "level"))
    path = source.file.parent / source.text_at(("measured", "file"))
    level = source.number(("measured", "level")) if "level" in table else LEVEL
    if not 0.0 < level < 1.0:
        source.fail(("measured", "level"), f"is {shown_value(level)}: give a probability between 0 and 1, such as 0.95")
    point = source.text_at(("measured", "point"), linkage.points) if "point" in table else points[0]
    if not any(point in link.points for link in linkage.links.values()):
        source.fail(("measured", "point"), f"no link has the point {point!r}: add it to the link that carries it")
    with source.at("measured"):
        try:
            return MeasuredPoint(path, point, level, read_measured(path))
        except FrameError as error:
            source.fail(("measured", "file"), str(error))
