"""Contact at large displacement under loads of any size: right, or said not to have been found."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.elements import Beam, Joint, Material, Rectangle
from linkframe.framework import Frame
from numpy.testing import assert_allclose

INF = float("inf")
BAR = Beam(Rectangle(y=12.7e-3, z=6.35e-3), Material(E=200e9, nu=0.3))
PULL = 200e9 * 12.7e-3 * 6.35e-3  # of the rod, a metre long, N/m
SIZES = [1e-300, 1e-100, 1e-20, 1e-12, 1e-8, 1e-4, 1.0, 1e4]


def pulled(stiffness: float, held: tuple[str, ...], force: object) -> Frame:
    """A clamped rod with a journal of 1e-3 at its end, pulled along the rod."""
    frame = Frame()
    for name, x in {"A": 0.0, "B": 1.0, "C": 1.0}.items():
        frame.node(name, (x, 0.0, 0.0))
    frame.add("AB", BAR, "A", "B")
    spring = (stiffness, stiffness, INF, INF, INF, 0.0)
    frame.add("pin", Joint(stiffness=spring, clearance=1e-3, clearance_directions=("ux", "uy")), "B", "C")
    frame.fix("A")
    if held:
        frame.fix("C", *held)
    frame.load("C", fx=force)  # type: ignore[arg-type]
    return frame


@pytest.mark.parametrize("held", [(), ("uz",), ("uz", "rx", "ry")])
@pytest.mark.parametrize("stiffness", [1e9, INF])
def test_a_load_of_any_size_closes_the_clearance(stiffness: float, held: tuple[str, ...]) -> None:
    """ε + F/k + F L/EA, however small against a rounding of ε what the springs give is."""
    force = np.array(SIZES)
    solution = pulled(stiffness, held, force).solve(large=True)
    assert solution.status.tolist() == ["stable"] * len(force)
    exact = 1e-3 + force / PULL + force / stiffness
    assert_allclose(solution.displacement("C")[:, 0], exact, rtol=1e-12)
    assert np.all(solution.error_bound("C")[:, 0] >= np.abs(solution.displacement("C")[:, 0] - exact))
    contact = solution.contact("pin")
    assert contact.closed.all()
    assert_allclose(contact.force, force, rtol=1e-9)
    assert_allclose(contact.normal, np.broadcast_to([1.0, 0.0, 0.0], (len(force), 3)), atol=1e-9)


@pytest.mark.parametrize("stiffness", [1e9, INF])
@pytest.mark.parametrize("force", [1e-300, 1e-20, 1e-8, 1.0])
def test_what_is_called_an_equilibrium_is_one(stiffness: float, force: float) -> None:
    """Also where the journal closes a loop, whose start is not in contact."""
    solution = pulled(stiffness, ("rz",), force).solve(large=True)
    exact = 1e-3 + force / PULL + force / stiffness
    if force >= 1e-8:
        assert solution.converged
    if solution.converged:
        assert_allclose(solution.displacement("C")[0], exact, rtol=1e-12)
        assert_allclose(solution.contact("pin").force, force, rtol=1e-3)
    else:
        assert solution.status == "not converged"
        assert solution.contact("pin").status == "unresolved"


def test_nothing_loaded_leaves_the_journal_where_it_is() -> None:
    solution = pulled(1e9, (), [0.0, 1.0]).solve(large=True)
    assert solution.contact("pin").status.tolist() == ["open", "closed"]
    assert solution.status.tolist() == ["stable"] * 2
    assert not solution.displacement("C")[0].any()
