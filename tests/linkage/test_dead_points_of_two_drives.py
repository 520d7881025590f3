"""A five-bar that two drives bring to where its rods lie in line: the end of the path, at which it is singular."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.models import Linkage, PoseState
from numpy.testing import assert_allclose

# Places of both drives at which the pins of the cranks are as far apart as the rods reach: 2.
IN_LINE = np.array([[np.pi, np.pi], [-np.pi, -np.pi], [0.0, 0.0], [0.5 * np.pi, 0.5 * np.pi], [1.0, 1.0], [-2.0, -2.0]])


def pins(angles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The pins of cranks of length 1 about (0, 0) and (2, 0), as complex numbers."""
    return np.exp(1j * angles[..., 0]), 2.0 + np.exp(1j * angles[..., 1])


def five_bar(angles: np.ndarray, side: float) -> Linkage:
    """Cranks and rods of length 1, the rods' pin on one side of the line between those of the cranks."""
    b, d = pins(angles)
    c = 0.5 * (b + d) + side * 1j * (d - b) / abs(d - b) * np.sqrt(1.0 - 0.25 * abs(d - b) ** 2)
    linkage = Linkage(A=(0, 0), E=(2, 0), **{name: (z.real, z.imag) for name, z in zip("BCD", (b, c, d), strict=True)})
    for link in ("AB", "BC", "CD", "DE"):
        linkage.link(link, *link)
    linkage.revolute("A", "ground", "AB", drive=True, reference=angles[0])
    linkage.revolute("E", "ground", "DE", drive=True, reference=angles[1])
    for pin, links in {"B": ("AB", "BC"), "C": ("BC", "CD"), "D": ("CD", "DE")}.items():
        linkage.revolute(pin, *links)
    return linkage


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_in_line_at_the_end_of_the_path(side: float) -> None:
    """Wherever the straight path of the drives has not been in line before; else they are not led there."""
    rng, led = np.random.default_rng(1), 0
    for start in rng.uniform(-np.pi, np.pi, (16, 2)):
        b, d = pins(start)
        if not 0.1 < abs(b - d) < 1.9:
            continue
        motion = five_bar(start, side).move(A=IN_LINE[:, 0], E=IN_LINE[:, 1])
        b, d = pins(start + np.linspace(0.0, 1.0, 2001)[:-1, None, None] * (IN_LINE - start))
        clear = (np.abs(b - d) < 2.0).all(axis=0) & (np.abs(b - d) > 1e-3).all(axis=0)
        assert (motion.is_assembled == clear).all()
        assert (motion.state[clear] == PoseState.SINGULAR_DIRECT).all(), motion.status
        middle = 0.5 * sum(pins(IN_LINE))
        found = motion.position("C")[:, 0] + 1j * motion.position("C")[:, 1]
        # A rounding of 1e-16 in the gap is 1e-8 across.
        assert_allclose(np.abs(found - middle)[clear], 0.0, atol=1e-7)
        led += int(clear.sum())
    assert led > 10
