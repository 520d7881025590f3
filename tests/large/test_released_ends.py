"""Released ends at large displacement and in buckling: an energy written here, and hinges described as joints."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.elements import Beam, Joint, Material, Rectangle, Section, Spring
from linkframe.framework import Frame, FrameError
from linkframe.framework.dofs import DISPLACEMENTS
from linkframe.framework.results.validity import nonlinearity
from numpy.testing import assert_allclose
from numpy.typing import NDArray

Array = NDArray[np.complex128]

EA, EI, SPRING, SOFT, TURNED, OUT = 4e5, 60.0, 3e3, (2e4, 5e4, 300.0), 0.4, 4e-3
PLACES = {"A": (0.0, 0.0), "B": (0.8, 0.3), "C": (0.8, 0.3), "D": (1.5, -0.1), "E": (1.6, 0.15), "G": (2.2, 0.9)}


def pinned_and_sprung(load: tuple[float, float]) -> Frame:
    """A clamped beam, a joint with an offset, a beam hinged by a release, and a spring on a rigid arm at its end."""
    beam = Section(A=EA, Iy=EI, Iz=EI, J=1.0), Material(E=1.0, nu=0.0)
    c, s = np.cos(TURNED), np.sin(TURNED)
    frame = Frame()
    for name, (x, y) in PLACES.items():
        frame.node(name, (x, y, 0.0))
    frame.add("AB", Beam(*beam, shear=False), "A", "B")
    frame.add("CD", Beam(*beam, shear=False, release=("start rz",)), "C", "D")
    stiffness = (*SOFT[:2], np.inf, np.inf, np.inf, SOFT[2])
    frame.add("joint", Joint(stiffness, axes=[[c, -s, 0], [s, c, 0], [0, 0, 1]]), "B", "C")
    frame.offset("joint", ux=OUT, rz=-OUT)
    frame.rigid("D", "E")
    frame.add("spring", Spring(SPRING), "E", "G")
    frame.add("other", Spring(SPRING), "C", "G")
    frame.fix("A")
    frame.fix("G")
    frame.load("E", fx=load[0], fy=load[1])
    return frame


def energy(moved: Array, load: tuple[float, float]) -> Array:
    """That of `pinned_and_sprung` by ``ux uy rz`` of B, C, D and the hinged end, (..., 10), less the load's work."""
    at = {name: np.array(place) + 0.0 * moved[..., :2] for name, place in PLACES.items()}
    turn = {"A": 0.0 * moved[..., 0]}
    for k, name in enumerate("BCD"):
        at[name], turn[name] = at[name] + moved[..., 3 * k : 3 * k + 2], moved[..., 3 * k + 2]
    arm = np.subtract(PLACES["E"], PLACES["D"])
    at["E"] = at["D"] + rotated(arm, turn["D"])
    apart = rotated(at["C"] - at["B"], -turn["B"] - TURNED)
    gaps = [apart[..., 0] - OUT, apart[..., 1], turn["C"] - turn["B"] + OUT]
    total = sum(0.5 * k * gap**2 for k, gap in zip(SOFT, gaps, strict=True))
    for start, end, released in (("A", "B", False), ("C", "D", True)):
        rest = np.subtract(PLACES[end], PLACES[start])
        chord, length = at[end] - at[start], np.hypot(*rest)
        turned = np.arctan((rest[0] * chord[..., 1] - rest[1] * chord[..., 0]) / np.sum(rest * chord, axis=-1))
        far = turn[end] - turned
        near = (moved[..., 9] if released else turn[start]) - turned
        # bending shortens the chord by half the mean square of the slope
        longer = span(chord) - length + length / 30.0 * (2.0 * near**2 - near * far + 2.0 * far**2)
        total = total + 0.5 * EA / length * longer**2 + 2.0 * EI / length * (near**2 + near * far + far**2)
    for end in "EC":
        rest = np.hypot(*np.subtract(PLACES["G"], PLACES[end]))
        total = total + 0.5 * SPRING * (span(at["G"] - at[end]) - rest) ** 2
    return np.asarray(total - np.sum(np.asarray(load) * (at["E"] - PLACES["E"]), axis=-1))


def rotated(vector: Array, angle: Array) -> Array:
    c, s = np.cos(angle), np.sin(angle)
    return np.stack([c * vector[..., 0] - s * vector[..., 1], s * vector[..., 0] + c * vector[..., 1]], axis=-1)


def span(vector: Array) -> Array:
    return np.asarray(np.sqrt(np.sum(vector**2, axis=-1)))


