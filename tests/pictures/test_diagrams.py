"""Diagrams of members that know their forces at the ends of their segments alone, or not at all."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import skfem
from linkframe.elements import Beam, Material, Rectangle, Section
from linkframe.framework import Frame, FrameError, Solution
from numpy.testing import assert_allclose
from pictures.test_plots import artists

LENGTH, FORCE, GROUND = 4.0, 1000.0, 2e5
STEEL = Material(E=210e9, nu=0.3)


@skfem.BilinearForm
def foundation(u: Any, v: Any, w: Any) -> Any:
    """Springs across the member."""
    return w.k * u[1] * v[1]


def on_ground(beam: Beam, *others: tuple[str, Beam]) -> Solution:
    frame = Frame()
    frame.node("A", (0.0, 0.0, 0.0))
    frame.node("B", (LENGTH / 2, 0.0, 0.0))
    frame.node("C", (LENGTH, 0.0, 0.0))
    for name, own in (("AB", beam), ("BC", beam), *others):
        frame.add(name, own, name[0], name[1])
    frame.fix("A", "ux", "uz", "rx", "ry")
    frame.load("B", fy=-FORCE)
    frame.add_form(foundation, on=["AB", "BC"], k=GROUND)
    return frame.solve()


def test_moments_of_members_with_a_form_are_drawn_at_the_ends_of_their_segments() -> None:
    """Greatest moment of a beam on ground, F (cosh s − cos s) / 4 λ (sinh s + sin s), s = λ L (Hetényi 1946, III)."""
    solution = on_ground(Beam(Rectangle(y=0.06, z=0.04), STEEL, segments=16))
    axes = solution.plot("M")
    left, right = (each.get_xy()[:17] for each in artists(axes, "diagram") if hasattr(each, "get_xy"))
    assert_allclose(left[:, 0], np.linspace(0.0, 2.0, 17))
    stretch = (GROUND / (4.0 * 210e9 * 0.04 * 0.06**3 / 12.0)) ** 0.25
    s = stretch * LENGTH
    greatest = FORCE / (4.0 * stretch) * (np.cosh(s) - np.cos(s)) / (np.sinh(s) + np.sin(s))
    (told,) = {text.get_text() for text in axes.texts if text.get_gid() == "value"}
    assert float(told) == pytest.approx(greatest, rel=3e-3)
    tips = np.concatenate(
        [each.get_xydata()[1:18, 1] for each in artists(axes, "diagram") if hasattr(each, "get_xydata")]
    )
    moment = [solution.forces(name, np.linspace(0.0, 2.0, 17))[:, 5] for name in ("AB", "BC")]
    assert_allclose(tips / tips.min(), np.concatenate(moment) / np.max(moment), atol=1e-9)
    bar = solution.plot("von_mises").figure.axes[1]
    assert bar.get_ylim()[1] == pytest.approx(1e-6 * float(told) * 0.03 / (0.04 * 0.06**3 / 12.0), rel=1e-3)
    assert len(right) == 17


def test_what_no_member_tells_is_refused_and_what_some_do_not_tell_is_said() -> None:
    known_by_number = Beam(Section(A=1e-3, Iy=1e-7, Iz=1e-7, J=1e-7), STEEL)
    frame = Frame()
    for name, x in {"A": 0.0, "B": 1.0, "C": 2.0}.items():
        frame.node(name, (x, 0.0, 0.0))
    frame.add("AB", known_by_number, "A", "B")
    frame.fix("A")
    frame.load("B", fy=1.0)
    with pytest.raises(FrameError, match="'AB' does not tell its von Mises stress, nor does any other"):
        frame.solve().plot("von_mises")
    frame.add("BC", Beam(Rectangle(y=0.06, z=0.04), STEEL), "B", "C")
    frame.load("C", fy=1.0)
    assert "not known of AB" in frame.solve().plot("von_mises").get_title(loc="left")


def test_names_at_the_edge_of_a_long_frame_are_clear_of_the_title() -> None:
    axes: Any = on_ground(Beam(Rectangle(y=0.06, z=0.04), STEEL, segments=4)).plot("M")
    axes.figure.canvas.draw()
    renderer = axes.figure.canvas.get_renderer()
    title = axes._left_title.get_window_extent(renderer)
    names = [text for text in axes.texts if text.get_text() in ("A", "B", "C")]
    assert len(names) == 3
    assert not any(name.get_window_extent(renderer).overlaps(title) for name in names)
