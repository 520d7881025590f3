"""The elements that examples write, each through all that a frame does, and as a link of a linkage."""

from __future__ import annotations

import importlib.util
import sys
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import meshio
import numpy as np
import pytest
import scipy
from linkframe.elements import Beam, Circle, Material, Rectangle, Spring
from linkframe.framework import Frame, FrameError, LineElement
from linkframe.models import Linkage, write_linkage
from numpy.testing import assert_allclose
from numpy.typing import NDArray
from reference.textbook_members import TextbookMember, bar, in_global_axes, level_axes
from reference.textbook_members import footing as footing_by_hand

Array = NDArray[np.float64]
EXAMPLES = Path(__file__).parents[2] / "examples"
STEEL, BAR = Material(E=210e9, nu=0.3, density=7850.0), Rectangle(y=0.03, z=0.02)
AREA = 0.03 * 0.02


def example(name: str) -> ModuleType:
    if name not in sys.modules:
        spec = importlib.util.spec_from_file_location(name, EXAMPLES / f"{name}.py")
        assert spec is not None
        assert spec.loader is not None
        sys.modules[name] = module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
    return sys.modules[name]


def truss(scale: Any) -> LineElement:
    return example("own_truss").Truss(210e9 * AREA * np.asarray(scale), 5.0)  # type: ignore[no-any-return]


def cable(scale: Any) -> LineElement:
    return example("own_cable").Cable(210e9 * AREA * np.asarray(scale), True, 5.0)  # type: ignore[no-any-return]


def footing(scale: Any) -> LineElement:
    kind = example("own_foundation").Footing
    return kind(210e9 * AREA, 1e3, 9e3, 1e5 * np.asarray(scale), 5.0)  # type: ignore[no-any-return]


def heated(scale: Any) -> LineElement:
    return example("own_heated_beam").Heated(  # type: ignore[no-any-return]
        BAR, STEEL, rise=30.0 * np.asarray(scale), gradient=-200.0
    )


def hardening(scale: Any) -> LineElement:
    return example("own_hardening_spring").Hardening(  # type: ignore[no-any-return]
        1e6 * np.asarray(scale), 1e10 * np.asarray(scale)
    )


ELEMENTS: dict[str, Callable[[Any], LineElement]] = {
    "truss": truss,
    "cable": cable,
    "footing": footing,
    "heated": heated,
    "hardening": hardening,
}
MASS = {"heated": 7850.0 * AREA, "hardening": 0.0}
# How much of the buckling load bending moments change, which textbooks' geometric stiffness leaves out; axial forces in
# the element change it by a tenth.
MOMENTS = {"truss": 2e-6, "cable": 2e-6, "hardening": 3e-5, "heated": 2e-4, "footing": 2e-3}
# From C, where an own element starts, to B.
CHORD = np.array([0.1, 2.0, 0.1]) - np.array([1.5, 0.2, -0.3])
# Why large displacement refuses them.
REFUSED = {"footing": "Footing.* resists rigid motion"}


def braced(element: LineElement | None) -> Frame:
    """A post that an own element stays, or without any."""
    frame = Frame()
    for name, place in {"A": (0, 0, 0), "B": (0.1, 2.0, 0.1), "C": (1.5, 0.2, -0.3)}.items():
        frame.node(name, place)
    frame.add("post", Beam(Circle(diameter=0.05), STEEL, segments=2), "A", "B")
    if element is not None:
        frame.add("own", element, "C", "B")
    frame.fix("A")
    frame.fix("C")
    frame.load("B", fx=-300.0, fy=-2000.0, fz=150.0)
    return frame


@pytest.mark.parametrize("kind", ELEMENTS)
def test_batch_is_its_entries_within_their_bounds(kind: str) -> None:
    scale = np.geomspace(0.1, 10.0, 6000)
    batch = braced(ELEMENTS[kind](scale)).solve()
    found, forces = batch.displacement("B"), batch.end_forces("own")
    assert (batch.status == "regular").all()
    for entry in (0, 2222, 5999):
        alone = braced(ELEMENTS[kind](scale[entry])).solve()
        assert_allclose(found[entry], alone.displacement("B"), rtol=1e-9, atol=1e-18)
        assert_allclose(forces[entry], alone.end_forces("own"), rtol=1e-8, atol=1e-7)
        off = np.abs(alone.displacement("B") - alone.refined("B")[0])
        assert (off <= alone.error_bound("B")).all()
        assert (alone.error_bound("B") <= 1e-9 * np.abs(found[entry]).max()).all()


