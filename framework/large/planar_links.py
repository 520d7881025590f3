"""Joints, rigid links, ties and supports in a plane; see `links`."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..batch import Array
from ..elementwise import contracted, cosine, sine, zeros
from .joint_law import ContactMultipliers
from .joints import TreeJoint
from .model import Model
from .numbers import Numbers, Where
from .planar_pieces import AXES


@dataclass(frozen=True)
class PlanarJoint:
    """A link of the tree in the plane.

    Attributes
    ----------
    axes
        Its two translations as columns (2, 2, ...); `places` are their numbers among the six, and that of the angle.
    sense
        Sign of its angle (...).
    arm
        From first to second node at rest (2, ...).
    offset, stiffness
        Of the three coordinates (3, ...).
    """

    joint: TreeJoint
    places: list[int]
    axes: Numbers
    sense: Numbers
    arm: Numbers
    offset: Numbers
    stiffness: Numbers

    @classmethod
    def of(cls, joint: TreeJoint, model: Model, normal: int) -> PlanarJoint:
        """What of a joint in space lies in the plane."""
        places = joint.within(model.components)
        a, b = AXES[normal]
        ndim = model.ndim
        one = (1,) * ndim
        axes = np.eye(3).reshape(3, 3, *one) if joint.axes is None else joint.axes.array
        arm = np.zeros((3, *one)) if joint.arm is None else joint.arm.array
        return cls(
            joint,
            places,
            Numbers(np.stack([axes[a][places[:2]], axes[b][places[:2]]]), ndim),
            Numbers(axes[normal, places[2] - 3], ndim),
            Numbers(arm[[a, b]], ndim),
            Numbers(joint.offset.array[places], ndim),
            Numbers(joint.stiffness.array[places], ndim),
        )

    def law_response(
        self, where: Where, elastic: Array, contact_multipliers: ContactMultipliers, contact: int | None
    ) -> tuple[Array, Array, Array]:
        """Energy (m,), force (3, m) and tangent (3, 3, m) of its own law at a displacement (3, m) within the plane."""
        whole = zeros((6, elastic.shape[-1]), elastic)
        whole[self.places] = elastic
        energy, force, tangent = self.joint.resistance(where, whole, contact_multipliers, contact)
        return energy, force[self.places], tangent[np.ix_(self.places, self.places)]


@dataclass(frozen=True)
class PlanarLink:
    """A joint at some entries; see `links.Link`."""

    forward: bool
    follows: bool
    axes: Array
    sense: Array
    arm: Array
    offset: Array
    stiffness: Array

    @classmethod
    def of(cls, joint: PlanarJoint, where: Where, factor: float) -> PlanarLink:
        return cls(
            joint.joint.forward,
            joint.joint.edge.kind != "tie",
            joint.axes.at(where),
            joint.sense.at(where),
            joint.arm.at(where),
            factor * joint.offset.at(where),
            joint.stiffness.at(where),
        )

    def elastic(self, own: Array) -> Array:
        """What of the displacement is not imposed (3, m)."""
        return own - self.offset

    def springs(self, elastic: Array) -> tuple[Array, Array, Array]:
        """Energy (m,), force (3, m) and tangent (3, 3, m) of the springs."""
        force, tangent = self.stiffness * elastic, zeros((3, 3, self.stiffness.shape[-1]), elastic)
        tangent[range(3), range(3)] = self.stiffness
        return 0.5 * contracted("im,im->m", force, elastic), force, tangent

    def child(self, place: Array, turn: Array, own: Array) -> tuple[Array, Array]:
        """Displacement (2, m) and angle (m,) of the child."""
        angle = self.sense * own[2]
        first = turn if self.forward else turn - angle
        shift = contracted("ijm,jm->im", self.axes, own[:2])
        if self.follows:
            half = sine(0.5 * first)
            across, less = sine(first), -2.0 * half * half
            x, y = shift + self.arm
            shift = shift + np.stack([less * x - across * y, across * x + less * y])
        return (place + shift, turn + angle) if self.forward else (place - shift, first)

    def rotated_arm(self, first: Array, own: Array) -> tuple[Array, Array]:
        """Axes of the translations (2, 2, m) and arm from the first node (2, m), both turned."""
        if not self.follows:
            return self.axes + 0.0 * first, np.zeros_like(own[:2])
        c, s = cosine(first), sine(first)
        axes = np.stack([c * self.axes[0] - s * self.axes[1], s * self.axes[0] + c * self.axes[1]])
        arm = contracted("ijm,jm->im", axes, own[:2])
        if self.arm.any():
            arm = arm + np.stack([c * self.arm[0] - s * self.arm[1], s * self.arm[0] + c * self.arm[1]])
        return axes, arm

    def transfer(self, axes: Array, arm: Array) -> Array:
        """Motion of the child by those of the parent and the link's own (3, 6, m)."""
        sign = 1.0 if self.forward else -1.0
        out = zeros((3, 6, arm.shape[1]), axes, arm)
        out[[0, 1, 2], [0, 1, 2]] = 1.0
        out[0, 2], out[1, 2] = -sign * arm[1], sign * arm[0]
        out[:2, 3:5] = sign * axes
        out[2, 5] = sign * self.sense
        if not self.forward:
            out[:2, 5] = -self.sense * out[:2, 2]
        return out

    def geometric(self, force: Array, axes: Array, arm: Array) -> Array:
        """What turning does to the forces (6, 6, m): parent's coordinates, then the link's own."""
        out = zeros((6, 6, arm.shape[1]), force, axes, arm)
        if not self.follows:
            return out
        sign = 1.0 if self.forward else -1.0
        bend = -sign * (force[0] * arm[0] + force[1] * arm[1])
        slide = sign * (force[1] * axes[0] - force[0] * axes[1])
        out[2, 2], out[2, 3:5], out[3:5, 2] = bend, slide, slide
        if not self.forward:
            out[2, 5] = out[5, 2] = -self.sense * bend
            out[5, 5] = bend
            out[5, 3:5] = out[3:5, 5] = -self.sense * slide
        return out
