"""Where iteration does not converge a factor serves instead, also for a later load on a matrix that is regular."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.framework.solvers import iterative
from numpy.testing import assert_allclose
from reference.as_frame import as_frame
from reference.random_structures import random_frame


def test_a_load_that_does_not_converge(monkeypatch: pytest.MonkeyPatch) -> None:
    solution = as_frame(random_frame(3)).solve("iterative")
    factor = solution.solver.factor  # type: ignore[union-attr]
    assert isinstance(factor, iterative.Iterative)
    assert not factor.singular
    monkeypatch.setattr(iterative, "ITERATIONS", 0)
    load = np.random.default_rng(0).standard_normal((len(factor.root), 2))
    found = factor.solve_scaled(load)
    assert found is not None
    assert_allclose(factor.scaled @ found, load, atol=1e-6 * np.abs(load).max())
