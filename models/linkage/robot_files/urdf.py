"""Write a linkage as URDF: a tree of links with one coordinate a joint, and followers by ``mimic``."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from xml.etree.ElementTree import Element

import numpy as np

from ....framework.batch import Array
from ..description.linkage_description import LinkageDescription
from ..description.parts import GROUND
from .body_tree import BodyTree, TreeBody, TreeStep, body_tree
from .followers import Follower, followers
from .placed import BodyMass
from .xml import add, check_unique, document, note

# Limits that URDF requires for joints that slide: of the coordinate in sizes of the linkage, and of force and speed.
REACH, UNBOUND = 100.0, 1e9
BALL = ("rx", "ry", "rz")


@dataclass(frozen=True, eq=False)
class SingleJoint:
    """A joint of URDF and SDF: with one coordinate, without any, or spherical.

    Attributes
    ----------
    name, kind
        Its name, and ``continuous``, ``prismatic``, ``fixed`` or ``ball``.
    parent, child
        Links that it joins.
    place
        Global position, (3,); the origin of the child.
    axis
        Its axis, (3,), global in the reference configuration.
    follows
        The motion that its coordinate follows; None if it is independent.
    """

    name: str
    kind: str
    parent: str
    child: str
    place: Array
    axis: Array
    follows: Follower | None


def single_joints(tree: BodyTree, following: dict[str, Follower], *, balls: bool) -> Iterator[SingleJoint]:
    """All joints, those with several coordinates as a chain of joints with massless links between them.

    Without `balls` a spherical joint is a chain of three hinges, about x, y and z.
    """
    for body in whole_links(tree):
        steps = [each for step in body.steps for each in ([step] if balls else _hinges(step))]
        names = [body.parent, *(f"{body.name} before {step.name}" for step in steps[1:]), body.name]
        if not steps:
            yield SingleJoint(body.joint.name, "fixed", body.parent, body.name, body.origin, np.zeros(3), None)
        for step, parent, child in zip(steps, names, names[1:], strict=False):
            follows = following.get(step.name, following.get(step.joint))
            kind = "ball" if step.component == "ball" else "continuous" if step.is_rotation else "prismatic"
            if follows is not None and not follows.factor:
                kind, follows = "fixed", None
            yield SingleJoint(step.name, kind, parent, child, body.origin, step.axis, follows)


def whole_links(tree: BodyTree) -> list[TreeBody]:
    """The bodies, without the parts of links that close loops."""
    return [body for body in tree.bodies if body.part_of is None]


def _hinges(step: TreeStep) -> list[TreeStep]:
    if step.component != "ball":
        return [step]
    return [TreeStep(f"{step.name} {each}", step.joint, each, np.eye(3)[k], 0.0) for k, each in enumerate(BALL)]


def urdf(linkage: LinkageDescription, title: str) -> str:
    """The text of the file.

    Raises
    ------
    FrameError
        As for `body_tree` and `followers`.
    """
    tree = body_tree(linkage)
    following = followers(tree, "URDF")
    masses = tree.placed.masses
    root = Element("robot", name=title)
    note(root, "Coordinates are counted from the reference configuration of the linkage, in radians and its lengths.")
    add(root, "link", name=GROUND)
    places = {GROUND: np.zeros(3)}
    for joint in single_joints(tree, following, balls=False):
        places[joint.child] = joint.place
        element = add(root, "link", name=joint.child)
        if joint.child in masses and masses[joint.child].is_own:
            _inertial(element, masses[joint.child], joint.place)
        _joint(root, joint, joint.place - places[joint.parent], REACH * tree.placed.size)
    for body in whole_links(tree):
        _points(root, body)
    for what in ("link", "joint"):
        check_unique([each.get("name", "") for each in root.findall(what)], f"{what}s")
    return document(root)


def _inertial(element: Element, own: BodyMass, origin: Array) -> None:
    inertial = add(element, "inertial")
    add(inertial, "origin", xyz=own.centre - origin, rpy=(0.0, 0.0, 0.0))
    add(inertial, "mass", value=own.mass)
    add(inertial, "inertia", **inertia_terms(own.tensor))


def inertia_terms(tensor: Array) -> dict[str, float]:
    """The six terms of an inertia tensor by name."""
    return {f"i{'xyz'[i]}{'xyz'[k]}": float(tensor[i, k]) for i in range(3) for k in range(i, 3)}


def _joint(root: Element, joint: SingleJoint, offset: Array, reach: float) -> None:
    element = add(root, "joint", name=joint.name, type=joint.kind)
    add(element, "parent", link=joint.parent)
    add(element, "child", link=joint.child)
    add(element, "origin", xyz=offset, rpy=(0.0, 0.0, 0.0))
    if joint.kind == "fixed":
        return
    add(element, "axis", xyz=joint.axis)
    if joint.kind == "prismatic":
        add(element, "limit", lower=-reach, upper=reach, effort=UNBOUND, velocity=UNBOUND)
    if joint.follows is not None:
        add(element, "mimic", joint=joint.follows.leader, multiplier=joint.follows.factor, offset=0.0)


def _points(root: Element, body: TreeBody) -> None:
    """Add points as massless links that are fixed to their link."""
    for point, place in body.points.items():
        name = f"{point} on {body.name}"
        add(root, "link", name=name)
        element = add(root, "joint", name=f"point {name}", type="fixed")
        add(element, "parent", link=body.name)
        add(element, "child", link=name)
        add(element, "origin", xyz=place - body.origin, rpy=(0.0, 0.0, 0.0))
