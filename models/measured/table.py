"""Measured positions of a point, and reading them from a table."""

from __future__ import annotations

import csv
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...framework.batch import numbers
from ...framework.errors import FrameError

Array = NDArray[np.float64]

AXES = ("x", "y", "z")
# Columns in which a cell may be empty.
POSITIONS = (*AXES, *(f"u{axis}" for axis in AXES))


@dataclass(frozen=True, eq=False)
class Measured:
    """Positions of a point, measured at several poses.

    Parameters
    ----------
    position
        Positions (poses, 3), lengths; NaN where a component was not measured.
    uncertainty
        Standard uncertainty of the positions, in a shape that broadcasts to (poses, 3); None if unknown.
    drives
        Values of the drives at the measured poses, by name, (poses,) each, in the drives' units.
    """

    position: Array
    uncertainty: Array | None
    drives: Mapping[str, Array]

    def __post_init__(self) -> None:
        place = checked_positions(self.position)
        object.__setattr__(self, "position", place)
        object.__setattr__(self, "uncertainty", checked_uncertainty(self.uncertainty, place.shape))
        for name, values in self.drives.items():
            if np.shape(values) != place.shape[:1]:
                raise FrameError(
                    f"drive {name!r} has shape {np.shape(values)} for {len(place)} measured poses: one each"
                )
            if missing := np.flatnonzero(~np.isfinite(values)).tolist():
                raise FrameError(f"drive {name!r} has no value at measured pose {missing[0]}: give it at each")


def checked_positions(position: ArrayLike) -> Array:
    """Measured positions as an array (poses, 3) with at least one finite component."""
    found = numbers(position, "measured position")
    if found.ndim != 2 or found.shape[1] != 3 or not np.isfinite(found).any():
        raise FrameError(f"measured position has shape {found.shape}: give (poses, 3), NaN where nothing was measured")
    if np.isinf(found).any():
        raise FrameError("a measured position is infinite: give NaN where nothing was measured")
    return found


def checked_uncertainty(uncertainty: ArrayLike | None, shape: tuple[int, ...]) -> Array | None:
    """Standard uncertainty in the shape of the measured values; None if unknown."""
    if uncertainty is None:
        return None
    found = numbers(uncertainty, "uncertainty")
    try:
        out = np.array(np.broadcast_to(found, shape))
    except ValueError:
        raise FrameError(f"uncertainty has shape {found.shape}: give one that broadcasts to {shape}") from None
    if not np.all(out > 0.0) or np.isinf(out).any():
        raise FrameError(f"an uncertainty is {out.min():g}: give standard uncertainties above zero")
    return out


def read_measured(path: str | Path) -> Measured:
    """Read a table of measured positions.

    Parameters
    ----------
    path
        A CSV file whose first line names the columns: ``x``, ``y``, ``z`` (lengths; at least one of them, with empty
        cells where nothing was measured), ``ux``, ``uy``, ``uz`` (standard uncertainties), and any other name for the
        values of a drive. If that name ends in ``[deg]``, the values are converted to radians.

    Returns
    -------
    Measured
        Positions, uncertainties and values of the drives.

    Raises
    ------
    FrameError
        If the file cannot be read, a cell is not a number, or there is no position.

    Examples
    --------
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as folder:
    ...     table = Path(folder) / "measured.csv"
    ...     _ = table.write_text("A [deg],x,y,ux,uy\\n0,0.2,0.0,1e-5,1e-5\\n90,0.0,0.2,1e-5,1e-5\\n")
    ...     found = read_measured(table)
    >>> found.position.shape, found.drives["A"].round(4).tolist()
    ((2, 3), [0.0, 1.5708])
    """
    file = Path(path)
    try:
        with file.open(newline="", encoding="utf-8-sig") as lines:
            rows = [row for row in csv.reader(lines) if any(cell.strip() for cell in row)]
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise FrameError(f"{file.name} cannot be read as a table of measured positions: {error}") from None
    columns = _columns(file.name, rows)
    count = len(rows) - 1
    missing = np.full(count, np.nan)
    place = np.stack([columns.pop(axis, missing) for axis in AXES], axis=1)
    own = [columns.pop(f"u{axis}", None) for axis in AXES]
    uncertainty = None
    if any(each is not None for each in own):
        uncertainty = np.stack([missing if each is None else each for each in own], axis=1)
        if np.any(np.isfinite(place) & np.isnan(uncertainty)):
            raise FrameError(
                f"{file.name}: a measured component has no uncertainty: fill in ux, uy, uz, or none of them"
            )
        uncertainty = np.where(np.isnan(place), 1.0, uncertainty)
    return Measured(place, uncertainty, dict(_drives(columns)))


def _columns(name: str, rows: list[list[str]]) -> dict[str, Array]:
    if len(rows) < 2:
        raise FrameError(f"{name} has no rows: give a line of column names and one a pose")
    heads = [cell.strip() for cell in rows[0]]
    if len(set(heads)) != len(heads) or not set(AXES) & set(heads):
        raise FrameError(f"{name} has the columns {', '.join(heads)}: name each once, with one of x, y, z among them")
    out = {head: np.full(len(rows) - 1, np.nan) for head in heads}
    for line, row in enumerate(rows[1:]):
        if len(row) != len(heads):
            raise FrameError(f"{name}, row {line + 2} has {len(row)} cells for {len(heads)} columns")
        for head, cell in zip(heads, row, strict=True):
            try:
                out[head][line] = float(cell) if cell.strip() else np.nan
            except ValueError:
                raise FrameError(f"{name}, row {line + 2}: {head} is {cell!r}, which is no number") from None
            if head not in POSITIONS and np.isnan(out[head][line]):
                raise FrameError(f"{name}, row {line + 2}: {head} has no value: give that of the drive at each pose")
    return out


def _drives(columns: Mapping[str, Array]) -> list[tuple[str, Array]]:
    degrees = "[deg]"
    return [
        (head.removesuffix(degrees).strip(), np.radians(values)) if head.endswith(degrees) else (head, values)
        for head, values in columns.items()
    ]
