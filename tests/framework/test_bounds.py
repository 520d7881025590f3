"""Error bounds of linear solutions: never below the true error, and not far above it."""

from __future__ import annotations

import importlib.util
import tracemalloc
from collections.abc import Mapping
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given
from linkframe.elements import Beam, Circle, Joint, Material, Rectangle, Section
from linkframe.framework import Frame, FrameError, MechanismWarning, Solution
from linkframe.framework.error_bounds import bounds, compliance
from reference.as_frame import as_frame
from reference.four_bar import coordinates, four_bar
from reference.random_structures import CLAMPED, constrained, few, screws, structures
from reference.stiffness_method import EXACT, cross, deformation, mp, solve
from reference.structure import Member, Spring, Structure
from stress.chain import chain

Array = np.ndarray[Any, np.dtype[Any]]
STEEL = Material(E=2e11, nu=0.3, density=7850.0)
BAR = Beam(Rectangle(y=0.02, z=0.01), STEEL)
ROUNDING = 2.0**-53


def off(found: Array, exact: Array) -> Array:
    """True error of doubles beside 50-digit numbers."""
    return np.array([float(abs(mp.mpf(float(a)) - b)) for a, b in zip(found, exact, strict=True)])


def hold(solution: Solution, kind: str, truth: Mapping[str, Array], floor: float = 0.0) -> None:
    """Bounds of plain and refined results of a kind are not below the error, up to what the reference is sure of."""
    for name, exact in truth.items():
        refined, left = solution.refined(name, kind)
        assert np.all(off(getattr(solution, kind)(name), exact) <= solution.error_bound(name, kind) + floor)
        assert np.all(off(refined, exact) <= left + floor)


def test_axes_a_quarter_turned_change_no_bound() -> None:
    """The same joint, its axes x and y exchanged."""

    def bound(axes: Any, turning: tuple[float, float]) -> Array:
        frame = Frame()
        for name, place in {"A": (0.0, 0.0, 0.0), "B": (0.0, 0.0, 0.0), "C": (0.3, 0.2, 0.4)}.items():
            frame.node(name, place)
        frame.add("pin", Joint(stiffness=(1e8, 1e8, 1e8, *turning, np.inf), axes=axes), "A", "B")
        frame.add("arm", BAR, "B", "C")
        frame.fix("A")
        frame.fix("C")
        frame.load("B", fx=100.0, fz=20.0, my=3.0)
        return frame.solve().error_bound("A", "reaction")

    quarter = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    np.testing.assert_allclose(bound(quarter, (np.inf, 2e5)), bound(None, (2e5, np.inf)), rtol=0.1)


@pytest.mark.parametrize("seed", range(20))
def test_moment_at_the_foot_of_a_tapered_cantilever(seed: int) -> None:
    """That of the force about the foot, in fractions."""
    rng = np.random.default_rng(seed)
    thick, thin = (Section(A=1e-3, Iy=rng.uniform(1e-7, 1e-6), Iz=rng.uniform(1e-7, 1e-6), J=1e-6) for _ in range(2))
    place, force = rng.normal(size=(2, 3))
    frame = Frame()
    frame.node("A", (0.0, 0.0, 0.0))
    frame.node("B", place)
    frame.add("bar", Beam(thick, STEEL, end=thin), "A", "B")
    frame.fix("A")
    frame.load("B", fx=force[0], fy=force[1], fz=force[2])
    d, f = ([mp.mpf(float(part)) for part in vector] for vector in (place, force))
    moment = [d[2] * f[1] - d[1] * f[2], d[0] * f[2] - d[2] * f[0], d[1] * f[0] - d[0] * f[1]]
    hold(frame.solve(), "reaction", {"A": np.array([-f[0], -f[1], -f[2], *moment])})


