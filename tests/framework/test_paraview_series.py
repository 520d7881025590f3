"""A series for ParaView as VTK's own readers have it: named blocks, names as strings, global vectors, clearances."""

from __future__ import annotations

import sys
from pathlib import Path
from types import ModuleType
from typing import Any
from unittest.mock import MagicMock
from xml.etree import ElementTree

import meshio
import numpy as np
import pytest
import vtk
from linkframe.elements import Beam, Circle, Joint, Material
from linkframe.framework import Frame, read_names
from linkframe.framework.paraview.blocks import write_collection
from linkframe.framework.paraview.guide import MEANINGS
from linkframe.framework.structure import numbered_pieces
from linkframe.framework.structure.mesh import line_mesh
from numpy.testing import assert_allclose

ROD = Beam(Circle(diameter=0.02), Material(E=200e9, nu=0.3), segments=4)
AWKWARD = "rod <é> & -- 'q' 🙂"


def rest(force: object = (1.0, -10.0)) -> Frame:
    """A cantilever whose tip has 1 mm to a stop, which the joint's axes are turned against."""
    frame = Frame()
    for name, x in {"A": 0.0, "B": 1.0, "C": 1.0}.items():
        frame.node(name, (x, 0.0, 0.0))
    quarter = np.array([(0.0, -1.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)])
    frame.add(AWKWARD, ROD, "A", "B")
    frame.add("stop", Joint(stiffness=(1e9, 0.0, 0.0, 0.0, 0.0, 0.0), clearance=1e-3, axes=quarter), "B", "C")
    frame.fix("A")
    frame.fix("C")
    frame.load("B", fy=force)
    return frame


def read(path: Path) -> Any:
    reader = vtk.vtkXMLMultiBlockDataReader()
    reader.SetFileName(str(path))
    reader.Update()
    return reader.GetOutput()


def strings(data: Any, name: str) -> list[str]:
    array = data.GetFieldData().GetAbstractArray(name)
    assert isinstance(array, vtk.vtkStringArray)
    return [array.GetValue(k) for k in range(array.GetNumberOfValues())]


def test_blocks_and_parts_have_names(tmp_path: Path) -> None:
    rest().solve().save(tmp_path / "rest.pvd")
    pose = read(tmp_path / "rest" / "pose_001.vtm")
    blocks = [pose.GetMetaData(k).Get(vtk.vtkCompositeDataSet.NAME()) for k in range(pose.GetNumberOfBlocks())]
    assert blocks == ["beams", "joints"]
    assert strings(pose, "member_names") == [AWKWARD]
    assert strings(pose, "joint_names") == ["stop"]
    assert pose.GetFieldData().GetNumberOfArrays() == 2
    assert pose.GetBlock(0).GetCellData().GetArray("member").GetRange() == (0.0, 0.0)
    assert read_names(tmp_path / "rest.pvd")["member"] == [AWKWARD]
    # other programs read the grids, in which VTK's strings would end meshio
    assert "member" in meshio.read(tmp_path / "rest" / "beams_001.vtu").cell_data


@pytest.mark.parametrize("large", [False, True])
def test_clearances_are_shown(tmp_path: Path, large: bool) -> None:
    # pushed up by 1 N the tip moves P L^3 / (3 E I) = 0.21 mm, so that the journal hangs free of its stop
    solution = rest().solve(large=large)
    solution.save(tmp_path / "rest.pvd")
    free, closed = (meshio.read(tmp_path / "rest" / f"joints_{k:03d}.vtu").point_data for k in range(2))
    assert (free["contact"], closed["contact"]) == (0, 1)
    # the stop holds the tip, so that the bearing lies 1 mm above the journal
    assert_allclose(closed["clearance_offset"], [[0.0, 1e-3, 0.0]], rtol=1e-6, atol=2e-6)  # turned by 1.5e-3
    # at large displacement the journal has turned by 3e-4 with its arm
    assert_allclose(free["clearance_offset"][0], free["gap"][0], rtol=1e-6, atol=1e-7)
    assert_allclose(free["gap"][0, 1], -1.0 / (3.0 * 200e9 * np.pi / 64.0 * 0.02**4), rtol=1e-3)


