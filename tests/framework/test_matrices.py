"""The frame as scikit-fem has it: mesh, numbering and matrices, solved by scikit-fem's own hand."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import skfem
from linkframe.elements import ArcLengthMapping, Beam, Circle, ElementLineFrame, Joint, Material, PointMass, Rectangle
from linkframe.elements.forms import load, rigidity_of, stiffness
from linkframe.framework import Frame, FrameError
from numpy.testing import assert_allclose, assert_array_equal

STEEL = Material(E=200e9, nu=0.3, density=7850.0)
BAR = Beam(Rectangle(y=0.03, z=0.02), STEEL, segments=3)
TURN = np.array([[0.6, 0.0, 0.8], [0.0, 1.0, 0.0], [-0.8, 0.0, 0.6]])


def portal() -> Frame:
    """A portal on a turned body, with a joint, gravity, a mass, a settlement and a batch of loads."""
    frame = Frame()
    frame.body("table", (0.1, 0.2, 0.0), TURN)
    for name, place in {"A": (0, 0, 0), "B": (0, 1, 0), "C": (1, 1, 0.2), "D": (1, 1, 0.2), "E": (1, 0, 0)}.items():
        frame.node(name, place, body="table")
    frame.add("AB", BAR, "A", "B")
    frame.add("BC", BAR, "B", "C")
    frame.add("pin", Joint(stiffness=(1e7, 2e7, 3e7, 1e4, 2e4, 50.0), axes=TURN), "C", "D")
    frame.add("DE", Beam(Circle(diameter=0.03), STEEL, end=Circle(diameter=0.02), shear=True), "D", "E")
    frame.add("motor", PointMass(3.0, inertia=(0.1, 0.2, 0.3)), "B")
    frame.fix("A")
    frame.fix("E", "ux", "uy", "uz", "ry")
    frame.prescribe("E", uy=1e-3)
    frame.offset("pin", ux=2e-4, rz=1e-3)
    frame.load("C", fx=[[10.0], [20.0]], mz=[1.0, 2.0, 3.0])
    frame.line_load("BC", fy=-30.0)
    frame.gravity((0.0, -9.81, 0.0))
    return frame


def nodal(frame: Frame, solution: np.ndarray) -> np.ndarray:
    """Displacements of the described nodes, (nodes, 6), in a vector in scikit-fem's numbering."""
    return solution.reshape(-1, 6)[: len(frame.nodes)]


@pytest.mark.parametrize("entry", [(0, 0), (1, 2), (-1, 0)])
def test_solved_by_hand(entry: tuple[int, int]) -> None:
    frame = portal()
    expected = frame.solve().displacements()[entry]
    by = frame.matrices(entry)
    plain = skfem.solve(*skfem.condense(by.K, by.f, x=by.x, D=by.D))
    reduced = skfem.solve(*by.condensed())
    size = np.abs(expected).max()
    assert_allclose(nodal(frame, plain), expected, rtol=1e-9, atol=1e-10 * size)
    assert_allclose(nodal(frame, reduced), expected, rtol=1e-9, atol=1e-10 * size)


def test_reactions_and_energy_by_hand() -> None:
    frame = portal()
    by, solution = frame.matrices((1, 1)), frame.solve()
    u = skfem.solve(*by.condensed())
    left = (by.K @ u - by.f).reshape(-1, 6)
    for node in ("A", "E"):
        at = list(frame.nodes).index(node)
        expected = solution.reaction(node)[1, 1]
        assert_allclose(left[at], expected, rtol=1e-7, atol=1e-8 * np.abs(expected).max())


def test_modes_by_hand() -> None:
    frame = portal()
    by = frame.matrices((0, 0))
    expected = frame.modes(4).frequencies[0, 0]
    squared, shapes = skfem.solve(
        *skfem.condense(by.K, by.M, D=by.D), solver=skfem.solver_eigen_scipy_sym(k=4, sigma=0.0)
    )
    assert_allclose(np.sqrt(squared) / (2.0 * np.pi), expected, rtol=1e-8)
    assert_allclose(shapes.T @ by.M @ shapes, np.eye(4), atol=1e-8)
    squared, _ = skfem.solve(*by.condensed(by.M), solver=skfem.solver_eigen_scipy_sym(k=4, sigma=0.0))
    assert_allclose(np.sqrt(squared) / (2.0 * np.pi), expected, rtol=1e-8)


