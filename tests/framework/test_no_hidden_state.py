"""Solving and reading leave descriptions as they were, for any number of threads; what is kept is kept elsewhere."""

from __future__ import annotations

import gc
import inspect
import pickle
import re
import weakref
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from linkframe.elements import Beam, Joint, Material, Rectangle
from linkframe.framework import Frame, FrameError
from linkframe.framework.batched import order as ordering
from linkframe.framework.cache import COMPILED, ORDERS, PROGRAMS, SOLVED, Bounded, LimitedCache, alike
from linkframe.framework.renamed import RenamedAttribute
from linkframe.models import Linkage

TOP = Path(__file__).parents[2]
STEEL = Material(E=200e9, nu=0.3, density=7850.0)
BAR = Beam(Rectangle(y=0.03, z=0.02), STEEL)
PIN = (2e8, 2e8, 2e8, 2e5, 2e5, 10.0)


def bent(length: float = 1.0, k: object = 2e8, bar: Beam = BAR) -> Frame:
    frame = Frame()
    for name, place in {"A": (0, 0, 0), "B": (length, 0, 0), "C": (length, 0, 0), "D": (length, 1, 0)}.items():
        frame.node(name, place)
    frame.add("AB", bar, "A", "B")
    frame.add("pin", Joint(stiffness=np.asarray(k)[..., None] * np.array(PIN)), "B", "C")
    frame.add("CD", bar, "C", "D")
    frame.fix("A")
    frame.load("D", fx=100.0)
    return frame


def ladder(steps: int) -> Frame:
    frame = Frame()
    for k in range(steps):
        for side in "lr":
            frame.node(f"{side}{k}", (float(side == "r"), 0.1 * k * k, float(k)))
        frame.add(f"s{k}", BAR, f"l{k}", f"r{k}")
        for side in "lr" if k else "":
            frame.add(f"{side}{k}", BAR, f"{side}{k - 1}", f"{side}{k}")
    frame.fix("l0")
    frame.fix("r0")
    frame.load(f"l{steps - 1}", fx=1.0)
    return frame


def four_bar() -> Linkage:
    linkage = Linkage(A=(0, 0), B=(0, 0.1), P=(0.12, 0.19), D=(0.24, 0.16), E=(0.22, 0))
    for name, on in {"crank": "AB", "coupler": "BPD", "rocker": "DE"}.items():
        linkage.link(name, *on, beam=BAR)
    linkage.revolute("A", "ground", "crank", drive=True)
    linkage.revolute("B", "crank", "coupler", stiffness=PIN)
    linkage.revolute("D", "coupler", "rocker", stiffness=PIN, clearance=1e-4)
    linkage.revolute("E", "rocker", "ground", stiffness=PIN)
    linkage.load("P", fy=100.0)
    return linkage


def held(value: object) -> object:
    """All that an object holds, whatever it is made of, as what can be compared."""
    if isinstance(value, np.ndarray):
        return value.shape, value.dtype, value.tobytes()
    if isinstance(value, dict):
        return [(key, held(part)) for key, part in value.items()]
    if isinstance(value, (list, tuple)):
        return [held(part) for part in value]
    if is_dataclass(value):
        return (
            type(value),
            [held(getattr(value, each.name)) for each in fields(value)],
            type(value) is Frame and sorted(vars(value)),
        )
    return (type(value), held(vars(value))) if isinstance(value, Linkage) else value


READ: dict[str, Callable[[Frame], object]] = {
    "batch": lambda f: f.solve().displacement("D"),
    "sparse": lambda f: f.solve("sparse").displacement("D"),
    "forces": lambda f: (f.solve().reaction("A"), f.solve().joint_force("pin"), f.solve().stress("AB", 0.5)),
    "bound": lambda f: f.solve().error_bound("D"),
    "sensitivity": lambda f: f.solve().sensitivity("D", "ux"),
    "large": lambda f: f.solve(large=True).displacement("D"),
    "modes": lambda f: f.modes(2).frequencies,
    "buckling": lambda f: f.buckling(1).factors,
    "explain": lambda f: f.explain(),
    "matrices": lambda f: f.matrices(),
    "words": lambda f: (f.solve().status, f.solve().linear, f.solve().condition_number()),
}


