"""The frame on which unit offsets act: without loads, and with the joints and members that are asked for."""

from __future__ import annotations

import math
from collections.abc import Hashable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..batch import ZERO
from ..composed import Unstrained
from ..described.known_parts import add_body, add_node
from ..described.parts import JointLink
from ..description import Description
from ..joint_protocol import JointElement
from ..protocol import LineElement

# Up to this many entries the stiffness of each entry costs no more than a common one.
_FEW = 1000


def without_loads(
    frame: Description, joints: Mapping[str, JointElement], members: Mapping[str, LineElement]
) -> Description:
    """The frame with the given joints and members, without loads, free strains, offsets and imposed displacements.

    Parameters
    ----------
    frame
        The frame; what is known of its parts is not checked again.
    joints, members
        By name the elements, each as the frame's but for its numbers.
    """
    out = Description(size=frame.size)
    out.bodies, out.nodes, out.ties = dict(frame.bodies), dict(frame.nodes), list(frame.ties)
    for name, member in frame.members.items():
        element = members[name]
        strained = element.free_strain(np.zeros(())) is not None
        out.members[name] = (
            member
            if element is member.element and not strained
            else member._replace(element=Unstrained(element) if strained else element)
        )
    for name, joint in frame.joints.items():
        out.joints[name] = joint._replace(element=joints[name])
    out.supports = {node: dict.fromkeys(constrained, ZERO) for node, constrained in frame.supports.items()}
    out._join({f"body {name!r}": shape for name, shape in _shapes_of_bodies(frame).items()})
    out._join({f"node {name!r}": node.coordinates.shape[:-1] for name, node in frame.nodes.items()})
    out._join({f"member {name!r}": element.shape for name, element in members.items()})
    out._join({f"joint {name!r}": element.shape for name, element in joints.items()})
    return out


def at_first_entry(frame: Description) -> Description:
    """The nodes and bodies of a frame at its first batch entry, and all that connects them, without loads."""
    out = Description()
    for name, body in frame.bodies.items():
        add_body(out, name, first(body.origin, 1), first(body.axes, 2))
    for name, node in frame.nodes.items():
        add_node(out, name, first(node.coordinates, 1), node.body)
    out.members, out.joints, out.ties, out.supports = frame.members, frame.joints, frame.ties, frame.supports
    return out


def count_of_entries(frame: Description, joints: Mapping[str, JointElement], members: Mapping[str, LineElement]) -> int:
    """Number of batch entries of the frame with the given joints and members, without loads."""
    elements = (*(each.shape for each in joints.values()), *(each.shape for each in members.values()))
    return math.prod(np.broadcast_shapes(*_shapes_of_places(frame), *elements))


def shape_of_stiffness(frame: Description) -> tuple[int, ...]:
    """Batch shape over which the geometry of a frame and the stiffness of its members and joints vary."""
    members = (member.element.shape for member in frame.members.values())
    return np.broadcast_shapes(*_shapes_of_places(frame), *members, *map(_shape_of_springs, frame.joints.values()))


def _shape_of_springs(joint: JointLink) -> tuple[int, ...]:
    element = joint.element
    axes = () if element.axes is None else element.axes.shape[:-2]
    return np.broadcast_shapes(element.stiffness.shape[:-1], axes, element.pitch.shape)


def _shapes_of_places(frame: Description) -> list[tuple[int, ...]]:
    places = (node.coordinates.shape[:-1] for node in frame.nodes.values())
    return [*places, *_shapes_of_bodies(frame).values()]


def _shapes_of_bodies(frame: Description) -> dict[str, tuple[int, ...]]:
    return {
        name: np.broadcast_shapes(body.origin.shape[:-1], body.axes.shape[:-2]) for name, body in frame.bodies.items()
    }


def elements_of(frame: Description) -> tuple[dict[str, JointElement], dict[str, LineElement]]:
    """Elements of joints and of members, by name."""
    members = {name: member.element for name, member in frame.members.items()}
    return {name: joint.element for name, joint in frame.joints.items()}, members


def typical_elements(frame: Description) -> tuple[dict[str, JointElement], dict[str, LineElement]] | None:
    """Elements of joints and members with a stiffness common to many entries of a long batch; None if it is not."""
    joints, members = elements_of(frame)
    if math.prod(frame.shape) <= _FEW or not all(_alike(element) for element in joints.values()):
        return None
    bearings, typical = {name: each.typical() for name, each in joints.items()}, typical_members(frame)
    fewer = count_of_entries(frame, bearings, typical) < count_of_entries(frame, joints, members)
    return (bearings, typical) if fewer else None


def _alike(element: JointElement) -> bool:
    """Whether each component of a joint is free at all batch entries or at none."""
    free = (element.stiffness == 0.0).reshape(-1, 6)
    return bool(np.all(free.all(axis=0) == free.any(axis=0)))


def typical_members(frame: Description) -> dict[str, LineElement]:
    """The elements of members as they are at the first entry, where that says what they resist at all entries.

    That is so if they resist every deformation there, and what they resist does not depend on their own numbers.
    """
    members: dict[Hashable, list[str]] = {}
    for name, member in frame.members.items():
        members.setdefault(member.element.kind, []).append(name)
    out: dict[str, LineElement] = {}
    for names in members.values():
        element = frame.members[names[0]].element
        if element.shape and (element.deforms_as is not None or not element.has_springs):
            typical = element.cut(first)
            lengths = np.array([first(frame.length(name), 0) for name in names])
            element = typical if np.all(typical.spring_stiffness(lengths) > 0.0) else element
        out |= dict.fromkeys(names, element)
    return {name: out[name] for name in frame.members}


def first(array: NDArray[Any], trailing: int) -> NDArray[Any]:
    """An array (..., trailing) at the first batch entry, without batch axes."""
    return np.asarray(array[(0,) * (array.ndim - trailing)])