def test_what_is_ideal_is_in_the_coordinates() -> None:
    """A lever on an ideal hinge with a rigid arm and a tie; by hand in the coordinates q only."""
    frame = Frame()
    for name, place in {"A": (0, 0, 0), "B": (0, 0, 0), "C": (1, 0, 0), "D": (1, 0.5, 0), "E": (2, 0.5, 0)}.items():
        frame.node(name, place)
    frame.node("F", (2.0, 0.5, 0.0))
    frame.add("hinge", Joint(stiffness=(np.inf,) * 5 + (400.0,)), "A", "B")
    frame.add("BC", BAR, "B", "C")
    frame.rigid("C", "D")
    frame.add("DE", BAR, "D", "E")
    frame.tie("E", "F")
    frame.fix("A")
    frame.load("F", fy=5.0, mz=2.0)
    by, expected = frame.matrices(), frame.solve().displacements()
    u = nodal(frame, skfem.solve(*by.condensed()))
    assert_allclose(u, expected, rtol=1e-9, atol=1e-10 * np.abs(expected).max())
    assert set(by.mesh.subdomains) == {"beam", "joint", "rigid", "BC", "DE", "hinge"}


def test_mesh_and_numbering() -> None:
    frame = portal()
    mesh, dofs = frame.mesh, frame.dofs
    assert_array_equal(mesh.subdomains["AB"], [0, 1, 2])
    assert_array_equal(mesh.subdomains["beam"], np.arange(7))
    assert_array_equal(mesh.subdomains["pin"], [7])
    assert_array_equal(mesh.subdomains["table"], np.arange(7))
    assert_allclose(mesh.p[:, :5].T, np.stack([frame.position(name) for name in frame.nodes]), atol=1e-15)
    assert_array_equal(dofs.get_facet_dofs(mesh.boundaries["E"]).all(["ux", "ry"]), [24, 28])
    assert_array_equal(frame.matrices((0, 0)).D, [0, 1, 2, 3, 4, 5, 24, 25, 26, 28])


def test_stiffness_of_a_subdomain_is_that_of_a_form() -> None:
    """Members by a scikit-fem form over a basis on the frame's own mesh."""
    frame = Frame()
    for name, place in {"A": (0, 0, 0), "B": (1, 0.3, 0.2), "C": (1.5, 1, 0)}.items():
        frame.node(name, place)
    frame.add("AB", BAR, "A", "B")
    frame.add("BC", BAR, "B", "C")
    mesh = frame.mesh
    basis = skfem.Basis(mesh, ElementLineFrame(BAR), ArcLengthMapping(mesh), intorder=2, elements="beam")
    by_form = stiffness.assemble(basis, rigidity=rigidity_of(BAR, basis))
    K = frame.matrices().K
    assert_allclose(by_form.toarray(), K.toarray(), atol=1e-12 * np.abs(K).max())


@pytest.mark.parametrize(
    "beam",
    [
        Beam(Rectangle(y=0.03, z=0.02), STEEL),
        Beam(Rectangle(y=0.03, z=0.02), STEEL, shear=True),
        Beam(Circle(diameter=0.03), STEEL, end=Circle(diameter=0.02)),
        Beam(Circle(diameter=0.03), STEEL, release="end rz"),
    ],
    ids=["slender", "with shear", "taper", "released"],
)
def test_loads_between_nodes_are_those_of_the_form(beam: Beam) -> None:
    """A load that grows along the member, in its own axes, and its weight: as scikit-fem's linear form has them."""
    frame = Frame()
    for name, place in {"A": (0, 0, 0), "B": (1, 0.3, 0.2)}.items():
        frame.node(name, place)
    frame.add("AB", beam, "A", "B")
    frame.line_load("AB", fx=(1.0, 4.0), fy=(2.0, -3.0), fz=(0.5, 2.5), local=True)
    frame.gravity((0.4, -9.81, 2.0))
    basis = skfem.Basis(
        frame.mesh,
        ElementLineFrame(beam),
        ArcLengthMapping(frame.mesh),
        quadrature=(np.ravel(beam.integration_points[0])[None], np.ravel(beam.integration_points[1])),
    )
    fraction = np.broadcast_to(basis.X[0], basis.dx.shape)
    pushed = np.zeros((6, *basis.dx.shape))
    for k, (start, end) in enumerate(((1.0, 4.0), (2.0, -3.0), (0.5, 2.5))):
        pushed[k] = start + (end - start) * fraction
    weight = beam.axes(np.array([1.0, 0.3, 0.2])) @ np.array([0.4, -9.81, 2.0])
    pushed[:3] += weight[:, None, None] * np.ravel(beam.mass_per_length(fraction[0]))
    by_form = load.assemble(basis, load=pushed)
    assert_allclose(frame.matrices().f, by_form, rtol=0.0, atol=1e-13 * np.abs(by_form).max())


def test_entries_are_checked() -> None:
    frame = portal()
    with pytest.raises(FrameError, match="matrices was given entry"):
        frame.matrices((2, 0))
    frame.exclude([[True], [False]])
    with pytest.raises(FrameError, match="was left out"):
        frame.matrices((0, 1))


