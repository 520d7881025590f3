"""Grids are written as meshio writes them, without loading it."""

from __future__ import annotations

import sys
from pathlib import Path

import meshio
import numpy as np
import pytest
from linkframe.framework.paraview.scene import Part
from linkframe.framework.paraview.vtu import write_grid

RNG = np.random.default_rng(0)


def part(name: str, cell: str, points: int, ends: int) -> Part:
    """A part at two poses, with arrays of its own and one that all parts have."""
    vectors, numbers = RNG.normal(size=(2, points, 3)), np.arange(2 * (points - 1), dtype=np.int32)
    cells = np.arange(points - 1)[:, None] + np.arange(ends)
    return Part(
        name=name,
        cell=cell,
        points=RNG.normal(size=(2, points, 3)),
        cells=cells,
        point_data={"displacement": vectors, name: RNG.normal(size=(2, points))},
        cell_data={"number": numbers.reshape(2, -1), f"of {name}": RNG.normal(size=(2, points - 1, 3))},
    )


def test_bytes_are_those_of_meshio(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Two kinds of cells, arrays that only one has, and a view whose numbers do not lie in a row."""
    lines, dots = part("beams", "line", 5, 2), part("joints", "vertex", 3, 1)
    both = {name: np.concatenate([p.point_data[name][1] for p in (lines, dots)]) for name in ("displacement",)}
    both["beams"] = np.concatenate([lines.point_data["beams"][1], np.zeros(3)])
    both["joints"] = np.concatenate([np.zeros(5), dots.point_data["joints"][1]])
    cells = {
        "number": [lines.cell_data["number"][1], dots.cell_data["number"][1]],
        "of beams": [lines.cell_data["of beams"][1], np.zeros((2, 3))],
        "of joints": [np.zeros((4, 3)), dots.cell_data["of joints"][1]],
        "part": [np.zeros(4, dtype=np.int32), np.ones(2, dtype=np.int32)],
    }
    points = np.concatenate([lines.points[1], dots.points[1]])
    mesh = meshio.Mesh(points, [("line", lines.cells), ("vertex", dots.cells + 5)], point_data=both, cell_data=cells)
    meshio.vtu.write(tmp_path / "theirs.vtu", mesh, binary=True, compression=None)
    theirs = (tmp_path / "theirs.vtu").read_bytes().splitlines(keepends=True)
    for name in [name for name in sys.modules if name.partition(".")[0] == "meshio"]:
        monkeypatch.setitem(sys.modules, name, None)
    turned = Part(**{**vars(lines), "points": np.asfortranarray(lines.points)})
    write_grid(tmp_path / "ours.vtu", [turned, dots], 1)
    ours = (tmp_path / "ours.vtu").read_bytes().splitlines(keepends=True)
    assert ours == [line for line in theirs if not line.startswith(b"<!--This file was created by meshio")]
