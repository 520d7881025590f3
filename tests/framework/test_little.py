"""Frames and batches of nothing, or next to nothing: every question has an answer, or is refused in words."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from linkframe.elements import Beam, Joint, Material, Rectangle
from linkframe.framework import Frame, FrameError, MechanismWarning, Solution
from linkframe.framework.large.solution import LargeSolution
from numpy.testing import assert_allclose

INF = float("inf")
BAR = Beam(Rectangle(y=0.02, z=0.01), Material(E=200e9, nu=0.3, density=7850.0))
EMPTY = [(0,), (0, 3), (3, 0), (2, 0, 3)]

LINEAR: dict[str, tuple[Callable[[Solution], object], tuple[int, ...]]] = {
    "displacement": (lambda s: s.displacement("D"), (6,)),
    "joint_displacement": (lambda s: s.joint_displacement("pin"), (6,)),
    "displacement_along": (lambda s: s.displacement_along("AB", [0.0, 0.5]), (2, 6)),
    "end_forces": (lambda s: s.end_forces("AB"), (12,)),
    "forces": (lambda s: s.forces("AB", [0.0, 0.5]), (2, 6)),
    "stress": (lambda s: s.stress("AB", [0.0]), (1, 3)),
    "reaction": (lambda s: s.reaction("A"), (6,)),
    "joint_force": (lambda s: s.joint_force("pin"), (6,)),
    "status": (lambda s: s.status, ()),
    "error_bound": (lambda s: s.error_bound("D"), (6,)),
    "error_bound of forces": (lambda s: s.error_bound("AB", "end_forces"), (12,)),
    "refined": (lambda s: s.refined("D")[0], (6,)),
    "sensitivity": (lambda s: s.sensitivity("D", "uy").loads["D"], (6,)),
    "distance": (lambda s: s.distance_to_singularity(), ()),
    "nonlinearity": (lambda s: s.nonlinearity(), ()),
    "linear": (lambda s: s.linear, ()),
    "condition_number": (lambda s: s.condition_number(), ()),
    "scaled_condition_number": (lambda s: s.scaled_condition_number(), ()),
}
LARGE: dict[str, tuple[Callable[[LargeSolution], object], tuple[int, ...]]] = {
    "displacement": (lambda s: s.displacement("D"), (6,)),
    "joint_displacement": (lambda s: s.joint_displacement("pin"), (6,)),
    "displacement_along": (lambda s: s.displacement_along("AB", [0.0, 0.5]), (2, 6)),
    "end_forces": (lambda s: s.end_forces("AB"), (12,)),
    "forces": (lambda s: s.forces("AB", [0.0, 0.5]), (2, 6)),
    "stress": (lambda s: s.stress("AB", [0.0]), (1, 3)),
    "reaction": (lambda s: s.reaction("A"), (6,)),
    "joint_force": (lambda s: s.joint_force("pin"), (6,)),
    "status": (lambda s: s.status, ()),
    "stable": (lambda s: s.stable, ()),
    "error_bound": (lambda s: s.error_bound("D"), (6,)),
    "residual": (lambda s: s.residual, ()),
    "iterations": (lambda s: s.iterations, ()),
}


def bent(shape: tuple[int, ...], vary: str = "load", out_of_plane: bool = False) -> Frame:
    """A -- B, pin, C -- D, clamped at A, with a batch of this shape in its load or its places."""
    frame = Frame()
    zero = np.zeros((*shape, 1)) if vary == "place" else 0.0
    for name, place in {"A": (0, 0, 0), "B": (1, 0, 0), "C": (1, 0, 0), "D": (1, 1, 0)}.items():
        frame.node(name, np.array(place) + zero)
    frame.add("AB", BAR, "A", "B")
    frame.add("pin", Joint(stiffness=(1e8, 1e8, 1e8, 1e6, 1e6, 1e3)), "B", "C")
    frame.add("CD", BAR, "C", "D")
    frame.fix("A")
    frame.load("D", fx=np.ones(shape) if vary == "load" else 1.0, fz=float(out_of_plane))
    return frame


@pytest.mark.parametrize("vary", ["load", "place"])
@pytest.mark.parametrize("shape", EMPTY)
@pytest.mark.parametrize("asked", LINEAR)
def test_empty_batches(asked: str, shape: tuple[int, ...], vary: str) -> None:
    """Results are there, of the batch's shape; no question ends otherwise than at full batches."""
    call, trailing = LINEAR[asked]
    assert np.shape(call(bent(shape, vary).solve())) == (*shape, *trailing)


