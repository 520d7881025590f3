"""Closed-form stiffness of a prismatic beam, and mass and geometric stiffness in one plane of bending.

The last two follow from the interdependent cubics: the mass from ``int rho A v^2 + rho I r^2 dx``, the geometric
stiffness from ``N int v'^2 dx`` (Przemieniecki, *Theory of Matrix Structural Analysis*, 1968,
ch. 11 and 15; Friedman & Kosmatka, Comput. Struct. 47 (1993) 473-481).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ..framework.protocol import Array
from .bending import Plane
from .direction import deformations
from .parameters import Real


def _rows(length: float) -> Array:
    """Deformations of the six springs of a beam per unit end displacement, about its middle, (6, 12)."""
    rows, middle = np.zeros((6, 12)), Plane(0.5, 0.5 * length, 0.5 * length, 0.0, 0.0)
    for at, number in deformations([middle, middle], np.array(length)).items():
        rows[at] = number
    return rows


# Deformations of the springs of a beam of unit length, by spring and end displacement.
_OF_UNIT = {at: float(k) for at, k in deformations([Plane(0.5, 0.5, 0.5, 0.0, 0.0)] * 2, np.array(1.0)).items()}
# The deformations are linear in the length: their constant part, and their part per unit of length.
_BY_ENDS = _rows(0.0)
_BY_LENGTH = _rows(1.0) - _BY_ENDS


class Mirrored(NamedTuple):
    """Entries of a symmetric 4 x 4 matrix on (v1, r1, v2, r2) that is the same seen from either end."""

    v1v1: Real
    v1r1: Real
    v1v2: Real
    v1r2: Real
    r1r1: Real
    r1r2: Real

    def stamp(self, matrix: Array, dofs: tuple[int, int, int, int], sign: float) -> None:
        """Write the entries into `matrix` at `dofs`; `sign` is the sign of rotations in the plane."""
        v1, r1, v2, r2 = dofs
        near, far = sign * self.v1r1, sign * self.v1r2
        matrix[..., v1, v1] = matrix[..., v2, v2] = self.v1v1
        matrix[..., r1, r1] = matrix[..., r2, r2] = self.r1r1
        matrix[..., v1, v2] = matrix[..., v2, v1] = self.v1v2
        matrix[..., r1, r2] = matrix[..., r2, r1] = self.r1r2
        matrix[..., v1, r1] = matrix[..., r1, v1] = near
        matrix[..., v2, r2] = matrix[..., r2, v2] = -near
        matrix[..., v1, r2] = matrix[..., r2, v1] = far
        matrix[..., v2, r1] = matrix[..., r1, v2] = -far


def prismatic_springs(flexibility: Array, length: Array) -> Array:
    """Stiffness of the springs of `linkframe.elements.Beam`, (6, ...), from the flexibility of its section, (6, ...).

    ``E A / L``, ``G J / L``, ``E I / L``, and ``12 E I / (L^3 (1 + phi))``, computed as
    ``1 / (L^3 / (12 E I) + L / (k G A))`` (Przemieniecki 1968, Eq. 5.116).
    """
    missing = (1,) * (length.ndim + 1 - flexibility.ndim)
    out: Array = flexibility.reshape(6, *missing, *flexibility.shape[1:]) * length
    # 1/12 about the middle, rounded as in `UniformPart`
    out[1:3] += out[5:3:-1] * length * length * (0.25 - 1.0 / 6.0)
    return np.divide(1.0, out, out=out)


def stiffness_of(inputs: Sequence[Any], length: Any) -> list[Any]:
    """`prismatic_springs` one by one, without shear deformation, from E, G, A, Iy, Iz and J; for terms as well."""
    E, G, A, Iy, Iz, J = inputs
    tension, torsion, about_y, about_z = (1.0 / (a * b) * length for a, b in ((E, A), (G, J), (E, Iy), (E, Iz)))
    across = [bend * length * length * (0.25 - 1.0 / 6.0) for bend in (about_z, about_y)]
    return [1.0 / each for each in (tension, *across, torsion, about_y, about_z)]


def prismatic_rows(length: Array) -> Array:
    """Deformations of the springs per unit end displacement, (6, 12, ...); they are linear in the length.

    Batch axes come last, so that the batch of each component is contiguous in memory.
    """
    missing = (1,) * length.ndim
    out: Array = _BY_LENGTH.reshape(6, 12, *missing) * length
    out += _BY_ENDS.reshape(6, 12, *missing)
    return out


def prismatic_deformations(length: Any) -> dict[tuple[int, int], Any]:
    """The numbers of `prismatic_rows` that are not zero, by spring and end displacement; for terms as well.

    Equal ones that vary are one object.
    """
    half = 0.5 * length
    arms = {0.5: half, -0.5: -half}
    return {at: arms.get(number, number) for at, number in _OF_UNIT.items()}


def bar_mass(per_length: Real, length: Real) -> tuple[Real, Real]:
    """Diagonal and off-diagonal entry of the mass matrix of a bar with linear shape functions, (...) each."""
    return per_length * length / 3.0, per_length * length / 6.0


def plane_mass(per_length: Real, rotary: Real, length: Real, phi: Real) -> Mirrored:
    """Consistent mass in one plane of bending, of translation (`per_length`, rho A) and rotation (`rotary`, rho I)."""
    m = per_length * length / (1.0 + phi) ** 2
    r = rotary / (length * (1.0 + phi) ** 2)
    turn = r * (0.1 - phi / 2.0) * length
    near = m * (1.0 / 105.0 + phi * (1.0 + phi / 2.0) / 60.0) + r * (2.0 / 15.0 + phi * (1.0 / 6.0 + phi / 3.0))
    far = -m * (1.0 / 140.0 + phi * (1.0 + phi / 2.0) / 60.0) - r * (1.0 / 30.0 + phi * (1.0 - phi) / 6.0)
    return Mirrored(
        m * (13.0 / 35.0 + phi * (7.0 / 10.0 + phi / 3.0)) + r * 1.2,
        m * (11.0 / 210.0 + phi * (11.0 / 120.0 + phi / 24.0)) * length + turn,
        m * (9.0 / 70.0 + phi * (3.0 / 10.0 + phi / 6.0)) - r * 1.2,
        -m * (13.0 / 420.0 + phi * (3.0 / 40.0 + phi / 24.0)) * length + turn,
        near * length**2,
        far * length**2,
    )


def plane_geometric(axial: Real, length: Real, phi: Real) -> Mirrored:
    """Geometric stiffness in one plane of bending under the axial force `axial`, tension positive."""
    g = axial / (length * (1.0 + phi) ** 2)
    sway, turn = g * (1.2 + phi * (2.0 + phi)), g * length / 10.0
    bow = phi * (1.0 + phi / 2.0) / 6.0
    return Mirrored(sway, turn, -sway, turn, g * (2.0 / 15.0 + bow) * length**2, -g * (1.0 / 30.0 + bow) * length**2)
