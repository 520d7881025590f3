"""A planar linkage loaded across its plane: u_z in every table and picture, by the closed form of a cantilever."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from linkframe.models.command_line import main
from linkframe.models.job import figures
from linkframe.models.linkage.job.figures import _spreading, draw
from linkframe.models.linkage.job.inputs import read_inputs
from linkframe.models.linkage.job.remarks import remarks
from linkframe.models.linkage.job.report import report
from linkframe.models.linkage.job.result import compute
from linkframe.models.linkage.job.table import as_text
from linkframe.models.sampling import draw as drawn
from numpy.testing import assert_allclose

ARM = """\
[points]
A = [0.0, 0.0]
B = [0.5, 0.0]

[links.arm]
points = ["A", "B"]
beam = "bar"

[joints.A]
kind = "revolute"
point = "A"
links = ["ground", "arm"]
drive = true

[[loads]]
point = "B"
fx = 0.0
fy = 0.0
fz = 100.0

[beams.bar]
section = "flat"
material = "steel"

[sections.flat]
shape = "rectangle"
y = 0.01
z = 0.02

[materials.steel]
E = 2e11
nu = 0.3

[run]
pose = 30.0
samples = 40

[run.drives.A]
values = [0.0, 30.0, 60.0]
unit = "deg"

[tolerances.load]
of = ["loads.0.fz"]
distribution = "norm"
scale = "5 %"
"""
# F l³ / (3 E I), I = b h³ / 12 with the height of the section across the plane.
PER_FORCE = 0.5**3 / (3.0 * 2e11 * 0.01 * 0.02**3 / 12.0)


def arm(folder: Path, *changes: tuple[str, str]):
    text = ARM
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    path = folder / "arm.toml"
    path.write_text(text, encoding="utf-8")
    return compute(read_inputs(path))


def columns(text: str) -> dict[str, list[str]]:
    bare = re.sub(r"\(\d+\)", "", text)  # without standard errors
    heading, *rows = (line.split() for line in bare.replace("drive A", "drive").replace("mean ", "mean_").splitlines())
    return dict(zip(heading, zip(*rows, strict=True), strict=True))  # type: ignore[arg-type]


def test_tables_show_the_displacement_across(tmp_path: Path) -> None:
    result = arm(tmp_path)
    found = columns(as_text(result))
    assert_allclose(np.array(found["u_z"], float), 100.0 * PER_FORCE, rtol=1e-3)
    force = drawn(result.inputs.distributions, 40, 0)["load"]
    assert_allclose(np.array(found["σ_z"], float), 100.0 * force.std(ddof=1) * PER_FORCE, rtol=1e-2)
    text = report(result).text({}, [], {})
    assert "| part | u_x | u_y | u_z |" in text
    assert f"| compliance | 0 | 0 | {1e5 * PER_FORCE:.4g} |" in text


@pytest.mark.parametrize("plane", ["xz", "yz"])
def test_in_any_plane(plane: str, tmp_path: Path) -> None:
    """The same arm turned into another plane, the load across it."""
    first, second = plane
    across = next(iter(set("xyz") - set(plane)))
    at = {"x": "[0.5, 0.0, 0.0]", "y": "[0.0, 0.5, 0.0]"}[first]
    normal = {"x": "[1.0, 0.0, 0.0]", "y": "[0.0, 1.0, 0.0]"}[across]
    up = {"z": "[0.0, 0.0, 1.0]"}[second]
    result = arm(
        tmp_path,
        ("[0.5, 0.0]", at),
        ("drive = true", f"drive = true\naxis = {normal}"),
        ('material = "steel"', f'material = "steel"\nup = {normal}'),
        ("fz = 100.0", "fz = 0.0"),
        (f"f{across} = 0.0", f"f{across} = 100.0"),
        ("loads.0.fz", f"loads.0.f{across}"),
    )
    assert up
    found = columns(as_text(result))
    assert_allclose(np.array(found[f"u_{across}"], float), 100.0 * PER_FORCE, rtol=1e-3)


def test_a_load_across_in_the_samples_only(tmp_path: Path) -> None:
    result = arm(
        tmp_path,
        ("fz = 100.0", "fz = 0.0"),
        ('scale = "5 %"', "loc = 0.0\nscale = 5.0"),
        ("fy = 0.0", "fy = 100.0"),
    )
    assert result.shown == (0, 1, 2)
    assert np.all(np.array(columns(as_text(result))["σ_z"], float) > 0.0)
    assert _spreading(result) == [2]


def test_a_load_in_the_plane_shows_the_plane(tmp_path: Path) -> None:
    result = arm(tmp_path, ("fz = 100.0", "fz = 0.0"), ("fy = 0.0", "fy = 100.0"), ("loads.0.fz", "loads.0.fy"))
    assert result.shown == (0, 1)
    assert "u_z" not in columns(as_text(result))


def test_histograms_are_of_what_spreads(tmp_path: Path) -> None:
    """Of the three components one spreads; a component of one value would be a solid bar."""
    pictures = draw(arm(tmp_path))
    (axes,) = pictures["histogram.png"].axes
    assert "u_z" in axes.get_xlabel()
    assert len(axes.patches) > 3
    assert pictures["trajectory.png"].axes[0].name == "3d"
    assert _spreading(arm(tmp_path, ("loads.0.fz", "materials.steel.nu"))) == []


def test_samples_that_are_all_the_same_have_no_density() -> None:
    """No fit, and no warning of one."""
    same = np.full((30, 2), 1e-3) * (1.0 + 1e-15 * np.arange(30.0)[:, None])
    drawing = figures.draw_histograms([(same, ("P", "xy"))], "here")
    assert all("all samples the same: 1 mm" in axes.get_title(loc="left") for axes in drawing.axes)


def test_displacements_beyond_the_linkage_are_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A modulus in GPa: the arm of 0.5 m would be displaced by kilometres."""
    path = tmp_path / "arm.toml"
    path.write_text(ARM.replace("E = 2e11", "E = 200.0"), encoding="utf-8")
    assert main(["run", str(path), "--figures", "none", "--out", str(tmp_path / "out")]) == 0
    wanted = 100.0 * PER_FORCE * 1e9
    told = f"B is displaced by up to {wanted:.3g} m at A = 0°, A = 30°, A = 60°, further than the linkage is large"
    assert told in capsys.readouterr().out
    assert told in (tmp_path / "out" / "report.md").read_text(encoding="utf-8")


def test_tolerances_that_move_nothing_are_told(tmp_path: Path) -> None:
    result = arm(tmp_path, ("loads.0.fz", "materials.steel.nu"), ("pose = 30.0", "pose = 90.0"))
    assert remarks(result) == [
        "The tolerances do not move B: its standard deviation is 0 at all poses.",
        "The pose 90 is beyond the drive's values; the figures show A = 60°.",
    ]
