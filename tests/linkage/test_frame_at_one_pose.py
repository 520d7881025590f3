"""The frame of one pose is the same whether or not the linkage was framed at another pose before."""

from __future__ import annotations

import gc
from dataclasses import fields, is_dataclass
from weakref import ref

import numpy as np
import pytest
from linkframe.elements import Beam, Circle, Material, Rectangle
from linkframe.framework import Frame
from linkframe.models import Linkage
from linkframe.models.linkage.statics.frame import Builder

STEEL = Material(E=200e9, nu=0.3, density=7850.0)
BAR = Beam(Rectangle(y=12.7e-3, z=6.35e-3), STEEL)


def four_bar() -> Linkage:
    linkage = Linkage(A=(0, 0), B=(0, 0.1), P=(0.12, 0.19), D=(0.24, 0.16), E=(0.22, 0))
    linkage.link("crank", "A", "B", beam=BAR)
    linkage.link("coupler", "B", "P", "D", beam=BAR)
    linkage.link("rocker", "D", "E", beam=BAR)
    linkage.revolute("A", "ground", "crank", drive=True)
    linkage.revolute("B", "crank", "coupler", stiffness=(2e8, 2e8, 2e8, 2e5, 2e5, 0.0))
    linkage.revolute("D", "coupler", "rocker", clearance=1e-4)
    linkage.revolute("E", "rocker", "ground")
    linkage.load("P", fy=100.0)
    return linkage


def cardan() -> Linkage:
    """Two shafts at 30 degrees and a cross between them, the ground not upright."""
    tilt = np.array([np.cos(np.pi / 6), np.sin(np.pi / 6), 0.0])
    linkage = Linkage(A=(-1, 0, 0), O=(0, 0, 0), B=tuple(tilt))
    linkage.link("in", "A", "O", beam=Beam(Circle(diameter=0.03), STEEL))
    linkage.link("out", "O", "B", beam=Beam(Circle(diameter=0.03), STEEL))
    linkage.revolute("A", "ground", "in", axis=(1, 0, 0), drive=True)
    linkage.universal("O", "in", "out", axis=(0, 0, 1), second=(-tilt[1], tilt[0], 0.0))
    linkage.revolute("B", "out", "ground", axis=tilt)
    return linkage


def assert_same(one: object, other: object) -> None:
    """That two descriptions hold the same numbers, to the last bit."""
    assert type(one) is type(other)
    if isinstance(one, np.ndarray):
        np.testing.assert_array_equal(one, other)
        assert one.flags.writeable == other.flags.writeable  # type: ignore[union-attr]
    elif isinstance(one, dict):
        assert list(one) == list(other)  # type: ignore[call-overload]
        for name in one:
            assert_same(one[name], other[name])  # type: ignore[index]
    elif isinstance(one, list | tuple):
        for x, y in zip(one, other, strict=True):  # type: ignore[call-overload]
            assert_same(x, y)
    elif is_dataclass(one):
        for each in fields(one):
            if each.name not in ("made_from", "kept"):
                assert_same(getattr(one, each.name), getattr(other, each.name))
    else:
        assert one == other


@pytest.mark.parametrize("make", [four_bar, cardan])
def test_it_is_the_same_whatever_was_framed_before(make: object) -> None:
    linkage = make()  # type: ignore[operator]
    linkage.move(A=0.2).frame()
    for angle, tolerance in ((1.1, 0.0), (-2.0, 1e-5), (0.2, 0.0)):
        again = linkage.move(A=angle, tolerance=tolerance).frame()
        anew = make().move(A=angle, tolerance=tolerance).frame()  # type: ignore[operator]
        assert isinstance(again, Frame)
        assert_same(again, anew)
        solutions = again.solve(clearance=False), anew.solve(clearance=False)
        np.testing.assert_array_equal(*(solution.displacement("B") for solution in solutions))


def test_what_is_described_anew_is_framed_anew() -> None:
    linkage = four_bar()
    linkage.move(A=0.2).frame()
    linkage.revolute("E", "rocker", "ground", stiffness=(1e7, 1e7, 1e7, 1e4, 1e4, 0.0), replace=True)
    linkage.load("P", fx=7.0)
    found = linkage.move(A=0.3).frame().solve(clearance=False).displacement("P")
    again = four_bar()
    again.revolute("E", "rocker", "ground", stiffness=(1e7, 1e7, 1e7, 1e4, 1e4, 0.0), replace=True)
    again.load("P", fx=7.0)
    np.testing.assert_array_equal(found, again.move(A=0.3).frame().solve(clearance=False).displacement("P"))


def test_a_frame_of_its_own_may_be_changed() -> None:
    linkage = four_bar()
    first = linkage.move(A=0.2).frame()
    first.load("P", fy=5e3)
    first.add("more", BAR, "A", "E")
    second = linkage.move(A=0.2).frame()
    assert_same(second, four_bar().move(A=0.2).frame())


def test_what_is_kept_does_not_keep_the_linkage() -> None:
    linkage = four_bar()
    linkage.move(A=0.2).frame()
    assert linkage.move(A=0.3).state == 0
    gone = ref(linkage)
    del linkage
    gc.collect()
    assert gone() is None


def test_bodies_and_joints_alone_are_described(monkeypatch: pytest.MonkeyPatch) -> None:
    linkage = four_bar()
    linkage.move(A=0.2).frame()
    monkeypatch.setattr(Builder, "link", None)
    assert linkage.move(A=0.7).frame().nodes.keys() == linkage.move(A=0.2).frame().nodes.keys()
