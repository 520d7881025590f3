"""The preconditioner of conjugate gradients: block Jacobi, by node, plus the rigid motions of pieces of the frame.

(Nicolaides, SIAM J. Numer. Anal. 24, 1987, 355-365, with the six rigid motions of each piece.)
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import scipy

from ..batch import Array
from ..structure.topology import Index
from .condensed import Condensed, Places, compact
from .dissection import bisected
from .lu import LUFactor

# Number of nodes of a rigid piece.
PIECE = 100
# Share of its diagonal that is added to the coarse stiffness, so that it is regular even if the frame is singular.
_FLOOR = 1e-12
# Factor of what rigid pieces add: with less, the greatest eigenvalue falls, and the least falls little.
_SHARE = 0.5
_EPS = float(np.finfo(float).eps)


def preconditioner(matrix: Condensed, root: Array, places: Places) -> Callable[[Array], Array]:
    """Function that multiplies vectors (n,) or (n, k) by the preconditioner of a matrix whose own blocks are ones.

    Parameters
    ----------
    matrix
        The matrix, of which the nodes kept have six unknowns each.
    root
        Scale of the unknowns before the nodes were condensed.
    places
        The nodes of these unknowns.
    """
    rigid = _rigid_motions(matrix, root, places)
    moved = scipy.sparse.csr_matrix(rigid.T @ (matrix @ rigid))
    stiff = moved.diagonal()
    # motions that take no energy, as those of a piece without nodes that are kept, are left out
    most = stiff.max(initial=0.0)
    floor = np.where(stiff > _EPS * most, _FLOOR * stiff, most)
    coarse = LUFactor(scipy.sparse.csr_matrix(moved + scipy.sparse.diags(floor)))
    if coarse.factor is None or not stiff.any():
        return np.copy
    rigid.data *= np.sqrt(_SHARE) * coarse.root.reshape(-1, 1, 6)[rigid.indices]
    forth, back = compact(rigid), compact(rigid.T)
    return lambda residual: np.asarray(residual + forth @ coarse.factor.solve(back @ residual))


def _rigid_motions(matrix: Condensed, root: Array, places: Places) -> scipy.sparse.bsr_matrix:
    """Motions of the nodes kept, (6 nodes, 6 pieces), per unit of the six motions of each rigid piece."""
    nodes, first, node = np.unique(places.node, return_index=True, return_inverse=True)
    free = places.free[first]
    piece = np.zeros(len(nodes), dtype=np.int64)
    piece[free] = bisected(places.points[first][free], PIECE)
    count = int(piece.max(initial=0)) + 1
    blocks = np.zeros((len(nodes), 6, 6))
    blocks[node, places.component] = _motions_about(_centres(piece[node], places), places) / root[:, None]
    kept = matrix.order[matrix.out :]
    parts = matrix.motions(blocks), piece[kept], np.arange(len(kept) + 1)
    return scipy.sparse.bsr_matrix(parts, shape=(6 * len(kept), 6 * count))


def _centres(piece: Index, places: Places) -> Array:
    """Centre of the piece (n,) of each of n unknowns, (n, 3)."""
    own = np.maximum(np.bincount(piece, places.free), 1.0)
    centres = np.stack([np.bincount(piece, places.free * x) / own for x in places.points.T], axis=1)
    found: Array = centres[piece]
    return found


def _motions_about(centres: Array, places: Places) -> Array:
    """Value of n unknowns, (n, 6), per unit of the six rigid motions about centres (n, 3)."""
    unknowns, arm = np.arange(len(centres)), places.points - centres
    found = np.zeros((len(centres), 6))
    found[unknowns, places.component] = 1.0
    for k in range(3):
        on = places.component == k
        found[on, 3 + (k + 1) % 3] = arm[on, (k + 2) % 3]
        found[on, 3 + (k + 2) % 3] = -arm[on, (k + 1) % 3]
    out: Array = found * places.free[:, None]
    return out
