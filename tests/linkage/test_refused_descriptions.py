"""A call that is refused leaves linkage and frame as they were, whichever method, whatever it was given."""

from __future__ import annotations

import copy
import dataclasses
import inspect
from collections.abc import Callable, Mapping

import numpy as np
import pytest
from linkframe.elements import Beam, Circle, Joint, Material, PointMass
from linkframe.framework import Frame, FrameError
from linkframe.models import Linkage
from skfem import BilinearForm

ROD = Beam(Circle(diameter=0.02), Material(E=200e9, nu=0.3, density=7850.0))
# What nothing takes, and what fits no batch of three.
TWO, BAD = np.ones(2), (np.nan, "text", None, [1.0, "x"], object())
SIX = np.ones((2, 6))


def linkage() -> Linkage:
    made = Linkage(A=(0, 0), B=(1, 0), C=np.array([[1.0, 1.0], [1.0, 1.1], [1.0, 1.2]]))
    made.link("arm", "A", "B", beam=ROD)
    made.link("hand", "B", "C", length=1.0)
    made.revolute("A", "ground", "arm", drive=True)
    made.spring("A", "C", stiffness=1.0, length=0.5)
    made.load("C", fx=1.0)
    made.gravity((0.0, -9.81))
    return made


def frame() -> Frame:
    made = Frame()
    for name, place in {"A": (0, 0, 0), "B": (1, 0, 0), "C": (1, 0, 0), "D": (1, 1, 0)}.items():
        made.node(name, place)
    made.body("own", np.zeros((3, 3)))
    made.add("AB", ROD, "A", "B")
    made.add("pin", Joint(stiffness=(2e11,) * 5 + (0.0,)), "B", "C")
    made.add("CD", ROD, "C", "D")
    made.fix("A")
    made.load("B", fx=np.ones(3))
    return made


JOINTS = ("revolute", "prismatic", "cylindrical", "spherical", "universal", "planar", "screw", "fixed")
NEEDED = {"prismatic": {"axis": (0, 0, 1)}, "universal": {"axis": (0, 0, 1), "second": (1, 0)}}
NEEDED["screw"] = {"axis": (0, 0, 1), "pitch": 0.1}  # type: ignore[dict-item]

