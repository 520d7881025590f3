"""Whatever is described, in whatever order, is answered or refused in words: no other exception leaves the library."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Collection
from contextlib import suppress
from typing import Any

import numpy as np
import pytest
from linkframe.elements import Beam, Joint, Material, PointMass, Rectangle, Spring
from linkframe.framework import Frame, FrameError
from linkframe.framework.dofs import DISPLACEMENTS, FORCES
from linkframe.models import Linkage
from linkframe.models.linkage import Motion
from numpy.typing import NDArray

Rng = np.random.Generator
Array = NDArray[np.float64]
STEEL = Material(E=200e9, nu=0.3, density=7850.0)
BAR = Beam(Rectangle(y=0.03, z=0.02), STEEL)
# Most of a description does not vary; some of it does, over batches that do not fit, or have no entries.
SHAPES = [()] * 14 + [(3,), (1,), (2, 1), (0,)]
METHODS = (None, "broadcast", "banded", "sparse", "iterative")
KINDS = ("displacement", "reaction", "joint_displacement", "joint_force", "end_forces")


def some(rng: Rng, mean: float, spread: float) -> Array:
    """A number, or a batch of them."""
    shape = SHAPES[rng.integers(len(SHAPES))]
    return mean + spread * np.asarray(rng.uniform(-1.0, 1.0, shape))


def one(rng: Rng, names: Collection[str]) -> str:
    """One of the names, or where there are none one that is unknown."""
    return str(rng.choice(sorted(names))) if names else "none"


# -- frames ---------------------------------------------------------------------------------------------------------


def place(rng: Rng, frame: Frame) -> Array:
    """A node's position on a coarse lattice, every third where another node is, some in batches."""
    if frame.nodes and rng.random() < 0.35:
        return frame.position(one(rng, frame.nodes))
    lattice = rng.integers(-2, 3, 3).astype(float)
    return lattice if rng.random() < 0.9 else lattice + np.asarray(some(rng, 0.0, 0.1))[..., None]


def beam(rng: Rng) -> Beam:
    releases = [f"{end} {name}" for end in ("start", "end") for name in DISPLACEMENTS]
    released = tuple(rng.choice(releases, 2, replace=False).tolist()) if rng.random() < 0.2 else ()
    steel = STEEL if rng.random() < 0.8 else Material(E=np.abs(some(rng, 2e11, 1e10)), nu=0.3, density=7850.0)
    return Beam(BAR.section, steel, release=released, segments=int(rng.integers(1, 3)))


def joint(rng: Rng) -> Joint:
    stiffness = [rng.choice([0.0, np.inf, 1e4, 1e9]) for _ in range(6)]
    return Joint(stiffness, clearance=1e-4 if rng.random() < 0.2 else 0.0)


EDITS: tuple[Callable[[Rng, Frame, str], object], ...] = (
    lambda rng, f, name: f.node(name, place(rng, f)),
    lambda rng, f, name: f.node(name, place(rng, f)),
    lambda rng, f, name: f.add(name, beam(rng), one(rng, f.nodes), one(rng, f.nodes)),
    lambda rng, f, name: f.add(name, beam(rng), one(rng, f.nodes), one(rng, f.nodes)),
    lambda rng, f, name: f.add(name, joint(rng), one(rng, f.nodes), one(rng, f.nodes)),
    lambda rng, f, name: f.add(name, PointMass(float(rng.uniform(0.0, 2.0))), one(rng, f.nodes)),
    lambda rng, f, _: f.rigid(one(rng, f.nodes), one(rng, f.nodes)),
    lambda rng, f, _: f.tie(one(rng, f.nodes), one(rng, f.nodes), one(rng, DISPLACEMENTS)),
    lambda rng, f, _: f.fix(one(rng, f.nodes)),
    lambda rng, f, _: f.fix(one(rng, f.nodes), *rng.choice(DISPLACEMENTS, 3, replace=False).tolist()),
    lambda rng, f, _: f.prescribe(one(rng, f.nodes), **{one(rng, DISPLACEMENTS): some(rng, 0.0, 1e-3)}),
    lambda rng, f, _: f.offset(one(rng, f.joints), **{one(rng, DISPLACEMENTS): some(rng, 0.0, 1e-3)}),
    lambda rng, f, _: f.load(one(rng, f.nodes), **{one(rng, FORCES): some(rng, 0.0, 10.0)}),
    lambda rng, f, _: f.line_load(one(rng, f.members), **{one(rng, FORCES[:3]): some(rng, 0.0, 1.0)}),
    lambda rng, f, _: f.point_load(one(rng, f.members), at=0.5, **{one(rng, FORCES): some(rng, 0.0, 1.0)}),
    lambda rng, f, _: f.gravity((0.0, 0.0, -9.81)) if rng.random() < 0.5 else None,
    lambda rng, f, _: f.change(one(rng, f.members), beam(rng)),
    lambda rng, f, _: f.change(one(rng, f.joints), joint(rng)),
    lambda rng, f, _: f.change(one(rng, f.nodes), place(rng, f)),
    lambda rng, f, _: f.set_load(one(rng, f.nodes), **{one(rng, FORCES): some(rng, 0.0, 10.0)}),
    lambda rng, f, _: f.unload(one(rng, f.nodes)) if rng.random() < 0.3 else None,
    lambda rng, f, name: f.add_nodes([name, f"{name} too"], [place(rng, f), place(rng, f)]),
    lambda rng, f, name: f.add_many(beam(rng), [(one(rng, f.nodes), one(rng, f.nodes))], [name]),
    lambda rng, f, _: f.load_many([one(rng, f.nodes)] * 2, **{one(rng, FORCES): some(rng, 0.0, 10.0)}),
    lambda rng, f, _: f.fix_many([one(rng, f.nodes)], one(rng, DISPLACEMENTS)),
    lambda rng, f, _: f.exclude(rng.random(f.shape) < 0.5) if rng.random() < 0.2 else None,
)


