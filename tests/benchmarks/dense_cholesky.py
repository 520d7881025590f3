"""Numba's way: each sample's textbook matrix on its own, by a compiled loop that assembles it and solves by Cholesky.

Plane frame and grillage in global axes in closed form (McGuire, Gallagher & Ziemian, Matrix Structural Analysis,
sections 4.5 and 5.1): what a programmer writes who knows that the linkage lies in the plane.
"""

from __future__ import annotations

import numba
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@numba.njit(cache=False)  # type: ignore[untyped-decorator]
def displacements(
    places: Array,
    ends: NDArray[np.int64],
    joints: NDArray[np.int64],
    modulus: Array,
    section: Array,
    stiffness: Array,
    loads: Array,
    components: NDArray[np.int64],
    node: int,
) -> Array:
    """Displacement of a node, (samples, 6).

    Parameters
    ----------
    places
        Coordinates x, y of the nodes, (samples, nodes, 2), the first and the last of which are clamped.
    ends, joints
        Nodes of each member, (members, 2), and of each joint, (joints, 2).
    modulus
        E and G of each member, (samples, members, 2).
    section
        A, Iy, Iz and J of all members.
    stiffness
        Six springs of each joint, (samples, joints, 6).
    loads
        On each node, (samples, nodes, 6).
    components
        Which of ux uy uz rx ry rz are unknown.
    node
        Number of the node.
    """
    samples, nodes = places.shape[:2]
    width = len(components)
    size = width * (nodes - 2)
    place = np.full(6, -1)
    place[components] = np.arange(width)
    found = np.zeros((samples, 6))
    matrix, right, pair, dofs = np.empty((size, size)), np.empty(size), np.empty((12, 12)), np.empty(12, np.int64)
    for sample in range(samples):
        matrix[:] = 0.0
        for k in range(len(ends)):
            start, end = ends[k]
            x, y = places[sample, end] - places[sample, start]
            _member(x, y, modulus[sample, k], section, pair)
            _dofs(start, end, place, width, size, dofs)
            _add(matrix, pair, dofs)
        for k in range(len(joints)):
            start, end = joints[k]
            pair[:] = 0.0
            for c in range(6):
                spring = stiffness[sample, k, c]
                pair[c, c] = pair[c + 6, c + 6] = spring
                pair[c, c + 6] = pair[c + 6, c] = -spring
            _dofs(start, end, place, width, size, dofs)
            _add(matrix, pair, dofs)
        for n in range(nodes - 2):
            for c in range(width):
                right[width * n + c] = loads[sample, n + 1, components[c]]
        _solve(matrix, right)
        for c in range(width):
            found[sample, components[c]] = right[width * (node - 1) + c]
    return found


@numba.njit  # type: ignore[untyped-decorator]
def _dofs(start: int, end: int, place: Array, width: int, size: int, dofs: NDArray[np.int64]) -> None:
    """Number of each of a pair's unknowns, -1 for those that are not there."""
    for side in range(2):
        first = width * ((start if side == 0 else end) - 1)
        for c in range(6):
            free = place[c] >= 0 and 0 <= first < size
            dofs[6 * side + c] = first + place[c] if free else -1


@numba.njit  # type: ignore[untyped-decorator]
def _add(matrix: Array, pair: Array, dofs: NDArray[np.int64]) -> None:
    """Add to the upper triangle."""
    for i in range(12):
        if dofs[i] >= 0:
            for j in range(12):
                if dofs[j] >= dofs[i]:
                    matrix[dofs[i], dofs[j]] += pair[i, j]


@numba.njit  # type: ignore[untyped-decorator]
def _member(x: float, y: float, modulus: Array, section: Array, out: Array) -> None:
    """Stiffness (12, 12) of a member along (x, y)."""
    length = np.sqrt(x * x + y * y)
    c, s = x / length, y / length
    area, inertia_y, inertia_z, torsion = section
    out[:] = 0.0
    # plane frame: ux uy rz
    a, b = modulus[0] * area / length, 12.0 * modulus[0] * inertia_z / length**3
    d, e = 0.5 * b * length, b * length * length / 3.0
    for i, j, sign in ((0, 0, 1.0), (6, 6, 1.0), (0, 6, -1.0), (6, 0, -1.0)):
        out[i, j] = sign * (a * c * c + b * s * s)
        out[i + 1, j + 1] = sign * (a * s * s + b * c * c)
        out[i, j + 1] = out[i + 1, j] = sign * (a - b) * c * s
    for i in (0, 6):
        sign = 1.0 if i == 0 else -1.0
        for j in (5, 11):
            out[i, j] = out[j, i] = -sign * d * s
            out[i + 1, j] = out[j, i + 1] = sign * d * c
    out[5, 5] = out[11, 11] = e
    out[5, 11] = out[11, 5] = 0.5 * e
    # grillage: uz rx ry
    t, b = modulus[1] * torsion / length, 12.0 * modulus[0] * inertia_y / length**3
    d, e = 0.5 * b * length, b * length * length / 3.0
    for i, j, sign in ((2, 2, 1.0), (8, 8, 1.0), (2, 8, -1.0), (8, 2, -1.0)):
        out[i, j] = sign * b
        same = 1.0 if i == j else 0.5
        out[i + 1, j + 1] = sign * t * c * c + same * e * s * s
        out[i + 2, j + 2] = sign * t * s * s + same * e * c * c
        out[i + 1, j + 2] = out[i + 2, j + 1] = (sign * t - same * e) * c * s
    for i in (2, 8):
        sign = 1.0 if i == 2 else -1.0
        for j in (2, 8):
            out[i, j + 1] = out[j + 1, i] = sign * d * s
            out[i, j + 2] = out[j + 2, i] = -sign * d * c


@numba.njit  # type: ignore[untyped-decorator]
def _solve(matrix: Array, right: Array) -> None:
    """Cholesky in the upper triangle, in place, and both substitutions; rows lie together in memory."""
    size = len(right)
    for k in range(size):
        root = np.sqrt(matrix[k, k])
        for j in range(k, size):
            matrix[k, j] /= root
        for i in range(k + 1, size):
            factor = matrix[k, i]
            for j in range(i, size):
                matrix[i, j] -= factor * matrix[k, j]
    for k in range(size):
        right[k] /= matrix[k, k]
        for i in range(k + 1, size):
            right[i] -= matrix[k, i] * right[k]
    for k in range(size - 1, -1, -1):
        total = right[k]
        for j in range(k + 1, size):
            total -= matrix[k, j] * right[j]
        right[k] = total / matrix[k, k]
