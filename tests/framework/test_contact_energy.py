"""Contact in statically indeterminate frames, against the least energy found by an independent program."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.elements import Beam, Joint, Material, Rectangle
from linkframe.framework import Frame, Solution

from tests.reference.contact_energy import PlanarFrame

HEIGHT, WIDTH, E = 0.02, 0.01, 200e9
EA, EI = E * HEIGHT * WIDTH, E * WIDTH * HEIGHT**3 / 12
# A bar from A over M to C, where two more bars meet it, which stand on B and G: pins A, C, B, G with clearance.
PLACES = {"A": (0.0, 0.0), "C": (0.5, 0.3), "B": (1.0, 0.0), "G": (0.5, -0.4)}
PINS = {"A": ("A", "A2"), "C": ("C", "C2"), "B": ("B2", "B"), "G": ("G2", "G")}
BARS = (("A2", "M"), ("M", "C"), ("C2", "B2"), ("C2", "G2"))
MIDDLE = (0.25, 0.15)


def structure(stiffness: float, clearance: dict[str, float], force: np.ndarray) -> Frame:
    bar = Beam(Rectangle(y=HEIGHT, z=WIDTH), Material(E=E, nu=0.3))
    frame = Frame()
    for name, (x, y) in PLACES.items():
        for node in PINS[name]:
            frame.node(node, (x, y, 0.0))
    frame.node("M", (*MIDDLE, 0.0))
    for start, end in BARS:
        frame.add(start + end, bar, start, end)
    for name, ends in PINS.items():
        frame.add("pin " + name, Joint((stiffness,) * 5 + (0.0,), clearance=clearance[name]), *ends)
    for support in ("A", "B", "G"):
        frame.fix(support)
    frame.load("M", fx=force[0], fy=force[1])
    frame.load("C2", fx=force[2], fy=force[3])
    return frame


def reference(stiffness: float, clearance: dict[str, float], force: np.ndarray) -> dict[str, np.ndarray]:
    nodes = {node: PLACES[name] for name, ends in PINS.items() for node in ends} | {"M": MIDDLE}
    number = {node: index for index, node in enumerate(nodes)}
    model = PlanarFrame(list(nodes.values()))
    for start, end in BARS:
        model.beam(number[start], number[end], EA, EI)
    model.pins = [(number[a], number[b], stiffness, clearance[name]) for name, (a, b) in PINS.items()]
    model.held = {3 * number[support] + k for support in ("A", "B", "G") for k in range(3)}
    model.load[3 * number["M"] : 3 * number["M"] + 2] = force[:2]
    model.load[3 * number["C2"] : 3 * number["C2"] + 2] = force[2:]
    u = model.minimum()
    return {node: u[index] for node, index in number.items()}


def states(solution: Solution, clearance: dict[str, float]) -> list[str]:
    return [str(solution.contact("pin " + name).status) for name, eps in clearance.items() if eps]


@pytest.mark.parametrize("seed", range(16))
def test_displacements_are_those_of_the_least_energy(seed: int) -> None:
    rng = np.random.default_rng(seed)
    stiffness = 10 ** rng.uniform(4, 8)
    clearance = {name: 10 ** rng.uniform(-5, -3) * float(rng.random() > 0.2) for name in PINS}
    force = rng.normal(size=4) * 10 ** rng.uniform(1, 4)
    solution = structure(stiffness, clearance, force).solve()
    expected = reference(stiffness, clearance, force)
    largest = max(float(np.abs(u).max()) for u in expected.values())
    for node, u in expected.items():
        np.testing.assert_allclose(solution.displacement(node)[[0, 1, 5]], u, rtol=0, atol=1e-6 * largest)


def test_some_of_them_are_open() -> None:
    """A small load leaves the prop G off its pin; a larger one closes it: the cases above are of both kinds."""
    clearance = dict.fromkeys(PINS, 1e-6) | {"G": 1e-4}
    force = np.array([0.0, -1.0, 0.0, 0.0])
    small, large = (structure(1e8, clearance, factor * force).solve() for factor in (1.0, 1e4))
    assert states(small, clearance) == ["closed", "closed", "closed", "open"]
    assert states(large, clearance) == ["closed", "closed", "closed", "closed"]
    for solution, factor in ((small, 1.0), (large, 1e4)):
        u = reference(1e8, clearance, factor * force)["M"]
        np.testing.assert_allclose(solution.displacement("M")[[0, 1, 5]], u, rtol=1e-6)


@pytest.mark.parametrize("stiffness", [1e3, 1e7, 1e11, np.inf])
@pytest.mark.parametrize("seed", range(6))
def test_every_joint_obeys_its_law(stiffness: float, seed: int) -> None:
    """Law and equilibrium together make the energy least, as it is convex; equilibrium is that of a linear frame."""
    rng = np.random.default_rng(seed)
    clearance = {name: 10 ** rng.uniform(-6, -3) for name in PINS}
    force = rng.normal(size=4) * 10 ** rng.uniform(1, 4)
    solution = structure(stiffness, clearance, force).solve()
    size = np.abs(force).max()
    for name, eps in clearance.items():
        gap = solution.joint_displacement("pin " + name)[:2]
        pull = solution.joint_force("pin " + name)[:2]
        contact = solution.contact("pin " + name)
        if not contact.closed:
            assert np.hypot(*gap) <= eps
            assert contact.gap == pytest.approx(eps - np.hypot(*gap), abs=1e-12 * eps)
            np.testing.assert_allclose(pull, 0.0, atol=1e-9 * size)
            continue
        np.testing.assert_allclose(gap, (eps + np.hypot(*pull) / stiffness) * contact.normal[:2], atol=1e-9 * eps)
        np.testing.assert_allclose(pull, contact.force * contact.normal[:2], atol=1e-9 * size)


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3])
def test_small_clearances_displace_in_proportion(size: float) -> None:
    """With all joints closed, halving the clearances halves their displacement, to first order in them."""
    force = size * np.array([10.0, -200.0, 30.0, 40.0])
    clearance = {"A": 3e-9 * size, "C": 2e-9 * size, "B": 1e-9 * size, "G": 4e-9 * size}
    tight = structure(1e9, clearance, force).solve(clearance=False).displacement("M")[:2]
    whole, half = (
        structure(1e9, {name: factor * eps for name, eps in clearance.items()}, force).solve().displacement("M")[:2]
        - tight
        for factor in (1.0, 0.5)
    )
    np.testing.assert_allclose(half, 0.5 * whole, rtol=2e-3)
    assert np.abs(whole).max() > 1e-9 * size


def test_stiffness_to_infinity_is_smooth() -> None:
    """The displacement tends to that of rigid contacts as 1/k, to the last digit."""
    clearance = {"A": 3e-4, "C": 2e-4, "B": 1e-4, "G": 4e-4}
    force = np.array([1000.0, -2000.0, 300.0, 400.0])

    def displacement(stiffness: float) -> np.ndarray:
        found: np.ndarray = structure(stiffness, clearance, force).solve().displacement("M")[:2]
        return found

    rigid = displacement(np.inf)
    off = [np.abs(displacement(10.0**k) - rigid).max() for k in range(9, 18)]
    np.testing.assert_allclose(np.divide(off[:-1], off[1:]), 10.0, rtol=0.01)


def test_loads_of_all_sizes_are_resolved_or_announced() -> None:
    """With 10⁷ N/m against closing 10⁻⁴ m, rounding hides the contact under 10⁻⁶ N: the status says so."""
    clearance = {"A": 3e-4, "C": 2e-4, "B": 1e-4, "G": 4e-4}
    direction = np.array([1.0, -2.0, 0.3, 0.4])
    limit = structure(1e9, clearance, 1e-4 * direction).solve()
    for size in 10.0 ** np.arange(-3, 4):
        assert states(structure(1e9, clearance, size * direction).solve(), clearance)[:3] == ["closed"] * 3
    for size in 10.0 ** np.arange(-12, -6):
        small = structure(1e9, clearance, size * direction).solve()
        assert small.status == "unresolved"
        assert np.isnan(small.contact("pin A").force)
    force = np.array([limit.contact("pin " + name).force for name in "ACB"])
    twice = structure(1e9, clearance, 2e-4 * direction).solve()
    np.testing.assert_allclose([twice.contact("pin " + name).force for name in "ACB"], 2.0 * force, rtol=1e-3)
