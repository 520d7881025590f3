"""Joints of an MJCF body as joints of a linkage: several become one joint, or a chain with links between them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from ....framework.batch import Array
from ....framework.errors import FrameError
from ..description.parts import ROUNDING, joint_axes
from .mjcf_bodies import ReadBody, ReadJoint


@dataclass(frozen=True, eq=False)
class ReadPair:
    """A joint of the new linkage.

    Attributes
    ----------
    name, kind
        Its name, None if it has none, and its kind.
    first, second
        Names of its links.
    place
        Global position, (3,).
    axes
        Its axes as columns, (3, 3).
    reference
        Reference values of its coordinates, in the order of the kind.
    coordinates
        By name of a joint in MJCF: the coordinate of this joint that it is; empty for all three of a spherical joint.
    pitch
        Advance of a screw per turn.
    """

    name: str | None
    kind: str
    first: str
    second: str
    place: Array
    axes: Array
    reference: tuple[float, ...]
    coordinates: Mapping[str, str]
    pitch: float | None = None


@dataclass(frozen=True)
class TiedJoints:
    """Two joints of MJCF that move in proportion, ``follower = factor * leader``."""

    follower: str
    leader: str
    factor: float


def joined(body: ReadBody, couplings: list[TiedJoints]) -> list[ReadPair]:
    """Joints between a body and its parent: one, or several with massless links between them.

    Couplings that make a screw are removed from the list.

    Raises
    ------
    FrameError
        If the body has a free joint and others.
    """
    joints = body.joints
    kinds = tuple(joint.kind for joint in joints)
    if "free" in kinds:
        if len(kinds) > 1:
            raise FrameError(f"body {body.name!r} has a free joint beside others: leave one or the other out")
        return []
    if not joints:
        axes = joint_axes(body.name, (0.0, 0.0, 1.0))
        return [ReadPair(None, "fixed", body.parent, body.name, body.frame.origin, axes, (), {})]
    whole = _one_joint(body, kinds, couplings)
    if whole is not None:
        return [whole]
    links = [body.parent, *(f"{body.name} before {joint.name}" for joint in joints[1:]), body.name]
    return [_single(joint, *ends) for joint, ends in zip(joints, pairwise(links), strict=True)]


def _one_joint(body: ReadBody, kinds: Sequence[str], couplings: list[TiedJoints]) -> ReadPair | None:
    """One joint that is the same as all joints of the body; None if there is no such kind."""
    joints = body.joints
    if len(joints) == 1:
        return _single(joints[0], body.parent, body.name)
    if sorted(kinds) == ["hinge", "slide"]:
        return _coaxial(body, couplings)
    if kinds == ("hinge", "hinge") and _meet(joints) and abs(joints[0].axis @ joints[1].axis) < ROUNDING:
        # the names tell that the first link is the child
        backwards = joints[0].name.endswith(" rx") and joints[1].name.endswith(" rz")
        own = list(reversed(joints)) if backwards else joints
        sign = -1.0 if backwards else 1.0
        axes = joint_axes(own[0].name, sign * own[0].axis, sign * own[1].axis)
        return _several(body, "universal", ("rz", "rx"), own, axes, own[0].place, is_reversed=backwards)
    if kinds == ("slide", "slide", "hinge") and _right_handed(joints):
        axes = np.column_stack([joint.axis for joint in joints])
        return _several(body, "planar", ("ux", "uy", "rz"), joints, axes, joints[2].place)
    if kinds == ("hinge", "slide", "slide") and _right_handed(list(reversed(joints)), -1.0):
        axes = -np.column_stack([joint.axis for joint in reversed(joints)])
        own = list(reversed(joints))
        return _several(body, "planar", ("ux", "uy", "rz"), own, axes, joints[0].place, is_reversed=True)
    return None


def _single(joint: ReadJoint, first: str, second: str) -> ReadPair:
    if joint.kind == "ball":
        axes, components = joint_axes(joint.name, (0.0, 0.0, 1.0)), {joint.name: ""}
        return ReadPair(joint.name, "spherical", first, second, joint.place, axes, (0.0,) * 3, components)
    kind, component = ("revolute", "rz") if joint.kind == "hinge" else ("prismatic", "uz")
    axes, given = joint_axes(joint.name, joint.axis), {joint.name: component}
    return ReadPair(joint.name, kind, first, second, joint.place, axes, (joint.reference,), given)


def _coaxial(body: ReadBody, couplings: list[TiedJoints]) -> ReadPair | None:
    """A hinge and a slide along its axis: a screw if they are coupled, else a cylindrical joint."""
    hinge, slide = body.joints if body.joints[0].kind == "hinge" else reversed(body.joints)
    if hinge.axis @ slide.axis < 1.0 - ROUNDING:
        return None
    axes = joint_axes(hinge.name, hinge.axis)
    for coupling in couplings:
        if {coupling.follower, coupling.leader} == {hinge.name, slide.name} and coupling.factor:
            couplings.remove(coupling)
            per_radian = coupling.factor if coupling.follower == slide.name else 1.0 / coupling.factor
            given = {hinge.name: "rz", slide.name: "rz"}
            name = _common(body, {hinge.name: "rz", slide.name: "uz"})
            ends = body.parent, body.name
            pitch = 2.0 * np.pi * per_radian
            return ReadPair(name, "screw", *ends, hinge.place, axes, (hinge.reference,), given, pitch)
    return _several(body, "cylindrical", ("uz", "rz"), [slide, hinge], axes, hinge.place)


def _several(
    body: ReadBody,
    kind: str,
    components: Sequence[str],
    joints: Sequence[ReadJoint],
    axes: Array,
    place: Array,
    *,
    is_reversed: bool = False,
) -> ReadPair:
    given = {joint.name: component for joint, component in zip(joints, components, strict=True)}
    ends = (body.name, body.parent) if is_reversed else (body.parent, body.name)
    reference = tuple(joint.reference for joint in joints)
    return ReadPair(_common(body, given), kind, *ends, place, axes, reference, given)


def _common(body: ReadBody, given: Mapping[str, str]) -> str:
    """The common part of the joints' names, as of ``A uz`` and ``A rz``; else the first name."""
    stems = {name.rpartition(" ")[0] for name in given}
    ends = {name.rpartition(" ")[2] for name in given}
    if len(stems) == 1 and stems != {""} and ends <= {"ux", "uy", "uz", "rx", "ry", "rz"}:
        return stems.pop()
    return body.joints[0].name


def _meet(joints: Sequence[ReadJoint]) -> bool:
    off, far = (float(np.linalg.norm(each)) for each in (joints[1].place - joints[0].place, joints[0].place))
    return off <= ROUNDING * max(1.0, far)


def _right_handed(joints: Sequence[ReadJoint], sign: float = 1.0) -> bool:
    axes = sign * np.column_stack([joint.axis for joint in joints])
    return bool(np.abs(axes.T @ axes - np.eye(3)).max() < ROUNDING and np.linalg.det(axes) > 0.0)
