"""Stiffness under load of a link on a compliant joint: the second derivative of an energy written down here."""

from __future__ import annotations

from itertools import combinations_with_replacement

import numpy as np
import pytest
from linkframe.models import Linkage
from numpy.testing import assert_allclose
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]
TIP, ANCHOR, FORCE = np.array([0.4, -0.3, 0.5]), np.array([0.9, 0.2, 0.1]), np.array([8.0, -5.0, 6.0])
PULL, FREE_LENGTH, STEP = 40.0, 0.3, 1e-3
SHIFT = (300.0, 200.0, 250.0)


def place(own: Array) -> Array:
    """The tip by displacement and turns of the joint: turns about z, the softest, go with the link."""
    bend = Rotation.from_rotvec(own[:, 3:] * (1.0, 1.0, 0.0))
    return np.asarray(own[:, :3] + (bend * Rotation.from_rotvec(own[:, 3:] * (0.0, 0.0, 1.0))).apply(TIP))


def second_derivatives(stiffness: Array, spring: bool) -> Array:
    """Of the energy by the joint's own six, about rest; the joint carries what then acts on it."""

    def loads(own: Array) -> Array:
        stretch = np.linalg.norm(place(own) - ANCHOR, axis=-1) - FREE_LENGTH
        return np.asarray(0.5 * PULL * spring * stretch**2 - place(own) @ FORCE)

    out = np.diag(stiffness)
    units = STEP * np.eye(6)
    for i, j in combinations_with_replacement(range(6), 2):
        around = np.array([units[i] + units[j], units[i] - units[j], units[j] - units[i], -units[i] - units[j]])
        found = loads(around) @ (1.0, -1.0, -1.0, 1.0) / (4.0 * STEP**2)
        out[i, j] += found
        out[j, i] += found if i != j else 0.0
    return out


@pytest.mark.parametrize("spring", [False, True])
def test_a_soft_drive_in_a_soft_bearing(spring: bool) -> None:
    """The drive, softer than its bearing, turns first; a spring pulls as at rest, though its end gives way."""
    stiffness = np.array([*SHIFT, 90.0, 120.0, 60.0])
    linkage = Linkage(A=(0, 0, 0), B=TIP, C=ANCHOR)
    linkage.link("arm", "A", "B")
    linkage.revolute("A", "ground", "arm", drive=True, stiffness=stiffness)
    linkage.load("B", **dict(zip(("fx", "fy", "fz"), FORCE, strict=True)))
    if spring:
        linkage.spring("B", ("ground", "C"), stiffness=PULL, length=FREE_LENGTH)
    units = 1e-6 * np.eye(6)
    moved = (place(units) - place(-units)).T / 2e-6
    wanted = moved @ np.linalg.inv(second_derivatives(stiffness, spring)) @ moved.T
    found = linkage.move().compliance_matrix("B")[:3, :3]
    assert_allclose(found, wanted, atol=2e-6 * np.abs(wanted).max())
