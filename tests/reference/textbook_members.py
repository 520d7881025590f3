"""Matrices of members in their own axes as textbooks have them, without linkframe: bars, and slender beams on a
foundation.

Przemieniecki, *Theory of Matrix Structural Analysis*, 1968: stiffness ch. 5, consistent mass ch. 11, geometric
stiffness ch. 15. A Winkler foundation of modulus k resists as a beam of mass k per length does.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
# Displacements and rotations of both ends that bend a member in its xy and in its xz plane; which are lengths.
PLANES = (([1, 5, 7, 11], 1.0), ([2, 4, 8, 10], -1.0))


@dataclass(frozen=True)
class TextbookMember:
    """Stiffness and mass, (12, 12) each, geometric stiffness of a unit axial force, and end forces of heat (12,)."""

    stiffness: Array
    mass: Array
    geometric: Array
    heat: Array
    axial_stiffness: float


def _in_plane(matrix: Array, length: float, sign: float) -> Array:
    """A matrix by deflections and ``length times`` rotations, by deflections and rotations of one sense."""
    scale = np.array([1.0, sign * length, 1.0, sign * length])
    return np.asarray(scale[:, None] * matrix * scale)


BENDING = np.array([[12, 6, -12, 6], [6, 4, -6, 2], [-12, -6, 12, -6], [6, 2, -6, 4]], dtype=float)
CARRIED = np.array([[156, 22, 54, -13], [22, 4, 13, -3], [54, 13, 156, -22], [-13, -3, -22, 4]]) / 420.0
SWAY = np.array([[36, 3, -36, 3], [3, 4, -3, -1], [-36, -3, 36, -3], [3, -1, -3, 4]]) / 30.0
ALONG, SHARED = np.array([[1.0, -1.0], [-1.0, 1.0]]), np.array([[2.0, 1.0], [1.0, 2.0]]) / 6.0


def bar(k: float, mass: float, length: float) -> TextbookMember:
    """A bar that resists its elongation alone by `k`, force per length, of so much mass per length."""
    stiffness, carried, sway = np.zeros((3, 12, 12))
    for i in range(3):
        ends = np.ix_([i, i + 6], [i, i + 6])
        carried[ends] = mass * length * SHARED
        if i:
            sway[ends] = ALONG / length
        else:
            stiffness[ends] = k * ALONG
    return TextbookMember(stiffness, carried, sway, np.zeros(12), k)


def footing(EA: float, GJ: float, EI: float, modulus: float, mass: float, length: float) -> TextbookMember:
    """A slender beam whose deflection along its own y a foundation of so much `modulus` resists."""
    stiffness, carried, sway = np.zeros((3, 12, 12))
    for i, rigidity in ((0, EA), (3, GJ)):
        stiffness[np.ix_([i, i + 6], [i, i + 6])] = rigidity / length * ALONG
    carried[np.ix_([0, 6], [0, 6])] = mass * length * SHARED
    for dofs, sign in PLANES:
        at = np.ix_(dofs, dofs)
        stiffness[at] = _in_plane(EI / length**3 * BENDING, length, sign)
        carried[at] = _in_plane(mass * length * CARRIED, length, sign)
        sway[at] = _in_plane(SWAY / length, length, sign)
    dofs, sign = PLANES[0]
    stiffness[np.ix_(dofs, dofs)] += _in_plane(modulus * length * CARRIED, length, sign)
    return TextbookMember(stiffness, carried, sway, np.zeros(12), EA / length)


def level_axes(chord: Array) -> Array:
    """Axes as rows, (3, 3): x along a chord that is not vertical, y level, z upwards."""
    x = chord / np.linalg.norm(chord)
    y = np.cross([0.0, 0.0, 1.0], x)
    y /= np.linalg.norm(y)
    return np.stack([x, y, np.cross(x, y)])


def in_global_axes(matrix: Array, axes: Array) -> Array:
    """A matrix (12, 12), or forces (12,), in global axes."""
    turn = np.kron(np.eye(4), axes)
    return np.asarray(turn.T @ matrix @ turn if matrix.ndim == 2 else turn.T @ matrix)
