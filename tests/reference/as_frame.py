"""A structure as a linkframe Frame, by the public face only."""

from __future__ import annotations

from math import isinf
from typing import Any

import numpy as np
from linkframe.elements import Beam, Joint, Material, Section
from linkframe.framework import Frame

from .structure import COMPONENTS, LOADS, Member, Spring, Structure


def stacked(vector: Any) -> Any:
    """Numbers, some of which vary over a batch (...), with the components last; plain ones as they are."""
    if isinstance(vector, tuple) and any(isinstance(part, tuple) for part in vector):
        rows = [np.stack(np.broadcast_arrays(*row), axis=-1) for row in vector]
        return np.stack(np.broadcast_arrays(*rows), axis=-2)
    if any(isinstance(part, np.ndarray) for part in vector):
        return np.stack(np.broadcast_arrays(*vector), axis=-1)
    return vector


def as_beam(member: Member, segments: int = 1) -> Beam:
    """The beam of a member, from the same floats."""
    shear = {} if isinf(member.ky) else {"ky": member.ky, "kz": member.kz}
    section = Section(A=member.A, Iy=member.Iy, Iz=member.Iz, J=member.J, **shear)
    end = None
    if member.taper is not None:
        end = Section(**dict(zip(("A", "Iy", "Iz", "J"), member.taper, strict=True)), **shear)
    plain = all(isinstance(part, float) for part in member.up) and member.up == (0.0, 0.0, 1.0)
    up = None if plain else stacked(member.up)  # the default, exactly zero out of a plane frame
    return Beam(
        section,
        Material(E=member.E, G=member.G),
        end=end,
        up=up,
        shear=member.shear,
        segments=segments,
        release=member.release,
    )


def as_joint(spring: Spring) -> Joint:
    """The joint of a spring, from the same floats."""
    return Joint(stiffness=stacked(spring.stiffness), axes=stacked(spring.axes), pitch=spring.pitch)


def as_frame(structure: Structure, *, segments: int = 1, loaded: bool = True) -> Frame:
    """The frame in the order in which the structure lists its things; its numbers may be arrays over a batch."""
    frame = Frame()
    for name, place in structure.nodes.items():
        frame.node(name, stacked(place))
    for name, member in structure.members.items():
        frame.add(name, as_beam(member, segments), member.start, member.end)
    for name, joint in structure.joints.items():
        frame.add(name, as_joint(joint), joint.first, joint.second)
    for master, slave in structure.rigid:
        frame.rigid(master, slave)
    for master, slave, names in structure.ties:
        frame.tie(master, slave, *names)
    for node, prescribed in structure.supports.items():
        frame.prescribe(node, **prescribed)
    for joint, offset in structure.offsets.items():
        frame.offset(joint, **dict(zip(COMPONENTS, offset, strict=True)))
    for node, load in structure.loads.items() if loaded else ():
        frame.load(node, **dict(zip(LOADS, load, strict=True)))
    for line in structure.line_loads if loaded else ():
        pairs = dict(zip(LOADS, zip(line.start, line.end, strict=True), strict=False))
        frame.line_load(line.member, local=line.local, span=line.span, **pairs)
    for point in structure.point_loads if loaded else ():
        force = dict(zip(LOADS, point.force, strict=True))
        frame.point_load(point.member, at=point.at, local=point.local, **force)
    return frame
