"""Results of the paper's own formulas, to compare with a run."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from ...elements import Beam

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class EndMatrix:
    """A supposed stiffness matrix of a beam, with tests of properties that such a matrix must have.

    Attributes
    ----------
    matrix
        Matrix (12, 12) in the member's axes, ``ux uy uz rx ry rz`` at the start, then at the end.
    length
        Length of the member.
    """

    matrix: Array
    length: float

    def rigid_turn(self, angle: float) -> float:
        """Largest force or moment in a small rigid rotation about z at the start; 0 for a beam."""
        rotated = np.zeros(12)
        rotated[[5, 11]], rotated[7] = angle, angle * self.length
        return float(np.abs(self.matrix @ rotated).max())

    def exchange(self) -> float:
        """Largest change when the ends are exchanged, relative to the largest entry; 0 for a beam.

        Seen from its other end, the member is rotated by half a turn about z: x, y and the rotations about them change
        sign.
        """
        swap = np.roll(np.eye(12), 6, axis=0) * np.tile([-1.0, -1.0, 1.0], 4)
        return float(np.abs(swap @ self.matrix @ swap.T - self.matrix).max() / np.abs(self.matrix).max())

    def cantilever(self, force: float) -> tuple[float, float]:
        """Deflection and rotation of the free end of a cantilever under a transverse `force` there."""
        deflection, rotation = np.linalg.solve(self.matrix[np.ix_([7, 11], [7, 11])], [force, 0.0])
        return float(deflection), float(rotation)


def equation_6(beam: Beam, length: float) -> tuple[EndMatrix, EndMatrix]:
    """Eq. (6) of the paper, [[k, −k], [−k, k]] with the k of Eq. (7), and the beam's true matrix.

    Parameters
    ----------
    beam
        Beam of the link.
    length
        Length of the link.

    Returns
    -------
    tuple of EndMatrix
        The paper's matrix and the true one. Eq. (7) is the block of the true matrix for its start.
    """
    true = np.asarray(beam.stiffness_matrix(np.asarray(length)))
    k = true[:6, :6]
    return EndMatrix(np.block([[k, -k], [-k, k]]), length), EndMatrix(true, length)


def mean_direction(contact: float, deviation: float) -> float:
    """E[cos γ] of a normal contact angle: cos(mean) exp(−s²/2), with its standard deviation s in radians.

    Parameters
    ----------
    contact, deviation
        Mean and standard deviation of γ, degrees.

    Returns
    -------
    float
        Mean of ε cos γ divided by that of ε.

    Examples
    --------
    >>> round(mean_direction(180.0, 180.0), 5)
    -0.00719
    """
    return float(np.cos(np.radians(contact)) * np.exp(-0.5 * np.radians(deviation) ** 2))
