"""Loops of ideal joints whose directions vary over the batch: each entry is as it is when it is solved alone."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from linkframe.elements import Beam, Circle, Joint, Material
from linkframe.framework import Frame, FrameError, MechanismWarning
from numpy.typing import NDArray

Numbers = NDArray[np.float64]
ROLLER = (np.inf, 0.0, 0.0, 0.0, 0.0, 0.0)
# A roller whose node turns with its slide.
SLIDE = (np.inf, np.inf, 0.0, np.inf, np.inf, np.inf)
ROD = Beam(Circle(diameter=0.02), Material(E=2e11, nu=0.3, density=7850.0))
BENDING = 2e11 * np.pi * 0.02**4 / 64.0
# Across the first roller of `between_rollers`, along it both ways, and at random.
TURNED = [0.0, 0.5 * np.pi, np.pi, 1e-9]


def turned(angles: list[float] | Numbers) -> Numbers:
    """Axes whose x is the normal (0, cos, sin)."""
    c, s = np.cos(angles), np.sin(angles)
    axes = np.zeros((*np.shape(angles), 3, 3))
    axes[..., 0] = np.stack([0.0 * c, c, s], axis=-1)
    axes[..., 0, 1] = 1.0
    axes[..., 2] = np.cross(axes[..., 0], axes[..., 1])
    return axes


def on_two_rollers(angles: list[float] | Numbers) -> Frame:
    """A cantilever whose end rolls on two planes; the normal of one is across the other, or turned so far from that."""
    frame = Frame()
    for name, x in {"A": 0.0, "B": 1.0, "G": 1.0, "H": 1.0}.items():
        frame.node(name, (x, 0.0, 0.0))
    frame.add("AB", ROD, "A", "B")
    frame.add("one", Joint(stiffness=ROLLER), "G", "B")
    frame.add("two", Joint(stiffness=ROLLER, axes=turned(angles)), "H", "B")
    for node in "AGH":
        frame.fix(node)
    frame.load("B", fy=10.0, fz=5.0)
    return frame


def between_rollers(angles: list[float], *, clamped: bool, push: float = 5.0) -> Frame:
    """A rod from B to C; B slides along z, and rolls on a plane, which only where that is across z is needed not.

    It is also carried by a rod from the wall where it is `clamped`.
    """
    frame = Frame()
    for name, x in {"B": 1.0, "C": 1.5, "G": 1.0, "H": 1.0}.items():
        frame.node(name, (x, 0.0, 0.0))
    frame.add("BC", ROD, "B", "C")
    frame.add(
        "one", Joint(stiffness=ROLLER if clamped else SLIDE, axes=turned([0.0])[0] if clamped else None), "G", "B"
    )
    frame.add("two", Joint(stiffness=ROLLER, axes=turned(angles)), "H", "B")
    if clamped:
        frame.node("A", (0.0, 0.0, 0.0))
        frame.add("AB", ROD, "A", "B")
        frame.fix("A")
    frame.fix("G")
    frame.fix("H")
    frame.load("C", fx=-3.0, fy=10.0, fz=push)
    return frame


def test_turned_entries_are_those_of_lagrange_multipliers() -> None:
    """End of a cantilever (uy rz uz ry) and the multiplier of the second roller, in enough entries to go in chunks."""
    angles = np.concatenate([[0.0, 0.5 * np.pi], np.random.default_rng(0).uniform(0.0, np.pi, 598)])
    c, s = np.cos(angles), np.sin(angles)
    matrix = np.zeros((600, 5, 5))
    matrix[:, :4, :4] = [[12.0, -6.0, 0.0, 0.0], [-6.0, 4.0, 0.0, 0.0], [0.0, 0.0, 12.0, 6.0], [0.0, 0.0, 6.0, 4.0]]
    matrix[:, 4, [0, 2]] = matrix[:, [0, 2], 4] = np.stack([c, s], axis=-1)
    found = np.linalg.solve(matrix, np.broadcast_to([10.0, 0.0, 5.0, 0.0, 0.0], (600, 5))[..., None])[..., 0]
    for method in ("broadcast", "banded"):
        solution = on_two_rollers(angles).solve(method)
        end = solution.displacement("B")[:, [1, 5, 2, 4]]
        assert np.abs(end * BENDING - found[:, :4]).max() < 1e-12 * np.abs(found[:, :4]).max()
        assert np.abs(solution.joint_force("two")[:, 0] - found[:, 4]).max() < 1e-12 * np.abs(found[:, 4]).max()
        assert (solution.status == "regular").all()


@pytest.mark.parametrize(
    ("clamped", "push", "states"),
    [
        (True, 5.0, ["regular"] * 4),
        (False, 5.0, ["mechanism", "regular", "mechanism", "regular"]),
        (False, 0.0, ["statically consistent mechanism", "regular"] * 2),
    ],
)
def test_each_entry_is_as_alone(clamped: bool, push: float, states: list[str]) -> None:
    """Also beside entries at which the loop is singular: they determine one unknown less."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", MechanismWarning)
        whole = between_rollers(TURNED, clamped=clamped, push=push).solve()
        assert whole.status.tolist() == states
        modes = between_rollers(TURNED, clamped=clamped).modes(4).frequencies
        for entry, angle in enumerate(TURNED):
            one = between_rollers([angle], clamped=clamped, push=push)
            alone = one.solve()
            assert alone.status[0] == states[entry]
            for read in (
                lambda found: found.displacement("C"),
                lambda found: found.error_bound("C"),
                lambda found: found.reaction("H"),
                lambda found: found.joint_force("one"),
                lambda found: found.end_forces("BC"),
                lambda found: found.scaled_condition_number(),
                lambda found: found.distance_to_singularity(),
            ):
                np.testing.assert_allclose(read(whole)[entry], read(alone)[0], rtol=1e-9, atol=1e-15)
            assert whole.free_motion(entry).count == alone.free_motion(0).count
            assert whole.mechanism(entry) == alone.mechanism(0)
            np.testing.assert_allclose(modes[entry], one.modes(4).frequencies[0], rtol=1e-9, atol=1e-9)