@pytest.mark.parametrize("read", READ)
def test_a_frame_holds_what_it_held_before(read: str) -> None:
    frame = bent()
    before, keys, sent = held(frame), list(vars(frame)), pickle.dumps(frame)
    READ[read](frame)
    READ[read](frame)
    assert held(frame) == before
    assert list(vars(frame)) == keys
    assert pickle.dumps(frame) == sent


# What draws or writes is tried elsewhere; all else is asked for, with the first of these that it takes.
ELSEWHERE = {"animate", "movie", "page", "picture", "plot", "save", "show", "widget"}
ASKED: list[tuple[Any, ...]] = [(), ("D",), ("AB",), ("pin",), ("P",), ("D", "ux"), ("AB", [0.5]), ([0.5],), (0,)]
RESULTS: dict[str, tuple[Callable[[], Any], Callable[[Any], Any], int]] = {
    "solution": (lambda: bent().solve(), lambda result: result.frame, 40),
    "batch": (lambda: bent(k=[1e8, 2e8]).solve(), lambda result: result.frame, 40),
    "large": (lambda: bent().solve(large=True), lambda result: result.frame, 30),
    "motion": (lambda: four_bar().move(A=[0.0, 0.5]), lambda result: result.linkage, 35),
}


@pytest.mark.parametrize("kind", RESULTS)
def test_every_reader_leaves_its_description_as_it_was(kind: str) -> None:
    """Whatever a result is asked for, by all its public names; and it can be sent on afterwards, to say the same."""
    make, described, least = RESULTS[kind]
    result, read = make(), []
    description = described(result)
    before, sent = held(description), pickle.dumps(description)
    renamed = {name for name, each in inspect.getmembers_static(type(result)) if isinstance(each, RenamedAttribute)}
    for name in sorted(set(dir(type(result))) - ELSEWHERE - renamed):
        for given in [] if name.startswith("_") else ASKED:
            with suppress(TypeError, ValueError, AttributeError, KeyError, FrameError):
                found = getattr(result, name)
                read.append((name, found(*given) if callable(found) else found))
                break
        assert held(description) == before, name
    assert pickle.dumps(description) == sent
    assert len(read) >= least
    again = pickle.loads(pickle.dumps(result))
    for name, found in read:
        if isinstance(found, np.ndarray) and not callable(getattr(type(result), name)):
            np.testing.assert_array_equal(getattr(again, name), found)


def test_a_solution_holds_the_description_that_it_was_given() -> None:
    frame = bent()
    solution = frame.solve()
    before = held(solution.frame)
    assert before == held(frame)
    for name in ("A", "D"):
        solution.displacement(name)
    solution.error_bound("D")
    solution.forces("AB", [0.2, 0.4])
    solution.explain()
    assert held(solution.frame) == before


def test_a_linkage_holds_what_it_held_before() -> None:
    linkage = four_bar()
    before, sent = held(linkage), pickle.dumps(linkage)
    motion = linkage.move(A=np.linspace(0.0, 1.0, 4))
    motion.frame().solve().displacement("P")
    motion.reactions()
    linkage.mobility()
    linkage.drive_range("A")
    assert held(linkage) == before
    assert pickle.dumps(linkage) == sent


@pytest.mark.parametrize("kind", ["batch", "large"])
def test_threads_find_what_one_alone_finds(kind: str) -> None:
    """Many solutions of one frame at a time, some under loads of their own, and reads of one solution by all."""
    frame = ladder(30) if kind == "large" else bent(k=2e8 + np.linspace(0.0, 1e7, 3000))
    tip = "l29" if kind == "large" else "D"
    shared = frame.solve()

    def work(number: int) -> list[bytes]:
        twin = frame.copy()
        twin.load(tip, fy=float(number))
        out = [shared.displacement(tip), frame.solve().displacement(tip), twin.solve().displacement(tip)]
        out += [shared.error_bound(tip), twin.solve().end_forces(next(iter(frame.members)))]
        return [array.tobytes() for array in out]

    with ThreadPoolExecutor(4) as pool:
        found = list(pool.map(work, range(8)))
    assert found == [work(number) for number in range(8)]


