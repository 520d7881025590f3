"""The scikit-fem path: equal to the closed forms, in space; its displacement method converges to the force method."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from linkframe.elements import ArcLengthMapping, Beam, ElementLineFrame, Material, Rectangle
from linkframe.elements.forms import (
    geometric,
    inertia_of,
    initial_of,
    internal_forces,
    load,
    mass,
    rigidity_of,
    section_forces,
    stiffness,
    strains,
)
from numpy.testing import assert_allclose
from numpy.typing import NDArray
from skfem import Basis, ElementLineP1, Functional, MeshLine1, condense, solve

Array = NDArray[np.float64]
STEEL = Material(E=200e9, nu=0.3, density=7850.0)
THICK, THIN = Rectangle(y=0.12, z=0.07), Rectangle(y=0.05, z=0.09)
POINTS = np.array([[0.0, 1.0, 1.5, 0.3, 0.3], [0.0, 0.5, 2.0, -1.0, -1.0], [0.0, 0.2, 1.0, 0.7, 2.0]])
CELLS = np.array([[0, 1, 0, 3], [1, 2, 3, 4]])  # the last one is vertical
MESH = MeshLine1(POINTS, CELLS)


def basis_of(beam: Beam, intorder: int, mesh: MeshLine1 = MESH) -> Basis:
    return Basis(mesh, ElementLineFrame(beam), ArcLengthMapping(mesh), intorder=intorder)


def assembled(beam: Beam, name: str, *arguments: float) -> Array:
    """The same by closed forms: sums of T^T m T."""
    total = np.zeros((30, 30))
    for first, second in CELLS.T:
        chord = POINTS[:, second] - POINTS[:, first]
        T = np.kron(np.eye(4), beam.axes(chord))
        dofs = np.r_[6 * first : 6 * first + 6, 6 * second : 6 * second + 6]
        total[np.ix_(dofs, dofs)] += T.T @ getattr(beam, name)(np.linalg.norm(chord), *arguments) @ T
    return total


BEAMS = [
    Beam(THICK, STEEL),
    Beam(THICK, STEEL, shear=True),
    Beam(THICK, STEEL, shear=True, up=(1.0, 1.0, 0.3)),
    Beam(THICK, STEEL, shear=True, release=("start rz", "end ry")),
]
IDS = ["bernoulli", "timoshenko", "up", "released"]


@pytest.mark.parametrize("beam", BEAMS, ids=IDS)
def test_stiffness_is_the_closed_form(beam: Beam) -> None:
    basis = basis_of(beam, 2)
    K, closed = (
        stiffness.assemble(basis, rigidity=rigidity_of(beam, basis)).toarray(),
        assembled(beam, "stiffness_matrix"),
    )
    assert_allclose(K, closed, atol=1e-13 * np.abs(closed).max())


@pytest.mark.parametrize("beam", BEAMS, ids=IDS)
def test_mass_is_the_closed_form(beam: Beam) -> None:
    basis = basis_of(beam, 6)
    M, closed = mass.assemble(basis, inertia=inertia_of(beam, basis)).toarray(), assembled(beam, "mass_matrix")
    assert_allclose(M, closed, atol=1e-13 * np.abs(closed).max())


@pytest.mark.parametrize("beam", BEAMS, ids=IDS)
def test_geometric_stiffness_is_the_closed_form(beam: Beam) -> None:
    basis = basis_of(beam, 4)
    Kg = geometric.assemble(basis, initial=initial_of(beam, basis, np.asarray(-2.0))).toarray()
    closed = assembled(beam, "geometric_matrix", -2.0)
    assert_allclose(Kg, closed, atol=1e-13 * np.abs(closed).max())


def test_load_is_the_textbooks_and_turns_with_the_member() -> None:
    """q L / 2 and q L^2 / 12 (Roark, 7th ed., table 8.1, case 2d) along the local y axis of an inclined member."""
    beam, q = BEAMS[1], 3.0
    mesh = MeshLine1(POINTS[:, :2].copy(), CELLS[:, :1].copy())
    basis = basis_of(beam, 3, mesh)
    local = np.zeros((6, *basis.dx.shape))
    local[1] = q
    f = load.assemble(basis, load=local)
    chord = POINTS[:, 1] - POINTS[:, 0]
    L = np.linalg.norm(chord)
    T = np.kron(np.eye(4), beam.axes(chord))
    expected = np.zeros(12)
    expected[[1, 5, 7, 11]] = q * L / 2, q * L**2 / 12, q * L / 2, -q * L**2 / 12
    assert_allclose(f, T.T @ expected, atol=1e-13 * q)


@pytest.mark.parametrize("beam", BEAMS[:3], ids=IDS[:3])
def test_recovery(beam: Beam) -> None:
    """End forces by the linear form, section forces at the points, of a random displacement."""
    basis = basis_of(beam, 2)
    u = np.random.default_rng(9).normal(size=basis.N)
    rigidity, field = rigidity_of(beam, basis), basis.interpolate(u)
    f = internal_forces.assemble(basis, rigidity=rigidity, displacement=field)
    closed = assembled(beam, "stiffness_matrix") @ u
    assert_allclose(f, closed, atol=1e-12 * np.abs(closed).max())
    forces = section_forces(field, rigidity)
    for cell, (first, second) in enumerate(CELLS.T):
        chord = POINTS[:, second] - POINTS[:, first]
        own = np.kron(np.eye(4), beam.axes(chord)) @ u[np.r_[6 * first : 6 * first + 6, 6 * second : 6 * second + 6]]
        ends = beam.end_forces(np.linalg.norm(chord), own)
        x = basis.X[0] * np.linalg.norm(chord)
        moments = np.stack([-ends[4] - x * ends[2], x * ends[1] - ends[5]])
        size = np.abs(ends).max()
        assert_allclose(forces[[4, 5], cell], moments, atol=1e-11 * size)
        assert_allclose(forces[[0, 3], cell], np.outer(-ends[[0, 3]], np.ones_like(x)), atol=1e-11 * size)
        shear = -ends[[1, 2]] if beam.shear else np.zeros(2)
        assert_allclose(forces[[1, 2], cell], np.outer(shear, np.ones_like(x)), atol=1e-9 * size)


def test_a_cantilever_by_ordinary_scikit_fem() -> None:
    """P L^3 / 3 E I at the tip of an inclined cantilever of three elements, and its length by a functional."""
    start, direction, L, P = np.array([1.0, 2.0, 3.0]), np.array([2.0, 1.0, 2.0]) / 3, 1.5, 100.0
    points = start[:, None] + np.outer(direction, np.linspace(0.0, L, 4))
    mesh = MeshLine1(points, np.array([[0, 1, 2], [1, 2, 3]]))
    beam = Beam(THICK, STEEL)
    basis = basis_of(beam, 2, mesh)
    K = stiffness.assemble(basis, rigidity=rigidity_of(beam, basis))
    across = beam.axes(direction)[1]
    f = basis.zeros()
    f[18:21] = P * across
    clamped = basis.dofs.get_vertex_dofs(np.array([0])).all(["ux", "uy", "uz", "rx", "ry", "rz"])
    u = solve(*condense(K, f, D=clamped))
    assert_allclose(u[18:21], P * L**3 / (3 * 200e9 * THICK.Iz) * across, atol=1e-12 * P * L**3 / (200e9 * THICK.Iz))
    assert Functional(lambda w: 1.0 + 0.0 * w.x[0]).assemble(basis) == pytest.approx(L, rel=1e-14)


def test_mapping() -> None:
    """Points, lengths and back; a part of the elements, and points of their own in each."""
    mapping, X = ArcLengthMapping(MESH), np.array([[0.0, 0.25, 1.0]])
    ends = POINTS[:, CELLS]
    x = mapping.F(X)
    assert_allclose(x, ends[:, 0, :, None] * (1 - X[0]) + ends[:, 1, :, None] * X[0], atol=1e-15)
    assert_allclose(mapping.invF(x), np.broadcast_to(X[0], (1, 4, 3)), atol=1e-15)
    lengths = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=0)
    assert_allclose(mapping.detDF(X), np.repeat(lengths[:, None], 3, axis=1))
    assert_allclose(mapping.DF(X) * mapping.invDF(X), np.ones((1, 1, 4, 3)), rtol=1e-15)
    some, own = np.array([2, 0]), np.array([[[0.0, 0.5], [0.25, 1.0]]])
    part = mapping.F(own, tind=some)
    assert part.shape == (3, 2, 2)
    assert_allclose(part[:, 1, 0], mapping.F(np.array([[0.25]]))[:, 0, 0])
    assert_allclose(mapping.invF(part, tind=some), own, atol=1e-15)
    assert_allclose(mapping.detDF(own, tind=some)[:, 0], lengths[some])


def test_scikit_fems_own_mapping_would_be_wrong() -> None:
    """Why there is a mapping at all."""
    own = Basis(MESH, ElementLineP1(), ArcLengthMapping(MESH), intorder=2)
    total = np.linalg.norm(POINTS[:, CELLS[1]] - POINTS[:, CELLS[0]], axis=0).sum()
    assert own.dx.sum() == pytest.approx(total)


def test_part_of_the_elements_and_points_of_their_own() -> None:
    beam, mapping = BEAMS[1], ArcLengthMapping(MESH)
    element, X = ElementLineFrame(beam), np.array([[0.2, 0.9]])
    everywhere = element.gbasis(mapping, X, 5)[0]
    turned = element.gbasis(mapping, 1.0 - X, 5)[0]
    assert not np.allclose(turned, everywhere)
    some = np.array([3, 1])
    assert_allclose(element.gbasis(mapping, X, 5, tind=some)[0], np.asarray(everywhere)[:, some])
    own = np.array([[[0.2, 0.9]] * 4])
    assert_allclose(element.gbasis(mapping, own, 5)[0], everywhere, atol=1e-15)
    assert_allclose(element.gbasis(mapping, own, 5)[0].grad, everywhere.grad, atol=1e-15)


def test_field_is_rigid_where_the_frame_is() -> None:
    """A motion of the whole frame, global, has no strain anywhere; its field is that motion in the members' axes."""
    beam = BEAMS[2]
    basis = basis_of(beam, 3)
    shift, turn = np.array([0.3, -0.2, 0.5]), np.array([0.1, 0.4, -0.2])
    u = np.concatenate([np.concatenate([shift + np.cross(turn, p), turn]) for p in POINTS.T])
    field = basis.interpolate(u)
    assert_allclose(strains(field), 0.0, atol=1e-15)
    x = basis.mapping.F(basis.X)
    moved = shift[:, None, None] + np.cross(turn, x, axisb=0, axisc=0)
    for cell, (first, second) in enumerate(CELLS.T):
        R = beam.axes(POINTS[:, second] - POINTS[:, first])
        assert_allclose(np.asarray(field)[:3, cell], R @ moved[:, cell], atol=1e-14)


