"""Members of a batch whose sizes lie far apart: each is what it is alone, as none counts lengths in another's unit."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from linkframe.models import Linkage, Motion
from numpy.testing import assert_allclose, assert_array_equal
from numpy.typing import NDArray

from ..reference.any_linkage import KINDS, Recipe

Array = NDArray[np.float64]
SCALES = np.array([1.0, 43.0, 0.0031, 5.7e3])
LOAD = {"fx": 1e3, "fy": 2e3, "fz": 500.0}
ANGLES = np.radians(np.linspace(-80.0, 200.0, 15))


def scaled(kind: str, scales: Array) -> Motion:
    """A random linkage of a kind at two poses, enlarged by some factors: its motion with rates and accelerations."""
    recipe: Recipe = KINDS[kind](np.random.default_rng(5))
    recipe.points = {name: place * scales[..., None] for name, place in recipe.points.items()}
    linkage = recipe.made()
    linkage.load("P", **LOAD)
    values, rates, more = {}, {}, {}
    for turn, (name, reach) in enumerate(recipe.reach.items(), 1):
        pair = linkage.joint(name)
        length = scales if linkage.drives[name][0][0] == "u" else np.ones_like(scales)
        begin = pair.reference[..., pair.kind.places_of(linkage.drives[name])][..., 0]
        share = np.array([0.1, 0.25]).reshape(2, *(1,) * scales.ndim)
        values[name] = begin + share * reach * length
        rates[name], more[name] = 0.7 * turn * length, 0.3 / turn * length
    return linkage.move(values, rates=rates, accelerations=more)


def results(motion: Motion, entry: tuple[int, ...], scale: float) -> Iterator[tuple[str, Array]]:
    """Results of the second pose of a member, or of the only one, with lengths in units of its scale."""
    at, units = (1, *entry), np.array([scale] * 3 + [1.0] * 3)
    for what in ("position", "velocity", "acceleration"):
        yield what, getattr(motion, what)("P")[at] / scale
    for joint, pair in motion.linkage.joints.items():
        own = np.array([scale if name[0] == "u" else 1.0 for name in pair.kind.coordinates])
        yield f"coordinate of {joint}", motion.coordinate(joint)[at] / own
        yield f"rate of {joint}", motion.coordinate_rate(joint)[at] / own
        yield f"acceleration of {joint}", motion.coordinate_acceleration(joint)[at] / own
    yield "conditioning", motion.conditioning[at]
    for joint, derivatives in motion.sensitivity("P").joints.items():
        yield f"sensitivity to {joint}", derivatives[at] / units[:, None] * units
    moved = motion.accuracy("P").compliance[at]
    yield "displacement", moved[:3]
    yield "rotation", moved[3:]
    found = motion.reactions()
    if found.method[at] == "determinate":
        for joint, wrench in found.wrenches.items():
            yield f"force in {joint}", wrench[at][:3]
            yield f"moment in {joint}", wrench[at][3:] / scale
        for joint, drive in found.drives.items():
            yield f"force of the drive {joint}", drive[at]


@pytest.mark.parametrize("kind", KINDS)
def test_results_are_those_of_each_member_alone(kind: str) -> None:
    """Kinematics, derivatives, forces and displacements of four members, 0.003 to 5700 times as large as drawn."""
    whole = scaled(kind, SCALES)
    assert len({float(size) for size in np.ravel(whole.mechanism.size)}) == len(SCALES)
    for k, scale in enumerate(SCALES.tolist()):
        alone = scaled(kind, np.asarray(scale))
        assert_array_equal(whole.status[:, k], alone.status)
        for (what, mine), (_, theirs) in zip(results(whole, (k,), scale), results(alone, (), scale), strict=True):
            size = float(np.nanmax(np.abs(theirs), initial=0.0))
            # displacements have the rounding of stiffness, of which those of hinges in a point share little
            allowed = 1e-8 * size if what in ("displacement", "rotation") else 1e-11 * max(1.0, size)
            assert_allclose(mine, theirs, atol=allowed, err_msg=f"{what}, {scale} times as large")


def parallelogram(scales: Array, longer: float) -> Linkage:
    """One whose coupler is longer than the ground by a share, enlarged by some factors."""
    crank, ground, turn = 0.1, 0.25, np.radians(60.0)
    pin, pivot, coupler = crank * np.exp(1j * turn), complex(ground), ground * (1.0 + longer)
    chord = pivot - pin
    along = (abs(chord) ** 2 + coupler**2 - crank**2) / (2.0 * abs(chord))
    other = pin + chord / abs(chord) * (along + 1j * np.sqrt(coupler**2 - along**2))
    places = {"A": 0j, "B": pin, "D": other, "E": pivot}
    linkage = Linkage({n: np.stack([at.real * scales, at.imag * scales], axis=-1) for n, at in places.items()})
    for link, ends in {"crank": "AB", "coupler": "BD", "rocker": "DE"}.items():
        linkage.link(link, *ends)
    for joint, (first, second) in {"B": ("crank", "coupler"), "D": ("coupler", "rocker")}.items():
        linkage.revolute(joint, first, second)
    linkage.revolute("A", "ground", "crank", drive=True, reference=turn)
    linkage.revolute("E", "rocker", "ground")
    return linkage


@pytest.mark.parametrize("longer", [0.0, 1e-16, 1e-14, 1e-12, 1e-10, 1e-9])
def test_parallelograms_stay_parallelograms(longer: float) -> None:
    """A hundred of log-normal sizes, beyond both change points: the coupler does not turn."""
    sizes = np.exp(np.random.default_rng(0).normal(size=120))[20:]
    motion = parallelogram(sizes, longer).move(A=ANGLES[:, None])
    turned = motion.coordinate("A") + motion.coordinate("B")
    assert_allclose(turned, np.broadcast_to(turned[:1], turned.shape), atol=10.0 * np.sqrt(longer) + 1e-7)


@pytest.mark.parametrize("longer", [-1e-7, -1e-8, 1e-11, 5e-9, 1e-8, 2e-8, 3e-8, 1e-7, 1e-6, 1e-5])
def test_almost_parallelograms_do_as_they_do_alone(longer: float) -> None:
    """Beside members of any size, in any order: statuses, and positions."""
    rng = np.random.default_rng(1)
    alone = parallelogram(np.asarray(1.0), longer).move(A=ANGLES)
    for sizes in (*np.exp(1.5 * rng.normal(size=(2, 1))), np.exp(1.5 * rng.normal(size=3))):
        for place in (0, len(sizes)):
            motion = parallelogram(np.insert(sizes, place, 1.0), longer).move(A=ANGLES[:, None])
            assert_array_equal(motion.status[:, place], alone.status)
            assert_allclose(motion.position("D")[:, place], alone.position("D"), atol=1e-6)


def test_a_gap_that_is_accepted_is_the_same_length_for_all() -> None:
    """A tolerance is a length: what closes by less than that counts as assembled, whatever the size of the others."""
    linkage = parallelogram(np.array([1.0, 100.0]), 1e-5)
    strict, loose = linkage.move(A=[[0.0]]), linkage.move(A=[[0.0]], tolerance=1e-5)
    assert strict.is_assembled.tolist() == [[False, False]]
    assert_allclose(strict.gap[0], [2.5e-6, 2.5e-4], rtol=1e-3)
    assert loose.is_assembled.tolist() == [[True, False]]
    assert loose.tolerance == pytest.approx(1e-5)


@pytest.mark.parametrize("scales", [SCALES, SCALES[:2]], ids=len)
def test_accelerations_of_a_slide(scales: Array) -> None:
    """A mass that falls along a slide, and a bar that swings from it: as each alone, lengths and angles."""

    def falling(size: Array) -> dict[str, Array]:
        places = {"S": (0.0, 0.0), "T": (0.6, 0.3)}
        linkage = Linkage({name: np.multiply.outer(size, place) for name, place in places.items()})
        linkage.link("block", "S", mass=2.0, centre=(0.0, 0.0), inertia=0.0)
        centre = np.stack([0.3 * size * np.sqrt(5.0), 0.0 * size], axis=-1)
        linkage.link("bar", "S", "T", mass=1.0, centre=centre, inertia=0.01 * size**2)
        linkage.prismatic("S", "ground", "block", axis=(1.0, 0.2, 0.0), name="slide", drive=True)
        linkage.revolute("S", "block", "bar", name="pin", drive=True)
        linkage.gravity((0.0, -10.0))
        return linkage.move(slide=0.4 * size, pin=0.3, rates={"pin": 2.0}).free_accelerations({"slide": 3.0})

    whole = falling(scales)
    for k, size in enumerate(scales):
        for joint, mine in falling(np.asarray(size)).items():
            assert_allclose(whole[joint][k], mine, rtol=1e-12)


@pytest.mark.parametrize("sizes", [(1.0, 1e3), (1e-6, 1e7)], ids=str)
def test_small_dimensions_stay(sizes: tuple[float, float]) -> None:
    """Pins a little off the plane, beside a linkage many times as large: no dimension is taken for rounding."""

    def oblique(size: Array, off: float) -> Linkage:
        places = {"A": (0.0, 0.0, 0.0), "B": (0.0, 1.0, off), "D": (2.5, 2.0, -off), "E": (3.0, 0.0, 0.0)}
        linkage = Linkage({name: np.multiply.outer(size, place) for name, place in places.items()})
        for link, ends in {"crank": "AB", "coupler": "BD", "rocker": "DE"}.items():
            linkage.link(link, *ends)
        for joint, (first, second) in {"A": ("ground", "crank"), "B": ("crank", "coupler")}.items():
            linkage.revolute(joint, first, second, drive=joint == "A")
        linkage.revolute("D", "coupler", "rocker")
        linkage.revolute("E", "rocker", "ground")
        return linkage

    for off in (2.4e-12, 1e-3):
        whole = oblique(np.array(sizes), off).move(A=[[0.1], [0.5]])
        for k, size in enumerate(sizes):
            alone = oblique(np.asarray(size), off).move(A=[0.1, 0.5])
            assert_array_equal(whole.status[:, k], alone.status)
            assert_allclose(whole.position("D")[:, k], alone.position("D"), rtol=0.0, atol=1e-14 * size)


def test_what_is_said_of_a_gap_is_no_matter_of_the_others() -> None:
    """Of a parallelogram with three cranks, one of them too far out: by much or by little for its own size."""

    def three(size: Array, off: Array) -> Linkage:
        at = {"A": (0.0, 0.0), "B": (0.5, 1.0), "C": (2.0, 0.0), "D": (2.5, 1.0), "E": (4.0, 0.0), "G": (4.5, 1.0)}
        places = {name: np.multiply.outer(size, place) for name, place in at.items()}
        places["G"] = places["G"] + np.multiply.outer(size * off, (1.0, 0.0))
        linkage = Linkage(places)
        for link, ends in {"one": "AB", "two": "CD", "three": "EG", "bar": "BDG"}.items():
            linkage.link(link, *ends)
        for crank, (foot, pin) in {"one": "AB", "two": "CD", "three": "EG"}.items():
            linkage.revolute(foot, "ground", crank, drive=foot == "A")
            linkage.revolute(pin, crank, "bar")
        return linkage

    off = np.array([0.03, 0.0])
    alone = three(np.asarray(1.0), off[0]).move(A=[1.0])
    for other in (1.0, 100.0):
        assert three(np.array([1.0, other]), off).move(A=[[1.0]]).status[0, 0] == alone.status[0]