@pytest.mark.parametrize("load", [(0.0, 0.0), (60.0, -150.0), (-200.0, 300.0)])
def test_release_offset_and_springs_together_in_the_plane(load: tuple[float, float]) -> None:
    """The energy is stationary where the frame comes to rest, by derivatives along an imaginary step."""
    solution = pinned_and_sprung(load).solve(large=True)
    assert solution.status == "stable"
    hinged = solution.displacement_along("CD", [0.0])[0, 5:]
    moved = np.concatenate([*(solution.displacement(name)[[0, 1, 5]] for name in "BCD"), hinged])
    assert np.abs(moved).max() > (0.1 if any(load) else 1e-3)
    forces = energy(moved + 1e-30j * np.eye(10), load).imag / 1e-30
    assert_allclose(forces, 0.0, atol=1e-8 * SPRING)


def portal(released: str, end: int, segments: int, hinge: bool) -> Frame:
    """Three beams in space under forces; the second is released at an end, or has an ideal joint there."""
    places = {"A": (0.0, 0.0, 0.0), "B": (1.0, 0.0, 0.2), "C": (1.3, 0.8, 0.1), "D": (1.5, 0.9, 1.0)}
    section, material = Rectangle(y=0.03, z=0.06), Material(E=2e9, nu=0.3)
    frame = Frame()
    for name, place in places.items():
        frame.node(name, place)
    beam = Beam(section, material, segments=segments)
    frame.add("AB", beam, "A", "B")
    frame.add("CD", beam, "C", "D")
    if hinge:
        frame.node("T", places["BC"[end]])
        frame.add("BC", beam, *(("T", "C") if end == 0 else ("B", "T")))
        stiffness = np.where([name in released.split() for name in DISPLACEMENTS], 0.0, np.inf)
        axes = beam.axes(np.subtract(places["C"], places["B"])).T
        frame.add("hinge", Joint(stiffness, axes=axes), "T", "BC"[end])
    else:
        release = [f"{('start', 'end')[end]} {name}" for name in released.split()]
        frame.add("BC", Beam(section, material, segments=segments, release=release), "B", "C")
    frame.fix("A")
    frame.fix("D")
    frame.load("B", fx=15.0, fy=-200.0, fz=100.0)
    frame.load("C", fx=50.0, fz=-150.0)
    frame.line_load("BC", fz=-20.0)
    return frame


@pytest.mark.parametrize(("end", "segments"), [(0, 1), (1, 3)])
@pytest.mark.parametrize("released", ["rx", "ry", "rz", "ry rz", "rx rz", "rx ry rz", "ux", "uy", "ux rz"])
def test_a_released_end_in_space_is_an_ideal_joint(released: str, end: int, segments: int) -> None:
    """Its axes are those of the member's end, at any number of segments."""
    given, joined = (portal(released, end, segments, hinge).solve(large=True) for hinge in (False, True))
    assert given.status == joined.status == "stable"
    for node in "BC":
        expected = joined.displacement(node)
        assert np.abs(expected).max() > 0.02
        assert_allclose(given.displacement(node), expected, rtol=0.0, atol=1e-12)
    forces = joined.end_forces("BC")
    assert_allclose(given.end_forces("BC"), forces, rtol=0.0, atol=1e-9 * np.abs(forces).max())


@pytest.mark.parametrize(("end", "segments"), [(0, 1), (1, 3)])
@pytest.mark.parametrize("released", ["rx", "ry", "rz", "ry rz", "rx rz", "rx ry rz", "ux", "uy", "uz", "ux rz"])
def test_a_released_end_buckles_as_an_ideal_joint(released: str, end: int, segments: int) -> None:
    """Its axes are those of the member's end here as well, and the lowest load is that beyond which it is unstable."""
    given, joined = (portal(released, end, segments, hinge) for hinge in (False, True))
    factors = joined.buckling(2).factors
    assert_allclose(given.buckling(2).factors, factors, rtol=1e-9)
    for factor, stable in ((0.999, True), (1.001, False)):
        loaded = portal(released, end, segments, hinge=False)
        loaded.loads.clear()
        loaded.member_loads.clear()
        size = factor * factors[0]
        loaded.load("B", fx=15.0 * size, fy=-200.0 * size, fz=100.0 * size)
        loaded.load("C", fx=50.0 * size, fz=-150.0 * size)
        loaded.line_load("BC", fz=-20.0 * size)
        assert np.isfinite(nonlinearity(loaded.solve())) == stable


@pytest.mark.parametrize("end", [0, 1])
@pytest.mark.parametrize("released", ["rx", "ry", "rz", "ry rz", "rx ry rz", "ux", "uy", "ux rz", "uy rz"])
def test_matrices_of_a_released_member_are_those_of_an_ideal_joint_condensed(released: str, end: int) -> None:
    """What is free in the joint moves as statics without loads says, by multipliers for the nodes that remain."""
    given, joined = (portal(released, end, 1, hinge).matrices() for hinge in (False, True))
    change = joined.T.toarray()
    stiffness, geometric = (change.T @ each.toarray() @ change for each in (joined.K, joined.Kg))
    kept = slice(6, 18)  # of B and C, between the supports
    count, nodes = change.shape[1], change[kept]
    whole = np.block([[stiffness, nodes.T], [nodes, np.zeros((12, 12))]])
    moved = np.linalg.solve(whole, np.eye(count + 12)[:, count:])[:count]
    for own, other in ((given.K, stiffness), (given.Kg, geometric)):
        expected = moved.T @ other @ moved
        assert_allclose(own.toarray()[kept, kept], expected, rtol=0.0, atol=1e-10 * np.abs(expected).max())