@few
@given(structures)
def test_random_frames_and_linkages(structure: Structure) -> None:
    """Displacements, reactions, joint displacements, joint forces and end forces beside 50 digits; the force on the tip
    of each member by its tip stiffness, and equilibrium for that on its start."""
    solution, truth = as_frame(structure).solve(), solve(structure)
    hold(solution, "displacement", truth.displacement)
    hold(solution, "reaction", truth.reaction)
    hold(solution, "joint_displacement", truth.extension)
    hold(solution, "joint_force", truth.force)
    exact = {}
    for name, member in structure.members.items():
        stiffness, tip = deformation(member, structure, EXACT)
        force = stiffness @ tip @ np.concatenate([truth.displacement[node] for node in (member.start, member.end)])
        chord = EXACT.array(structure.nodes[member.end]) - EXACT.array(structure.nodes[member.start])
        arm = np.array([mp.sqrt(chord @ chord), mp.mpf(0), mp.mpf(0)])
        exact[name] = np.concatenate([-force[:3], -force[3:] - cross(arm, force[:3]), force])
    hold(solution, "end_forces", exact)


@few
@given(constrained)
def test_rigid_links_and_loops_of_ideal_joints(structure: Structure) -> None:
    """The reference holds what is ideal by springs of 1e30, so that it is sure of 1e-20 only."""
    # A roller on a chain of rigid links from a clamp is redundant: how they share the reaction is undetermined.
    assume(not any(first.startswith("s") and second.startswith("s") for first, second in structure.rigid))
    solution, truth = as_frame(structure).solve(), solve(structure)
    hold(solution, "displacement", truth.displacement, 1e-20 * largest(truth.displacement) + 1e-26)
    hold(solution, "reaction", truth.reaction, 1e-20 * largest(truth.reaction))


@few
@given(screws)
def test_random_frames_with_screws(structure: Structure) -> None:
    """What is ideal is held by springs of 1e30 in the reference, so that it is sure of 1e-20 only."""
    assume(structure.joints)
    solution, truth = as_frame(structure).solve(), solve(structure)
    hold(solution, "displacement", truth.displacement, 1e-20 * largest(truth.displacement) + 1e-26)
    hold(solution, "joint_displacement", truth.extension, 1e-20 * largest(truth.extension) + 1e-26)
    hold(solution, "joint_force", truth.force, 1e-17 * largest(truth.force))
    hold(solution, "reaction", truth.reaction, 1e-20 * largest(truth.reaction))


def largest(vectors: Mapping[str, Array]) -> float:
    """The greatest component."""
    return max(float(abs(part)) for vector in vectors.values() for part in vector)


@pytest.mark.parametrize("angle", [30.0, 80.0, 170.0])
def test_a_bound_is_within_two_decades_of_the_error(angle: float) -> None:
    """Of the four-bar's displacements, or of half a unit in the last place where the error is less."""
    structure = four_bar(coordinates(angle), (10.0, 100.0, 5.0, 1.0, 2.0, 3.0))
    solution, truth = as_frame(structure).solve(), solve(structure)
    size = np.abs(np.array(list(truth.displacement.values()), dtype=float)).reshape(-1, 2, 3).max(axis=(0, 2))
    for name, exact in truth.displacement.items():
        error = np.maximum(off(solution.displacement(name), exact), ROUNDING * np.repeat(size, 3))
        assert np.all(solution.error_bound(name) <= 100.0 * error)