@pytest.mark.parametrize("kind", ELEMENTS)
def test_weight_sensitivity_and_files(kind: str, tmp_path: Path) -> None:
    own, step = ELEMENTS[kind], 1e-5
    frame = braced(own(1.0))
    solution = frame.solve()
    if kind != "footing":  # whose ground takes a share of the weight
        heavy = frame.copy()
        heavy.gravity((0.0, -9.81, 0.0))
        lift = sum(heavy.solve().reaction(node)[1] - solution.reaction(node)[1] for node in "AC")
        post = 7850.0 * np.pi / 4.0 * 0.05**2 * float(frame.length("post"))
        assert_allclose(lift, 9.81 * (MASS.get(kind, 5.0) * float(frame.length("own")) + post), rtol=1e-6)
    if kind != "heated":  # of which the load varies, not the stiffness
        shares = solution.sensitivity("B", "uy").members["own"]
        up, down = (braced(own(1.0 + s)).solve().displacement("B")[1] for s in (step, -step))
        varied = shares[..., -4:] if kind == "footing" else shares
        assert_allclose(varied.sum(), (up - down) / (2.0 * step), rtol=1e-5)
    solution.save(tmp_path / "own.vtu")
    written = meshio.read(tmp_path / "own.vtu")
    moved = written.point_data["displacement"][np.abs(written.points - (0.1, 2.0, 0.1)).max(axis=-1) < 1e-12]
    assert len(moved) >= 2  # ends of the post and of the element
    assert_allclose(moved, np.broadcast_to(solution.displacement("B")[:3], moved.shape), rtol=1e-6)


def textbook(kind: str) -> TextbookMember:
    """What the own element is, from the chord from C to B on."""
    length = float(np.linalg.norm(CHORD))
    if kind == "footing":
        return footing_by_hand(210e9 * AREA, 1e3, 9e3, 1e5, 5.0, length)
    if kind == "heated":  # a beam that would be longer, and curved about its z
        beam = Beam(BAR, STEEL)
        heat, curve = np.zeros((2, 12))
        heat[[0, 6]], curve[[5, 11]] = (-1.0, 1.0), (-1.0, 1.0)
        heat = 1.2e-5 * 210e9 * (30.0 * AREA * heat + 200.0 * float(BAR.Iz) * curve)
        matrices = beam.stiffness_matrix(length), beam.mass_matrix(length), beam.geometric_matrix(length, 1.0)
        return TextbookMember(*matrices, heat, 210e9 * AREA / length)
    return bar(1e6 if kind == "hardening" else 210e9 * AREA / length, MASS.get(kind, 5.0), length)


