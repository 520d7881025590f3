"""What is described by one call is what would be described one by one."""

from __future__ import annotations

import gc
import re
import time
from functools import partial

import numpy as np
import pytest
from linkframe.elements import Beam, Circle, Joint, Material, Rectangle
from linkframe.framework import Frame, FrameError

STEEL = Material(E=200e9, nu=0.3, density=7850.0)
BAR = Beam(Rectangle(y=0.03, z=0.02), STEEL)
PIN = Joint(stiffness=(1e8, 1e8, 1e8, 1e6, 1e6, 1e3))
PLACES = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.2], [1.0, 0.0, 0.2], [2.0, 1.0, 0.0]])


def pairs(element: object, at: list[tuple[str, str]]) -> list[tuple[object, tuple[str, str]]]:
    each = element if isinstance(element, list) else [element] * len(at)
    return list(zip(each, at, strict=True))


def answers(frame: Frame) -> list[bytes]:
    solution = frame.solve()
    arrays = [solution.displacements(), solution.reactions(), solution.all_end_forces(), np.array(frame.size)]
    return [array.tobytes() for array in arrays]


@pytest.mark.parametrize("batch", [False, True])
@pytest.mark.parametrize("body", [None, "link"])
@pytest.mark.parametrize("element", [BAR, [BAR, Beam(Circle(diameter=0.03), STEEL, segments=3)]], ids=["one", "each"])
def test_as_one_by_one(element: object, body: str | None, batch: bool) -> None:
    places = PLACES + 0.01 * np.arange(3.0)[:, None, None] if batch else PLACES
    forces = np.arange(6.0).reshape(3, 2) if batch else np.array([1.0, -2.0])
    names, members = ["A", "B", "C", "D"], [("A", "B"), ("C", "D")]
    one, other = Frame(), Frame()
    for frame in (one, other):
        frame.body("link", (0.0, 0.0, 1.0), [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    for k, name in enumerate(names):
        one.node(name, places[..., k, :], body)
    assert other.add_nodes(names, places, body) == names
    for k, (each, at) in enumerate(pairs(element, members)):
        one.add(str(k), each, *at)  # type: ignore[arg-type]
    assert other.add_many(element, members) == ["0", "1"]  # type: ignore[arg-type]
    one.add("pin", PIN, "B", "C")
    other.add_many(PIN, np.array([[1, 2]]), ["pin"])
    one.fix("A")
    one.fix("D", "ux", "uz")
    other.fix_many(["A"])
    other.fix_many(["D"], "ux", "uz")
    for k, node in enumerate(("B", "D")):
        one.load(node, fy=forces[..., k], mz=3.0)
    other.load_many(["B", "D"], fy=forces, mz=3.0)
    assert one.shape == other.shape == ((3,) if batch else ())
    assert answers(one) == answers(other)


@pytest.mark.parametrize("batch", [False, True])
def test_one_element_with_arrays_is_one_for_each(batch: bool) -> None:
    """Numbers along the last axis are those of the members; a batch that is the same for all has an axis of one."""
    y, E = np.array([0.03, 0.04, 0.05]), np.array([[1e11], [2e11]]) if batch else 2e11
    places = np.stack([np.arange(4.0), np.arange(4.0) ** 2, 0.0 * np.arange(4.0)], axis=-1)
    at = np.array([[0, 1], [1, 2], [2, 3]])
    one, other = Frame(), Frame()
    for frame in (one, other):
        frame.add_nodes(4, places)
        frame.fix("0")
        frame.load("3", fx=1.0)
    bars = Beam(Rectangle(y=y, z=0.02), Material(E=E, nu=0.3), up=np.array([[0, 0, 1], [0, 1, 1], [0, 0, 2.0]]))
    one.add_many(bars, at)
    for k in range(3):
        steel = Material(E=np.ravel(E) if batch else E, nu=0.3)
        other.add(str(k), Beam(Rectangle(y=y[k], z=0.02), steel, up=bars.up[k]), str(k), str(k + 1))  # type: ignore[index]
    assert one.shape == other.shape == ((2,) if batch else ())
    assert answers(one) == answers(other)
    assert len(one.solve().plan.topology.groups) == 1
    twins = Frame()
    twins.add_nodes(4, np.zeros((4, 3)))
    k = np.arange(1.0, 3.0)[:, None] * np.ones(6)
    twins.add_many(Joint(stiffness=k), [("0", "1"), ("2", "3")], ["a", "b"])
    assert [float(twins.joints[name].element.stiffness[0]) for name in "ab"] == [1.0, 2.0]
    with pytest.raises(FrameError, match=r"Beam for 2 members has batch shape \(3,\): give \(..., 2\) with one for"):
        one.add_many(Beam(Rectangle(y=y, z=0.02), STEEL), at[:2])


def test_names_count_on() -> None:
    frame = Frame()
    frame.node("A", (0.0, 0.0, 1.0))
    assert frame.add_nodes(2, PLACES[:2]) == ["1", "2"]
    assert frame.add_nodes(0, np.zeros((0, 3))) == []
    assert frame.add_many(BAR, []) == []
    assert frame.add_many(BAR, [("A", "1"), ("1", "2")]) == ["0", "1"]
    frame.alias("tip", "2")
    frame.load_many(["tip"], fx=1.0)
    assert list(frame.loads) == ["2"]
    frame.node("3", (0.0, 0.0, 4.0))
    with pytest.raises(FrameError, match="node '3' exists already"):
        frame.add_nodes(["5", "3"], PLACES[:2])


def test_many_take_no_longer_than_some() -> None:
    """Ten thousand beams by three calls, in a fraction of the time that they take one by one."""

    def one_by_one(n: int) -> float:
        start, frame = time.process_time(), Frame()
        for k in range(n + 1):
            frame.node(f"n{k}", (float(k), 0.0, 0.0))
        for k in range(n):
            frame.add(f"m{k}", BAR, f"n{k}", f"n{k + 1}")
        return time.process_time() - start

    def at_once(n: int) -> float:
        start, frame = time.process_time(), Frame()
        x = np.arange(n + 1.0)
        frame.add_nodes(n + 1, np.stack([x, 0.0 * x, 0.0 * x], axis=-1))
        frame.add_many(BAR, np.stack([np.arange(n), np.arange(1, n + 1)], axis=-1))
        frame.fix_many(["0"])
        frame.load_many(list(frame.nodes)[1:], fy=x[1:])
        return time.process_time() - start

    alone, together = (min(way(4000) for _ in range(3)) for way in (one_by_one, at_once))
    assert together < 0.4 * alone


def test_nothing_that_is_made_in_bulk_is_searched_for_garbage() -> None:
    """The search goes on afterwards, where something is refused as well."""
    begun: list[str] = []

    def note(phase: str, _: object) -> None:
        begun.append(phase)

    x, frame = np.arange(20_000.0), Frame()
    ends = np.stack([np.arange(len(x) - 1), np.arange(1, len(x))], axis=-1)
    gc.collect()
    gc.callbacks.append(note)
    try:
        frame.add_nodes(len(x), np.stack([x, 0.0 * x, 0.0 * x], axis=-1))
        frame.add_many(BAR, ends)
        with pytest.raises(FrameError, match="given 1 names"):
            frame.add_many(BAR, ends, ["a"])
    finally:
        gc.callbacks.remove(note)
    # once at most behind each of the three
    assert begun.count("start") <= 3
    assert gc.isenabled()


@pytest.mark.parametrize("far", [1e155, 1e-155, np.array([1.0, 1e101])])
@pytest.mark.parametrize("at_once", [False, True])
def test_lengths_whose_powers_no_float_holds_are_refused(far, at_once):
    """They had ended as a mechanism, or in an error of the eigenvalues."""
    frame = Frame()
    frame.add_nodes(["A", "B"], np.multiply.outer(far, [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0)]))
    told = f"member 'AB' is {np.max(far):.3g} long" + (" at batch entry [1]" if np.ndim(far) else "")
    add = partial(frame.add_many, BAR, [("A", "B")], ["AB"]) if at_once else partial(frame.add, "AB", BAR, "A", "B")
    with pytest.raises(FrameError, match=f"{re.escape(told)}: describe the frame in a unit"):
        add()
