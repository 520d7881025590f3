"""The interface between the framework and joints between two nodes, `JointElement`."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any, ClassVar

import numpy as np

from .batch import Array
from .clearances.contact import law
from .entries import Change


class JointElement(ABC):
    """Six springs between two coincident nodes, in the joint's own axes, or a nonlinear law by `resistance`.

    Linear solutions use the springs, and contact where there is clearance. The tangent of a nonlinear law at zero
    displacement must agree with the springs, else linear solutions refuse the joint. What a joint returns is checked
    when it is added to a frame.

    Attributes
    ----------
    stiffness
        Six springs, (..., 6), force per length and moment per radian, each from 0 (free) to inf (ideal).
    axes
        The joint's axes as columns in global components, (..., 3, 3); None for the global axes.
    clearance
        Radius of the ball inside which the `clearance_directions` are free, (...); 0 for none.
    clearance_directions
        Indices of the components with clearance, all of equal stiffness; empty for none.
    pitch
        Advance along z per turn about z, (...), length: the spring along z acts on ``uz - pitch rz / (2 pi)``.
    has_law
        Whether the joint defines a nonlinear law, overriding `resistance`.
    """

    stiffness: Array
    axes: Array | None
    clearance: Array
    clearance_directions: tuple[int, ...]
    pitch: Array
    has_law: ClassVar[bool] = False

    def __init_subclass__(cls, **given: Any) -> None:
        super().__init_subclass__(**given)
        cls.has_law = cls.resistance is not JointElement.resistance

    @property
    @abstractmethod
    def shape(self) -> tuple[int, ...]:
        """Batch shape of the element's own parameters."""

    @abstractmethod
    def matrix(self) -> Array:
        """Stiffness matrix of the two nodes, by springs, axes and pitch.

        Returns
        -------
        ndarray
            In global axes, first node before second, (..., 12, 12): force per length and moment per radian.
        """

    @abstractmethod
    def typical(self) -> JointElement:
        """A joint without clearance whose springs are the stiffest of the batch.

        Returns
        -------
        JointElement
            Joint with a stiffness (6,) that does not vary over the batch, and with the same axes and pitch.
        """

    def resistance(self, displacement: Array, pick: Change) -> tuple[Array, Array, Array]:
        """Energy, forces and tangent stiffness at a displacement, of the springs and of contact in clearances.

        A joint with a nonlinear law overrides this; large displacement then uses it for all components that are not
        ideal. Forces must be the gradient of the energy, and the tangent its second derivative (at a kink of the force,
        that of either side).

        Parameters
        ----------
        displacement
            Displacement of the second node relative to the first, less an imposed offset, in the joint's axes, (m, 6).
        pick
            ``pick(array, trailing)`` takes from a parameter, whose last `trailing` axes are no batch axes, the m rows
            that belong to the displacements.

        Returns
        -------
        energy, force, tangent
            Energy (m,), forces (m, 6) and tangent stiffness (m, 6, 6), zero for ideal components; see
            `linkframe.framework.clearances.contact.law`.
        """
        springs = np.where(np.isinf(self.stiffness), 0.0, self.stiffness)
        free = list(self.clearance_directions)
        stiffness = pick(springs, 1) + 0.0 * displacement
        contact = stiffness[:, free[0]].copy() if free else np.zeros(len(displacement))
        stiffness[:, free] = 0.0
        energy, force = 0.5 * np.sum(stiffness * displacement**2, axis=-1), stiffness * displacement
        tangent = stiffness[:, :, None] * np.eye(6)
        if free:
            generalised_force, turning, stored = law(
                displacement[:, free], pick(self.clearance[..., None], 1)[:, 0], contact
            )
            force[:, free] = generalised_force
            tangent[np.ix_(range(len(force)), free, free)] = turning
            energy = energy + stored
        return energy, force, tangent

    def springs_matrix(self) -> Array:
        """Stiffness matrix of the two nodes for finite springs, by axes and pitch.

        Returns
        -------
        ndarray
            In global axes, first node before second, (..., 12, 12): force per length and moment per radian.
        """
        axes = np.eye(3) if self.axes is None else self.axes
        acts = np.zeros((*np.broadcast_shapes(axes.shape[:-2], self.pitch.shape), 6, 6))
        acts[..., :3, :3] = acts[..., 3:, 3:] = axes
        acts[..., 3:, 2] = -self.pitch[..., None] / (2.0 * np.pi) * axes[..., :, 2]
        # the products commute, so that the block is symmetric to the last bit
        dyads = acts[..., :, None, :] * acts[..., None, :, :]
        block = np.sum(self.stiffness[..., None, None, :] * dyads, axis=-1)
        near = np.concatenate([block, -block], axis=-1)
        return np.concatenate([near, -near], axis=-2)
