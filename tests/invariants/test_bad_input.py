"""Bad input is refused by the call that made it: thing, value, remedy; the frame stays as it was."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from linkframe.elements import Beam, Circle, ISection, Joint, Material, PointMass, Rectangle, Section, Tube
from linkframe.framework import Frame, FrameError
from numpy.testing import assert_allclose

STEEL = Material(E=200e9, nu=0.3)
BAR = Rectangle(y=0.02, z=0.01)
BEAM = Beam(BAR, STEEL)
NAN, INF = float("nan"), float("inf")

# What is wrong; the call; what its message must hold: the thing, the value, the remedy.
ELEMENTS: dict[str, tuple[Callable[[], object], tuple[str, ...]]] = {
    "zero modulus": (lambda: Material(E=0.0, nu=0.3), ("Material", "E", "0", "positive")),
    "negative modulus": (lambda: Material(E=-2e11, nu=0.3), ("Material", "E", "-2e+11", "positive")),
    "NaN modulus": (lambda: Material(E=NAN, nu=0.3), ("Material", "E", "nan", "finite")),
    "infinite modulus": (lambda: Material(E=INF, nu=0.3), ("Material", "E", "inf", "finite")),
    "modulus in words": (lambda: Material(E="steel", nu=0.3), ("Material", "E", "steel", "number")),
    "modulus in digits": (lambda: Material(E="2e11", nu=0.3), ("Material", "E", "'2e11'", "number")),
    "complex modulus": (lambda: Material(E=np.array([2e11 + 1j]), nu=0.3), ("Material", "E", "1.j", "number")),
    "modulus beyond all floats": (lambda: Material(E=10**400, nu=0.3), ("Material", "E", "1000", "number")),
    "date for a modulus": (
        lambda: Material(E=np.datetime64("2020-01-01"), nu=0.3),
        ("Material", "E", "2020", "number"),
    ),
    "masked side": (lambda: Rectangle(y=np.ma.masked_less([0.02, -1.0], 0.0), z=0.01), ("Rectangle", "y", "masked")),
    "one bad modulus of many": (lambda: Material(E=[2e11, -1.0], nu=0.3), ("Material", "E", "-1", "positive")),
    "nu of 0.5": (lambda: Material(E=2e11, nu=0.5), ("Material", "nu", "0.5", "between -1 and 0.5")),
    "nu of -1": (lambda: Material(E=2e11, nu=-1.0), ("Material", "nu", "-1", "between -1 and 0.5")),
    "nu in per cent": (lambda: Material(E=2e11, nu=30.0), ("Material", "nu", "30", "between -1 and 0.5")),
    "NaN nu": (lambda: Material(E=2e11, nu=NAN), ("Material", "nu", "nan")),
    "zero G": (lambda: Material(E=2e11, G=0.0), ("Material", "G", "0", "positive")),
    "both nu and G": (lambda: Material(E=2e11, nu=0.3, G=8e10), ("Material", "nu", "G", "one")),
    "neither nu nor G": (lambda: Material(E=2e11), ("Material", "nu", "G", "one")),
    "negative density": (lambda: Material(E=2e11, nu=0.3, density=-7850.0), ("Material", "density", "-7850")),
    "shapes of a material": (
        lambda: Material(E=[1.0, 2.0], nu=[0.1, 0.2, 0.3]),
        ("Material", "E", "(2,)", "nu", "(3,)"),
    ),
    "zero side": (lambda: Rectangle(y=0.0, z=0.01), ("Rectangle", "y", "0", "positive")),
    "negative side": (lambda: Rectangle(y=0.02, z=-0.01), ("Rectangle", "z", "-0.01", "positive")),
    "NaN side": (lambda: Rectangle(y=NAN, z=0.01), ("Rectangle", "y", "nan")),
    "zero diameter": (lambda: Circle(0.0), ("Circle", "diameter", "0", "positive")),
    "solid tube": (lambda: Tube(0.02, 0.011), ("Tube", "thickness", "0.011")),
    "I-section of thick flanges": (
        lambda: ISection(height=0.1, width=0.05, web=0.005, flange=0.06),
        ("ISection", "flange", "0.06"),
    ),
    "negative area": (lambda: Section(A=-1.0, Iy=1.0, Iz=1.0, J=1.0), ("Section", "A", "-1", "positive")),
    "zero inertia": (lambda: Section(A=1.0, Iy=0.0, Iz=1.0, J=1.0), ("Section", "Iy", "0", "positive")),
    "NaN torsion constant": (lambda: Section(A=1.0, Iy=1.0, Iz=1.0, J=NAN), ("Section", "J", "nan")),
    "section too small for floats": (lambda: Rectangle(y=1e-200, z=1e-200), ("Rectangle", "A", "0", "range of floats")),
    "section too large for floats": (lambda: Rectangle(y=1e200, z=1e200), ("Rectangle", "A", "inf", "another unit")),
    "I-section too large for floats": (
        lambda: ISection(height=3e150, width=1e150, web=1e148, flange=1e148),
        ("ISection", "A", "inf", "another unit"),
    ),
    "shear in words": (lambda: Beam(BAR, STEEL, shear="no"), ("Beam", "shear", "'no'", "False")),  # type: ignore[arg-type]
    "no segments": (lambda: Beam(BAR, STEEL, segments=0), ("Beam", "segments", "0")),
    "half a segment": (lambda: Beam(BAR, STEEL, segments=2.5), ("Beam", "segments", "2.5")),
    "unknown release": (lambda: Beam(BAR, STEEL, release=("middle rz",)), ("Beam", "release", "middle rz", "start rz")),
    "too many releases": (
        lambda: Beam(BAR, STEEL, release=("start ux", "end ux")),
        ("Beam", "start ux", "end ux", "keep one"),
    ),
    "taper of two shapes": (lambda: Beam(BAR, STEEL, end=Circle(0.02)), ("Beam", "end", "Circle", "Rectangle")),
    "up without direction": (lambda: Beam(BAR, STEEL, up=(0.0, 0.0, 0.0)), ("Beam", "up", "0")),
    "negative spring": (lambda: Joint(stiffness=(1.0, -2.0, 0.0, 0.0, 0.0, 0.0)), ("Joint", "stiffness", "-2", "inf")),
    "NaN spring": (lambda: Joint(stiffness=(1.0, NAN, 0.0, 0.0, 0.0, 0.0)), ("Joint", "stiffness", "nan")),
    "five springs": (lambda: Joint(stiffness=(1.0,) * 5), ("Joint", "stiffness", "(5,)", "6")),
    "skew joint axes": (lambda: Joint(stiffness=(1.0,) * 6, axes=np.ones((3, 3))), ("Joint", "axes", "orthonormal")),
    "left-handed joint axes": (
        lambda: Joint(stiffness=(1.0,) * 6, axes=np.diag([1.0, 1.0, -1.0])),
        ("Joint", "axes", "left-handed"),
    ),
    "negative mass": (lambda: PointMass(-1.0), ("PointMass", "mass", "-1")),
}

FRAMES: dict[str, tuple[Callable[[Frame], object], tuple[str, ...]]] = {
    "duplicate node": (lambda f: f.node("A", (9.0, 0.0, 0.0)), ("node", "'A'", "another name")),
    "duplicate body": (lambda f: f.body("link"), ("body", "'link'", "another name")),
    "node on an unknown body": (lambda f: f.node("Z", (0.0, 0.0, 0.0), "wheel"), ("'Z'", "'wheel'", "'link'")),
    "node with two coordinates": (lambda f: f.node("Z", (1.0, 2.0)), ("'Z'", "(2,)", "3")),
    "node at NaN": (lambda f: f.node("Z", (1.0, NAN, 0.0)), ("'Z'", "nan", "finite")),
    "node at infinity": (lambda f: f.node("Z", (INF, 0.0, 0.0)), ("'Z'", "inf", "finite")),
    "node in words": (lambda f: f.node("Z", "here"), ("'Z'", "here", "number")),
    "skew body": (lambda f: f.body("wheel", axes=2.0 * np.eye(3)), ("'wheel'", "orthonormal")),
    "duplicate element": (lambda f: f.add("AB", BEAM, "B", "D"), ("'AB'", "another name")),
    "joint named as a member": (lambda f: f.add("AB", Joint(stiffness=(1.0,) * 6), "B", "C"), ("'AB'", "another name")),
    "member to an unknown node": (lambda f: f.add("AX", BEAM, "A", "X"), ("'AX'", "'X'", "'A'", "'B'")),
    "member of zero length": (lambda f: f.add("BC", BEAM, "B", "C"), ("'BC'", "zero length", "'B'", "'C'")),
    "member of zero length at one entry": (
        lambda f: (f.node("V", [(0.5, 0.0, 0.0), (1.0, 0.0, 0.0)]), f.add("BV", BEAM, "B", "V")),
        ("'BV'", "zero length", "1"),
    ),
    "member from a node to itself": (lambda f: f.add("AA", BEAM, "A", "A"), ("'AA'", "'A'", "two different nodes")),
    "member with one node": (lambda f: f.add("A1", BEAM, "A"), ("'A1'", "1", "2")),
    "mass at two nodes": (lambda f: f.add("ball", PointMass(1.0), "A", "B"), ("'ball'", "2", "1")),
    "up along the member": (lambda f: f.add("BD2", Beam(BAR, STEEL, up=(0.0, 1.0, 0.0)), "C", "D"), ("up", "parallel")),
    "joint apart": (
        lambda f: f.add("far", Joint(stiffness=(1.0,) * 6), "A", "B"),
        ("'far'", "'A'", "'B'", "1", "apart"),
    ),
    "joint ideal at one entry": (
        lambda f: f.add("half", Joint(stiffness=[(1.0,) * 6, (INF,) * 6]), "B", "C"),
        ("'half'", "inf", "some"),
    ),
    "joint apart at one entry": (
        lambda f: (
            f.node("V", [(1.0, 0.0, 0.0), (1.0, 0.0, 0.25)]),
            f.add("far", Joint(stiffness=(1.0,) * 6), "B", "V"),
        ),
        ("'far'", "'B'", "'V'", "0.25"),
    ),
    "support of an unknown node": (lambda f: f.fix("X"), ("'X'", "unknown", "'A'")),
    "support of an unknown component": (lambda f: f.fix("B", "uw"), ("'uw'", "ux")),
    "prescribed on an unknown node": (lambda f: f.prescribe("X", ux=1.0), ("'X'", "unknown")),
    "prescribed nothing": (lambda f: f.prescribe("B"), ("'B'", "ux")),
    "prescribed NaN": (lambda f: f.prescribe("B", ux=NAN), ("'B'", "ux", "nan")),
    "load on an unknown node": (lambda f: f.load("X", fy=1.0), ("'X'", "unknown", "'A'")),
    "load of nothing": (lambda f: f.load("B"), ("'B'", "fx")),
    "load of an unknown component": (lambda f: f.load("B", fw=1.0), ("'fw'", "fx")),
    "load of NaN": (lambda f: f.load("B", fy=NAN), ("'B'", "fy", "nan")),
    "complex load": (lambda f: f.load("B", fy=np.array([1.0 + 2.0j])), ("'B'", "fy", "2.j", "number")),
    "load in digits": (lambda f: f.load("B", fy=np.array(["1", "2"])), ("'B'", "fy", "'2'", "number")),
    "masked load": (lambda f: f.load("B", fy=np.ma.masked_invalid([1.0, NAN])), ("'B'", "fy", "masked", "leave")),
    "infinite load": (lambda f: f.load("B", fy=[1.0, INF]), ("'B'", "fy", "inf")),
    "shapes of loads": (
        lambda f: (f.load("B", fy=np.ones(3)), f.load("D", mz=np.ones((2, 4)))),
        ("mz", "'D'", "(2, 4)", "(3,)", "fy", "'B'"),
    ),
    "shapes of a node": (
        lambda f: (f.load("B", fy=np.ones(3)), f.node("Z", np.zeros((5, 3)))),
        ("'Z'", "(5,)", "(3,)", "fy", "'B'"),
    ),
    "line load on an unknown member": (lambda f: f.line_load("XY", fy=1.0), ("'XY'", "unknown", "'AB'")),
    "line load of nothing": (lambda f: f.line_load("AB"), ("'AB'", "fy")),
    "line load of a moment": (lambda f: f.line_load("AB", mz=1.0), ("'mz'", "fx")),
    "line load of NaN": (lambda f: f.line_load("AB", fy=(1.0, NAN)), ("'AB'", "fy", "nan")),
    "line load beyond the member": (lambda f: f.line_load("AB", fy=1.0, span=(0.5, 1.5)), ("'AB'", "(0.5, 1.5)", "1")),
    "line load on nothing": (lambda f: f.line_load("AB", fy=1.0, span=(0.5, 0.5)), ("'AB'", "(0.5, 0.5)", "x1 < x2")),
    "line load over text": (lambda f: f.line_load("AB", fy=1.0, span="ab"), ("'AB'", "'ab'", "two distances")),  # type: ignore[arg-type]
    "line load over three numbers": (
        lambda f: f.line_load("AB", fy=1.0, span=(0.0, 0.5, 1.0)),  # type: ignore[arg-type]
        ("'AB'", "(0.0, 0.5, 1.0)", "two distances"),
    ),
    "line load over a batch": (
        lambda f: f.line_load("AB", fy=1.0, span=(np.zeros(2), 1.0)),  # type: ignore[arg-type]
        ("'AB'", "array", "two distances"),
    ),
    "line load to a number": (lambda f: f.line_load("AB", fy=1.0, span=0.5), ("'AB'", "0.5", "two distances")),  # type: ignore[arg-type]
    "point load at text": (lambda f: f.point_load("AB", at="end", fy=1.0), ("'AB'", "'end'", "one distance")),  # type: ignore[arg-type]
    "point load at a batch": (
        lambda f: f.point_load("AB", at=np.array([0.2, 0.4]), fy=1.0),  # type: ignore[arg-type]
        ("'AB'", "array([0.2, 0.4])", "one distance"),
    ),
    "element that is a number": (lambda f: f.add("X", 3, "A", "D"), ("'X'", "3", "beam", "joint", "mass")),  # type: ignore[arg-type]
    "element that is a class": (lambda f: f.add("X", Beam, "A", "D"), ("'X'", "class", "Beam(...)")),  # type: ignore[arg-type]
    "point load on an unknown member": (lambda f: f.point_load("XY", at=0.5, fy=1.0), ("'XY'", "unknown")),
    "point load beyond the member": (lambda f: f.point_load("AB", at=1.5, fy=1.0), ("'AB'", "1.5", "length")),
    "point load of NaN": (lambda f: f.point_load("AB", at=0.5, fy=NAN), ("'AB'", "fy", "nan")),
    "point load at NaN": (lambda f: f.point_load("AB", at=NAN, fy=1.0), ("'AB'", "nan")),
    "gravity of two components": (lambda f: f.gravity((0.0, -9.81)), ("gravity", "(2,)", "3")),
    "offset of an unknown joint": (lambda f: f.offset("AB", ux=1.0), ("'AB'", "unknown", "'pin'")),
    "offset of nothing": (lambda f: f.offset("pin"), ("'pin'", "ux")),
    "offset of NaN": (lambda f: f.offset("pin", ux=NAN), ("'pin'", "ux", "nan")),
    "rigid link to an unknown node": (lambda f: f.rigid("B", "X"), ("'X'", "unknown")),
    "rigid link to itself": (lambda f: f.rigid("B", "B"), ("'B'", "two different nodes")),
    "tie of an unknown component": (lambda f: f.tie("B", "D", "up"), ("'up'", "ux")),
    "support of a number": (lambda f: f.fix(1), ("node", "1", "string")),  # type: ignore[arg-type]
    "member between numbers": (lambda f: f.add("X", BEAM, 0, 1), ("node", "0", "string")),  # type: ignore[arg-type]
    "load on a list": (lambda f: f.load(["A"], fx=1.0), ("node", "['A']", "string")),  # type: ignore[arg-type]
    "line load on a number": (lambda f: f.line_load(1, fx=1.0), ("member", "1", "string")),  # type: ignore[arg-type]
    "offset of a number": (lambda f: f.offset(1, ux=1.0), ("joint", "1", "string")),  # type: ignore[arg-type]
    "node on the body of a number": (
        lambda f: f.node("Z", (0.0, 0.0, 0.0), 1),  # type: ignore[arg-type]
        ("body", "1", "string"),
    ),
    "tie of an unknown node": (lambda f: f.tie("X", "D", "ux"), ("'X'", "unknown")),
}

READINGS: dict[str, tuple[Callable[[Frame], object], tuple[str, ...]]] = {
    "displacement of an unknown node": (lambda f: f.solve().displacement("X"), ("'X'", "known are 'A', 'B'")),
    "reaction of an unknown node": (lambda f: f.solve().reaction("X"), ("'X'",)),
    "reaction where there is no support": (lambda f: f.solve().reaction("B"), ("'B'", "support")),
    "end forces of a joint": (lambda f: f.solve().end_forces("pin"), ("'pin'", "known are 'AB'")),
    "force of a member as a joint": (lambda f: f.solve().joint_force("AB"), ("'AB'", "known are 'pin'")),
    "bound of an unknown result": (lambda f: f.solve().error_bound("C", "stress"), ("'stress'", "displacement")),
    "sensitivity of the status": (lambda f: f.solve().sensitivity("C", "ux", "status"), ("'status'", "displacement")),
    "sensitivity of a file": (lambda f: f.solve().sensitivity("C.vtu", "ux", "save"), ("'save'", "displacement")),
    "mode shape of an unknown node": (lambda f: massive(f).modes(1).shapes("X"), ("'X'", "known are 'A', 'B'")),
    "buckling shape of an unknown node": (lambda f: f.buckling(1).shapes("X"), ("'X'", "known are 'A', 'B'")),
    "half a mode": (lambda f: massive(f).modes(1.5), ("modes", "1.5", "whole number")),  # type: ignore[arg-type]
    "modes in digits": (lambda f: massive(f).modes("2"), ("modes", "'2'", "whole number")),  # type: ignore[arg-type]
    "no buckling at all": (lambda f: f.buckling(0), ("buckling", "0", "whole number")),
    "clearance in words": (
        lambda f: f.solve(clearance="no"),  # type: ignore[call-overload]
        ("clearance", "'no'", "True or False"),
    ),
    "large in words": (
        lambda f: f.solve(large="no"),  # type: ignore[call-overload]
        ("large", "'no'", "True or False"),
    ),
    "motion of an entry that is none": (lambda f: f.solve().free_motion(0), ("free_motion", "(0,)", "()")),
    "mechanism of an entry that is none": (lambda f: f.solve().mechanism(3), ("mechanism", "(3,)", "()")),
    "forces at NaN": (lambda f: f.solve().forces("AB", NAN), ("'AB'", "nan", "finite")),
    "stress in words": (lambda f: f.solve().stress("AB", "middle"), ("'AB'", "middle", "number")),  # type: ignore[arg-type]
    "forces nowhere": (lambda f: f.solve().forces("AB", []), ("'AB'", "empty", "one distance")),
    "stations of another batch": (
        lambda f: f.solve().displacement_along("AB", np.zeros((2, 1))),
        ("'AB'", "(2,)", "()", "k"),
    ),
    "forces beyond the member": (lambda f: f.solve().forces("AB", np.array([2.0])), ("'AB'", "2")),
    "modes of a structure without mass": (lambda f: f.modes(2), ("mass", "density")),
    "no modes at all": (lambda f: f.modes(0), ("0",)),
    "too many modes": (lambda f: f.modes(1000), ("1000",)),
}


def frame() -> Frame:
    """A -- B, pin, C -- D; clamped at A and D."""
    made = Frame()
    made.body("link")
    for name, place in {"A": (0, 0, 0), "B": (1, 0, 0), "C": (1, 0, 0), "D": (1, 1, 0)}.items():
        made.node(name, place)
    made.add("AB", BEAM, "A", "B")
    made.add("pin", Joint(stiffness=(2e11,) * 5 + (0.0,)), "B", "C")
    made.add("CD", BEAM, "C", "D")
    made.fix("A")
    made.fix("D")
    made.load("C", fx=10.0, fy=5.0)
    return made


def massive(made: Frame) -> Frame:
    """The frame with a mass, so that it has modes."""
    made.add("ball", PointMass(1.0, inertia=(1.0, 1.0, 1.0)), "C")
    return made


def assert_says(error: pytest.ExceptionInfo[FrameError], parts: tuple[str, ...]) -> None:
    """All parts, and more than the value alone."""
    message = str(error.value)
    for part in parts:
        assert part in message, f"{part!r} is not in: {message}"
    assert len(message.split()) >= 6


@pytest.mark.parametrize("case", ELEMENTS)
def test_elements(case: str) -> None:
    """Materials, sections, beams, joints and masses."""
    call, parts = ELEMENTS[case]
    with pytest.raises(FrameError) as error:
        call()
    assert_says(error, parts)


@pytest.mark.parametrize("case", FRAMES)
def test_frames(case: str) -> None:
    """The call is refused, and the frame can be used as if it had not been made."""
    call, parts = FRAMES[case]
    made = frame()
    with pytest.raises(FrameError) as error:
        call(made)
    assert_says(error, parts)
    # What came before the refused call in the same case may stay, and the batch that it brought; it must be sound.
    changed, untouched = made.solve().displacement("C"), frame().solve().displacement("C")
    if "shapes" not in case:
        assert_allclose(changed, np.broadcast_to(untouched, changed.shape), rtol=1e-12, atol=1e-20)


@pytest.mark.parametrize("case", READINGS)
def test_readings(case: str) -> None:
    """Results are asked for by name."""
    call, parts = READINGS[case]
    with pytest.raises(FrameError) as error:
        call(frame())
    assert_says(error, parts)


def test_arrays_of_the_user_stay_his_own() -> None:
    """What becomes of an array after the call that took it changes nothing, before and after it is solved."""
    place, force, modulus = np.array([1.0, 1.0, 0.0]), np.array([10.0, 20.0]), np.array([200e9])
    made = Frame()
    made.node("A", (0.0, 0.0, 0.0))
    made.node("B", place)
    made.add("AB", Beam(BAR, Material(E=modulus, nu=0.3)), "A", "B")
    made.fix("A")
    made.load("B", fy=force)
    before = made.solve().displacement("B").copy()
    solution = made.solve()
    for array in (place, force, modulus):
        array *= 2.0
    assert_allclose(made.solve().displacement("B"), before, rtol=0.0)
    assert_allclose(solution.displacement("B"), before, rtol=0.0)


@pytest.mark.parametrize(
    "array",
    [
        Rectangle(y=[1.0, 2.0], z=1.0).y,
        Rectangle(y=[1.0, 2.0], z=1.0).J,
        Tube(outer=[1.0, 2.0], thickness=0.1).A,
        Material(E=[1.0, 2.0], nu=0.3).G,
        Material(E=[1.0, 2.0], G=1.0).nu,
        PointMass(1.0, inertia=(1.0, 1.0, 1.0)).inertia,
        Joint(stiffness=(1.0,) * 6, axes=np.eye(3)).axes,
    ],
)
def test_what_many_frames_may_share_cannot_be_written_to(array: object) -> None:
    assert isinstance(array, np.ndarray)
    with pytest.raises(ValueError, match="read-only"):
        array[...] = 1.0


def test_names_out_of_arrays_are_told_as_what_they_say() -> None:
    """NumPy's strings print as ``np.str_('A')``, which belongs in no message and no file."""
    a, b, c = np.array(["A", "B", "C"])
    made = Frame()
    for name, place in {a: (0.0, 0.0, 0.0), b: (1.0, 0.0, 0.0), c: (1.0, 0.0, 0.0)}.items():
        made.node(name, place)
    made.add(np.str_("AB"), BEAM, a, b)
    made.add(np.str_("pin"), Joint(stiffness=(1.0,) * 6), b, c)
    made.fix(a)
    made.load(c, fx=1.0)
    made.alias(np.str_("tip"), b)
    made.line_load(np.str_("AB"), fx=1.0)
    made.offset(np.str_("pin"), ux=1e-3)
    held = (made.nodes, made.members, made.joints, made.supports, made.loads, made.aliases, made.member_loads)
    assert {type(name) for names in (*held, made.offsets) for name in names} == {str}
    assert {type(name) for member in made.members.values() for name in (member.start, member.end)} == {str}
    for call in (lambda: made.load(np.str_("X"), fx=1.0), lambda: made.node(a, (2.0, 0.0, 0.0))):
        with pytest.raises(FrameError) as error:
            call()
        assert "str_" not in str(error.value)
    solution = made.solve()
    assert_allclose(solution.displacement(c), solution.displacement("C"))
