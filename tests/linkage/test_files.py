"""Files of linkages: what is written reads back to the last bit, and what is wrong is told with its line and key."""

from __future__ import annotations

import tomllib
from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from linkframe.elements import Beam, Circle, ISection, Material, Rectangle, Section, Tube
from linkframe.framework import FrameError
from linkframe.models.linkage import Linkage, read_linkage, write_linkage
from linkframe.models.linkage.files.toml import line_of, written
from linkframe.models.linkage.files.write import tables

FLOATS = st.floats(-1e3, 1e3)
SIZES = st.floats(1e-3, 1e3)
NAMES = st.text(st.characters(codec="utf-8", exclude_categories=("C",)), min_size=1, max_size=8)

FOUR_BAR = """\
# A four-bar.
gravity = [0.0, -9.81]

[points]
A = [0.0, 0.0]
B = [0.05, 0.0866]
D = [0.25, 0.0866]
E = [0.2, 0.0]

[links.crank]
points = ["A", "B"]
beam = "bar"

[links.coupler]
points = ["B", "D"]
beams = [
    ["B", "D", "bar"],  # one
]

[links.rocker]
points = ["D", "E"]
mass = 2.0

[joints.A]
kind = "revolute"
point = "A"
links = ["ground", "crank"]
drive = true

[joints.B]
kind = "revolute"
point = "B"
links = ["crank", "coupler"]
stiffness = [2e11, 2e11, inf, inf, inf, 0.0]
clearance = 1e-4

[joints.D]
kind = "revolute"
point = "D"
links = ["coupler", "rocker"]

[joints.E]
kind = "revolute"
point = "E"
links = ["rocker", "ground"]

[[springs]]
between = ["B", ["ground", "E"]]
stiffness = 2e3
length = 0.1

[[loads]]
point = "D"
fy = 100.0

[[loads]]
link = "rocker"
mz = 2.0

[beams.bar]
section = "flat"
material = "steel"

[sections.flat]
shape = "rectangle"
y = 0.0127
z = 0.00635

[materials.steel]
E = 2e11
nu = 0.3
density = 7850.0
"""


@st.composite
def linkages(draw: st.DrawFn) -> Linkage:
    """Anything that can be described; it need not move."""
    names = draw(st.lists(NAMES, min_size=3, max_size=5, unique=True))
    linkage = Linkage({name: draw(st.tuples(FLOATS, FLOATS, FLOATS)) for name in names})
    linkage.point("batch", draw(st.lists(st.tuples(FLOATS, FLOATS), min_size=2, max_size=2)))
    sizes = [draw(SIZES) for _ in range(4)]
    stuff = draw(st.sampled_from([Material(E=sizes[0], nu=0.3), Material(E=sizes[0], G=sizes[1], density=sizes[2])]))
    section = draw(
        st.sampled_from(
            [
                Rectangle(y=sizes[0], z=sizes[1]),
                Circle(diameter=sizes[0]),
                Tube(outer=sizes[0], thickness=sizes[0] / 7.0),
                ISection(height=sizes[0], width=sizes[0], web=sizes[0] / 9.0, flange=sizes[0] / 9.0),
                Section(A=sizes[0], Iy=sizes[1], Iz=sizes[2], J=sizes[3]),
            ]
        )
    )
    beam = Beam(section, stuff, segments=draw(st.integers(1, 3)), release=("end rz",), up=(0.1, 0.2, sizes[3]))
    linkage.link("one", *names[:2], beam=beam, mass=draw(SIZES), centre=draw(st.tuples(FLOATS, FLOATS)))
    linkage.link("two", *names, beam={(names[0], names[2]): beam}, inertia=draw(st.tuples(*[SIZES] * 3)) + (0.0,) * 3)
    springs = draw(st.tuples(*[st.sampled_from([0.0, 1.5, np.inf])] * 6))
    axis = draw(st.tuples(*[st.floats(0.1, 1.0)] * 3))
    linkage.revolute(names[0], "ground", "one", "two", axis=axis, stiffness=springs, clearance=draw(SIZES))
    linkage.screw(names[1], "one", "two", axis=axis, pitch=draw(FLOATS), reference=draw(FLOATS), drive=True)
    linkage.universal(names[1], "two", "one", axis=axis, second=(-axis[1], axis[0], 0.0))
    linkage.spring(("one", names[0]), ("ground", names[2]), stiffness=draw(SIZES), length=draw(SIZES))
    linkage.load(names[0], link="two", fx=draw(FLOATS), mz=draw(FLOATS))
    linkage.torque("one", my=draw(FLOATS), follower=draw(st.booleans()))
    linkage.gravity(draw(st.tuples(FLOATS, FLOATS, FLOATS)))
    return linkage


