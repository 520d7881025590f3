"""What the framework asks of an element; it knows nothing else about beams, joints or masses.

All arrays are stacks: batch axes first, components last. Forces and displacements of a line
element are in its local axes, start node before end node, each ``ux uy uz rx ry rz``.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Hashable
from dataclasses import fields, is_dataclass
from typing import Any, Self, TypeVar

import numpy as np
from numpy.typing import NDArray

from .clearances.contact import law
from .errors import FrameError

Array = NDArray[np.float64]
# Changes a parameter; the number says how many of its last axes are no batch axes.
Change = Callable[[Array, int], Array]
_Element = TypeVar("_Element", bound=type)
_PROVEN = "_proven"


def proven(kind: _Element) -> _Element:
    """Mark a class of elements whose answers its own tests prove, so that a frame need not examine them.

    A subclass is examined, as it may answer otherwise.
    """
    setattr(kind, _PROVEN, kind)
    return kind


def is_proven(element: object) -> bool:
    """Whether the class of an element is marked as `proven` itself."""
    return getattr(type(element), _PROVEN, None) is type(element)


class LineElement(ABC):
    """A straight member between two nodes: stiffness, mass and recovery in its own axes.

    What an element returns is examined when it is added to a frame, see `linkframe.framework.examined`.

    Attributes
    ----------
    segments
        Number of equal parts into which the framework cuts the member.
    releases
        Released end components as ``(end, component)``, end 0 or 1, component 0 to 5.
    """

    segments: int
    releases: tuple[tuple[int, int], ...]

    @property
    @abstractmethod
    def shape(self) -> tuple[int, ...]:
        """Batch shape of the element's own parameters."""

    @property
    @abstractmethod
    def kind(self) -> Hashable:
        """Equal for two elements that answer alike, so that one is asked for both; `self` where none other does."""

    @property
    @abstractmethod
    def exact(self) -> bool:
        """Whether in statics one piece is exact, so that segments change nothing."""

    @property
    def roundings(self) -> float:
        """Roundings, half a unit in the last place each, that the stiffnesses of `springs` may be off.

        What derives a section's properties from its sizes counts as well.
        """
        return 100.0

    @property
    def balanced(self) -> bool | None:
        """Whether a rigid motion costs nothing; None where a frame is to find out."""
        return None

    @property
    def tension(self) -> Array:
        """Axial force at rest, (...), which turns with the member, and with which the frame is loaded at its nodes.

        Linear statics has it from the loads alone.
        """
        return np.zeros(())

    @property
    @abstractmethod
    def quadrature(self) -> int:
        """Gauss points that integrate a linear load times the shape functions to rounding."""

    @abstractmethod
    def part(self, index: int, count: int) -> LineElement:
        """Part `index` of `count` equal parts, with the releases and taper that fall to it."""

    def cut(self, change: Change) -> Self:
        """The element at some entries of its batch: with every parameter that is an array changed.

        This is for dataclasses that hold nothing but their fields; metadata ``{"trailing": 1}`` tells of a field that
        its last axis is no batch axis. It is asked for only where `shape` has an axis.

        Parameters
        ----------
        change
            What takes the entries out of an array, given the array and the number of its axes that are no batch axes.
        """
        found: Self = changed(self, change)
        return found

    @abstractmethod
    def check(self, chord: Array) -> None:
        """Raise FrameError where the member cannot lie along `chord` (..., 3)."""

    @abstractmethod
    def axes(self, chord: Array) -> Array:
        """Local axes as rows, (..., 3, 3), of a member along `chord` (..., 3)."""

    @abstractmethod
    def stiffness_matrix(self, length: Array) -> Array:
        """Stiffness, (..., 12, 12)."""

    @abstractmethod
    def springs(self, length: Array) -> tuple[Array, Array]:
        """The stiffness as any number n of springs k (..., n) on deformations b (..., n, 12).

        ``K = sum_i k_i b_i b_i^T``. The deformations come in the precision of `length`, as do `axes` in that of the
        chord: error bounds rest on it that a rigid motion costs no energy. A beam has six; where something outside the
        frame holds the member, as a foundation does, springs resist its rigid motion.
        """

    @abstractmethod
    def mass_matrix(self, length: Array) -> Array:
        """Consistent mass, (..., 12, 12)."""

    @abstractmethod
    def geometric_matrix(self, length: Array, axial: Array) -> Array:
        """Geometric stiffness under the axial force `axial` (tension positive), (..., 12, 12)."""

    @abstractmethod
    def end_forces(self, length: Array, displacement: Array) -> Array:
        """Stiffness times `displacement` (..., 12), by way of the deformations, (..., 12)."""

    @abstractmethod
    def shape_functions(self, length: Array, x: Array) -> Array:
        """Displacement at distance `x` from the start for unit end displacements, (..., 6, 12).

        At the ends the displacement, not always the rotation, is that of the nodes.
        """

    @abstractmethod
    def section_flexibility(self, fraction: Array) -> Array:
        """Strain and curvature per unit ``N Vy Vz T My Mz`` at `fraction` of the length, (..., 6)."""

    @abstractmethod
    def mass_per_length(self, fraction: Array) -> Array:
        """Mass per length at `fraction` of the length, (...)."""

    @abstractmethod
    def stress(self, fraction: Array, forces: Array) -> Array:
        """Least and greatest normal stress and greatest von Mises stress, (..., 3).

        `forces` (..., 6) are ``N Vy Vz T My Mz`` at `fraction` of the length. An element without a section raises
        FrameError.
        """


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
    """

    stiffness: Array
    axes: Array | None
    clearance: Array
    clearance_directions: tuple[int, ...]
    pitch: Array

    @property
    @abstractmethod
    def shape(self) -> tuple[int, ...]:
        """Batch shape of the element's own parameters."""

    @abstractmethod
    def matrix(self) -> Array:
        """Stiffness of the two nodes in global axes, (..., 12, 12): what springs, axes and pitch make."""

    @abstractmethod
    def typical(self) -> JointElement:
        """The joint without clearance, its springs those that are stiffest in the batch: what has no batch of its own
        but that of its geometry."""

    def resistance(self, displacement: Array, pick: Change) -> tuple[Array, Array, Array]:
        """Energy, force and tangent at a displacement in the joint's axes: springs, and contact in the clearance
        directions.

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

    @property
    def has_law(self) -> bool:
        """Whether `resistance` is its own and not that of springs and contact."""
        return type(self).resistance is not JointElement.resistance

    def springs_matrix(self) -> Array:
        """Stiffness that finite springs, axes and pitch make of the two nodes in global axes, (..., 12, 12)."""
        axes = np.eye(3) if self.axes is None else self.axes
        acts = np.zeros((*np.broadcast_shapes(axes.shape[:-2], self.pitch.shape), 6, 6))
        acts[..., :3, :3] = acts[..., 3:, 3:] = axes
        acts[..., 3:, 2] = -self.pitch[..., None] / (2.0 * np.pi) * axes[..., :, 2]
        # the products commute, so that the block is symmetric to the last bit
        dyads = acts[..., :, None, :] * acts[..., None, :, :]
        block = np.sum(self.stiffness[..., None, None, :] * dyads, axis=-1)
        near = np.concatenate([block, -block], axis=-1)
        return np.concatenate([near, -near], axis=-2)


class PointElement(ABC):
    """Inertia at one node."""

    @property
    @abstractmethod
    def shape(self) -> tuple[int, ...]:
        """Batch shape of the element's own parameters."""

    @abstractmethod
    def mass_matrix(self) -> Array:
        """Mass in global axes, (..., 6, 6)."""


def changed(described: Any, change: Change) -> Any:
    """A dataclass with its arrays changed, and those of the dataclasses in it; its numbers are not checked again."""
    if not is_dataclass(described):
        kind = type(described).__name__
        told = "make it one, or give it its own method cut(change)"
        raise FrameError(f"{kind} holds a batch but is no dataclass: {told}")
    twin = object.__new__(type(described))
    for each in fields(described):
        value = getattr(described, each.name)
        if isinstance(value, np.ndarray):
            value = change(value, each.metadata.get("trailing", 0))
        elif is_dataclass(value):
            value = changed(value, change)
        object.__setattr__(twin, each.name, value)
    return twin
