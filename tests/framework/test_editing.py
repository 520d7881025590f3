"""A frame changed in place answers as one that was described so from the start, to the last bit."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from linkframe.elements import Beam, Circle, Joint, Material, PointMass, Rectangle
from linkframe.framework import Frame, FrameError, MechanismWarning

STEEL = Material(E=200e9, nu=0.3, density=7850.0)
BAR, ROD = Beam(Rectangle(y=0.03, z=0.02), STEEL), Beam(Circle(diameter=0.03), STEEL)
PIN = (1e8, 1e8, 1e8, 1e6, 1e6, 1e3)
SOFT = (1e7, 1e8, 1e8, 1e6, 1e6, 1e2)


def bent(
    corner: object = (1.0, 0.0, 0.0),
    *,
    bar: Beam = BAR,
    pin: object = PIN,
    mass: object = 1.0,
    tip: object = (1.0, 1.0, 0.0),
    **load: object,
) -> Frame:
    frame = Frame()
    for name, place in {"A": (0.0, 0.0, 0.0), "B": corner, "C": corner, "D": tip}.items():
        frame.node(name, place)  # type: ignore[arg-type]
    frame.alias("tip", "D")
    frame.add("AB", bar, "A", "B")
    frame.add("pin", Joint(stiffness=pin), "B", "C")  # type: ignore[arg-type]
    frame.add("CD", BAR, "C", "D")
    frame.add("lump", PointMass(mass), "D")  # type: ignore[arg-type]
    frame.fix("A")
    frame.line_load("AB", fy=-3.0, span=(0.2, 0.7))
    frame.gravity((0.0, -9.81, 0.0))
    frame.load("D", **(load or {"fx": 100.0}))  # type: ignore[arg-type]
    return frame


def answers(frame: Frame) -> list[bytes]:
    solution = frame.solve()
    arrays = [solution.displacement("D"), solution.reaction("A"), solution.end_forces("AB")]
    arrays += [solution.joint_force("pin"), solution.stress("AB", [0.1, 0.3])]
    arrays += [np.array(frame.shape), np.array(frame.size)]
    return [array.tobytes() for array in arrays]


BATCH = np.array([[1.0, 0.1, 0.0], [1.2, 0.0, 0.0]])
CHANGES: dict[str, tuple[Callable[[Frame], None], Callable[[], Frame]]] = {
    "section": (lambda f: f.change("AB", ROD), lambda: bent(bar=ROD)),
    "joint": (lambda f: f.change("pin", Joint(stiffness=SOFT)), lambda: bent(pin=SOFT)),
    "ideal joint": (
        lambda f: f.change("pin", Joint(stiffness=(np.inf,) * 6)),
        lambda: bent(pin=(np.inf,) * 6),
    ),
    "mass": (lambda f: f.change("lump", PointMass(3.0)), lambda: bent(mass=3.0)),
    "several elements": (
        lambda f: f.change(["pin", "AB", "lump"], [Joint(stiffness=SOFT), ROD, PointMass(3.0)]),
        lambda: bent(bar=ROD, pin=SOFT, mass=3.0),
    ),
    "an element and a place": (
        lambda f: (f.change("AB", ROD), f.change("tip", (1.5, 2.0, 0.3)))[0],  # type: ignore[func-returns-value]
        lambda: bent(bar=ROD, tip=(1.5, 2.0, 0.3)),
    ),
    "tip": (lambda f: f.change("tip", (1.5, 2.0, 0.3)), lambda: bent(tip=(1.5, 2.0, 0.3))),
    "tip nearer": (lambda f: f.change("D", (1.0, 0.5, 0.0)), lambda: bent(tip=(1.0, 0.5, 0.0))),
    "both nodes of a joint": (lambda f: f.change(("B", "C"), (0.9, 0.1, 0.0)), lambda: bent((0.9, 0.1, 0.0))),
    "both nodes, a place each": (
        lambda f: f.change(["C", "B"], [(0.9, 0.1, 0.0), (0.9, 0.1, 0.0)]),
        lambda: bent((0.9, 0.1, 0.0)),
    ),
    "a batch": (
        lambda f: f.change(("B", "C"), np.stack([BATCH, BATCH], axis=-2)),
        lambda: bent(BATCH),
    ),
    "load": (lambda f: f.set_load("tip", fy=[7.0, 8.0], mz=1.0), lambda: bent(fy=[7.0, 8.0], mz=1.0)),
    "load off and on": (
        lambda f: (f.set_load("D"), f.load("D", fz=2.0))[0],  # type: ignore[func-returns-value]
        lambda: bent(fz=2.0),
    ),
}


@pytest.mark.parametrize("change", CHANGES)
@pytest.mark.parametrize("solved", [False, True])
def test_as_if_described_so(change: str, solved: bool) -> None:
    frame = bent()
    before = answers(frame) if solved else None
    edit, fresh = CHANGES[change]
    edit(frame)
    found = answers(frame)
    assert found == answers(fresh())
    assert found != before


@pytest.mark.parametrize("change", CHANGES)
def test_and_back_again(change: str) -> None:
    """A batch that was given and taken back is one no more."""
    frame = bent()
    wanted, edit = answers(frame), CHANGES[change][0]
    edit(frame)
    frame.solve().displacement("D")
    for name, new in {"AB": BAR, "pin": Joint(stiffness=PIN), "lump": PointMass(1.0)}.items():
        frame.change(name, new)
    frame.change(("B", "C"), (1.0, 0.0, 0.0))
    frame.change("D", (1.0, 1.0, 0.0))
    frame.set_load("D", fx=100.0)
    assert answers(frame) == wanted


def test_random_edits_end_as_described() -> None:
    rng, frame = np.random.default_rng(5), bent()
    given: dict[str, object] = {}
    for step in range(40):
        kind = ("bar", "pin", "mass", "tip", "corner", "load")[rng.integers(6)]
        if kind == "bar":
            given["bar"] = Beam(Rectangle(y=float(rng.uniform(0.01, 0.1)), z=0.02), STEEL)
            frame.change("AB", given["bar"])  # type: ignore[arg-type]
        elif kind == "pin":
            given["pin"] = rng.choice([1e3, 1e6, np.inf], 6)
            frame.change("pin", Joint(stiffness=given["pin"]))  # type: ignore[arg-type]
        elif kind == "mass":
            given["mass"] = float(rng.uniform(0.0, 2.0))
            frame.change("lump", PointMass(given["mass"]))  # type: ignore[arg-type]
        elif kind == "tip":
            given["tip"] = rng.uniform(1.5, 3.0, 3)
            frame.change("D", given["tip"])  # type: ignore[arg-type]
        elif kind == "corner":
            given["corner"] = rng.uniform(0.8, 1.2, 3)
            frame.change(("B", "C"), given["corner"])  # type: ignore[arg-type]
        else:
            load = {"fx": float(rng.normal()), "mz": float(rng.normal())}
            given = {k: v for k, v in given.items() if k not in ("fx", "mz")} | load
            frame.set_load("D", **load)
        if step % 8 == 7:
            assert answers(frame) == answers(bent(**given))  # type: ignore[arg-type]


def test_loads_taken_off() -> None:
    frame = bent()
    frame.load("B", fx=[1.0, 2.0])
    frame.unload("B", "AB")
    assert frame.shape == ()
    assert not frame.member_loads
    assert list(frame.loads) == ["D"]
    frame.unload("tip")
    assert frame.weight is not None
    frame.unload()
    assert not np.any(frame.solve().displacement("D"))


REFUSED: dict[str, tuple[Callable[[Frame], object], str]] = {
    "unknown": (lambda f: f.change("EF", BAR), "'EF' is no member, joint or mass"),
    "other sort": (lambda f: f.change("pin", BAR), r"'pin' is a joint, and change was given Beam\(...\), a member"),
    "unknown node": (lambda f: f.change("X", (0.0, 0.0, 0.0)), "'X' is unknown"),
    "one node of a joint": (lambda f: f.change("B", (0.9, 0.0, 0.0)), "joint 'pin' joins nodes 'B' and 'C', which are"),
    "no length": (lambda f: f.change("D", (1.0, 0.0, 0.0)), "member 'CD' has zero length"),
    "load beyond": (lambda f: f.change(("B", "C"), (0.5, 0.0, 0.0)), "member 'AB' would be 0.5 long, and a load on it"),
    "twice": (lambda f: f.change(("B", "B"), (0.9, 0.0, 0.0)), "give each node once"),
    "places": (lambda f: f.change(("B", "C"), np.zeros((3, 3))), r"give \(3,\) for one place, or \(..., 2, 3\)"),
    "many elements": (lambda f: f.change(("AB", "CD"), BAR), "change them one by one"),
    "too few elements": (lambda f: f.change(("AB", "CD", "pin"), [BAR, BAR]), "2 elements for .*: give a list of one"),
    "an element twice": (lambda f: f.change(("AB", "AB"), [BAR, BAR]), "2 elements for .*: give a list of one"),
    "the second of several": (lambda f: f.change(("CD", "pin"), [BAR, BAR]), "'pin' is a joint, and change was given"),
    "none of an element": (lambda f: f.change(("AB", "CD"), [BAR, 1.0]), "'CD' is a member, and change was given 1.0"),  # type: ignore[list-item]
    "shapes of several": (
        lambda f: f.change(("CD", "AB"), [BAR, Beam(BAR.section, Material(E=[1e9] * 3, nu=0.3))]),
        r"member 'AB' has batch shape \(3,\)",
    ),
    "shapes": (
        lambda f: f.change("AB", Beam(BAR.section, Material(E=[1e9] * 3, nu=0.3))),
        r"member 'AB' has batch shape \(3,\)",
    ),
    "shapes of nodes": (
        lambda f: f.change("D", np.add(np.ones((3, 3)), [0.0, 1.0, 0.0])),
        r"node 'D' has batch shape \(3,\)",
    ),
    "shapes of loads": (lambda f: f.set_load("D", fx=[1.0, 2.0, 3.0]), "fx at 'D' has batch shape"),
    "component": (lambda f: f.set_load("D", uy=1.0), "'uy' is unknown"),
    "load": (lambda f: f.set_load("X", fx=1.0), "'X' is unknown"),
    "unload": (lambda f: f.unload("D", "X"), "neither a node nor a member"),
    "up": (
        lambda f: f.change("AB", Beam(BAR.section, STEEL, up=(1.0, 0.0, 0.0))),
        "parallel to the member",
    ),
}


@pytest.mark.parametrize("call", REFUSED)
def test_refused_and_left_as_it_was(call: str) -> None:
    frame = bent()
    frame.load("C", fx=[1.0, 2.0])
    before, held = answers(frame), repr(vars(frame))
    edit, told = REFUSED[call]
    with pytest.raises(FrameError, match=told):
        edit(frame)
    assert repr(vars(frame)) == held
    assert answers(frame) == before


def test_a_free_joint_in_place_makes_a_mechanism() -> None:
    """What can move follows the change, though the names stay."""
    frame = bent()
    frame.solve().displacement("D")
    frame.change("pin", Joint(stiffness=(1e8, 1e8, 1e8, 1e6, 1e6, 0.0)))
    with pytest.warns(MechanismWarning):
        assert np.isnan(frame.solve().displacement("D")).all()