def test_bodies_are_where_their_axes_put_them() -> None:
    """Axes from sines and cosines are orthonormal to rounding; the exact model has its nodes there all the same."""
    angle = np.array([0.3, 1.2, 2.5])
    c, s, o, i = np.cos(angle), np.sin(angle), np.zeros(3), np.ones(3)
    axes = np.stack([np.stack([c, -s, o], -1), np.stack([s, c, o], -1), np.stack([o, o, i], -1)], -2)
    local = {"a": (0.1, 0.05, 0.0), "b": (0.7, 0.2, 0.3), "c": (1.1, -0.4, 0.0)}
    frame = Frame()
    frame.body("arm", (0.2, 0.1, 0.0), axes)
    for name, place in local.items():
        frame.node(name, place, "arm")
    given = {"E": 2e11, "G": 8e10, "A": 2e-4, "Iy": 1.7e-9, "Iz": 6.7e-9, "J": 4.6e-9}
    bars = {"ab": Member("a", "b", **given), "bc": Member("b", "c", **given)}
    template = as_frame(Structure({name: local[name] for name in local}, bars))
    for name, member in bars.items():
        frame.add(name, template.members[name].element, member.start, member.end)
    frame.fix("a")
    frame.load("c", fx=3.0, fy=-2.0, mz=1.0)
    solution = frame.solve()
    for entry in range(3):
        turn = [[mp.mpf(float(axes[entry, j, k])) for k in range(3)] for j in range(3)]
        origin = [mp.mpf(0.2), mp.mpf(0.1), mp.mpf(0)]
        places = {
            name: tuple(origin[j] + sum(turn[j][k] * mp.mpf(at[k]) for k in range(3)) for j in range(3))
            for name, at in local.items()
        }
        up = tuple(turn[j][2] for j in range(3))
        members = {name: Member(m.start, m.end, **given, up=up) for name, m in bars.items()}
        load = {"c": (3.0, -2.0, 0.0, 0.0, 0.0, 1.0)}
        exact = solve(Structure(places, members, supports={"a": CLAMPED}, loads=load)).displacement
        for name in "bc":
            assert np.all(off(solution.displacement(name)[entry], exact[name]) <= solution.error_bound(name)[entry])
    assert np.all(solution.error_bound("c") <= 1e-13 * np.abs(solution.displacement("c")).max())


def test_loads_on_members() -> None:
    """A cantilever under a uniform load, its weight and a point load: closed forms of tip and root in 50 digits."""
    length, w, p, at, g = 1.7, 31.0, 12.0, 0.6, 9.81
    frame = Frame()
    frame.node("A", (0.0, 0.0, 0.0))
    frame.node("B", (length, 0.0, 0.0))
    frame.add("AB", BAR, "A", "B")
    frame.fix("A")
    frame.line_load("AB", fy=-w)
    frame.point_load("AB", at=at, fy=-p)
    frame.gravity((0.0, -g, 0.0))
    solution = frame.solve()
    L, a = mp.mpf(length), mp.mpf(at)
    EI = mp.mpf(2e11) * mp.mpf(0.01) * mp.mpf(0.02) ** 3 / 12
    q = mp.mpf(w) + mp.mpf(g) * mp.mpf(7850.0) * mp.mpf(0.02) * mp.mpf(0.01)
    tip = -(q * L**4 / 8 + mp.mpf(p) * a * a * (3 * L - a) / 6) / EI
    turn = -(q * L**3 / 6 + mp.mpf(p) * a * a / 2) / EI
    found, bound = solution.displacement("B"), solution.error_bound("B")
    assert np.all(off(found, np.array([0, tip, 0, 0, 0, turn])) <= bound)
    assert bound[1] < 1e-12 * abs(found[1])
    force, moment = q * L + mp.mpf(p), q * L * L / 2 + mp.mpf(p) * a
    exact = np.array([0, force, 0, 0, 0, moment])
    assert np.all(off(solution.reaction("A"), exact) <= solution.error_bound("A", "reaction"))
    ends = np.array([*exact, 0, 0, 0, 0, 0, 0])
    assert np.all(off(solution.end_forces("AB"), ends) <= solution.error_bound("AB", "end_forces"))
    assert solution.error_bound("AB", "end_forces").max() < 1e-11 * float(moment)


def test_a_wrong_result_is_found_out() -> None:
    """Whatever is put in the place of a result, its bound is not below how wrong it is, nor much above."""
    solution = as_frame(four_bar(coordinates(30.0), (10.0, 100.0, 5.0, 1.0, 2.0, 3.0))).solve()
    right, bound = solution.displacement("P"), solution.error_bound("P")
    wrong = right * (1.0 + 1e-6)
    stated = solution.bounds.bound("P", "displacement", wrong)
    assert np.all(stated >= np.abs(wrong - right) - bound)
    assert np.all(stated <= np.abs(wrong - right) + 2.0 * bound)


