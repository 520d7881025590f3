"""Tolerances in a file: each number varies about its own value, and what cannot be meant is refused by its line."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from linkframe.framework import FrameError
from linkframe.models import Linkage
from linkframe.models.linkage.files.read import linkage_of
from linkframe.models.linkage.files.source import Source
from linkframe.models.linkage.files.write import tables
from linkframe.models.linkage.job.inputs import RunInputs, read_inputs
from linkframe.models.linkage.job.report import report
from linkframe.models.linkage.job.result import compute
from linkframe.models.linkage.study.tolerances import toleranced
from numpy.testing import assert_allclose, assert_array_equal

EXAMPLES = Path(__file__).parents[2] / "examples"
LINKAGE = """\
gravity = [0.0, -9.81, 0.5]

[points]
A = [0.0, 0.0, 0.1]
B = [0.1, 0.02]
C = [0.4, 0.03]
Q = [0.3, 0.3]

[links.crank]
points = ["A", "B"]
beam = "bar"
length = 0.15

[links.rod]
points = ["B", "C"]
mass = 2.0
centre = [0.2, 0.05]
inertia = [0.1, 0.2, 0.3, 0.01, 0.02, 0.03]

[joints.A]
kind = "cylindrical"
point = "A"
links = ["ground", "crank"]
drive = ["rz", "uz"]
reference = [0.05, 0.7]

[joints.B]
kind = "revolute"
point = "B"
links = ["crank", "rod"]
stiffness = [2e8, 2e8, inf, 2e2, 3e2, 0.0]
clearance = 1e-5
axis = [0.1, 0.2, 1.0]

[[springs]]
between = ["C", ["ground", "A"]]
stiffness = 2e3
length = 0.1
damping = 3.0

[[loads]]
point = "C"
fy = -500.0
mz = 0.0

[beams.bar]
section = "flat"
material = "steel"

[sections.flat]
shape = "rectangle"
y = 0.02
z = 0.01

[sections.spare]
shape = "circle"
diameter = 0.05

[materials.steel]
E = 2e11
nu = 0.3
density = 7850.0

[joints.C]
kind = "planar"
point = "C"
links = ["ground", "rod"]
axis = [0.0, 1.0, 0.0]

[run.drives.A.rz]
values = [0.0, 10.0]
unit = "deg"

