"""How the force in a joint depends on its displacement, beyond six springs: contact, and laws of its own.

Rigid contact (stiffness inf where the joint has clearance) has no law: its force p holds the displacement d in the ball
of radius e. It is found by augmented Lagrangians (Rockafellar, J. Optim. Theory Appl. 12 (1973) 555-562): with a guess
of p and a stiffness k, the energy ::

    W(d) = k/2 dist(d + p/k, ball)^2 - p^2 / 2k,    f = k (z - the point of the ball nearest to z),  z = d + p/k

is smooth, and p is right where f = p, for any k: so k bears on the way only, not on the result.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..batch import Array
from ..elementwise import less, maximum, square_root, where
from ..joint_protocol import JointElement
from ..rotation import dot, outer


def law_of(element: JointElement, clearance: bool) -> JointElement | None:
    """The joint element itself where its `resistance` is to be followed; None where springs describe it.

    Parameters
    ----------
    element
        The joint element.
    clearance
        Whether clearances are taken into account. A law of its own that has none stands either way.
    """
    if element.clearance.any():
        return element if clearance else None
    return element if element.has_law else None


@dataclass(frozen=True)
class ContactMultipliers:
    """Rigid contacts at m entries: guesses of their forces (6, contacts, m), and stiffnesses k (contacts, m)."""

    force: Array
    stiffness: Array

    @classmethod
    def none(cls, contacts: int, count: int) -> ContactMultipliers:
        """Without any force."""
        return cls(np.zeros((6, contacts, count)), np.ones((contacts, count)))

    def taken(self, kept: Any) -> ContactMultipliers:
        """Some of the entries."""
        return ContactMultipliers(self.force[..., kept], self.stiffness[..., kept])

    def those(self, contacts: list[int]) -> ContactMultipliers:
        """Some of the contacts."""
        return ContactMultipliers(self.force[:, contacts], self.stiffness[contacts])

    def put(self, where: Any, other: ContactMultipliers) -> None:
        """Replace some of the entries."""
        self.force[..., where], self.stiffness[..., where] = other.force, other.stiffness


def elastic_contact(displacement: Array, radius: Array, stiffness: Array) -> tuple[Array, Array, Array]:
    """Energy (m,), force (n, m) and tangent (n, n, m) of a contact with a stiffness; see `clearances.contact.law`."""
    length = square_root(dot(displacement, displacement))
    depth = maximum(length - radius, 0.0)
    touched = less(-depth, 0.0)
    safe = where(touched, length, 1.0)
    normal, pressed = displacement / safe, stiffness * depth
    across = pressed / safe
    tangent = (stiffness - across) * outer(normal, normal)
    for k in range(len(displacement)):
        tangent[k, k] = tangent[k, k] + across
    return 0.5 * pressed * depth, pressed * normal, where(touched, tangent, 0.0)


def rigid_contact(displacement: Array, radius: Array, force: Array, stiffness: Array) -> tuple[Array, Array, Array]:
    """Energy (m,), force (n, m) and tangent (n, n, m) of a rigid contact at a displacement (n, m) in its clearance."""
    stored, generalised_force, tangent = elastic_contact(displacement + force / stiffness, radius, stiffness)
    return stored - 0.5 * dot(force, force) / stiffness, generalised_force, tangent
