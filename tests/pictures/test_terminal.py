"""What objects say of themselves, tables that fit the terminal, and the file to begin with."""

from __future__ import annotations

import tomllib
from pathlib import Path

import numpy as np
import pytest
from linkframe.elements import Beam, Joint, Material, Rectangle
from linkframe.framework import Frame, FrameError, MechanismWarning
from linkframe.framework.pictures.shapes import prism
from linkframe.models import Linkage, SobolIndices, read_linkage
from linkframe.models.command_line import main
from linkframe.models.job.tables import aligned, folded
from linkframe.models.linkage.files.sketch_file import write_sketch
from linkframe.models.linkage.graphics.bodies import MotionBodies
from numpy.testing import assert_allclose

BAR = Beam(Rectangle(y=0.02, z=0.01), Material(E=200e9, nu=0.3))


def parallelogram() -> Linkage:
    linkage = Linkage(A=(0, 0), B=(0, 1), C=(2, 1), D=(2, 0))
    links = ("ground", "AB", "BC", "CD", "ground")
    for link in links[1:-1]:
        linkage.link(link, *link, beam=BAR)
    for k, pin in enumerate("ABCD"):
        linkage.revolute(pin, links[k], links[k + 1], drive=pin == "A")
    linkage.load("C", fy=-100.0)
    return linkage


# -- what is printed of objects ---------------------------------------------------------------------------------------


def test_a_motion_and_a_solution_count_their_states() -> None:
    motion = parallelogram().move(A=np.radians([0.0, 30.0, 90.0]))
    assert repr(motion).endswith(": 2 regular, 1 singular direct>")
    assert repr(motion.accuracy("C")) == f"<PointAccuracy of C.BC in {motion!r}>"
    solution = motion.frame().solve()
    assert repr(solution) == f"<Solution of {solution.frame!r}>"
    _ = solution.status
    assert repr(solution).endswith(": 2 regular, 1 mechanism>")


def test_results_are_short_tables() -> None:
    motion = parallelogram().move(A=np.radians([0.0, 30.0, 90.0]))
    with pytest.warns(MechanismWarning):
        stress = motion.stress("BC")
    title, heading, row = repr(stress).splitlines()
    assert title.startswith("Stress of shape (3,)")
    assert heading.split()[:3] == ["member", "least", "greatest"]
    assert float(row.split()[3]) == pytest.approx(np.nanmax(stress.von_mises), rel=1e-3)
    frame = Frame()
    for name, x in {"A": 0.0, "B": 1.0, "C": 1.0, "D": 3.0}.items():
        frame.node(name, (x, 0.0, 0.0))
    frame.add("AB", BAR, "A", "B")
    frame.add("hinge", Joint(stiffness=(1e8, 1e8, 1e8, 1e6, 1e6, 0.0)), "B", "C")
    frame.add("CD", BAR, "C", "D")
    frame.fix("A")
    frame.load("D", fy=1.0)
    free = frame.solve().free_motion()
    lines = repr(free).splitlines()
    assert lines[0].startswith("FreeMotion: 1 motion of ")
    told = {line.split()[0]: float(line.split()[-1]) for line in lines[2:]}
    assert told == pytest.approx({name: moved[0, 5] for name, moved in free.joints.items()}, rel=1e-3)
    indices = SobolIndices(("a", "b"), *(np.array([share, 1.0 - share]) for share in (0.25, 0.2, 0.01, 0.02)))
    assert [line.split()[0] for line in repr(indices).splitlines()] == ["input", "b", "a"]


def test_notebooks_show_drawings_and_tables() -> None:
    linkage = parallelogram()
    assert linkage._repr_html_().count("<svg") == 1
    assert "<svg" not in Linkage(A=(0, 0))._repr_html_()
    frame = linkage.move(A=np.radians([0.0, 30.0])).frame()
    assert frame._repr_html_().count("<tr>") >= 3 + 4
    solution = frame.solve()
    html = solution._repr_html_()
    assert "2 regular" in html
    most = np.abs(solution.displacement("C")[:, 1]).max()
    assert f">{most:.4g}<" in html
    assert frame.explain()._repr_html_().startswith("<pre>")  # type: ignore[attr-defined]


# -- tables -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("width", [20, 33, 60, None])
def test_a_table_fits_the_terminal(width: int | None) -> None:
    lines = [["A", *(f"column{k}" for k in range(7)), "status"], ["10", *(f"{k}.5" for k in range(7)), "not assembled"]]
    tables = aligned(lines, width).split("\n\n")
    assert all(table.split()[0] == "A" for table in tables)
    if width is None:
        assert len(tables) == 1
    else:
        assert max(len(line) for table in tables for line in table.splitlines()[:1]) <= width
    words = [word for table in tables for word in table.splitlines()[0].split()[1:]]
    assert words == lines[0][1:]