@pytest.mark.parametrize("out_of_plane", [False, True])
@pytest.mark.parametrize("vary", ["load", "place"])
@pytest.mark.parametrize("shape", EMPTY)
def test_empty_batches_at_large_displacement(shape: tuple[int, ...], vary: str, out_of_plane: bool) -> None:
    solution = bent(shape, vary, out_of_plane).solve(large=True)
    for call, trailing in LARGE.values():
        assert np.shape(call(solution)) == (*shape, *trailing)
    assert solution.strain_energy.shape == solution.work.shape == (1, *shape)
    path = bent(shape, vary, out_of_plane).path("D", "ux", 1e-4)
    assert path.displacement("D").shape[1:] == (*shape, 6)


def clamped_at_both_ends(settled: float, up: float = 0.0) -> Frame:
    frame = Frame()
    for name, x in {"A": 0.0, "B": 1.0}.items():
        frame.node(name, (x, 0.0, 0.0))
    frame.add("AB", BAR, "A", "B")
    frame.fix("A")
    frame.prescribe("B", ux=0.0, uy=settled, uz=up, rx=0.0, ry=0.0, rz=0.0)
    return frame


@pytest.mark.parametrize("up", [0.0, 1e-6])
def test_nothing_is_free(up: float) -> None:
    """A settlement w of a clamped end calls for 12 EI w/L³ there."""
    solution = clamped_at_both_ends(1e-6, up).solve(large=True)
    assert solution.status == "stable"
    assert solution.stable
    assert not solution.residual
    bending = 12.0 * 200e9 * 0.01 * 0.02**3 / 12.0
    assert_allclose(solution.reaction("B")[1], 1e-6 * bending, rtol=1e-6)
    assert_allclose(solution.displacement("B"), [0.0, 1e-6, up, 0.0, 0.0, 0.0], atol=1e-22)
    assert not solution.error_bound("A").any()
    with pytest.raises(FrameError, match=r"path.*'B'.*nothing.*move.*prescribe"):
        clamped_at_both_ends(0.0).path("B", "uy", 1e-6)


@pytest.mark.parametrize("place", [0.0, 1.0])
def test_a_chain_of_ideal_joints(place: float) -> None:
    """Nothing moves; joints and support hand the load on."""
    frame = Frame()
    for name in ("A", "B", "C"):
        frame.node(name, (place, 0.0, 0.0))
    frame.add("first", Joint(stiffness=(INF,) * 6), "A", "B")
    frame.add("second", Joint(stiffness=(INF,) * 6), "B", "C")
    frame.fix("A")
    frame.load("C", fx=3.0, mz=1.0)
    for solution in (frame.solve(), frame.solve(large=True)):
        assert solution.status in ("regular", "stable")
        assert_allclose(solution.reaction("A"), [-3.0, 0.0, 0.0, 0.0, 0.0, -1.0])
        assert_allclose(solution.joint_force("second"), [3.0, 0.0, 0.0, 0.0, 0.0, 1.0])
        assert not solution.displacement("C").any()


@pytest.mark.parametrize("place", [0.0, 1e-3, 1.0])
@pytest.mark.parametrize("stiffness", [50.0, INF])
@pytest.mark.parametrize("play", ["ux", "rz"])
def test_a_journal_alone_at_large_displacement(place: float, stiffness: float, play: str) -> None:
    """ε + F/k along one direction, wherever the nodes are."""
    component = ["ux", "uy", "uz", "rx", "ry", "rz"].index(play)
    frame = Frame()
    for name in ("A", "B"):
        frame.node(name, (place, 0.0, 0.0))
    springs = [INF] * 6
    springs[component] = stiffness
    frame.add("pin", Joint(stiffness=springs, clearance=0.02, clearance_directions=play), "A", "B")
    frame.fix("A")
    frame.load("B", **{{"ux": "fx", "rz": "mz"}[play]: [1.0, -2.0, 1e-6]})
    solution = frame.solve(large=True)
    expected = np.array([0.02, -0.02, 0.02]) + np.array([1.0, -2.0, 1e-6]) / stiffness
    assert_allclose(solution.displacement("B")[:, component], expected, rtol=1e-14)
    assert solution.status.tolist() == ["stable"] * 3
    assert_allclose(solution.contact("pin").force, [1.0, 2.0, 1e-6], rtol=1e-9)


