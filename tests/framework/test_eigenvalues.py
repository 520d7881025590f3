"""Eigenvalues that are not there: no compression, no resistance."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.elements import Beam, Material, Rectangle
from linkframe.framework import Frame
from numpy.testing import assert_allclose

BEAM = Beam(Rectangle(y=0.03, z=0.02), Material(E=200e9, nu=0.3, density=7850.0), segments=4)
TURN = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0]


def bracket(turn: np.ndarray[tuple[int, int], np.dtype[np.float64]], force: tuple[float, float, float]) -> Frame:
    """A cantilever with a branch at its end that carries nothing, turned in space."""
    frame = Frame()
    for name, place in {"A": (0, 0, 0), "B": (1, 0, 0), "C": (1, 0.5, 0)}.items():
        frame.node(name, turn @ place)
    frame.add("AB", BEAM, "A", "B")
    frame.add("BC", BEAM, "B", "C")
    frame.fix("A")
    frame.load("B", **dict(zip(("fx", "fy", "fz"), turn @ force, strict=True)))
    return frame


@pytest.mark.parametrize("turn", [np.eye(3), TURN], ids=["level", "turned"])
@pytest.mark.parametrize("force", [(1e3, 0.0, 0.0), (0.0, 1e3, 0.0), (1e3, 1e3, 0.0), (0.0, 0.0, 0.0)])
def test_what_is_not_compressed_does_not_buckle(
    turn: np.ndarray[tuple[int, int], np.dtype[np.float64]], force: tuple[float, float, float]
) -> None:
    """Pulled, bent, both, and not loaded at all: no factor, however large, is made of rounding."""
    assert np.isinf(bracket(turn, force).buckling(4).factors).all()
    pressed = bracket(turn, (-1e3, force[1], force[2])).buckling(1).factors
    assert_allclose(pressed, np.pi**2 * 200e9 * 0.03 * 0.02**3 / 12 / 4.0 / 1e3, rtol=2e-3)


def test_what_nothing_holds_has_frequency_zero() -> None:
    """Six motions of a free frame, to the last bit; elastic ones come after them."""
    frame = bracket(np.eye(3), (0.0, 0.0, 0.0))
    frame.supports.clear()
    found = frame.modes(9).frequencies
    assert found[:6].tolist() == [0.0] * 6
    assert np.all(found[6:] > 10.0)


def test_the_motion_of_a_regular_frame_is_none_in_words() -> None:
    assert bracket(np.eye(3), (1.0, 0.0, 0.0)).solve().mechanism() == ""