LINKAGE: dict[str, list[Callable[[Linkage], object]]] = {
    "point": [
        *(lambda k, v=v: k.point("Q", v) for v in (*BAD, 3.0, np.ones((2, 3)))),
        lambda k: k.point("A", (0, 0)),
    ],
    "link": [
        lambda k: k.link("new"),
        lambda k: k.link("arm", "A", "C"),
        lambda k: k.link("new", "A", "X"),
        lambda k: k.link("new", "A", "B", beam=3),
        lambda k: k.link("new", "A", "B", length=np.ones(3), beam=3),
        lambda k: k.link("new", "A", "B", length=np.ones(3), mass=-1.0),
        lambda k: k.link("new", "A", "B", length=np.ones(3), inertia=np.nan),
        lambda k: k.link("new", "A", "B", length=TWO),
        lambda k: k.link("new", "A", "B", length=np.ones(3), centre=(1, 2, 3, 4)),
        lambda k: k.link("new", "A", "B", beam=ROD, beams=[("A", "X")]),
    ],
    "drive": [lambda k: k.drive("X"), lambda k: k.drive("A", "uz"), lambda k: k.drive("A", "rz", "uz")],
    "spring": [
        *(lambda k, v=v: k.spring("A", "B", stiffness=1.0, length=v) for v in (*BAD, -1.0)),
        lambda k: k.spring("A", "A", stiffness=1.0, length=1.0),
        lambda k: k.spring("A", "C", stiffness=1.0, length=0.5),
        lambda k: k.spring("A", "C", stiffness=-1.0, length=0.5, replace=True),
    ],
    "load": [
        *(lambda k, v=v: k.load("B", fx=v) for v in BAD),
        lambda k: k.load("X", fx=1.0),
        lambda k: k.load("C", fx=1.0),
        lambda k: k.load("C", fx=np.ones(4), fy=TWO, replace=True),
        lambda k: k.load("B", link="X", fx=1.0),
    ],
    "torque": [*(lambda k, v=v: k.torque("arm", mz=v) for v in BAD), lambda k: k.torque("X", mz=1.0)],
    "gravity": [*(lambda k, v=v: k.gravity(v) for v in (*BAD, 3.0, np.ones(4)))],
    "joint": [lambda k: k.joint("X")],
    "end": [lambda k: k.end("X"), lambda k: k.end(("arm", "C"))],
    "check_free": [],
    "move": [
        lambda k: k.move(A="x"),
        lambda k: k.move(X=1.0),
        lambda k: k.move(A=np.nan),
        lambda k: k.move(branch="x"),
    ],
    "mobility": [lambda k: k.mobility(entry=9)],
    "dead_points": [lambda k: k.dead_points("X")],
    "drive_range": [lambda k: k.drive_range("X")],
    "page": [
        lambda k: k.page("page.html", "X", drives={"A": [0.0, 0.1]}),
        lambda k: k.page("page.pdf", "C", drives={"A": [0.0, 0.1]}),
        lambda k: k.page("page.html", "C", drives={"A": 0.0}),
    ],
    "plot": [lambda k: k.plot(entry=9)],
    "save": [lambda k: k.save("linkage.pdf"), lambda k: k.save("linkage.dxf", entry=9)],
    "workspace": [
        lambda k: k.workspace("C", x=[0.0, 0.1], y=[0.0, 0.1], z=[0.0, 0.1]),
        lambda k: k.workspace("X", x=[0.0, 0.1], y=[0.0, 0.1]),
        lambda k: k.workspace("C", x=[0.0, np.nan], y=[0.0, 0.1]),
    ],
    "study": [
        lambda k: k.study({"points.X.x": 1e-5}, "C", {"A": [0.0, 0.1]}),
        lambda k: k.study({"points.C.x": "wide"}, "C", {"A": [0.0, 0.1]}),
        lambda k: k.study({}, "C", {"A": [0.0, 0.1]}),
    ],
}
for kind in JOINTS:
    needed = NEEDED.get(kind, {})

    def make(given: Mapping[str, object], kind: str = kind, links: tuple[str, ...] = ("arm", "hand"), at: str = "B"):  # type: ignore[no-untyped-def]
        return lambda k: getattr(k, kind)(at, *links, **{**NEEDED.get(kind, {}), **given})

    LINKAGE[kind] = [
        *(make({"stiffness": v}) for v in (np.nan, "text", SIX[0, :3], -SIX)),
        *(make({"clearance": v}) for v in (np.nan, "text", -1.0)),
        *(
            make({"axis": v, **({} if kind != "universal" else {"second": (1, 0)})})
            for v in (*BAD, (0, 0, 0), SIX[:, :3])
        ),
        *([] if kind == "fixed" else [make({"reference": v}) for v in (*BAD, np.ones((5, 2, 4)))]),
        *([] if kind == "fixed" else [make({"drive": v}) for v in ("up", 3, ["rz", "up"])]),
        *([make({"pitch": v, "axis": np.ones((3, 3))}) for v in (*BAD, TWO)] if kind == "screw" else []),
        make({}, links=("arm", "X")),
        make({}, links=("arm", "arm")),
        make({}, at="C"),
        make({"name": "A"}),
        make({"name": "A", "replace": True, "axis": (0, 0, 0)}),
    ]
LINKAGE["revolute"] += [
    lambda k: k.revolute("B", "arm"),
    lambda k: k.revolute("B", "arm", "hand", "ground", drive=True),
    lambda k: k.revolute("A", "ground", "arm"),
]

