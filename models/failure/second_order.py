"""Probability beyond a limit state with curvature at its design point."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .limit_state import Index, LimitState

Array = NDArray[np.float64]

# Step of the differences of gradients, in scores.
STEP = 1e-3
# Step of the trapezoidal rule along the contour, and its end: the error by either is far below rounding.
FINE, FAR = 0.05, 10.0
# Allowed error of a curvature found by differences: on a sphere about the median every point is a nearest one.
NEARLY = 1e-4


def curvatures(limit: LimitState, scores: Array, pose: Index, normals: Array, slopes: Array) -> tuple[Array, Array]:
    """Principal curvatures (n, k - 1) of the limit state at design points, and their directions (n, k, k - 1).

    A curvature is positive if the limit state curves away from the median. The directions are columns.

    Parameters
    ----------
    limit
        The limit state.
    scores
        Design points (n, k).
    pose
        Numbers of their poses, (n,).
    normals
        Unit vectors of steepest descent of the limit state there, (n, k).
    slopes
        Lengths of the gradients there, (n,).
    """
    n, k = scores.shape
    shifts = STEP * np.concatenate([np.eye(k), -np.eye(k)])
    around = (scores[:, None] + shifts).reshape(-1, k)
    _, gradients = limit.linearised(around, np.repeat(pose, 2 * k))
    gradients = gradients.reshape(n, 2, k, k)
    hessian = (gradients[:, 0] - gradients[:, 1]) / (2.0 * STEP)
    hessian = 0.5 * (hessian + np.swapaxes(hessian, -1, -2)) / slopes[:, None, None]
    # The first column of a Householder reflection is the normal; the others span the tangent plane.
    tangents = np.linalg.qr(np.concatenate([normals[..., None], np.broadcast_to(np.eye(k), (n, k, k))], axis=-1))[0]
    plane = tangents[..., 1:k]
    found, directions = np.linalg.eigh(np.swapaxes(plane, -1, -2) @ hessian @ plane)
    return found, plane @ directions


def beyond_paraboloid(beta: Array, curvature: Array) -> Array:
    """Probability beyond paraboloids, (n,), with a relative error of some 1e-14.

    It is NaN where the design point is not the point of the paraboloid nearest to the median.

    With Y = u - ½ Σ κᵢ vᵢ² for independent standard normal u and vᵢ it is P(Y > β), by the inverse Laplace transform
    of ``exp(s²/2) Π (1 + κᵢ s)^(-1/2) / s`` along a line of real part c > 0 (the exact integral of Tvedt, J. Eng. Mech.
    116, 1990, doi:10.1061/(ASCE)0733-9399(1990)116:6(1183), on another contour).

    Parameters
    ----------
    beta
        Distances of the design points from the median, (n,), negative where the median fails.
    curvature
        Principal curvatures, (n, k - 1).
    """
    least = np.minimum(curvature.min(axis=-1, initial=0.0), -1e-300)
    singular = -1.0 / least
    nearest = np.all(1.0 + beta[:, None] * curvature > -NEARLY, axis=-1)
    # The contour keeps clear of the singularity, also for a sphere about the median, which has it at beta.
    real = np.minimum(np.clip(beta, 0.5, None), np.maximum(singular - 0.25, 0.5 * singular))
    steps = FINE * np.minimum(1.0, np.minimum(real, np.abs(singular - real)))
    count = int(np.ceil(FAR / max(float(steps.min(initial=FINE)), FINE / 100.0)))
    s = real[:, None] + 1j * steps[:, None] * np.arange(-count, count + 1)
    logarithm = -s * beta[:, None] + 0.5 * s * s
    for each in curvature.T:
        logarithm = logarithm - 0.5 * np.log(1.0 + each[:, None] * s)
    found = (np.exp(logarithm) / s).sum(axis=-1).real * steps / (2.0 * np.pi)
    return np.where(nearest, found, np.nan)
