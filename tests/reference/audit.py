"""Laws that any motion of any linkage obeys, written without the code under test: joints, rates, equilibrium, power."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
from linkframe.models import Linkage, Motion
from numpy.testing import assert_allclose
from numpy.typing import NDArray

Array = NDArray[np.float64]
Path = Callable[[Array], Mapping[str, Array]]


def size_of(linkage: Linkage) -> float:
    """Greatest extent of the drawing along an axis."""
    places = np.stack([p.reshape(-1, 3)[0] for p in linkage.points.values()])
    return float(np.ptp(places, axis=0).max())


def joints_hold(linkage: Linkage, motion: Motion, tolerance: float = 1e-12) -> None:
    """Each joint, measured by its drawn axes carried on either link, holds what its kind holds."""
    size = size_of(linkage)
    for joint in linkage.joints.values():
        first, second = motion.axes(joint.first) @ joint.axes, motion.axes(joint.second) @ joint.axes
        gap = motion.position(joint.point, joint.second) - motion.position(joint.point, joint.first)
        along = np.einsum("...ji,...j->...i", first, gap) / size
        turn = np.swapaxes(first, -1, -2) @ second
        zero = {
            "revolute": (along, turn[..., :2, 2]),
            "prismatic": (along[..., :2], turn - np.eye(3)),
            "cylindrical": (along[..., :2], turn[..., :2, 2]),
            "spherical": (along,),
            "universal": (along, turn[..., 2, 0]),
            "planar": (along[..., 2], turn[..., :2, 2]),
            "screw": (along[..., :2], turn[..., :2, 2]),
            "fixed": (along, turn - np.eye(3)),
        }[joint.kind.name]
        for part in zero:
            assert_allclose(part, 0.0, atol=tolerance, err_msg=f"{joint.kind.name} {joint.name}")
        if joint.pitch is not None:
            advance = motion.coordinate(joint.name)[..., 0] - joint.reference[..., 0]
            expected = joint.pitch * advance / (2.0 * np.pi) / size
            assert_allclose(along[..., 2], expected, atol=tolerance, err_msg=joint.name)


def difference(values: Array, h: float) -> Array:
    """Derivative at the middle of five equidistant values."""
    return (values[0] - 8.0 * values[1] + 8.0 * values[3] - values[4]) / (12.0 * h)


def five(linkage: Linkage, path: Path, t: float, h: float) -> Motion:
    """The motion at t - 2 h ... t + 2 h, rates by differences of the path, reached from the drawing along the path."""
    times = t + h * np.arange(-2, 3)
    wide = {k: np.asarray([np.asarray(path(times + s * h)[k]) for s in (-2, -1, 0, 1, 2)]) for k in path(times)}
    rates = {k: difference(v, h) for k, v in wide.items()}
    bends = {k: (-v[0] + 16 * v[1] - 30 * v[2] + 16 * v[3] - v[4]) / (12 * h**2) for k, v in wide.items()}
    return linkage.move(path(times), rates=rates, accelerations=bends)


def rates_fit(linkage: Linkage, motion: Motion, h: float, tolerance: float, without: tuple[str, ...] = ()) -> None:
    """Velocities and accelerations of all links are the derivatives of their positions."""
    size = size_of(linkage)
    off = np.array([0.3, -0.2, 0.1]) * size
    for link in linkage.links:
        if link in without:
            continue
        place, v = motion.position_on(link, off), motion.velocity_on(link, off)
        a = motion.acceleration_on(link, off)
        unit = max(float(np.abs(v).max()), float(np.abs(a).max()) * 0.1, 1e-6 * size)
        assert_allclose(v[2] / unit, difference(place, h) / unit, atol=tolerance, err_msg=f"velocity of {link}")
        assert_allclose(
            a[2] / unit, difference(v, h) / unit, atol=10 * tolerance, rtol=1e-7, err_msg=f"acceleration of {link}"
        )
        turning = difference(motion.axes(link), h) @ motion.axes(link)[2].T
        omega = motion.angular_velocity(link)
        spin = (turning[2, 1], turning[0, 2], turning[1, 0])
        assert_allclose(omega[2], spin, atol=10 * tolerance, err_msg=f"turning of {link}")
        alpha = motion.angular_acceleration(link)[2]
        assert_allclose(alpha, difference(omega, h), atol=100 * tolerance, err_msg=f"angular acceleration of {link}")


def _about(force: Array, moment: Array, place: Array) -> Array:
    force, place = np.broadcast_arrays(force, place)
    return np.concatenate([force, moment + np.cross(place, force)], axis=-1)


def _mass(linkage: Linkage, name: str) -> tuple[float, Array, Array]:
    link = linkage.links[name]
    if link.mass is None:
        return 0.0, np.zeros(3), np.zeros((3, 3))
    centre = np.mean([linkage.points[p] for p in link.points], axis=0) if link.centre is None else link.centre
    return float(link.mass), centre, np.zeros((3, 3)) if link.inertia is None else link.inertia


def outside_wrenches(linkage: Linkage, motion: Motion, name: str) -> Array:
    """Loads, springs, dampers, weight and inertia of a link with a given mass, about the global origin, (..., 6)."""
    mass, centre, inertia = _mass(linkage, name)
    place, turn = motion.position_on(name, centre), motion.axes(name)
    about = turn @ inertia @ np.swapaxes(turn, -1, -2)
    w, alpha = motion.angular_velocity(name), motion.angular_acceleration(name)
    spin = np.einsum("...ij,...j->...i", about, w)
    torque = np.einsum("...ij,...j->...i", about, alpha) + np.cross(w, spin)
    total = _about(mass * (linkage.weight - motion.acceleration_on(name, centre)), -torque, place)
    for load in linkage.loads:
        if load.link == name:
            at = np.zeros(3) if load.point is None else motion.position(load.point, name)
            total = total + _about(load.value[..., :3], load.value[..., 3:], at)
    for spring in linkage.springs:
        for here, there in ((spring.first, spring.second), (spring.second, spring.first)):
            if here[0] == name:
                p, q = (motion.position(point, link) for link, point in (here, there))
                v, u = (motion.velocity(point, link) for link, point in (here, there))
                length = np.linalg.norm(q - p, axis=-1)
                along = (q - p) / length[..., None]
                speed = np.einsum("...i,...i->...", u - v, along)
                pull = spring.stiffness * (length - spring.length) + spring.damping * speed
                total = total + _about(pull[..., None] * along, np.zeros(3), p)
    return total


def in_equilibrium(linkage: Linkage, motion: Motion, tolerance: float = 1e-9) -> None:
    """Newton and Euler for every link; joints transmit no power beside their drives'; power balance of the whole."""
    reactions = motion.reactions()
    size = size_of(linkage)
    balance = {name: outside_wrenches(linkage, motion, name) for name in linkage.links}
    scale = 1e-300
    for joint in linkage.joints.values():
        wrench = reactions.force(joint.name)
        at = motion.position(joint.point, joint.second)
        about = _about(wrench[..., :3], wrench[..., 3:], at)
        scale = max(scale, float(np.abs(wrench[..., :3]).max()), float(np.abs(wrench[..., 3:]).max()) / size)
        for name, sign in ((joint.first, -1.0), (joint.second, 1.0)):
            if name in balance:
                balance[name] = balance[name] + sign * about
    unit = scale * np.array([1, 1, 1, size, size, size])
    for name, rest in balance.items():
        assert_allclose(rest / unit, 0.0, atol=tolerance, err_msg=f"equilibrium of {name}")
    for joint in linkage.joints.values():
        wrench = reactions.force(joint.name)
        v = [motion.velocity_on(link, np.zeros(3)) for link in (joint.first, joint.second)]
        w = [motion.angular_velocity(link) for link in (joint.first, joint.second)]
        at = motion.position(joint.point, joint.second)
        origins = [motion.origin(link) for link in (joint.first, joint.second)]
        slip = v[1] + np.cross(w[1], at - origins[1]) - v[0] - np.cross(w[0], at - origins[0])
        power = np.sum(wrench[..., :3] * slip, axis=-1) + np.sum(wrench[..., 3:] * (w[1] - w[0]), axis=-1)
        driven = np.zeros(())
        if joint.name in linkage.drives:
            rates = motion.coordinate_rate(joint.name)
            which = [joint.kind.coordinates.index(k) for k in linkage.drives[joint.name]]
            driven = np.sum(reactions.drive(joint.name) * rates[..., which], axis=-1)
        speed = max(float(np.abs(slip).max()), size * float(np.abs(np.asarray(w)).max()), 1e-300)
        assert_allclose((power - driven) / (scale * speed), 0.0, atol=tolerance, err_msg=f"power of {joint.name}")


def audit(
    linkage: Linkage,
    path: Path,
    t: float = 0.3,
    h: float = 2e-3,
    tolerance: float = 1e-8,
    without: tuple[str, ...] = (),
) -> Motion:
    """All of it at one time of a path of the drives; the links `without` a rate of their own are left out."""
    motion = five(linkage, path, t, h)
    assert np.all(motion.is_assembled), motion.status
    joints_hold(linkage, motion)
    for joint, driven in linkage.drives.items():
        which = [linkage.joint(joint).kind.coordinates.index(k) for k in driven]
        wanted = np.asarray(path(t + h * np.arange(-2, 3))[joint])
        wanted = wanted[:, None] if wanted.ndim == 1 else wanted
        assert_allclose(motion.coordinate(joint)[..., which], wanted, rtol=1e-13, atol=1e-12 * size_of(linkage))
    rates_fit(linkage, motion, h, tolerance, without)
    if not without:
        in_equilibrium(linkage, motion)
    return motion