def test_displacement_method_converges_to_the_force_method() -> None:
    """With Hermite's cubics in its parts, a taper's stiffness comes from above by the fourth power of their length."""
    taper, L = Beam(THICK, STEEL, end=THIN), 1.4
    exact = taper.stiffness_matrix(L)
    errors = []
    for count in (2, 4, 8):
        K = np.zeros((6 * (count + 1), 6 * (count + 1)))
        for index in range(count):
            part = taper.part(index, count)
            mesh = MeshLine1(np.array([[0.0, L / count], [0.0, 0.0], [0.0, 0.0]]), np.array([[0], [1]]))
            cubics = replace(part, section=part.section.between(part.end, 0.5), end=None)  # type: ignore[arg-type]
            basis = basis_of(cubics, 12, mesh)
            dofs = slice(6 * index, 6 * index + 12)
            K[dofs, dofs] += stiffness.assemble(basis, rigidity=rigidity_of(part, basis)).toarray()
        outer, inner = np.r_[0:6, 6 * count : 6 * count + 6], np.arange(6, 6 * count)
        scale = 1 / np.sqrt(np.diag(K))
        K = scale[:, None] * K * scale
        schur = K[np.ix_(outer, outer)] - K[np.ix_(outer, inner)] @ np.linalg.solve(
            K[np.ix_(inner, inner)], K[np.ix_(inner, outer)]
        )
        found = schur / np.outer(scale[outer], scale[outer])
        errors.append((np.diag(found) / np.diag(exact) - 1)[[1, 2, 4, 5, 7, 8, 10, 11]])
    fine, finest = np.array(errors[1]), np.array(errors[2])
    assert np.all(finest > 0.0)
    assert np.all(finest < 1e-3)
    assert_allclose(np.log2(fine / finest), 4.0, atol=0.3)