[run.drives.A.uz]
values = [0.05]
"""
# Numbers that a tolerance may name, and where they stand.
NAMED = {
    "gravity.y": ("gravity", 1),
    "points.B.x": ("points", "B", 0),
    "points.A.2": ("points", "A", 2),
    "links.crank.length": ("links", "crank", "length"),
    "links.rod.mass": ("links", "rod", "mass"),
    "links.rod.centre.x": ("links", "rod", "centre", 0),
    "links.rod.inertia.zz": ("links", "rod", "inertia", 2),
    "joints.A.reference.rz": ("joints", "A", "reference", 1),
    "joints.B.stiffness.ry": ("joints", "B", "stiffness", 4),
    "joints.B.clearance": ("joints", "B", "clearance"),
    "joints.B.axis.y": ("joints", "B", "axis", 1),
    "springs.0.stiffness": ("springs", 0, "stiffness"),
    "springs.0.damping": ("springs", 0, "damping"),
    "loads.0.fy": ("loads", 0, "fy"),
    "sections.flat.y": ("sections", "flat", "y"),
    "materials.steel.E": ("materials", "steel", "E"),
}


def tolerance(of: str, numbers: str = 'distribution = "norm"\nscale = "5 %"', name: str = "t") -> str:
    return f"\n[tolerances.{name}]\nof = {of}\n{numbers}\n"


def inputs(folder: Path, text: str) -> RunInputs:
    path = folder / "f.toml"
    path.write_text(text, encoding="utf-8")
    return read_inputs(path)


def numbers(value: Any) -> Iterator[float]:
    """All numbers in tables and lists."""
    if isinstance(value, dict):
        for entry in value.values():
            yield from numbers(entry)
    elif isinstance(value, list | tuple):
        for entry in value:
            yield from numbers(entry)
    elif isinstance(value, np.ndarray):
        yield from value.ravel().tolist()
    elif isinstance(value, float | np.floating):
        yield float(value)


@settings(max_examples=25, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(name=st.sampled_from(sorted(NAMED)), share=st.floats(-0.2, 0.2).filter(lambda x: abs(x) > 1e-3))
def test_one_number_named_is_that_number_alone(name: str, share: float, tmp_path: Path) -> None:
    """Against the file with that number scaled by hand: all else stays, to the last bit."""
    given = inputs(tmp_path, LINKAGE + tolerance(f'["{name}"]'))
    varied = tables(given.varied({"t": np.array(share)}))
    source = Source(tmp_path / "f.toml")
    *above, last = NAMED[name]
    here: Any = source.data
    for key in above:
        here = here[key]
    here[last] = float(here[last] * (1.0 + share))
    assert list(numbers(varied)) == list(numbers(tables(linkage_of(source, Linkage))))
    assert list(numbers(varied)) != list(numbers(tables(given.linkage)))


def test_a_percentage_of_a_list_scales_each_number_by_itself(tmp_path: Path) -> None:
    """Free and ideal springs stay so; the spread of each is 5 % of its own."""
    given = inputs(tmp_path, LINKAGE + tolerance('["joints.B.stiffness"]') + tolerance('["points.B"]', name="p"))
    draws = np.random.default_rng(0).normal(0.0, 0.05, 1000)
    stiffness = given.varied({"t": draws, "p": draws}).joints["B"].stiffness
    assert stiffness is not None
    assert_array_equal(stiffness[:, [2, 5]], np.tile([np.inf, 0.0], (1000, 1)))
    for k, nominal in ((0, 2e8), (1, 2e8), (3, 2e2), (4, 3e2)):
        assert_allclose(stiffness[:, k], nominal * (1.0 + draws), rtol=1e-14)


def test_a_percentage_in_space_and_sign(tmp_path: Path) -> None:
    for scale, wanted in (("5 %", 0.05), ("± 5%", 0.05), (" 1e1 % ", 0.1), (".5 %", 0.005)):
        given = inputs(tmp_path, LINKAGE + tolerance('["loads.0.fy"]', f'distribution = "norm"\nscale = "{scale}"'))
        law: Any = given.tolerances["t"].distribution
        assert law.std() == pytest.approx(wanted)
        assert f"scale={100 * wanted:g} %" in given.tolerances["t"].description


def test_the_mean_of_samples_is_near_the_nominal_answer(tmp_path: Path) -> None:
    """Rotational springs of 200 beside translational ones of 2e8: one draw for both once gave 2e8 to all."""
    folder = Path(__file__).parents[2] / "examples" / "four_bar.toml"
    text = folder.read_text(encoding="utf-8").replace("rng = 0", "rng = 0\n").replace("samples = 100", "samples = 200")
    text = text.replace("[2e11, 2e11, 2e11, 2e11, 2e11, 0.0]", "[2e8, 2e8, 2e8, 2e2, 2e2, 0.0]").replace(
        "steps = 37", "steps = 3"
    )
    text = text[: text.index("[tolerances")].replace("fy = 100.0", "fy = 100.0\nfz = 100.0")
    text = re.sub(r"(clearance|contact) = .*\n", "", text)
    told = (
        r"joints.B.stiffness.ux is 2e\+08 and joints.B.stiffness.rx is 200: one draw of norm\(loc=2e\+08, .*in percent"
    )
    with pytest.raises(FrameError, match=told):
        inputs(tmp_path, text + tolerance('["joints.B.stiffness"]', 'distribution = "norm"\nloc = 2e8\nscale = 1e6'))
    result = compute(
        inputs(tmp_path, text + tolerance('["joints.B.stiffness"]', 'distribution = "norm"\nscale = "0.5 %"'))
    )
    spread = result.spread["P"]
    good = np.isfinite(result.main.total[:, :3]).all(axis=-1)
    off = np.abs(spread.mean - result.main.total[:, :3])[good]
    assert np.all(off <= 5.0 * spread.standard_error[good] + 1e-15)
    assert np.all(spread.std[good, 2] > 0.0)


@pytest.mark.parametrize(
    ("of", "law", "key", "told"),
    [
        ('["joints.B.stiffness"]', 'distribution = "norm"\nloc = 2e8\nscale = 1e6', "of", "one draw of norm"),
        (
            '["points.B"]',
            'distribution = "norm"\nloc = 0.1\nscale = 1e-3',
            "of",
            "points.B.x is 0.1 and points.B.y is 0.02",
        ),
        ('["points.B.x", "points.C.x"]', 'distribution = "norm"\nloc = 0.1\nscale = 1e-3', "of", "points.C.x is 0.4"),
        ('["links.rod.mass"]', 'distribution = "norm"\nloc = 2.0', "", "has no scale"),
        ('["links.rod.mass"]', 'distribution = "norm"\nloc = "1 %"', "", "has no scale"),
        (
            '["links.rod.mass"]',
            'distribution = "norm"\nloc = 2.0\nscale = 0',
            "",
            "is not defined for loc = 2, scale = 0",
        ),
        (
            '["links.rod.mass"]',
            'distribution = "norm"\nscale = 0.1',
            "",
            "has the mean 0 and spreads by 0.1, but links.rod.mass is 2",
        ),
        ('["links.rod.mass"]', 'distribution = "norm"\nloc = 2.2\nscale = 0.1', "", "has the mean 2.2"),
        ('["links.rod.mass"]', 'distribution = "uniform"\nloc = 2.1\nscale = 0.1', "", "has the mean 2.15"),
        ('["links.rod.mass"]', 'distribution = "cauchy"\nloc = 3.0\nscale = 0.1', "", "has the mean 3"),
        (
            '["links.rod.mass"]',
            'distribution = "truncnorm"\na = -9\nb = 9\nloc = 2.5\nscale = 0.1',
            "",
            "has the mean 2.5",
        ),
        (
            '["links.rod.mass"]',
            'distribution = "norm"\nloc = "100 %"\nscale = "5 %"',
            "",
            "deviates by 100 % on average",
        ),
        ('["links.rod.mass"]', 'distribution = "norm"\nloc = 2.0\nscale = "5 %"', "loc", "beside scale in percent"),
        (
            '["links.rod.mass"]',
            'distribution = "norm"\nscale = "5"',
            "scale",
            "is '5': give a number, or loc and scale in percent",
        ),
        ('["links.rod.mass"]', 'distribution = "lognorm"\ns = "5 %"\nscale = 2.0', "s", "is '5 %': give a number"),
        ('["links.rod.mass"]', 'distribution = "norm"\nloc = 2.0\nscale = [0.1]', "scale", "give one number"),
        (
            '["links.rod.mass", "links.rod.mass"]',
            'distribution = "norm"\nscale = "5 %"',
            "of.1",
            "links.rod.mass a second time",
        ),
        (
            '["points.B", "points.B.y"]',
            'distribution = "norm"\nscale = "5 %"',
            "of.1",
            "names points.B.y a second time",
        ),
        ('["joints.B.axis"]', 'distribution = "norm"\nscale = "5 %"', "of.0", "is a direction, which has no size"),
        ('["joints.B.stiffness.uz"]', 'distribution = "norm"\nscale = "5 %"', "of.0", "inf alone cannot vary"),
        ('["loads.0.mz"]', 'distribution = "norm"\nscale = "5 %"', "of.0", "is 0, of which a percentage is 0"),
        (
            '["joints.B.stiffness.kx"]',
            'distribution = "norm"\nscale = "5 %"',
            "of.0",
            "has no 'kx': give one of ux, uy, uz, rx, ry, rz",
        ),
        (
            '["points.B.z"]',
            'distribution = "norm"\nscale = "5 %"',
            "of.0",
            "has no 'z': give one of x, y, or a number from 0 to 1",
        ),
        ('["loads.1.fy"]', 'distribution = "norm"\nscale = "5 %"', "of.0", "loads has no '1'"),
        ('["loads.first.fy"]', 'distribution = "norm"\nscale = "5 %"', "of.0", "loads has no 'first'"),
        ('["loads.0"]', 'distribution = "norm"\nscale = "5 %"', "of.0", "name a number"),
        ('["joints.B.kind"]', 'distribution = "norm"\nscale = "5 %"', "of.0", "name a number"),
        (
            '["sections.spare.diameter"]',
            'distribution = "norm"\nscale = "5 %"',
            "",
            "has no effect, as the linkage does not use",
        ),
        (
            '["points.Q.x"]',
            'distribution = "norm"\nscale = "5 %"',
            "",
            "has no effect, as the linkage does not use points.Q.x",
        ),
    ],
)
def test_what_cannot_be_meant_is_refused(of: str, law: str, key: str, told: str, tmp_path: Path) -> None:
    text = LINKAGE + tolerance(of, law)
    line = LINKAGE.count("\n") + 2
    if key:
        starts = (row.split(" =")[0] for row in text.splitlines()[line:])
        line += 1 + list(starts).index(key.split(".")[0])
    place = f"tolerances.t.{key}" if key else "tolerances.t"
    with pytest.raises(FrameError, match=rf"line {line}, {re.escape(place)}: .*{re.escape(told)}"):
        inputs(tmp_path, text)


@pytest.mark.parametrize(
    "law",
    [
        'distribution = "norm"\nloc = 1.95\nscale = 0.1',
        'distribution = "uniform"\nloc = 2.0\nscale = 0.1',  # a tolerance on one side
        'distribution = "uniform"\nloc = 1.9\nscale = 0.1',
        'distribution = "lognorm"\ns = 0.05\nscale = 2.0',
        'distribution = "cauchy"\nloc = 2.0\nscale = 0.1',
        'distribution = "triang"\nc = 0.5\nloc = "-5 %"\nscale = "10 %"',
        'distribution = "expon"\nloc = 2.0\nscale = 0.1',
    ],
)
def test_laws_about_the_nominal_value_are_taken(law: str, tmp_path: Path) -> None:
    assert list(inputs(tmp_path, LINKAGE + tolerance('["links.rod.mass"]', law)).tolerances) == ["t"]


def test_one_number_has_one_tolerance(tmp_path: Path) -> None:
    text = LINKAGE + tolerance('["joints.B.stiffness"]') + tolerance('["joints.B.stiffness.4"]', name="u")
    with pytest.raises(FrameError, match=r"tolerances.u.of: joints.B.stiffness.ry is in tolerance 't', too"):
        inputs(tmp_path, text)


def test_samples_out_of_range_are_blamed_on_their_tolerance(tmp_path: Path) -> None:
    law = 'distribution = "norm"\nloc = 1e-5\nscale = 1e-5'
    given = inputs(tmp_path, LINKAGE + tolerance('["joints.B.clearance"]', law))
    line = LINKAGE.count("\n") + 2
    told = r"tolerances\.t: samples of joints\.B\.clearance (are|reach from) -.*give zero or above"
    with pytest.raises(FrameError, match=rf"line {line}, {told}"):
        _ = compute(given).spread
    given = inputs(tmp_path, LINKAGE + tolerance('["joints.B.stiffness"]', 'distribution = "norm"\nscale = "60 %"'))
    with pytest.raises(
        FrameError, match=rf"line {line}, tolerances.t: samples of joints.B.stiffness.0 reach"
    ) as refused:
        _ = compute(given).spread
    assert len(str(refused.value)) < 500


@pytest.mark.parametrize("option", ["samples = 10", "rng = 1", 'sampler = "lhs"', 'nan_policy = "omit"'])
def test_options_of_samples_need_tolerances(option: str, tmp_path: Path) -> None:
    text = LINKAGE.replace("[run.drives.A.rz]", f"[run]\n{option}\n\n[run.drives.A.rz]")
    with pytest.raises(FrameError, match=rf"run\.{option.split(' ')[0]}: has no effect, as the file has no tolerances"):
        inputs(tmp_path, text)
    inputs(tmp_path, text + tolerance('["links.rod.mass"]'))


def test_a_clearance_has_room_in_its_link(tmp_path: Path) -> None:
    with pytest.raises(FrameError, match=r"joints\.B\.clearance: is 0\.5, no less than link 'crank' is long \(0\.1428"):
        inputs(tmp_path, LINKAGE.replace("clearance = 1e-5", "clearance = 0.5"))


def test_a_job_is_of_one_linkage(tmp_path: Path) -> None:
    with pytest.raises(FrameError, match=r"run: mass of rod: a list of shape \(2,\)"):
        inputs(tmp_path, LINKAGE.replace("mass = 2.0", "mass = [2.0, 3.0]"))


UNITS = {
    "gravity.y": "m/s²", "points.B.x": "m", "links.rod.mass": "kg", "links.rod.inertia.zz": "kg m²",
    "joints.A.reference.rz": "rad", "joints.A.reference.uz": "m", "joints.B.stiffness.ux": "N/m",
    "joints.B.stiffness.ry": "N m/rad", "joints.B.clearance": "m", "joints.B.axis.y": "", "springs.0.damping": "N s/m",
    "loads.0.fy": "N", "sections.flat.y": "m", "materials.steel.E": "Pa", "materials.steel.density": "kg/m³",
}  # fmt: skip


@pytest.mark.parametrize(("name", "unit"), UNITS.items())
def test_a_tolerance_has_the_name_and_the_unit_of_its_number(name: str, unit: str, tmp_path: Path) -> None:
    path = tmp_path / "f.toml"
    path.write_text(LINKAGE, encoding="utf-8")
    found = toleranced(Source(path), name, 1e-3)
    assert found.names == (name,)
    assert found.unit == unit
    assert toleranced(Source(path), name, "± 5 %").unit == "of each number"


def test_a_tolerance_of_a_moment_is_in_newton_metres(tmp_path: Path) -> None:
    path = tmp_path / "f.toml"
    path.write_text(LINKAGE, encoding="utf-8")
    assert toleranced(Source(path), "loads.0.mz", 1e-3).unit == "N m"


def test_the_report_lists_tolerances_with_their_units(tmp_path: Path) -> None:
    """By the names of the file, and to all digits of their numbers."""
    text = (EXAMPLES / "four_bar.toml").read_text(encoding="utf-8").partition("[tolerances")[0]
    place = tomllib.loads(text)["points"]["P"][0] + 1e-7
    text += tolerance('["points.P.x"]', f'distribution = "norm"\nloc = {place:.7f}\nscale = 1e-6')
    text += tolerance('["joints.B.stiffness"]', name="springs")
    lines = report(compute(replace(inputs(tmp_path, text), samples=2).at_pose(3))).text({}, [], {}).splitlines()
    assert f"| t | norm(loc={place:.7f}, scale=1e-06) | m | points.P.x |" in lines
    assert "| springs | norm(scale=5 %) | of each number | joints.B.stiffness |" in lines


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ("-5 %", "tolerance '-5 %': write it as '± 0.1'"),
        ("± 500 %", r"samples of joints\.B\.clearance are -\S+: clearance of joint 'B' is -\S+: give zero or above"),
    ],
)
def test_a_tolerance_is_refused_in_the_words_it_was_given_in(given: str, told: str, tmp_path: Path) -> None:
    with pytest.raises(FrameError, match=told):
        inputs(tmp_path, LINKAGE + tolerance('["joints.B.clearance"]', f'tolerance = "{given}"'))
