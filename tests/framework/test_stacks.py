"""Members of many sections are evaluated as one stack: the same numbers as each by itself, in the time of one."""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np
import pytest
from linkframe.elements import Beam, Circle, Joint, Material, Rectangle, Section, Tube
from linkframe.framework import Frame, FrameError
from numpy.testing import assert_allclose
from numpy.typing import NDArray

STEEL = Material(E=200e9, nu=0.3, density=7850.0)
Array = NDArray[np.float64]


def kinds(rng: np.random.Generator, batch: bool) -> list[Beam]:
    """Two beams or more of each family, in no order."""

    def some(mean: float) -> object:
        return mean * rng.uniform(0.8, 1.2, 3 if batch and rng.random() < 0.5 else ())

    def steel() -> Material:
        return Material(E=some(200e9), nu=0.3, density=some(7850.0)) if rng.random() < 0.6 else STEEL  # type: ignore[arg-type]

    def bar() -> Rectangle:
        return Rectangle(y=some(0.06), z=some(0.04))  # type: ignore[arg-type]

    def plain() -> Section:
        return Section(A=some(2e-3), Iy=some(4e-7), Iz=some(6e-7), J=some(5e-7))  # type: ignore[arg-type]

    def told() -> Section:
        return Section(A=2e-3, Iy=some(4e-7), Iz=6e-7, J=5e-7, ky=0.8, kz=0.8, cy=0.03, cz=0.02, Wt=2e-5)  # type: ignore[arg-type]

    makers: tuple[Callable[[], Beam], ...] = (
        lambda: Beam(bar(), steel()),
        lambda: Beam(bar(), steel(), segments=int(rng.integers(1, 3))),
        lambda: Beam(bar(), steel(), shear=True),
        lambda: Beam(bar(), steel(), up=rng.normal(size=3)),
        lambda: Beam(bar(), steel(), release=("end rz",)),
        lambda: Beam(bar(), steel(), end=Rectangle(y=0.03, z=some(0.05))),  # type: ignore[arg-type]
        lambda: Beam(Circle(diameter=some(0.05)), steel()),  # type: ignore[arg-type]
        lambda: Beam(Tube(outer=some(0.06), thickness=0.005), steel()),  # type: ignore[arg-type]
        lambda: Beam(plain(), steel()),
        lambda: Beam(told(), steel()),
    )
    out = [make() for make in makers for _ in range(2)]
    return [out[k] for k in rng.permutation(len(out))]


def lattice(beams: list[Beam], *, weight: bool = False) -> Frame:
    """A crooked ladder in space of these beams, partly on a body, with a joint at its top."""
    frame = Frame()
    turn = [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]
    frame.body("link", (0.1, 0.0, 0.0), turn)
    rng = np.random.default_rng(3)
    count = len(beams) // 3
    for k in range(count + 1):
        for side in range(2):
            place = np.array([float(side), 0.0, float(k)]) + rng.uniform(-0.2, 0.2, 3)
            if k > count // 2:
                frame.node(f"{side},{k}", np.transpose(turn) @ (place - [0.1, 0.0, 0.0]), "link")
            else:
                frame.node(f"{side},{k}", place)
    each = iter(beams)
    for k in range(1, count + 1):
        for side in range(2):
            frame.add(f"rail{side},{k}", next(each), f"{side},{k - 1}", f"{side},{k}")
        frame.add(f"rung{k}", next(each), f"0,{k}", f"1,{k}")
    frame.node("pinned", frame.position(f"1,{count}"))
    frame.add("pin", Joint(stiffness=(1e8, 1e8, 1e8, 1e5, 1e5, 1e3)), f"1,{count}", "pinned")
    frame.fix_many(["0,0", "1,0"])
    frame.load("pinned", fx=50.0, fy=[10.0, 20.0, 30.0], mz=5.0)
    frame.line_load("rung1", fz=-20.0, span=(0.1, 0.5))
    frame.point_load("rail1,2", at=0.3, fy=10.0)
    if weight:
        frame.gravity((0.0, 0.0, -9.81))
    return frame