def named(rng: Rng, frame: Frame, kind: str) -> str:
    of = {"reaction": frame.supports, "joint_displacement": frame.joints, "joint_force": frame.joints}
    names: dict[str, Collection[str]] = {**of, "displacement": frame.nodes, "end_forces": frame.members}
    return one(rng, names[kind])


def ask(rng: Rng, frame: Frame, asked: int) -> object:
    """One of the questions to a frame."""
    if asked < 2:
        return (frame.modes, frame.buckling)[asked](1)
    solution = frame.solve(METHODS[rng.integers(len(METHODS))], clearance=bool(rng.random() < 0.5))
    kind, name = (kind := one(rng, KINDS)), named(rng, frame, kind)
    component = one(rng, FORCES if kind in ("reaction", "joint_force") else DISPLACEMENTS)
    entry = [0] * len(frame.shape)
    questions: tuple[Callable[[], object], ...] = (
        lambda: getattr(solution, kind)(name),
        lambda: solution.status,
        lambda: solution.error_bound(name, kind),
        lambda: solution.refined(name, kind),
        lambda: solution.sensitivity(name, component, kind),
        lambda: solution.linear,
        lambda: solution.distance_to_singularity(),
        lambda: solution.scaled_condition_number(),
        lambda: solution.condition_number(),
        lambda: solution.mechanism(*entry),
        lambda: solution.free_motion(*entry),
        lambda: solution.stress(one(rng, frame.members), [0.0, 0.5]),
        solution.explain,
    )
    return questions[asked % len(questions)]()


@pytest.mark.parametrize("seed", range(64))
def test_frames(seed: int) -> None:
    """Random edits, of which some are refused, then every fourth question."""
    rng, frame = np.random.default_rng(seed), Frame()
    for number in range(int(rng.integers(0, 40))):
        with suppress(FrameError):
            EDITS[rng.integers(len(EDITS))](rng, frame, f"part {number}")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for asked in range(seed % 4, 16, 4):
            with suppress(FrameError):
                ask(rng, frame, asked)


# -- linkages -------------------------------------------------------------------------------------------------------


def four_bar(rng: Rng) -> Linkage:
    """A four-bar whose points, masses, beams, loads and springs may each carry a batch."""
    drawn = {"A": (0.0, 0.0), "B": (0.0, 0.1), "P": (0.12, 0.19), "D": (0.24, 0.16), "E": (0.22, 0.0)}
    points = {name: np.asarray(at) + np.asarray(some(rng, 0.0, 1e-3))[..., None] for name, at in drawn.items()}
    linkage = Linkage({name: points[name] if rng.random() < 0.3 else at for name, at in drawn.items()})
    for name, on in {"crank": "AB", "coupler": "BPD", "rocker": "DE"}.items():
        mass: dict[str, Any] = {"mass": some(rng, 1.0, 0.1)} if rng.random() < 0.4 else {}
        linkage.link(name, *on, beam=beam(rng) if rng.random() < 0.6 else None, **mass)
    linkage.revolute("A", "ground", "crank", drive=True)
    linkage.revolute("B", "crank", "coupler", stiffness=(2e8,) * 5 + (0.0,))
    linkage.revolute("D", "coupler", "rocker", clearance=1e-4 if rng.random() < 0.3 else None)
    linkage.revolute("E", "rocker", "ground")
    with suppress(FrameError):
        linkage.load("P", fx=some(rng, 10.0, 1.0), fy=some(rng, -5.0, 1.0))
    linkage.torque("rocker", mz=some(rng, 1.0, 0.1))
    linkage.spring(("ground", "A"), ("coupler", "P"), stiffness=some(rng, 100.0, 10.0), length=some(rng, 0.1, 0.01))
    return linkage


QUESTIONS: tuple[Callable[[Rng, Motion], object], ...] = (
    lambda rng, m: m.reactions().drive("A"),
    lambda rng, m: m.acceleration("P"),
    lambda rng, m: m.status,
    lambda rng, m: m.frequencies(2),
    lambda rng, m: m.stress("coupler").envelope,
    lambda rng, m: m.frame(inertia=True).solve().displacement("P"),
    lambda rng, m: m.accuracy("P", fx=some(rng, 1.0, 1.0)).compliance,
    lambda rng, m: m.stiffness("P"),
    lambda rng, m: m.free_accelerations({"A": some(rng, 1.0, 0.5)}),
    lambda rng, m: m.kinetic_energy(),
    lambda rng, m: m.transmission_angle("D"),
)


