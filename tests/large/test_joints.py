"""Finite motion in a joint: first and second derivatives, both ways, and that one way undoes the other."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from linkframe.framework import rotation
from linkframe.framework.large.links import EdgeGeometry, LinkChange, LoopChange, displacement

COUNT, STEP = 3, 1e-6
LOOSE = [(0, 0, 0), (0, 0, 1), (0, 1, 0), (1, 1, 0), (1, 1, 1)]
Place = tuple[np.ndarray, np.ndarray]


def link(loose: tuple[int, ...], forward: bool, follows: bool) -> EdgeGeometry:
    rng = np.random.default_rng(3)
    axes = rotation.matrix(rotation.normalised(rng.standard_normal((4, COUNT)))) if follows else None
    arm = rng.standard_normal((3, COUNT)) if follows else None
    lead = rng.standard_normal(COUNT) if follows else None
    return EdgeGeometry(axes, arm, np.array(loose, dtype=bool), forward, follows, lead)


def places() -> tuple[Place, Place, np.ndarray, np.ndarray]:
    rng = np.random.default_rng(4)
    nodes = [
        (rng.standard_normal((3, COUNT)), rotation.exponential(0.6 * rng.standard_normal((3, COUNT)))) for _ in "ab"
    ]
    return nodes[0], nodes[1], 0.6 * rng.standard_normal((6, COUNT)), rng.standard_normal((6, COUNT))


def shifted(place: Place, k: int, by: float) -> Place:
    moved, turned = place[0].copy(), place[1]
    if k < 3:
        moved[k] += by
    else:
        turn = np.zeros((3, COUNT))
        turn[k - 3] = by
        turned = rotation.product(rotation.exponential(turn), turned)
    return moved, turned


def slope(of: Callable[[int, float], np.ndarray], k: int) -> np.ndarray:
    return np.asarray((of(k, STEP) - of(k, -STEP)) / (2.0 * STEP))


@pytest.mark.parametrize("follows", [True, False])
@pytest.mark.parametrize("forward", [True, False])
@pytest.mark.parametrize("loose", LOOSE)
def test_a_node_that_hangs_on_another(loose: tuple[int, ...], forward: bool, follows: bool) -> None:
    edge = link(loose, forward, follows)
    parent, _, own, force = places()

    def at(k: int, by: float) -> tuple[Place, LinkChange]:
        here = shifted(parent, k, by) if k < 6 else parent
        inner = own.copy()
        if k >= 6:
            inner[k - 6] += by
        child = edge.child(*here, inner)
        return child, LinkChange(edge, here[1] if forward else child[1], inner)

    still, change = at(0, 0.0)
    jacobian, geometric = change.jacobian, change.geometric(force)
    for k in range(12):
        ahead, behind = at(k, STEP)[0], at(k, -STEP)[0]
        turned = rotation.logarithm(rotation.product(ahead[1], rotation.conjugate(behind[1])))
        moved = np.concatenate([ahead[0] - behind[0], turned]) / (2.0 * STEP)
        assert moved == pytest.approx(jacobian[:, k], abs=1e-8)
        found = slope(lambda k, by: np.einsum("jim,jm->im", at(k, by)[1].jacobian, force), k)
        assert found[3:] == pytest.approx(geometric[:, k - 3] if k >= 3 else np.zeros((9, COUNT)), abs=1e-8)
    assert np.isfinite(still[0]).all()


@pytest.mark.parametrize("follows", [True, False])
@pytest.mark.parametrize("loose", LOOSE)
def test_an_edge_that_closes_a_loop(loose: tuple[int, ...], follows: bool) -> None:
    edge = link(loose, True, follows)
    first, second, own, force = places()
    child = edge.child(*first, own)
    assert displacement(edge, (first[0], child[0]), (first[1], child[1])) == pytest.approx(own, abs=1e-13)

    def at(k: int, by: float) -> LoopChange:
        one, other = (shifted(first, k, by), second) if k < 6 else (first, shifted(second, k - 6, by))
        return LoopChange(edge, (one[0], other[0]), (one[1], other[1]))

    jacobian, geometric = at(0, 0.0).jacobian, at(0, 0.0).geometric(force)
    for k in range(12):
        assert slope(lambda k, by: at(k, by).own, k) == pytest.approx(jacobian[:, k], abs=2e-8)
        found = slope(lambda k, by: np.einsum("jim,jm->im", at(k, by).jacobian, force), k)
        assert found == pytest.approx(geometric[:, k], abs=5e-8)