def test_prescribed_displacements_and_offsets() -> None:
    """A settlement and a misfit in a joint, beside 50 digits."""
    places = {"A": (0.0, 0.0, 0.0), "B": (1.0, 0.2, 0.0), "C": (1.0, 0.2, 0.0), "D": (1.5, -0.7, 0.4)}
    given = {"E": 2e11, "G": 8e10, "A": 2e-4, "Iy": 1.7e-9, "Iz": 6.7e-9, "J": 4.6e-9}
    members = {"AB": Member("A", "B", **given), "CD": Member("C", "D", **given)}
    moved = {**CLAMPED, "uy": 1e-3, "rx": -2e-3}
    stiffness = (1e8, 1e7, 1e9, 1e3, 1e4, 1e2)
    structure = Structure(places, members, {"j": Spring("B", "C", stiffness)}, (), {"A": moved, "D": CLAMPED})
    misfit = np.array([1e-3, 0.0, -2e-4, 3e-3, 0.0, 1e-2])
    frame = as_frame(structure)
    frame.offset("j", **dict(zip(("ux", "uy", "uz", "rx", "ry", "rz"), misfit, strict=True)))
    # a spring with a misfit pulls as one without, and a pair of forces besides
    pair = tuple(float(mp.mpf(k) * mp.mpf(float(gap))) for k, gap in zip(stiffness, misfit, strict=True))
    exact = solve(
        Structure(places, members, structure.joints, (), structure.supports, {"B": negative(pair), "C": pair})
    )
    solution = frame.solve()
    hold(solution, "displacement", exact.displacement, 2.0**-52 * largest(exact.displacement))


def negative(vector: tuple[float, ...]) -> tuple[float, ...]:
    return tuple(-part for part in vector)


def test_a_batch_has_the_bounds_of_its_entries() -> None:
    """Chunk by chunk, with singular poses and hard ones among regular ones."""
    angles = np.array([0.0, 1e-5, 1e-3, 1.0, 30.0, 180.0, 200.0])
    each = [four_bar(coordinates(theta), (10.0, 100.0, 5.0, 1.0, 2.0, 3.0)) for theta in angles]
    template, frame = as_frame(each[-1]), Frame()
    for name in each[0].nodes:
        frame.node(name, np.array([structure.nodes[name] for structure in each])[:, None])
    for name, member in template.members.items():
        frame.add(name, member.element, member.start, member.end)
    for name, joint in template.joints.items():
        stiffness = joint.element.stiffness * np.linspace(0.9, 1.1, 160)[:, None]
        frame.add(name, Joint(stiffness=stiffness), joint.first, joint.second)
    frame.fix("A")
    frame.fix("E")
    frame.load("P", fx=10.0, fy=100.0, fz=5.0, mx=1.0, my=2.0, mz=3.0)
    solution = frame.solve()
    with pytest.warns(MechanismWarning):
        bound = solution.error_bound("P")
    assert bound.shape == (7, 160, 6)
    assert np.isinf(bound[[0, 5]]).all()
    assert np.isfinite(bound[[1, 2, 3, 4, 6]]).all()
    refined, left = solution.refined("P")
    for pose in (1, 2, 3, 4, 6):
        for sample in (0, 159):
            joints = {
                name: Spring(joint.first, joint.second, tuple(frame.joints[name].element.stiffness[sample]))
                for name, joint in each[pose].joints.items()
            }
            one = Structure(each[pose].nodes, each[pose].members, joints, (), each[pose].supports, each[pose].loads)
            exact = solve(one).displacement["P"]
            at = pose, sample
            assert np.all(off(solution.displacement("P")[at], exact) <= bound[at])
            assert np.all(off(refined[at], exact) <= left[at])


