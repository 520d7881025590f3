"""Deformations of a member: its elongation, and the rotations of its ends relative to its chord."""

from __future__ import annotations

import numpy as np

from .batch import Array

# Places of the elongation and the two rotation vectors among the twelve end displacements.
DEFORMATIONS = (6, 3, 4, 5, 9, 10, 11)


def deformation_rows(length: Array) -> Array:
    """Elongation, and end rotations from the chord and the mean twist, by small end displacements, (..., 7, 12).

    Parameters
    ----------
    length
        Length, (...).
    """
    rows = np.zeros((*np.shape(length), 7, 12))
    rows[..., 0, 0], rows[..., 0, 6] = -1.0, 1.0
    for end in (0, 1):
        first = 1 + 3 * end
        rows[..., first, 3 + 6 * end], rows[..., first, 9 - 6 * end] = 0.5, -0.5
        for k, moved, sign in ((1, 2, 1.0), (2, 1, -1.0)):
            rows[..., first + k, 3 + 6 * end + k] = 1.0
            rows[..., first + k, moved], rows[..., first + k, moved + 6] = -sign / length, sign / length
    return rows
