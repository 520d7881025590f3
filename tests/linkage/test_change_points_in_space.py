"""Overconstrained linkages in space at their change points and dead points: as single poses and in a sweep."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.models import Linkage
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

BESIDE = np.array([0.0, 1e-12, -1e-9, 1e-3])
TURNED = Rotation.from_euler("xyz", (0.3, -0.7, 1.1))


def sarrus(theta: float, legs: int, upper: float, turned: Rotation = TURNED) -> Linkage:
    """A plate on legs of two hinged plates each, 1 and `upper` long, the lower of which stand at `theta`."""
    height = np.sin(theta) + np.sqrt(upper**2 - np.cos(theta) ** 2)
    heading = Rotation.from_euler("z", np.arange(legs)[:, None] * (np.pi / 2 if legs == 2 else 2.0 * np.pi / legs))
    linkage = Linkage(P=turned.apply((0.0, 0.0, height)))
    names = range(legs)
    for k in names:
        for name, place in {
            "A": (0.5, 0, 0),
            "B": (0.5 + np.cos(theta), 0, np.sin(theta)),
            "C": (0.5, 0, height),
        }.items():
            linkage.point(f"{name}{k}", turned.apply(heading[k].apply(place)))
    linkage.link("top", "P", *(f"C{k}" for k in names))
    for k in names:
        axis = turned.apply(heading[k].apply((0.0, -1.0, 0.0)))
        linkage.link(f"low {k}", f"A{k}", f"B{k}")
        linkage.link(f"up {k}", f"B{k}", f"C{k}")
        linkage.revolute(f"A{k}", "ground", f"low {k}", axis=axis, drive=k == 0, reference=theta)
        linkage.revolute(f"B{k}", f"low {k}", f"up {k}", axis=axis)
        linkage.revolute(f"C{k}", f"up {k}", "top", axis=axis)
    return linkage


def folds(rho, alpha: float):
    """Angles at the four creases of a Miura vertex with sectors α, π - α, π - α, α."""
    other = 2.0 * np.arctan(np.tan(rho / 2.0) / np.cos(alpha))
    return np.stack([rho, -other, -rho, -other], axis=-1)


def miura(alpha: float, rho: float, turned: Rotation = TURNED) -> Linkage:
    """Four panels about a vertex, the last of them the ground; crease 0 drives and is drawn folded by `rho`."""
    angles = folds(rho, alpha)
    here, creases = turned, []
    for angle, sector in zip(angles, (alpha, np.pi - alpha, np.pi - alpha, alpha), strict=True):
        creases.append(here.apply((1.0, 0.0, 0.0)))
        here = here * Rotation.from_euler("x", angle) * Rotation.from_euler("z", sector)
    assert_allclose((turned.inv() * here).magnitude(), 0.0, atol=1e-12)
    linkage = Linkage(V=(0, 0, 0), **{f"E{k}": crease for k, crease in enumerate(creases)})
    for k in range(3):
        linkage.link(f"panel {k}", "V", f"E{k}", f"E{k + 1}")
    names = ["ground", "panel 0", "panel 1", "panel 2", "ground"]
    for k, crease in enumerate(creases):
        linkage.revolute("V", *names[k : k + 2], axis=crease, name=f"crease {k}", drive=k == 0, reference=angles[k])
    return linkage


def assert_alone_as_in_a_sweep(
    linkage: Linkage, drive: str, values: np.ndarray, points: tuple[str, ...], passed: bool = True
):
    sweep = linkage.move({drive: values}, rates={drive: 1.0})
    for k, value in enumerate(values):
        alone = linkage.move({drive: value}, rates={drive: 1.0})
        assert alone.status == sweep.status[k]
        singular = bool(sweep.is_singular[k])
        for point in points:
            # in a dead point Newton's method leaves half the digits
            atol = 5e-9 if singular and not passed else 1e-12
            assert_allclose(alone.position(point), sweep.position(point)[k], rtol=0.0, atol=atol)
            if sweep.is_assembled[k] and not singular:
                assert_allclose(alone.velocity(point), sweep.velocity(point)[k], rtol=1e-6, atol=1e-9)
        if k % 4 == 0:
            for pair in sweep.mechanism.tree.cuts:
                wanted = sweep.coordinate(pair.name)[k]
                assert_allclose(alone.coordinate(pair.name), wanted, rtol=0.0, atol=1e-8)
            alone.reactions()
            alone.frame()
    return sweep


@pytest.mark.parametrize("legs", [2, 3])
def test_sarrus_stretched_and_folded(legs):
    """With plates of one length all legs are stretched at 90° and lie folded at 0: all change points, passed."""
    linkage = sarrus(0.7, legs, 1.0)
    values = np.concatenate([[0.3, 2.0, -0.4], np.pi / 2 + BESIDE, BESIDE])
    motion = assert_alone_as_in_a_sweep(linkage, "A0", values, ("P", "B1", "C1"))
    assert motion.is_assembled.all()
    assert motion.is_regular[:3].all()
    assert motion.is_singular[[3, 4, 5, 7, 8, 9]].all()
    height = TURNED.apply(2.0 * np.sin(values)[:, None] * (0.0, 0.0, 1.0))
    assert_allclose(motion.position("P"), height, rtol=0.0, atol=1e-12)


def test_sarrus_with_short_upper_plates():
    """Lower plates of 1 go down to where the upper ones, 0.9 long, lie level: a dead point, and no way beyond."""
    end = np.arccos(0.9)
    linkage = sarrus(0.7, 2, 0.9)
    values = np.concatenate([[0.6, 2.0, 0.0], np.pi / 2 + BESIDE, end + BESIDE])
    motion = assert_alone_as_in_a_sweep(linkage, "A0", values, ("P", "B1", "C1"), passed=False)
    assert motion.is_assembled.tolist() == [True, True, False] + 4 * [True] + [True, True, False, True]
    assert motion.is_singular[7]
    reached = motion.is_assembled
    height = np.sin(values) + np.sqrt(np.maximum(0.81 - np.cos(values) ** 2, 0.0))
    place = TURNED.apply(height[:, None] * (0.0, 0.0, 1.0))
    assert_allclose(motion.position("P")[reached], place[reached], rtol=0.0, atol=5e-8)


@pytest.mark.parametrize("alpha", [1.0, 1.3])
def test_miura_flat_and_folded(alpha):
    """Flat at 0 and folded upon itself at ±180°, where panels lie on each other: change points, passed."""
    linkage = miura(alpha, 0.8)
    values = np.concatenate([[0.3, -2.0], BESIDE, np.pi + BESIDE, -np.pi + BESIDE])
    motion = assert_alone_as_in_a_sweep(linkage, "crease 0", values, ("E1", "E2", "E3"))
    assert motion.is_assembled.all()
    assert motion.is_regular[:2].all()
    assert motion.is_singular[[2, 3, 4, 6, 7, 8, 10, 11, 12]].all()
    turned = np.stack([motion.coordinate(f"crease {k}")[:, 0] for k in range(4)], axis=-1)
    away = turned - folds(values, alpha)
    assert_allclose(np.sin(away / 2.0), 0.0, rtol=0.0, atol=1e-11)
