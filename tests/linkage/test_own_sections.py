"""A cross-section of one's own in a linkage, and what a file says of it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from linkframe.elements import Beam, CrossSection, Material, Rectangle
from linkframe.framework import FrameError
from linkframe.models import Linkage, write_linkage
from numpy.testing import assert_allclose

STEEL = Material(E=2e11, nu=0.3, density=7800.0)


@dataclass(frozen=True, eq=False)
class Square(CrossSection):
    """A square; its torsion constant is no matter here."""

    side: float

    def _derive(self) -> dict[str, float]:
        area = self.side**2
        return {"A": area, "Iy": area**2 / 12.0, "Iz": area**2 / 12.0, "J": 1.0, "ky": 5.0 / 6.0, "kz": 5.0 / 6.0}

    def stress(self, forces: np.ndarray) -> np.ndarray:
        return np.zeros((*np.shape(forces)[:-1], 3))


def crank(section: CrossSection) -> Linkage:
    linkage = Linkage(A=(0, 0), B=(1, 0))
    linkage.link("crank", "A", "B", beam=Beam(section, STEEL))
    linkage.revolute("A", "ground", "crank", drive=True)
    linkage.load("B", fy=1.0)
    return linkage


def test_a_square_of_ones_own_bends_as_a_rectangle() -> None:
    own, usual = (crank(section).move(A=0.1).frame().solve() for section in (Square(0.01), Rectangle(y=0.01, z=0.01)))
    assert_allclose(own.displacement("B")[:3], usual.displacement("B")[:3], rtol=1e-14)


def test_a_file_refuses_a_shape_that_it_has_no_word_for(tmp_path: Path) -> None:
    with pytest.raises(FrameError, match=r"shapes rectangle, circle, .*the linkage has a Square: .* give .* a Section"):
        write_linkage(crank(Square(0.01)), tmp_path / "crank.toml")
    assert not list(tmp_path.iterdir())
