"""Measured positions of a point, and reading them from a table."""

from __future__ import annotations

import csv
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import NoReturn

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...framework.batch import numbers
from ...framework.errors import FrameError

Array = NDArray[np.float64]

AXES = ("x", "y", "z")
SPREADS = ("ux", "uy", "uz")
# Columns in which a cell may be empty.
POSITIONS = (*AXES, *SPREADS)
# From the unit behind the name of a drive to its name, and from that to what a linkage takes.
UNITS = {"[deg]": "deg", "[°]": "deg", "[rad]": "rad"}
FACTORS = {"deg": np.pi / 180.0, "rad": 1.0, "": 1.0}


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
        Values of the drives at the measured poses, by name, (poses,) each, radians or lengths.
    units
        Units in which a table gave the drives, by name: ``deg``, ``rad``, or empty where it named none.
    """

    position: Array
    uncertainty: Array | None
    drives: Mapping[str, Array]
    units: Mapping[str, str] = field(default_factory=dict)

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
    if found.ndim != 2 or found.shape[1] != 3:
        raise FrameError(f"measured position has shape {found.shape}: give (poses, 3), NaN where nothing was measured")
    if np.isinf(found).any():
        raise FrameError("a measured position is infinite: give NaN where nothing was measured")
    if np.isnan(found).all():
        raise FrameError("no position was measured, all are NaN: give at least one component of one pose")
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
    if (wrong := out[~((out > 0.0) & (out < np.inf))]).size:
        raise FrameError(f"an uncertainty is {wrong[0]:g}: give finite standard uncertainties above zero")
    return out


def read_measured(path: str | Path) -> Measured:
    """Read a table of measured positions.

    Parameters
    ----------
    path
        A CSV file whose first line names the columns: ``x``, ``y``, ``z`` (lengths; at least one of them, with empty
        cells where nothing was measured), ``ux``, ``uy``, ``uz`` (standard uncertainties), and any other name for the
        values of a drive. Such a name may end in its unit, ``[deg]``, ``[°]`` or ``[rad]``; degrees are converted to
        radians. Without a unit it is in radians or the linkage's unit of length.

    Returns
    -------
    Measured
        Positions, uncertainties and values of the drives.

    Raises
    ------
    FrameError
        If the file cannot be read, its columns are not those, a cell is not a number, or there is no position.

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
    name, rows = Path(path).name, _rows(Path(path))
    columns = _columns(name, rows)
    place = _vectors(columns, AXES)
    drives, units = _drives(name, {head: values for head, values in columns.items() if head not in POSITIONS})
    if np.isnan(place).all():
        raise FrameError(f"{name} has no position in it: x, y and z are empty in all rows")
    return Measured(place, _uncertainty(name, columns, place, list(rows)[1:]), drives, units)


def _rows(file: Path) -> dict[int, list[str]]:
    """Cells of the rows that hold something by the number of the row in the file, the names of the columns first."""
    try:
        with file.open(newline="", encoding="utf-8-sig") as lines:
            rows = enumerate(csv.reader(lines), start=1)
            return {number: row for number, row in rows if any(cell.strip() for cell in row)}
    except OSError as error:
        why = error.strerror or str(error)
    except UnicodeDecodeError:
        why = "it is not UTF-8 text"
    except (ValueError, csv.Error):
        why = "it is no text of rows and cells"
    raise FrameError(
        f"{file} cannot be read: {why}; give a table of measured positions, saved as CSV in UTF-8 (a spreadsheet's "
        "'CSV UTF-8')"
    )


def _columns(name: str, rows: Mapping[int, list[str]]) -> dict[str, Array]:
    """Numbers by the names of the columns, (poses,) each; NaN where a position or its uncertainty is left out."""
    if len(rows) < 2:
        raise FrameError(f"{name} has no rows: give a line of column names and one a pose")
    (first, heads), *poses = [(number, [cell.strip() for cell in row]) for number, row in rows.items()]
    _check_heads(f"{name}, row {first}", heads)
    out: dict[str, list[float]] = {head: [] for head in heads}
    for number, row in poses:
        if len(row) != len(heads):
            raise FrameError(f"{name}, row {number} has {len(row)} cells for {len(heads)} columns")
        for head, cell in zip(heads, row, strict=True):
            out[head].append(_number(f"{name}, row {number}: {head}", cell, needed=head not in POSITIONS))
    return {head: np.array(values) for head, values in out.items()}


def _check_heads(where: str, heads: list[str]) -> None:
    """Refuse names of columns that are no table of positions."""

    def refuse(why: str) -> NoReturn:
        raise FrameError(f"{where}: {why}")

    if len(heads) == 1 and (marks := re.findall(r"[;\t]", heads[0])):
        mark = "semicolons" if ";" in marks else "tabs"
        refuse(f"columns are separated by {mark}: separate them by commas, and write numbers with a point, 0.5")
    if "" in heads:
        refuse(f"column {heads.index('') + 1} has no name: name it, or leave it out")
    for head in heads:
        if heads.count(head) > 1:
            refuse(f"there are {heads.count(head)} columns {head!r}: keep one")
    if not set(AXES) & set(heads):
        refuse(f"no column is a position, of {', '.join(heads)}: name those x, y, z, in the linkage's unit of length")


def _number(what: str, cell: str, *, needed: bool) -> float:
    """A cell as a number; NaN where it is empty."""
    try:
        value = float(cell.replace("_", "?")) if cell else np.nan
    except ValueError:
        comma = ": write it with a point" if re.fullmatch(r"[+-]?\d+,\d+", cell) else ""
        raise FrameError(f"{what} is {cell!r}, which is no number{comma}") from None
    if np.isinf(value):
        raise FrameError(f"{what} is {cell!r}: give a finite number")
    if needed and np.isnan(value):
        raise FrameError(f"{what} has no value: give that of the drive at each pose")
    return value


def _vectors(columns: Mapping[str, Array], names: Sequence[str]) -> Array:
    """Columns side by side, (poses, 3); NaN for those that are not there."""
    missing = np.full(len(next(iter(columns.values()))), np.nan)
    return np.stack([columns.get(name, missing) for name in names], axis=1)


def _uncertainty(name: str, columns: Mapping[str, Array], place: Array, rows: Sequence[int]) -> Array | None:
    """Standard uncertainties (poses, 3), unity where nothing was measured; None if the table has none."""
    if not columns.keys() & set(SPREADS):
        return None
    found = np.where(np.isnan(place), 1.0, _vectors(columns, SPREADS))
    for (pose, k), value in np.ndenumerate(found):
        where = f"{name}, row {rows[pose]}"
        if np.isnan(value):
            raise FrameError(
                f"{where}: {AXES[k]} has no uncertainty: fill in {SPREADS[k]}, or leave {', '.join(SPREADS)} out"
            )
        if value <= 0.0:
            raise FrameError(f"{where}: {SPREADS[k]} is {value:g}: give a standard uncertainty above zero")
    return found


def _drives(name: str, columns: Mapping[str, Array]) -> tuple[dict[str, Array], dict[str, str]]:
    """Values of the drives by name, radians or lengths, and the units that their columns name."""
    out: dict[str, Array] = {}
    units: dict[str, str] = {}
    for head, values in columns.items():
        mark = next((each for each in UNITS if head.endswith(each)), "")
        drive = head.removesuffix(mark).strip()
        if drive in out:
            raise FrameError(f"{name}: two columns give the drive {drive!r}: keep one of them")
        units[drive] = UNITS.get(mark, "")
        out[drive] = values * FACTORS[units[drive]]
    return out, units
