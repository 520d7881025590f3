"""Derivatives by the sizes of sections of beams of one's own, and of beams with forms of one's own."""

from __future__ import annotations

from typing import Any

import pytest
import skfem
from linkframe.elements import Beam, CrossSection, Material, Rectangle
from linkframe.framework import Frame, FrameError, LineElement
from numpy.testing import assert_allclose
from reference.own_elements import Softer

STEEL = Material(E=200e9, nu=0.3)
STEP = 1e-6


class Square(Beam):
    """A beam that is made from its width alone."""

    def __init__(self, width: float) -> None:
        super().__init__(Rectangle(y=width, z=width), STEEL)


def cantilever(beam: LineElement) -> Frame:
    frame = Frame()
    frame.node("A", (0.0, 0.0, 0.0))
    frame.node("B", (1.0, 0.0, 0.0))
    frame.add("AB", beam, "A", "B")
    frame.fix("A")
    frame.load("B", fy=10.0)
    return frame


@pytest.mark.parametrize("kind", [Beam, Softer])
def test_a_beam_of_ones_own_has_its_law_at_each_size(kind: type[Beam]) -> None:
    def deflection(y: float, z: float) -> float:
        section: CrossSection = Rectangle(y=y, z=z)
        return float(cantilever(kind(section, STEEL)).solve().displacement("B")[1])

    found = cantilever(kind(Rectangle(y=0.02, z=0.01), STEEL)).solve().sensitivity("B", "uy").sections["AB"]
    y, z = 0.02, 0.01
    assert_allclose(found["y"], -3.0 * deflection(y, z) / y, rtol=1e-9)
    assert_allclose(found["z"], -deflection(y, z) / z, rtol=1e-9)
    assert_allclose(
        found["y"], (deflection(y + STEP * y, z) - deflection(y - STEP * y, z)) / (2.0 * STEP * y), rtol=1e-6
    )


def test_what_cannot_be_made_with_another_section_is_named() -> None:
    sensitivity = cantilever(Square(0.02)).solve().sensitivity("B", "uy")
    with pytest.raises(FrameError, match=r"Square cannot be made with another section.*parameters of a dataclass"):
        sensitivity.sections  # noqa: B018
    assert_allclose(sensitivity.members["AB"].sum(), -10.0 / (3.0 * 200e9 * 0.02**4 / 12.0), rtol=1e-9)


@skfem.BilinearForm
def foundation(u: Any, v: Any, w: Any) -> Any:
    return w.k * (u[0] * v[0] + u[1] * v[1] + u[2] * v[2])


def test_a_beam_on_a_foundation_keeps_it_at_each_size() -> None:
    def footed(y: float) -> Frame:
        frame = cantilever(Beam(Rectangle(y=y, z=0.01), STEEL, segments=4))
        frame.add_form(foundation, on="AB", k=2e4)
        return frame

    y = 0.02
    found = footed(y).solve().sensitivity("B", "uy").sections["AB"]["y"]
    ahead, behind = (float(footed(y * (1.0 + step)).solve().displacement("B")[1]) for step in (STEP, -STEP))
    assert_allclose(found, (ahead - behind) / (2.0 * STEP * y), rtol=1e-6)


def test_modulus_of_a_beam_on_a_foundation_leaves_the_foundation_as_it_is() -> None:
    def footed(modulus: float) -> Frame:
        frame = cantilever(Beam(Rectangle(y=0.02, z=0.01), Material(E=modulus, nu=0.3), segments=2))
        frame.add_form(foundation, on="AB", k=2e4)
        return frame

    found = footed(200e9).solve().sensitivity("B", "uy").moduli["AB"]
    ahead, behind = (float(footed(200e9 * (1.0 + step)).solve().displacement("B")[1]) for step in (STEP, -STEP))
    assert_allclose(found, (ahead - behind) / (2.0 * STEP * 200e9), rtol=1e-6)