@pytest.mark.parametrize("kind", ELEMENTS)
def test_as_with_matrices_of_textbooks(kind: str) -> None:
    """Displacement, sensitivity, frequencies and buckling load of the stayed post, by dense matrices.

    Those of the post alone, in two segments, are the frame's; those of the element are added to them.
    """
    own, frame = textbook(kind), braced(ELEMENTS[kind](1.0))
    by, post = braced(None).matrices(), Beam(Circle(diameter=0.05), STEEL)
    axes, at = level_axes(CHORD), np.r_[12:18, 6:12]  # of C, and of B
    K, M, f = by.K.toarray(), by.M.toarray(), by.f.copy()
    stiffness = in_global_axes(own.stiffness, axes)
    K[np.ix_(at, at)] += stiffness
    M[np.ix_(at, at)] += in_global_axes(own.mass, axes)
    f[at] += in_global_axes(own.heat, axes)
    free = np.setdiff1d(np.arange(len(f)), by.D)
    inner = np.ix_(free, free)
    u = np.zeros(len(f))
    u[free] = np.linalg.solve(K[inner], f[free])
    solution = frame.solve()
    assert_allclose(solution.displacement("B"), u[6:12], rtol=1e-9, atol=1e-9 * np.abs(u).max())
    moved = np.zeros(len(f))
    moved[at] = stiffness @ u[at]
    stiffer = np.linalg.solve(K[inner], -moved[free])  # by a share of the element's stiffness
    shares = solution.sensitivity("B", "uy").members["own"]
    assert_allclose(shares.sum(), stiffer[np.flatnonzero(free == 7)[0]], rtol=1e-7)
    squared = scipy.linalg.eigh(K[inner], M[inner], eigvals_only=True)
    assert_allclose(frame.modes(3).frequencies, np.sqrt(squared[:3]) / (2.0 * np.pi), rtol=1e-9)
    rod = np.array([0.1, 2.0, 0.1])
    half, up = float(np.linalg.norm(rod)) / 2.0, rod / np.linalg.norm(rod)
    pushed = 210e9 * float(Circle(diameter=0.05).A) / (2.0 * half) * (up @ u[6:9])
    pulled = own.axial_stiffness * (axes[0] @ u[6:9]) - own.heat[6]
    Kg = np.zeros_like(K)
    Kg[np.ix_(at, at)] += in_global_axes(own.geometric * pulled, axes)
    for ends in (np.r_[0:6, 18:24], np.r_[18:24, 6:12]):
        Kg[np.ix_(ends, ends)] += in_global_axes(post.geometric_matrix(half, pushed), level_axes(rod))
    inverse = scipy.linalg.eigh(-Kg[inner], K[inner], eigvals_only=True)
    assert_allclose(frame.buckling(1).factors, 1.0 / inverse.max(), rtol=MOMENTS[kind])


@pytest.mark.parametrize("kind", ELEMENTS)
def test_large_displacement_or_why_not(kind: str) -> None:
    frame = braced(ELEMENTS[kind](1.0))
    if kind in REFUSED:
        with pytest.raises(FrameError, match=REFUSED[kind]):
            frame.solve(large=True).displacement("B")
        return
    large, linear = frame.solve(large=True).displacement("B"), frame.solve().displacement("B")
    assert_allclose(large, linear, atol=0.1 * np.abs(linear).max())
    assert np.abs(large - linear).max() > 0.0


@pytest.mark.parametrize("kind", ELEMENTS)
def test_as_a_link(kind: str, tmp_path: Path) -> None:
    """The coupler of a four-bar that an own element is: its inertia is that of a rod, and its frame is solved."""

    def four_bar(**coupler: Any) -> Linkage:
        linkage = Linkage(A=(0, 0), B=(0, 0.3), D=(0.5, 0.4), E=(0.5, 0))
        bar = Beam(BAR, STEEL)
        linkage.link("crank", "A", "B", beam=bar)
        linkage.link("coupler", "B", "D", **coupler)
        linkage.link("rocker", "D", "E", beam=bar)
        linkage.revolute("A", "ground", "crank", drive=True)
        linkage.revolute("B", "crank", "coupler")
        linkage.revolute("D", "coupler", "rocker")
        linkage.revolute("E", "rocker", "ground")
        return linkage

    linkage = four_bar(beam=ELEMENTS[kind](1.0))
    length = np.hypot(0.5, 0.1)
    mass = MASS.get(kind, 5.0) * length
    rigid = four_bar(mass=mass, inertia=mass * length**2 / 12.0)
    motion, wanted = (each.move(A=[0.0, 0.2, 0.4], rates={"A": 3.0}) for each in (linkage, rigid))
    assert_allclose(motion.reactions().drive("A"), wanted.reactions().drive("A"), rtol=1e-3)
    # a bar between two pins can turn about itself, which no load makes it
    assert np.isin(motion.frame(inertia=True).solve().status, ["regular", "statically consistent mechanism"]).all()
    given = four_bar(beam=ELEMENTS[kind](1.0), mass=2.0)
    assert np.isfinite(given.move(A=[0.1]).frame().modes(1).frequencies).all()
    with pytest.raises(FrameError, match="a file describes beams, and the linkage has a"):
        write_linkage(linkage, tmp_path / "linkage.toml")