# The buckling length over that of the column: Timoshenko & Gere, Theory of Elastic Stability, 1961, pp. 48-54.
@pytest.mark.parametrize(("released", "length"), [("end uy", 1.0), ("end rz", np.pi / 4.493409457909064)])
def test_a_clamped_column_with_a_released_top(released: str, length: float) -> None:
    """One segment has the error of a cubic deflection, ``10 E I / L^2`` and ``30 E I / L^2``; eight are near."""
    size, section, material = 0.04 * 0.02**3 / 12.0, Rectangle(y=0.02, z=0.04), Material(E=2e9, nu=0.3)
    exact = np.pi**2 * 2e9 * size / length**2
    found = []
    for segments in (1, 2, 4, 8):
        frame = Frame()
        frame.node("A", (0.0, 0.0, 0.0))
        frame.node("B", (1.0, 0.0, 0.0))
        frame.add("AB", Beam(section, material, segments=segments, release=released), "A", "B")
        frame.fix("A")
        frame.fix("B", "uy", "uz", "rx", "ry", "rz")
        frame.load("B", fx=-1.0)
        found.append(frame.buckling(1).factors[0] / exact - 1.0)
    cubic = {"end uy": 10.0, "end rz": 30.0}[released] * 2e9 * size
    assert_allclose(found[0], cubic / exact - 1.0, rtol=1e-3)
    assert np.all(np.diff(found) < 0.0)
    assert abs(found[-1]) < 3e-4


def test_a_mechanism_with_a_released_end_is_told_by_the_nodes_of_the_frame() -> None:
    frame = Frame()
    frame.node("A", (0.0, 0.0, 0.0))
    frame.node("B", (1.0, 0.0, 0.0))
    frame.add("AB", Beam(Rectangle(y=0.02, z=0.04), Material(E=2e9, nu=0.3), release="start rz"), "A", "B")
    frame.fix("A")
    frame.load("B", fx=-1.0, fy=1.0)
    with pytest.raises(FrameError, match=r"mechanism even without the load: free motion 1: B \([+-]uy [+-]rz\)$"):
        frame.buckling(1)


def test_released_ends_turn_with_the_body_of_their_member() -> None:
    """A bent frame on a body, and the same by itself, turned by hand."""
    angle = np.array([0.3, 1.4])
    c, s = np.cos(angle), np.sin(angle)
    turned = np.stack([np.stack([c, -s, 0 * c], -1), np.stack([s, c, 0 * c], -1), np.full((2, 3), (0.0, 0.0, 1.0))], -2)
    frame = Frame()
    frame.body("whole", axes=turned)
    for name, place in {"A": (0.0, 0.0, 0.0), "B": (1.0, 0.0, 0.2), "C": (1.3, 0.8, 0.1)}.items():
        frame.node(name, place, body="whole")
    section, material = Rectangle(y=0.03, z=0.06), Material(E=2e9, nu=0.3)
    frame.add("AB", Beam(section, material), "A", "B")
    frame.add("BC", Beam(section, material, release="start rz"), "B", "C")
    frame.fix("A")
    frame.fix("C")
    force = turned @ (15.0, -200.0, 150.0)
    frame.load("B", fx=force[:, 0], fy=force[:, 1], fz=force[:, 2])
    moved = frame.solve(large=True).displacement("B").reshape(2, 2, 3)
    back = np.einsum("pji,pkj->pki", turned, moved)
    assert np.abs(back).max() > 0.015
    assert_allclose(back[0], back[1], rtol=0.0, atol=1e-12)


def test_a_bar_hinged_about_one_axis_at_both_ends_stays_straight_and_does_not_buckle() -> None:
    """Of one segment: four times Euler's load shortens it by ``F L / E A`` alone; two segments are unstable in it."""
    section, material = Rectangle(y=0.02, z=0.04), Material(E=2e9, nu=0.3)
    load = 4.0 * np.pi**2 * 2e9 * 0.04 * 0.02**3 / 12.0
    frame = Frame()
    frame.node("A", (0.0, 0.0, 0.0))
    frame.node("B", (1.0, 0.0, 0.0))
    frame.add("AB", Beam(section, material, release=("start rz", "end rz")), "A", "B")
    frame.fix("A")
    frame.fix("B", "uy", "uz", "rx", "ry", "rz")
    frame.load("B", fx=-load)
    solution = frame.solve(large=True)
    assert solution.status == "stable"
    assert_allclose(solution.displacement("B")[0], -load / (2e9 * 0.02 * 0.04), rtol=1e-9)
