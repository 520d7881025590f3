"""Members of long batches whose springs follow from moduli, sizes and chords: the bits of springs that are given."""

from __future__ import annotations

from collections.abc import Callable
from unittest.mock import patch

import numpy as np
import pytest
from linkframe.elements import Beam, Joint, Material, Rectangle, Section
from linkframe.framework import Frame
from linkframe.framework.batched.broadcast import BroadcastSolver
from linkframe.framework.batched.plan import Plan
from linkframe.framework.structure import varying
from linkframe.framework.structure.member_numbers import FormulaNumbers, SpringNumbers
from numpy.testing import assert_allclose, assert_array_equal
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]
COUNT = 70_000
SPREAD = 1.0 + 0.05 * np.random.default_rng(3).normal(size=(8, COUNT)).clip(-4.0, 4.0)
LEVEL = np.array([[0.0, 0.0, 0.0], [1.0, 0.3, 0.0], [0.0, 0.9, 0.0], [-0.8, 1.1, 0.0]])
ASLANT = LEVEL + np.array([0.0, 0.4, 0.4, -0.2])[:, None] * [0.0, 0.0, 1.0]


def chain(places: Array, bar: Callable[[int], Beam], turn: Array | None = None) -> Frame:
    """Three members one after the other, clamped, the last behind a spring; on a turned body if `turn` is given."""
    frame = Frame()
    body = None
    if turn is not None:
        frame.body("arm", (0.1, 0.2, 0.3), turn)
        body = "arm"
    for k in range(4):
        frame.node(f"n{k}", places[..., k, :], body)
    frame.node("n2'", places[..., 2, :], body)
    for k, (start, end) in enumerate((("n0", "n1"), ("n1", "n2"), ("n2'", "n3"))):
        frame.add(f"m{k}", bar(k), start, end)
    frame.add("j", Joint((1e6, 1e6, 1e6, 1e4, 1e4, 1e3)), "n2", "n2'")
    frame.fix("n0")
    frame.load("n3", fx=3.0, fy=1.0, fz=2.0, my=0.5)
    return frame


def varied(places: Array, *, moved: bool) -> Array:
    """The places, those of the nodes but the first moved in each direction in which they are not zero."""
    out = np.broadcast_to(places, (COUNT, 4, 3)).copy()
    for k in range(1, 4 if moved else 1):
        out[:, k] *= np.stack([SPREAD[k], SPREAD[k + 3], SPREAD[k + 4]], axis=-1)
    return out if moved else places


def prismatic(k: int, *, modulus: bool = True, sizes: bool = False) -> Beam:
    """A beam whose modulus varies, and whose section does."""
    factor = SPREAD[k] if sizes else 1.0
    section = Section(A=1e-4 * factor, Iy=1e-9 * factor**2, Iz=2e-9 * factor**2, J=1e-9 * factor**2)
    return Beam(section, Material(E=2e11 * SPREAD[k + 1] if modulus else 2e11, nu=0.3))


TURN = Rotation.from_rotvec([0.3, 0.4, 0.5]).as_matrix()
ALONG = np.array([[0.0, 0.0, 0.0], [0.5, 0.0, 0.0], [1.2, 0.0, 0.0], [1.5, 0.0, 0.0]])
CASES: dict[str, Callable[[], Frame]] = {
    "moduli": lambda: chain(ASLANT, prismatic),
    "moduli, level": lambda: chain(LEVEL, prismatic),
    "moduli, along x": lambda: chain(ALONG, prismatic),
    "one modulus": lambda: chain(ASLANT, lambda _: prismatic(0)),
    "sections": lambda: chain(ASLANT, lambda k: prismatic(k, modulus=False, sizes=True)),
    "places": lambda: chain(varied(ASLANT, moved=True), lambda _: prismatic(0, modulus=False)),
    "places, level": lambda: chain(varied(LEVEL, moved=True), lambda _: prismatic(0, modulus=False)),
    "places, along x": lambda: chain(varied(ALONG, moved=True), lambda k: prismatic(k, modulus=False)),
    "all on a body": lambda: chain(varied(ASLANT, moved=True), prismatic, TURN),
    "all on a body that turns": lambda: chain(
        ASLANT, prismatic, Rotation.from_rotvec(np.multiply.outer(SPREAD[7], [0.3, 0.4, 0.5])).as_matrix()
    ),
}


def kinds(frame: Frame) -> set[type]:
    """How the numbers of the members that vary lead to their springs."""
    return {type(numbers) for numbers, _ in frame.solve().plan.varying.groups}


@pytest.mark.parametrize("case", CASES)
def test_same_bits_as_given_springs(case: str) -> None:
    """Displacements, end forces and pivots, whatever computes springs and axes."""
    frame = CASES[case]()
    assert kinds(frame) == {FormulaNumbers}
    found = results(frame)
    with patch.object(varying, "numbers_of", SpringNumbers):
        other = frame.copy()
        other.load("n0", fx=1.0)  # of which nothing is known from the last solution
        assert kinds(other) == {SpringNumbers}
        expected = results(other)
    for mine, theirs in zip(found, expected, strict=True):
        assert_array_equal(mine, theirs)


def results(frame: Frame) -> list[Array]:
    """Some results of a frame, solved as if for the first time."""
    solution = frame.copy().solve()
    solver = solution.primary.solver
    assert isinstance(solver, BroadcastSolver)
    pivots = [solver.factor(name).least() for name in sorted(solution.plan.excited)]
    return [solution.displacement("n3"), solution.end_forces("m1"), *pivots]