FORM = BilinearForm(lambda u, v, w: w.k * u[1] * v[1])
FRAME: dict[str, list[Callable[[Frame], object]]] = {
    "body": [
        lambda f: f.body("own"),
        lambda f: f.body("new", axes=2.0 * np.eye(3)),
        lambda f: f.body("new", np.ones((3, 3)), np.broadcast_to(np.eye(3), (2, 3, 3))),
    ],
    "node": [
        *(lambda f, v=v: f.node("Q", v) for v in (*BAD, 3.0, np.ones((2, 3)))),
        lambda f: f.node("Q", (0, 0, 0), "X"),
        lambda f: f.node("", (9, 9, 9)),
        lambda f: f.node("A", (9, 9, 9)),
    ],
    "alias": [lambda f: f.alias("A", "B"), lambda f: f.alias("Z", "X")],
    "position": [lambda f: f.position("X")],
    "chord": [lambda f: f.chord("X")],
    "length": [lambda f: f.length("X")],
    "add": [
        lambda f: f.add("AB", ROD, "A", "D"),
        lambda f: f.add("new", ROD, "A"),
        lambda f: f.add("new", ROD, "B", "C"),
        lambda f: f.add("new", 3, "A", "B"),  # type: ignore[arg-type]
        lambda f: f.add("new", ROD, "A", "X"),
        lambda f: f.add("new", Joint(stiffness=SIX), "B", "C"),
        lambda f: f.add("new", Joint(stiffness=np.ones(6)), "A", "D"),
        lambda f: f.add("new", Joint(stiffness=np.array([[1.0] * 6, [np.inf] * 6, [1.0] * 6])), "B", "C"),
        lambda f: f.add("new", PointMass(TWO), "B"),
        lambda f: f.add("new", Beam(Circle(diameter=0.01 * TWO), ROD.material), "A", "D"),
        lambda f: f.add("new", Beam(Circle(diameter=0.01), ROD.material, up=(1, 0, 0)), "A", "B"),
    ],
    "add_form": [
        lambda f: f.add_form(FORM, on="X", k=1.0),
        lambda f: f.add_form(FORM, on=["AB", "X"], k=np.ones((4, 1))),
        *(lambda f, v=v: f.add_form(FORM, on="AB", k=v) for v in (*BAD, -1.0, TWO)),
        lambda f: f.add_form(FORM, on="AB", into="load", k=np.ones((4, 1))),
        lambda f: f.add_form(FORM, on="AB", q=np.ones((4, 1))),
        lambda f: f.add_form(3, on="AB"),
    ],
    "members_on": [lambda f: f.members_on("X"), lambda f: f.members_on([])],
    "basis": [lambda f: f.basis("X"), lambda f: f.basis("pin")],
    "rigid": [lambda f: f.rigid("A", "B", "X"), lambda f: f.rigid("A", "B", "A")],
    "tie": [lambda f: f.tie("A", "X"), lambda f: f.tie("A", "B", "ux", "uw")],
    "fix": [lambda f: f.fix("X"), lambda f: f.fix("D", "ux", "uw")],
    "prescribe": [
        *(lambda f, v=v: f.prescribe("D", ux=np.ones((4, 1)), uy=v) for v in (*BAD, np.ones((5, 1)))),
        lambda f: f.prescribe("D"),
    ],
    "offset": [lambda f: f.offset("X", ux=1.0), lambda f: f.offset("pin", ux=np.ones((4, 1)), uy=np.ones((5, 1)))],
    "load": [*(lambda f, v=v: f.load("D", fx=np.ones((4, 1)), fy=v) for v in (*BAD, TWO)), lambda f: f.load("D", fw=1)],
    "line_load": [
        *(lambda f, v=v: f.line_load("AB", fx=np.ones((4, 1)), fy=v) for v in (*BAD, TWO, (1.0, TWO))),
        lambda f: f.line_load("AB", fx=np.ones((4, 1)), span=(0.5, 0.5)),
        lambda f: f.line_load("AB", mx=np.ones((4, 1))),
    ],
    "point_load": [
        *(lambda f, v=v: f.point_load("AB", at=v, fx=np.ones((4, 1))) for v in (*BAD, 2.0, TWO)),
        lambda f: f.point_load("AB", at=0.5, fx=np.ones((4, 1)), fy=np.ones((5, 1))),
    ],
    "gravity": [*(lambda f, v=v: f.gravity(v) for v in (*BAD, np.ones((2, 3))))],
    "change": [
        *(lambda f, v=v: f.change("D", v) for v in (*BAD, 3.0, np.ones((2, 3)))),
        lambda f: f.change("X", ROD),
        lambda f: f.change("pin", ROD),
        lambda f: f.change("AB", Beam(Circle(diameter=0.01 * TWO), ROD.material)),
        lambda f: f.change("pin", Joint(stiffness=np.ones((2, 6)))),
        lambda f: f.change("C", (5.0, 5.0, 5.0)),
        lambda f: f.change(("B", "C"), (0.0, 0.0, 0.0)),
        lambda f: f.change((), (0.0, 0.0, 0.0)),
    ],
    "set_load": [
        *(lambda f, v=v: f.set_load("D", fx=np.ones((4, 1)), fy=v) for v in (*BAD, TWO)),
        lambda f: f.set_load("X"),
    ],
    "unload": [lambda f: f.unload("X")],
    "add_nodes": [
        *(lambda f, v=v: f.add_nodes(["P", "Q"], v) for v in (*BAD, 3.0, np.ones((3, 3)), np.ones((7, 2, 3)))),
        lambda f: f.add_nodes(["P", "P"], np.ones((2, 3))),
        lambda f: f.add_nodes(["P", "A"], np.ones((2, 3))),
        lambda f: f.add_nodes(["P", ""], np.ones((2, 3))),
        lambda f: f.add_nodes(["P"], np.ones((1, 3)), "X"),
    ],
    "add_many": [
        lambda f: f.add_many(ROD, [("A", "X")]),
        lambda f: f.add_many(ROD, [("A", "D"), ("B", "C")]),
        lambda f: f.add_many(ROD, [("A", "D"), ("B", "B")]),
        lambda f: f.add_many(ROD, [("A", "D", "B")]),  # type: ignore[list-item]
        lambda f: f.add_many(ROD, np.array([[0, 9]])),
        lambda f: f.add_many(ROD, [("A", "D")], ["AB"]),
        lambda f: f.add_many(ROD, [("A", "D")], ["P", "Q"]),
        lambda f: f.add_many([ROD, 3], [("A", "D"), ("A", "B")]),  # type: ignore[list-item]
        lambda f: f.add_many([ROD], [("A", "D"), ("A", "B")]),
        lambda f: f.add_many([ROD, Joint(stiffness=SIX[0])], [("A", "D"), ("B", "C")]),
        lambda f: f.add_many(Joint(stiffness=np.ones(6)), [("B", "C"), ("A", "D")]),
        lambda f: f.add_many(Beam(Circle(diameter=0.01 * TWO), ROD.material), [("A", "D")]),
        lambda f: f.add_many(Beam(Circle(diameter=0.01), ROD.material, up=(1, 0, 0)), [("A", "D"), ("A", "B")]),
    ],
    "fix_many": [lambda f: f.fix_many(["D", "X"]), lambda f: f.fix_many(["D"], "uw")],
    "load_many": [
        *(lambda f, v=v: f.load_many(["C", "D"], fx=1.0, fy=v) for v in (*BAD, np.ones(3), np.ones((7, 2)))),
        lambda f: f.load_many(["C", "X"], fx=1.0),
        lambda f: f.load_many(["C"]),
        lambda f: f.load_many(["C"], fw=1.0),
    ],
    "matrices": [lambda f: f.matrices(7), lambda f: f.matrices((0, 0, 0))],
    "exclude": [lambda f: f.exclude(1.0), lambda f: f.exclude([True, False])],
    "solve": [
        lambda f: f.solve("magic"),
        lambda f: f.solve(steps=3),
        lambda f: f.solve(clearance=1),  # type: ignore[arg-type]
        lambda f: f.solve(large=True, method="sparse"),  # type: ignore[call-overload]
    ],
    "path": [lambda f: f.path("X", "ux", 1.0), lambda f: f.path("D", "uw", 1.0), lambda f: f.path("D", "ux", 0.0)],
    "modes": [lambda f: f.modes(0)],
    "buckling": [lambda f: f.buckling(0)],
}


