"""Members whose springs and axes a program for batches computes: the bits that they have without a program."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest
from linkframe.elements import Beam, Circle, Joint, Material, Section
from linkframe.framework import Frame
from linkframe.framework.batched import batch_recording, entry_machine, unloaded
from linkframe.framework.batched.batch_numbers import BatchNumbers
from linkframe.framework.batched.entry_program import Way
from linkframe.framework.cache import PROGRAMS
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]
MET = 5


@pytest.fixture(autouse=True)
def _nothing_known() -> Iterator[None]:
    PROGRAMS.clear()
    yield
    PROGRAMS.clear()


@pytest.fixture(params=[Way.STEPS, Way.MACHINE])
def _both_ways(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    if request.param is Way.MACHINE and not entry_machine.available():
        pytest.skip("no LLVM, or no extended precision of 80 bits")
    monkeypatch.setattr(batch_recording, "_OFTEN", 0 if request.param is Way.MACHINE else 10**9)


def steel(rng: np.random.Generator, *shape: int, **more: Any) -> Beam:
    return Beam(Circle(diameter=0.02), Material(E=rng.uniform(1.9e11, 2.1e11, shape), nu=0.3), **more)


def by_sizes(rng: np.random.Generator, *shape: int) -> Beam:
    """A beam whose section varies, and not its material."""
    A, Iy, Iz, J = rng.uniform(1.0, 2.0, (4, *shape)) * np.reshape([1e-4, 1e-8, 2e-8, 3e-8], (4, *(1,) * len(shape)))
    return Beam(Section(A=A, Iy=Iy, Iz=Iz, J=J), Material(E=2e11, nu=0.3))


def by_area(rng: np.random.Generator, *shape: int) -> Beam:
    """A beam only one of whose stiffnesses varies."""
    return Beam(Section(A=rng.uniform(1e-4, 2e-4, shape), Iy=1e-8, Iz=2e-8, J=3e-8), Material(E=2e11, nu=0.3))


def chain(rng: np.random.Generator, places: list[Array], beam: Callable[..., Beam], shape: tuple[int, ...]) -> Frame:
    """Beams from place to place, a joint at each of these in between, clamped at the first and loaded at the last."""
    frame, last = Frame(), len(places) - 1
    for k, place in enumerate(places):
        for end in range(2 if 0 < k < last else 1):
            frame.node(f"{k}{'ab'[end]}", place)
    for k in range(last):
        frame.add(f"m{k}", beam(rng, *shape), f"{k}{'b' if k else 'a'}", f"{k + 1}a")
        if k:
            frame.add(f"j{k}", Joint(stiffness=rng.uniform(1e5, 1e9, (*shape, 6))), f"{k}a", f"{k}b")
    frame.fix("0a")
    frame.load(f"{last}a", **dict(zip(("fx", "fy", "fz", "mx"), rng.normal(size=(4, *shape)), strict=True)))
    return frame


def walk(rng: np.random.Generator, steps: list[tuple[float, float, float]], shape: tuple[int, ...]) -> list[Array]:
    """Places so many steps from one another, each step of another length at each entry."""
    sizes = [np.asarray(step) * rng.uniform(1.0, 1.1, (*shape, 1)) for step in steps]
    return [np.zeros((*shape, 3)), *np.cumsum(sizes, axis=0)]


IN_PLANE = [(0.3, 0.1, 0.0), (0.5, -0.2, 0.0), (-0.2, 0.4, 0.0)]
IN_SPACE = [(0.3, 0.1, 0.2), (0.5, -0.2, 0.1), (-0.2, 0.4, -0.3)]
IN_LINE = [(0.3, 0.0, 0.0), (0.2, 0.0, 0.0)]
BACK = [(0.3, 0.0, 0.0), (-0.2, 0.0, 0.0)]
UPWARDS = [(0.3, 0.1, 0.0), (0.0, 0.0, 0.4)]
ACROSS = [(0.3, 0.0, 0.2), (0.0, 0.4, 0.1)]
SEVEN, TWO_AXES = (7,), (4, 5)
# By name: the steps, the beams, the shape, and whether the program computes the springs.
CASES: dict[str, tuple[Any, Any, tuple[int, ...], bool]] = {
    "in the plane": (IN_PLANE, steel, SEVEN, True),
    "in space": (IN_SPACE, steel, SEVEN, True),
    "in line": (IN_LINE, steel, SEVEN, True),
    "there and back": (BACK, steel, SEVEN, True),
    "without y": (ACROSS, steel, SEVEN, True),
    "over two axes": (IN_SPACE, steel, TWO_AXES, True),
    "by sizes": (IN_SPACE, by_sizes, SEVEN, True),
    "many entries": (IN_SPACE, steel, (1000,), True),
    "by the area alone": (IN_SPACE, by_area, SEVEN, False),
    "upwards": (UPWARDS, steel, SEVEN, False),
    "with shear": (IN_SPACE, lambda rng, *shape: Beam(Circle(diameter=0.02), steel(rng, *shape).material, shear=True),
                   SEVEN, False),
    "a direction": (IN_SPACE, lambda rng, *shape: steel(rng, *shape, up=(0.0, 1.0, 1.0)), SEVEN, False),
}  # fmt: skip


@pytest.mark.usefixtures("_both_ways")
@pytest.mark.parametrize("case", CASES)
def test_bits_of_a_chain(case: str) -> None:
    steps, beam, shape, computed = CASES[case]
    check(lambda rng: chain(rng, walk(rng, steps, shape), beam, shape), f"{len(steps)}a", computed=computed)


@pytest.mark.usefixtures("_both_ways")
def test_places_and_moduli_that_vary_over_different_axes() -> None:
    check(lambda rng: chain(rng, walk(rng, IN_SPACE, (4, 1)), steel, (5,)), "3a", computed=True)


@pytest.mark.usefixtures("_both_ways")
def test_places_that_do_not_vary() -> None:
    check(lambda rng: chain(rng, walk(rng, IN_SPACE, ()), steel, SEVEN), "3a", computed=True)


@pytest.mark.usefixtures("_both_ways")
@pytest.mark.parametrize("shape", [SEVEN, TWO_AXES])
def test_bits_of_links_on_bodies(shape: tuple[int, ...]) -> None:
    def arm(rng: np.random.Generator) -> Frame:
        frame, lengths, count = Frame(), rng.uniform(0.2, 0.3, (2, *shape)), int(np.prod(shape))
        first, second = Rotation.random(2 * count, rng=rng).as_matrix().reshape(2, *shape, 3, 3)
        ends = np.stack([lengths, 0.0 * lengths, 0.0 * lengths], axis=-1)
        frame.body("upper", axes=first)
        frame.body("lower", origin=np.einsum("...ij,...j->...i", first, ends[0]), axes=second)
        for name, end in zip(("upper", "lower"), ends, strict=True):
            frame.node(f"{name} start", (0.0, 0.0, 0.0), body=name)
            frame.node(f"{name} end", end, body=name)
            frame.add(name, steel(rng, *shape), f"{name} start", f"{name} end")
        frame.add("elbow", Joint(stiffness=rng.uniform(1e5, 1e9, (*shape, 6))), "upper end", "lower start")
        frame.fix("upper start")
        frame.load("lower end", fx=rng.normal(size=shape), fz=rng.normal(size=shape))
        return frame

    check(arm, "lower end", computed=True)


@pytest.mark.usefixtures("_both_ways")
def test_members_between_bodies_are_given_to_the_program() -> None:
    def link(rng: np.random.Generator) -> Frame:
        frame = Frame()
        frame.body("arm", axes=Rotation.random(7, rng=rng).as_matrix())
        frame.node("A", (0.0, 0.0, 0.0))
        frame.node("B", rng.normal(size=(7, 3)), body="arm")
        frame.add("AB", steel(rng, 7), "A", "B")
        frame.fix("A")
        frame.load("B", fy=rng.normal(size=7))
        return frame

    check(link, "B", computed=False)


def check(described: Callable[[np.random.Generator], Frame], node: str, *, computed: bool) -> None:
    """Frames of a program that others have had recorded, against the same without a program."""
    for seed in range(MET):
        described(np.random.default_rng(seed)).solve("broadcast").displacement(node)
    solution = described(np.random.default_rng(MET)).solve("broadcast")
    found = solution.displacement(node)
    numbers = solution.plan.unloaded.numbers
    assert isinstance(numbers, BatchNumbers)
    assert solution.plan.entry is not None
    assert bool(numbers.formulas) is computed
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(unloaded, "FEW", 10**9)
        wanted = described(np.random.default_rng(MET)).solve("broadcast").displacement(node)
    np.testing.assert_array_equal(found, wanted)