def test_bounds_of_some_components() -> None:
    """They hold as those of all do, from as many adjoint solutions."""
    structure = four_bar(coordinates(30.0), (10.0, 100.0, 5.0, 1.0, 2.0, 3.0))
    solution, exact = as_frame(structure).solve(), solve(structure).displacement["P"]
    some = solution.error_bound("P", components=("uy", "ux"))
    assert some.shape == (2,)
    off_by = off(solution.displacement("P"), exact)
    assert np.all(off_by[[1, 0]] <= some)
    assert np.all(some <= 2.0 * solution.error_bound("P")[[1, 0]])
    ((_, adjoint),) = solution.bounds.adjoints("P", "displacement", (1, 0))
    assert len(adjoint.coordinates) == 2
    force = solution.error_bound("A", "reaction", components=("fy",))
    np.testing.assert_allclose(force, solution.error_bound("A", "reaction")[1:2], rtol=1.0)
    with pytest.raises(FrameError, match="component 'fx' is unknown: use one of ux"):
        solution.error_bound("P", components=("fx",))
    with pytest.raises(FrameError, match="components of end forces: leave them out"):
        solution.error_bound(next(iter(solution.frame.members)), "end_forces", components=("fx",))


@pytest.mark.parametrize("of", ["displacement", "end_forces"])
def test_a_beam_that_is_rolled_over_the_batch(of: str) -> None:
    """Neither its length nor its stiffness varies, but the axes that its springs act along do."""
    roll, length, load = np.linspace(0.0, 1.5, 7), 0.5, 100.0
    up = np.stack([np.zeros(7), -np.sin(roll), np.cos(roll)], axis=-1)
    frame, section = Frame(), Rectangle(y=0.02, z=0.01)
    frame.node("A", (0.0, 0.0, 0.0))
    frame.node("B", (length, 0.0, 0.0))
    frame.add("AB", Beam(section, Material(E=2e11, G=8e10), up=up, shear=False), "A", "B")
    frame.fix("A")
    frame.load("B", fy=load)
    solution = frame.solve()
    exact = np.zeros((7, 12 if of == "end_forces" else 6))
    along = {"y": load * np.cos(roll), "z": -load * np.sin(roll)}
    if of == "end_forces":  # cantilever: shear P, moment P L at the foot, along local axes
        exact[:, 1], exact[:, 7] = -along["y"], along["y"]
        exact[:, 2], exact[:, 8] = -along["z"], along["z"]
        exact[:, 4], exact[:, 5] = length * along["z"], -length * along["y"]
        found, bound = solution.end_forces("AB"), solution.error_bound("AB", of)
    else:  # P L^3 / (3 E I) along each principal axis
        local = {"y": along["y"] / section.Iz, "z": along["z"] / section.Iy}
        compliance, slope = length**3 / (3.0 * 2e11), length**2 / (2.0 * 2e11)
        exact[:, 1] = compliance * (np.cos(roll) * local["y"] - np.sin(roll) * local["z"])
        exact[:, 2] = compliance * (np.sin(roll) * local["y"] + np.cos(roll) * local["z"])
        exact[:, 4] = -slope * (np.sin(roll) * local["y"] + np.cos(roll) * local["z"])
        exact[:, 5] = slope * (np.cos(roll) * local["y"] - np.sin(roll) * local["z"])
        found, bound = solution.displacement("B"), solution.error_bound("B")
    rounding = 8.0 * np.finfo(float).eps * np.abs(exact).max()
    assert np.all(np.abs(found - exact) <= bound + rounding)
    assert np.all(bound <= 1e3 * rounding)


def lattice() -> Frame:
    """A space frame of 108 unknowns and more, pushed in two load cases."""
    frame = Frame()
    places = [(i, j, k) for k in range(4) for j in range(3) for i in range(3)]
    for place in places:
        frame.node(str(place), np.array(place) + 0.1 * np.sin([place[1], place[2], place[0]]))
    for i, j, k in places:
        for ahead in ((i + 1, j, k), (i, j + 1, k), (i, j, k + 1)):
            if ahead in places:
                frame.add(f"{(i, j, k)} {ahead}", BAR, str((i, j, k)), str(ahead))
        if k == 0:
            frame.fix(str((i, j, k)))
    frame.load("(2, 2, 3)", fx=[1e3, 0.0], fy=[0.0, 2e3], mz=[0.0, 10.0])
    return frame


