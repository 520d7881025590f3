"""Read a linkage from an MJCF file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, Generic, TypeVar

import numpy as np

from ....framework.dofs import FORCES
from ....framework.errors import FrameError
from ..description.joints import KINDS
from ..description.linkage_description import LinkageDescription
from ..description.parts import GROUND
from .left_out import tell
from .mjcf_bodies import bodies_of, site_named
from .mjcf_joints import ReadPair, joined
from .mjcf_loops import ReadLoops
from .mjcf_mass import together
from .mjcf_points import PointsOfBodies
from .mjcf_source import MjcfSource, numbers, shown
from .mjcf_write import MASSLESS

Described = TypeVar("Described", bound=LinkageDescription)

# Gravity if the file gives none.
GRAVITY = "0 0 -9.81"


def mjcf_linkage(file: Path, kind: type[Described]) -> Described:
    """The linkage of an MJCF file, such as a `Linkage`.

    Raises
    ------
    FrameError
        If the file cannot be read, or has something that is not possible in a linkage; the message names the element.
    """
    try:
        source = MjcfSource(file)
        reader = MjcfReader(source, kind())
        linkage = reader.whole()
    except FrameError as error:
        raise FrameError(f"{file}: {error}") from error
    except RecursionError:
        raise FrameError(f"{file}: its elements stand too deep within one another: nest fewer bodies") from None
    tell(file, reader.left, "a linkage", depth=3)
    return linkage


class MjcfReader(Generic[Described]):
    """Reader of one file.

    Parameters
    ----------
    source
        The file.
    linkage
        The empty linkage to fill.
    """

    def __init__(self, source: MjcfSource, linkage: Described) -> None:
        self.source, self.linkage = source, linkage
        self.bodies, self.left = bodies_of(source)
        self.loops = ReadLoops(source, self.bodies)
        couplings = self.loops.couplings
        self.joinings = [each for body in self.bodies[1:] for each in joined(body, couplings)]
        for coupling in couplings:
            raise FrameError(
                f"joint {coupling.follower!r} is tied to {coupling.leader!r}: a linkage has no gears; leave the "
                "constraint out, or describe what ties them by links"
            )
        self.joinings += self.loops.joinings
        self.points = PointsOfBodies(self.bodies, self.loops)

    def whole(self) -> Described:
        """Fill the linkage and return it."""
        names = [self.points.of(each) for each in self.joinings]
        self.points.complete(self.bodies)
        for name, place in self.points.places.items():
            self.linkage.point(name, place)
        for link, points in self.points.on_links.items():
            if link != GROUND:
                self.linkage.link(link, *points, **self._mass(link))
        for each, name in zip(self.joinings, names, strict=True):
            self._join(each, name)
        self._springs()
        self._actuators()
        option = {key: text for element in self.source.root.findall("option") for key, text in element.attrib.items()}
        weightless = self.source.flags.get("gravity") == "disable"
        self.linkage.gravity(np.zeros(3) if weightless else numbers(option, "gravity", "option", 3, GRAVITY))
        return self.linkage

    def _mass(self, link: str) -> dict[str, Any]:
        light = any(element.get("name") == f"{MASSLESS}{link}" for element in self.source.section("custom"))
        bodies = (body for body in self.bodies if self.points.link_of(body.name) == link)
        own = [mass for body in bodies for mass in body.masses]
        if light or not own:
            return {}
        whole = own[0] if len(own) == 1 else together(own)
        return {"mass": whole.mass, "centre": whole.centre, "inertia": whole.tensor}

    def _join(self, each: ReadPair, point: str) -> None:
        """Add a joint, with its axes unchanged to the last bit."""
        linkage, kind = self.linkage, KINDS[each.kind]
        first, second = (self.points.link_of(link) for link in (each.first, each.second))
        given: dict[str, Any] = {"name": each.name, "axis": each.axes[:, 2]}
        if each.kind == "universal":
            given["second"] = each.axes[:, 0]
        if each.kind == "screw":
            given["pitch"] = each.pitch
        if kind.freedom:
            given["reference"] = each.reference[0] if kind.freedom == 1 else each.reference
        before = set(linkage.joints)
        getattr(linkage, each.kind)(point, first, second, **given)
        (name,) = set(linkage.joints) - before
        linkage.joints[name] = replace(linkage.joints[name], axes=each.axes)

    # -- what acts --------------------------------------------------------------------------------------------------

    def _springs(self) -> None:
        """Add tendons from one site to another as springs."""
        for tendon in self.source.section("tendon"):
            given = self.source.attributes(tendon, section="tendon")
            what = shown(tendon)
            stiffness, damping = (float(numbers(given, key, what, 1, "0")[0]) for key in ("stiffness", "damping"))
            if not stiffness and not damping:
                continue
            sites = [child.get("site", "") for child in tendon]
            if tendon.tag != "spatial" or len(sites) != 2 or any(child.tag != "site" for child in tendon):
                raise FrameError(f"{what} runs over more than two sites: a spring goes from one point to another")
            ends = [site_named(self.bodies, name, what)[0] for name in sites]
            (one, start), (other, end) = (
                (self.points.link_of(body.name), self.points.of_site(name))
                for body, name in zip(ends, sites, strict=True)
            )
            length = numbers(given, "springlength", what, None, "-1")
            if len(set(length.tolist())) > 1:
                raise FrameError(f"{what} is slack from {length[0]:g} to {length[1]:g}: give one springlength")
            rest = float(length[0])
            if rest < 0.0:
                rest = float(np.linalg.norm(self.linkage.points[start] - self.linkage.points[end]))
            self.linkage.spring((one, start), (other, end), stiffness=stiffness, length=rest, damping=damping)

    def _actuators(self) -> None:
        """Add actuators: any on a joint drives it, a constant force on a site is a load."""
        driven: dict[str, set[str]] = {}
        for element in self.source.section("actuator"):
            given = self.source.attributes(element)
            name = given.get("joint") or given.get("jointinparent")
            if name is not None:
                self._drive(driven, name, shown(element))
            elif not self._load(given, shown(element)):
                self.left.append(f"actuator {shown(element)}")
        for joint, coordinates in driven.items():
            self.linkage.drive(joint, *coordinates)

    def _drive(self, driven: dict[str, set[str]], name: str, what: str) -> None:
        for each in self.joinings:
            if name in each.coordinates:
                joint = each.name if each.name is not None else name
                coordinate = each.coordinates[name]
                kind = self.linkage.joint(joint).kind
                driven.setdefault(joint, set()).update((coordinate,) if coordinate else kind.coordinates)
                return
        raise FrameError(f"{what} acts on joint {name!r}, which is not there or free: name another joint")

    def _load(self, given: Mapping[str, str], what: str) -> bool:
        """Add an actuator as a load, if it is a constant force along axes of the ground or of a site; whether it is."""
        constant = given.get("biastype") == "affine" and not numbers(given, "gainprm", what, None, "1").any()
        bias = numbers(given, "biasprm", what, None, "0")
        if not constant or bias[1:].any() or "site" not in given:
            return False
        body, site = site_named(self.bodies, given["site"], what)
        gear = np.zeros(6)
        found = bias[0] * numbers(given, "gear", what, None, "1")
        gear[: len(found)] = found
        axes = site.axes
        if "refsite" in given:
            carrier, other = site_named(self.bodies, given["refsite"], what)
            if carrier.name != GROUND:
                return False
            axes = other.axes
        value = np.concatenate([axes @ gear[:3], axes @ gear[3:]])
        point = self.points.of_site(given["site"])
        follows = "refsite" not in given
        force = dict(zip(FORCES, value.tolist(), strict=True))
        self.linkage.load(point, link=self.points.link_of(body.name), follower=follows, **force)
        return True
