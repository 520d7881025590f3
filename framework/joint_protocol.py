"""What the framework asks of a joint between two nodes."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any, ClassVar

import numpy as np

from .batch import Array
from .clearances.contact import law
from .entries import Change


class JointElement(ABC):
    """Six springs between two coincident nodes, in the joint's own axes, or a law of its own by `resistance`.

    Linear solutions follow the springs, and contact where there is clearance: a law must agree with them at rest, or it
    is refused there. What a joint returns is examined when it is added to a frame.

    Attributes
    ----------
    stiffness
        (..., 6), each 0 (free) to inf (ideal).
    axes
        (..., 3, 3), the joint's axes as columns in global components; None for the global axes.
    clearance
        (...), radius of the ball inside which the `clearance_directions` are free; 0 for none.
    clearance_directions
        Indices of these components, of equal stiffness; empty for none.
    pitch
        (...), advance along z per turn about z: the spring along z acts on what differs from it.
    has_law
        Whether `resistance` is its own and not that of springs and contact.
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
        """Stiffness of the two nodes: what springs, axes and pitch make.

        Returns
        -------
        ndarray
            In global axes, first node before second, (..., 12, 12): force per length and moment per radian.
        """

    @abstractmethod
    def typical(self) -> JointElement:
        """The joint without clearance, each of its springs the stiffest in the batch.

        It has no batch of its own but that of its geometry.

        Returns
        -------
        JointElement
            Its stiffness (6,), its axes and pitch as they are.
        """

    def resistance(self, displacement: Array, pick: Change) -> tuple[Array, Array, Array]:
        """Energy, force and tangent at a displacement in the joint's axes: of springs, and of contact in clearances.

        A joint of another law overrides this; large displacement then follows it in place of the springs of all
        components that are not ideal. Forces must be the gradient of the energy, and the tangent its second derivative
        (where the force has a kink, that of either side).

        Parameters
        ----------
        displacement
            Displacement (m, 6) of the second node from the first, or from an imposed offset.
        pick
            ``pick(array, trailing)`` takes the m rows of a parameter that belong to the displacements.

        Returns
        -------
        energy, force, tangent
            (m,), (m, 6) and (m, 6, 6), see `linkframe.framework.clearances.contact.law`; nothing from ideal components.
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
        """Stiffness that finite springs, axes and pitch make of the two nodes.

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
