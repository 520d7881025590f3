"""What a member's springs and axes are made of, number by number: the numbers of the arrays."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from linkframe.elements import Beam, Material, Section, Spring
from linkframe.framework import Frame
from linkframe.framework.protocol import LineElement

N = 4
RNG = np.random.default_rng(2)
STEEL = Material(E=2e11 * np.exp(RNG.normal(size=(1, 5))), nu=0.3)
THIN, THICK = Section(A=1e-3, Iy=1e-7, Iz=2e-7, J=1e-7), Section(A=2e-3, Iy=3e-7, Iz=5e-7, J=3e-7)
SHEARED = Section(A=1e-3, Iy=1e-7, Iz=2e-7, J=1e-7, ky=0.8, kz=0.7)
ELEMENTS: dict[str, LineElement] = {
    "beam": Beam(THIN, STEEL),
    "tapered, with shear": Beam(SHEARED, STEEL, end=Section(A=2e-3, Iy=3e-7, Iz=5e-7, J=3e-7, ky=0.8, kz=0.7)),
    "released": Beam(THIN, STEEL, release=("start rz", "end ry", "end rx")),
    "turned": Beam(THICK, STEEL, up=(0.3, 1.0, 0.2)),
    "spring": Spring(1e3 * np.exp(RNG.normal(size=(1, 5))), 20.0),
}


@dataclass(frozen=True, eq=False)
class Doubled(Beam):
    """A beam of other springs and axes than those of its class."""

    def springs(self, length):
        stiffness, rows = super().springs(length)
        return 2.0 * stiffness, rows

    def stiffness_matrix(self, length):
        return 2.0 * super().stiffness_matrix(length)

    def end_forces(self, length, displacement):
        return 2.0 * super().end_forces(length, displacement)

    def axes(self, chord):
        return super().axes(chord)[..., [0, 2, 1], :] * np.array([1.0, -1.0, 1.0])[:, None]


@pytest.mark.parametrize("kind", [np.float64, np.longdouble])
@pytest.mark.parametrize("name", ELEMENTS)
def test_numbers_are_those_of_the_arrays(name, kind):
    element = ELEMENTS[name]
    chord = RNG.normal(size=(N, 5, 3)).astype(kind)
    chord[1, 2, :2] = 0.0  # upright
    length = np.sqrt(np.sum(chord * chord, axis=-1))
    stiffness, rows = element.springs(length)
    each, deformed = element.spring_numbers(length)
    assert len(each) == stiffness.shape[-1]
    for spring, number in enumerate(each):
        np.testing.assert_array_equal(*np.broadcast_arrays(number, stiffness[..., spring]))
        for dof in range(12):
            given = deformed.get((spring, dof), 0.0)
            np.testing.assert_array_equal(*np.broadcast_arrays(given, rows[..., spring, dof]))
    axes = element.axes(chord).reshape(N, 5, 9)
    for k, number in enumerate(element.axis_numbers(chord)):
        assert np.result_type(number, kind) == kind
        np.testing.assert_array_equal(*np.broadcast_arrays(number, axes[..., k]))


def test_a_large_batch_of_places_asks_a_subclass_for_its_own():
    """Its springs are twice as stiff, though the numbers of its class are not."""
    places = np.array([1.0, 0.3, 0.2]) + 0.01 * RNG.normal(size=(40_000, 3))

    def tip(beam):
        frame = Frame()
        frame.node("foot", (0.0, 0.0, 0.0))
        frame.node("tip", places)
        frame.fix("foot")
        frame.add("post", beam, "foot", "tip")
        frame.load("tip", fx=1.0)
        return frame.solve().displacement("tip")[..., :3]

    steel, turned = Material(E=2e11, nu=0.3), Section(A=1e-3, Iy=2e-7, Iz=1e-7, J=1e-7)
    np.testing.assert_allclose(tip(Doubled(THIN, steel)), 0.5 * tip(Beam(turned, steel)), rtol=1e-10)
