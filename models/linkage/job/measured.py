"""The table ``[measured]`` of a file: measured positions of a point."""

from __future__ import annotations

from ....framework.errors import FrameError
from ...job.measured import LEVEL, MeasuredPoint
from ...measured.table import read_measured
from ..files.source import Source, shown_value
from ..linkage import Linkage


def read_measured_point(source: Source, linkage: Linkage, points: tuple[str, ...]) -> MeasuredPoint | None:
    """Measured positions of the table ``[measured]`` of a file; None if there is none.

    Raises
    ------
    FrameError
        If something is wrong; the message names the line.
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
