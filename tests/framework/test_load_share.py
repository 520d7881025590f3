"""Redundant ideal joints and supports: who carries what, alone, in a batch and described otherwise."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import Any

import mpmath
import numpy as np
import pytest
from linkframe.elements import Beam, Circle, Joint, Material
from linkframe.framework import Frame
from numpy.testing import assert_allclose
from numpy.typing import NDArray

Numbers = NDArray[np.float64]
INF = np.inf
ROD = Beam(Circle(diameter=0.02), Material(E=2e11, nu=0.3, density=7850.0))
ROLLER = (INF, 0.0, 0.0, 0.0, 0.0, 0.0)
LOAD = 10.0, 5.0


def about(axis: int, angle: Numbers) -> Numbers:
    """Axes (..., 3, 3) turned about a global one."""
    i, j = (axis + 1) % 3, (axis + 2) % 3
    out = np.zeros((*np.shape(angle), 3, 3)) + np.eye(3)
    out[..., i, i] = out[..., j, j] = np.cos(angle)
    out[..., j, i] = np.sin(angle)
    out[..., i, j] = -out[..., j, i]
    return out


def on_rollers(angles: Numbers) -> Frame:
    """A cantilever whose end rolls along its axis between rollers, the directions of which are (..., rollers)."""
    frame = Frame()
    frame.node("A", (0.0, 0.0, 0.0))
    frame.node("B", (1.0, 0.0, 0.0))
    frame.add("AB", ROD, "A", "B")
    frame.fix("A")
    for k in range(angles.shape[-1]):
        frame.node(f"G{k}", (1.0, 0.0, 0.0))
        frame.fix(f"G{k}")
        turned = about(0, angles[..., k]) @ about(2, np.array(0.5 * np.pi))
        frame.add(f"roller {k}", Joint(stiffness=ROLLER, axes=turned), f"G{k}", "B")
    frame.load("B", fy=LOAD[0], fz=LOAD[1])
    return frame


def least(normals: Numbers) -> list[Any]:
    """Forces along normals (k, 2) that hold the load, with the least sum of squares, in 40 digits."""
    with mpmath.workdps(40):
        n = mpmath.matrix(normals.tolist())
        found = n * mpmath.lu_solve(n.T * n, mpmath.matrix(LOAD))
        return list(found)


def test_rollers_share_by_the_pseudo_inverse_and_within_their_bounds() -> None:
    """Some are across each other, or in line; the share of each entry is its own."""
    rng = np.random.default_rng(3)
    angles = np.concatenate([[[0.0, 0.5 * np.pi, 0.0, np.pi]], rng.uniform(0.0, np.pi, (7, 4))])
    solution = on_rollers(angles).solve()
    for entry, own in enumerate(angles):
        normals = np.stack([(about(0, a) @ about(2, np.array(0.5 * np.pi)))[1:, 0] for a in own])
        for k, exact in enumerate(least(normals)):
            force = solution.joint_force(f"roller {k}")[entry, 0]
            bound = solution.error_bound(f"roller {k}", "joint_force")[entry, 0]
            assert abs(mpmath.mpf(force) - exact) <= bound < 1e-11
            assert_allclose(solution.reaction(f"G{k}")[entry, 1:3], -force * normals[k], rtol=1e-12, atol=1e-12)
    assert "Redundant: 2 ideal components" in solution.explain()


@pytest.mark.parametrize("shape", [(0, 4), (3, 0, 4)])
def test_a_batch_without_entries(shape: tuple[int, ...]) -> None:
    solution, expected = on_rollers(np.zeros(shape)).solve(), (*shape[:-1], 6)
    assert solution.joint_force("roller 1").shape == solution.reaction("G1").shape == expected
    assert solution.error_bound("roller 1", "joint_force").shape == expected


def door(hinge: tuple[float, ...], moment: float = 8.0, apart: float = 0.5) -> Frame:
    """A rigid door on two hinges, with a moment on the end of a rod across it."""
    frame = Frame()
    for name, z in {"low": 0.0, "high": 2.0 * apart}.items():
        frame.node(name, (0.0, 0.0, z))
        frame.node(f"{name} wall", (0.0, 0.0, z))
        frame.fix(f"{name} wall")
        frame.add(f"{name} hinge", Joint(stiffness=hinge), f"{name} wall", name)
    frame.rigid("low", "high")
    frame.node("tip", (0.0, 0.6, 0.0))
    frame.add("rod", ROD, "low", "tip")
    frame.load("tip", mx=moment)
    return frame


def test_hinges_share_like_springs_of_equal_stiffness() -> None:
    """Half of the moment goes by each way: as a couple of forces, and as moments in the hinges."""
    solution = door((INF,) * 5 + (1.0,)).solve()
    low, high = (solution.joint_force(f"{name} hinge") for name in ("low", "high"))
    assert_allclose(low, [0.0, 8.0 / (4.0 * 0.5), 0.0, 8.0 / 4.0, 0.0, 0.0], rtol=1e-12, atol=1e-12)
    assert_allclose(high, [0.0, -8.0 / (4.0 * 0.5), 0.0, 8.0 / 4.0, 0.0, 0.0], rtol=1e-12, atol=1e-12)
    stiff = door((1e12, 1e12, 1e12, 0.25e12, 0.25e12, 1.0)).solve()
    assert_allclose(stiff.joint_force("low hinge"), low, rtol=1e-6, atol=1e-9)
    assert_allclose(stiff.joint_force("high hinge"), high, rtol=1e-6, atol=1e-9)


def tangle(seed: int, entry: int | None = None, *, order: int = 0) -> Frame:
    """Rods on rigid links and joints that are ideal in random directions, along axes that vary over four entries."""
    rng = np.random.default_rng(seed)
    points = np.round(rng.uniform(0.0, 2.0, (3, 3)), 1)
    angles = np.append([0.0, 0.5 * np.pi], rng.uniform(0.0, np.pi, 2))
    steps: list[Callable[[Frame], None]] = [lambda frame: frame.add("rod", ROD, "P0", "P1")]
    steps += [lambda frame: frame.add("strut", ROD, "P1", "P2"), lambda frame: frame.fix("P2")]
    places = {f"P{k}": point for k, point in enumerate(points)}
    for k in range(5):
        at = int(rng.integers(2))
        places[f"G{k}"] = points[at]
        stiffness = tuple(rng.choice([0.0, 1e6, INF], 6, p=[0.3, 0.2, 0.5]).tolist())
        turned = about(int(rng.integers(3)), angles if rng.random() < 0.7 else angles[0])
        own = Joint(stiffness=stiffness, axes=turned if entry is None or turned.ndim == 2 else turned[entry])
        steps.append(lambda frame, k=k, at=at, own=own: frame.add(f"J{k}", own, f"G{k}", f"P{at}"))
        if rng.random() < 0.5:
            steps.append(lambda frame, k=k: frame.fix(f"G{k}"))
        else:
            steps.append(lambda frame, k=k, at=at: frame.rigid(f"P{1 - at}", f"G{k}"))
    frame, names = Frame(), list(places)
    mixed = np.random.default_rng(order) if order else None
    for name in names if mixed is None else mixed.permutation(names).tolist():
        frame.node(name, places[name])
    for step in steps if mixed is None else [steps[k] for k in mixed.permutation(len(steps))]:
        step(frame)
    for name in ("P0", "P1"):
        force = rng.normal(size=6)
        frame.load(name, **dict(zip(("fx", "fy", "fz", "mx", "my", "mz"), force.tolist(), strict=True)))
    return frame


def read(frame: Frame) -> dict[str, Numbers]:
    """Forces of all joints and supports, and what follows from them."""
    solution = frame.solve()
    out = {name: solution.joint_force(name) for name in frame.joints}
    out |= {f"at {name}": solution.reaction(name) for name in frame.supports}
    refined, bound = solution.refined("J0", "joint_force")
    return out | {"refined": refined, "bound": bound, "state": solution.state}


def same(found: dict[str, Numbers], other: dict[str, Numbers], entry: Any = ...) -> None:
    """Compare results, one entry of a batch with those of a single frame; bounds are of the size of rounding."""
    size = max(float(np.nanmax(np.abs(each), initial=1.0)) for name, each in other.items() if name != "bound")
    for name, value in other.items():
        own = found[name] if found[name].ndim == value.ndim else found[name][entry]
        if name == "bound":
            assert np.array_equal(np.isfinite(own), np.isfinite(value))
            assert (np.nan_to_num(np.abs(own - value)) < 1e-11 * size + 100.0 * value).all()
        else:
            assert_allclose(own, value, rtol=1e-8, atol=1e-10 * size)


@pytest.mark.parametrize("seed", [2, 35, 39])
def test_the_share_is_that_of_the_entry_alone_and_of_another_order(seed: int) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        whole = read(tangle(seed))
        for entry in range(4):
            same(whole, read(tangle(seed, entry)), entry)
        same(whole, read(tangle(seed, order=1)))


@pytest.mark.parametrize("seed", [51, 174])
def test_the_condition_number_is_that_of_the_entry_alone(seed: int) -> None:
    """Though the batch eliminates other unknowns of a loop than the entry alone."""
    found = tangle(seed).solve().scaled_condition_number()
    alone = [tangle(seed, entry).solve().scaled_condition_number() for entry in range(4)]
    assert_allclose(found, alone, rtol=1e-9)


def test_screws_share_by_what_they_exert() -> None:
    """A carriage on two spindles along z: forces of the nuts, with ``mz = -lead fz`` each, by normal equations.

    Squares of moments are divided by that of half the distance, and of the leads at two of four joints and supports.
    """
    apart, pitch = 0.8, 1.5
    frame, load = Frame(), np.array([3.0, -2.0, 5.0, 0.4, 0.7, -0.6])
    for name, x in {"left": 0.0, "right": apart}.items():
        frame.node(name, (x, 0.0, 0.0))
        frame.node(f"{name} wall", (x, 0.0, 0.0))
        frame.fix(f"{name} wall")
        frame.add(f"{name} nut", Joint(stiffness=(INF,) * 5 + (0.0,), pitch=pitch), f"{name} wall", name)
    frame.rigid("left", "right")
    frame.node("tip", (0.0, 0.5, 0.2))
    frame.add("rod", ROD, "left", "tip")
    frame.load("tip", **dict(zip(("fx", "fy", "fz", "mx", "my", "mz"), load.tolist(), strict=True)))
    solution, lead = frame.solve(), pitch / (2.0 * np.pi)
    own = np.eye(6)[:, :5] - lead * np.outer(np.eye(6)[5], np.eye(5)[2])
    arm = np.eye(6)
    arm[[4, 5], [2, 1]] = -apart, apart
    works = np.hstack([own, arm @ own])
    carried = load + np.append(np.zeros(3), np.cross([0.0, 0.5, 0.2], load[:3]))
    found = least_squares(works, np.kron(np.eye(2), own), carried, np.sqrt(apart**2 / 4.0 + lead**2 / 2.0))
    for k, name in enumerate(("left", "right")):
        expected = own @ found[5 * k : 5 * k + 5]
        assert_allclose(solution.joint_force(f"{name} nut"), expected, rtol=1e-10, atol=1e-12)
        assert_allclose(solution.reaction(f"{name} wall"), -expected, rtol=1e-10, atol=1e-12)


def least_squares(works: Numbers, exerted: Numbers, load: Numbers, length: float) -> Numbers:
    """Forces (n,) in equilibrium with a load (6,) of which the sum of squares is least, by normal equations.

    `exerted` (6 k, n) is what they are as forces and moments, and `works` (6, n) what these are at the load's place.
    """
    weighed = np.tile(np.repeat([1.0, 1.0 / length], 3), len(exerted) // 6)[:, None] * exerted
    metric = np.linalg.inv(weighed.T @ weighed)
    found: Numbers = metric @ works.T @ np.linalg.solve(works @ metric @ works.T, load)
    return found


def test_rigid_links_that_close_loops_of_their_own_leave_the_share_of_supports() -> None:
    """P and Q are clamped; links from P to R and to S go two ways each, so that some states of self-stress differ by
    what is in rigid links alone."""
    places, load = np.random.default_rng(3).uniform(0.0, 2.0, (4, 3)), np.array([1.0, 2.0, -0.5, 0.2, 0.1, 0.3])
    frame = Frame()
    for name, place in zip("PQRS", places, strict=True):
        frame.node(name, place)
    for name in "PQ":
        frame.fix(name)
    for pair in ("PQ", "QR", "PR", "RS", "PS"):
        frame.rigid(*pair)
    frame.node("T", (1.0, 1.0, 3.0))
    frame.add("rod", ROD, "S", "T")
    frame.load("T", **dict(zip(("fx", "fy", "fz", "mx", "my", "mz"), load.tolist(), strict=True)))
    solution, arm = frame.solve(), np.eye(6)
    p, q = places[:2]
    arm[3:, :3] = np.cross(q - p, np.eye(3)).T
    carried = load + np.append(np.zeros(3), np.cross([1.0, 1.0, 3.0] - p, load[:3]))
    works = np.hstack([np.eye(6), arm])
    found = -least_squares(works, np.eye(12), carried, float(np.linalg.norm(q - p)) / 2.0)
    for name, expected in {"P": found[:6], "Q": found[6:]}.items():
        assert_allclose(solution.reaction(name), expected, rtol=1e-11, atol=1e-11)
        assert (np.abs(solution.reaction(name) - expected) <= solution.error_bound(name, "reaction") + 1e-14).all()


def test_scaled_condition_number_of_an_entry_whose_pivots_are_equal() -> None:
    """Of equal coefficients of a loop the entry takes the same one alone and beside others: 5.2 and 19.6 once."""
    whole = tangle(244).solve().scaled_condition_number()
    assert_allclose(whole, [tangle(244, entry).solve().scaled_condition_number() for entry in range(4)], rtol=1e-8)
