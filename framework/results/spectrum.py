"""Symmetric eigenvalue problems with dense matrices for a whole batch, and extreme eigenvalues of a sparse one."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy
from numpy.typing import NDArray

from ..batch import Array
from ..batched.plan import Plan
from ..error_bounds.compliance import DenseCompliance
from ..error_bounds.equilibrium import Statics, rounded
from ..errors import FrameError
from ..solvers.rounding import zero_eigenvalue
from . import dense

# Above this many unknowns a single frame is treated with sparse matrices.
DENSE = 400
# If squared frequencies differ by more than this factor, the higher ones are computed again with a shift of their size.
_APART = 1e4


class AskedModes(NamedTuple):
    """What asks for modes, as messages say it: the verb, of what, and what gives that a mass."""

    verb: str
    owner: str
    remedy: str

    def number(self, count: int) -> str:
        """Beginning of a message on so many modes."""
        return f"{self.verb}({count}): {self.owner}"

    def require_mass(self, massive: NDArray[np.bool_], absent: NDArray[np.bool_] | None) -> None:
        """Refuse what has no mass at a batch entry that is there; `massive` (...) tells where it has some."""
        without = ~massive if absent is None else ~massive & ~absent
        if without.any():
            which = "" if without.all() else f" at batch entry {np.argwhere(without)[0].tolist()}"
            raise FrameError(f"{self.verb}: {self.owner} has no mass{which}: {self.remedy}")


OF_FRAME = AskedModes("modes", "the frame", "give its materials a density, or add a PointMass")


def stiffness_halves(plan: Plan) -> tuple[Array, Array]:
    """L of ``D K D = L L^T`` with unit diagonal, (..., n, n), and D's diagonal, (..., n), by QR of the deformations.

    ``D K D = A^T A``, with A the deformations per unknown weighted by the square root of their stiffness. Forming the
    product would square the condition number. Where springs have a negative stiffness, by a preload, L comes from the
    product nevertheless, and is NaN if the frame is unstable.
    """
    found = _compliance(plan)
    weighted, size = found.scaled, len(plan.unknowns)
    missing = np.zeros((*weighted.shape[:-2], max(size - weighted.shape[-2], 0), size))
    upper = np.linalg.qr(np.concatenate([weighted, missing], axis=-2), mode="r")
    half = np.swapaxes(upper, -1, -2)
    pushed = found.pushing
    if not pushed.any():
        return half, found.root
    values, vectors = np.linalg.eigh(found.matrix)
    root = np.sqrt(np.where(values > 0.0, values, np.nan))[..., None, :]
    return np.where(pushed[..., None, None], vectors * root, half), found.root


def surely_stiff(plan: Plan) -> NDArray[np.bool_]:
    """Entries at which deformations show a stiffness above rounding for every motion, even if K has lost it, (...)."""
    found = _compliance(plan)
    return np.asarray(found.distance() > found.backward_error)


def _compliance(plan: Plan) -> DenseCompliance:
    statics = Statics(plan)
    kinematics, springs = statics.kinematics.mapped(rounded), [each.mapped(rounded) for each in statics.springs]
    return DenseCompliance(kinematics, springs, statics.stiffness, plan.unknowns)


def inverse_pencil(half: Array, root: Array, other: Array, count: int) -> tuple[Array, Array]:
    """Eigenvalues mu of largest magnitude of ``other x = mu K x``, (..., count), and vectors (..., n, count).

    With ``D K D = L L^T`` the problem is that of ``L^-1 D other D L^-T``, which is symmetric; eigenvalues of large
    magnitude are exact to rounding.

    Parameters
    ----------
    half, root
        L and the diagonal of D.
    other
        Symmetric matrices, (..., n, n).
    count
        Number of eigenvalues.
    """
    left = np.linalg.solve(half, other * root[..., :, None] * root[..., None, :])
    middle = np.linalg.solve(half, np.swapaxes(left, -1, -2))
    values, vectors = np.linalg.eigh((middle + np.swapaxes(middle, -1, -2)) / 2.0)
    chosen = np.argsort(-np.abs(values), axis=-1, kind="stable")[..., :count]
    values = np.take_along_axis(values, chosen, axis=-1)
    vectors = np.take_along_axis(vectors, chosen[..., None, :], axis=-1)
    return values, root[..., :, None] * np.linalg.solve(np.swapaxes(half, -1, -2), vectors)


def found_anew(
    stiffness: Array, mass: Array, least: Array, squared: Array, vectors: Array, asked: str
) -> tuple[Array, Array]:
    """Modes in which those far above the lowest, which rounding hides in inverse iteration, are computed again.

    They are computed with shifts of the size of their own squared frequencies.

    Parameters
    ----------
    stiffness, mass
        Symmetric matrices, (..., n, n).
    least
        A shift of the size of the least squared frequency, with which the stiffness is positive definite, (...).
    squared, vectors
        Squared frequencies (..., count), in order, and modes (..., n, count), the higher ones with rounding errors.
    asked
        Beginning of the error message, such as ``"modes(5): the frame"``.

    Returns
    -------
    tuple of ndarray
        Squared frequencies and modes of unit modal mass.

    Raises
    ------
    FrameError
        If the frame has fewer modes with mass.
    """
    fewer = f"{asked} has fewer modes with mass: ask for fewer"
    while (far := np.asarray(squared > _APART * least[..., None])).any():
        least = np.where(far.any(axis=-1), np.where(far, squared, np.inf).min(axis=-1), least)
        if np.any(least > _highest(stiffness, mass)):
            raise FrameError(fewer)
        values, shapes = inverse_pencil(*shifted(stiffness, mass, least), mass, squared.shape[-1])
        values = above_rounding(values)
        squared = np.where(far, 1.0 / values - least[..., None], squared)
        vectors = np.where(far[..., None, :], shapes / np.sqrt(values)[..., None, :], vectors)
    size = np.abs(vectors)
    if np.any(zero_eigenvalue(mass.shape[-1]) * np.sum(size * (np.abs(mass) @ size), axis=-2) > 1.0):
        raise FrameError(fewer)  # the modal mass, which is one, is rounding of what it is made of
    return squared, vectors


def above_rounding(values: Array) -> Array:
    """Eigenvalues, the greatest first, none below its rounding error, which bounds the frequency of the mode."""
    return np.maximum(values, np.finfo(float).eps * np.abs(values[..., :1]))


def _highest(stiffness: Array, mass: Array) -> Array:
    """Upper bound on the squared frequencies of modes with mass, (...): greatest stiffness over least mass."""
    heavy, root = dense.scaled(mass)
    own = np.diagonal(stiffness, axis1=-2, axis2=-1) * root**2
    massive = np.diagonal(heavy, axis1=-2, axis2=-1) > 0.0
    return np.asarray(np.sum(own, axis=-1, where=massive) / zero_eigenvalue(heavy.shape[-1]))


def shifted(stiffness: Array, mass: Array, shift: Array) -> tuple[Array, Array]:
    """L of ``D (K + shift M) D = L L^T``, (..., n, n), and the diagonal of D, (..., n).

    Motions with neither stiffness nor mass, which are no modes, get a stiffness of one.
    """
    scaled, root = dense.scaled(stiffness + shift[..., None, None] * mass)
    values, vectors = np.linalg.eigh(scaled)
    zero = values <= zero_eigenvalue(values.shape[-1])
    return vectors * np.sqrt(np.where(zero, 1.0, values))[..., None, :], root


def extremes(matrix: scipy.sparse.csr_matrix) -> tuple[Array, Array]:
    """Least and greatest eigenvalue of a symmetric positive semidefinite matrix, by Lanczos."""
    from scipy.sparse.linalg import eigsh

    start = np.ones(matrix.shape[0])
    greatest = eigsh(matrix, k=1, v0=start, return_eigenvectors=False)
    try:
        least = eigsh(matrix.tocsc(), k=1, sigma=0.0, v0=start, return_eigenvectors=False)
    except RuntimeError:  # SuperLU raises it for an exactly zero pivot
        least = np.zeros(1)
    return np.asarray(least[0]), np.asarray(greatest[0])
