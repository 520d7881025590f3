"""Reliability under load by exact derivatives: as differences have it, and one solution for each point of a search."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from linkframe.elements import Beam, Material, Rectangle
from linkframe.framework import FrameError
from linkframe.models import Linkage
from linkframe.models.linkage.zone import _Margin
from numpy.testing import assert_allclose
from scipy import stats

Array = np.ndarray[Any, np.dtype[np.float64]]
NUMBERS = {"crank": 0.1, "stiffness": 5e6, "force": 100.0, "modulus": 200e9, "height": 0.02, "corner": 0.16}


def four_bar(
    crank: Array,
    stiffness: Array,
    force: Array,
    modulus: Array,
    height: Array,
    corner: Array,
    clearance: float | None = None,
) -> Linkage:
    """Everything of it is uncertain: points, pins, load across the plane as well, modulus, section."""
    crank, corner, stiffness, none = np.broadcast_arrays(crank, corner, stiffness, 0.0)
    pin = np.stack([*[stiffness] * 5, none], axis=-1)
    linkage = Linkage(
        A=(0, 0),
        B=np.stack([none, crank], axis=-1),
        P=(0.12, 0.19),
        D=np.stack([0.24 + none, corner], axis=-1),
        E=(0.22, 0),
    )
    beam = Beam(Rectangle(y=height, z=0.01), Material(E=modulus, nu=0.3))
    for name, ends in (("crank", "AB"), ("coupler", "BPD"), ("rocker", "DE")):
        linkage.link(name, *ends, beam=beam)
    linkage.revolute("A", "ground", "crank", drive=True)
    linkage.revolute("B", "crank", "coupler", stiffness=pin)
    linkage.revolute("D", "coupler", "rocker", stiffness=pin, clearance=clearance)
    linkage.revolute("E", "rocker", "ground", stiffness=pin)
    linkage.load("P", fy=force, fz=0.3 * force)
    return linkage


def given(names: str = " ".join(NUMBERS)) -> dict[str, Any]:
    fine = ("crank", "corner")
    return {name: stats.norm(NUMBERS[name], NUMBERS[name] * (1e-3 if name in fine else 0.05)) for name in names.split()}


@pytest.mark.parametrize("angles", [np.radians([10.0, 40.0]), 0.4])
def test_derivatives_of_the_place_under_load(angles: Array | float) -> None:
    """Against differences of fourth order, with and without an axis of poses."""
    motion = four_bar(**NUMBERS).move(A=angles)
    margin = _Margin(motion, "P", 1e-3, four_bar, given(), compliance=True)
    rng, n = np.random.default_rng(0), 4
    samples = {name: value * (1.0 + 5e-3 * rng.normal(size=n)) for name, value in NUMBERS.items()}
    pose = np.arange(n) % 2 if motion.shape else None
    left, slopes = margin.by_adjoint()(samples, pose)
    assert_allclose(left, margin(samples, pose), rtol=1e-12)
    for name, value in NUMBERS.items():
        step = 1e-4 * value
        a, b, c, d = (margin(samples | {name: samples[name] + k * step}, pose) for k in (-2.0, -1.0, 1.0, 2.0))
        assert_allclose(slopes[name], (8.0 * (c - b) - (d - a)) / (12.0 * step), rtol=2e-6, err_msg=name)


def cross(about: Array) -> Linkage:
    """An arm on a universal joint, ideal along one axis, each of whose two springs turns about an axis of its own."""
    linkage = Linkage(A=(0, 0), P=(1.2, 0.3))
    linkage.link("arm", "A", "P", beam=Beam(Rectangle(y=0.02, z=0.01), Material(E=200e9, nu=0.3)))
    springs = np.stack(np.broadcast_arrays(np.inf, 2e6, 4e6, 0.5 * about, 3e4, about), axis=-1)
    linkage.universal("A", "ground", "arm", axis=(0.2, 0.3, 1), second=(1, 0, -0.2), drive=True, stiffness=springs)
    linkage.load("P", fx=30.0, fy=100.0, fz=40.0)
    return linkage


def rod(across: Array) -> Linkage:
    """A rod between two balls, of which the first is stiffer in one direction where an input says so."""
    even = np.broadcast_to(5e4, np.shape(across))
    none = np.zeros_like(even)
    linkage = Linkage(A=(0, 0, 0), B=(0.05, 0.1, 0), P=(0.3, 0.25, 0.2), D=(0.4, 0, 0.1))
    for name, ends in (("crank", "AB"), ("rod", "BP"), ("rocker", "PD")):
        linkage.link(name, *ends, beam=Beam(Rectangle(y=0.02, z=0.01), Material(E=200e9, nu=0.3)))
    linkage.revolute("A", "ground", "crank", drive=True)
    linkage.spherical("B", "crank", "rod", stiffness=np.stack([across, even, even, none, none, none], axis=-1))
    linkage.spherical("P", "rod", "rocker", stiffness=(5e4, 5e4, 5e4, 0.0, 0.0, 0.0))
    linkage.revolute("D", "ground", "rocker", axis=(1, 0, 0.2))
    linkage.load("P", fx=30.0, fy=100.0, fz=40.0)
    return linkage


@pytest.mark.parametrize(("build", "name", "value"), [(cross, "about", 4e4), (rod, "across", 5e4)])
def test_derivatives_by_springs_that_the_frame_takes_apart_or_turns(build: Any, name: str, value: float) -> None:
    """Both springs of a cross count; those of a ball, even at the median and turned along the rod there, do not."""
    motion = build(np.float64(value)).move(A=(0.02, 0.3) if build is cross else 0.02)
    margin = _Margin(motion, "P", 1e-3, build, {name: stats.norm(value, 0.05 * value)}, compliance=True)
    samples, step = {name: np.array([value])}, 1e-3 * value
    _, slopes = margin.with_gradient(samples)
    a, b, c, d = (margin({name: samples[name] + k * step}) for k in (-2.0, -1.0, 1.0, 2.0))
    assert_allclose(slopes[name], (8.0 * (c - b) - (d - a)) / (12.0 * step), rtol=1e-4)


def test_the_same_index_from_a_few_of_the_solutions() -> None:
    few = given("crank stiffness force height")

    def built(**numbers: Array) -> Linkage:
        return four_bar(**{**NUMBERS, **numbers})

    motion = built(**{name: NUMBERS[name] for name in few}).move(A=np.radians([40.0]))
    limit = 1.6 * float(np.linalg.norm(motion.accuracy("P").total[..., :3], axis=-1).max())

    def found(**options: Any) -> Any:
        return motion.reliability("P", limit, built, few, compliance=True, method="form", starts=1, **options)

    exact, differences = found(gradient="adjoint"), found()
    assert_allclose(exact.beta, differences.beta, rtol=1e-8)
    assert differences.evaluations == 9 * exact.evaluations


def test_many_inputs_have_adjoints_by_themselves() -> None:
    """Two forces, or the same as a sum of many: with few inputs differences take less time."""

    def many(**forces: Array) -> Linkage:
        return four_bar(**{**NUMBERS, "force": sum(forces.values())})

    for count in (2, 120):
        forces = {f"force{k}": stats.norm(100.0 / count, 1.0) for k in range(count)}
        motion = many(**dict.fromkeys(forces, 100.0 / count)).move(A=0.4)
        margin = _Margin(motion, "P", 1e-3, many, forces, compliance=True)
        assert (margin.gradient is None) == (count == 2)

    def loose(**forces: Array) -> Linkage:
        return four_bar(**{**NUMBERS, "force": sum(forces.values())}, clearance=1e-5)

    assert _Margin(motion, "P", 1e-3, loose, forces, compliance=True).gradient is None


def test_a_torque_at_no_point_and_inputs_that_change_nothing() -> None:
    def twisted(torque: Array, idle: Array) -> Linkage:
        linkage = four_bar(**NUMBERS)
        linkage.torque("rocker", mz=torque)
        return linkage

    values = {"torque": 20.0, "idle": 1.0}
    margin = _Margin(twisted(**values).move(A=0.4), "P", 1e-3, twisted, dict.fromkeys(values, stats.norm()), True)
    samples = {name: np.full(3, value) for name, value in values.items()}
    _, slopes = margin.by_adjoint()(samples)
    above, below = (margin(samples | {"torque": samples["torque"] + step}) for step in (0.1, -0.1))
    assert_allclose(slopes["torque"], (above - below) / 0.2, rtol=1e-6)
    assert_allclose(slopes["idle"], np.zeros(3), rtol=0.0, atol=0.0)

    def same(idle: Array) -> Linkage:
        return four_bar(**NUMBERS)

    margin = _Margin(same(1.0).move(A=0.4), "P", 1e-3, same, {"idle": stats.norm()}, True)
    left, slopes = margin.with_gradient({"idle": np.ones(3)})
    assert left.shape == slopes["idle"].shape == (3,)


def test_loads_alone_leave_the_linkage_where_it_is() -> None:
    def loaded(force: Array) -> Linkage:
        return four_bar(**{**NUMBERS, "force": force})

    motion = loaded(NUMBERS["force"]).move(A=0.4)
    off = float(np.linalg.norm(motion.accuracy("P").total[:3]))
    found = motion.reliability(
        "P", 1.2 * off, loaded, given("force"), compliance=True, method="form", starts=1, gradient="adjoint"
    )
    # The deflection is in proportion to the force, which spreads by a twentieth; failure at the other side is far.
    assert_allclose(found.beta, 4.0, rtol=1e-8)


def test_what_adjoints_do_not_offer_is_told() -> None:
    def loose(**numbers: Array) -> Linkage:
        return four_bar(**numbers, clearance=1e-5)

    with pytest.raises(FrameError, match="gradient='adjoint': the displacement of 'P' has no adjoint derivatives"):
        four_bar(**NUMBERS).move(A=0.4).reliability("P", 1e-3, loose, given(), compliance=True, gradient="adjoint")


ARM = {"ratio": 0.3, "tilt": 0.1, "weight": 9.81, "density": 7800.0, "turn": 0.2}


def arm(**given: Array) -> Linkage:
    """An arm under its weight, of which what adjoints do not know of may be uncertain."""
    ratio, tilt, weight, density, turn, none = np.broadcast_arrays(*(ARM | given).values(), 0.0)
    linkage = Linkage(A=(0, 0), P=(1, 0))
    steel = Material(E=200e9, nu=ratio, density=density)
    up = np.stack([none, np.sin(turn), np.cos(turn)], axis=-1)
    linkage.link("arm", "A", "P", beam=Beam(Rectangle(y=0.02, z=0.01), steel, up=up))
    linkage.revolute("A", "ground", "arm", drive=True, axis=np.stack([np.sin(tilt), none, np.cos(tilt)], axis=-1))
    linkage.load("P", fy=10.0, mx=1.0)
    linkage.gravity(np.stack([none, none, -weight], axis=-1))
    return linkage


@pytest.mark.parametrize("name", ARM)
def test_by_what_adjoints_do_not_know(name: str) -> None:
    margin = _Margin(arm().move(A=0.3), "P", 1e-2, arm, {name: stats.norm(ARM[name], 0.01)}, compliance=True)
    with pytest.raises(FrameError, match="Poisson's ratio or gravity that vary"):
        margin.by_adjoint()