def state(value: object) -> object:
    """All that an object holds, as what can be compared."""
    if isinstance(value, np.ndarray):
        return value.shape, value.dtype, value.tobytes()
    if isinstance(value, dict):
        return [(key, state(part)) for key, part in value.items()]
    if isinstance(value, (list, tuple)):
        return [state(part) for part in value]
    if dataclasses.is_dataclass(value):
        return type(value), state({each.name: getattr(value, each.name) for each in dataclasses.fields(value)})
    if isinstance(value, Linkage):
        return state(vars(value))
    return copy.copy(value)


@pytest.mark.parametrize("method", LINKAGE)
def test_linkage(method: str) -> None:
    made = linkage()
    before = state(made)
    for number, call in enumerate(LINKAGE[method]):
        with pytest.raises((FrameError, TypeError)):
            pytest.fail(f"{method}, call {number}, was not refused: {call(made)}")
        assert state(made) == before, f"{method}, call {number}"


@pytest.mark.parametrize("method", FRAME)
def test_frame(method: str) -> None:
    made = frame()
    before = state(made)
    for number, call in enumerate(FRAME[method]):
        with pytest.raises((FrameError, TypeError)):
            pytest.fail(f"{method}, call {number}, was not refused: {call(made)}")
        assert state(made) == before, f"{method}, call {number}"


