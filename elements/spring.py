"""The spring element along the line between two nodes, with or without preload."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..framework.protocol import Array, LineElement, proven
from ..framework.shape_rules import straight_shapes
from .parameters import Real, as_real, common_shape, not_negative, number

ALONG, ACROSS = 0, (1, 2)


@proven
@dataclass(frozen=True, eq=False, init=False)
class Spring(LineElement):
    """Spring along the line between two nodes, which transmits no moments.

    With the preload S in the undeformed shape (tension positive), the length L and the displacements along (u) and
    across (v, w) the line, ::

        N = S + k (u2 - u1),    across: S / L (v2 - v1),  S / L (w2 - w1)

    The part across is the geometric stiffness of a string (Przemieniecki, *Theory of Matrix Structural Analysis*,
    1968, ch. 15). By default S is in equilibrium in the undeformed shape and is not applied to the nodes.

    With `applied` the force S is one of the loads instead; apply it to both nodes by `Frame.load`, since the spring
    does not. The frame is then linearised about its shape without loads, where ``across`` is zero. The rotation of
    the force with the line is taken into account in buckling, in ``solution.linear`` and at large displacement.

    Parameters
    ----------
    stiffness : array_like
        Stiffness k, force per length, (...), zero or above.
    force : array_like
        Preload S in the undeformed shape, (...), tension positive.
    applied : bool
        Whether the loads on the frame hold the preload in equilibrium.

    Raises
    ------
    FrameError
        If the stiffness is negative, a number is not finite, or the shapes do not broadcast.

    Examples
    --------
    >>> spring = Spring(stiffness=2e3, force=50.0)
    >>> [float(k) for k in spring.stiffness_matrix(0.5).diagonal()[:3]]
    [2000.0, 100.0, 100.0]
    """

    stiffness: Real
    force: Real
    applied: bool

    def __init__(self, stiffness: ArrayLike, force: ArrayLike = 0.0, *, applied: bool = False) -> None:
        object.__setattr__(self, "stiffness", not_negative("Spring", "stiffness", stiffness))
        object.__setattr__(self, "force", number("Spring", "force", force))
        object.__setattr__(self, "applied", bool(applied))
        common_shape("Spring", {"stiffness": np.shape(self.stiffness), "force": np.shape(self.force)})

    @property
    def shape(self) -> tuple[int, ...]:
        """Batch shape: the broadcast of stiffness and force."""
        return np.broadcast_shapes(np.shape(self.stiffness), np.shape(self.force))

    @property
    def kind(self) -> Hashable:
        """The spring itself: each is evaluated on its own."""
        return self

    @property
    def exact(self) -> bool:
        return True

    @property
    def balanced(self) -> bool:
        """Whether a rigid motion costs no energy: a preload resists rotation of its line, unless loads hold it."""
        return self.applied or not np.any(self.force)

    @property
    def tension(self) -> Array:
        return np.asarray(self.force if self.applied else 0.0)

    @property
    def quadrature(self) -> int:
        """Number of Gauss points for a linear load times the linear shape functions."""
        return 2

    def part(self, index: int, count: int) -> Spring:
        return self if count == 1 else Spring(count * np.asarray(self.stiffness), self.force, applied=self.applied)

    def stiffness_matrix(self, length: Array | float) -> Array:
        """Stiffness in local axes: along the line that of the spring, across it the geometric stiffness of the preload.

        Parameters
        ----------
        length
            Length of the spring, (...).

        Returns
        -------
        ndarray
            Forces on both ends per unit displacement of the ends, (..., 12, 12); zero for moments and rotations.
        """
        return self._stamped(self.stiffness, self._across(length))

    def springs(self, length: Array | float) -> tuple[Array, Array]:
        across = self._across(length)
        shape = np.broadcast_shapes(np.shape(across), np.shape(self.stiffness))
        # deformations per unit displacement do not vary with the stiffness
        stiffness, rows = np.zeros((*shape, 6)), np.zeros((*np.shape(length), 6, 12))
        for i, k in zip((ALONG, *ACROSS), (self.stiffness, across, across), strict=True):
            stiffness[..., i], rows[..., i, i], rows[..., i, i + 6] = k, -1.0, 1.0
        return stiffness, rows

    def mass_matrix(self, length: Array | float) -> Array:
        return np.zeros((*np.shape(length), 12, 12))

    def geometric_matrix(self, length: Array | float, axial: Array | float) -> Array:
        """Stiffness across the line under an axial force, in local axes.

        Parameters
        ----------
        length
            Length of the spring, (...).
        axial
            Axial force, (...), tension positive.

        Returns
        -------
        ndarray
            Forces on both ends per unit displacement of the ends, (..., 12, 12): ``axial / length`` across the line.
        """
        return self._stamped(0.0, as_real(axial) / as_real(length))

    def end_forces(self, length: Array | float, displacement: Array) -> Array:
        stiffness, _ = self.springs(length)
        moved = np.asarray(displacement, dtype=np.float64)
        force = stiffness * (moved[..., 6:] - moved[..., :6])
        return np.concatenate([-force, force], axis=-1)

    def shape_functions(self, length: Array | float, x: Array | float) -> Array:
        return straight_shapes(np.asarray(length), np.asarray(x))

    def _across(self, length: Array | float) -> Real:
        return (self.force - self.tension) / as_real(length)

    def _stamped(self, along: Real, across: Real) -> Array:
        shape = np.broadcast_shapes(np.shape(along), np.shape(across), self.shape)
        matrix = np.zeros((*shape, 12, 12))
        for i, k in zip((ALONG, *ACROSS), (along, across, across), strict=True):
            matrix[..., i, i] = matrix[..., i + 6, i + 6] = k
            matrix[..., i, i + 6] = matrix[..., i + 6, i] = -np.asarray(k)
        return matrix
