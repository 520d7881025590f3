"""What is saved is what was solved, to the bit, as read by meshio and by pyvista."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import meshio
import numpy as np
import pytest
import pyvista
from linkframe.elements import Beam, Joint, Material, Rectangle, Section
from linkframe.framework import Frame, FrameError, MechanismWarning
from linkframe.framework.paraview import blocks as blocks_module
from linkframe.framework.paraview.vtu import read_names
from linkframe.framework.solution import Solution

STATIONS = 8
BAR = Beam(Rectangle(y=0.02, z=0.01), Material(E=200e9, nu=0.3))
STRESSES = ("stress_min", "stress_max", "von_mises")


def turned(angle: float) -> np.ndarray[Any, np.dtype[np.float64]]:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def crane(reach: object = 1.0, load: object = -100.0) -> Solution:
    """A clamped mast, a boom on a compliant joint with axes of its own, and a prop under the boom."""
    frame = Frame()
    frame.body("boom", origin=(0.0, 1.0, 0.2), axes=turned(0.3))
    frame.node("foot", (0.0, 0.0, 0.2))
    frame.node("head", (0.0, 1.0, 0.2))
    frame.node("root", (0.0, 0.0, 0.0), body="boom")
    frame.node("tip", np.multiply.outer(reach, (1.0, 0.0, 0.0)), body="boom")
    frame.add("mast", BAR, "foot", "head")
    frame.add("boom", BAR, "root", "tip")
    frame.add("pin", Joint(stiffness=(2e6, 1e6, 3e6, 2e4, 3e4, 1e3), axes=turned(0.7)), "head", "root")
    frame.fix("foot")
    frame.load("tip", fy=load, fz=20.0)
    frame.line_load("boom", fy=-30.0)
    return frame.solve()


def slider(angle: object) -> Solution:
    """A bar on a hinge, held by a support that acts along x alone: a mechanism where the bar lies along x."""
    frame = Frame()
    angle = np.asarray(angle)
    frame.node("A", (0.0, 0.0, 0.0))
    frame.node("B", np.stack([np.cos(angle), np.sin(angle), 0.0 * angle], axis=-1))
    frame.add("AB", BAR, "A", "B")
    frame.fix("A", "ux", "uy", "uz", "rx", "ry")
    frame.fix("B", "ux")
    frame.load("B", fy=1.0)
    return frame.solve()


def check_beams(solution: Solution, entry: tuple[int, ...], points: Any, point_data: Any, cell_data: Any) -> None:
    """Every array of every member at a batch entry, against the solution itself."""
    frame = solution.frame
    for number, (name, member) in enumerate(frame.members.items()):
        fraction = np.linspace(0.0, 1.0, 2 * STATIONS + 1)
        at = frame.length(name)[..., None] * fraction
        rows, cells = (slice(number * n, (number + 1) * n) for n in (STATIONS + 1, STATIONS))
        start, end = (
            np.broadcast_to(frame.position(node), (*solution.shape, 3))[entry] for node in (member.start, member.end)
        )
        np.testing.assert_allclose(points[rows], start + fraction[::2, None] * (end - start), rtol=0, atol=1e-15)
        along = solution.displacement_along(name, at[..., ::2])[entry]
        np.testing.assert_array_equal(point_data["displacement"][rows], along[:, :3])
        np.testing.assert_array_equal(point_data["rotation"][rows], along[:, 3:])
        forces, stress = solution.forces(name, at)[entry], solution.stress(name, at[..., ::2])[entry]
        np.testing.assert_array_equal(point_data["N"][rows], forces[::2, 0])
        np.testing.assert_array_equal(point_data["T"][rows], forces[::2, 3])
        rows_of_axes = local_axes(end - start)
        for array, part in (("V", slice(1, 3)), ("M", slice(4, 6))):
            across = rows_of_axes[1:].T @ forces[::2, part].T
            np.testing.assert_allclose(point_data[array][rows], across.T, rtol=1e-13, atol=1e-13 * np.abs(forces).max())
            own = np.column_stack([0.0 * forces[1::2, 0], forces[1::2, part]])
            np.testing.assert_array_equal(cell_data[f"{array}_local"][cells], own)
        for k, quantity in enumerate(STRESSES):
            np.testing.assert_array_equal(point_data[quantity][rows], stress[:, k])
        np.testing.assert_array_equal(cell_data["member"][cells], number)
        np.testing.assert_array_equal(cell_data["solved"][cells], 1)


def local_axes(chord: Any) -> Any:
    """Axes of a member in the xy plane as rows: along it, across it in the plane, and z."""
    along = np.asarray(chord) / np.linalg.norm(chord)
    return np.array([along, np.cross((0.0, 0.0, 1.0), along), (0.0, 0.0, 1.0)])


def check_pin(solution: Solution, entry: tuple[int, ...], point_data: Any, row: int) -> None:
    """The joint's vectors against the solution's, turned by its axes."""
    axes = turned(0.7)
    for names, vector in (
        (("gap", "gap_rotation"), solution.joint_displacement("pin")[entry]),
        (("force", "moment"), solution.joint_force("pin")[entry]),
    ):
        for name, part in zip(names, (vector[:3], vector[3:]), strict=True):
            np.testing.assert_allclose(point_data[name][row], axes @ part, rtol=1e-14, atol=1e-16 * np.abs(part).max())
    head, root = solution.displacement("head")[entry], solution.displacement("root")[entry]
    np.testing.assert_array_equal(point_data["displacement"][row], head[:3])
    np.testing.assert_allclose(point_data["gap"][row], root[:3] - head[:3], rtol=0, atol=1e-14)


def of_lines(mesh: meshio.Mesh) -> dict[str, Any]:
    return {name: arrays[0] for name, arrays in mesh.cell_data.items()}


def test_one_pose_read_by_meshio(tmp_path: Path) -> None:
    solution = crane()
    solution.save(tmp_path / "crane.vtu")
    mesh = meshio.read(tmp_path / "crane.vtu")
    assert [(block.type, len(block.data)) for block in mesh.cells] == [("line", 2 * STATIONS), ("vertex", 1)]
    check_beams(solution, (), mesh.points, mesh.point_data, of_lines(mesh))
    check_pin(solution, (), mesh.point_data, row=-1)
    lines = np.arange(2 * (STATIONS + 1)).reshape(2, -1)
    np.testing.assert_array_equal(mesh.cells[0].data, np.stack([lines[:, :-1], lines[:, 1:]], axis=-1).reshape(-1, 2))
    assert mesh.cells[1].data.tolist() == [[len(mesh.points) - 1]]
    np.testing.assert_array_equal(mesh.points[-1], (0.0, 1.0, 0.2))
    np.testing.assert_array_equal(of_lines(mesh)["link"], [-1] * STATIONS + [0] * STATIONS)
    assert mesh.cell_data["joint"][1] == [0]
    assert (mesh.cell_data["part"][0] == 0).all()
    assert mesh.cell_data["part"][1] == [1]


def test_one_pose_read_by_pyvista(tmp_path: Path) -> None:
    solution = crane()
    solution.save(tmp_path / "crane.vtu")
    grid = pyvista.read(tmp_path / "crane.vtu")
    check_beams(solution, (), grid.points, grid.point_data, grid.cell_data)
    check_pin(solution, (), grid.point_data, row=-1)


def test_a_series_read_by_pyvista_and_meshio(tmp_path: Path) -> None:
    solution = crane(load=np.linspace(-100.0, 200.0, 4))
    times = [0.1 * 3, 0.7, 2.0 / 3.0 + 1.0, 1e6]
    solution.save(tmp_path / "crane.pvd", times=times)
    reader = pyvista.PVDReader(tmp_path / "crane.pvd")
    assert reader.time_values == times
    for pose, time in enumerate(times):
        reader.set_active_time_value(time)
        (blocks,) = reader.read()
        beams, joints = blocks["beams"], blocks["joints"]
        check_beams(solution, (pose,), beams.points, beams.point_data, beams.cell_data)
        check_pin(solution, (pose,), joints.point_data, row=0)
        mesh = meshio.read(tmp_path / "crane" / f"beams_{pose:03d}.vtu")
        check_beams(solution, (pose,), mesh.points, mesh.point_data, of_lines(mesh))
        check_pin(solution, (pose,), meshio.read(tmp_path / "crane" / f"joints_{pose:03d}.vtu").point_data, row=0)


def test_lengths_that_vary_over_the_batch(tmp_path: Path) -> None:
    solution = crane(reach=(1.0, 1.5, 2.5))
    solution.save(tmp_path / "crane.pvd")
    for pose in range(3):
        mesh = meshio.read(tmp_path / "crane" / f"beams_{pose:03d}.vtu")
        check_beams(solution, (pose,), mesh.points, mesh.point_data, of_lines(mesh))


def test_one_axis_of_a_larger_batch(tmp_path: Path) -> None:
    solution = crane(reach=np.linspace(1.0, 2.0, 3)[:, None], load=np.linspace(-10.0, 10.0, 5))
    solution.save(tmp_path / "loads.pvd", axis=1, entry=2)
    solution.save(tmp_path / "reaches.pvd", axis=0, entry=(-1,))
    solution.save(tmp_path / "one.vtu", entry=(2, 3))
    for file, entry in (("loads/beams_003", (2, 3)), ("reaches/beams_001", (1, 4)), ("one", (2, 3))):
        mesh = meshio.read(tmp_path / f"{file}.vtu")
        check_beams(solution, entry, mesh.points, mesh.point_data, of_lines(mesh))


def test_tip_deflection_and_clamp_stress_of_a_cantilever(tmp_path: Path) -> None:
    # u = P L^3 / (3 E I), sigma = P L c / I; the worst stress is on the file although no cell has it in its middle.
    frame = Frame()
    frame.node("A", (0.0, 0.0, 0.0))
    frame.node("B", (2.0, 0.0, 0.0))
    frame.add("AB", BAR, "A", "B")
    frame.fix("A")
    frame.load("B", fy=-6.0)
    frame.solve().save(tmp_path / "cantilever.vtu", stations=5)
    mesh = meshio.read(tmp_path / "cantilever.vtu")
    inertia = 0.01 * 0.02**3 / 12.0
    assert mesh.point_data["displacement"][-1, 1] == pytest.approx(-6.0 * 2.0**3 / (3.0 * 200e9 * inertia), rel=1e-12)
    assert mesh.point_data["von_mises"].max() == pytest.approx(6.0 * 2.0 * 0.01 / inertia, rel=1e-12)
    assert len(mesh.points) == 6
    assert "part" not in mesh.cell_data


def test_section_forces_jump_between_members(tmp_path: Path) -> None:
    frame = Frame()
    for name, x in (("A", 0.0), ("B", 1.0), ("C", 2.0)):
        frame.node(name, (x, 0.0, 0.0))
    frame.add("AB", BAR, "A", "B")
    frame.add("BC", BAR, "B", "C")
    frame.fix("A")
    frame.load("B", fx=5.0)
    frame.load("C", fx=2.0)
    frame.solve().save(tmp_path / "rod.vtu", stations=2)
    mesh = meshio.read(tmp_path / "rod.vtu")
    np.testing.assert_array_equal(mesh.points[:, 0], [0.0, 0.5, 1.0, 1.0, 1.5, 2.0])
    np.testing.assert_allclose(mesh.point_data["N"], [7.0, 7.0, 7.0, 2.0, 2.0, 2.0], rtol=1e-13)


def test_a_mechanism_is_told_and_holds_no_nan(tmp_path: Path) -> None:
    solution = slider([0.0, 0.8])
    with pytest.warns(MechanismWarning):
        solution.save(tmp_path / "slider.pvd")
    singular, regular = (meshio.read(tmp_path / "slider" / f"beams_{pose:03d}.vtu") for pose in range(2))
    assert (of_lines(singular)["solved"] == 0).all()
    for data in (singular.point_data, of_lines(singular)):
        for name in {"N", "V", "T", "M", "V_local", "M_local", *STRESSES} & set(data):
            assert (data[name] == 0.0).all()
    assert (singular.point_data["displacement"] == 0.0).all()
    check_beams(solution, (1,), regular.points, regular.point_data, of_lines(regular))


def test_names_come_back(tmp_path: Path) -> None:
    awkward = 'é -- <b> & "q" -->'
    frame = Frame()
    frame.body(awkward)
    frame.node("A", (0.0, 0.0, 0.0), body=awkward)
    frame.node("B", (1.0, 0.0, 0.0), body=awkward)
    frame.add(awkward, BAR, "A", "B")
    frame.fix("A")
    solution = frame.solve()
    for file in ("names.vtu", "names.pvd"):
        solution.save(tmp_path / file)
        assert read_names(tmp_path / file) == {"member": [awkward], "link": [awkward], "joint": []}
    assert pyvista.read(tmp_path / "names.vtu").n_cells == STATIONS
    assert pyvista.PVDReader(tmp_path / "names.pvd").time_values == [0.0]


def test_file_names_that_xml_would_misread(tmp_path: Path) -> None:
    solution = crane(load=(1.0, 2.0))
    solution.save(tmp_path / "a & 'b' <c>.v2.pvd")
    reader = pyvista.PVDReader(tmp_path / "a & 'b' <c>.v2.pvd")
    assert reader.read()[0]["beams"].n_cells == 2 * STATIONS


@pytest.mark.parametrize(
    ("file", "options", "message"),
    [
        ("x.vtk", {}, r"x\.vtk is neither \.vtu .* nor \.pvd"),
        ("x.vtu", {}, r"batch shape is \(2, 3\): save as \.pvd .* entry=\(0, 0\)"),
        ("x.vtu", {"entry": (0, 3)}, r"entry=\(0, 3\): give one index for each of the batch axes \(2, 3\)"),
        ("x.vtu", {"entry": 1}, r"entry=1: give one index"),
        ("x.vtu", {"entry": (0.5, 1)}, r"entry=\(0\.5, 1\): give one index"),
        ("x.vtu", {"entry": (0, 0), "axis": 0}, r"holds one pose, without axis or times"),
        ("x.vtu", {"entry": (0, 0), "times": [0.0]}, r"holds one pose, without axis or times"),
        ("x.pvd", {}, r"batch shape is \(2, 3\): choose axis= .* entry="),
        ("x.pvd", {"axis": 2, "entry": 0}, r"axis=2, but the batch shape is \(2, 3\)"),
        ("x.pvd", {"axis": 0}, r"other axes \(3,\) with entry="),
        ("x.pvd", {"axis": 0, "entry": 3}, r"entry=3: give one index for each of the batch axes \(3,\)"),
        ("x.pvd", {"axis": 0, "entry": 0, "times": [0.0]}, r"shape \(1,\): give 2 increasing numbers"),
        ("x.pvd", {"axis": 0, "entry": 0, "times": [1.0, 1.0]}, r"go from 1 to 1: give 2 increasing numbers"),
        ("x.pvd", {"axis": 0, "entry": 0, "times": [0.0, np.nan]}, r"times of x\.pvd contains nan"),
        ("x.pvd", {"axis": 0, "entry": 0, "stations": 0}, r"0 stations a member: give a whole number"),
    ],
)
def test_what_cannot_be_saved_is_refused(tmp_path: Path, file: str, options: dict[str, Any], message: str) -> None:
    solution = crane(reach=np.array([[1.0], [2.0]]), load=(1.0, 2.0, 3.0))
    with pytest.raises(FrameError, match=message):
        solution.save(tmp_path / file, **options)
    assert list(tmp_path.iterdir()) == []


def test_a_frame_of_nodes_alone_has_nothing_to_save(tmp_path: Path) -> None:
    frame = Frame()
    frame.node("A", (0.0, 0.0, 0.0))
    frame.fix("A")
    with pytest.raises(FrameError, match="no member and no joint"):
        frame.solve().save(tmp_path / "x.vtu")
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_is_a_file_is_named(tmp_path: Path) -> None:
    (tmp_path / "results").write_text("not a folder")
    for path in (tmp_path / "results" / "x.vtu", tmp_path / "results" / "deep" / "x.vtu"):
        with pytest.raises(FrameError, match=r"cannot write in .*results.*: (Not a directory|File exists); choose"):
            crane().save(path)


def test_a_missing_folder_is_made_and_after_a_failure_unmade(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    crane().save(tmp_path / "made" / "deep" / "x.vtu")
    assert (tmp_path / "made" / "deep" / "x.vtu").is_file()
    monkeypatch.setattr(blocks_module, "write_grid", full_disk(blocks_module.write_grid, 1))
    with pytest.raises(FrameError, match="No space left on device"):
        crane(load=(1.0, 2.0)).save(tmp_path / "made" / "new" / "deep" / "x.pvd")
    assert [path.name for path in (tmp_path / "made").iterdir()] == ["deep"]


@pytest.mark.parametrize("failing", ["write_grid", "write_collection"])
def test_a_failure_half_way_leaves_what_was_there(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, failing: str
) -> None:
    crane(load=(1.0, 2.0, 3.0)).save(tmp_path / "x.pvd")
    before = {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}
    monkeypatch.setattr(
        blocks_module, failing, full_disk(getattr(blocks_module, failing), 2 * (failing == "write_grid"))
    )
    with pytest.raises(FrameError, match="No space left on device"):
        crane(load=(4.0, 5.0, 6.0)).save(tmp_path / "x.pvd")
    assert {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()} == before


def full_disk(write: Callable[..., None], successes: int) -> Callable[..., None]:
    """`write`, which fails after some successes."""
    calls = iter(range(successes))

    def limited(*arguments: Any) -> None:
        if next(calls, None) is None:
            raise OSError(28, "No space left on device")
        write(*arguments)

    return limited


def test_saving_again_replaces(tmp_path: Path) -> None:
    for load in (1.0, 7.0):
        solution = crane(load=(load, 2.0 * load))
        solution.save(tmp_path / "x.pvd")
    mesh = meshio.read(tmp_path / "x" / "beams_001.vtu")
    check_beams(solution, (1,), mesh.points, mesh.point_data, of_lines(mesh))
    assert sorted(path.name for path in tmp_path.iterdir()) == ["x", "x.pvd"]


def test_section_by_its_properties(tmp_path: Path) -> None:
    """A section that does not tell where its material lies has forces but no stress: NaN, beside members that have."""
    frame = Frame()
    for name, x in {"A": 0.0, "B": 1.0, "C": 2.0}.items():
        frame.node(name, (x, 0.0, 0.0))
    frame.add("AB", Beam(Section(A=1e-4, Iy=1e-8, Iz=1e-8, J=1e-8), Material(E=200e9, nu=0.3)), "A", "B")
    frame.add("BC", BAR, "B", "C")
    frame.fix("A")
    frame.load("C", fx=5.0)
    path = tmp_path / "x.vtu"
    frame.solve().save(path)
    data = meshio.read(path).point_data
    np.testing.assert_allclose(data["N"], 5.0)
    assert np.isnan(data["von_mises"][: STATIONS + 1]).all()
    np.testing.assert_allclose(data["von_mises"][STATIONS + 1 :], 5.0 / 2e-4)


def test_names_of_a_file_from_elsewhere_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "other.vtu"
    path.write_text("<?xml version='1.0'?>\n<VTKFile/>\n", encoding="utf-8")
    with pytest.raises(FrameError, match=r"other\.vtu holds no names"):
        read_names(path)


def hinged(load: float) -> Frame:
    """A cantilever AB, and a bar BC behind a hinge about z at its tip; with a second load case that is left out."""
    frame = Frame()
    for name, x in {"A": 0.0, "B": 1.0, "end": 1.0, "C": 2.0}.items():
        frame.node(name, (x, 0.0, 0.0))
    frame.add("AB", BAR, "A", "B")
    frame.add("hinge", Joint(stiffness=(1e9,) * 3 + (1e6, 1e6, 0.0)), "B", "end")
    frame.add("BC", BAR, "end", "C")
    frame.fix("A")
    frame.load("B", fy=[load, 1.0])
    frame.exclude([False, True])
    return frame


def test_a_free_motion_on_which_no_load_works_is_left_out(tmp_path: Path) -> None:
    """The tip sinks by ``F L^3 / 3 E I``; how far the bar behind it turns, nothing tells: 0, and no NaN."""
    with pytest.warns(MechanismWarning, match="statically consistent"):
        hinged(3.0).solve().save(tmp_path / "x.vtu", entry=(0,))
    mesh = meshio.read(tmp_path / "x.vtu")
    for data in (mesh.point_data, of_lines(mesh)):
        assert all(np.isfinite(array).all() for array in data.values())
    moved, turns = mesh.point_data["displacement"], mesh.point_data["gap_rotation"]
    np.testing.assert_allclose(moved[STATIONS, 1], 3.0 / (3.0 * 200e9 * 0.01 * 0.02**3 / 12.0), rtol=1e-12)
    assert (moved[STATIONS + 2 : 2 * STATIONS + 2, 1] == 0.0).all()
    assert (turns[-1] == 0.0).all()
    assert (of_lines(mesh)["solved"] == 1).all()


def test_an_entry_left_out_holds_no_nan_at_large_displacement(tmp_path: Path) -> None:
    """Zeros, told by ``solved``: forces in global axes too, whose axes are known at the other entries alone."""
    frame = hinged(3.0)
    frame.fix("C", "uy")
    frame.solve(large=True).save(tmp_path / "x.pvd")
    for pose, there in enumerate((1, 0)):
        for part in ("beams", "joints"):
            mesh = meshio.read(tmp_path / "x" / f"{part}_{pose:03d}.vtu")
            assert all(np.isfinite(array).all() for array in mesh.point_data.values())
            assert all((array[0] == there).all() for name, array in mesh.cell_data.items() if name == "solved")
            assert there or not any(array.any() for array in mesh.point_data.values())
