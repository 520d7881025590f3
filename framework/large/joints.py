"""Joints, rigid links, ties and supports as edges of the joint tree: their numbers by entry, and what resists in them.

Beside six springs that is contact in a clearance, or a law of the joint's own. Rigid contact (stiffness inf where the
joint has clearance) has no law: its force p holds the displacement d in the ball of radius e. It is found by augmented
Lagrangians (Rockafellar, J. Optim. Theory Appl. 12 (1973) 555-562): with a guess of p and a stiffness k, the energy ::

    W(d) = k/2 dist(d + p/k, ball)^2 - p^2 / 2k,    f = k (z - the point of the ball nearest to z),  z = d + p/k

is smooth, and p is right where f = p, for any k: so k bears on the way only, not on the result.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from .. import rotation
from ..batch import Array
from ..description import Description
from ..elementwise import less, maximum, square_root, where, zeros
from ..joint_protocol import JointElement
from ..rotation import dot, outer
from ..structure.connections import TreeEdge
from ..structure.edge import Edge
from ..structure.topology import Topology
from .links import EdgeGeometry
from .numbers import Numbers, Where


@dataclass(frozen=True)
class TreeJoint:
    """A joint, rigid link, tie or support between a child of the tree and its parent, or one that closes a loop.

    Attributes
    ----------
    edge
        The same in the frame's structure.
    parent, child
        Numbers of its nodes.
    forward
        Whether the child is the second node.
    axes, arm
        Axes as columns (3, 3, ...), None for the global ones; from first to second node (3, ...), None for zero.
    offset, stiffness
        Imposed displacement, and springs, of its six coordinates (6, ...).
    law
        What replaces its springs, None for nothing.
    clearance_directions, clearance
        Clearance directions, none where clearance is left out, and its radius.
    rigid
        Whether contact is rigid.
    lead
        Advance of a screw by its turn, None for none.
    """

    edge: Edge
    parent: int
    child: int
    forward: bool
    axes: Numbers | None
    arm: Numbers | None
    offset: Numbers
    stiffness: Numbers
    law: JointElement | None
    clearance_directions: tuple[int, ...]
    clearance: Numbers
    ndim: int
    rigid: bool
    lead: Numbers | None

    @classmethod
    def of(cls, topology: Topology, branch: TreeEdge, clearance: bool) -> TreeJoint:
        """The numbers of a branch of the tree."""
        frame, edge = topology.frame, branch.edge
        ndim = len(frame.shape)
        given = offsets(frame, edge)
        whole = np.broadcast_arrays(*(np.asarray(given.get(k, 0.0)) for k in range(6)))
        springs = np.broadcast_arrays(*(np.asarray(value, dtype=np.float64) for value in edge.stiffness))
        arm = None
        if edge.kind == "rigid":
            arm = Numbers.of(topology.position(edge.second) - topology.position(edge.first), ndim, 1)
        element = frame.joints[edge.name].element if edge.kind == "joint" and edge.name is not None else None
        law = None if element is None else _law_of(element, clearance)
        has_clearance = law is not None and bool(law.clearance.any())
        directions = law.clearance_directions if law is not None and has_clearance else ()
        radius = law.clearance if law is not None and has_clearance else np.zeros(())
        return cls(
            edge,
            branch.parent,
            branch.child,
            branch.sign > 0.0,
            None if edge.axes is None else Numbers.of(edge.axes, ndim, 2),
            arm,
            Numbers.of(np.stack(whole, axis=-1), ndim, 1),
            Numbers.of(np.stack(springs, axis=-1), ndim, 1),
            law,
            directions,
            Numbers.of(radius, ndim, 0),
            ndim,
            any(k in edge.ideal for k in directions),
            Numbers.of(element.pitch / (2.0 * np.pi), ndim, 0) if element is not None and element.pitch.any() else None,
        )

    def at(self, where: Where) -> EdgeGeometry:
        """Geometry at some entries."""
        axes = None if self.axes is None else self.axes.at(where)
        arm = None if self.arm is None else self.arm.at(where)
        lead = None if self.lead is None else self.lead.at(where)
        return EdgeGeometry(axes, arm, self.movable, self.forward, self.edge.kind != "tie", lead)

    def resistance(
        self, where: Where, elastic: Array, contact: tuple[Array, Array] | None
    ) -> tuple[Array, Array, Array]:
        """Energy (m,), force (6, m) and tangent (6, 6, m) of its springs, or of its own law, at a displacement (6, m).

        Of rigid contact `contact` is the guess of its force (6, m), and the stiffness by which it is corrected (m,).
        """
        energy, force, tangent = (self._by_own_law if self.own_law else self._by_springs)(where, elastic)
        directions = list(self.clearance_directions)
        if contact is not None:
            push, pressed = contact
            more = rigid_contact(elastic[directions], self.clearance.at(where), push[directions], pressed)
        elif directions and not self.own_law:
            pressed = self.stiffness.at(where)[directions[0]]
            more = elastic_contact(elastic[directions], self.clearance.at(where), pressed)
        else:
            return energy, force, tangent
        force[directions] = force[directions] + more[1]
        inside = np.ix_(directions, directions)
        tangent[inside] = tangent[inside] + more[2]
        return energy + more[0], force, tangent

    def _by_springs(self, where: Where, elastic: Array) -> tuple[Array, Array, Array]:
        """Energy, force and tangent of its springs, those that clearance leaves free apart."""
        stiffness = self.stiffness.at(where)
        if self.clearance_directions:
            stiffness = stiffness.copy()
            stiffness[list(self.clearance_directions)] = 0.0
        force, tangent = stiffness * elastic, zeros((6, 6, stiffness.shape[-1]), elastic, stiffness)
        tangent[range(6), range(6)] = stiffness
        if self.clearance_directions:
            tangent = tangent + 0.0 * elastic[0]
        return 0.5 * dot(force, elastic), force, tangent

    def _by_own_law(self, where: Where, elastic: Array) -> tuple[Array, Array, Array]:
        """Energy, force and tangent as the element says, which has a law in place of springs."""

        def pick(array: Array, trailing: int) -> Array:
            return np.moveaxis(Numbers.of(array, self.ndim, trailing).at(where), -1, 0)

        assert self.law is not None
        energy, force, tangent = self.law.resistance(elastic.T, pick)
        return energy, force.T, np.moveaxis(tangent, 0, -1)

    @property
    def own_law(self) -> bool:
        """Whether the element says by a function what its displacement takes, which may be any."""
        return self.law is not None and self.law.has_law

    @cached_property
    def ideal(self) -> tuple[int, ...]:
        """Components that are constrained, whatever the load."""
        return tuple(k for k in self.edge.ideal if k not in self.clearance_directions)

    @cached_property
    def turns_freely(self) -> bool:
        """Whether its soft rotation is about several axes, and nothing knows it from one by a turn more.

        A pin counts its turns; a ball without springs does not.
        """
        free = not any(k in self.edge.ideal or self.stiffness.array[k].any() for k in 3 + np.flatnonzero(self.movable))
        by_law = self.own_law or (self.law is not None and max(self.clearance_directions) >= 3)
        return free and not by_law and self.lead is None and int(self.movable.sum()) > 1

    def shortest(self, own: Array) -> Array:
        """Its coordinates (6, m) for the same place, soft rotation by half a turn at most if it `turns_freely`.

        Near a whole turn it would hardly change with its coordinates, and not at all at one.
        """
        if not self.turns_freely:
            return own
        soft = self.movable[:, None]
        turned = rotation.shortest(np.where(soft, own[3:], 0.0))
        return np.concatenate([own[:3], np.where(soft, turned, own[3:])])

    @cached_property
    def movable(self) -> NDArray[np.bool_]:
        """Components of rotation that turn first: the softest."""
        return self.edge.softest

    def within(self, kept: tuple[int, ...]) -> list[int]:
        """Which of its own coordinates move within `kept` global components; its axes lie along these or across."""
        if self.axes is None or len(kept) == 6:
            return list(kept)
        normal = kept[2] - 3
        across = (self.axes.array[normal] == 0.0).reshape(3, -1).all(axis=1)
        return [k for k in range(6) if across[k % 3] == (k < 3)]


def offsets(frame: Description, edge: Edge) -> dict[int, Array]:
    """Given displacements of an edge that are not zero."""
    known = {"joint": frame.offsets, "support": frame.supports}.get(edge.kind, {})
    given = known.get(edge.name, {}) if edge.name else {}
    return {k: value for k, value in given.items() if np.any(value)}


def _law_of(element: JointElement, clearance: bool) -> JointElement | None:
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
