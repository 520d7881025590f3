"""Two frames that differ in one item share nothing that is kept of a topology, whichever of them comes first."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np
import pytest
from linkframe.elements import Beam, Joint, Material, Rectangle
from linkframe.framework import Frame
from linkframe.framework.cache import FORMULAS, KERNELS, ORDERS, PATTERNS, PROGRAMS, STACKS, TERMS

PLACES = {"A": (0.0, 0.0), "B": (0.3, 0.1), "C": (0.3, 0.1), "D": (0.7, 0.2), "E": (0.8, -0.2), "F": (0.4, -0.3)}
HEIGHTS = {"D": 0.1, "F": -0.2}
MEMBERS = {"AB": "AB", "CD": "CD", "DE": "DE", "EF": "EF", "FB": "FB"}


def beam(E: object = 200e9, **given: object) -> Beam:
    return Beam(Rectangle(y=0.0127, z=0.00635), Material(E=E, nu=0.3), **given)  # type: ignore[arg-type]


def pin(*turning: float, **given: object) -> Joint:
    return Joint((2e8, 2e8, 2e8, *(turning or (2e5, 2e5, 10.0))), **given)  # type: ignore[arg-type]


def described(
    *,
    members: dict[str, str] = MEMBERS,
    joint: Joint | None = None,
    elements: dict[str, Beam] | None = None,
    held: tuple[str, ...] = ("ux", "uy", "uz", "rx"),
    ends: str = "BC",
    loaded: dict[str, object] | None = None,
    more: Callable[[Frame], None] | None = None,
    moved: object = 0.0,
) -> Frame:
    frame, moved = Frame(), np.asarray(moved)
    for name, (x, y) in PLACES.items():
        off = moved if name == "D" else 0.0
        frame.node(name, np.stack(np.broadcast_arrays(x + off, y, HEIGHTS.get(name, 0.0)), axis=-1))
    for name, pair in members.items():
        frame.add(name, (elements or {}).get(name, beam()), *pair)
    frame.add("pin", joint or pin(), *ends)
    frame.fix("A")
    frame.fix("E", *held)
    for name, force in (loaded or {"D": 100.0}).items():
        frame.load(name, fy=force, fz=-20.0)
    if more:
        more(frame)
    return frame


MANY = np.linspace(0.9, 1.1, 3)
OTHERS: dict[str, Callable[[], Frame]] = {
    "another component is held": partial(described, held=("ux", "uy", "uz", "ry")),
    "one component more is held": partial(described, held=("ux", "uy", "uz", "rx", "ry")),
    "the joint turns freely": partial(described, joint=pin(2e5, 2e5, 0.0)),
    "the joint is ideal": partial(described, joint=pin(np.inf, 2e5, 10.0)),
    "the joint has a pitch": partial(described, joint=pin(pitch=0.05)),
    "the joint is turned": partial(
        described, joint=pin(axes=np.array([[0.6, -0.8, 0.0], [0.8, 0.6, 0.0], [0.0, 0.0, 1.0]]))
    ),
    "the joint has its nodes exchanged": partial(described, ends="CB"),
    "a member has its ends exchanged": partial(described, members=MEMBERS | {"DE": "ED"}),
    "a member goes to another node": partial(described, members=MEMBERS | {"FB": "FC"}),
    "a member is left out": partial(described, members={k: v for k, v in MEMBERS.items() if k != "FB"}),
    "a member is released": partial(described, elements={"DE": beam(release=("end rz",))}),
    "a member is cut": partial(described, elements={"DE": beam(segments=2)}),
    "another node is loaded": partial(described, loaded={"F": 100.0}),
    "two nodes are loaded": partial(described, loaded={"D": 100.0, "F": 50.0}),
    "a member is loaded": partial(described, more=lambda frame: frame.line_load("DE", fy=100.0)),
    "a node is displaced": partial(described, more=lambda frame: frame.prescribe("E", ux=1e-4)),
    "a joint is offset": partial(described, more=lambda frame: frame.offset("pin", ux=1e-4)),
    "two nodes are tied": partial(described, more=lambda frame: frame.tie("F", "D", "uy")),
    "one modulus varies": partial(described, elements={"DE": beam(200e9 * MANY)}),
    "another modulus varies": partial(described, elements={"EF": beam(200e9 * MANY)}),
    "the load varies": partial(described, loaded={"D": 100.0 * MANY}),
    "a place varies": partial(described, moved=1e-2 * MANY),
    "two axes vary": partial(described, elements={"DE": beam(200e9 * MANY)}, loaded={"D": 100.0 * MANY[:, None]}),
}


def forget() -> None:
    for kept in (ORDERS, PATTERNS, TERMS, PROGRAMS, KERNELS, FORMULAS, STACKS):
        kept.clear()


def found(make: Callable[[], Frame], times: int = 1) -> list[np.ndarray]:
    """Displacements and the forces of the joint, of so many frames one after the other."""
    out = []
    for _ in range(times):
        solution = make().solve()
        out.append(np.concatenate([solution.displacement("D"), solution.joint_force("pin")], axis=-1))
    return out


@pytest.mark.parametrize("other", OTHERS)
def test_neither_takes_up_what_was_kept_of_the_other(other: str) -> None:
    makes = [described, OTHERS[other]]
    forget()
    alone = []
    for make in makes:
        alone.append(found(make)[0])
        forget()
    for first, second in ((0, 1), (1, 0)):
        forget()
        found(makes[first], 6)
        for again in found(makes[second]):
            np.testing.assert_allclose(again, alone[second], rtol=1e-10, atol=1e-18)


def offset(**given: object) -> Callable[[], Frame]:
    return partial(described, more=lambda frame: frame.offset("pin", **given))  # type: ignore[arg-type]


def displaced(**given: object) -> Callable[[], Frame]:
    return partial(described, more=lambda frame: frame.prescribe("A", **given))  # type: ignore[arg-type]


STEP = 1e-4 * MANY
ONLY_THE_COMPONENT: dict[str, tuple[Callable[[], Frame], Callable[[], Frame]]] = {
    "the offset": (offset(ux=STEP), offset(uy=STEP)),
    "a force in place of a moment": (offset(ux=STEP), offset(rz=STEP)),
    "two offsets": (offset(uy=STEP, uz=2.0 * STEP), offset(rx=STEP, ry=2.0 * STEP)),
    "the displacement": (displaced(ux=STEP), displaced(uz=STEP)),
    "an offset in place of a pitch": (partial(described, joint=pin(pitch=200.0 * STEP)), offset(uz=STEP)),
}


@pytest.mark.parametrize("pair", ONLY_THE_COMPONENT)
@pytest.mark.parametrize("first", [0, 1])
def test_batches_that_differ_in_the_component_of_a_number_alone(pair: str, first: int) -> None:
    """Both have as many numbers, that vary over the same axes: which of the components they are of tells them apart."""
    makes = ONLY_THE_COMPONENT[pair]
    forget()
    alone = found(makes[1 - first])[0]
    forget()
    found(makes[first], 6)
    for again in found(makes[1 - first], 2):
        np.testing.assert_allclose(again, alone, rtol=1e-10, atol=1e-18)
