"""Velocities and accelerations against differences of positions, for every kind of joint, on the tree and off it."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.models import Linkage
from numpy.testing import assert_allclose
from reference.linkages import bennett, four_bar, rssr
from reference.spatial import spatial_slider_crank, stewart

H = 2e-3
OFF_AXIS = np.array([0.3, -0.2, 0.5])


def sliders():
    """A loop of a hinge and three cylinders, random in space."""
    rng = np.random.default_rng(5)
    linkage = Linkage({f"P{k}": p for k, p in enumerate(rng.uniform(-1, 1, (4, 3)))})
    axes = rng.normal(size=(4, 3))
    chain = ["ground", "a", "b", "c", "ground"]
    for k in range(3):
        linkage.link(chain[k + 1], f"P{k}", f"P{k + 1}")
    linkage.revolute("P0", "ground", "a", axis=axes[0], drive=True)
    for k in range(1, 4):
        linkage.cylindrical(f"P{k}", chain[k], chain[k + 1], axis=axes[k])
    return linkage


def table():
    """A link that slides and turns on a table, carried by a crank; turned by a drive of its own."""
    linkage = Linkage(A=(0, 0, 0), B=(1, 0, 0.1), C=(0.5, 1, 0.2))
    linkage.link("crank", "A", "B")
    linkage.link("plate", "B", "C")
    linkage.revolute("A", "ground", "crank", drive=True)
    linkage.revolute("B", "crank", "plate")
    linkage.planar("C", "ground", "plate", drive="rz")
    return linkage


def jack():
    """A spindle with a nut in a slide."""
    linkage = Linkage(A=(0, 0, 0), B=(0, 0, 1))
    linkage.link("spindle", "A", "B")
    linkage.link("nut", "B")
    linkage.revolute("A", "ground", "spindle", drive=True)
    linkage.screw("B", "spindle", "nut", axis=(0, 0, 1), pitch=0.3)
    linkage.prismatic("B", "ground", "nut", axis=(0, 0, 1))
    return linkage


LINKAGES = {
    "four-bar": lambda: four_bar(2, 7, 9, 6, 0.5),
    "Bennett": lambda: bennett(0.5, 1.2, 1.0),
    "RSSR": lambda: rssr(0.4, 1.2, 1.0, (0.7, 0.9, 0.3), 0.8),
    "RUSR": lambda: rssr(0.4, 1.2, 1.0, (0.7, 0.9, 0.3), 0.8, universal=True),
    "slider-crank": spatial_slider_crank,
    "Stewart": lambda: stewart()[0],
    "cylinders": sliders,
    "table": table,
    "jack": jack,
}


def difference(values):
    """Derivative at the middle of five equidistant values."""
    return (values[0] - 8.0 * values[1] + 8.0 * values[3] - values[4]) / (12.0 * H)


@pytest.mark.parametrize("name", LINKAGES)
def test_rates_are_derivatives_of_positions(name):
    linkage = LINKAGES[name]()
    rng = np.random.default_rng(1)
    t = H * np.arange(-2, 3)
    values, rates, accelerations = {}, {}, {}
    for joint, driven in linkage.drives.items():
        pair = linkage.joint(joint)
        start = pair.reference[..., pair.kind.coordinates.index(driven[0])]
        v, w = rng.uniform(0.2, 1.0, 2)
        values[joint] = start + 0.01 + v * t + 0.5 * w * t**2
        rates[joint], accelerations[joint] = v + w * t, w
    motion = linkage.move(values, rates=rates, accelerations=accelerations)
    assert np.all(motion.closure_status == "regular")
    for link in linkage.links:
        spins = name == "RSSR" and link == "rod"  # nothing says how
        place = linkage.points["B"] + 0.3 * (linkage.points["D"] - linkage.points["B"]) if spins else OFF_AXIS
        position, velocity = motion.position_on(link, place), motion.velocity_on(link, place)
        assert_allclose(velocity[2], difference(position), atol=2e-8)
        assert_allclose(motion.acceleration_on(link, place)[2], difference(velocity), atol=2e-7)
        if spins:
            continue
        turning = difference(motion.axes(link)) @ motion.axes(link)[2].T
        omega = motion.angular_velocity(link)
        assert_allclose(omega[2], (turning[2, 1], turning[0, 2], turning[1, 0]), atol=2e-8)
        assert_allclose(motion.angular_acceleration(link)[2], difference(omega), atol=2e-7)
    for joint, pair in linkage.joints.items():
        rate = motion.coordinate_rate(joint)
        if name == "RSSR" and pair.kind.name == "spherical":
            continue
        if pair.kind.name != "spherical":
            assert_allclose(rate[2], difference(motion.coordinate(joint)), atol=2e-7)
        assert_allclose(motion.coordinate_acceleration(joint)[2], difference(rate), atol=2e-6)


@pytest.mark.parametrize("name", LINKAGES)
def test_joints_hold_what_they_hold(name):
    linkage = LINKAGES[name]()
    values = {
        joint: linkage.joint(joint).reference[0 if len(driven) == len(linkage.joint(joint).reference) else -1]
        + np.array([0.0, 0.02])
        for joint, driven in linkage.drives.items()
    }
    motion = linkage.move(values)
    for joint, pair in linkage.joints.items():
        axes = motion.joint_axes(joint)
        assert_allclose(np.swapaxes(axes, -1, -2) @ axes, np.broadcast_to(np.eye(3), (2, 3, 3)), atol=1e-14)
        apart = motion.position(pair.point, pair.second) - motion.position(pair.point, pair.first)
        along = np.einsum("pji,pj->pi", axes, apart)
        held = [k for k, component in enumerate(("ux", "uy", "uz")) if component in pair.kind.constrained]
        if pair.kind.name != "screw":
            assert_allclose(along[:, held], 0.0, atol=1e-13)
        if pair.kind.name in ("revolute", "cylindrical", "planar", "screw"):
            z = (motion.axes(pair.second) @ pair.axes)[..., 2]
            assert_allclose(z, axes[..., 2], atol=1e-13)