# -- a file to begin with ---------------------------------------------------------------------------------------------


def test_a_new_file_is_a_linkage_that_runs(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "sketch.toml"
    assert main(["new", str(file)]) == 0
    assert f"linkframe run {file}" in capsys.readouterr().out
    text = file.read_text(encoding="utf-8")
    assert sum("#" in line for line in text.splitlines()) > 25
    assert set(tomllib.loads(text)) >= {"points", "links", "joints", "loads", "run", "tolerances"}
    assert read_linkage(file).move(A=np.linspace(0.0, 6.2, 20)).is_regular.all()
    assert main(["run", str(file), "--figures", "none", "--out", str(tmp_path / "out")]) == 0
    assert "displacement u of P" in capsys.readouterr().out
    assert main(["new", str(file)]) == 2
    assert "is there already and is left as it is" in capsys.readouterr().err
    assert file.read_text(encoding="utf-8") == text
    with pytest.raises(FrameError, match=r"does not end in \.toml"):
        write_sketch(tmp_path / "sketch.txt")


# -- bodies in space --------------------------------------------------------------------------------------------------


def test_links_in_space_have_their_sections() -> None:
    """A bar of 20 by 10 mm between its points, with its longer side in the plane; joints stand along their axes."""
    motion = parallelogram().move(A=np.radians([0.0, 30.0]))
    bodies = MotionBodies(motion, (0, 1))
    found, moved = bodies.surfaces(0), bodies.surfaces(1)
    assert set(found) == {"link AB", "link BC", "link CD", "joints", "drives", "ground", "forces"}
    assert_allclose(np.ptp(found["link BC"][0].points, axis=0), [2.0, 0.02, 0.01], rtol=1e-12)
    assert_allclose(np.ptp(found["link AB"][0].points, axis=0), [0.02, 1.0, 0.01], rtol=1e-12)
    way = motion.position("B")[1] - motion.position("A")[1]
    assert_allclose(np.ptp(moved["link AB"][0].points @ way), 1.0, rtol=1e-12)
    assert all(len(found[name][0].points) == len(moved[name][0].points) for name in found)
    for surface, _ in found.values():
        assert_allclose(np.linalg.norm(surface.normals, axis=-1), 1.0, rtol=1e-9)
    pin = found["drives"][0].points
    assert_allclose(0.5 * (pin.min(axis=0) + pin.max(axis=0)), 0.0, atol=1e-12)
    assert np.ptp(pin[:, 2]) > np.ptp(pin[:, 0])
    assert bodies.scene(0).arrows[0].text == "100 N"


def test_a_prism_looks_outwards() -> None:
    square = np.array([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)])
    body = prism(square, np.zeros(3), np.array([4.0, 0.0, 0.0]), np.eye(3))
    middle = np.array([2.0, 0.0, 0.0])
    assert np.all(np.sum((body.points - middle) * body.normals, axis=-1) > 0.0)


@pytest.mark.parametrize("width", [40, 60, 80, 120])
def test_folded_tables_keep_vectors_whole(width: int) -> None:
    """Positions, displacements and what stands right of the bar are never torn apart nor taken for each other."""
    heading = ["θ", "x", "y", "z", "u_x", "u_y", "u_z", "│", "μ_x", "μ_y", "κ", "status"]
    rows = [heading, [*["1.234567"] * 7, "│", *["7.6(2)e-04"] * 3, "singular: B in line"]]
    tables = [table.splitlines()[0].split() for table in aligned(rows, width).split("\n\n")]
    assert [name for table in tables for name in table[1:] if name != "│"] == [n for n in heading[1:] if n != "│"]
    for family in ({"x", "y", "z"}, {"u_x", "u_y", "u_z"}, {"μ_x", "μ_y"}):
        assert [family <= set(table) for table in tables if family & set(table)] == [True]
    assert all("│" in table for table in tables if {"μ_x", "κ"} & set(table))
    assert all(len(line) <= width for line in aligned(rows, width).splitlines())


def test_sentences_are_folded_and_units_stay_whole() -> None:
    text = "drive base [N m], position of a point with a long name [rad / s], status\n\na  table\n1      2"
    lines = folded(text, 24).splitlines()
    assert max(map(len, lines)) <= 24
    assert lines[-2:] == ["a  table", "1      2"]
    assert "[rad / s]" in "\n".join(lines)
    assert folded(text, None) == text


def test_an_option_that_is_not_there_is_told_by_its_job(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit, match="2"):
        main(["four-bar", "--steps", "5"])
    assert capsys.readouterr().err == (
        "linkframe four-bar: error: --steps 5: no such option; linkframe four-bar --help lists them\n"
    )
