"""Textbook linkages: R. L. Norton, Design of Machinery; P. E. Nikravesh, Planar Multibody Dynamics."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.models import Linkage
from numpy.testing import assert_allclose
from reference.linkages import four_bar

# Norton, problems 4-6, 6-4 and 7-3, row a: link angles, angular velocities and accelerations (degrees, rad/s, rad/s²)
# of coupler and rocker, to the three digits of the book, and to nine digits from the same loop equations.
NORTON = {
    "open": (
        (88.8, 117.3, -6.0, -4.0, 26.1, 53.3),
        (88.8372413, 117.2860679, -5.9909657, -3.9917348, 26.0800166, 53.3305883),
    ),
    "crossed": (
        (-115.2, -143.6, -0.66, -2.66, 77.9, 50.7),
        (-115.2108122, -143.6596387, -0.662352, -2.6615829, 77.9198551, 50.6692834),
    ),
}


@pytest.mark.parametrize("circuit", NORTON)
def test_norton_row_a(circuit: str) -> None:
    linkage = four_bar(2.0, 7.0, 9.0, 6.0, np.radians(80.0), crossed=circuit == "crossed")
    motion = linkage.move(A=np.radians(30.0), rates={"A": 10.0})
    chords = motion.position("D") - [motion.position("B"), motion.position("E")]
    found = np.concatenate(
        [
            np.degrees(np.arctan2(chords[:, 1], chords[:, 0])),
            [motion.angular_velocity(link)[2] for link in ("coupler", "rocker")],
            [motion.angular_acceleration(link)[2] for link in ("coupler", "rocker")],
        ]
    )
    book, more = NORTON[circuit]
    assert_allclose(found, book, rtol=0.0, atol=0.1)
    assert_allclose(found, more, rtol=0.0, atol=6e-8)


def test_nikravesh_four_bar() -> None:
    """Examples 5.2 and 6.5: crank 0.1 m, coupler 0.3 m with the point P, rocker 0.22 m, ground 0.2 m."""
    theta = np.radians(45.0)
    second, third = 0.27212474293624817, 0.7586309236111003
    arm = second + np.radians(30.0)
    a = 0.1 * np.array([np.cos(theta), np.sin(theta)])
    b = a + 0.3 * np.array([np.cos(second), np.sin(second)])
    linkage = Linkage(O=(0, 0), A=a, B=b, P=a + 0.2 * np.array([np.cos(arm), np.sin(arm)]), Q=(0.2, 0))
    linkage.link("crank", "O", "A")
    linkage.link("coupler", "A", "B", "P")
    linkage.link("rocker", "B", "Q")
    linkage.revolute("O", "ground", "crank", drive=True, reference=theta)
    linkage.revolute("A", "crank", "coupler")
    linkage.revolute("B", "coupler", "rocker")
    linkage.revolute("Q", "ground", "rocker")
    # The book's angles close the loop to its last digits.
    assert_allclose(b, 0.22 * np.array([np.cos(third), np.sin(third)]) + (0.2, 0.0), rtol=1e-14)
    motion = linkage.move(O=theta, rates={"O": 1.5}, accelerations={"O": -1.2})
    assert_allclose(motion.position("P")[:2], [0.21066429596757313, 0.21358469552909545], rtol=1e-14)
    links = "coupler", "rocker"
    assert_allclose(
        [motion.angular_velocity(x)[2] for x in links], [0.028622177505291294, 0.7160755715521803], rtol=1e-12
    )
    assert_allclose(
        [motion.angular_acceleration(x)[2] for x in links], [0.7779495932191832, 0.36564374076175393], rtol=1e-12
    )
