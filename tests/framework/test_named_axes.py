"""Batch axes with names, and results as tables that have them."""

from __future__ import annotations

import pickle
import sys
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from linkframe.elements import Beam, Circle, Joint, Material
from linkframe.framework import Frame, FrameError
from numpy.testing import assert_array_equal

ROD = Beam(Circle(diameter=0.02), Material(E=210e9, nu=0.3))


def rods(*axes: str) -> Frame:
    """Two rods with a hinge; 3 directions of the second and 4 loads."""
    frame, angle = Frame(axes=axes), np.array([0.0, 0.5, 1.0])[:, None]
    frame.node("A", (0.0, 0.0, 0.0))
    frame.node("B", (0.4, 0.0, 0.0))
    frame.node("C", (0.4, 0.0, 0.0))
    frame.node("D", np.stack([0.4 + 0.3 * np.cos(angle), 0.3 * np.sin(angle), 0.0 * angle], axis=-1))
    frame.add("AB", ROD, "A", "B")
    frame.add("CD", ROD, "C", "D")
    frame.add("hinge", Joint(stiffness=(1e8, 1e8, 1e8, 1e6, 1e6, 50.0)), "B", "C")
    frame.fix("A")
    frame.load("D", fy=np.linspace(1.0, 4.0, 4))
    return frame


def as_tables(monkeypatch: pytest.MonkeyPatch) -> None:
    """What the two libraries are given, should they not be there."""
    monkeypatch.setitem(sys.modules, "pandas", SimpleNamespace(DataFrame=lambda columns: columns))
    monkeypatch.setitem(sys.modules, "xarray", SimpleNamespace(Dataset=lambda data, coords: (data, coords)))


@pytest.mark.parametrize("axes", [("pose", "sample"), ("machine", "pose", "sample"), ()])
def test_dimensions_have_their_names(axes: tuple[str, ...], monkeypatch: pytest.MonkeyPatch) -> None:
    as_tables(monkeypatch)
    solution = rods(*axes).solve()
    batch = ("pose", "sample") if axes else ("axis_0", "axis_1")
    data, coords = solution.to_xarray()
    sizes = dict(zip(batch, (3, 4), strict=True)) | {name: len(values) for name, values in coords.items()}
    for dims, values in data.values():
        assert np.shape(values) == tuple(sizes[name] for name in dims)
    assert data["displacement"][0] == (*batch, "node", "component")
    assert_array_equal(data["displacement"][1][:, :, 3], solution.displacement("D"))
    assert_array_equal(data["reaction"][1][:, :, 0], solution.reaction("A"))
    assert_array_equal(data["joint_force"][1][:, :, 0], solution.joint_force("hinge"))
    assert coords["node"] == ["A", "B", "C", "D"]
    table = solution.to_dataframe()
    assert {len(column) for column in table.values()} == {3 * 4 * 4}
    last = (table[batch[0]] == 2) & (table[batch[1]] == 1) & (table["node"] == "D")
    assert_array_equal(table["uy"][last], solution.displacement("D")[2, 1, 1])
    assert set(table["status"]) == {"regular"}


def test_they_are_those_of_the_libraries() -> None:
    xarray = pytest.importorskip("xarray")
    solution = rods("pose", "sample").solve()
    found = solution.to_xarray()
    assert isinstance(found, xarray.Dataset)
    assert dict(found.sizes) == {
        "pose": 3,
        "sample": 4,
        "node": 4,
        "component": 6,
        "support": 1,
        "force": 6,
        "joint": 1,
    }
    chosen = found.displacement.sel(node="D", component="uy").isel(pose=1)
    assert chosen.dims == ("sample",)
    assert_array_equal(chosen, solution.displacement("D")[1, :, 1])
    table = solution.to_dataframe()
    assert_array_equal(table.query("node == 'D' and pose == 1")["uy"], chosen)
    assert rods("pose", "sample").solve(large=True).to_xarray().displacement.dims == found.displacement.dims


def test_names_stay() -> None:
    frame = rods("pose", "sample")
    assert frame.copy().axes == pickle.loads(pickle.dumps(frame)).axes == ("pose", "sample")


@pytest.mark.parametrize(
    ("axes", "message"),
    [
        ("pose", r"axes is 'pose': give names of the batch axes"),
        (("pose", ""), r"give names of the batch axes"),
        (("pose", "pose"), r"in which 'pose' stands twice"),
        (("pose", "node"), r"in which 'node' is that of another dimension of results"),
    ],
)
def test_names_that_are_refused(axes: Any, message: str) -> None:
    with pytest.raises(FrameError, match=message):
        Frame(axes=axes)


def test_more_axes_than_names_are_refused() -> None:
    with pytest.raises(FrameError, match=r"node 'D'.* has the shape \(3, 1\), and 1 batch axes have names"):
        rods("sample")


def test_a_library_that_is_missing_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    solution = rods().solve()
    for name, method in (("pandas", solution.to_dataframe), ("xarray", solution.to_xarray)):
        monkeypatch.setitem(sys.modules, name, None)
        with pytest.raises(FrameError, match=f"{name}, which is not installed"):
            method()
