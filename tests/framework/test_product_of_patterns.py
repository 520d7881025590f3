"""Products with sparse matrices whose kernels do not look at sizes themselves."""

from __future__ import annotations

import numpy as np
import pytest
import scipy
from linkframe.framework.solvers.patterns import times

MATRIX = scipy.sparse.csr_matrix(np.array([[1.0, 0.0, 2.0], [0.0, 3.0, 0.0]]))


@pytest.mark.parametrize("shape", [(3,), (3, 1), (3, 4), (3, 0)])
def test_a_product_is_that_of_the_whole_matrix(shape: tuple[int, ...]) -> None:
    values = np.arange(1.0, 1.0 + np.prod(shape, dtype=int)).reshape(shape)
    np.testing.assert_array_equal(times(MATRIX, values), MATRIX.toarray() @ values)


@pytest.mark.parametrize("shape", [(2,), (4,), (0,), (1, 3), (2, 4), (1,)])
def test_values_of_another_size_are_refused(shape: tuple[int, ...]) -> None:
    with pytest.raises(ValueError, match=r"give \(3,\) or \(3, m\)"):
        times(MATRIX, np.ones(shape))