def same(one: object, other: object) -> bool:
    """Equal to the last bit, whatever it is made of."""
    if isinstance(one, dict):
        assert isinstance(other, dict)
        return list(one) == list(other) and all(same(one[key], other[key]) for key in one)
    if isinstance(one, list | tuple):
        assert isinstance(other, list | tuple)
        return len(one) == len(other) and all(map(same, one, other))
    if isinstance(one, np.ndarray | float):
        return np.array_equal(np.asarray(one), np.asarray(other), equal_nan=True) and np.shape(one) == np.shape(other)
    if hasattr(one, "__dataclass_fields__"):
        return type(one) is type(other) and all(
            same(getattr(one, field.name), getattr(other, field.name))
            for field in fields(one)  # type: ignore[arg-type]
        )
    return one == other


@settings(max_examples=60, deadline=None)
@given(linkage=linkages())
def test_round_trip_is_exact(linkage: Linkage, tmp_path_factory: pytest.TempPathFactory) -> None:
    path = tmp_path_factory.mktemp("files") / "linkage.toml"
    write_linkage(linkage, path)
    again = read_linkage(path)
    for part in ("points", "links", "joints", "drives", "springs", "loads", "weight"):
        assert same(getattr(linkage, part), getattr(again, part)), part
    assert again.shape == linkage.shape
    assert written(tables(again)) == path.read_text(encoding="utf-8")


@given(values=st.lists(st.floats(allow_nan=True, width=64), min_size=1), name=NAMES, text=st.text(max_size=20))
def test_toml_keeps_every_float_and_text(values: list[float], name: str, text: str) -> None:
    back = tomllib.loads(written({"table": {name: values, "x": text.replace("\x7f", "")}}))["table"]
    if name != "x":
        np.testing.assert_array_equal(np.array(back[name]).view(np.int64) if name in back else [], _bits(values))
    assert back["x"] == text.replace("\x7f", "") or name == "x"


def _bits(values: list[float]) -> object:
    # Of the many NaN one is as good as another.
    return np.where(np.isnan(values), np.nan, values).view(np.int64)


def read(text: str, tmp_path: Path) -> Linkage:
    path = tmp_path / "linkage.toml"
    path.write_text(text, encoding="utf-8")
    return read_linkage(path)


def test_what_the_file_says_is_what_is_described(tmp_path: Path) -> None:
    linkage = read(FOUR_BAR, tmp_path)
    assert list(linkage.points) == ["A", "B", "D", "E"]
    assert linkage.links["crank"].beams["A", "B"] is linkage.links["coupler"].beams["B", "D"]
    assert linkage.links["rocker"].mass == 2.0
    assert linkage.drives == {"A": ("rz",)}
    stiffness = linkage.joints["B"].stiffness
    assert stiffness is not None
    np.testing.assert_array_equal(stiffness, [2e11, 2e11, np.inf, np.inf, np.inf, 0.0])
    assert linkage.springs[0].first == ("crank", "B")
    assert linkage.springs[0].second == ("ground", "E")
    assert [(load.link, load.point) for load in linkage.loads] == [("coupler", "D"), ("rocker", None)]
    np.testing.assert_array_equal(linkage.weight, [0.0, -9.81, 0.0])


