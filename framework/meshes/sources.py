"""Line meshes out of meshio, scikit-fem and files."""

from __future__ import annotations

import re
from collections.abc import Sequence
from contextlib import redirect_stdout
from dataclasses import replace
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..batch import Array, finite
from ..errors import FrameError
from .abaqus import read_abaqus
from .lines import Index, LineMesh, in_space

# How the nodes of a cell follow each other along it, by meshio's name of the cell.
_ORDER = {"line": (0, 1), "line3": (0, 2, 1), "line4": (0, 2, 3, 1)}
# Arrays by which gmsh and scikit-fem keep their sets, which are read as sets.
_OF_SETS = re.compile(r"gmsh:geometrical$|gmsh:dim_tags$|skfem:")


def line_mesh_of(given: Any, scale: float = 1.0) -> LineMesh:
    """Points, lines and sets of a file, a ``meshio.Mesh`` or a scikit-fem ``MeshLine1``, its coordinates times `scale`.

    Raises
    ------
    FrameError
        If it is none of these, cannot be read, or holds no lines.
    """
    if isinstance(given, (str, Path)):
        mesh = _of_file(Path(given))
    elif hasattr(given, "p") and hasattr(given, "t"):
        mesh = _of_skfem(given)
    elif hasattr(given, "points") and hasattr(given, "cells") and hasattr(given, "cell_sets"):
        mesh = of_meshio(given, "the mesh")
    else:
        kind = type(given).__name__
        raise FrameError(f"the mesh is a {kind}: give a file's path, a meshio.Mesh or a skfem.MeshLine1")
    if scale == 1.0:
        return mesh
    factor = finite(scale, "scale of the mesh")
    if factor.shape or factor <= 0.0:
        raise FrameError(f"scale of the mesh is {scale!r}: give one positive number, the length of the mesh's unit")
    return replace(mesh, points=factor * mesh.points)


def _of_file(path: Path) -> LineMesh:
    if not path.is_file():
        raise FrameError(f"the mesh {path} is no file: give the path of one")
    if path.suffix.lower() == ".inp":
        return read_abaqus(path)
    import meshio

    try:
        with redirect_stdout(StringIO()):  # some of its readers write blank lines
            mesh = meshio.read(path)
    except (Exception, SystemExit) as error:  # its readers raise all kinds, and one of them ends the program
        raise FrameError(f"{path.name} cannot be read as a mesh: {error or type(error).__name__}") from error
    return of_meshio(mesh, path.name)


def _of_skfem(mesh: Any) -> LineMesh:
    if mesh.t.shape[0] != 2:
        raise FrameError(f"the mesh is a {type(mesh).__name__}, which has no lines: give a skfem.MeshLine1")
    boundaries = mesh.boundaries or {}
    return LineMesh(
        "the mesh",
        in_space(mesh.p.T, "the mesh"),
        np.asarray(mesh.t.T, dtype=np.int64),
        {name: np.asarray(at, dtype=np.int64) for name, at in (mesh.subdomains or {}).items() if len(at)},
        {name: np.asarray(mesh.facets[0, at], dtype=np.int64) for name, at in boundaries.items()},
    )


def of_meshio(mesh: Any, source: str) -> LineMesh:
    """Lines of a ``meshio.Mesh``; those of higher order are cut at their inner nodes."""
    chosen = [k for k, block in enumerate(mesh.cells) if block.type in _ORDER and len(block.data)]
    if not chosen:
        kinds = ", ".join(sorted({block.type for block in mesh.cells})) or "none"
        raise FrameError(f"{source} holds no lines (its cells: {kinds}): give a mesh of line cells")
    parts = [len(_ORDER[mesh.cells[k].type]) - 1 for k in chosen]
    lines = np.concatenate([_cut(mesh.cells[k].data, _ORDER[mesh.cells[k].type]) for k in chosen])

    unknown = lines[(lines < 0) | (lines >= len(mesh.points))]
    if unknown.size:
        raise FrameError(f"{source}: a line has the point {unknown[0]}, and there are {len(mesh.points)} points")

    def spread(arrays: Sequence[Any]) -> Array:
        """One number for each line, out of arrays with one for each cell of a block."""
        return np.concatenate([np.repeat(np.asarray(arrays[k]), n) for k, n in zip(chosen, parts, strict=True)])

    line_sets: dict[str, Index] = {}
    point_sets = {name: np.asarray(at, dtype=np.int64) for name, at in mesh.point_sets.items()}
    for name, flags in _flags(mesh, source).items():
        if (at := np.flatnonzero(spread(flags))).size:
            line_sets[name] = at
        corners = [
            block.data[flag].ravel() for block, flag in zip(mesh.cells, flags, strict=True) if block.type == "vertex"
        ]
        if corners and (nodes := np.unique(np.concatenate(corners))).size:
            point_sets.setdefault(name, nodes.astype(np.int64))
    for name, arrays in mesh.cell_data.items():
        if name.startswith("skfem:b:"):
            ends, bits = lines.astype(np.int64), spread(arrays).astype(np.int64)
            point_sets[name[8:]] = np.unique(np.concatenate([ends[bits & 1 > 0, 0], ends[bits & 2 > 0, 1]]))
    tags = {
        name: spread(arrays)
        for name, arrays in mesh.cell_data.items()
        if not _OF_SETS.match(name) and all(np.asarray(a).dtype.kind in "iu" and np.ndim(a) == 1 for a in arrays)
    }
    return LineMesh(source, in_space(mesh.points, source), lines.astype(np.int64), line_sets, point_sets, tags)


def _cut(cells: Array, order: tuple[int, ...]) -> Array:
    """Lines from node to node along each cell, (m (k - 1), 2)."""
    along = cells[:, list(order)]
    return np.stack([along[:, :-1], along[:, 1:]], axis=-1).reshape(-1, 2)


def _flags(mesh: Any, source: str) -> dict[str, list[NDArray[Any]]]:
    """By the name of a set, for each block of cells, which of its cells are in it."""
    sizes = [len(block.data) for block in mesh.cells]
    out: dict[str, list[NDArray[Any]]] = {}
    for name, arrays in mesh.cell_sets.items():
        if not name.startswith("gmsh:"):
            out[name] = _marked(name, arrays, sizes, source)
    physical = mesh.cell_data.get("gmsh:physical")
    for name, tag in mesh.field_data.items():
        if physical is not None and name not in out and np.shape(tag) == (2,):
            dimension = [{"vertex": 0}.get(block.type, 1 if block.type in _ORDER else 2) for block in mesh.cells]
            out[name] = [(np.asarray(p) == tag[0]) & (d == tag[1]) for p, d in zip(physical, dimension, strict=True)]
    for name, arrays in mesh.cell_data.items():
        if name.startswith("skfem:s:"):
            out[name[8:]] = [np.asarray(a) > 0 for a in arrays]
    return out


def _marked(name: str, arrays: Any, sizes: list[int], source: str) -> list[NDArray[Any]]:
    flags = [np.zeros(size, dtype=bool) for size in sizes]
    if len(arrays) != len(sizes):
        raise FrameError(
            f"{source}: set {name!r} has {len(arrays)} arrays for {len(sizes)} blocks of cells: give each one"
        )
    for flag, at in zip(flags, arrays, strict=True):
        if at is not None and len(at):
            numbers = np.asarray(at).astype(np.int64)
            if numbers.min() < 0 or numbers.max() >= len(flag):
                raise FrameError(f"{source}: set {name!r} holds cell {numbers.max()} of a block of {len(flag)} cells")
            flag[numbers] = True
    return flags
