"""Frames of line meshes: files of gmsh, Abaqus and VTK, scikit-fem's meshes, their sets by name."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import meshio
import numpy as np
import pytest
import skfem
from linkframe.elements import Beam, Circle, Joint, Material
from linkframe.framework import Frame, FrameError
from reference.counted import calls

STEEL = Material(E=200e9, nu=0.3)
THICK, THIN = Beam(Circle(diameter=0.04), STEEL), Beam(Circle(diameter=0.02), STEEL)
PIN = Joint(stiffness=(1e7, 2e7, 3e7, 1e3, 2e3, 10.0))

GMSH = """$MeshFormat
4.1 0 8
$EndMeshFormat
$PhysicalNames
3
0 1 "foot"
1 2 "mast"
1 3 "boom"
$EndPhysicalNames
$Entities
2 2 0 0
1 0 0 0 1 1
2 1 2 0 0
1 0 0 0 0 2 0 1 2 2 1 -2
2 0 2 0 1 2 0 1 3 2 1 -2
$EndEntities
$Nodes
3 4 1 4
0 1 0 1
1
0 0 0
1 1 0 2
2
3
0 1 0
0 2 0
1 2 0 1
4
1 2 0
$EndNodes
$Elements
3 4 1 4
0 1 15 1
1 1
1 1 1 2
2 1 2
3 2 3
1 2 1 1
4 3 4
$EndElements
"""

# The same, in the older format, which keeps groups as numbers of the cells.
GMSH_2 = """$MeshFormat
2.2 0 8
$EndMeshFormat
$PhysicalNames
3
0 1 "foot"
1 2 "mast"
1 3 "boom"
$EndPhysicalNames
$Nodes
4
1 0 0 0
2 0 1 0
3 0 2 0
4 1 2 0
$EndNodes
$Elements
4
1 15 2 1 1 1
2 1 2 2 1 1 2
3 1 2 2 1 2 3
4 1 2 3 2 3 4
$EndElements
"""

# Sets that name others, sets given with elements and twice, a block without a set, labels with gaps.
ABAQUS = """*HEADING
a mast with a boom
** the nodes
*NODE, NSET=ALL
10, 0., 0., 0.
20, 0., 1.
30, 0., 2., 0.
40, 1., 2., 0.
45, 1.5, 2., 0.
50, 2., 2., 0.
*Element, type=B31
7, 10, 20
*ELEMENT, TYPE=B31, ELSET=Mast
1, 20, 30
*ELEMENT, TYPE=B32H, ELSET=BOOM
5, 40, 45, 50
*ELEMENT, TYPE=B31, ELSET=BOOM
6, 30, 40
*ELSET, ELSET=MAST LOW
7
*ELSET, ELSET=WHOLE
Mast, BOOM
MAST LOW
*NSET, NSET=FOOT
10,
*NSET, NSET=ROW, GENERATE
10, 30, 10
"""


def joined() -> Frame:
    """A mast and a boom, the boom in three pieces, with a compliant pin between them."""
    frame = Frame()
    frame.add_nodes(["foot", "head", "root", "tip"], [(0, 0, 0), (0, 2, 0), (0, 2, 0), (1, 2, 0.5)])
    frame.add("mast", THICK, "foot", "head")
    frame.add("pin", PIN, "head", "root")
    frame.add("boom", Beam(Circle(diameter=0.02), STEEL, segments=3), "root", "tip")
    frame.fix("foot")
    return frame


def tip(frame: Frame, node: str) -> Any:
    frame.load(node, fy=-10.0, fz=3.0)
    return frame.solve().displacement(node)


@pytest.mark.parametrize("ending", ["vtu", "msh", "vtk", None])
def test_a_frames_own_mesh_comes_back(tmp_path: Path, ending: str | None) -> None:
    frame = joined()
    mesh: Any = frame.mesh
    if ending:
        mesh = tmp_path / f"crane.{ending}"
        frame.mesh.save(mesh)
    again = Frame.from_mesh(mesh, {"mast": THICK, "boom": THIN, "pin": PIN})
    assert list(again.members) == ["mast", "boom 0", "boom 1", "boom 2"]
    assert list(again.joints) == ["pin"]
    assert again.node_sets == {"foot": ["0"]}
    again.fix("foot")
    np.testing.assert_allclose(tip(again, "3"), tip(frame, "tip"), rtol=1e-11, atol=1e-16)


@pytest.mark.parametrize("text", [GMSH, GMSH_2])
def test_physical_groups_of_gmsh(tmp_path: Path, text: str, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "crane.msh"
    path.write_text(text, encoding="utf-8")
    frame = Frame.from_mesh(path, {"mast": THICK, "boom": THIN})
    assert list(frame.members) == ["mast 0", "mast 1", "boom"]
    assert frame.element_sets == {"mast": ["mast 0", "mast 1"], "boom": ["boom"]}
    assert frame.node_sets == {"foot": ["0"]}
    assert frame.members["boom"].element is THIN
    assert frame.position(frame.members["boom"].end).tolist() == [1.0, 2.0, 0.0]
    assert capsys.readouterr().out == ""


def test_sets_of_abaqus(tmp_path: Path) -> None:
    path = tmp_path / "crane.inp"
    path.write_text(ABAQUS, encoding="utf-8")
    frame = Frame.from_mesh(path, {"MAST LOW": THICK, "Mast": THICK, "BOOM": THIN})
    assert list(frame.nodes) == ["10", "20", "30", "40", "45", "50"]
    assert list(frame.members) == ["MAST LOW", "Mast", "BOOM 5.0", "BOOM 5.1", "BOOM 6"]
    ends = {name: (member.start, member.end) for name, member in frame.members.items()}
    assert ends["MAST LOW"] == ("10", "20")
    assert ends["BOOM 5.1"] == ("45", "50")
    assert sorted(frame.element_sets["WHOLE"]) == sorted(frame.members)
    assert frame.node_sets["ROW"] == ["10", "20", "30"]
    frame.fix_many("FOOT")
    frame.load_many("ROW", fx=1.0)
    assert list(frame.supports) == ["10"]
    assert sorted(frame.loads) == ["10", "20", "30"]
    assert frame.position("FOOT").tolist() == [0.0, 0.0, 0.0]


def test_arrays_of_numbers_are_sets_and_cells_of_higher_order_are_cut(tmp_path: Path) -> None:
    # gmsh and VTK number the inner node of a line3 last
    points = [(0.0, 0.0), (2.0, 0.0), (1.0, 0.2), (3.0, 0.0), (9.0, 9.0)]
    mesh = meshio.Mesh(
        points,
        [("line3", [(0, 1, 2)]), ("line", [(1, 3)])],
        cell_data={"material": [np.array([4]), np.array([-2])]},
    )
    frame = Frame.from_mesh(mesh, {"material 4": THICK, "material -2": THIN}, scale=1e-3, drop_unconnected=True)
    assert [(m.start, m.end) for m in frame.members.values()] == [("0", "2"), ("2", "1"), ("1", "3")]
    assert [m.element for m in frame.members.values()] == [THICK, THICK, THIN]
    np.testing.assert_allclose(frame.position("2"), [1e-3, 0.2e-3, 0.0])
    path = tmp_path / "rods.vtu"
    meshio.Mesh([(0.0, 0.0, 0.0), (1.0, 0.0, 0.0)], [("line", [(0, 1)])]).write(path)
    assert list(Frame.from_mesh(str(path), THIN).members) == ["0"]


def test_lines_left_out_and_nodes_with_them() -> None:
    mesh = joined().mesh
    frame = Frame.from_mesh(mesh, {"mast": THICK, "pin": None, "boom": None}, drop_unconnected=True)
    assert (list(frame.members), list(frame.nodes), frame.aliases) == (["mast"], ["0", "1"], {"foot": "0"})


@pytest.mark.parametrize(
    ("mesh", "element", "message"),
    [
        (meshio.Mesh(np.eye(3), [("triangle", [(0, 1, 2)])]), THIN, r"holds no lines \(its cells: triangle\)"),
        (skfem.MeshTri(), THIN, r"is a MeshTri1, which has no lines"),
        (7, THIN, r"the mesh is a int: give a file's path"),
        ("nowhere.msh", THIN, r"nowhere\.msh is no file"),
        (joined().mesh, {"mast": THICK, "bom": THIN}, r"set of lines 'bom' is unknown: known are .*'boom'"),
        (joined().mesh, {"mast": THICK, "pin": PIN}, r"3 of 5 lines have no element, line 1 the first .*'boom'"),
        (joined().mesh, {"beam": THICK, "boom": THIN, "pin": PIN}, r"in the sets 'beam' and 'boom', which have diff"),
        (joined().mesh, {"mast": THICK, "boom": THIN, "pin": None}, None),
        (
            joined().mesh,
            {"mast": THICK, "boom": None, "pin": None},
            r"node 2 at \(0\.0, 2\.0, 0\.0\) and 3 more lie on no",
        ),
        (joined().mesh, {"mast": 3.0}, r"was given the element 3\.0: give a beam or a joint"),
        (joined().mesh, None, r"was given the element None"),
        (joined().mesh, THIN, r"'pin' has zero length"),
        (meshio.Mesh([(0, 0, 0), (np.nan, 0, 0)], [("line", [(0, 1)])]), THIN, r"point 1 lies at \[nan"),
        (meshio.Mesh(np.eye(3), [("line", [(0, 7)])]), THIN, r"a line has the point 7, and there are 3"),
        (meshio.Mesh(np.eye(3), [("line", [(0, -1)])]), THIN, r"a line has the point -1, and there are 3"),
    ],
)
def test_faults_are_named(mesh: Any, element: Any, message: str | None) -> None:
    if message is None:
        assert len(Frame.from_mesh(mesh, element).members) == 4
        return
    with pytest.raises(FrameError, match=message):
        Frame.from_mesh(mesh, element)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("5, 40, 45, 50", "5, 40, 45, 99"), r"element 5 has the node 99"),
        (("5, 40, 45, 50", "5, 40, 50"), r"element 5, 40, 50 does not have the 3 nodes of B32H"),
        (("*NSET, NSET=FOOT", "*NODE"), r"node 10 is there twice"),
        (("*HEADING", "*INCLUDE, INPUT=other.inp"), r"includes other\.inp"),
        (("*NODE, NSET=ALL", "*NODE, INPUT=other.inp"), r"includes other\.inp"),
        (("*HEADING", "*SYSTEM\n10., 0., 0.\n*HEADING"), r"has \*SYSTEM with places in axes of its own"),
        (("*NODE, NSET=ALL", "*NODE, SYSTEM=C"), r"has \*NODE with places in axes of its own"),
        (("*HEADING", "*INSTANCE, NAME=a, PART=b\n0., 0., 1.\n*HEADING"), r"has \*INSTANCE with places in axes"),
        (("*HEADING", "*INSTANCE, NAME=a, PART=b\n*INSTANCE, NAME=c, PART=b\n*HEADING"), r"several instances"),
        (("*HEADING", "*NGEN\n10, 20, 1\n*HEADING"), r"has \*NGEN, which makes nodes or elements of others"),
        (("*NSET, NSET=FOOT", "*NSET, NSET=OF, GENERATE\n1, x, 1\n*NSET, NSET=FOOT"), r"generated from 'x'"),
    ],
)
def test_faults_of_an_abaqus_file(tmp_path: Path, change: tuple[str, str], message: str) -> None:
    path = tmp_path / "crane.inp"
    path.write_text(ABAQUS.replace(*change), encoding="utf-8")
    with pytest.raises(FrameError, match=message):
        Frame.from_mesh(path, THIN)


def test_a_file_that_is_no_mesh(tmp_path: Path) -> None:
    for name in ("x.vtu", "x.abc", "x.msh"):
        (tmp_path / name).write_text("not a mesh", encoding="utf-8")
        with pytest.raises(FrameError, match=f"{name} cannot be read as a mesh"):
            Frame.from_mesh(tmp_path / name, THIN)


def test_many_lines_take_no_more_calls_than_some() -> None:
    """Nothing is done line by line."""

    def read(count: int) -> int:
        x = np.arange(count + 1.0)
        mesh = meshio.Mesh(
            np.stack([x, 0.0 * x, 0.0 * x], axis=-1),
            [("line", np.stack([x[:-1], x[1:]], axis=-1).astype(int))],
            cell_sets={"low": [np.arange(count // 4)], "high": [np.arange(count // 4, count)]},
        )
        frame = Frame.from_mesh(mesh, {"low": THICK, "high": THIN})
        assert list(frame.members)[-1] == f"high {count - count // 4 - 1}"
        return calls(lambda: Frame.from_mesh(mesh, {"low": THICK, "high": THIN}))

    assert read(20_000) <= read(2000)
