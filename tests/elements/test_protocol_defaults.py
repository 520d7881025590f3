"""What a line element has by default, from its shape functions and section law: equal to the closed forms of a beam."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import pytest
import skfem
from linkframe.elements import Beam, Material, Rectangle, Spring
from linkframe.elements.forms import internal_forces, rigidity_of
from linkframe.framework import Frame, FrameError, LineElement, cubic_shapes, straight_shapes
from linkframe.framework.scikit_fem.integrals import detached, integrated_loads, integrated_stiffness
from linkframe.framework.shape_rules import gradients, section_springs
from numpy.testing import assert_allclose
from numpy.typing import NDArray

Array = NDArray[np.float64]
STEEL, BAR = Material(E=200e9, nu=0.3, density=7850.0), Rectangle(y=0.03, z=0.02)
LENGTHS = np.array([0.7, 1.3])
BEAMS = {
    "slender": Beam(BAR, STEEL),
    "shear": Beam(BAR, STEEL, shear=True),
    "taper": Beam(BAR, STEEL, end=Rectangle(y=0.01, z=0.015), shear=True),
    "batch": Beam(BAR, Material(E=np.array([1e11, 2e11]), nu=0.3, density=np.array([2e3, 8e3]))),
}


@dataclass(frozen=True, eq=False)
class Slender(LineElement):
    """A prismatic beam by its section law alone."""

    rigidity: Array = field(metadata={"trailing": 1})
    density: float = 0.0
    segments: int = 1

    @property
    def shape(self) -> tuple[int, ...]:
        return self.rigidity.shape[:-1]

    def section_flexibility(self, fraction: Array) -> Array:
        stiff = np.where(self.rigidity > 0.0, self.rigidity, np.inf)
        return np.broadcast_to(1.0 / stiff, (*np.broadcast_shapes(np.shape(fraction), self.shape), 6))

    def shape_functions(self, length: Array, x: Array) -> Array:
        return cubic_shapes(length, x)

    def mass_per_length(self, fraction: Array) -> Array:
        return np.full(np.broadcast_shapes(np.shape(fraction), self.shape), self.density * BAR.A)


E, G = 200e9, STEEL.G
LAW = np.array([E * BAR.A, 0.0, 0.0, float(G) * float(BAR.J), E * float(BAR.Iy), E * float(BAR.Iz)])


def close(found: Array, wanted: Array) -> None:
    """Equal to 1e-13 of what the diagonal says of the size of an entry."""
    size = np.sqrt(np.abs(np.einsum("...ii->...i", wanted)))
    off = np.abs(found - wanted) / np.where(size > 0.0, size, 1.0)[..., :, None]
    assert (off <= 1e-13 * np.where(size > 0.0, size, 1.0)[..., None, :]).all()


@pytest.mark.parametrize("name", BEAMS)
def test_closed_forms_are_the_forms(name: str) -> None:
    beam = BEAMS[name]
    axial = np.array([3.0, -2.0])
    close(integrated_stiffness(beam, LENGTHS), beam.stiffness_matrix(LENGTHS))
    close(LineElement.mass_matrix(beam, LENGTHS), beam.mass_matrix(LENGTHS))
    close(LineElement.geometric_matrix(beam, LENGTHS, axial), beam.geometric_matrix(LENGTHS, axial))
    x, forces = LENGTHS * np.array([[0.1], [0.5], [0.9]]), np.random.default_rng(2).normal(size=(3, 2, 6))
    loads = beam.consistent_loads(LENGTHS, x, forces)
    assert_allclose(integrated_loads(beam, LENGTHS, x, forces), loads, rtol=0.0, atol=1e-13 * np.abs(loads).max())
    k, rows = section_springs(beam, LENGTHS)
    close(np.swapaxes(rows, -1, -2) @ (k[..., None] * rows), beam.stiffness_matrix(LENGTHS))


@pytest.mark.parametrize("name", BEAMS)
def test_internal_forces_are_the_form(name: str) -> None:
    beam, moved = BEAMS[name], np.random.default_rng(1).normal(size=(2, 12))
    basis = detached(beam, LENGTHS, (2,))
    by_form = internal_forces.assemble(
        basis, rigidity=rigidity_of(beam, basis), displacement=basis.interpolate(moved.reshape(-1))
    )
    expected = beam.end_forces(LENGTHS, moved)
    assert_allclose(by_form.reshape(2, 12), expected, atol=1e-13 * np.abs(beam.stiffness_matrix(LENGTHS)).max())


@dataclass(frozen=True, eq=False)
class Heated(Slender):
    """A beam by its section law, warmer by one degree below than above."""

    def free_strain(self, fraction: Array) -> Array:
        return np.broadcast_to([0.0, 0.0, 0.0, 0.0, 0.0, 1e-5], (*np.broadcast_shapes(np.shape(fraction), ()), 6))


def test_end_forces_by_default_are_the_form() -> None:
    """Of a section law, those of the closed form of a beam; frames sum them over springs."""
    moved = np.random.default_rng(1).normal(size=(5, 2, 12))
    own, expected = Slender(LAW).end_forces(LENGTHS, moved), Beam(BAR, STEEL).end_forces(LENGTHS, moved)
    assert_allclose(own, expected, rtol=0.0, atol=1e-13 * np.abs(expected).max())


@pytest.mark.parametrize("q", [-40.0, np.array([-40.0, 7.0])], ids=["one", "batch"])
def test_loads_by_default_are_forms(monkeypatch: pytest.MonkeyPatch, q: Array) -> None:
    """Of a clamped beam: ``q L / 2`` and ``q L^2 / 12`` (Roark, table 8.1), a force P at a by
    ``P b^2 (3 a + b) / L^3`` and ``P a b^2 / L^2``, and ``E I k`` of a free curvature k."""
    seen: list[str] = []
    elemental = skfem.LinearForm.elemental

    def counted(self: skfem.LinearForm, *args: object, **given: object) -> object:
        seen.append(self.form.__name__.strip("_"))
        return elemental(self, *args, **given)

    frame, length, a, push = Frame(), 1.4, 0.5, 30.0
    for name, place in {"A": (0.0, 0.0, 0.0), "B": (length, 0.0, 0.0)}.items():
        frame.node(name, place)
    frame.add("AB", Heated(LAW), "A", "B")
    frame.fix("A")
    frame.line_load("AB", fy=q)
    frame.point_load("AB", at=a, fy=push)
    frame.solve().displacement("B")
    monkeypatch.setattr(skfem.LinearForm, "elemental", counted)
    b, bend = length - a, E * float(BAR.Iz) * 1e-5
    last = np.reshape(q, -1)[-1]
    wanted = np.zeros(12)
    wanted[1] = last * length / 2.0 + push * b**2 * (3.0 * a + b) / length**3
    wanted[5] = last * length**2 / 12.0 + push * a * b**2 / length**2 - bend
    wanted[7] = last * length / 2.0 + push * a**2 * (3.0 * b + a) / length**3
    wanted[11] = -last * length**2 / 12.0 - push * a**2 * b / length**2 + bend
    by = frame.matrices(*(() if np.ndim(q) == 0 else (1,)))
    assert_allclose(by.f, wanted, rtol=0.0, atol=1e-13 * np.abs(wanted).max())
    assert sorted(set(seen)) == ["load", "restrained"]
    seen.clear()
    # all entries at once by sums over the same points
    moved = skfem.solve(*skfem.condense(by.K, by.f, x=by.x, D=by.D)).reshape(-1, 6)[1]
    found = frame.solve().displacement("B")
    assert_allclose(found.reshape(-1, 6)[-1], moved, rtol=0.0, atol=1e-11 * np.abs(moved).max())
    assert not seen


def test_consistent_loads_broadcast() -> None:
    """Places and forces that are the same for all lengths, and one place of each length."""
    forces, x = np.random.default_rng(4).normal(size=(3, 6)), np.array([0.1, 0.2, 0.6])
    for element in (Slender(LAW), Beam(BAR, STEEL)):
        found = element.consistent_loads(LENGTHS, x, forces)
        assert found.shape == (2, 12)
        for length, one in zip(LENGTHS, found, strict=True):
            shapes = cubic_shapes(length, x)
            assert_allclose(one, np.einsum("kij,ki->j", shapes, forces), rtol=0.0, atol=1e-14)
            assert_allclose(element.consistent_loads(length, x, forces), one, rtol=0.0, atol=1e-15)


def test_strain_loads_are_in_equilibrium() -> None:
    """Whatever section forces would restrain the strain: no resultant, and no moment about the start."""

    @dataclass(frozen=True, eq=False)
    class Restrained(Heated):
        def restrained_forces(self, fraction: Array) -> Array:
            return np.broadcast_to([3.0, -2.0, 5.0, 7.0, -1.0, 4.0], (*np.shape(fraction), 6))

    start, end = np.split(Restrained(LAW).strain_loads(LENGTHS), 2, axis=-1)
    assert_allclose(start[:, 0], -3.0, rtol=1e-13)
    assert_allclose(start[:, :3] + end[:, :3], 0.0, atol=1e-13)
    arm = LENGTHS[:, None] * np.array([1.0, 0.0, 0.0])
    assert_allclose(start[:, 3:] + end[:, 3:] + np.cross(arm, end[:, :3]), 0.0, atol=1e-13)


def test_consistent_loads_that_differ_from_the_shape_functions_are_refused() -> None:
    class Lumped(Slender):
        def consistent_loads(self, length: Array, x: Array, forces: Array) -> Array:
            half = 0.5 * np.sum(forces, axis=0)
            return np.concatenate([half, half], axis=-1)

    frame = Frame()
    frame.node("A", (0.0, 0.0, 0.0))
    frame.node("B", (1.0, 0.0, 0.0))
    with pytest.raises(FrameError, match="Lumped of member 'AB': consistent_loads of fx do not do the work"):
        frame.add("AB", Lumped(LAW), "A", "B")


def test_gradients_in_extended_precision() -> None:
    length = np.array([0.7, 1.3], dtype=np.longdouble)
    x = np.longdouble(0.3) * length
    step = np.longdouble(1e-6)
    for shapes in (cubic_shapes, straight_shapes):
        element = Slender(LAW) if shapes is cubic_shapes else Straight()
        found = gradients(element, length, x / length)
        by_hand = (shapes(length, x + step) - shapes(length, x - step)) / (2.0 * step)
        assert_allclose(found.astype(float), by_hand.astype(float), atol=1e-10)
    k, rows = section_springs(Slender(LAW), length)
    turn = np.zeros(12, dtype=np.longdouble)
    turn[5] = turn[11] = 1.0
    along = np.zeros((2, 12), dtype=np.longdouble) + turn
    along[:, 7] = length
    assert rows.dtype == np.longdouble
    assert np.abs(np.einsum("nij,nj->ni", rows, along)).max() <= 8.0 * np.finfo(np.longdouble).eps * np.abs(rows).max()
    assert k.shape[:-1] in {(), (2,)}


class Straight(LineElement):
    """A line that resists nothing."""

    shape = ()

    def section_flexibility(self, fraction: Array) -> Array:
        return np.zeros((*np.shape(fraction), 6))

    def shape_functions(self, length: Array, x: Array) -> Array:
        return straight_shapes(length, x)


def portal(element: LineElement) -> Frame:
    """Two members at an angle with weight, a line load and a batch of loads."""
    frame = Frame()
    for name, place in {"A": (0, 0, 0), "B": (0, 0.3, 1.0), "C": (0.9, 0.4, 1.1)}.items():
        frame.node(name, place)
    frame.add("AB", element, "A", "B")
    frame.add("BC", element, "B", "C")
    frame.fix("A")
    frame.line_load("BC", fz=-20.0)
    frame.load("C", fx=[-10.0, 30.0], fz=-200.0)
    return frame


def test_a_section_law_is_a_beam() -> None:
    """All that a frame answers, of a beam without rotary inertia and of one by its section law."""
    own = portal(Slender(LAW, 7850.0, segments=2))
    beam = portal(Beam(BAR, STEEL, segments=2))
    for frame in (own, beam):
        frame.gravity((0.0, 0.0, -9.81))
    mine, theirs = own.solve(), beam.solve()
    assert_allclose(mine.displacement("C"), theirs.displacement("C"), rtol=1e-9, atol=1e-14)
    off = np.abs(mine.displacement("C") - theirs.displacement("C"))
    assert (off <= mine.error_bound("C") + theirs.error_bound("C")).all()
    assert (mine.error_bound("C") < 1e-9 * np.abs(mine.displacement("C")).max()).all()
    assert_allclose(mine.end_forces("AB"), theirs.end_forces("AB"), atol=1e-8)
    assert_allclose(mine.forces("BC", [0.2, 0.6]), theirs.forces("BC", [0.2, 0.6]), atol=1e-8)
    assert_allclose(mine.displacement_along("BC", [0.2, 0.6]), theirs.displacement_along("BC", [0.2, 0.6]), atol=1e-13)
    assert_allclose(own.modes(4).frequencies, beam.modes(4).frequencies, rtol=1e-3)
    # without Wagner's term, which these hardly feel
    assert_allclose(own.buckling(2).factors, beam.buckling(2).factors, rtol=1e-3)
    large = own.solve(large=True).displacement("C"), beam.solve(large=True).displacement("C")
    assert_allclose(*large, rtol=1e-4, atol=1e-8)


def test_what_has_neither_law_nor_springs_is_refused() -> None:
    class Nothing(LineElement):
        shape = ()

        def shape_functions(self, length: Array, x: Array) -> Array:
            return straight_shapes(length, x)

    frame = Frame()
    frame.node("A", (0.0, 0.0, 0.0))
    frame.node("B", (1.0, 0.0, 0.0))
    with pytest.raises(FrameError, match="Nothing of member 'AB' has neither springs nor section_flexibility"):
        frame.add("AB", Nothing(), "A", "B")


def test_shape_functions_that_strain_in_a_rigid_motion_are_refused() -> None:
    class Wrong(Slender):
        def shape_functions(self, length: Array, x: Array) -> Array:
            rows = cubic_shapes(length, x)
            rows[..., 5, :] *= -1.0
            return rows

    frame = Frame()
    frame.node("A", (0.0, 0.0, 0.0))
    frame.node("B", (1.0, 0.0, 0.0))
    stiff = np.where(LAW > 0.0, LAW, 1e7)
    with pytest.raises(FrameError, match=r"Wrong of member 'AB': shape_functions strain in a rigid motion \(rz\)"):
        frame.add("AB", Wrong(stiff), "A", "B")


def test_parts_of_what_varies_are_asked_for() -> None:
    class Taper(Slender):
        def section_flexibility(self, fraction: Array) -> Array:
            return np.asarray(1.0 + np.asarray(fraction))[..., None] / np.where(LAW > 0.0, LAW, np.inf)

    frame = Frame()
    frame.node("A", (0.0, 0.0, 0.0))
    frame.node("B", (1.0, 0.0, 0.0))
    with pytest.raises(FrameError, match="section_flexibility varies along the member, and part returns the whole"):
        frame.add("AB", Taper(LAW, segments=2), "A", "B")


def test_default_springs_sum_to_the_matrix() -> None:
    spring = Spring(stiffness=2e3, force=5.0)
    assert_allclose(LineElement.stiffness_matrix(spring, LENGTHS), spring.stiffness_matrix(LENGTHS), rtol=1e-14)
    moved = np.arange(24.0).reshape(2, 12)
    assert_allclose(LineElement.end_forces(spring, LENGTHS, moved), spring.end_forces(LENGTHS, moved), rtol=1e-12)


def test_elements_go_through_scikit_fem(monkeypatch: pytest.MonkeyPatch) -> None:
    """Statics, modes and buckling of an element by its section law, and modes of a taper, assemble its forms."""
    seen: list[str] = []
    elemental = skfem.BilinearForm.elemental

    def counted(self: skfem.BilinearForm, *args: object, **given: object) -> object:
        seen.append(self.form.__name__.strip("_"))
        return elemental(self, *args, **given)

    monkeypatch.setattr(skfem.BilinearForm, "elemental", counted)
    frame = portal(Slender(LAW, 7850.0))
    seen.clear()
    frame.solve("sparse").displacement("C")
    assert set(seen) == {"stiffness"}
    frame.modes(1)
    assert set(seen) == {"stiffness", "mass"}
    frame.buckling(1)
    assert set(seen) == {"stiffness", "mass", "geometric"}
    seen.clear()
    portal(BEAMS["taper"]).modes(1)
    assert set(seen) == {"mass"}
