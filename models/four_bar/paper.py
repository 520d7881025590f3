"""What the paper's own formulas and printed numbers give, to lay beside a run."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

if TYPE_CHECKING:
    from ...elements import Beam
    from .motion import FourBarMotion

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class EndMatrix:
    """A 12 x 12 matrix that claims to be a beam's, and what a beam's must satisfy.

    Attributes
    ----------
    matrix
        (12, 12), in the member's axes, ``ux uy uz rx ry rz`` at the start, then at the end.
    length
        Length of the member.
    """

    matrix: Array
    length: float

    def rigid_turn(self, angle: float) -> float:
        """Largest force or moment after a small rigid turn about z of the start; 0 for a beam."""
        turned = np.zeros(12)
        turned[[5, 11]], turned[7] = angle, angle * self.length
        return float(np.abs(self.matrix @ turned).max())

    def exchange(self) -> float:
        """Largest change when the ends are exchanged, relative to the largest entry; 0 for a beam.

        Seen from its other end the member is turned about z by half a turn: x, y and their rotations change sign.
        """
        swap = np.roll(np.eye(12), 6, axis=0) * np.tile([-1.0, -1.0, 1.0], 4)
        return float(np.abs(swap @ self.matrix @ swap.T - self.matrix).max() / np.abs(self.matrix).max())

    def cantilever(self, force: float) -> tuple[float, float]:
        """Deflection and rotation of the free end of a cantilever under the transverse `force` on it."""
        deflection, rotation = np.linalg.solve(self.matrix[np.ix_([7, 11], [7, 11])], [force, 0.0])
        return float(deflection), float(rotation)


def equation_6(beam: Beam, length: float) -> tuple[EndMatrix, EndMatrix]:
    """Eq. (6) of the paper, [[k, −k], [−k, k]] with the k of Eq. (7), and the beam's true matrix.

    Parameters
    ----------
    beam
        The link.
    length
        Its length.

    Returns
    -------
    tuple of EndMatrix
        The paper's, the true one. Eq. (7) is the block of the true matrix that belongs to its start.
    """
    true = np.asarray(beam.stiffness_matrix(np.asarray(length)))
    k = true[:6, :6]
    return EndMatrix(np.block([[k, -k], [-k, k]]), length), EndMatrix(true, length)


def finite_rotation(motion: FourBarMotion, index: int, force: float, stiffness: float) -> Array:
    """Displacement of P at a singular pose with finite rotations and links that stretch, (2,).

    With the drive clamped the coupler turns about B by φ; the rocker then misses its pivot by
    ``m(φ) = |D(φ) − E| − c``, which the linkage takes up as tension or compression of its links, one spring in series
    as they lie in one line. The turn is where ``k m²/2 − F_y y_P(φ)`` is least. Bending is left out.

    Parameters
    ----------
    motion
        Motion of the linkage.
    index
        Number of the pose.
    force
        Force on P along y.
    stiffness
        Stiffness k of the line of coupler, rocker and joints, force per length.

    Returns
    -------
    ndarray
        Displacement of P in x and y, (2,).
    """
    b, p, d, e = (motion.position(name)[index, :2] @ [1.0, 1.0j] for name in "BPDE")
    rocker = abs(d - e)

    def energy(turn: float) -> float:
        way = np.exp(1j * turn)
        miss = abs(b + (d - b) * way - e) - rocker
        return float(0.5 * stiffness * miss**2 - force * ((p - b) * (way - 1.0)).imag)

    # The force turns the coupler to the side on which it does work, and not by a radian.
    side = np.copysign(1.0, force * (p - b).real)
    found = minimize_scalar(
        lambda turn: energy(side * turn), bounds=(0.0, 0.5), method="bounded", options={"xatol": 1e-10}
    )
    moved = (p - b) * (np.exp(1j * side * found.x) - 1.0)
    return np.array([moved.real, moved.imag])


def mean_direction(contact: float, deviation: float) -> float:
    """E[cos γ] of a normal contact angle: cos(mean) exp(−s²/2), with its standard deviation s in radians.

    Parameters
    ----------
    contact, deviation
        Mean and standard deviation of γ, degrees.

    Returns
    -------
    float
        Mean of ε cos γ over that of ε.

    Examples
    --------
    >>> round(mean_direction(180.0, 180.0), 5)
    -0.00719
    """
    return float(np.cos(np.radians(contact)) * np.exp(-0.5 * np.radians(deviation) ** 2))