def test_no_frame_at_all() -> None:
    frame = Frame()
    assert frame.solve().status == "regular"
    assert frame.solve().linear
    assert frame.solve().distance_to_singularity() == 1.0
    assert frame.solve().free_motion().count == 0
    assert frame.solve(large=True).status == "stable"
    assert frame.solve(large=True).residual == 0.0


@pytest.mark.parametrize("place", [0.0, 1.0])
@pytest.mark.parametrize("force", [None, 0.0, 1.0])
def test_a_node_that_nothing_holds(place: float, force: float | None) -> None:
    """Six free motions; a force drives it away, and its results are announced to be none."""
    frame = Frame()
    frame.node("A", (place, 0.0, 0.0))
    if force is not None:
        frame.load("A", fx=force)
    solution, large = frame.solve(), frame.solve(large=True)
    assert solution.status == ("mechanism" if force else "statically consistent mechanism")
    assert np.isnan(large.displacement("A")).all() == bool(force)
    assert solution.free_motion().count == 6
    assert solution.free_motion().solvable is not bool(force)
    assert "A" in solution.mechanism()
    if force:
        with pytest.warns(MechanismWarning):
            assert np.isnan(solution.displacement("A")).all()
    assert large.status == ("not converged" if force else "stable")
    assert np.isnan(large.displacement("A")).all() == bool(force)


@pytest.mark.parametrize("place", [0.0, 1.0])
def test_a_held_node_alone(place: float) -> None:
    frame = Frame()
    frame.node("A", (place, 0.0, 0.0))
    frame.prescribe("A", ux=1.0, uy=0.0, uz=0.0, rx=0.0, ry=0.0, rz=1.0)
    frame.load("A", fy=2.0)
    for solution in (frame.solve(), frame.solve(large=True)):
        assert solution.status in ("regular", "stable")
        assert_allclose(solution.displacement("A"), [1.0, 0.0, 0.0, 0.0, 0.0, 1.0], atol=1e-15)
        assert_allclose(solution.reaction("A"), [0.0, -2.0, 0.0, 0.0, 0.0, 0.0], atol=1e-15)
        assert not solution.error_bound("A")[1:5].any()


@pytest.mark.parametrize("vary", ["section", "joint", "clearance", "place"])
def test_empty_batches_of_elements(vary: str, tmp_path: Path) -> None:
    """Elements without entries, under loads on members; what needs an entry says so."""
    none = np.zeros(0)
    beam = Beam(Rectangle(y=none + 0.02 if vary == "section" else 0.02, z=0.01), BAR.material)
    stiffness = np.full((0, 6), 1e8) if vary == "joint" else (1e8,) * 6
    frame = Frame()
    for name, place in {"A": (0, 0, 0), "B": (1, 0, 0), "C": (1, 0, 0), "D": (1, 1, 0)}.items():
        frame.node(name, np.array(place) + (none[:, None] if vary == "place" else 0.0))
    frame.add("AB", beam, "A", "B")
    frame.add("pin", Joint(stiffness=stiffness, clearance=none if vary == "clearance" else 0.0), "B", "C")
    frame.add("CD", beam, "C", "D")
    frame.fix("A")
    frame.load("C", fy=1.0)
    frame.line_load("AB", fy=1.0, span=(0.2, 0.5))
    frame.point_load("AB", at=0.3, fz=1.0)
    solution = frame.solve()
    assert solution.displacement("C").shape == solution.joint_force("pin").shape == (0, 6)
    assert solution.forces("AB", [0.1, 0.2]).shape == (0, 2, 6)
    assert frame.solve(large=True).displacement("C").shape == (0, 6)
    assert frame.modes(2).frequencies.shape == (0, 2)
    for name in ("pose.vtu", "series.pvd"):
        with pytest.raises(FrameError, match=r"batch shape is \(0,\), without entries"):
            solution.save(tmp_path / name)
