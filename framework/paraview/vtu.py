"""Files for ParaView: VTK unstructured grids (.vtu), and the names of their parts."""

from __future__ import annotations

import base64
import json
import shutil
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import BinaryIO

import numpy as np

from ..errors import FrameError
from .scene import Array, Part

# Bytes of a file that are copied at a time.
_PIECE = 2**24
# Numbers that VTK has for kinds of cells, and its names for kinds of numbers.
_CELLS = {"vertex": 1, "line": 3}
_TYPES = {"float64": "Float64", "int64": "Int64", "int32": "Int32"}


def write_grid(path: Path, parts: Sequence[Part], pose: int) -> None:
    """Write pose number `pose` of `parts` into one .vtu.

    Where a part lacks an array of another, reals are 0 and integers -1. If there are several parts, the
    cell array ``part`` numbers them.
    """
    points, cells = [len(part.points[pose]) for part in parts], [len(part.cells) for part in parts]
    first = np.cumsum([0, *points])
    point_data = _united([part.point_data for part in parts], points, pose)
    cell_data = _united([part.cell_data for part in parts], cells, pose)
    if len(parts) > 1:
        cell_data["part"] = [np.full(count, number, dtype=np.int32) for number, count in enumerate(cells)]
    corners = [part.cells + start for part, start in zip(parts, first, strict=False)]
    size = np.concatenate([np.full(len(each), each.shape[1]) for each in corners])
    kinds = [np.full(len(part.cells), _CELLS[part.cell]) for part in parts]
    sections = {
        "Points": {"Points": [part.points[pose] for part in parts]},
        "Cells": {
            "connectivity": [each.reshape(-1) for each in corners],
            "offsets": [np.cumsum(size)],
            "types": kinds,
        },
        "PointData": point_data,
        "CellData": cell_data,
    }
    with path.open("wb") as file:
        _write(file, sum(points), sum(cells), sections)


def _write(file: BinaryIO, points: int, cells: int, sections: Mapping[str, Mapping[str, Sequence[Array]]]) -> None:
    """Write a grid as XML, its arrays in base 64, without a library: meshio's takes longer to load than most to write.

    They are not compressed: zlib would halve these small files and double the time.
    """
    order = "LittleEndian" if sys.byteorder == "little" else "BigEndian"
    size = f'NumberOfPoints="{points}" NumberOfCells="{cells}"'
    head = f'<VTKFile type="UnstructuredGrid" version="0.1" byte_order="{order}">\n<UnstructuredGrid>\n<Piece {size}>\n'
    file.write(f'<?xml version="1.0"?>\n{head}'.encode())
    for section, arrays in sections.items():
        if arrays:
            file.write(f"<{section}>\n".encode())
            for name, parts in arrays.items():
                _write_array(file, name, np.concatenate(parts))
            file.write(f"</{section}>\n".encode())
    file.write(b"</Piece>\n</UnstructuredGrid>\n</VTKFile>\n")


def _write_array(file: BinaryIO, name: str, array: Array) -> None:
    """Write an array, its number of bytes before it."""
    native = np.ascontiguousarray(array, dtype=array.dtype.newbyteorder("="))
    width = f' NumberOfComponents="{native.shape[1]}"' if native.ndim == 2 else ""
    file.write(f'<DataArray type="{_TYPES[native.dtype.name]}" Name="{name}"{width} format="binary">\n'.encode())
    file.write(base64.b64encode(np.uint32(native.nbytes).tobytes() + native.tobytes()))
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
    comment = json.dumps({kind: list(of) for kind, of in names.items()}).replace("--", "-\\u002d")
    named = path.with_name(f"{path.name}.named")
    with path.open("rb") as given, named.open("wb") as out:
        out.write(given.readline())
        out.write(f"<!-- {comment} -->\n".encode())
        # piece by piece: a large grid is hundreds of megabytes
        shutil.copyfileobj(given, out, _PIECE)
    named.replace(path)


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
