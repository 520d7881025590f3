"""Loops of ideal joints whose directions vary over the batch."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.elements import Beam, Circle, Joint, Material
from linkframe.framework import Frame, FrameError

ROLLER = (np.inf, 0.0, 0.0, 0.0, 0.0, 0.0)


def on_two_rollers(angles: list[float]) -> Frame:
    """A cantilever whose end rolls on two planes; the normal of one is across the other, or turned so far from that."""
    c, s = np.cos(angles), np.sin(angles)
    axes = np.zeros((len(angles), 3, 3))
    axes[:, :, 0] = np.stack([0.0 * c, c, s], axis=-1)
    axes[:, 0, 1] = 1.0
    axes[:, :, 2] = np.cross(axes[:, :, 0], axes[:, :, 1])
    frame = Frame()
    for name, x in {"A": 0.0, "B": 1.0, "G": 1.0, "H": 1.0}.items():
        frame.node(name, (x, 0.0, 0.0))
    frame.add("AB", Beam(Circle(diameter=0.02), Material(E=2e11, nu=0.3)), "A", "B")
    frame.add("one", Joint(stiffness=ROLLER), "G", "B")
    frame.add("two", Joint(stiffness=ROLLER, axes=axes), "H", "B")
    for node in "AGH":
        frame.fix(node)
    frame.load("B", fy=10.0, fz=5.0)
    return frame


def test_between_them_each_entry_is_as_alone() -> None:
    angles = [1e-9, 0.3, 1.2, 0.5 * np.pi - 1e-9]
    whole = on_two_rollers(angles).solve()
    for entry, angle in enumerate(angles):
        alone = on_two_rollers([angle]).solve()
        off = np.abs(whole.displacement("B")[entry] - alone.displacement("B")[0])
        assert (off <= whole.error_bound("B")[entry] + alone.error_bound("B")[0]).all()


def test_what_no_unknown_follows_from_at_all_entries_is_refused_as_that() -> None:
    """Neither entry is singular."""
    with pytest.raises(FrameError, match="ties other coordinates at some batch entries than at others: solve those"):
        _ = on_two_rollers([0.0, 0.5 * np.pi]).solve().status
    for angle in (0.0, 0.5 * np.pi):
        assert (on_two_rollers([angle]).solve().status == "regular").all()