@pytest.mark.parametrize("case", CASES)
def test_as_a_single_entry(case: str) -> None:
    """Displacements are those of frames of a few entries, whose stiffness is summed in extended precision.

    The scaled condition number is some 1e6, and rounding of that 1e-10.
    """
    whole = CASES[case]().solve().displacement("n3")
    some = slice(COUNT // 2, COUNT // 2 + 3)
    with patch.dict(globals(), SPREAD=SPREAD[:, some], COUNT=3):
        few = CASES[case]().solve().displacement("n3")
    assert_allclose(whole[some], few, rtol=0.0, atol=1e-10 * np.abs(few).max())


@pytest.mark.parametrize("what", ["moduli", "places", "both"])
def test_changed_in_place(what: str) -> None:
    """Nothing of the members before stays, where they are replaced or moved."""
    places = varied(ASLANT, moved=True)
    frame = chain(places, prismatic)
    frame.solve().displacement("n3")
    bar = (lambda k: prismatic(k + 1)) if what != "places" else prismatic
    other = places[::-1] if what != "moduli" else places
    if what != "places":
        frame.change(["m0", "m1", "m2"], [bar(k) for k in range(3)])
    if what != "moduli":
        frame.change(["n0", "n1", "n2", "n3", "n2'"], other[:, [0, 1, 2, 3, 2]])
    assert_array_equal(frame.solve().displacement("n3"), chain(other, bar).solve().displacement("n3"))


def test_divided_members_give_their_springs() -> None:
    """Of a part of a member the chord is that of the whole."""
    frame = chain(ASLANT, lambda k: Beam(Rectangle(y=0.02, z=0.03), Material(E=2e11 * SPREAD[k], nu=0.3), segments=2))
    assert {type(numbers) for numbers, _ in Plan(frame, cut=True).varying.groups} == {SpringNumbers}
    assert kinds(frame) == {FormulaNumbers}


def upright(count: int) -> Array:
    places = np.broadcast_to(ASLANT, (COUNT, 4, 3)) * SPREAD[:3].T[:, None]
    places[:count, 1, :2] = 0.0
    return places


@pytest.mark.parametrize(
    ("why", "made"),
    {
        "a member along z at one entry": lambda: chain(upright(1), lambda _: prismatic(0, modulus=False)),
        "shear deformation": lambda: chain(
            ASLANT, lambda k: Beam(Rectangle(y=0.02, z=0.03), Material(E=2e11 * SPREAD[k], nu=0.3), shear=True)
        ),
        "axes of one's own": lambda: chain(
            ASLANT, lambda k: Beam(Rectangle(y=0.02, z=0.03), Material(E=2e11 * SPREAD[k], nu=0.3), up=(0.1, 0.2, 1.0))
        ),
    }.items(),
)
def test_springs_that_are_given(why: str, made: Callable[[], Frame]) -> None:
    """Where axes or springs do not follow from these numbers, they are given; results are those of single entries."""
    frame = made()
    assert kinds(frame) == {SpringNumbers}, why
    whole = frame.solve().displacement("n3")
    for k in (0, 1):
        with patch.dict(globals(), SPREAD=SPREAD[:, k : k + 1], COUNT=1):
            alone = chain(upright(1 - k), lambda _: prismatic(0, modulus=False)) if "along z" in why else made()
            found = alone.solve().displacement("n3")[0]
        assert_allclose(whole[k], found, rtol=0.0, atol=1e-10 * np.abs(whole[k]).max())


@pytest.mark.parametrize("clearance", [0.0, 1e-4], ids=["without", "with clearance"])
@pytest.mark.parametrize("rise", [(0.5, 0.2), (0.5, 0.0), (0.0, 0.2), (0.0, 0.0)], ids=str)
def test_parts_whose_members_lie_otherwise(rise: tuple[float, float], clearance: float) -> None:
    """Two cantilevers with a joint, apart from each other: one aslant, the other along x, level or aslant."""

    def parts(modulus: Array) -> Frame:
        frame = Frame()
        for k, height in enumerate(((0.3, 0.4), rise)):
            for name, place in {"a": (0, 0, 0), "b": (1, *height), "b'": (1, *height), "c": (2, *height)}.items():
                frame.node(f"{name}{k}", np.add(place, (0.0, 3.0 * k, 0.0)))
            for name, ends, own in zip(("ab", "bc"), (("a", "b"), ("b'", "c")), modulus[2 * k :], strict=False):
                beam = Beam(Rectangle(y=0.02, z=0.01), Material(E=own, nu=0.3))
                frame.add(f"{name}{k}", beam, *(f"{end}{k}" for end in ends))
            joint = Joint((2e8, 2e8, 2e8, 2e5, 2e5, 1e5), clearance=clearance, clearance_directions=("ux", "uy"))
            frame.add(f"j{k}", joint, f"b{k}", f"b'{k}")
            frame.fix(f"a{k}")
            frame.load(f"c{k}", fx=1.0, fy=2.0, fz=0.5)
        return frame

    whole = parts(2e11 * SPREAD[:4]).solve()
    assert whole.explain()
    for k in (0, COUNT - 1):
        alone = parts(2e11 * SPREAD[:4, k]).solve()
        for node in ("c0", "c1"):
            mine, theirs = whole.displacement(node)[k], alone.displacement(node)
            assert_allclose(mine, theirs, rtol=0.0, atol=1e-10 * np.abs(theirs).max())
    solver = whole.primary.solver
    assert isinstance(solver, BroadcastSolver)
    assert all(np.all(solver.factor(name).least() > 0.0) for name in whole.plan.excited)