def test_a_mechanism_among_others_takes_no_buckling_factors_from_them() -> None:
    with pytest.warns(
        MechanismWarning, match=r"2 of 4 batch entries have no factors: at the first, \[0\], the frame is"
    ):
        found = between_rollers(TURNED, clamped=False).buckling(2).factors
    alone = between_rollers(TURNED[1:2], clamped=False).buckling(2).factors[0]
    assert np.isnan(found[[0, 2]]).all()
    np.testing.assert_allclose(found[[1, 3]], [alone, alone], rtol=1e-9)


def test_free_columns_of_an_entry_are_its_own() -> None:
    """An unknown that is free only where the loop is singular is no column of the matrices elsewhere."""
    frame = between_rollers(TURNED, clamped=True)
    for entry, angle in enumerate(TURNED):
        whole, alone = frame.matrices(entry), between_rollers([angle], clamped=True).matrices(0)
        assert whole.T.shape == alone.T.shape
        free = (whole.T.T @ whole.K @ whole.T).toarray()
        found = whole.T @ np.linalg.solve(free, whole.T.T @ (whole.f - whole.K @ whole.g)) + whole.g
        end = 6 * list(frame.nodes).index("C")
        np.testing.assert_allclose(found[end : end + 6], frame.solve().displacement("C")[entry], rtol=1e-9, atol=1e-12)


def test_what_carries_all_others_along_is_free_alone_as_in_a_batch() -> None:
    """What members resist cancels, to rounding that is not small beside itself."""
    angles = np.linspace(0.1, 1.5, 40)[:6]
    states = [str(bracket(angle).solve().status) for angle in angles]
    assert states == ["mechanism"] * 6 == bracket(angles).solve().status.tolist()


def test_modes_of_what_slides_freely() -> None:
    """As those of stiff joints in place of ideal ones: one of no frequency, alone as in a batch."""
    angles = np.array([0.17, 0.21, 0.3])
    found = bracket(angles).modes(4).frequencies
    for angle, own in zip(angles, found, strict=True):
        np.testing.assert_allclose(own, bracket(angle).modes(4).frequencies, rtol=1e-9, atol=1e-4)
    np.testing.assert_allclose(found, bracket(angles, 1e13).modes(4).frequencies, rtol=1e-4, atol=0.1)
    assert (found[:, 0] < 1e-4).all()


def bracket(angle: float | Numbers, stiff: float = np.inf) -> Frame:
    """A bent rod whose end and corner are joined to its start, on a roller and on a plane: it slides freely."""
    frame = Frame()
    places = {"A": (0.5, 0.5, 0.25), "B": (1.0, 1.0, 0.0), "C": (2.5, 0.5, 0.25)}
    places |= {"on C": places["A"], "on B": places["A"], "G": places["A"], "H": places["B"]}
    for name, place in places.items():
        frame.node(name, place)
    frame.add("AB", ROD, "A", "B")
    frame.add("BC", ROD, "B", "C")
    frame.rigid("C", "on C")
    frame.rigid("B", "on B")
    c, s = np.cos(angle), np.sin(angle)
    around = np.zeros((*np.shape(angle), 3, 3)) + np.diag([0.0, 0.0, 1.0])
    around[..., 0, 0], around[..., 0, 1], around[..., 1, 0], around[..., 1, 1] = c, -s, s, c
    tilted = np.array([[np.cos(0.3), 0.0, np.sin(0.3)], [0.0, 1.0, 0.0], [-np.sin(0.3), 0.0, np.cos(0.3)]])
    frame.add("roller", Joint(stiffness=(stiff, 0.0, 0.0, 0.0, 1e6, 1e6), axes=around), "G", "A")
    frame.add("end", Joint(stiffness=(0.0, 0.0, stiff, stiff, 1e6, stiff), axes=around), "on C", "A")
    frame.add("plane", Joint(stiffness=(0.0, 0.0, stiff, stiff, stiff, 1e6)), "H", "B")
    frame.add("corner", Joint(stiffness=(0.0, *(stiff,) * 5), axes=tilted), "on B", "A")
    frame.fix("G")
    frame.fix("H")
    frame.load("C", fx=0.5, fy=-1.0, mz=1.5)
    return frame


@pytest.mark.parametrize("what", ["buckling", "modes"])
def test_no_more_shapes_than_an_entry_has_alone(what: str) -> None:
    """Of the twelve displacements of a rod two rollers hold one or two."""
    with pytest.raises(FrameError, match=rf"{what}\(11\): batch entry \[1\], .* has 10 unknowns"):
        getattr(between_rollers([0.0, 1.0], clamped=True), what)(11)
    with pytest.raises(FrameError, match=rf"{what}\(11\): give a whole number from 1 to the frame's 10 unknowns"):
        getattr(between_rollers([1.0], clamped=True), what)(11)
    assert getattr(between_rollers([0.0, np.pi], clamped=True), what)(11)
