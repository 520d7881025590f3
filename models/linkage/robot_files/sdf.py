"""Write a linkage as SDF: a tree of links in their reference configuration, with followers by ``mimic``."""

from __future__ import annotations

from xml.etree.ElementTree import Element

import numpy as np

from ....framework.batch import Array
from ....framework.errors import FrameError
from ..description.linkage_description import LinkageDescription
from ..description.parts import GROUND
from .body_tree import TreeBody, body_tree
from .followers import followers
from .mjcf_write import WORLD, check_names
from .placed import BodyMass, Placed, single
from .urdf import REACH, SingleJoint, inertia_terms, single_joints, whole_links
from .xml import Number, add, check_unique, document, note, written

# First versions of SDF with ``mimic``, and with everything else: readers refuse versions that are too new for them.
MIMIC_VERSION, VERSION = "1.11", "1.7"


def sdf(linkage: LinkageDescription, title: str) -> str:
    """The text of the file.

    Raises
    ------
    FrameError
        As for `body_tree` and `followers`, and if a name is reserved in SDF.
    """
    check_names(linkage)
    tree = body_tree(linkage)
    following = followers(tree, "SDF")
    root = Element("sdf")
    world = add(root, "world", name=title)
    _text(world, "gravity", single(linkage.weight, 1, "gravity"))
    model = add(world, "model", name=title)
    note(model, "Coordinates are counted from the reference configuration of the linkage, in radians and its lengths.")
    for joint in single_joints(tree, following, balls=True):
        own = tree.placed.masses.get(joint.child)
        _link(model, joint, _between(tree.placed, joint.place) if own is None else own)
        _joint(model, joint, REACH * tree.placed.size)
    for body in whole_links(tree):
        _points(model, body)
    names = [each.get("name", "") for each in model if each.tag in ("link", "joint", "frame")]
    check_unique(names, "links, joints, points")
    _check_reserved([title, *names])
    root.set("version", VERSION if model.find(".//mimic") is None else MIMIC_VERSION)
    return document(root)


def _check_reserved(names: list[str]) -> None:
    """Refuse names that are reserved in SDF."""
    for name in names:
        if name == WORLD or "::" in name or (name.startswith("__") and name.endswith("__")):
            raise FrameError(
                f"SDF keeps the name {name!r} for itself, as all with '::' in them or between double underscores: "
                "rename the link, joint, point or file that it comes from"
            )


def _text(parent: Element, tag: str, value: str | Number, **attributes: str) -> Element:
    """Add an element with a text or numbers as its content."""
    element = add(parent, tag, **attributes)
    element.text = value if isinstance(value, str) else written(value)
    return element


def _pose(place: Array) -> Array:
    return np.concatenate([place, np.zeros(3)])


def _between(placed: Placed, place: Array) -> BodyMass:
    """A small mass for a link between two coordinates of a joint, which SDF requires."""
    light = 1e-9 * sum(own.mass for own in placed.masses.values())
    return BodyMass(light, place, 1e-2 * light * placed.size**2 * np.eye(3), False)


def _link(model: Element, joint: SingleJoint, own: BodyMass) -> None:
    element = add(model, "link", name=joint.child)
    _text(element, "pose", _pose(joint.place))
    inertial = add(element, "inertial")
    _text(inertial, "pose", _pose(own.centre - joint.place))
    _text(inertial, "mass", own.mass)
    inertia = add(inertial, "inertia")
    for name, value in inertia_terms(own.tensor).items():
        _text(inertia, name, value)


def _joint(model: Element, joint: SingleJoint, reach: float) -> None:
    """Add a joint; its origin is that of its child."""
    element = add(model, "joint", name=joint.name, type=joint.kind)
    _text(element, "parent", WORLD if joint.parent == GROUND else joint.parent)
    _text(element, "child", joint.child)
    if joint.kind in ("fixed", "ball"):
        return
    axis = add(element, "axis")
    _text(axis, "xyz", joint.axis)
    if joint.kind == "prismatic":
        limit = add(axis, "limit")
        _text(limit, "lower", -reach)
        _text(limit, "upper", reach)
    if joint.follows is not None:
        mimic = add(axis, "mimic", joint=joint.follows.leader)
        for name, value in {"multiplier": joint.follows.factor, "offset": 0.0, "reference": 0.0}.items():
            _text(mimic, name, value)


def _points(model: Element, body: TreeBody) -> None:
    """Add points as frames on their links."""
    for point, place in body.points.items():
        frame = add(model, "frame", name=f"{point} on {body.name}", attached_to=body.name)
        _text(frame, "pose", _pose(place - body.origin))
