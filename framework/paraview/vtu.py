"""Files for ParaView: VTK unstructured grids (.vtu), and the names of their parts."""

from __future__ import annotations

import json
import shutil
import struct
import sys
from binascii import b2a_base64
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import BinaryIO

import numpy as np

from ..errors import FrameError
from .scene import Array, Part

# Bytes of a file that are copied, or encoded, at a time: a multiple of three, which are four characters.
_PIECE = 3 * 2**20
# What VTK calls kinds of numbers, and the numbers of its cells.
_LETTERS = {"f": "Float", "i": "Int", "u": "UInt"}
_KINDS = {"vertex": 1, "line": 3}


def write_grid(path: Path, parts: Sequence[Part], pose: int, names: Mapping[str, Sequence[str]] | None = None) -> None:
    """Write pose number `pose` of `parts` into one .vtu, with `names` on its second line as `write_names` puts them.

    Where a part lacks an array of another, reals are 0 and integers -1. If there are several parts, the
    cell array ``part`` numbers them.
    """
    points, cells = [len(part.points[pose]) for part in parts], [len(part.cells) for part in parts]
    point_data = _united([part.point_data for part in parts], points, pose)
    cell_data = _united([part.cell_data for part in parts], cells, pose)
    if len(parts) > 1:
        cell_data["part"] = [np.full(count, number, dtype=np.int32) for number, count in enumerate(cells)]
    groups: dict[str, Mapping[str, Sequence[Array]]] = {
        "Points": {"Points": [part.points[pose] for part in parts]},
        "Cells": _cells(parts, points),
        "PointData": point_data,
        "CellData": cell_data,
    }
    with path.open("wb") as file:
        file.write(b'<?xml version="1.0"?>\n')
        if names is not None:
            file.write(_comment(names))
        order = "LittleEndian" if sys.byteorder == "little" else "BigEndian"
        file.write(
            f'<VTKFile type="UnstructuredGrid" version="1.0" byte_order="{order}" header_type="UInt64">\n'.encode()
        )
        file.write(
            f'<UnstructuredGrid>\n<Piece NumberOfPoints="{sum(points)}" NumberOfCells="{sum(cells)}">\n'.encode()
        )
        for group, arrays in groups.items():
            file.write(f"<{group}>\n".encode())
            for name, pieces in arrays.items():
                _write_array(file, name, np.concatenate(pieces))
            file.write(f"</{group}>\n".encode())
        file.write(b"</Piece>\n</UnstructuredGrid>\n</VTKFile>\n")


def _cells(parts: Sequence[Part], points: Sequence[int]) -> dict[str, list[Array]]:
    """Points of the cells one after the other, where each cell's points end, and what kind it is."""
    first = np.cumsum([0, *points])
    sizes = np.repeat([part.cells.shape[1] for part in parts], [len(part.cells) for part in parts])
    return {
        "connectivity": [(part.cells + start).reshape(-1) for part, start in zip(parts, first, strict=False)],
        "offsets": [np.cumsum(sizes)],
        "types": [np.full(len(part.cells), _KINDS[part.cell]) for part in parts],
    }


def _write_array(file: BinaryIO, name: str, values: Array) -> None:
    """Write an array as VTK reads it: behind its number of bytes, in base 64. (Compressed it would be half as large and
    take twice as long.)"""
    kind = f"{_LETTERS[values.dtype.kind]}{8 * values.dtype.itemsize}"
    width = f' NumberOfComponents="{values.shape[1]}"' if values.ndim == 2 else ""
    file.write(f'<DataArray type="{kind}" Name="{name}"{width} format="binary">\n'.encode())
    data = np.ascontiguousarray(values).reshape(-1).view(np.uint8).data
    # Eight bytes of the length and one of the data are twelve characters: the rest is encoded where it lies.
    begun = struct.pack("=Q", len(data)) + data[:1]
    file.write(b2a_base64(begun, newline=False))
    for start in range(1, len(data), _PIECE):
        file.write(b2a_base64(data[start : start + _PIECE], newline=False))
    file.write(b"\n</DataArray>\n")


def _united(data: Sequence[Mapping[str, Array]], counts: Sequence[int], pose: int) -> dict[str, list[Array]]:
    """For every name that some part has, one array a part."""
    sample = {name: array[pose] for arrays in data for name, array in arrays.items()}

    def missing(name: str, count: int) -> Array:
        like = sample[name]
        return np.full((count, *like.shape[1:]), -1 if like.dtype.kind == "i" else 0, dtype=like.dtype)

    return {
        name: [
            arrays[name][pose] if name in arrays else missing(name, count)
            for arrays, count in zip(data, counts, strict=True)
        ]
        for name in sample
    }


def write_names(path: Path, names: Mapping[str, Sequence[str]]) -> None:
    """Put `names` on the second line of an XML file, as JSON in a comment, which every reader skips."""
    named = path.with_name(f"{path.name}.named")
    with path.open("rb") as given, named.open("wb") as out:
        out.write(given.readline())
        out.write(_comment(names))
        # piece by piece: a large grid is hundreds of megabytes
        shutil.copyfileobj(given, out, _PIECE)
    named.replace(path)


def _comment(names: Mapping[str, Sequence[str]]) -> bytes:
    text = json.dumps({kind: list(of) for kind, of in names.items()}).replace("--", "-\\u002d")
    return f"<!-- {text} -->\n".encode()


def read_names(path: str | Path) -> dict[str, list[str]]:
    """Read the names of the members, links and joints that a saved .vtu or .pvd numbers.

    Parameters
    ----------
    path
        A file that `Solution.save` was asked to write.

    Returns
    -------
    dict
        Under ``member``, ``link`` and ``joint``, as the cell arrays are called, the names in the order of
        their numbers.

    Raises
    ------
    FrameError
        If the file holds no names.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> from linkframe.elements import Beam, Circle, Material
    >>> from linkframe.framework import Frame, read_names
    >>> frame = Frame()
    >>> for name, x in {"A": 0.0, "B": 1.0}.items():
    ...     frame.node(name, (x, 0.0, 0.0))
    >>> frame.add("AB", Beam(Circle(diameter=0.02), Material(E=200e9, nu=0.3)), "A", "B")
    >>> frame.fix("A")
    >>> with TemporaryDirectory() as folder:
    ...     frame.solve().save(f"{folder}/rod.vtu")
    ...     read_names(f"{folder}/rod.vtu")["member"]
    ['AB']
    """
    with Path(path).open(encoding="utf-8") as file:
        file.readline()
        comment = file.readline()
    if not comment.startswith("<!-- {"):
        raise FrameError(f"{path} holds no names of members, links and joints: give a file that save(...) wrote")
    names: dict[str, list[str]] = json.loads(comment.removeprefix("<!-- ").removesuffix(" -->\n"))
    return names