@pytest.mark.parametrize("release", [(), ("start ry", "end rz")])
def test_batches_of_tapers(release: tuple[str, ...]) -> None:
    """Sections (4, 1), moduli (3,), lengths (2, 1, 1): mass and geometric stiffness one by one."""
    depth, density = np.linspace(0.1, 0.2, 4)[:, None], np.linspace(1e3, 2e3, 3)
    lengths, axial = np.array([[[1.0]], [[2.0]]]), np.linspace(1.0, 2.0, 3)
    batch = Beam(
        Rectangle(y=depth, z=0.1),
        Material(E=1e9, nu=0.2, density=density),
        end=Rectangle(y=0.05, z=2 * depth),
        shear=True,
        release=release,
    )
    M, Kg = batch.mass_matrix(lengths), batch.geometric_matrix(lengths, axial)
    assert M.shape == Kg.shape == (2, 4, 3, 12, 12)
    for i, j, k in np.ndindex(2, 4, 3):
        one = Beam(
            Rectangle(y=depth[j, 0], z=0.1),
            Material(E=1e9, nu=0.2, density=density[k]),
            end=Rectangle(y=0.05, z=2 * depth[j, 0]),
            shear=True,
            release=release,
        )
        length = float(lengths[i, 0, 0])
        assert_allclose(M[i, j, k], one.mass_matrix(length), atol=1e-13 * M[i, j, k].max())
        found = one.geometric_matrix(length, axial[k])
        assert_allclose(Kg[i, j, k], found, atol=1e-13 * np.abs(found).max())
