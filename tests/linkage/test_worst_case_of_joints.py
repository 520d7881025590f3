"""What clearance lets each kind of joint do: closed forms and samples by a few lines of vector algebra of its own."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from linkframe.framework import FrameError
from linkframe.models import Linkage
from numpy.testing import assert_allclose

Array = np.ndarray[Any, np.dtype[np.float64]]
# Clearance, length of the bearing, end play, and the arm from the joint to the point.
EPS, LENGTH, PLAY, ARM = 1e-4, 0.04, 2e-4, np.array([0.3, -0.2, 0.1])
X, Y, Z = np.eye(3)
Deviations = list[tuple[int, Callable[[Array], Array]]]


def ends(axis: Array, arm: Array, length: float) -> Deviations:
    """Displacement of the point by unit shares of the offsets of both ends of a bearing, each in a disc."""
    first = np.cross(axis, X if abs(axis[0]) < 0.9 else Y)
    first /= np.linalg.norm(first)
    basis = np.stack([first, np.cross(axis, first)])

    def end(side: float) -> Callable[[Array], Array]:
        def moved(share: Array) -> Array:
            offset = EPS * share @ basis
            return 0.5 * offset + np.cross(side * np.cross(axis, offset) / length, arm)

        return moved

    return [(2, end(1.0)), (2, end(-1.0))]


def along(axis: Array) -> Deviations:
    return [(1, lambda share: PLAY * share * axis)]


def anywhere() -> Deviations:
    return [(3, lambda share: EPS * share)]


def across_a_plane() -> Deviations:
    return [(1, lambda share: EPS * share * Z)]


def one_joint(kind: str) -> tuple[Linkage, dict[str, Any], Deviations]:
    """An arm that a joint at the origin, all of its coordinates driven, holds to the ground."""
    linkage = Linkage(J=(0, 0, 0), P=ARM)
    linkage.link("arm", "J", "P")
    make, more = getattr(linkage, kind), {}
    if kind == "universal":
        more = {"axis": Z, "second": X}
    elif kind == "screw":
        more = {"axis": Z, "pitch": 0.01}
    elif kind != "spherical":
        more = {"axis": Z}
    make("J", "ground", "arm", drive=True, **more)
    given: dict[str, Any] = {"clearances": {"J": EPS}}
    if kind not in ("spherical", "planar"):
        given["journals"] = {"J": LENGTH}
    if kind in ("revolute", "universal", "screw"):
        given["end_play"] = {"J": PLAY}
    moves = {
        "spherical": anywhere(),
        "planar": across_a_plane(),
        "universal": [*ends(Z, ARM, LENGTH), *ends(X, ARM, LENGTH), *along(Z), *along(X)],
        "revolute": [*ends(Z, ARM, LENGTH), *along(Z)],
        "screw": [*ends(Z, ARM, LENGTH), *along(Z)],
    }.get(kind, ends(Z, ARM, LENGTH))
    return linkage, given, moves


@pytest.mark.parametrize("kind", ["revolute", "prismatic", "cylindrical", "screw", "universal", "spherical", "planar"])
def test_samples_never_lie_outside_and_adversarial_ones_touch(kind: str) -> None:
    """10^5 random deviations, and in each direction those that are the worst by themselves."""
    linkage, given, moves = one_joint(kind)
    worst = linkage.move().worst_case("P", **given)
    rng, n = np.random.default_rng(0), 100_000
    total = np.zeros((n, 3))
    for size, moved in moves:
        share = rng.normal(size=(n, size))
        share *= (rng.uniform(size=n) ** (0.2 / size) / np.linalg.norm(share, axis=1))[:, None]
        total += moved(share)
    directions = rng.normal(size=(60, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    reach = worst.support(directions)
    assert (total @ directions.T).max(axis=0) == pytest.approx(reach, rel=0.5, abs=EPS)
    assert np.all(total @ directions.T <= reach * (1.0 + 1e-12) + 1e-18)
    # The worst of each deviation is along its own gradient: the closed form, sum of eps |J^T n|.
    extreme = np.zeros(60)
    for size, moved in moves:
        columns = np.stack([moved(unit) for unit in np.eye(size)])
        extreme += np.linalg.norm(directions @ columns.T, axis=1)
    assert_allclose(reach, extreme, rtol=1e-12, atol=1e-18)


def test_a_cross_tilts_in_both_of_its_bearings() -> None:
    """Along y, across both pins: each bearing lets the link tilt by 2 ε / L about what the other leaves free."""
    linkage, given, _ = one_joint("universal")
    worst = linkage.move().worst_case("P", **given)
    assert_allclose(worst.rotation.support(Z), 2.0 * EPS / LENGTH, rtol=1e-12)
    assert_allclose(worst.rotation.support(X), 2.0 * EPS / LENGTH, rtol=1e-12)
    assert_allclose(worst.rotation.support(Y), 2.0 * (2.0 * EPS / LENGTH), rtol=1e-12)
    pair = linkage.move().worst_case("P", clearances={"J": EPS}, journals={"J": (LENGTH, 2.0 * LENGTH)})
    assert_allclose(pair.rotation.support(Z), EPS / LENGTH, rtol=1e-12)
    assert_allclose(pair.rotation.support(X), 2.0 * EPS / LENGTH, rtol=1e-12)
    assert_allclose(pair.rotation.support(Y), 3.0 * EPS / LENGTH, rtol=1e-12)
    assert "joint J" in repr(pair)


def drive_line(as_pins: bool) -> Linkage:
    """A crank, a rod on a universal joint and a ball, and a slider; the joint may be a cross with two pins."""
    linkage = Linkage(A=(0, 0, 0), B=(0.1, 0.02, 0.03), C=(0.4, 0.05, 0.1), P=(0.5, 0.02, 0.12))
    linkage.link("crank", "A", "B")
    linkage.link("rod", "B", "C")
    linkage.link("slider", "C", "P")
    linkage.revolute("A", "ground", "crank", axis=(0.1, 0.0, 1.0), drive=True)
    axis, second = np.array([0.0, 0.6, 0.8]), np.array([1.0, 0.0, 0.0])
    if as_pins:
        linkage.link("cross", "B")
        linkage.revolute("B", "crank", "cross", axis=axis, name="U1")
        linkage.revolute("B", "cross", "rod", axis=second, name="U2")
    else:
        linkage.universal("B", "crank", "rod", axis=axis, second=second, name="U")
    linkage.spherical("C", "rod", "slider")
    linkage.prismatic("C", "ground", "slider", axis=(1, 0, 0), name="slide")
    return linkage


def test_in_a_loop_a_universal_joint_is_two_pins() -> None:
    angles = np.array([0.2, 0.0, 0.5])
    cross = drive_line(as_pins=True).move(A=angles)
    pins = cross.worst_case(
        "P",
        clearances={"U1": EPS, "U2": EPS},
        journals={"U1": LENGTH, "U2": 0.5 * LENGTH},
        end_play={"U1": PLAY, "U2": 0.5 * PLAY},
    )
    whole = drive_line(as_pins=False).move(A=angles)
    found = whole.worst_case(
        "P", clearances={"U": EPS}, journals={"U": (LENGTH, 0.5 * LENGTH)}, end_play={"U": (PLAY, 0.5 * PLAY)}
    )
    assert_allclose(found.greatest, pins.greatest, rtol=1e-9)
    assert np.all(found.greatest > EPS)
    rod = [
        motion.worst_case("C", "rod", clearances=dict.fromkeys(names, EPS), journals=dict.fromkeys(names, LENGTH))
        for motion, names in ((whole, ("U",)), (cross, ("U1", "U2")))
    ]
    directions = np.random.default_rng(1).normal(size=(20, 1, 3))
    assert_allclose(rod[0].support(directions), rod[1].support(directions), rtol=1e-9)


def test_what_is_refused() -> None:
    linkage, _, _ = one_joint("revolute")
    with pytest.raises(FrameError, match="a revolute joint has one, not a pair"):
        linkage.move().worst_case("P", clearances={"J": EPS}, journals={"J": (LENGTH, LENGTH)})
    linkage, _, _ = one_joint("universal")
    with pytest.raises(FrameError, match="give one for both of its pins, or a pair"):
        linkage.move().worst_case("P", end_play={"J": (PLAY, PLAY, PLAY)})
    linkage, _, _ = one_joint("spherical")
    with pytest.raises(FrameError, match="only revolute, prismatic, cylindrical, screw, universal joints have it"):
        linkage.move().worst_case("P", clearances={"J": EPS}, journals={"J": LENGTH})