def test_a_screw_and_a_node_that_nothing_touches() -> None:
    frame = Frame()
    frame.node("alone", (9.0, 9.0, 9.0))
    for name, place in {"A": (0, 0, 0), "B": (1, 0, 0.2), "C": (1, 0, 0.2), "D": (1, 1, 0)}.items():
        frame.node(name, place)
    frame.add("AB", BAR, "A", "B")
    frame.add("screw", Joint(stiffness=(1e6, 2e6, 3e6, 1e4, 2e4, 300.0), pitch=0.05), "B", "C")
    frame.add("CD", BAR, "C", "D")
    frame.fix("A")
    frame.fix("alone")
    frame.offset("screw", rz=0.1)
    frame.load("D", fx=20.0)
    by, expected = frame.matrices(), frame.solve().displacements()
    u = nodal(frame, skfem.solve(*by.condensed()))
    assert_allclose(u, expected, rtol=1e-9, atol=1e-10 * np.abs(expected).max())
    assert set(by.mesh.boundaries) == {"A"}
    assert_array_equal(by.mesh.facets[0][by.mesh.boundaries["A"]], [1])


def test_buckling_by_hand() -> None:
    """The greatest of ``-Kg x = mu K x``, of a portal on a turned body with a joint, at an entry of a long batch."""
    frame = portal()
    frame.load("C", fx=np.zeros((2, 1)), fy=-np.array([[3e4], [5e4]]))
    expected = frame.buckling(1).factors
    for entry in ((0, 0), (1, 2)):
        by = frame.matrices(entry)
        stiffness, _, _, (_, back) = by.condensed()
        taken = by.condensed(by.Kg)[1]
        solver = skfem.solver_eigen_scipy_sym(k=1, which="LA", sigma=None)
        mu, _ = skfem.solve(-taken, stiffness, np.zeros(len(by.f)), (np.arange(len(by.f)), back), solver=solver)
        assert_allclose(1.0 / mu, expected[entry], rtol=1e-7)
    assert abs(by.Kg - by.Kg.T).max() <= 1e-12 * abs(by.Kg).max()


def test_geometric_stiffness_of_a_mechanism_is_refused() -> None:
    frame = Frame()
    frame.node("A", (0.0, 0.0, 0.0))
    frame.node("B", (1.0, 0.0, 0.0))
    frame.add("AB", BAR, "A", "B")
    frame.load("B", fy=1.0)
    with pytest.raises(FrameError, match="the frame is kinematically unstable"):
        frame.matrices().Kg  # noqa: B018


def test_basis_is_public() -> None:
    """Beams by name, all of one kind, and of several kinds, which are refused; a user's load by its form."""
    frame = portal()
    with pytest.raises(FrameError, match="basis: members on 'beam' are of 2 kinds, first in AB, DE"):
        frame.basis()
    with pytest.raises(FrameError, match="basis: on 'XY' is unknown"):
        frame.basis("XY")
    basis = frame.basis(["AB", "BC"], intorder=2)
    alone = Frame()
    for name in ("A", "B", "C"):
        alone.node(name, frame.position(name))
    alone.add("AB", BAR, "A", "B")
    alone.add("BC", BAR, "B", "C")
    by_form = stiffness.assemble(basis, rigidity=rigidity_of(BAR, basis))
    K = alone.matrices().K
    at = [*range(18), *range(30, 54)]
    assert_allclose(by_form.toarray()[np.ix_(at, at)], K.toarray(), atol=1e-11 * np.abs(K).max())
    warm = Frame()
    warm.node("A", (0.0, 0.0, 0.0))
    warm.node("B", (1.0, 0.0, 0.0))
    batch = Beam(Rectangle(y=np.array([0.03, 0.04]), z=0.02), STEEL)
    warm.add("AB", batch, "A", "B")
    first = warm.basis("AB", intorder=2)
    found = stiffness.assemble(first, rigidity=rigidity_of(first.elem.member, first))
    assert_allclose(found.toarray(), warm.matrices(0).K.toarray(), atol=1e-9)


def test_mesh_is_written_by_scikit_fem(tmp_path: Path) -> None:
    """Points to the last bit, and members, bodies and supports as what scikit-fem keeps in files."""
    meshio = pytest.importorskip("meshio")
    frame = portal()
    moved = nodal(frame, frame.matrices((0, 0)).f)
    mesh = frame.mesh
    push = np.zeros((mesh.p.shape[1], 3))
    push[: len(moved)] = moved[:, :3]
    mesh.save(tmp_path / "frame.vtu", point_data={"load": push})
    found = meshio.read(tmp_path / "frame.vtu")
    assert_array_equal(found.points.T, mesh.p)
    assert_array_equal(found.point_data["load"], push)
    assert {"skfem:s:AB", "skfem:s:table", "skfem:b:A"} <= set(found.cell_data)