@pytest.mark.parametrize("seed", range(12))
def test_linkages(seed: int) -> None:
    """Geometry, drives, rates, masses, loads of batches that may fit or not."""
    rng = np.random.default_rng(seed)
    with suppress(FrameError), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        linkage = four_bar(rng)
        motion = linkage.move(A=some(rng, 0.0, 0.5), rates={"A": some(rng, 1.0, 0.5)})
        for question in QUESTIONS[seed % 3 :: 3]:
            with suppress(FrameError):
                question(rng, motion)


# -- causes, one by one ---------------------------------------------------------------------------------------------


def spinning(*masses: float) -> Frame:
    """A clamped beam, and beyond a ball joint a node of a mass that turns without inertia."""
    frame = Frame()
    for name, x in {"A": 0.0, "B": 1.0, "C": 1.0}.items():
        frame.node(name, (x, 0.0, 0.0))
    frame.add("AB", BAR, "A", "B")
    frame.add("ball", Joint(stiffness=(np.inf,) * 3 + (0.0,) * 3), "B", "C")
    frame.add("mass", PointMass(np.asarray(masses) if len(masses) > 1 else masses[0]), "C")
    frame.fix("A")
    return frame


@pytest.mark.parametrize("masses", [(1.0,), (1.0, 2.0, 3.0)])
def test_what_turns_without_inertia_is_no_mode(masses: tuple[float, ...]) -> None:
    """The frequencies are those of the mass on the beam's end itself."""
    frame = spinning(*masses)
    direct = Frame()
    for name, x in {"A": 0.0, "B": 1.0}.items():
        direct.node(name, (x, 0.0, 0.0))
    direct.add("AB", BAR, "A", "B")
    direct.add("mass", PointMass(np.asarray(masses) if len(masses) > 1 else masses[0]), "B")
    direct.fix("A")
    found = frame.modes(6).frequencies
    np.testing.assert_allclose(found, direct.modes(6).frequencies, rtol=1e-9)
    with pytest.raises(FrameError, match="fewer modes"):
        frame.modes(9)


@pytest.mark.parametrize("method", ["banded", "sparse", "iterative"])
def test_nothing_to_solve_is_answered(method: str) -> None:
    """All held, or not loaded: every answer is zero, with a bound of zero, by all ways alike."""
    frame = Frame()
    for name, x in {"A": 0.0, "B": 1.0}.items():
        frame.node(name, (x, 0.0, 0.0))
    frame.add("AB", BAR, "A", "B")
    frame.fix("A")
    for _ in range(2):
        solution, plain = frame.solve(method), frame.solve("broadcast")
        for kind, name in (("displacement", "B"), ("reaction", "A"), ("end_forces", "AB")):
            np.testing.assert_array_equal(solution.error_bound(name, kind), 0.0)
            np.testing.assert_array_equal(np.array(solution.refined(name, kind)), 0.0)
        assert solution.linear == plain.linear
        np.testing.assert_allclose(solution.distance_to_singularity(), plain.distance_to_singularity(), rtol=1e-12)
        assert solution.sensitivity("B", "uy").loads["B"].shape == (6,)
        frame.fix("B")


def test_free_accelerations_under_a_batch_of_loads() -> None:
    """As many load cases as there are drives and one more are not taken for their unit accelerations."""

    def arm(load: Array) -> Linkage:
        linkage = Linkage(A=(0.0, 0.0), B=(0.3, 0.0), C=(0.3, 0.2))
        for name, on in {"a": "AB", "b": "BC"}.items():
            linkage.link(name, *on, mass=1.0, inertia=0.1)
        linkage.revolute("A", "ground", "a", drive=True)
        linkage.revolute("B", "a", "b", drive=True)
        linkage.load("C", fx=load)
        return linkage

    loads = np.array([0.0, 3.0, 7.0])
    found = arm(loads).move(A=0.1, B=0.2).free_accelerations()
    for k, load in enumerate(loads):
        single = arm(np.asarray(load)).move(A=0.1, B=0.2).free_accelerations()
        for joint in "AB":
            np.testing.assert_allclose(found[joint][k], single[joint], rtol=1e-12)


def test_frequencies_of_a_frame_whose_springs_push() -> None:
    """In a batch, the entries that a pushing spring pushes over have none."""
    frame = Frame()
    for name, x in {"A": 0.0, "B": 1.0}.items():
        frame.node(name, (x, 0.0, 0.0))
    push = np.array([0.0, -1.0, -1e9])
    frame.node("C", (2.0, 0.0, 0.0))
    frame.add("AB", BAR, "A", "B")
    frame.add("spring", Spring(10.0, push), "B", "C")
    frame.fix("A")
    frame.fix("C")
    with pytest.warns(UserWarning, match=r"1 of 3 batch entries, the first \[2\], are unstable"):
        found = frame.modes(2).frequencies
    assert np.isfinite(found[:2]).all()
    assert np.isnan(found[2]).all()
    assert found[1, 0] < found[0, 0]
