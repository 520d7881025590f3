"""Files for ParaView: VTK unstructured grids (.vtu), and the names of their parts."""

from __future__ import annotations

import json
import shutil
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from ..errors import FrameError
from .scene import Array, Part

# Bytes of a file that are copied at a time.
_PIECE = 2**24


def write_grid(path: Path, parts: Sequence[Part], pose: int) -> None:
    """Write pose number `pose` of `parts` into one .vtu.

    Where a part lacks an array of another, reals are 0 and integers -1. If there are several parts, the
    cell array ``part`` numbers them.
    """
    import meshio

    points, cells = [len(part.points[pose]) for part in parts], [len(part.cells) for part in parts]
    first = np.cumsum([0, *points])
    point_data = _united([part.point_data for part in parts], points, pose)
    cell_data = _united([part.cell_data for part in parts], cells, pose)
    if len(parts) > 1:
        cell_data["part"] = [np.full(count, number, dtype=np.int32) for number, count in enumerate(cells)]
    mesh = meshio.Mesh(
        np.concatenate([part.points[pose] for part in parts]),
        [(part.cell, part.cells + start) for part, start in zip(parts, first, strict=False)],
        point_data={name: np.concatenate(arrays) for name, arrays in point_data.items()},
        cell_data=cell_data,
    )
    # Uncompressed: zlib would halve these small files and double the time.
    meshio.vtu.write(path, mesh, binary=True, compression=None)


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
