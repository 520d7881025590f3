"""Vectors turned by axes: the same to the last bit in long batches and in short ones, whatever broadcasts and however
it lies in memory."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from linkframe.framework.batch import _LONG, rotated
from scipy.spatial.transform import Rotation

SHAPES = (
    ((600,), (600,)),
    ((6000,), ()),
    ((), (9000,)),  # of a single matrix NumPy takes all at once
    ((30, 1), (200,)),
    ((30, 200), (200,)),
    ((30, 200), (30, 1)),
    ((200,), (30, 200)),
    ((30, 1), (2, 30, 200)),
    ((2, 1, 1), (2, 30, 200)),
)
LAYOUTS: dict[str, Callable[[np.ndarray], np.ndarray]] = {
    "as they come": lambda a: a,
    "component by component": lambda a: np.moveaxis(np.ascontiguousarray(np.moveaxis(a, -1, 0)), 0, -1),
    "part of longer ones": lambda a: np.concatenate([a, a], axis=-1)[..., : a.shape[-1]],
}


def _given(axes: tuple[int, ...], vectors: tuple[int, ...], count: int) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(11)
    turns = Rotation.random(int(np.prod(axes)), rng=rng).as_matrix().reshape(*axes, 3, 3)
    return turns, rng.normal(size=(*vectors, count))


@pytest.mark.parametrize("count", [3, 6])
@pytest.mark.parametrize("shapes", SHAPES)
@pytest.mark.parametrize("layout", LAYOUTS)
@pytest.mark.parametrize("back", [False, True])
def test_a_long_batch_is_its_entries(shapes, layout: str, count: int, back: bool) -> None:
    """Against matrix products in extended precision, and to the last bit the entries by themselves."""
    axes, vectors = _given(*shapes, count)
    axes, vectors = axes.mT if back else axes, LAYOUTS[layout](vectors)
    assert axes.size * vectors.size > _LONG
    found = rotated(axes, vectors)
    whole = np.broadcast_shapes(*shapes)
    assert found.shape == (*whole, count)
    long = axes.astype(np.longdouble)
    true = [(long @ vectors[..., k : k + 3, None].astype(np.longdouble))[..., 0] for k in range(0, count, 3)]
    assert np.abs(found - np.concatenate(true, axis=-1)).max() < 4e-15
    all_axes, all_vectors = np.broadcast_to(axes, (*whole, 3, 3)), np.broadcast_to(vectors, (*whole, count))
    for entry in ((0,) * len(whole), tuple(n - 1 for n in whole), tuple(n // 3 for n in whole)):
        assert np.array_equal(found[entry], rotated(all_axes[entry], all_vectors[entry]))


def test_what_was_given_stays_as_it_was() -> None:
    axes, vectors = _given((30, 1), (200,), 6)
    before = axes.copy(), vectors.copy()
    rotated(axes, vectors)[:] = 0.0
    assert np.array_equal(axes, before[0])
    assert np.array_equal(vectors, before[1])


def test_extended_precision_stays_so() -> None:
    axes, vectors = _given((600,), (600,), 6)
    found = rotated(axes.astype(np.longdouble), vectors)
    assert found.dtype == np.longdouble
    assert np.abs(found - rotated(axes, vectors)).max() < 4e-15
