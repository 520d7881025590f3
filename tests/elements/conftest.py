"""What the tests of the elements share."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from linkframe.elements import Beam
from numpy.typing import NDArray

Array = NDArray[np.float64]
Assembled = tuple[Array, Array, Array]


def _chain(beam: Beam, length: float, count: int) -> Assembled:
    """Stiffness, mass and geometric stiffness under unit compression of a member along x in `count` equal parts."""
    matrices = np.zeros((3, 6 * (count + 1), 6 * (count + 1)))
    for index in range(count):
        part = beam.part(index, count)
        dofs = np.arange(6 * index, 6 * index + 12)
        piece = length / count
        for matrix, entry in zip(
            matrices,
            (part.stiffness_matrix(piece), part.mass_matrix(piece), part.geometric_matrix(piece, -1.0)),
            strict=True,
        ):
            matrix[np.ix_(dofs, dofs)] += entry
    return matrices[0], matrices[1], matrices[2]


@pytest.fixture
def chain() -> Callable[[Beam, float, int], Assembled]:
    """K, M and Kg (unit compression) of a member along x, cut into equal parts."""
    return _chain
