"""A kind of load that the framework has not: what it says of itself is all that statics, fields and edits need."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import pytest
from linkframe.elements import Beam, Material, Rectangle
from linkframe.framework import Frame, FrameError
from linkframe.framework.batch import Array, aligned, rotated
from linkframe.framework.loads import PointLoad
from numpy.testing import assert_allclose

ROD = Beam(Rectangle(y=0.02, z=0.01), Material(E=200e9, nu=0.3))


@dataclass(frozen=True)
class AxlePair:
    """Two equal forces `force` (..., 6), as of a carriage, at `first` and `last` from the member's start."""

    first: float
    last: float
    force: Array = field(metadata={"trailing": 1})
    local: bool = False

    @property
    def forces(self) -> tuple[Array, ...]:
        return (self.force,)

    @property
    def places(self) -> tuple[float, ...]:
        return self.first, self.last

    def in_axes(self, local_axes: Array) -> AxlePair:
        return replace(self, force=rotated(local_axes, aligned(self.force, local_axes.ndim - 2, 1)), local=True)

    def points(self, lower: Array, upper: Array, length: Array, rule: Any) -> list[tuple[Array, Array]]:
        each = (PointLoad(place, self.force, True) for place in self.places)
        return [point for load in each for point in load.points(lower, upper, length, rule)]


def rod() -> Frame:
    frame = Frame()
    frame.node("A", (0.0, 0.0, 0.0))
    frame.node("B", (0.6, 0.5, 0.2))
    frame.add("AB", ROD, "A", "B")
    frame.fix("A")
    frame.fix("B", "uy", "uz")
    return frame


def test_it_does_what_its_point_loads_do() -> None:
    """Displacements along the member and its internal forces on both sides of each place."""
    force = np.array([[10.0, -30.0, 5.0, 0.0, 0.0, 2.0], [0.0, 20.0, 0.0, 0.0, 1.0, 0.0]])
    own, plain = rod(), rod()
    own.member_loads["AB"] = [AxlePair(0.2, 0.5, force)]  # type: ignore[list-item]
    own.shape = (2,)
    for place in (0.2, 0.5):
        plain.point_load("AB", at=place, **dict(zip(("fx", "fy", "fz", "mx", "my", "mz"), force.T, strict=True)))
    along = np.array([0.0, 0.19, 0.21, 0.35, 0.49, 0.51, 0.7])
    found, wanted = own.solve(), plain.solve()
    for name in ("forces_at", "displacements_at"):
        values = [getattr(each, name)(along / own.length("AB")) for each in (found, wanted)]
        assert_allclose(*values, rtol=1e-10, atol=1e-12 * np.abs(values[1]).max())


def test_a_member_cannot_become_shorter_than_where_it_acts() -> None:
    frame = rod()
    frame.member_loads["AB"] = [AxlePair(0.2, 0.5, np.zeros(6))]  # type: ignore[list-item]
    with pytest.raises(FrameError, match=r"member 'AB' would be 0\.4 long, and a load on it reaches to 0\.5"):
        frame.change("B", (0.4, 0.0, 0.0))
    frame.change("B", (0.55, 0.0, 0.0))