@pytest.mark.parametrize(
    ("table", "kind", "leave"), [(LINKAGE, Linkage, ("alike",)), (FRAME, Frame, ("copy", "explain"))]
)
def test_every_method_is_in_the_table(table: dict[str, object], kind: type, leave: tuple[str, ...]) -> None:
    methods = {name for name, _ in inspect.getmembers(kind, inspect.isfunction) if not name.startswith("_")}
    assert methods - set(leave) == set(table)


@pytest.mark.parametrize("far", [(1e20, 1e20), (0.0, 1e20), (1e20, 0.0), (-3e16, 1.0)])
def test_points_too_far_from_the_origin_to_be_told_apart(far: tuple[float, float]) -> None:
    """Doubles near 1e20 lie 16384 apart, those near 3e16 lie 4 apart, 2**(e - 52) by IEEE 754: all points coincide."""
    places = {"A": (0, 0), "B": (0, 0.1), "D": (0.24, 0.16), "E": (0.22, 0)}
    linkage = Linkage(**{name: np.add(far, place) for name, place in places.items()})
    for link, points in {"crank": "AB", "coupler": "BD", "rocker": "DE"}.items():
        linkage.link(link, *points)
    linkage.revolute("A", "ground", "crank", drive=True)
    linkage.revolute("B", "crank", "coupler")
    linkage.revolute("D", "coupler", "rocker")
    linkage.revolute("E", "rocker", "ground")
    linkage.load("D", fx=1.0)
    apart = "1.6e+04" if max(far) == 1e20 else "4"
    with pytest.raises(
        FrameError, match=r"point '\w' lies .* from the origin.*give coordinates from an origin"
    ) as told:
        linkage.move(A=0.1).reactions()
    assert f"numbers are {apart} apart" in str(told.value)
