"""Entries taken out of a batch are what indexing the whole of it gives, however little of it an array holds."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from linkframe.framework.entries import WHOLE, Entries, Stretch, flattened, picked
from numpy.testing import assert_array_equal

BATCH = (3, 4, 2)
# Batch shapes that broadcast with it, some without its first axes.
shapes = st.sampled_from([(), (2,), (1,), (4, 1), (4, 2), (1, 1, 1), (3, 1, 2), (3, 4, 2), (1, 4, 1)])


@given(shapes, st.integers(0, 2), st.integers(0, 2))
@settings(max_examples=40, deadline=None)
def test_entries_are_those_of_the_whole(shape: tuple[int, ...], trailing: int, leading: int) -> None:
    full = len(shape) == len(BATCH)  # with axes in front, none of the batch may be left out
    front, behind = (5, 6)[: leading if full else 0], (7, 8)[:trailing]
    array = np.random.default_rng(0).normal(size=(*front, *shape, *behind))
    whole = np.broadcast_to(array, (*front, *BATCH, *behind))
    index = np.array([0, 2, 2]), np.array([3, 0, 1]), np.array([1, 1, 0])
    wanted = whole[(slice(None),) * len(front) + index]
    found = Entries(index)(array, trailing, len(front))
    assert_array_equal(np.broadcast_to(found, wanted.shape), wanted)
    assert_array_equal(found, picked(array, index, trailing, len(front)))
    part = Stretch(ndim=3, axis=1, indices=slice(1, 3))
    stretch = part(array, trailing, len(front))
    wanted = whole[(*(slice(None),) * len(front), *part.where)]
    assert_array_equal(np.broadcast_to(stretch, wanted.shape), wanted)
    assert WHOLE(array, trailing) is array
    if not front:
        assert_array_equal(flattened(array, BATCH, trailing), whole.reshape(24, *behind))


@pytest.mark.parametrize("trailing", [0, 1])
def test_a_batch_without_axes_has_one_entry(trailing: int) -> None:
    array = np.arange(3.0)[: 3 if trailing else 1].reshape((3,) if trailing else ())
    assert_array_equal(picked(array, (), trailing), array[None])
    assert Stretch(ndim=0, axis=0, indices=slice(0, 1))(array, trailing) is array
    assert flattened(array, (), trailing).shape == (1, *array.shape)


def test_an_empty_batch_has_no_entries() -> None:
    none = np.zeros(0, dtype=np.int64)
    assert picked(np.zeros((0, 6)), (none,), 1).shape == (0, 6)
    assert picked(np.zeros((1, 6)), (none,), 1).shape == (1, 6)
    assert flattened(np.zeros((0, 6)), (0,), 1).shape == (0, 6)
