"""Dead points at which several things happen at once, from wherever the linkage is drawn."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.models import Linkage
from numpy.testing import assert_allclose


def peaucellier(theta: float, radius: float, long: float, short: float) -> Linkage:
    """Inversor with long arms from O, a rhombus of short ones, and a crank about Q through O."""
    p = radius + radius * np.exp(1j * theta)
    along = (long**2 - short**2 + abs(p) ** 2) / (2.0 * abs(p))
    side = 1j * np.sqrt(long**2 - along**2)
    a, b = ((along + sign * side) * p / abs(p) for sign in (1.0, -1.0))
    places = {"O": 0j, "Q": complex(radius), "P": p, "A": a, "B": b, "R": a + b - p}
    linkage = Linkage({name: (z.real, z.imag) for name, z in places.items()})
    for name in ("QP", "OA", "OB", "AP", "BP", "AR", "BR"):
        linkage.link(name, *name)
    linkage.revolute("Q", "ground", "QP", drive=True, reference=theta)
    linkage.revolute("O", "ground", "OA", "OB")
    linkage.revolute("P", "QP", "AP", "BP")
    linkage.revolute("A", "OA", "AP", "AR")
    linkage.revolute("B", "OB", "BP", "BR")
    linkage.revolute("R", "AR", "BR")
    return linkage


@pytest.mark.parametrize("theta", [0.2, 0.0, -1.0])
def test_peaucellier(theta: float) -> None:
    """Where |OP| = long - short the rhombus lies flat, A on B: the crank turns back, and R may go another way."""
    linkage, end = peaucellier(theta, 1.0, 2.4, 1.0), 2.0 * np.arccos(0.7)
    points = linkage.dead_points("Q")
    assert_allclose([point.value for point in points], [-end, end], rtol=0.0, atol=1e-10)
    assert [(point.joint, point.change_point) for point in points] == 2 * [("R", False)]
    found = linkage.drive_range("Q")
    assert_allclose([found.lower, found.upper], [-end, end], rtol=0.0, atol=1e-10)