@pytest.mark.parametrize(
    ("old", "new", "line", "key", "told"),
    [
        ("D = [0.25, 0.0866]", 'D = [0.25, "0.0866"]', 7, "points.D", "give a number, or a list of numbers"),
        ("D = [0.25, 0.0866]", "D = [0.25]", 7, "points.D", "its last axis must hold"),
        ('beam = "bar"', 'beam = "rod"', 12, "links.crank.beam", "'rod': choose one of bar"),
        ('["B", "D", "bar"],  # one', '["B", "D"]', 16, "links.coupler.beams", "two points and a beam"),
        ('["B", "D", "bar"],  # one', '["B", "D", "rod"]', 16, "links.coupler.beams.0.2", "choose one of bar"),
        ("mass = 2.0", "mass = -2.0", 22, "links.rocker.mass", "-2: give zero or above"),
        ("mass = 2.0", "weight = 2.0", 22, "links.rocker.weight", "no such key here: use one of points"),
        ('points = ["D", "E"]', 'points = ["D", "F"]', 21, "links.rocker.points", "no point 'F'"),
        (
            'kind = "revolute"\npoint = "D"',
            'kind = "hinge"\npoint = "D"',
            38,
            "joints.D.kind",
            "choose one of revolute",
        ),
        ('kind = "revolute"\npoint = "D"', 'kind = "screw"\npoint = "D"', 37, "joints.D", "needs its axis"),
        ('kind = "revolute"\npoint = "D"', 'kind = "prismatic"\npoint = "D"', 37, "joints.D", "needs its axis"),
        ('links = ["coupler", "rocker"]', 'links = ["coupler", "bar"]', 40, "joints.D.links", "no link 'bar'"),
        ('links = ["coupler", "rocker"]', "pitch = 0.1", 37, "joints.D", "has no links"),
        ("drive = true", 'drive = ["uz"]', 28, "joints.A.drive", "no coordinate 'uz'"),
        ("drive = true", "pitch = 0.1", 28, "joints.A.pitch", "a revolute joint has no pitch"),
        ("clearance = 1e-4", "clearance = -1e-4", 35, "joints.B.clearance", "give zero or above"),
        ("inf, inf, inf, 0.0]", "inf]", 34, "joints.B.stiffness", "give six springs"),
        ('["ground", "E"]]', '["ground", "F"]]', 48, "springs.0.between", "no point 'F'|has no point"),
        ("length = 0.1", "length = -0.1", 50, "springs.0.length", "give zero or above"),
        ("length = 0.1", "", 47, "springs.0", "has no length"),
        ('link = "rocker"', 'link = "crankshaft"', 57, "loads.1.link", "choose one of crank"),
        ("mz = 2.0", "fz = 2.0", 56, "loads.1", "at no point: give the point"),
        ("fy = 100.0", 'fy = "100"', 54, "loads.0.fy", "give a number"),
        ("fy = 100.0", "fy = 100.0\nfollower = 1", 55, "loads.0.follower", "give true or false"),
        ('shape = "rectangle"', 'shape = "square"', 65, "sections.flat.shape", "choose one of rectangle"),
        ("z = 0.00635", "z = 0.0", 67, "sections.flat.z", "above zero"),
        ("z = 0.00635", "", 64, "sections.flat", "has no z: give shape, y, z"),
        ("nu = 0.3", "nu = 0.6", 71, "materials.steel.nu", "between -1 and 0.5"),
        ("nu = 0.3", "", 69, "materials.steel", "give one of the two, nu or G"),
        ("[materials.steel]", "[material.steel]", 69, "material", "no such table: use one of"),
        ("gravity = [0.0, -9.81]", "gravity = 9.81", 2, "gravity", "shape"),
        ("gravity = [0.0, -9.81]", 'drives = ["B"]', 2, "drives", "is B: name each driven joint once, they are A"),
        ("[points]", "[points", 4, "", "this is not TOML"),
    ],
)
def test_bad_files_are_told_by_line_and_key(old: str, new: str, line: int, key: str, told: str, tmp_path: Path) -> None:
    assert FOUR_BAR.count(old) == 1
    with pytest.raises(FrameError, match=told) as refused:
        read(FOUR_BAR.replace(old, new), tmp_path)
    message = str(refused.value)
    assert message.startswith(str(tmp_path / "linkage.toml"))
    assert f"line {line}" in message
    assert f", {key}: " in message or not key


def test_a_file_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(FrameError, match=r"none.toml cannot be read: No such file"):
        read_linkage(tmp_path / "none.toml")
    (tmp_path / "binary").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(FrameError, match="it is not UTF-8 text"):
        read_linkage(tmp_path / "binary")
    (tmp_path / "model").write_text("<mujoco/>")
    with pytest.raises(FrameError, match=r"line 1: this is XML, not TOML: where it is MJCF, linkframe convert"):
        read_linkage(tmp_path / "model")


def test_drives_keep_their_order(tmp_path: Path) -> None:
    """Which is that of columns and sums over them, to the last bit; where it is that of the joints it goes unsaid."""
    linkage = Linkage(A=(0, 0), B=(1, 0), C=(2, 0))
    linkage.link("upper", "A", "B")
    linkage.link("lower", "B", "C")
    linkage.revolute("A", "ground", "upper")
    linkage.revolute("B", "upper", "lower", drive=True)
    linkage.drive("A")
    write_linkage(linkage, tmp_path / "arm.toml")
    assert list(read_linkage(tmp_path / "arm.toml").drives) == ["B", "A"]
    linkage.drives = {"A": ("rz",), "B": ("rz",)}
    assert "drives" not in tables(linkage)


def test_lines_of_keys() -> None:
    text = 'a = 1\n[t."x y"]  # [no]\nb = [\n  [1, 2],\n  ["c = 3"]\n]\nf = 1\n[[l]]\nd.e = 2\n[[l]]\n"f" = {g = 1}\n'
    places = {("a",): 1, ("t", "x y"): 2, ("t", "x y", "b", 1): 3, ("l", 0): 8, ("l", 0, "d", "e"): 9}
    places |= {("l", 1): 10, ("l", 1, "f", "g"): 11, ("t", "x y", "f"): 7, ("t", "x y", "c"): 2, ("nothing",): 1}
    assert {path: line_of(text, path) for path in places} == places