@pytest.mark.parametrize("way", ["banded", "sparse", "iterative", "cholesky"])
def test_large_frames_have_the_same_bounds(way: str) -> None:
    """Each way agrees with the broadcasting elimination within the bounds of both."""
    if way == "cholesky" and importlib.util.find_spec("cvxopt") is None:
        way = "sparse"
    frame = lattice()
    one, other = frame.solve("broadcast"), frame.solve(way)
    for name, kind in (("(2, 2, 3)", "displacement"), ("(0, 0, 0)", "reaction"), ("(0, 0, 0) (0, 0, 1)", "end_forces")):
        first, second = getattr(one, kind)(name), getattr(other, kind)(name)
        bounds = one.error_bound(name, kind) + other.error_bound(name, kind)
        assert np.all(np.abs(first - second) <= bounds)
        assert bounds.max() < 1e-10 * np.abs(first).max()


@pytest.mark.parametrize("links", [20, 40, 80])
def test_eigenvalues_of_a_large_frame_lie_within_those_of_its_bounds(links: int) -> None:
    """LAPACK's, of the scaled matrix of a long chain; the least is within a factor of ten."""
    solution = as_frame(chain(links)).solve("sparse")
    ((_, adjoint),) = solution.bounds.adjoints(f"e{links - 1}", "displacement")
    values = np.linalg.eigvalsh(solution.solver.factor.scaled.toarray())
    assert 0.1 * values[0] < adjoint.compliance.least < values[0]
    assert values[-1] < adjoint.compliance.greatest


def test_what_has_no_bound() -> None:
    """A mechanism has an infinite one; contacts, unknown names and unknown results are refused."""
    solution = as_frame(four_bar(coordinates(0.0), (0.0, 100.0, 0.0, 0.0, 0.0, 0.0))).solve()
    with pytest.warns(MechanismWarning):
        assert np.isinf(solution.error_bound("P")).all()
    assert np.isinf(solution.error_bound("D", "joint_force")).all()
    regular = as_frame(four_bar(coordinates(20.0), (0.0, 100.0, 0.0, 0.0, 0.0, 0.0))).solve()
    with pytest.raises(FrameError, match="stress"):
        regular.error_bound("crank", "stress")
    with pytest.raises(FrameError, match="Q"):
        regular.error_bound("Q")


