"""Probability beyond a limit state that is curved at its design point."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .limit_state import Index, LimitState

Array = NDArray[np.float64]

# Step of the second differences in scores.
STEP = 1e-3
# Step of the trapezoidal rule along the contour, and where it ends: both far below rounding.
FINE, FAR = 0.05, 10.0
# By how much a curvature, by differences, may be off: on a sphere about the median every point is a nearest one.
NEARLY = 1e-4


def curvatures(limit: LimitState, scores: Array, pose: Index, normals: Array, slopes: Array) -> tuple[Array, Array]:
    """Principal curvatures of the limit state at design points, and their directions.

    They are (n, k - 1), positive where the limit state bends from the median, and (n, k, k - 1), columns.

    Parameters
    ----------
    limit
        The limit state.
    scores
        Design points (n, k).
    pose
        Their poses, (n,).
    normals
        Directions of failure there, of unit length, (n, k).
    slopes
        Sizes of the gradients there, (n,).
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
    """Probability beyond paraboloids, (n,), to some 1e-14 of itself; NaN where a design point is no nearest point.

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
    # Well off the singularity, also where a sphere about the median has it at beta.
    real = np.minimum(np.clip(beta, 0.5, None), np.maximum(singular - 0.25, 0.5 * singular))
    steps = FINE * np.minimum(1.0, np.minimum(real, np.abs(singular - real)))
    count = int(np.ceil(FAR / max(float(steps.min(initial=FINE)), FINE / 100.0)))
    s = real[:, None] + 1j * steps[:, None] * np.arange(-count, count + 1)
    logarithm = -s * beta[:, None] + 0.5 * s * s
    for each in curvature.T:
        logarithm = logarithm - 0.5 * np.log(1.0 + each[:, None] * s)
    found = (np.exp(logarithm) / s).sum(axis=-1).real * steps / (2.0 * np.pi)
    return np.where(nearest, found, np.nan)
