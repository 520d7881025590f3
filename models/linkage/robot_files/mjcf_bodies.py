"""Bodies of an MJCF file in the file's initial position, in global axes."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from xml.etree.ElementTree import Element

import numpy as np

from ....framework.batch import Array
from ....framework.errors import FrameError
from ..description.parts import GROUND
from .mjcf_mass import geom_mass, given_mass
from .mjcf_source import MAIN, MjcfSource, numbers, shown
from .placed import BodyMass

# Forces in a joint beside its constraint forces, which a linkage cannot describe.
IN_JOINTS = ("stiffness", "damping", "frictionloss", "armature")
JOINTS = ("hinge", "slide", "ball", "free")


@dataclass(frozen=True, eq=False)
class Placement:
    """Origin (3,) and axes (3, 3) of a frame."""

    origin: Array = field(default_factory=lambda: np.zeros(3))
    axes: Array = field(default_factory=lambda: np.eye(3))

    def at(self, place: Array) -> Array:
        """Global position of a position (3,) in this frame."""
        return np.asarray(self.origin + self.axes @ place)

    def of(self, own: BodyMass) -> BodyMass:
        """A mass given in this frame, in global axes."""
        return BodyMass(own.mass, self.at(own.centre), self.axes @ own.tensor @ self.axes.T, own.is_own)

    def inner(self, origin: Array, axes: Array) -> Placement:
        """A frame with origin and axes given in this one, in global axes."""
        return Placement(self.at(origin), self.axes @ axes)


@dataclass(frozen=True, eq=False)
class ReadJoint:
    """A joint of MJCF: ``hinge``, ``slide``, ``ball`` or ``free``; its axis and position are global, (3,)."""

    name: str
    kind: str
    axis: Array
    place: Array
    reference: float


@dataclass(frozen=True, eq=False)
class ReadBody:
    """A body: its parent, frame, joints in their order, sites with their axes, and masses.

    `has_geoms` is True if its masses are those of its geoms.
    """

    name: str
    parent: str
    frame: Placement
    has_geoms: bool = False
    joints: list[ReadJoint] = field(default_factory=list)
    sites: dict[str, Placement] = field(default_factory=dict)
    masses: list[BodyMass] = field(default_factory=list)


def bodies_of(source: MjcfSource) -> tuple[list[ReadBody], list[str]]:
    """All bodies from the ground outwards, the ground first, and what a linkage cannot describe of them."""
    reader = _Reader(source)
    world = ReadBody(GROUND, "", Placement())
    reader.bodies.append(world)
    for element in source.root.findall("worldbody"):
        reader.content(element, world, Placement(), element.get("childclass", MAIN))
    return reader.bodies, reader.left


class _Reader:
    def __init__(self, source: MjcfSource) -> None:
        self.source = source
        self.bodies: list[ReadBody] = []
        self.left: list[str] = []

    def content(self, element: Element, body: ReadBody, frame: Placement, childclass: str) -> None:
        """Read the elements in a body, or in a frame of it, in their order, which is that of its joints."""
        for child in element:
            inside = child.get("childclass", childclass)
            if child.tag == "site":
                self._site(child, body, frame, childclass)
            elif child.tag in ("joint", "freejoint"):
                body.joints.append(self._joint(child, body, frame, childclass))
            elif child.tag == "geom" and body.has_geoms:
                geom = geom_mass(self.source, self.source.attributes(child, childclass), f"geom of body {body.name!r}")
                body.masses.extend([] if geom is None else [frame.of(geom)])
            elif child.tag == "frame":
                self.content(child, body, self._inner(child, frame), inside)
            elif child.tag == "body":
                self._body(child, body, self._inner(child, frame), inside)

    def _site(self, element: Element, body: ReadBody, frame: Placement, childclass: str) -> None:
        given = self.source.attributes(element, childclass)
        name = given.get("name") or f"{body.name} site {len(body.sites) + 1}"
        if any(name in other.sites for other in self.bodies):
            raise FrameError(f"site {name!r} is there twice: give it another name")
        body.sites[name] = frame.inner(*self.source.placed(given, shown(element)))

    def _inner(self, element: Element, frame: Placement) -> Placement:
        pos = numbers(element.attrib, "pos", shown(element), 3, "0 0 0")
        return frame.inner(pos, self.source.orientation(element.attrib, shown(element)))

    def _body(self, element: Element, parent: ReadBody, frame: Placement, childclass: str) -> None:
        name = element.get("name") or f"body {len(self.bodies)}"
        if element.get("mocap") == "true":
            raise FrameError(f"body {name!r} is moved by motion capture: give it a joint and an actuator instead")
        if name == "world" or any(name == other.name for other in self.bodies):
            raise FrameError(f"body {name!r} is there twice, or is called as the ground is: give it another name")
        if "gravcomp" in element.attrib and numbers(element.attrib, "gravcomp", f"body {name!r}").any():
            self.left.append(f"gravcomp of body {name}")
        own, source = given_mass(self.source, element), self.source.compiler.get("inertiafromgeom", "auto")
        body = ReadBody(name, parent.name, frame, source == "true" or (own is None and source != "false"))
        self.bodies.append(body)
        self.content(element, body, frame, childclass)
        if own is not None and not body.masses:
            body.masses.append(frame.of(own))

    def _joint(self, element: Element, body: ReadBody, frame: Placement, childclass: str) -> ReadJoint:
        given = self.source.attributes(element, childclass)
        kind = "free" if element.tag == "freejoint" else given.get("type", "hinge")
        name = given.get("name") or (body.name if not body.joints else f"{body.name} joint {len(body.joints) + 1}")
        what = f"joint {name!r}"
        if kind not in JOINTS:
            raise FrameError(f"{what} is of type {kind!r}: give one of {', '.join(JOINTS)}")
        if kind == "free" and body.parent != GROUND:
            raise FrameError(f"{what} is free on body {body.parent!r}: only what the world carries moves freely")
        axis = frame.axes @ numbers(given, "axis", what, 3, "0 0 1")
        place = frame.at(numbers(given, "pos", what, 3, "0 0 0"))
        reference = float(numbers(given, "ref", what, 1, "0")[0]) if kind in ("hinge", "slide") else 0.0
        for word in IN_JOINTS:
            if word in given and numbers(given, word, what).any():
                self.left.append(f"{word} of joint {name}")
        if "range" in given and given.get("limited") != "false" and numbers(given, "range", what).any():
            self.left.append(f"range of joint {name}")
        length = float(np.linalg.norm(axis))
        if not length > 0.0:
            raise FrameError(f"{what}: axis is {given.get('axis')!r}: give a direction")
        turned = self.source.angle(reference) if kind == "hinge" else reference
        return ReadJoint(name, kind, axis / length if length != 1.0 else axis, place, turned)


def body_named(bodies: list[ReadBody], name: str, what: str) -> ReadBody:
    """A body by its name in MJCF, where the ground is called ``world``."""
    for body in bodies:
        if body.name == (GROUND if name == "world" else name):
            return body
    raise FrameError(f"{what} names body {name!r}, which is not there: choose one of {', '.join(_names(bodies))}")


def site_named(bodies: list[ReadBody], name: str, what: str) -> tuple[ReadBody, Placement]:
    """A site, and the body on which it is."""
    for body in bodies:
        if name in body.sites:
            return body, body.sites[name]
    raise FrameError(f"{what} names site {name!r}, which is not there: name a site of a body")


def _names(bodies: list[ReadBody]) -> Iterator[str]:
    return (body.name for body in bodies)
