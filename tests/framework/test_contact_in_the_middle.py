"""Journals that may rest in many places of one energy: the one in the middle, whatever else is in the batch."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.elements import Beam, Joint, Material, Rectangle
from linkframe.framework import Frame
from linkframe.framework.clearances.middle import in_the_middle
from numpy.testing import assert_allclose
from numpy.typing import ArrayLike
from scipy.optimize import brentq

BAR, BENDING = Beam(Rectangle(y=0.02, z=0.02), Material(E=200e9, nu=0.3)), 200e9 * 0.02**4 / 12.0
CLEARANCE = 1.25e-4
RNG = np.random.default_rng(1)
MANY = 40
PUSH, STIFFNESS, HEIGHT = RNG.uniform(0.02, 0.98, MANY), 10.0 ** RNG.uniform(6, 10, MANY), RNG.uniform(0.5, 2.0, MANY)


def portal(push: ArrayLike, stiffness: ArrayLike, height: ArrayLike, degrees: float) -> Frame:
    """Two columns and a beam that lies in a journal on each; the first column is pushed by its share of what would take
    the beam across both clearances."""
    push, stiffness, height = np.asarray(push), np.asarray(stiffness)[..., None], np.asarray(height)
    cosine, sine, frame = np.cos(np.radians(degrees)), np.sin(np.radians(degrees)), Frame()
    for name, x, y in (("A", 0, 0), ("B", 0, 1), ("B2", 0, 1), ("C", 1, 1), ("C2", 1, 1), ("D", 1, 0)):
        y = y * height
        frame.node(name, np.stack([x * cosine - y * sine, x * sine + y * cosine, 0.0 * y], axis=-1))
    for start, end in (("A", "B"), ("B2", "C"), ("C2", "D")):
        frame.add(start + end, BAR, start, end)
    spring = stiffness * np.array([1.0, 1.0, 1.0, 0.1, 0.1, 0.0])
    pin = Joint(spring, clearance=CLEARANCE, clearance_directions=("ux", "uy"))
    frame.add("left", pin, "B", "B2")
    frame.add("right", pin, "C", "C2")
    frame.fix("A")
    frame.fix("D")
    force = push * 2.0 * CLEARANCE * 3.0 * BENDING / height**3
    frame.load("B", fx=force * cosine, fy=force * sine)
    return frame


@pytest.mark.parametrize("degrees", [0.0, 40.0])
def test_each_journal_takes_half_of_what_the_column_moves(degrees: float) -> None:
    solution = portal(PUSH, STIFFNESS, HEIGHT, degrees).solve()
    along = np.array([np.cos(np.radians(degrees)), np.sin(np.radians(degrees)), 0.0])
    for name in ("left", "right"):
        contact = solution.contact(name)
        assert set(contact.status.tolist()) == {"free"}
        assert_allclose(contact.offset, -(PUSH * CLEARANCE)[:, None] * along, atol=1e-8 * CLEARANCE)


def test_an_entry_does_not_know_of_its_neighbours() -> None:
    degrees, order = 40.0, RNG.permutation(MANY)
    whole, other = (
        portal(PUSH[some], STIFFNESS[some], HEIGHT[some], degrees).solve() for some in (np.arange(MANY), order)
    )
    for name in ("left", "right"):
        found = whole.contact(name).offset
        assert_allclose(other.contact(name).offset, found[order], rtol=0.0, atol=1e-8 * CLEARANCE)
        for entry in (7, 23):
            alone = portal(PUSH[entry], STIFFNESS[entry], HEIGHT[entry], degrees).solve()
            assert_allclose(alone.contact(name).offset, found[entry], rtol=0.0, atol=1e-8 * CLEARANCE)


def test_from_far_away_the_middle_is_found_without_stepping_over_a_sphere() -> None:
    """Forty journals that meet their spheres on one side and one on the other move alike: where the sum of
    ``log(1 - x²)`` is greatest. A full step of Newton's method leads outside."""
    count, apart = 40, 0.9
    rest = np.append(np.full(count, -apart), apart)
    expected = brentq(lambda t: np.sum((t + rest) / (1.0 - (t + rest) ** 2)), apart - 1.0 + 1e-12, 1.0 - apart - 1e-12)
    own, starts = np.arange(count + 1), np.array([-0.05, 0.05, 0.09])
    stiffness = np.repeat((np.eye(count + 1) * (count + 1) - 1.0)[..., None], len(starts), axis=-1)
    x, members = rest[:, None] + starts, np.full((count + 1, len(starts)), count + 1.0)
    found = in_the_middle(own, stiffness, members, x, np.zeros(x.shape, dtype=bool), x)
    assert_allclose(found, np.repeat((rest + expected)[:, None], len(starts), axis=-1), atol=1e-12)