def test_a_frame_that_is_held_everywhere() -> None:
    """No unknown, no error."""
    frame = Frame()
    frame.node("A", (0.0, 0.0, 0.0))
    frame.node("B", (1.0, 0.0, 0.0))
    frame.add("AB", BAR, "A", "B")
    frame.fix("A")
    frame.fix("B")
    frame.load("B", fx=7.0)
    solution = frame.solve()
    assert np.all(solution.error_bound("B") == 0.0)
    assert np.all(solution.reaction("B") == [-7.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    assert np.all(solution.error_bound("B", "reaction") <= 1e-16)


@pytest.mark.parametrize("shear", [False, True])
@pytest.mark.parametrize("shape", ["rectangle", "circle"])
def test_stiffnesses_are_within_their_roundings(shape: str, shear: bool) -> None:
    """Springs of random members from their sizes, beside 50 digits."""
    rng = np.random.default_rng(0)
    for _ in range(40):
        y, z, length, young = (float(10**x) for x in rng.uniform((-3, -3, -2, 3), (0, 0, 2, 12)))
        nu = float(rng.uniform(-0.5, 0.49))
        section = Rectangle(y=y, z=z) if shape == "rectangle" else Circle(diameter=y)
        beam = Beam(section, Material(E=young, nu=nu), shear=shear)
        a, b, E, L = mp.mpf(y), mp.mpf(z), mp.mpf(young), mp.mpf(length)
        G = E / (2 * (1 + mp.mpf(nu)))
        if shape == "rectangle":
            A, Iy, Iz, J, factor = a * b, a * b**3 / 12, b * a**3 / 12, torsion(min(a, b), max(a, b)), mp.mpf(5) / 6
        else:
            A, Iy, Iz, J = (mp.pi * a**k / n for k, n in ((2, 4), (4, 64), (4, 64), (4, 32)))
            factor = mp.mpf(float(section.ky))
        slip = L / (factor * G * A) if shear else mp.mpf(0)
        exact = [E * A / L, *(1 / (L**3 / (12 * E * i) + slip) for i in (Iz, Iy)), G * J / L, E * Iy / L, E * Iz / L]
        found = beam.springs(length)[0]
        for one, other in zip(found, exact, strict=True):
            assert abs(mp.mpf(float(one)) / other - 1) <= beam.roundings * ROUNDING


def torsion(short: Any, long: Any) -> Any:
    """Torsion constant of a rectangle (Timoshenko & Goodier, art. 109), its series summed to 1e-30."""
    odd = [2 * n + 1 for n in range(60)]
    whole = mp.zeta(5) * 31 / 32
    left = sum((mp.tanh(n * mp.pi * long / (2 * short)) - 1) / mp.mpf(n) ** 5 for n in odd)
    return short**3 * long * (mp.mpf(1) / 3 - 64 / mp.pi**5 * short / long * (whole + left))


def test_bounds_of_middle_sized_batches_take_flat_memory(monkeypatch: pytest.MonkeyPatch) -> None:
    """Entries are handled some at a time, as many as their matrices leave room for; bounds are the same but for
    what rounding makes of their digits."""
    modulus = 2e11 * np.linspace(1.0, 2.0, 32)
    frame = Frame()
    names = frame.add_nodes(17, np.linspace(0.0, 1.0, 17)[:, None] * np.array([2.0, 0.5, 0.0]))
    rod = Beam(Circle(diameter=0.02), Material(E=modulus[:, None], nu=0.3))
    frame.add_many(rod, pairwise(names))
    frame.fix(names[0])
    frame.load(names[-1], fy=1.0)
    found, peaks = [], []
    for room in (2**22, 2**14):
        monkeypatch.setattr(bounds, "_NUMBERS", room)
        solution = frame.solve("banded")
        solution.displacement(names[-1])
        tracemalloc.start()
        found.append(solution.error_bound(names[-1]))
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    assert solution.bounds.step == 1
    np.testing.assert_allclose(*found, rtol=1e-4)
    assert peaks[1] < 0.5 * peaks[0]


def test_a_product_without_its_zeros_is_the_whole_one() -> None:
    """In extended precision, entry by entry of a batch whose axes only one of the factors has."""
    rng = np.random.default_rng(3)
    rows = (rng.normal(size=(2, 1, 90, 70)) * (rng.random((2, 1, 90, 70)) < 0.1)).astype(np.longdouble)
    weighted = np.swapaxes(rows * rng.random((3, 90))[..., None].astype(np.longdouble), -1, -2)
    found = compliance._product(weighted, rows)
    assert found.dtype == np.longdouble
    np.testing.assert_array_equal(found, weighted @ rows)


def test_bounds_of_a_long_batch_take_a_few_numbers_an_entry() -> None:
    """Of loads and bounds what acts and what is asked for, and not all of six numbers at each node."""
    count = 50_000
    rod = Beam(Circle(diameter=0.02), Material(E=210e9, nu=0.3))
    frame = Frame()
    for name, place in {"A": (0, 0, 0), "B": (0.4, 0, 0), "C": (0.4, 0, 0), "D": (0.4, 0.3, 0)}.items():
        frame.node(name, place)
    frame.add("AB", rod, "A", "B")
    frame.add("CD", rod, "C", "D")
    springs = np.multiply.outer(np.linspace(1.0, 2.0, count), (1e8, 1e8, 1e8, 1e6, 1e6, 50.0))
    frame.add("hinge", Joint(stiffness=springs), "B", "C")
    frame.fix("A")
    frame.load("D", fx=np.linspace(1.0, 10.0, count))
    solution = frame.solve()
    solution.displacement("D")
    tracemalloc.start()
    try:
        solution.error_bound("D")
        kept, most = (each / count for each in tracemalloc.get_traced_memory())
    finally:
        tracemalloc.stop()
    # six bounds, nine unknowns, six springs and a factor in 8 bytes each, the load in 16, and the parts at hand
    assert kept < 450.0
    assert most < 1100.0
