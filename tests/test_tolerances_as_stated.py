"""An absolute tolerance that a test states is all that it allows."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose


def test_no_relative_tolerance_is_added() -> None:
    assert_allclose(np.array([1.0]), 1.0 + 1e-14, atol=1e-13)
    with pytest.raises(AssertionError):
        assert_allclose(np.array([1.0]), 1.0 + 1e-9, atol=1e-13)
    assert_allclose(np.array([1.0]), 1.0 + 1e-9, rtol=1e-8, atol=1e-13)
    assert_allclose(np.array([1.0]), 1.0 + 1e-9)
