"""Equality constraints of MJCF as joints that close loops."""

from __future__ import annotations

from collections.abc import Mapping
from xml.etree.ElementTree import Element

import numpy as np

from ....framework.batch import Array
from ....framework.errors import FrameError
from ..description.parts import ROUNDING, joint_axes
from .mjcf_bodies import Placement, ReadBody, body_named, site_named
from .mjcf_joints import ReadPair, TiedJoints
from .mjcf_source import MjcfSource, numbers, shown

Z = (0.0, 0.0, 1.0)


class ReadLoops:
    """The equality constraints of a file.

    Parameters
    ----------
    source, bodies
        The file, and its bodies.

    Attributes
    ----------
    joinings
        Joints that close loops.
    couplings
        Pairs of joints that move in proportion.
    parts
        By name of a body that is a part of a link, ``X at J`` welded to ``X``: that link.
    """

    def __init__(self, source: MjcfSource, bodies: list[ReadBody]) -> None:
        self.source, self.bodies = source, bodies
        self.size = _extent(bodies)
        self.joinings: list[ReadPair] = []
        self.couplings: list[TiedJoints] = []
        self.parts: dict[str, str] = {}
        shared: dict[tuple[str, str], list[tuple[str, Array]]] = {}
        for element in source.section("equality"):
            given = source.attributes(element, section="equality")
            if given.get("active", "true") == "false":
                continue
            if element.tag == "connect":
                ends, place = self._connect(element, given)
                shared.setdefault(ends, []).append((given.get("name", " ".join(ends)), place))
            elif element.tag == "weld":
                self._weld(element, given)
            elif element.tag == "joint":
                self._couple(element, given)
            else:
                raise FrameError(f"{shown(element)} ties what a linkage cannot tie: leave the constraint out")
        for ends, points in shared.items():
            self.joinings.append(self._shared(ends, points))

    def _ends(self, element: Element, given: Mapping[str, str]) -> tuple[list[ReadBody], list[Placement] | None]:
        """Bodies of a constraint, and the frames of its sites; None if it has no sites."""
        what = shown(element)
        if "site1" in given:
            found = [site_named(self.bodies, given.get(f"site{k}", ""), what) for k in (1, 2)]
            return [body for body, _ in found], [frame for _, frame in found]
        bodies = [body_named(self.bodies, given.get(key, "world"), what) for key in ("body1", "body2")]
        if bodies[0] is bodies[1]:
            raise FrameError(f"{what} ties body {bodies[0].name!r} to itself: name two bodies")
        return bodies, None

    def _connect(self, element: Element, given: Mapping[str, str]) -> tuple[tuple[str, str], Array]:
        bodies, frames = self._ends(element, given)
        ends = bodies[0].name, bodies[1].name
        if frames is None:
            return ends, bodies[0].frame.at(numbers(given, "anchor", shown(element), 3))
        self._check_assembled(element, frames[0].origin - frames[1].origin)
        return ends, frames[0].origin

    def _shared(self, ends: tuple[str, str], points: list[tuple[str, Array]]) -> ReadPair:
        """Joint of two bodies that share points: spherical for one, revolute for several in line, else fixed."""
        name, place = points[0]
        arms = np.array([other - place for _, other in points])
        spread = np.linalg.svd(arms, compute_uv=False) if len(points) > 1 else np.zeros(3)
        rank = int(np.sum(spread > ROUNDING * self.size))
        if rank == 0:
            return ReadPair(name, "spherical", *ends, place, joint_axes(name, Z), (0.0,) * 3, {})
        if rank == 1:
            axis = arms[np.argmax(np.linalg.norm(arms, axis=1))]
            return ReadPair(name, "revolute", *ends, place, joint_axes(name, axis), (0.0,), {})
        return ReadPair(name, "fixed", *ends, place, joint_axes(name, Z), (), {})

    def _weld(self, element: Element, given: Mapping[str, str]) -> None:
        bodies, frames = self._ends(element, given)
        one, other = bodies
        name = given.get("name", f"{one.name} {other.name}")
        if frames is not None:
            off = np.append(frames[0].origin - frames[1].origin, self.size * (frames[0].axes - frames[1].axes))
            self._check_assembled(element, off)
        elif numbers(given, "relpose", shown(element), 7, "0 1 0 0 0 0 0")[3:].any():
            relative = Placement().inner(
                numbers(given, "relpose", shown(element), 7)[:3],
                self.source.orientation({"quat": " ".join(given["relpose"].split()[3:])}, shown(element)),
            )
            there = one.frame.inner(relative.origin, relative.axes)
            off = np.append(there.origin - other.frame.origin, self.size * (there.axes - other.frame.axes))
            self._check_assembled(element, off)
        if one.name == f"{other.name} at {name}" and one.joints:
            self.parts[one.name] = other.name
            return
        place = other.frame.origin if frames is None else frames[0].origin
        self.joinings.append(ReadPair(name, "fixed", one.name, other.name, place, joint_axes(name, Z), (), {}))

    def _couple(self, element: Element, given: Mapping[str, str]) -> None:
        what = shown(element)
        factors = np.array([0.0, 1.0, 0.0, 0.0, 0.0])
        own = numbers(given, "polycoef", what, None, "0 1")[: len(factors)]
        factors[: len(own)] = own
        if "joint2" not in given or factors[0] or factors[2:].any():
            raise FrameError(
                f"{what} ties joint {given.get('joint1')!r} other than in proportion to another: a linkage has no such "
                "joint; leave the constraint out, or describe what ties them by links"
            )
        self.couplings.append(TiedJoints(given.get("joint1", ""), given["joint2"], float(factors[1])))

    def _check_assembled(self, element: Element, off: Array) -> None:
        """Refuse a constraint that is violated in the position of the file: a linkage is described assembled."""
        if np.linalg.norm(off) > 1e-6 * self.size:
            raise FrameError(
                f"{shown(element)} is open by {np.linalg.norm(off):.2g} in the position of the file: write the bodies "
                "in a position in which the loops are closed"
            )


def _extent(bodies: list[ReadBody]) -> float:
    places = [body.frame.origin for body in bodies]
    places += [each.place for body in bodies for each in body.joints]
    places += [site.origin for body in bodies for site in body.sites.values()]
    return float(np.linalg.norm(np.ptp(np.array(places), axis=0))) or 1.0