def test_a_joint_without_clearance_is_told(tmp_path: Path) -> None:
    frame = rest(-10.0)
    frame.node("D", (1.0, 0.0, 0.0))
    frame.add("pin", Joint(stiffness=(1e6,) * 6), "B", "D")
    frame.solve().save(tmp_path / "rest.vtu")
    assert meshio.read(tmp_path / "rest.vtu").point_data["contact"][-2:].tolist() == [1, -1]
    frame.solve(clearance=False).save(tmp_path / "rest.vtu")
    assert "contact" not in meshio.read(tmp_path / "rest.vtu").point_data


@pytest.mark.parametrize("large", [False, True])
@pytest.mark.parametrize("in_body", [False, True])
def test_shear_and_bending_are_in_equilibrium_in_global_axes(tmp_path: Path, large: bool, in_body: bool) -> None:
    """What a cantilever in space carries at its clamp is the load at its tip, and that times the arm."""
    turn = np.linalg.qr(np.random.default_rng(5).normal(size=(3, 3)))[0]
    turn *= np.linalg.det(turn)
    frame = Frame()
    frame.body("arm", origin=(0.3, 0.1, 0.0), axes=turn)
    ends = np.array([(0.0, 0.0, 0.0), (0.5, 0.7, -0.3)])
    for name, place in zip("AB", ends, strict=True):
        frame.node(name, place if in_body else turn @ place + (0.3, 0.1, 0.0), body="arm" if in_body else None)
    frame.add("AB", ROD, "A", "B")
    frame.fix("A")
    load = np.array([200.0, -300.0, 100.0])
    frame.load("B", fx=load[0], fy=load[1], fz=load[2])
    frame.solve(large=large).save(tmp_path / "arm.vtu")
    mesh = meshio.read(tmp_path / "arm.vtu")
    data, moved = mesh.point_data, mesh.points + (mesh.point_data["displacement"] if large else 0.0)
    arm = moved[-1] - moved[0]
    rest_of = load - data["V"][0]
    along = rest_of / data["N"][0]
    assert_allclose(np.linalg.norm(along), 1.0, rtol=1e-9)
    assert_allclose(data["M"][0] + data["T"][0] * along, np.cross(arm, load), rtol=1e-8, atol=1e-8)
    if not large:
        assert_allclose(along, arm / np.linalg.norm(arm), atol=1e-10)
        assert_allclose(np.linalg.norm(mesh.cell_data["V_local"][0], axis=1), np.linalg.norm(data["V"][0]))


def test_joints_turn_with_what_they_are_on(tmp_path: Path) -> None:
    """At large displacement forces in the axes of a joint are told in global ones: the load at the tip."""
    frame = Frame()
    for name, x in {"A": 0.0, "B": 0.5, "C": 0.5, "D": 1.0}.items():
        frame.node(name, (x, 0.0, 0.0))
    frame.add("AB", ROD, "A", "B")
    frame.add("pin", Joint(stiffness=(1e7,) * 3 + (1e5,) * 3), "B", "C")
    frame.add("CD", ROD, "C", "D")
    frame.fix("A")
    frame.load("D", fy=2000.0)
    frame.solve(large=True).save(tmp_path / "bent.vtu")
    data = meshio.read(tmp_path / "bent.vtu").point_data
    assert data["rotation"][-1, 2] > 0.3
    assert_allclose(data["force"][-1], [0.0, 2000.0, 0.0], rtol=1e-8, atol=1e-5)