@pytest.mark.parametrize("up", [None, (0.0, 1.0, 0.0)])
def test_heated_strip_curls_into_a_circle(up: tuple[float, ...] | None) -> None:
    """Free of force, in the plane of x and y or of x and z; against a spring, heat does the work that is stored."""
    kind, curvature = example("own_heated_beam").Heated, np.array([0.036, 0.9])
    strip = kind(BAR, STEEL, gradient=-curvature / 1.2e-5, rise=10.0, segments=8, up=up)
    frame = Frame()
    frame.node("A", (0.0, 0.0, 0.0))
    frame.node("B", (2.0, 0.0, 0.0))
    frame.add("AB", strip, "A", "B")
    frame.fix("A")
    solution = frame.solve(large=True)
    across = solution.displacement("B")[:, 1 if up is None else 2] * (1.0 if up is None else -1.0)
    arc = 2.0 * (1.0 + 1.2e-4)
    assert_allclose(across, arc * (1.0 - np.cos(2.0 * curvature)) / (2.0 * curvature), rtol=1e-5)
    assert_allclose(
        solution.displacement("B")[:, 0], arc * np.sin(2.0 * curvature) / (2.0 * curvature) - 2.0, rtol=1e-4
    )
    assert np.abs(solution.forces("AB", [0.7])).max() < 1e-3
    assert frame.solve().linear.tolist() == [True, False]


def test_heat_does_the_work_that_is_stored() -> None:
    """A strip that curls against a spring: strain energy and work come together with the square of the step."""
    kind, off = example("own_heated_beam").Heated, []
    for steps in (2, 4):
        frame = Frame()
        for name, place in {"A": (0, 0, 0), "B": (2, 0, 0), "C": (2.0, -1.0, 0.5)}.items():
            frame.node(name, place)
        frame.add("AB", kind(BAR, STEEL, gradient=-2e4, rise=10.0, segments=3), "A", "B")
        frame.add("tie", Spring(stiffness=1e3), "B", "C")
        frame.fix("A")
        frame.fix("C")
        held = frame.solve(large=True, steps=steps)
        off.append(np.abs(held.work[-1] - held.strain_energy[-1]))
        assert held.strain_energy[-1] > 1.0
    assert off[1] < 0.35 * off[0]


def test_law_in_space_and_in_a_batch() -> None:
    """Two springs at an angle that a weight stretches far, against the energy's own minimum; a batch of laws."""
    kind = example("own_hardening_spring").Hardening
    k, cube = np.array([200.0, 400.0, 300.0]), np.array([[0.0], [2e4]])
    frame = Frame()
    for name, place in {"A": (-1.0, 0.0, 0.2), "B": (0.0, 0.0, 0.0), "C": (1.2, 0.0, 0.1)}.items():
        frame.node(name, place)
    frame.add("AB", kind(k, cube), "A", "B")
    frame.add("BC", kind(k, cube), "B", "C")
    frame.fix("A")
    frame.fix("C")
    frame.fix("B", "uy")
    frame.load("B", fz=-40.0)
    moved = frame.solve(large=True).displacement("B")[..., :3]
    ends = [np.array(place) for place in ((-1.0, 0.0, 0.2), (1.2, 0.0, 0.1))]
    total = np.broadcast_to(np.array([0.0, 0.0, -40.0]), moved.shape).copy()
    for end in ends:
        chord = moved - end
        length = np.linalg.norm(chord, axis=-1)
        stretch = length - np.linalg.norm(end)
        total -= ((k * stretch + cube * stretch**3) / length)[..., None] * chord
    assert_allclose(total[..., [0, 2]], 0.0, atol=1e-6)


def test_law_that_is_another_at_rest_is_refused() -> None:
    class Bent(example("own_hardening_spring").Hardening):  # type: ignore[misc]
        def springs(self, length: Array) -> tuple[Array, Array]:
            stiffness, rows = super().springs(length)
            return 2.0 * stiffness, rows

    frame = Frame()
    frame.node("A", (0.0, 0.0, 0.0))
    frame.node("D", (0.0, 1.0, 0.0))
    with pytest.raises(FrameError, match="Bent of member 'AD': resistance is not its stiffness at rest"):
        frame.add("AD", Bent(1.0, 1.0), "A", "D")


def test_links_refuse_what_is_no_element() -> None:
    linkage = Linkage(A=(0, 0), B=(0, 0.3))
    with pytest.raises(FrameError, match="give a Beam or another LineElement"):
        linkage.link("crank", "A", "B", beam=3)  # type: ignore[arg-type]
