"""A structure as a linkframe Frame, by the public face only."""

from __future__ import annotations

from math import isinf

from linkframe.elements import Beam, Joint, Material, Section
from linkframe.framework import Frame

from .structure import LOADS, Member, Spring, Structure


def as_beam(member: Member, segments: int = 1) -> Beam:
    """The beam of a member, from the same floats."""
    shear = {} if isinf(member.ky) else {"ky": member.ky, "kz": member.kz}
    section = Section(A=member.A, Iy=member.Iy, Iz=member.Iz, J=member.J, **shear)
    up = None if member.up == (0.0, 0.0, 1.0) else member.up  # the default, exactly zero out of a plane frame
    return Beam(section, Material(E=member.E, G=member.G), up=up, shear=member.shear, segments=segments)


def as_joint(spring: Spring) -> Joint:
    """The joint of a spring, from the same floats."""
    return Joint(stiffness=spring.stiffness, axes=spring.axes, pitch=spring.pitch)


def as_frame(structure: Structure, *, segments: int = 1, loaded: bool = True) -> Frame:
    """The frame in the order in which the structure lists its things."""
    frame = Frame()
    for name, place in structure.nodes.items():
        frame.node(name, place)
    for name, member in structure.members.items():
        frame.add(name, as_beam(member, segments), member.start, member.end)
    for name, joint in structure.joints.items():
        frame.add(name, as_joint(joint), joint.first, joint.second)
    for master, slave in structure.rigid:
        frame.rigid(master, slave)
    for node, prescribed in structure.supports.items():
        frame.prescribe(node, **prescribed)
    for node, load in structure.loads.items() if loaded else ():
        frame.load(node, **dict(zip(LOADS, load, strict=True)))
    return frame