def test_the_page_and_the_script_beside_a_series(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    rest().solve().save(tmp_path / "rest.pvd")
    page = (tmp_path / "rest" / "README.txt").read_text(encoding="utf-8")
    for name in ("joints_000", "beams_000"):
        mesh = meshio.read(tmp_path / "rest" / f"{name}.vtu")
        for array in [*mesh.point_data, *mesh.cell_data]:
            assert f"  {array} " in page
            assert MEANINGS[array] in page
    script = tmp_path / "rest" / "open_in_paraview.py"
    simple = MagicMock()
    simple.__all__ = [
        *("PVDReader", "GetAnimationScene", "GetActiveViewOrCreate", "GetColorTransferFunction", "ExtractBlock"),
        *("WarpByVector", "Tube", "ExtractSurface", "Show", "ColorBy", "ResetCamera", "Render"),
        *("CellDatatoPointData", "Glyph", "GetScalarBar", "Text"),
    ]
    monkeypatch.setitem(sys.modules, "paraview", ModuleType("paraview"))
    monkeypatch.setitem(sys.modules, "paraview.simple", simple)
    exec(compile(script.read_text(encoding="utf-8"), script, "exec"), {"__file__": str(script)})
    assert simple.PVDReader.call_args.kwargs["FileName"] == str(tmp_path / "rest.pvd")
    assert [call.kwargs["Selectors"] for call in simple.ExtractBlock.call_args_list] == [
        ["/Root/beams"],
        ["/Root/joints"],
    ]
    # the largest displacement, 1 mm, becomes about a twelfth of the length
    assert simple.WarpByVector.call_args.kwargs["ScaleFactor"] == 50.0
    assert simple.GetColorTransferFunction.return_value.Annotations == ["0", "stop"]


def test_an_array_lies_on_points_or_on_cells(tmp_path: Path) -> None:
    """Under one name a viewer would offer both, and show another picture by each."""
    rest().solve().save(tmp_path / "rest.pvd")
    for name in ("joints_000", "beams_000"):
        mesh = meshio.read(tmp_path / "rest" / f"{name}.vtu")
        assert not set(mesh.point_data) & set(mesh.cell_data)


def test_cells_are_those_of_the_mesh(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Members and joints are written from scikit-fem's mesh: with its beams turned round they are, too."""
    frame = rest(-10.0)
    mesh, cells = frame.mesh, 8
    first, last = mesh.t[0, mesh.subdomains["beam"][0]], mesh.t[1, mesh.subdomains["beam"][-1]]
    frame.solve().save(tmp_path / "rest.vtu", stations=cells)
    read = meshio.read(tmp_path / "rest.vtu")
    assert_allclose(read.points[: cells + 1], np.linspace(mesh.p[:, first], mesh.p[:, last], cells + 1), atol=1e-15)
    assert_allclose(read.points[cells + 1 :], mesh.p[:, mesh.t[0, mesh.subdomains["joint"]]].T)

    def turned(points: Any, kinds: Any, *given: Any) -> Any:
        return line_mesh(points, {**kinds, "beam": kinds["beam"][::-1, ::-1]}, *given)

    monkeypatch.setattr(numbered_pieces, "line_mesh", turned)
    frame.solve().save(tmp_path / "turned.vtu", stations=cells)
    assert_allclose(meshio.read(tmp_path / "turned.vtu").points[: cells + 1], read.points[cells::-1], atol=1e-15)


def test_collections_hold_any_name_of_a_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As XML reads it: line breaks, quotes and tabs too; without what Python loads for web pages."""
    monkeypatch.setitem(sys.modules, "xml.sax.saxutils", None)
    names = ["rest/pose_000.vtm", AWKWARD, "\"both\" 'kinds'", "a\nb\tc\rd", "&#10;&amp;"]
    write_collection(tmp_path / "all.pvd", [(0.5 * k, name) for k, name in enumerate(names)])
    read = ElementTree.parse(tmp_path / "all.pvd").getroot().iter("DataSet")
    assert [(float(each.attrib["timestep"]), each.attrib["file"]) for each in read] == [
        (0.5 * k, name) for k, name in enumerate(names)
    ]
