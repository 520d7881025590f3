"""What solves batches of middle-sized frames beside linkframe, given arrays of members whose axes are known.

As the modulus is one number for all members it scales the whole matrix, which is assembled once; a loop solves for each
modulus in turn, and loads share one factor. Nothing tells a mechanism, and what rounding leaves stays.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # the benchmarks run on one core; more threads would wait for it

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg.lapack import dpbsv, dpbtrf, dpbtrs
from scipy.sparse import coo_matrix, csc_matrix, tril
from scipy.sparse.csgraph import reverse_cuthill_mckee

from .harness import importable
from .large_ways import AREA, IY, IZ, LOAD, TORSION, E, G, Size, members, opensees, places

Array = NDArray[Any]
Solve = Callable[[], Array]
# Local axes as rows of members along x, y and z.
_AXES = np.array([np.eye(3), [[0, 1, 0], [-1, 0, 0], [0, 0, 1]], [[0, 0, 1], [0, 1, 0], [-1, 0, 0]]], dtype=float)


class Arrays:
    """A frame of `large_ways` as arrays; its first nodes are held, its last ones loaded."""

    def __init__(self, size: Size) -> None:
        number = {place: k for k, place in enumerate(places(size))}
        each = list(members(size))
        floor = size[0] * size[1]
        dofs = 6 * (np.array([(number[start], number[end]) for _, start, end in each]) - floor)
        self.dofs = (dofs[:, :, None] + np.arange(6)).reshape(-1, 12)
        self.axes = _AXES[[axis for axis, _, _ in each]]
        self.size = 6 * (len(number) - floor)
        self.load = np.zeros(self.size)
        self.load.reshape(-1, 6)[-floor:, :3] = LOAD

    def matrix(self) -> csc_matrix:
        """The stiffness of what is not held."""
        local = np.zeros((12, 12))
        for i, k in ((0, E * AREA), (3, G * TORSION)):
            local[i, i] = local[i + 6, i + 6] = k
            local[i, i + 6] = local[i + 6, i] = -k
        for sign, dofs, k in ((1.0, [1, 5, 7, 11], E * IZ), (-1.0, [2, 4, 8, 10], E * IY)):
            side = np.array([12.0, 6.0 * sign, -12.0, 6.0 * sign])
            plane = np.outer(side, side) / 12.0 + np.array([0, 1, 0, -1])[:, None] * np.array([0, 1, 0, -1])
            local[np.ix_(dofs, dofs)] = k * plane
        turned = np.swapaxes(self.axes, 1, 2)[:, None, None] @ local.reshape(4, 3, 4, 3).swapaxes(1, 2)
        turned = (turned @ self.axes[:, None, None]).swapaxes(2, 3).reshape(-1, 144)
        row, column = np.repeat(self.dofs, 12, axis=1), np.tile(self.dofs, 12)
        used = (row >= 0) & (column >= 0) & (turned != 0.0)
        return coo_matrix((turned[used], (row[used], column[used])), shape=(self.size, self.size)).tocsc()


def lapack(arrays: Arrays, scales: Array, shares: Array) -> Array:
    """``dpbsv`` for each modulus, or ``dpbtrf`` and ``dpbtrs`` for all loads: displacements (entries, n)."""
    matrix = arrays.matrix()
    order = reverse_cuthill_mckee(matrix.tocsr(), symmetric_mode=True)
    entries = tril(matrix[order][:, order], format="coo")
    below = entries.row - entries.col
    band, load = np.zeros((below.max() + 1, arrays.size), order="F"), arrays.load[order]
    band[below, entries.col] = entries.data
    out = np.empty((max(len(scales), len(shares)), arrays.size))
    if len(scales) == 1:
        factor, _ = dpbtrf(scales[0] * band, lower=1, overwrite_ab=1)
        out[:, order] = dpbtrs(factor, load[:, None] * shares, lower=1)[0].T
        return out
    for k, scale in enumerate(scales.tolist()):
        out[k, order] = dpbsv(scale * band, load[:, None], lower=1, overwrite_ab=1)[1][:, 0]
    return out


def substitution(arrays: Arrays) -> Callable[[float], Array]:
    """What LAPACK does for one more load where the factor is there: displacements (n,) for a share of the load."""
    matrix = arrays.matrix()
    order = reverse_cuthill_mckee(matrix.tocsr(), symmetric_mode=True)
    entries = tril(matrix[order][:, order], format="coo")
    below = entries.row - entries.col
    band = np.zeros((below.max() + 1, arrays.size), order="F")
    band[below, entries.col] = entries.data
    factor, _ = dpbtrf(band, lower=1, overwrite_ab=1)

    def solve(share: float) -> Array:
        out = np.empty(arrays.size)
        out[order] = dpbtrs(factor, share * arrays.load[order], lower=1)[0]
        return out

    return solve


def cholmod(arrays: Arrays, scales: Array, shares: Array) -> Array:
    """CHOLMOD with one symbolic factor: displacements (entries, n)."""
    from cvxopt import cholmod as library
    from cvxopt import matrix as dense
    from cvxopt import spmatrix

    lower = tril(arrays.matrix(), format="csc")
    columns = np.repeat(np.arange(lower.shape[1]), np.diff(lower.indptr))
    places = dense(lower.indices.astype(np.int64)), dense(columns.astype(np.int64))
    entries = spmatrix(dense(lower.data), *places, lower.shape)
    factor, out = library.symbolic(entries), []
    for scale in scales.tolist():
        library.numeric(scale * entries, factor)
        right = dense(arrays.load[:, None] * shares)
        library.solve(factor, right)
        out.append(np.array(right).T)
    return np.concatenate(out)


def peers(size: Size, scales: Array, shares: Array, *, anew: bool = False) -> dict[str, Solve]:
    """What there is by name; openseespy builds its model for each modulus, and is asked for one load alone.

    The others get their arrays ready, or make them from places and members each time `anew`, as openseespy does.
    """
    ready = Arrays(size)

    def arrays() -> Arrays:
        return Arrays(size) if anew else ready

    found: dict[str, Solve] = {"LAPACK": lambda: lapack(arrays(), scales, shares)}
    if importable("cvxopt"):
        found["CHOLMOD"] = lambda: cholmod(arrays(), scales, shares)
    if importable("openseespy.opensees") and len(shares) == 1:
        found["openseespy"] = lambda: np.array([opensees(size, "RCM", "ProfileSPD")[1] for _ in scales])
    return found