def test_another_frame_of_the_topology_orders_nothing_anew(monkeypatch: pytest.MonkeyPatch) -> None:
    """Other lengths, other stiffness, other sections, another load: the orders are those of the first."""
    made: list[object] = []
    ordered = ordering.order

    def counting(*given: object) -> object:
        made.append(given)
        return ordered(*given)  # type: ignore[arg-type]

    monkeypatch.setattr(ordering, "order", counting)
    ORDERS.clear()
    PROGRAMS.clear()
    first = bent().solve().displacement("D")
    count = len(made)
    assert count
    other = Beam(Rectangle(y=0.05, z=0.02), STEEL)
    for frame in (bent(1.5), bent(k=3e8), bent(bar=other)):
        frame.load("D", fx=7.0)
        assert np.abs(frame.solve().displacement("D") - first).max() > 0.0
        assert len(made) == count
    bent(k=[2e8, 3e8]).solve().displacement("D")
    assert len(made) > count


def test_results_do_not_depend_on_what_was_solved_before() -> None:
    wanted = bent(1.5).solve()
    read = wanted.displacement("D").tobytes(), wanted.reaction("A").tobytes()
    for length in (1.0, 1.25, 2.0):
        bent(length).solve().displacement("D")
    ORDERS.clear()
    for _ in range(2):
        again = bent(1.5).solve()
        assert (again.displacement("D").tobytes(), again.reaction("A").tobytes()) == read


def test_nothing_keeps_a_frame_or_a_linkage_alive() -> None:
    linkage = four_bar()
    motion = linkage.move(A=0.3)
    frame = motion.frame()
    frame.solve().displacement("P")
    motion.accuracy("P", fx=1.0)
    gone = [weakref.ref(each) for each in (linkage, motion, frame, motion.bare.frame, COMPILED.get(linkage)[1])]
    del linkage, motion, frame
    for _ in range(2):  # what is kept goes after what it was kept for
        gc.collect()
    assert [each() for each in gone] == [None] * 5


def test_what_is_kept_is_bounded() -> None:
    few: Bounded[int, str] = Bounded(3)
    assert [few.found(k, lambda k=k: str(k)) for k in range(5)] == list("01234")  # type: ignore[misc]
    assert len(few) == 3
    assert few.found(2, lambda: "kept") == "2"
    few.found(9, lambda: "new")
    assert few.found(2, lambda: "kept") == "2"
    assert few.found(3, lambda: "made anew") == "made anew"
    few.found(10, lambda: "heavy", 4)
    assert len(few) == 0
    leases: LimitedCache[int] = LimitedCache()
    frames = [Frame() for _ in range(300)]
    for number, frame in enumerate(frames):
        leases.put(frame, number)
    assert len(leases) == 256
    assert leases.get(frames[0]) is None
    assert leases.get(frames[-1]) == 299
    assert len(pickle.loads(pickle.dumps(leases))) == len(pickle.loads(pickle.dumps(few))) == 0


def test_a_plan_is_taken_up_by_content() -> None:
    """The same numbers given once more are the same; what differs in one bit is not."""
    frame = bent()
    frame.solve().displacement("D")
    tree = SOLVED.get(frame)[0].tree
    frame.members["AB"] = bent().members["AB"]
    frame.joints["pin"] = bent().joints["pin"]
    frame.solve()
    assert SOLVED.get(frame)[0].tree is tree
    frame.joints["pin"] = bent(k=np.nextafter(2e8, 3e8)).joints["pin"]
    frame.solve()
    assert SOLVED.get(frame)[0].tree is not tree


def test_alike_tells_content_apart() -> None:
    assert alike(BAR, Beam(Rectangle(y=0.03, z=0.02), Material(E=200e9, nu=0.3, density=7850.0)))
    assert not alike(BAR, Beam(Rectangle(y=0.03, z=0.02), STEEL, shear=True))
    assert not alike(BAR, Beam(Rectangle(y=0.03, z=np.array([0.02, 0.02])), STEEL))
    assert not alike({"a": 1, "b": 2}, {"b": 2, "a": 1})
    assert not alike(object(), object())


@pytest.mark.parametrize(
    "pattern",
    [r"(vars\([^)]*\)|__dict__)\.pop", r"(vars\([^)]*\)|__dict__)\[[^\]]*\] = ", r"weakref\.proxy", r"[\[{(, ]id\("],
)
def test_no_such_tricks(pattern: str) -> None:
    for folder in ("framework", "elements", "models"):
        for path in (TOP / folder).rglob("*.py"):
            assert not re.search(pattern, path.read_text(encoding="utf-8")), path
