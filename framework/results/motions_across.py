"""Free motions across what the loads do: at every node they go, and turn, at right angles to the displacement there.

Of all displacements that differ by free motions, take the shortest one, with rotations times a length. Where another of
them is at right angles to a free motion at every node, it is this one; so no choice of that length, of axes or of the
motions of a basis matters.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..batch import Array
from ..elementwise import contracted
from ..error_bounds.kinematic_edge import Real

# Squares of lengths of motions that depend on others, and what is left at right angles of unit motions, by rounding.
_RANK, _ACROSS = 1e-12, 1e-10


class FreeMotions:
    """Free motions as a basis of unit length.

    Parameters
    ----------
    motions
        Displacements ``ux uy uz rx ry rz`` of one node after the other in each motion, rotations times a length, (r, k,
        m); zeros where an entry has fewer.

    Attributes
    ----------
    factors
        Factors of the motions in those of the basis, which are the columns, (r, r, m); zeros where there are fewer.
    """

    def __init__(self, motions: Real) -> None:
        squares, vectors = np.linalg.eigh(_entries_first(contracted("rkm,skm->rsm", motions, motions)))
        self._some = squares > _RANK * np.maximum(squares.max(axis=-1, keepdims=True), np.finfo(float).tiny)
        unit = vectors / np.sqrt(np.where(self._some, squares, 1.0))[:, None]
        self.factors = np.moveaxis(np.where(self._some[:, None], unit, 0.0), 0, -1)
        self._basis = contracted("rsm,rkm->skm", self.factors, motions)

    def along(self, moved: Real) -> Real:
        """Factors of the motions (r, m) in what of displacements (k, m) lies along them."""
        return contracted("rsm,sm->rm", self.factors, contracted("skm,km->sm", self._basis, moved))

    def others(self, shortest: Real) -> tuple[Array, NDArray[np.bool_]]:
        """Those at right angles to all that are across a displacement which has nothing along any of them.

        Parameters
        ----------
        shortest
            The displacement (k, m).

        Returns
        -------
        factors : ndarray
            Factors of the motions in a basis of them, its columns, of which some are zero, (r, r, m).
        which : ndarray of bool
            Entries that have motions across the displacement, (m,); none where nothing is displaced.
        """
        count, rows, size = self._basis.shape
        largest = np.abs(shortest).max(axis=0, initial=0.0)
        unit = shortest / np.where(largest > 0.0, largest, 1.0)
        pairs = self._basis.reshape(count, rows // 3, 3, size), unit.reshape(rows // 3, 3, size)
        work = _entries_first(contracted("snim,nim->snm", *pairs))
        more = np.zeros((size, count, max(count - rows // 3, 0)))
        left, values, _ = np.linalg.svd(np.concatenate([work, more], axis=-1), full_matrices=False)
        across = (values <= _ACROSS) & (largest > 0.0)[:, None]
        turned = contracted("rsm,stm->rtm", self.factors, np.moveaxis(left, 0, -1))
        return np.where(across.T, 0.0, turned), np.asarray(across.sum(axis=-1) > (~self._some).sum(axis=-1))


def _entries_first(matrices: Real) -> Array:
    """In double precision, (m, ...) from (..., m)."""
    return np.ascontiguousarray(np.moveaxis(matrices, -1, 0).astype(np.float64))
