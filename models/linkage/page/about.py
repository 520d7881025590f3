"""Texts of a page on the origin of its numbers: inputs, and how many digits are certain."""

from __future__ import annotations

import math

import numpy as np

from ....framework.errors import FrameError
from ..files.toml import written
from ..files.write import tables
from ..statics.frame import FramedPoses
from .data import driven

CERTAIN = (
    "Positions are closed to rounding and written to 12 digits. The table has a bound on the numerical error of the "
    "deflection at each pose. Worst cases are exact to first order in clearances and tolerances."
)
# Largest number of characters of the inputs on a page, and of linkages in a batch that are described.
ROOM, MEMBERS = 20_000, 100


def about(motion: FramedPoses) -> list[tuple[str, str]]:
    """Headings and texts: the linkage in the format of its files with the range of its drives; the certain digits."""
    return [("Inputs", f"{_drives(motion)}\n{_described(motion)}"), ("Certainty of digits", CERTAIN)]


def _drives(motion: FramedPoses) -> str:
    """The range of each drive, as comments of a file."""
    rows = [f"# {motion.shape[0]} poses"]
    for joint in motion.linkage.drives:
        values = driven(motion, joint)
        rows.append(f"# drive {joint}: {np.nanmin(values):.6g} to {np.nanmax(values):.6g}, radians or a length")
    return "\n".join(rows)


def _described(motion: FramedPoses) -> str:
    if math.prod(motion.linkage.shape) > MEMBERS:
        return f"# {motion.linkage!r}, of which each pose is another"
    try:
        text = written(tables(motion.linkage))
    except FrameError as error:
        return f"# The linkage is described in Python: {error}"
    return text if len(text) <= ROOM else f"{text[:ROOM]}\n# and so on: {len(text)} characters"
