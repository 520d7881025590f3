"""The bend of 45 degrees under a load across its plane (Bathe & Bolourchi, Int. J. Numer. Methods Eng. 14 (1979) 961).

Radius 100, square section of side 1, E = 1e7, nu = 0. The truth is the geometrically exact rod, met by shooting.
"""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.elements import Beam, Material, Section
from linkframe.framework import Frame
from linkframe.framework.large.solution import LargeSolution
from reference.rod import Rod, cantilever

RADIUS, E = 100.0, 1e7


def bend(pieces: int, force: float, turn: np.ndarray | None = None) -> tuple[LargeSolution, np.ndarray]:
    """The bend as a polygon, perhaps turned as a whole; also the place of its end at rest."""
    angle = np.linspace(0.0, np.pi / 4, pieces + 1)
    points = RADIUS * np.stack([np.sin(angle), 1.0 - np.cos(angle), np.zeros_like(angle)], axis=-1)
    axes = np.eye(3) if turn is None else turn
    beam = Beam(
        Section(A=1.0, Iy=1 / 12, Iz=1 / 12, J=1 / 6, ky=1.0, kz=1.0),
        Material(E=E, nu=0.0),
        shear=True,
        up=axes @ np.array([0.0, 0.0, 1.0]),
    )
    frame = Frame()
    for k, point in enumerate(points @ axes.T):
        frame.node(str(k), point)
    for k in range(pieces):
        frame.add(f"piece {k}", beam, str(k), str(k + 1))
    frame.fix("0")
    push = axes @ np.array([0.0, 0.0, force])
    frame.load(str(pieces), fx=push[0], fy=push[1], fz=push[2])
    return frame.solve(large=True), points[-1]


@pytest.fixture(scope="module")
def exact() -> dict[float, np.ndarray]:
    rod = Rod((E, E / 2, E / 2), (E / 12, E / 12, E / 12), RADIUS * np.pi / 4, (0.0, 0.0, 1.0 / RADIUS))
    return {force: cantilever(rod, np.array([0.0, 0.0, force])) for force in (300.0, 450.0, 600.0)}


def test_the_rod_is_that_of_the_literature(exact: dict[float, np.ndarray]) -> None:
    """Simo & Vu-Quoc (1986), eight elements; their axes are y z x of these."""
    assert exact[300.0] == pytest.approx([58.84, 22.33, 40.08], abs=0.12)
    assert exact[600.0] == pytest.approx([47.23, 15.79, 53.37], abs=0.12)


@pytest.mark.parametrize("force", [300.0, 450.0, 600.0])
def test_against_the_exact_rod(exact: dict[float, np.ndarray], force: float) -> None:
    """Order of the error of the end, in brackets the force: 2, by the pieces of the polygon."""
    error = []
    for pieces in (8, 16, 32):
        solution, place = bend(pieces, force)
        assert solution.status == "stable"
        error.append(np.abs(place + solution.displacement(str(pieces))[:3] - exact[force]).max())
    assert error[0] < 0.06
    assert np.log2(np.array(error[:-1]) / error[1:]) == pytest.approx(2.0, abs=0.1)


def test_finite_rotation_of_the_whole_changes_nothing() -> None:
    q = np.array([0.3, -0.7, 0.5, 0.4])
    w, x, y, z = q / np.linalg.norm(q)
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    turn = np.eye(3) + 2.0 * (w * cross + cross @ cross)
    plain, turned = bend(8, 600.0)[0], bend(8, 600.0, turn)[0]
    for node in ("3", "8"):
        moved = plain.displacement(node)
        assert turned.displacement(node)[:3] == pytest.approx(turn @ moved[:3], rel=1e-10, abs=1e-10)
        assert turned.displacement(node)[3:] == pytest.approx(turn @ moved[3:], rel=1e-10, abs=1e-11)
    assert turned.end_forces("piece 2") == pytest.approx(plain.end_forces("piece 2"), rel=1e-9, abs=1e-7)


def test_equilibrium_of_the_whole() -> None:
    solution, place = bend(12, 450.0)
    end = place + solution.displacement("12")[:3]
    force = np.array([0.0, 0.0, 450.0])
    reaction = solution.reaction("0")
    assert reaction[:3] == pytest.approx(-force, abs=1e-9)
    assert reaction[3:] == pytest.approx(-np.cross(end, force), rel=1e-11, abs=1e-8)
    assert solution.residual < 1e-10  # of elongations, which are small against displacements
