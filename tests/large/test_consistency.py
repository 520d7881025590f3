"""What must hold of any frame: forces are derivatives of the energy, their tangent; batches, planes, small loads."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from linkframe.elements import Beam, Joint, Material, PointMass, Rectangle, Spring
from linkframe.framework import Frame, FrameError
from linkframe.framework.batched.plan import Plan
from linkframe.framework.large.equations import EquilibriumEquations
from linkframe.framework.large.model import Model
from linkframe.framework.large.planar_equations import PlanarEquations
from linkframe.framework.large.planar_model import PlanarModel
from linkframe.framework.large.solution import LargeSolution
from linkframe.framework.large.state import DisplacedState, PlanarState

STEEL = Material(E=200e3, nu=0.3, density=1.0)
BAR = Rectangle(y=0.2, z=0.3)


def turn(*axis: float) -> np.ndarray:
    v = np.array(axis)
    angle = np.linalg.norm(v)
    x, y, z = v / angle
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.asarray(np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross)


def frame(scale: float = 1.0) -> Frame:
    """Joints and a screw seen from both sides, a rigid link, a taper, prescribed motion, all kinds of dead loads."""
    built = Frame()
    places = {"A": (0, 0, 0), "B": (1, 0.2, 0.1), "C": (1, 0.2, 0.1), "E": (2.2, 0.5, 0.1), "H": (3, 0, 0)}
    for name, place in places.items():
        built.node(name, place)
    for name in "DG":
        built.node(name, [(2.0, 0.5, -0.3), (2.0, 0.5, -0.2)])
    built.add("AB", Beam(BAR, STEEL, end=Rectangle(y=0.1, z=0.2), segments=2), "A", "B")
    built.add("CD", Beam(BAR, STEEL, shear=True, segments=2), "C", "D")
    built.add("GH", Beam(BAR, STEEL, release="end rx"), "G", "H")
    built.add("EH", Beam(BAR, STEEL, segments=2), "E", "H")
    built.add("first", Joint((2e4, 2e4, np.inf, 1e3, 2e3, 0.0), axes=turn(0.3, 0.9, -0.4), pitch=0.7), "B", "C")
    built.add("second", Joint((2e4, np.inf, 2e4, 1e3, 10.0, 3.0)), "G", "D")
    built.rigid("D", "E")
    built.fix("A", "ux", "uy", "uz", "rx")
    built.fix("H", "rz")
    built.prescribe("H", ux=0.1 * scale, uz=scale * np.array([0.05, 0.02]), ry=0.02 * scale)
    built.offset("first", uz=0.1 * scale, rx=0.02 * scale)
    built.load("D", fy=10.0 * scale, fz=30.0 * scale)
    built.line_load("CD", fy=10.0 * scale)
    built.point_load("EH", at=0.3, fz=4.0 * scale)
    built.gravity((0.0, 0.0, -9.0 * scale))
    built.add("mass", PointMass(2.0, offset=(0.1, 0.2, 0.3)), "E")
    return built


@cache
def solved(steps: int | None = None) -> LargeSolution:
    """At a third of the loads."""
    return frame(0.3).solve(large=True) if steps is None else frame(0.3).solve(large=True, steps=steps)


@pytest.fixture(scope="module")
def model() -> Model:
    return Model(Plan(frame(), cut=True))


def bent(model: Model, moved: int = 1) -> tuple[EquilibriumEquations, DisplacedState]:
    """Both entries of the batch in some bent shape, so many times over: all first entries, then all second ones."""
    equations = EquilibriumEquations(model, (np.repeat(np.arange(2), moved),), 2 * moved)
    step = 0.3 * np.random.default_rng(1).standard_normal((model.size, 2))
    return equations, equations.advanced(DisplacedState.start(model, 2 * moved), np.repeat(step, moved, axis=1))


def each_by_itself(model: Model) -> np.ndarray:
    """Steps by which a batch of both entries, as often as there are coordinates, moves one coordinate each."""
    return np.tile(1e-6 * np.eye(model.size), 2)


def test_forces_are_the_derivative_of_the_energy(model: Model) -> None:
    equations, state = bent(model)
    forces = equations.linearised(state).forces
    equations, state = bent(model, model.size)
    ahead, behind = (equations.energy(equations.advanced(state, s * each_by_itself(model))) for s in (1.0, -1.0))
    slope = ((ahead - behind) / 2e-6).reshape(2, -1).T
    assert slope == pytest.approx(forces, abs=1e-8 * np.abs(forces).max())


def test_tangent_is_the_derivative_of_the_forces(model: Model) -> None:
    equations, state = bent(model)
    _, rows, columns = model.pattern
    tangent = np.zeros((model.size, model.size, 2))
    tangent[rows, columns] = equations.linearised(state).values
    equations, state = bent(model, model.size)
    ahead, behind = (
        equations.linearised(equations.advanced(state, s * each_by_itself(model))).forces for s in (1.0, -1.0)
    )
    slope = np.moveaxis(((ahead - behind) / 2e-6).reshape(-1, 2, model.size), 1, 2)
    assert slope == pytest.approx(tangent, abs=2e-9 * np.abs(tangent).max())


def test_tangent_is_symmetric_in_equilibrium() -> None:
    solution = solved(2)
    model, at = solution.model, solution.equations.linearised(solution.displaced)
    _, rows, columns = model.pattern
    tangent = np.zeros((model.size, model.size, 2))
    tangent[rows, columns] = at.values
    free = slice(model.free)
    assert np.abs(at.forces[free]).max() < 1e-9
    assert tangent[free, free] == pytest.approx(np.swapaxes(tangent[free, free], 0, 1), abs=1e-9)


def test_small_loads_give_the_linear_solution() -> None:
    scale = 1e-6
    described = frame(scale)
    linear, large = described.solve(), described.solve(large=True)
    results = [("displacement", name) for name in described.nodes] + [("reaction", name) for name in "AH"]
    results += [("end_forces", name) for name in described.members]
    results += [(kind, name) for kind in ("joint_force", "joint_displacement") for name in described.joints]
    for kind, name in results:
        expected = getattr(linear, kind)(name)
        assert getattr(large, kind)(name) == pytest.approx(expected, abs=2e-5 * np.abs(expected).max()), (kind, name)
    for member in described.members:
        at = np.linspace(0.0, 1.0, 4) * described.length(member)[..., None]
        for kind in ("forces", "stress", "displacement_along"):
            expected = getattr(linear, kind)(member, at)
            found = getattr(large, kind)(member, at)
            assert found == pytest.approx(expected, abs=3e-4 * np.abs(expected).max()), (kind, member)


def test_energy_balance_along_load_steps() -> None:
    """The work of loads, prescribed motion and offsets equals the strain energy, to the square of the step."""
    error = []
    for steps in (4, 8):
        solution = solved(steps)
        assert solution.load_factor[-1] == 1.0
        error.append(np.abs(solution.work[-1] - solution.strain_energy[-1]).max())
    assert error[1] < 1e-2 * solution.strain_energy[-1].max()
    assert error[0] / error[1] == pytest.approx(4.0, rel=0.2)


class WarmBeam(Beam):
    """A beam that grows by one part in a thousand."""

    def free_strain(self, fraction: np.ndarray) -> np.ndarray:
        return np.broadcast_to([1e-3, 0.0, 0.0, 0.0, 0.0, 0.0], (*np.shape(fraction), 6))


@pytest.mark.parametrize("steps", [1, 4])
def test_work_of_heat_between_two_walls_and_of_a_moment_about_any_axis(steps: int) -> None:
    """``EA ε² L / 2``, and ``M² L / (2 EI)`` of a beam that is rolled by two radians; as the square of the load."""
    shares = np.arange(1, steps + 1) ** 2 / steps**2
    warm, rolled = Frame(), Frame()
    across = np.array([0.48, -0.64, 0.6])
    for each, element in ((warm, WarmBeam(BAR, STEEL)), (rolled, Beam(Rectangle(y=0.2, z=0.2), STEEL, segments=12))):
        each.node("A", (0.0, 0.0, 0.0))
        each.node("B", 2.0 * np.array([0.8, 0.6, 0.0]))
        each.add("AB", element, "A", "B")
        each.fix("A")
    warm.fix("B")
    bending = STEEL.E * 0.2**4 / 12.0
    mx, my, mz = bending * across
    rolled.load("B", mx=mx, my=my, mz=mz)
    for each, energy in ((warm, 0.5 * STEEL.E * BAR.A * 1e-6 * 2.0), (rolled, bending)):
        solution = each.solve(large=True, steps=steps)
        np.testing.assert_allclose(solution.work, energy * shares, rtol=1e-9)
        np.testing.assert_allclose(solution.strain_energy, energy * shares, rtol=1e-9)


def test_a_batch_equals_its_members() -> None:
    whole = solved()
    for entry, height in enumerate((-0.3, -0.2)):
        described, alone = frame(0.3), Frame()
        for name, node in described.nodes.items():
            place = (2.0, 0.5, height) if name in "DG" else node.coordinates
            alone.node(name, place)
        for field in ("members", "joints", "masses", "ties", "supports", "offsets", "loads", "member_loads", "weight"):
            setattr(alone, field, getattr(described, field))
        alone.prescribe("H", uz=0.3 * (0.05, 0.02)[entry])
        found = alone.solve(large=True)
        assert found.shape == ()
        for node in "BDEG":
            assert found.displacement(node) == pytest.approx(whole.displacement(node)[entry], rel=1e-9, abs=1e-10)
        assert found.iterations == whole.iterations[entry]


@pytest.mark.parametrize("normal", [2, 1, 0])
def test_a_plane_gives_what_space_gives(normal: int) -> None:
    """A frame in one of the coordinate planes, in three coordinates a node and in six."""
    order = np.roll(np.arange(3), normal - 2)
    x, y, z = np.eye(3)[:, order].T
    flat = Frame()

    def place(along: float, up: float) -> np.ndarray:
        return np.asarray(along * x + up * y)

    for name, point in {
        "A": (0, 0),
        "B": (1, 0.2),
        "C": (1, 0.2),
        "D": (2, 0.5),
        "E": (2.2, 0.6),
        "G": (2, 0.5),
    }.items():
        flat.node(name, place(*point))
    flat.node("H", place(3, 0))
    bar = Beam(BAR, STEEL, segments=2)
    for ends in ("AB", "CD", "GH", "EH"):
        flat.add(ends, bar, *ends)
    c, s = np.cos(0.3), np.sin(0.3)
    axes = np.stack([c * x + s * y, z, s * x - c * y], axis=-1)
    flat.add("first", Joint((2e4, 2e4, 3e4, 1e3, 20.0, 1e3), axes=axes), "B", "C")
    flat.add("second", Joint((2e4,) * 3 + (5.0,) * 3), "G", "D")
    flat.rigid("D", "E")
    names = ["xyz"[int(np.argmax(v))] for v in (x, y, z)]
    flat.fix("A", f"u{names[0]}", f"u{names[1]}")
    flat.prescribe("H", **{f"u{names[0]}": np.array([0.1, -0.1]), f"u{names[1]}": 0.0})
    flat.load("D", **{f"f{names[1]}": 10.0})
    flat.load("B", **{f"m{names[2]}": 3.0})
    model = Model(Plan(flat, cut=True))
    assert len(model.components) == 3
    assert PlanarModel.suits(model)
    space, plane = (
        EquilibriumEquations(model, (np.arange(2),), 2),
        PlanarEquations(PlanarModel(model), (np.arange(2),), 2),
    )
    step = 0.2 * np.random.default_rng(2).standard_normal((model.size, 2))
    there = space.advanced(DisplacedState.start(model, 2), step)
    here = plane.advanced(PlanarState.start(model, 2), step)
    in_space = plane.planar_model.space(here)
    for one, other in zip(
        (there.displacements, np.abs(there.rotations), there.own),
        (in_space.displacements, np.abs(in_space.rotations), in_space.own),
        strict=True,
    ):
        assert one == pytest.approx(other, abs=1e-14)
    first, second = space.linearised(there), plane.linearised(here)
    assert second.forces == pytest.approx(first.forces, abs=1e-12 * np.abs(first.forces).max())
    tangents = np.zeros((2, model.size, model.size, 2))
    tangents[0][model.pattern[1:]] = first.values
    tangents[1][plane.planar_model.pattern[1:]] = tangents[1][plane.planar_model.pattern[:0:-1]] = second.values
    assert tangents[1] == pytest.approx(tangents[0], abs=1e-12 * np.abs(first.values).max())


def test_rotation_beyond_a_turn_by_a_prescribed_angle() -> None:
    """A crank turned through two turns carries its free end round."""
    angles = np.linspace(0.0, 4.0 * np.pi, 9)
    crank = Frame()
    crank.node("A", (0.0, 0.0, 0.0))
    crank.node("B", (1.0, 0.0, 0.0))
    crank.add("AB", Beam(BAR, STEEL), "A", "B")
    crank.fix("A", "ux", "uy", "uz", "rx", "ry")
    crank.prescribe("A", rz=angles)
    moved = crank.solve(large=True, steps=16).displacement("B")
    assert moved[:, 0] == pytest.approx(np.cos(angles) - 1.0, abs=1e-12)
    assert moved[:, 1] == pytest.approx(np.sin(angles), abs=1e-12)


def test_error_bound_holds_what_the_way_leaves_open() -> None:
    """Different load steps end in different last bits: their difference lies within the bounds, which are small."""
    one, other = (solved(steps) for steps in (2, 4))
    for node in "BDEGH":
        apart = np.abs(one.displacement(node) - other.displacement(node))
        bound = one.error_bound(node) + other.error_bound(node)
        assert (apart <= bound).all(), node
        assert bound.max() < 1e-9


def test_moments_in_space_keep_their_axis() -> None:
    """A moment about x at the end of a rod along x, after bending: the reaction is the moment itself."""
    rod = Frame()
    rod.node("A", (0.0, 0.0, 0.0))
    rod.node("B", (2.0, 0.0, 0.0))
    rod.add("AB", Beam(Rectangle(y=0.03, z=0.03), STEEL, segments=6), "A", "B")
    rod.fix("A")
    rod.load("B", mx=1.0e-3, my=6e-3, fz=4e-4)
    solution = rod.solve(large=True)
    assert solution.status == "stable"
    end = np.array([2.0, 0.0, 0.0]) + solution.displacement("B")[:3]
    moment = np.array([1e-3, 6e-3, 0.0]) + np.cross(end, [0.0, 0.0, 4e-4])
    assert solution.reaction("A")[3:] == pytest.approx(-moment, rel=1e-9, abs=1e-12)
    assert solution.residual < 1e-9


@pytest.mark.parametrize("component", [1e6, np.inf])
def test_joints_that_close_a_loop(component: float) -> None:
    """Three links on three joints: springs and ideal components in the loop; statics from outside."""
    linked = Frame()
    for name, place in {"A": (0, 0, 0), "D": (0.6, 0, 0.1), "F": (0.3, -0.3, 0.1)}.items():
        linked.node(name, place)
        linked.fix(name)
    for name in "BCE":
        linked.node(name, (0.3, 0.1, 0.0))
    steel = Beam(Rectangle(y=0.02, z=0.01), Material(E=200e9, nu=0.3), segments=2)
    for ends in ("AB", "CD", "EF"):
        linked.add(ends, steel, *ends)
    linked.add("first", Joint((1e7, 2e7, np.inf, 500.0, 100.0, 5.0)), "B", "C")
    linked.add("second", Joint((1e6, 2e6, 1e5, 200.0, 100.0, 50.0)), "C", "E")
    linked.add("third", Joint((1e6, component, 1e6, 100.0, component, 5.0)), "B", "E")
    force = np.array([800.0, 2000.0, 300.0])
    linked.load("C", fx=force[0], fy=force[1], fz=force[2])
    solution = linked.solve(large=True)
    assert len(solution.model.loops) == 1
    assert solution.status == "stable"
    assert sum(solution.reaction(name)[:3] for name in "ADF") == pytest.approx(-force, rel=1e-10, abs=1e-8)
    for name, (first, second) in {"first": "BC", "second": "CE", "third": "BE"}.items():
        gap = solution.displacement(second)[:3] - solution.displacement(first)[:3]
        moved = solution.joint_displacement(name)
        assert np.linalg.norm(moved[:3]) == pytest.approx(np.linalg.norm(gap), rel=1e-9)
        stiffness = linked.joints[name].element.stiffness
        finite = np.isfinite(stiffness)
        assert solution.joint_force(name)[finite] == pytest.approx(
            stiffness[finite] * moved[finite], rel=1e-9, abs=1e-9
        )
        assert moved[~finite] == pytest.approx(0.0, abs=1e-15)
    tiny = linked.copy()
    tiny.loads = {"C": [(k, 1e-6 * value) for k, value in linked.loads["C"]]}
    linear, large = tiny.solve(), tiny.solve(large=True)
    for name in ("first", "third"):
        expected = linear.joint_force(name)
        assert large.joint_force(name) == pytest.approx(expected, abs=1e-6 * np.abs(expected).max())


def test_bad_input_is_refused() -> None:
    described = frame()
    with pytest.raises(FrameError, match="steps is 0"):
        described.solve(large=True, steps=0)
    with pytest.raises(FrameError, match="'Q' is unknown"):
        described.solve(large=True).displacement("Q")
    with pytest.raises(FrameError, match="no support"):
        described.solve(large=True).reaction("B")
    described.add("slide", Beam(BAR, STEEL, release=("start rz", "end rz", "end uz")), "A", "H")
    with pytest.raises(FrameError, match="'slide' slides"):
        described.solve(large=True)


def test_what_turns_otherwise_is_refused() -> None:
    tense = frame()
    tense.add("string", Spring(stiffness=10.0, force=3.0), "A", "H")
    with pytest.raises(FrameError, match="'string' carries a force at rest"):
        tense.solve(large=True)
    slack = frame()
    slack.add("string", Spring(stiffness=10.0), "A", "H")
    assert (slack.solve(large=True).status == "stable").all()


def test_a_moment_between_nodes_is_refused() -> None:
    described = frame()
    described.point_load("AB", at=0.5, mz=1.0)
    with pytest.raises(FrameError, match="has a moment"):
        described.solve(large=True)


def test_files_for_paraview(tmp_path: object) -> None:
    pytest.importorskip("pyvista")
    solution = solved()
    solution.save(f"{tmp_path}/bent.pvd")
    from pathlib import Path

    import meshio

    mesh = meshio.read(next(Path(f"{tmp_path}").rglob("beams_001.vtu")))
    tip = np.abs(mesh.points - np.array([3.0, 0.0, 0.0])).sum(axis=1).argmin()
    assert mesh.point_data["displacement"][tip] == pytest.approx(solution.displacement("H")[1, :3], abs=1e-12)