def told(frame: Frame, read: str) -> list[Array]:
    solution = frame.solve("sparse" if read == "sparse" else None)
    members = list(frame.members)
    if read == "modes":
        return [frame.modes(4).frequencies]
    if read == "buckling":
        return [frame.buckling(2).factors]
    if read == "large":
        found = frame.solve(large=True)
        return [found.displacement("pinned"), *(found.forces(name, 0.1) for name in members[:5])]
    if read == "all":
        return [solution.displacements_at([0.0, 0.3]), solution.forces_at([0.5]), solution.all_end_forces()]
    if read == "stress":
        out = []
        for name in members:
            try:
                out.append(solution.stress(name, [0.0, 0.1]))
            except FrameError:
                out.append(np.zeros(()))
        return out
    if read == "words":
        return [solution.nonlinearity(), solution.condition_number(), solution.distance_to_singularity()]
    out = [solution.displacement("pinned"), solution.reaction("0,0"), solution.joint_force("pin")]
    return out + [solution.displacement_along(name, [0.05, 0.2]) for name in members[::5]]


READS = [("sparse", False), ("buckling", False), ("large", True), ("words", True), ("modes", True)]


@pytest.mark.parametrize(
    ("read", "batch"), [*READS, *((r, b) for r in ("one by one", "all", "stress") for b in (0, 1))]
)
def test_as_each_by_itself(read: str, batch: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    beams = kinds(np.random.default_rng(7), batch)
    heavy = read == "one by one"
    if heavy or read == "large":
        beams = [beam for beam in beams if beam.end is None]
    found = told(lattice(beams, weight=heavy), read)
    monkeypatch.setattr(Beam, "family", None)
    alone = lattice(beams, weight=heavy)
    wanted = told(alone, read)
    assert len(alone.solve().plan.topology.groups) == len(alone.members)
    # a stability that the stiffness leaves uncertain, and what large displacement iterates to, to their tolerance
    rough = {"words": 1e-6, "buckling": 1e-8, "large": 1e-7, "modes": 1e-9}.get(read, 1e-9)
    for mine, theirs in zip(found, wanted, strict=True):
        assert_allclose(mine, theirs, rtol=rough, atol=rough * np.abs(theirs).max(initial=0.0))


@pytest.mark.parametrize("batch", [False, True])
def test_bounds_hold_and_sensitivities_agree(batch: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    beams = kinds(np.random.default_rng(11), batch)
    stacked = lattice(beams).solve()
    value, bound = stacked.displacement("pinned"), stacked.error_bound("pinned")
    by = stacked.sensitivity("pinned", "uy")
    monkeypatch.setattr(Beam, "family", None)
    alone = lattice(beams).solve()
    other = alone.displacement("pinned")
    assert np.all(np.abs(value - other) <= bound + alone.error_bound("pinned"))
    assert_allclose(bound, alone.error_bound("pinned"), rtol=0.5)
    wanted = alone.sensitivity("pinned", "uy").members
    for name, mine in by.members.items():
        assert_allclose(mine, wanted[name], rtol=1e-8, atol=1e-10 * np.abs(wanted[name]).max())


def test_stacks_by_form() -> None:
    """By family, whatever the number of sections; a section of one's own, which may not take arrays, by itself."""
    frame = lattice(kinds(np.random.default_rng(5), batch=False))
    groups = frame.solve().plan.topology.groups
    assert sum(len(group.pieces) for group in groups) == len(frame.members)
    assert len(groups) < len(frame.members)

    class Own(Rectangle):
        """A section of one's own."""

    own = Frame()
    for k in range(4):
        own.node(str(k), (float(k), 0.0, 0.0))
    for k in range(3):
        own.add(str(k), Beam(Own(y=0.02 + 0.01 * k, z=0.02), STEEL), str(k), str(k + 1))
    assert len(own.solve().plan.topology.groups) == 3


def test_a_thousand_sections_cost_what_one_costs() -> None:
    def mast(sections: int, count: int = 300) -> float:
        bars = [Beam(Rectangle(y=0.03 + 1e-5 * k, z=0.02), STEEL) for k in range(sections)]
        best = np.inf
        for _ in range(3):
            frame = Frame()
            frame.add_nodes(count + 1, [(0.1 * k, float(k % 2), float(k)) for k in range(count + 1)])
            pairs = [(str(k), str(k + 1)) for k in range(count)]
            frame.add_many([bars[k % sections] for k in range(count)], pairs)
            frame.fix("0")
            frame.load(str(count), fx=1.0)
            start = time.process_time()
            solution = frame.solve("banded")
            solution.displacement(str(count))
            solution.all_end_forces()
            best = min(best, time.process_time() - start)
        return best

    assert mast(300) < 2.5 * mast(1)
