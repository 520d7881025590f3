"""Frames of many kinds of member, as the links of a linkage are: each kind costs what its own members do."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
import scipy
from linkframe.elements import Beam, Material, Rectangle
from linkframe.framework.error_bounds.deformations import Springs, on_nodes
from linkframe.framework.solvers import evaluation
from linkframe.models import Linkage

BAR = Beam(Rectangle(y=12.7e-3, z=6.35e-3), Material(E=200e9, nu=0.3))
PIN = (2e8, 2e8, 2e8, 2e5, 2e5, 1e4)


def arm(links: int) -> Linkage:
    """Links end to end, a drive in each joint."""
    linkage = Linkage({f"P{k}": (0.1 * k, 0.03 * (k % 2)) for k in range(links + 1)})
    for k in range(links):
        linkage.link(f"l{k}", f"P{k}", f"P{k + 1}", beam=BAR)
        linkage.revolute(f"P{k}", f"l{k - 1}" if k else "ground", f"l{k}", drive=True, stiffness=PIN)
    return linkage


def test_numbers_evaluated_grow_with_the_links(monkeypatch: pytest.MonkeyPatch) -> None:
    plain = evaluation.times

    def evaluated(links: int) -> int:
        counts: list[int] = []

        def times(matrix: scipy.sparse.csr_matrix, values: np.ndarray) -> np.ndarray:
            found = plain(matrix, values)
            counts.append(found.size)
            return found

        monkeypatch.setattr(evaluation, "times", times)
        frame = arm(links).move({f"P{k}": np.linspace(0.0, 0.01 * k, 3) for k in range(links)}).frame()
        frame.load(f"P{links}", fy=1.0)
        frame.solve("banded").displacement(f"P{links}")
        return sum(counts)

    assert evaluated(40) < 2.3 * evaluated(20)


@pytest.mark.parametrize("ends", [[(0, 1), (3, 4)], [(0, 1), (1, 3), (1, 4)], [(4, 2)]])
def test_sums_on_nodes_by_kind(ends: list[tuple[int, int]]) -> None:
    """Integers add up exactly, whether or not members of a kind share nodes, and over batches of both."""
    rng = np.random.default_rng(0)
    start = rng.integers(-9, 9, (3, 1, 5, 2)).astype(float)
    kinds = [
        (np.array(ends), rng.integers(-9, 9, (4, len(ends), 4)).astype(float)),
        (np.array([(1, 2)]), np.ones((1, 4))),
    ]
    expected = np.broadcast_to(start, (3, 4, 5, 2)).copy()
    for nodes, acting in kinds:
        for k, pair in enumerate(nodes.tolist()):
            for side, node in enumerate(pair):
                expected[..., node, :] += acting[..., k, 2 * side : 2 * side + 2]
    stand_ins = []
    for nodes, acting in kinds:
        springs = SimpleNamespace(nodes=nodes)
        springs.add_to = lambda nodal, acting, springs=springs: Springs.add_to(springs, nodal, acting)
        stand_ins.append((springs, acting))
    np.testing.assert_array_equal(on_nodes(start, stand_ins), expected)


@pytest.mark.parametrize("used", [[], [0], [4], [2, 3], [0, 9], list(range(10))])
@pytest.mark.parametrize("trailing", [(), (3,)])
def test_products_with_the_rows_that_have_entries(used: list[int], trailing: tuple[int, ...]) -> None:
    rng = np.random.default_rng(1)
    dense = np.zeros((10, 4))
    dense[used] = rng.integers(1, 9, (len(used), 4))
    values = rng.integers(-9, 9, (4, *trailing)).astype(float)
    rows = evaluation._FilledRows.of(scipy.sparse.csr_matrix(dense))
    np.testing.assert_array_equal(rows.add_to(None, values), dense @ values)
    np.testing.assert_array_equal(rows.add_to(np.ones((10, *trailing)), values), 1.0 + dense @ values)
