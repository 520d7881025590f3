"""The point mass: a rigid body attached to one node."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..framework.batch import numbers
from ..framework.errors import FrameError
from ..framework.protocol import Array, PointElement, proven
from .parameters import Real, common_shape, not_negative, require

# Asymmetry and negative moments up to this share of a tensor's largest entry are rounding, as after a rotation.
_ROUNDING = 1e-12


@proven
@dataclass(frozen=True, eq=False, init=False)
class PointMass(PointElement):
    """Rigid body attached to a node.

    With the offset o from the node to the centre of mass, whose velocity is ``u' + r' x o``, the parallel-axis theorem
    gives (Featherstone, *Rigid Body Dynamics Algorithms*, 2008, ch. 2), ::

        M = [[m I, -m S], [m S, I_c - m S S]],    S x = o x x

    Parameters
    ----------
    mass : array_like
        Mass, (...), zero or above.
    inertia : array_like
        Moments of inertia about the centre of mass in global axes, mass times length squared: three principal moments
        (..., 3), or a symmetric tensor (..., 3, 3) without negative principal moments. An array whose shape ends in
        (3, 3) is taken as a tensor.
    offset : array_like
        Vector from the node to the centre of mass in global axes, (..., 3), length.

    Raises
    ------
    FrameError
        If the mass or an inertia is negative, a shape is wrong, or the tensor is not symmetric.

    Examples
    --------
    >>> flywheel = PointMass(2.0, inertia=(0.1, 0.1, 0.2))
    >>> [float(m) for m in flywheel.mass_matrix().diagonal()]
    [2.0, 2.0, 2.0, 0.1, 0.1, 0.2]
    """

    mass: Real
    inertia: Array
    offset: Array

    def __init__(
        self, mass: ArrayLike, inertia: ArrayLike = (0.0, 0.0, 0.0), offset: ArrayLike = (0.0, 0.0, 0.0)
    ) -> None:
        object.__setattr__(self, "mass", not_negative("PointMass", "mass", mass))
        object.__setattr__(self, "inertia", _tensor(numbers(inertia, "PointMass: inertia")))
        object.__setattr__(self, "offset", numbers(offset, "PointMass: offset"))
        if self.offset.shape[-1:] != (3,):
            raise FrameError(f"PointMass: offset has shape {self.offset.shape}; give three numbers, (..., 3)")
        require("PointMass", "offset", self.offset, np.isfinite(self.offset), "finite; give a length")
        common_shape(
            "PointMass",
            {"mass": np.shape(self.mass), "inertia": self.inertia.shape[:-2], "offset": self.offset.shape[:-1]},
        )

    @property
    def shape(self) -> tuple[int, ...]:
        """Batch shape: the broadcast of mass, inertia and offset."""
        return np.broadcast_shapes(np.shape(self.mass), self.inertia.shape[:-2], self.offset.shape[:-1])

    def mass_matrix(self) -> Array:
        """Mass matrix of the node in global axes.

        Returns
        -------
        ndarray
            Symmetric matrix by ``ux uy uz rx ry rz``, (..., 6, 6).

        Examples
        --------
        A mass of 2 kg at 0.5 m from its node has a moment of inertia of 0.5 kg m^2 about the node.

        >>> from linkframe.elements import PointMass
        >>> PointMass(2.0, offset=(0.5, 0.0, 0.0)).mass_matrix().diagonal().tolist()
        [2.0, 2.0, 2.0, 0.0, 0.5, 0.5]
        """
        x, y, z = np.moveaxis(self.offset, -1, 0)
        cross = np.zeros((*self.offset.shape[:-1], 3, 3))
        cross[..., 0, 1], cross[..., 0, 2], cross[..., 1, 2] = -z, y, -x
        cross -= np.swapaxes(cross, -1, -2)
        mass = np.asarray(self.mass)[..., None, None]
        matrix = np.zeros((*self.shape, 6, 6))
        matrix[..., :3, :3] = mass * np.eye(3)
        matrix[..., :3, 3:] = -mass * cross
        matrix[..., 3:, :3] = mass * cross
        outer = self.offset[..., :, None] * self.offset[..., None, :]
        square = np.sum(self.offset**2, axis=-1)[..., None, None]
        matrix[..., 3:, 3:] = self.inertia + mass * (square * np.eye(3) - outer)
        return matrix


def _tensor(inertia: Array) -> Array:
    """Principal moments (..., 3) or a tensor (..., 3, 3) as a checked tensor (..., 3, 3)."""
    if inertia.shape[-1:] != (3,):
        raise FrameError(f"PointMass: inertia has shape {inertia.shape}; give (..., 3) or (..., 3, 3)")
    require("PointMass", "inertia", inertia, np.isfinite(inertia), "finite; give a moment of inertia")
    if inertia.shape[-2:] != (3, 3):
        require("PointMass", "inertia", inertia, inertia >= 0.0, "zero or above; give its magnitude")
        return numbers(inertia[..., :, None] * np.eye(3), "PointMass: inertia")
    rounding = _ROUNDING * np.max(np.abs(inertia), axis=(-2, -1))
    other = np.swapaxes(inertia, -1, -2)
    if np.any(np.abs(inertia - other) > rounding[..., None, None]):
        raise FrameError("PointMass: inertia is not symmetric; give the tensor with Ixy = Iyx, Ixz = Izx, Iyz = Izy")
    inertia = numbers(0.5 * inertia + 0.5 * other, "PointMass: inertia")
    least: Array = np.asarray(np.linalg.eigvalsh(inertia)[..., 0], dtype=np.float64)
    require("PointMass", "inertia (least principal moment)", least, least >= -rounding, "zero or above")
    return inertia
