"""Whole turns of joints, those that close loops as well: counted on the way to each pose, in whatever company."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.models import Linkage
from numpy.testing import assert_allclose
from reference.linkages import bennett, four_bar, rssr

EXACT = {"rtol": 0.0, "atol": 1e-12}


def angle(linkage: Linkage, joint: str, **drives) -> np.ndarray:
    return linkage.move(drives).coordinate(joint)


def assert_alone(linkage: Linkage, joint: str, drive: str, values: np.ndarray) -> None:
    """A joint's coordinates in a batch, in another order of it, and one by one."""
    together = angle(linkage, joint, **{drive: values})
    turned = np.random.default_rng(0).permutation(len(values))
    assert_allclose(angle(linkage, joint, **{drive: values[turned]}), together[turned], **EXACT)
    alone = [angle(linkage, joint, **{drive: value}) for value in values]
    assert_allclose(alone, together, **EXACT)


THETA = np.array([0.5, 25.0, -3.0, 0.6, 9.5, -31.0, 6.5, 3.0])


@pytest.mark.parametrize("lengths", [(2, 7, 9, 6), (0.1, 0.2, 0.1, 0.2), (3, 2.5, 2.6, 1)])
def test_angles_in_the_plane_add_up(lengths):
    """Crank, coupler and rocker turn one after the other by what the rocker turns in the ground, turns and all."""
    linkage = four_bar(*lengths, 0.5)
    assert [pair.name for pair in linkage.move().mechanism.tree.cuts] == ["D"]
    motion = linkage.move(A=THETA)
    crank, coupler, rocker, ground = (motion.coordinate(joint)[:, 0] for joint in "ABDE")
    around = crank + coupler + rocker - ground
    assert_allclose(around, around[0], **EXACT)
    assert_alone(linkage, "D", "A", THETA)


def test_bennett_against_its_closed_form():
    """tan(θ/2) tan(φ/2) is constant, and opposite hinges turn alike; H2 closes the loop."""
    alpha, beta, start = np.pi / 6, np.pi / 3, 1.2
    linkage = bennett(alpha, beta, start)
    assert [pair.name for pair in linkage.move().mechanism.tree.cuts] == ["H2"]
    motion = linkage.move(H0=start + THETA)
    theta = motion.coordinate("H0")[:, 0]
    share = np.sin((beta + alpha) / 2) / np.sin((beta - alpha) / 2)
    phi = 2.0 * np.arctan(share / np.tan(theta / 2.0)) - 2.0 * np.pi * np.floor(theta / (2.0 * np.pi))
    assert_allclose(motion.coordinate("H1")[:, 0], phi, **EXACT)
    assert_allclose(motion.coordinate("H2")[:, 0], -theta, **EXACT)
    assert_allclose(motion.coordinate("H3")[:, 0], -phi, **EXACT)
    assert_alone(linkage, "H2", "H0", start + THETA)


def test_a_universal_joint_that_closes_the_loop():
    """Both pins of the cross; and the rocker."""
    linkage = rssr(0.1, 0.4, 0.25, (0.15, 0.1, 0.3), 0.3, True)
    for joint in ("B", "Q"):
        assert_alone(linkage, joint, "O", THETA)


def test_several_drives():
    """Two arms, one driven on the other, carry the end of two rods round: the rods sway, so the joint C turns."""
    linkage = Linkage(A=(0, 0), B=(0.3, 0), C=(0.3, 0.2), D=(0.9, 0.7), E=(1, 0))
    for name, ends in {"a": "AB", "b": "BC", "c": "CD", "d": "DE"}.items():
        linkage.link(name, *ends)
    linkage.revolute("A", "ground", "a", drive=True)
    linkage.revolute("B", "a", "b", drive=True)
    for point, first, second in (("C", "b", "c"), ("D", "c", "d"), ("E", "ground", "d")):
        linkage.revolute(point, first, second)
    turns = np.random.default_rng(1).permutation(np.linspace(-4.0, 4.0, 9))
    drives = {"A": 2.0 * np.pi * turns + 0.3, "B": 4.0 * np.pi * turns}
    motion = linkage.move(drives)
    assert [pair.name for pair in motion.mechanism.tree.cuts] == ["C"]
    first, second, elbow, third, last = (motion.coordinate(joint)[:, 0] for joint in "ABCDE")
    assert_allclose(first + second + elbow + third - last, 0.0, **EXACT)
    assert_allclose(elbow, -6.0 * np.pi * turns, rtol=0.0, atol=2.0)
    for k in (0, 3, 8):
        alone = linkage.move({name: value[k] for name, value in drives.items()})
        assert_allclose(alone.coordinate("C"), elbow[k, None], **EXACT)


def test_what_is_described_later_does_not_change_a_motion():
    linkage = four_bar(0.1, 0.2, 0.1, 0.2, 0.7)
    motion = linkage.move(A=THETA)
    before = linkage.move(A=THETA).coordinate("D")
    linkage.point("F", (0.3, 0.3))
    linkage.link("flag", "D", "F")
    linkage.revolute("D", "rocker", "flag", name="hinge", drive=True)
    assert_allclose(motion.coordinate("D"), before, **EXACT)
