"""Six springs between two coincident nodes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..framework.errors import FrameError
from ..framework.protocol import Array, JointElement
from .parameters import array_of, common_shape, require

ORTHONORMAL = 1e-9


@dataclass(frozen=True, eq=False, init=False)
class Joint(JointElement):
    """Three springs and three rotational springs between two coincident nodes.

    With the relative displacement ``d = u2 - u1`` the joint pulls its first node with
    ``f = diag(stiffness) d``, and the second with -f (Eq. 5 of the four-bar paper:
    ``[[k, -k], [-k, k]]``).

    Parameters
    ----------
    stiffness : array_like
        ``ktx kty ktz krx kry krz``, (..., 6), force per length and moment per radian, each from 0
        (free) to inf (ideal).
    axes : array_like, optional
        Joint axes as columns, (..., 3, 3), in global components, orthonormal and right-handed;
        the global axes if not given.

    Raises
    ------
    FrameError
        If a stiffness is negative or NaN, if there are not six, or if `axes` are not orthonormal.

    Examples
    --------
    >>> revolute = Joint(stiffness=(2e11, 2e11, 2e11, 2e11, 2e11, 0.0))
    >>> revolute.matrix().shape
    (12, 12)
    """

    stiffness: Array
    axes: Array | None

    def __init__(self, stiffness: ArrayLike, axes: ArrayLike | None = None) -> None:
        springs = array_of("Joint", "stiffness", stiffness)
        if springs.shape[-1:] != (6,):
            raise FrameError(f"Joint: stiffness has shape {springs.shape}; give six springs, (..., 6)")
        require("Joint", "stiffness", springs, springs >= 0.0, "0 (free) to inf (ideal)")
        turned = None if axes is None else _checked_axes(axes)
        common_shape("Joint", {"stiffness": springs.shape[:-1], "axes": () if turned is None else turned.shape[:-2]})
        object.__setattr__(self, "stiffness", springs)
        object.__setattr__(self, "axes", turned)

    @property
    def shape(self) -> tuple[int, ...]:
        """Batch shape: the broadcast of stiffness and axes."""
        return np.broadcast_shapes(self.stiffness.shape[:-1], () if self.axes is None else self.axes.shape[:-2])

    def matrix(self) -> Array:
        """Stiffness of the two nodes in global axes, (..., 12, 12).

        Raises
        ------
        FrameError
            If a spring is infinite: an ideal component is a constraint, not a stiffness.
        """
        rigid = np.isinf(self.stiffness).reshape(-1, 6).any(axis=0)
        if rigid.any():
            name = ("ktx", "kty", "ktz", "krx", "kry", "krz")[int(rigid.argmax())]
            raise FrameError(f"Joint: {name} = inf has no stiffness matrix; give a finite spring")
        block = np.zeros((*self.shape, 6, 6))
        axes = np.eye(3) if self.axes is None else self.axes
        for part in (slice(0, 3), slice(3, 6)):
            # the products commute, so that the block is symmetric to the last bit
            dyads = axes[..., :, None, :] * axes[..., None, :, :]
            block[..., part, part] = np.sum(self.stiffness[..., None, None, part] * dyads, axis=-1)
        near = np.concatenate([block, -block], axis=-1)
        return np.concatenate([near, -near], axis=-2)


def _checked_axes(axes: ArrayLike) -> Array:
    columns = array_of("Joint", "axes", axes)
    if columns.shape[-2:] != (3, 3):
        raise FrameError(f"Joint: axes has shape {columns.shape}; give the three axes as columns, (..., 3, 3)")
    gap = np.max(np.abs(np.swapaxes(columns, -1, -2) @ columns - np.eye(3)), initial=0.0)
    if not gap < ORTHONORMAL:
        raise FrameError(f"Joint: axes are not orthonormal (by {gap:.1e}); give three unit vectors, as columns")
    if np.any(np.linalg.det(columns) < 0.0):
        raise FrameError("Joint: axes are left-handed; turn one of the columns round")
    return columns
