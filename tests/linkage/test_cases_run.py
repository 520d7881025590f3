"""Springs in a linkage that is run, drawn and saved: they have no stress, and are no beams."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from linkframe.elements import Beam, Circle, Material
from linkframe.framework.pictures.drawing import drawing
from linkframe.models import Linkage
from linkframe.models.command_line import main
from linkframe.models.linkage import read_linkage, write_linkage
from numpy.testing import assert_array_equal

ROD = Beam(Circle(diameter=0.02), Material(E=2e11, nu=0.3))
RUN = """
[run]
points = ["B"]
[run.drives.A]
values = [0.0, 10.0]
unit = "deg"
rate = 5.0
"""


def arm(beam: Beam | None) -> Linkage:
    linkage = Linkage(A=(0, 0), B=(1, 0), C=(0, 1))
    linkage.link("arm", "A", "B", beam=beam, mass=2.0)
    linkage.revolute("A", "ground", "arm", drive=True)
    linkage.spring("B", ("ground", "C"), stiffness=50.0, length=1.0, damping=3.0)
    linkage.load("B", fy=-10.0)
    return linkage


def test_scale_of_stress_leaves_springs_out():
    solution = arm(ROD).move(A=[0.0, 0.1]).frame().solve()
    shown = drawing(solution, (slice(None),), None, "von_mises")
    assert np.isnan(shown.values).any()
    greatest = np.nanmax(shown.values)
    assert greatest <= shown.top < 1.5 * greatest


@pytest.mark.parametrize("beam", [None, ROD])
def test_linkage_with_a_spring_is_run(tmp_path: Path, beam: Beam | None):
    linkage, file = arm(beam), tmp_path / "arm.toml"
    write_linkage(linkage, file)
    again = read_linkage(file)
    drive = linkage.move(A=0.1, rates={"A": 2.0}).reactions().drive("A")
    assert_array_equal(again.move(A=0.1, rates={"A": 2.0}).reactions().drive("A"), drive)
    file.write_text(file.read_text() + RUN)
    main(["run", str(file), "--figures", "2d", "--out", str(tmp_path / "out")])
    assert (tmp_path / "out" / "trajectory.pvd").exists()
    assert ("| rigid |" in (tmp_path / "out" / "report.md").read_text()) == (beam is None)
