"""Equations whose elimination is written down are solved as by a matrix, and where their pivots fail by a matrix."""

from __future__ import annotations

import numpy as np
import pytest
from benchmarks.kinematics import stewart
from hypothesis import given, settings
from hypothesis import strategies as st
from linkframe.framework.program.recording import Recording
from linkframe.framework.program.source import Functions
from linkframe.models.linkage.kinematics import equations
from linkframe.models.linkage.kinematics.elimination import Eliminated, order_of
from linkframe.models.linkage.kinematics.linear import Linear


@settings(max_examples=30, deadline=None)
@given(seed=st.integers(0, 10**6), size=st.integers(1, 8), share=st.floats(0.2, 1.0))
def test_solutions_and_determinants_are_those_of_the_matrix(seed: int, size: int, share: float) -> None:
    rng = np.random.default_rng(seed)
    pattern = rng.random((size, size)) < share
    pattern[np.arange(size), rng.permutation(size)] = True
    entries, rights = rng.standard_normal((2, size, size)), rng.standard_normal((2, size))
    linear, given_matrix = Linear(pattern), entries[0] * pattern
    order = order_of(linear, given_matrix)
    if order is None:
        return
    recording = Recording(fixed=True)
    given_terms = [recording.later(0) for _ in range(size * size)]
    terms = [term if there else 0.0 for term, there in zip(given_terms, pattern.ravel(), strict=True)]
    sides = [[recording.later(0) for _ in range(size)] for _ in range(2)]
    found = Eliminated(linear, order, terms, sides)
    flat = [x for solution in found.solutions for x in solution]
    outputs = [
        x if hasattr(x, "number") else recording.constant(x) for x in (*flat, *found.determinants, *found.pivots)
    ]
    list_of_steps, places = recording.program(outputs)
    entry = [(1, k) for k in range(size * size)] + [(0, k) for k in range(2 * size)]
    program = Functions.of(list_of_steps, tuple(entry[k] for k in places))
    matrix = (entries[0] + 1e-3 * entries[1]) * pattern
    got = program[0](rights.ravel().tolist(), matrix.ravel().tolist())
    sizes = [y for x in order.sizes for y in x]
    if min(abs(pivot / full) for pivot, full in zip(got[-size:], sizes, strict=True)) < 1e-2:
        return
    tolerance = 1e-10 * np.linalg.cond(matrix)
    np.testing.assert_allclose(
        np.reshape(got[: 2 * size], (2, size)), np.linalg.solve(matrix, rights.T).T, rtol=0, atol=tolerance
    )
    blocks = [np.linalg.det(matrix[np.ix_(*block)]) for block in linear.blocks]
    np.testing.assert_allclose(got[2 * size : -size], blocks, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(np.abs(np.prod(got[-size:])), np.abs(np.prod(blocks)), rtol=1e-9)
    arrays = program[1](list(np.repeat(rights.reshape(-1, 1), 2, axis=1)), list(np.stack([matrix.ravel()] * 2, -1)))
    np.testing.assert_array_equal([np.broadcast_to(x, 2)[1] for x in arrays], got)


def test_small_pivots_are_not_relied_on(monkeypatch: pytest.MonkeyPatch) -> None:
    linkage, drives = stewart(12)
    plain = linkage.move(drives)
    monkeypatch.setattr(equations, "LEAST_PIVOT_RATIO", 0.9)
    mended = linkage.move(drives)
    monkeypatch.setattr(equations, "LEAST_PIVOT_RATIO", np.inf)
    for motion in (mended, linkage.move(drives)):
        np.testing.assert_allclose(motion.position("P"), plain.position("P"), rtol=0.0, atol=1e-14)
        assert motion.is_assembled.all()


def test_a_batch_does_not_depend_on_its_length() -> None:
    linkage, drives = stewart(5000)
    whole = linkage.move(drives).position("P")
    part = linkage.move({name: x[4000:4300] for name, x in drives.items()}).position("P")
    np.testing.assert_array_equal(part, whole[4000:4300])
