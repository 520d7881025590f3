"""Clearance of the four-bar in equilibrium: the extreme point of what the rigid linkage can reach."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.framework import FrameError, MechanismWarning
from linkframe.models import FourBar, FourBarMotion, Link, accuracy
from linkframe.models.four_bar.clearance import clearance_displacement
from numpy.testing import assert_allclose, assert_array_equal

ROCKING = {"crank": 0.3, "coupler": 0.9, "rocker": 0.8, "ground": 0.7, "point": (0.5, 0.2), "branch": "open"}
POSES = np.radians(np.arange(5.0, 360.0, 10.0))
GAPS = {"B": 1e-3, "D": 5e-4, "E": 2e-3}


def displaced(motion: FourBarMotion, force: tuple[float, float], stiffness: float) -> np.ndarray:
    """Displacement of P by clearance alone, (..., 3)."""
    frame = motion.frame(GAPS)
    frame.load("P", fx=force[0], fy=force[1])
    by_clearance: np.ndarray = (frame.solve().displacement("P") - frame.solve(clearance=False).displacement("P"))[
        ..., :3
    ]
    return by_clearance


@pytest.mark.parametrize("stiffness", [1e3, 2e11, 1e16, np.inf])
@pytest.mark.parametrize("force", [(0.0, 100.0), (-3e-4, 1e-4), (5e5, 2e5)])
def test_support_function_of_what_the_linkage_can_reach(force: tuple[float, float], stiffness: float) -> None:
    """F · u = Σ ε |R|, with the reactions R of the rigid linkage by Eq. (3)-(4), whatever the stiffness."""
    motion = FourBar(**ROCKING, stiffness=(stiffness,) * 5 + (0.0,)).move(POSES)
    reactions = motion.reactions(coupler=Link(force=force, at=ROCKING["point"]))
    work = sum(eps * np.linalg.norm(reactions.reaction(joint)[..., :2], axis=-1) for joint, eps in GAPS.items())
    moved = displaced(motion, force, stiffness)
    # compliance is subtracted: what it loses in digits is allowed for
    assert_allclose(moved[..., :2] @ force, work, rtol=1e-9)


def test_no_point_in_reach_lies_further_along_the_load() -> None:
    """Contact angles over a grid, the rigid loop closed exactly with them, at clearances so small that it is linear."""
    angles = np.linspace(0.0, 2.0 * np.pi, 40, endpoint=False)
    unit = 1e-6 * np.exp(1j * angles)
    for theta in POSES[::7]:
        motion = FourBar(**ROCKING).move(theta)
        offsets = {
            "B": GAPS["B"] * unit[:, None, None],
            "D": GAPS["D"] * unit[:, None],
            "E": GAPS["E"] * unit,
        }
        reached = 1e6 * clearance_displacement(motion, offsets)[..., 1].max()
        found = displaced(motion, (0.0, 100.0), 2e11)[1]
        assert reached <= found * (1.0 + 1e-5)
        # at the nearest of 40 angles the loss is at most 1 - cos(π/40)
        assert reached >= found * np.cos(np.pi / 40) * (1.0 - 1e-5)


def test_without_springs_equilibrium_is_the_reaction() -> None:
    four_bar = FourBar(**ROCKING)
    given = {"load": (20.0, 100.0, 3.0), "clearance": GAPS}
    found, known = (accuracy(four_bar, POSES, contact=how, **given) for how in ("equilibrium", "reaction"))
    assert_allclose(found.clearance, known.clearance, atol=1e-13)
    assert_allclose(found.clearance_exact, known.clearance_exact, atol=1e-13)
    assert_array_equal(found.compliance, known.compliance)


def test_springs_in_the_pins_turn_the_contact() -> None:
    """Torsion springs take a share of the load: the total is the frame's own solution, which obeys the law."""
    four_bar = FourBar(**ROCKING, stiffness=(1e8,) * 5 + (2e4,))
    load = (20.0, 1000.0, 3.0)
    found = accuracy(four_bar, POSES, load=load, clearance=GAPS, contact="equilibrium")
    frame = four_bar.move(POSES).frame(GAPS)
    frame.load("P", fx=load[0], fy=load[1], mz=load[2])
    solution = frame.solve()
    assert_allclose(found.total, solution.displacement("P")[..., :3], atol=1e-12)
    for joint, eps in GAPS.items():
        gap, force = solution.joint_displacement(joint)[..., :2], solution.joint_force(joint)[..., :2]
        size, pull = np.linalg.norm(gap, axis=-1), np.linalg.norm(force, axis=-1)
        assert_allclose(pull, 1e8 * np.maximum(size - eps, 0.0), atol=1e-6 * 1000.0)
        assert_allclose(force[..., 0] * gap[..., 1], force[..., 1] * gap[..., 0], atol=1e-9 * eps * 1000.0)
    by_reaction = accuracy(four_bar, POSES, load=load, clearance=GAPS, contact="reaction")
    assert np.abs(by_reaction.clearance - found.clearance).max() > 1e-4


def test_energy_is_less_than_with_the_contact_of_the_reactions() -> None:
    """Least potential energy: no other contact, so not that along the forces without clearances, has less."""
    four_bar = FourBar(**ROCKING, stiffness=(1e8,) * 5 + (2e4,))
    load = (20.0, 1000.0, 3.0)
    works = []
    for contact in ("equilibrium", "reaction", 0.3):
        found = accuracy(four_bar, POSES, load=load, clearance=GAPS, contact=contact)
        solution = found.frame().solve()
        # Clapeyron with offsets o: 2 Π = -F·u - Σ R·o
        twice = solution.displacement("P")[..., [0, 1, 5]] @ load
        for joint, place in found.offsets.items():
            force = solution.joint_force(joint)
            twice = twice + force[..., 0] * place.real + force[..., 1] * place.imag
        works.append(-0.5 * twice)
    assert np.all(works[0] < works[1])
    assert np.all(works[0] < works[2])


def test_jumps_of_the_contact_along_a_turn() -> None:
    """Between two poses the reaction in a pin reverses where the rocker's force passes through zero."""
    motion = FourBar(**ROCKING).move(POSES)
    frame = motion.frame(GAPS)
    frame.load("P", fy=100.0)
    contact = frame.solve().contact("E")
    jumps = contact.jumps(axis=0)
    along = motion.reactions(coupler=Link(force=(0.0, 100.0), at=ROCKING["point"])).reaction("E")
    turned = np.sum(along[1:] * along[:-1], axis=-1) < 0.0
    assert_array_equal(jumps, turned)
    assert turned.any()


def test_singular_poses_are_left_out() -> None:
    found = accuracy(FourBar(), np.radians([0.0, 60.0]), load=(0.0, 100.0, 0.0), clearance=1e-4, contact="equilibrium")
    with pytest.warns(MechanismWarning):
        assert np.isnan(found.clearance[0]).all()
    assert found.status[1] == "regular"
    assert np.isfinite(found.clearance[1]).all()
    assert found.status[0].startswith("singular")


def test_what_is_refused() -> None:
    with pytest.raises(FrameError, match="'equilibrium', but the load is zero"):
        accuracy(FourBar(), 1.0, clearance=1e-4, contact="equilibrium")
    with pytest.raises(FrameError, match="'reaction' or 'equilibrium'"):
        accuracy(FourBar(), 1.0, load=(1.0, 0.0, 0.0), contact="force")
