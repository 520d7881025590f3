"""Sliders on the beams of a link: where along the link's elastic axis each of them stands, at every pose.

A slider may pass points of the link and its ends. The frame has one topology for all poses, so each slider cuts every
beam within which it comes to stand at a node of its own. Where it is elsewhere at a pose, the node cuts the beam
somewhere else, which changes nothing. A slider's seats are these nodes and the points of the link that it reaches: at
each pose it stands on one of them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import combinations, pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ....elements import Beam
from ....framework.batch import Array
from ....framework.errors import FrameError
from ....framework.protocol import LineElement
from ..description.joints import COMPONENTS
from ..description.parts import Pair

Mask = NDArray[np.bool_]
Ends = tuple[str, str]

# A slot runs along a beam where it lies no further off its line, and leans from it by no more (radians), as a share of
# the beam's length.
ALONG = 1e-2
# Where the slot lies in a plane: how far a slider may be off the line of a beam.
OFF_LINE = 1e-9
# A slider nearer to a node, as a share of the beam's length, stands on the node, its arm to it rigid: that the beam
# bends over this distance counts by its square.
AT_NODE = 1e-7
# Stiffness of a slider's hold on its seat by that of the link.
RIGID = 1e16


@dataclass(frozen=True, eq=False)
class Slider:
    """A slider of a link.

    Attributes
    ----------
    guide
        Node of the joint on the link, under the slider.
    pair
        The joint.
    place
        Where it is in the link's axes, (..., 3).
    """

    guide: str
    pair: Pair
    place: Array


@dataclass(frozen=True, eq=False)
class Visit:
    """A slider on a beam: the share of the beam's length before it (...), and at which poses it is there (...)."""

    slider: Slider
    fraction: Array
    within: Mask


@dataclass
class Layout:
    """How the beams of a link are cut, and where its sliders stand.

    Attributes
    ----------
    at
        Place in the link's axes by point and cut node, (..., 3).
    chains
        By beam: its ends with the cut nodes between them, in order.
    fractions
        By cut node: share of the beam's length before it, (...).
    bearing_points
        By guide: the nodes on which the slider stands, and at which poses (...); none where it never runs on a beam.
    """

    at: dict[str, Array]
    chains: dict[Ends, list[str]]
    fractions: dict[str, Array] = field(default_factory=dict)
    bearing_points: dict[str, dict[str, Mask]] = field(default_factory=dict)

    @classmethod
    def of(cls, beams: Mapping[Ends, LineElement], places: Mapping[str, Array], sliders: Sequence[Slider]) -> Layout:
        """Cut the beams of a link under its sliders; `places` are those of its points.

        Raises
        ------
        FrameError
            If sliders pass each other on a beam, or several of them come to stand on the same two points.
        """
        out = cls(dict(places), {ends: list(ends) for ends in beams})
        visits: dict[Ends, list[Visit]] = {}
        for slider in sliders:
            bearing_points = out.bearing_points[slider.guide] = {}
            free = np.ones(slider.place.shape[:-1], dtype=bool)
            runs = {ends: along for ends in beams if (along := _runs_along(slider, ends, places)).any()}
            for ends, along in runs.items():
                fraction = _fraction(slider.place, ends, places)
                within = free & along & (fraction > AT_NODE) & (fraction < 1.0 - AT_NODE)
                free = free & ~within
                if within.any():
                    visits.setdefault(ends, []).append(Visit(slider, fraction, within))
            if runs and free.any():
                bearing_points |= _at_points(slider, runs, places, free)
        _check_points({slider.pair.name: set(out.bearing_points[slider.guide]) for slider in sliders})
        for ends, those in visits.items():
            out._cut(ends, those)
        return out

    def parts(self, ends: Ends, beam: LineElement) -> list[LineElement]:
        """A beam that is cut, at its nodes.

        Raises
        ------
        FrameError
            If it is an element that cannot be cut anywhere.
        """
        chain = self.chains[ends]
        if not isinstance(beam, Beam):
            if type(beam).part is LineElement.part and not beam.releases:
                return [beam] * (len(chain) - 1)
            raise FrameError(
                f"a slider runs along {'-'.join(ends)}, which is a {beam.title}: only a Beam, or an element whose "
                "parts are as the whole, can be cut where it stands: give it a Beam"
            )
        cuts = [np.zeros(()), *(self.fractions[name] for name in chain[1:-1]), np.ones(())]
        out: list[LineElement] = []
        for index, (here, there) in enumerate(pairwise(cuts)):
            whole = {"start": index == 0, "end": index == len(cuts) - 2}
            release = tuple(name for name in beam.release if whole[name.split()[0]])
            sections: dict[str, Any] = {}
            if beam.end is not None:
                of = beam.section.between
                sections = {"section": of(beam.end, here), "end": of(beam.end, there)}
            out.append(replace(beam, release=release, **sections))
        return out

    def _cut(self, ends: Ends, visits: Sequence[Visit]) -> None:
        """Cut a beam under the sliders that come to stand within it, and seat them there."""
        ordered = _in_order(visits)
        start, chord = self.at[ends[0]], self.at[ends[1]] - self.at[ends[0]]
        for visit, fraction in zip(ordered, _nodes(ordered), strict=True):
            always = bool(visit.within.all())
            guide = visit.slider.guide
            name = guide if always else f"{guide}.{ends[0]}-{ends[1]}"
            self.fractions[name], self.at[name] = fraction, start + fraction[..., None] * chord
            self.bearing_points[guide][name] = visit.within
            self.chains[ends].insert(-1, name)


def contact_stiffness(beams: Mapping[Ends, LineElement], places: Mapping[str, Array]) -> Array:
    """Stiffness (6,) of a slider's hold on a seat, so far above that of the link that it is rigid to rounding.

    It stands alone on the diagonal of its own coordinate, and costs no digits.
    """
    most = np.zeros(6)
    for ends, beam in beams.items():
        matrix = beam.stiffness_matrix(_distance(places[ends[1]], places[ends[0]]))
        most = np.maximum(most, np.diagonal(matrix, axis1=-2, axis2=-1).reshape(-1, 12).max(axis=0)[:6])
    return np.repeat([RIGID * most[:3].max(), RIGID * most[3:].max()], 3)


def _at_points(slider: Slider, runs: Mapping[Ends, Mask], places: Mapping[str, Array], where: Mask) -> dict[str, Mask]:
    """Poses at which a slider stands on each point: the nearest end of a beam that it runs along there, as it is at one
    of them or beyond; where it runs along none, the point of its joint."""
    reached: dict[str, Mask] = {}
    for ends, along in runs.items():
        for end in ends:
            reached[end] = reached.get(end, np.zeros((), dtype=bool)) | along
    drawn = slider.pair.point
    reached[drawn] = reached.get(drawn, np.zeros((), dtype=bool)) | ~np.logical_or.reduce([*runs.values()])
    away = [np.where(here, _distance(slider.place, places[point]), np.inf) for point, here in reached.items()]
    nearest = np.argmin(np.stack(np.broadcast_arrays(*away)), axis=0)
    found = {point: where & (nearest == index) for index, point in enumerate(reached)}
    return {point: here for point, here in found.items() if here.any()}


def _in_order(visits: Sequence[Visit]) -> list[Visit]:
    """Sliders on a beam in the order in which they stand on it where they do so at one time."""
    out: list[Visit] = []
    for visit in visits:
        before = [k for k, other in enumerate(out) if _ahead(other, visit)]
        out.insert(min(before, default=len(out)), visit)
    for here, there in combinations(out, 2):
        if _ahead(here, there, by=-AT_NODE):
            raise FrameError(
                f"sliders {here.slider.pair.name!r} and {there.slider.pair.name!r} pass each other on one beam, or "
                "stand at one place of it: give each a link of its own, and join these firmly"
            )
    return out


def _ahead(one: Visit, other: Visit, by: float = 0.0) -> bool:
    """Whether the one slider stands further along than the other at some pose at which both stand on the beam."""
    return bool(np.any(one.within & other.within & (one.fraction > other.fraction + by)))


def _nodes(visits: Sequence[Visit]) -> list[Array]:
    """Fractions at which a beam is cut: under its sliders, and evenly between these for those that are elsewhere."""
    shape = np.broadcast_shapes(*(visit.fraction.shape for visit in visits), *(visit.within.shape for visit in visits))
    within = np.stack([np.broadcast_to(visit.within, shape) for visit in visits])
    known = np.stack([np.broadcast_to(np.where(visit.within, visit.fraction, 0.0), shape) for visit in visits])
    count = np.arange(1, len(visits) + 1).reshape(-1, *(1,) * len(shape))
    # The nearest slider before and behind each node, by number and place; the ends of the beam where there is none.
    first = np.maximum.accumulate(np.where(within, count, 0), axis=0)
    start = np.maximum.accumulate(known, axis=0)
    last = np.minimum.accumulate(np.where(within, count, len(visits) + 1)[::-1], axis=0)[::-1]
    end = np.minimum.accumulate(np.where(within, known, 1.0)[::-1], axis=0)[::-1]
    share = (count - first) / np.where(within, 1, last - first)
    return list(np.where(within, known, start + share * (end - start)))


def _check_points(bearing_points: Mapping[str, set[str]]) -> None:
    """See that what holds sliders on the points that they reach forms no loop, in which its stiffness would cancel.

    A loop closes with a slider that reaches two points which others, by way of what they reach, join already.
    """
    joined: list[tuple[set[str], set[str]]] = []
    for name, points in bearing_points.items():
        touched = [each for each in joined if each[0] & points]
        for group, others in touched:
            if len(both := group & points) > 1:
                raise FrameError(
                    f"slider {name!r} comes to stand on {' and '.join(map(repr, sorted(both)))}, as "
                    f"{' and '.join(map(repr, sorted(others)))} at other poses: give each a link of its own, and join "
                    "these firmly"
                )
        rest = [each for each in joined if each not in touched]
        joined = [*rest, (points.union(*(each[0] for each in touched)), {name}.union(*(each[1] for each in touched)))]


def _runs_along(slider: Slider, ends: Ends, places: Mapping[str, Array]) -> Mask:
    """At which poses the slot of a slider runs along the line of a beam, (...)."""
    start, chord = places[ends[0]], places[ends[1]] - places[ends[0]]
    length = np.linalg.norm(chord, axis=-1)
    ways = [COMPONENTS.index(name) for name in slider.pair.kind.moving if name[0] == "u"]
    if len(ways) > 1:
        return np.asarray(_off(slider.place, start, chord) <= OFF_LINE * length)
    leans = np.linalg.norm(np.cross(slider.pair.axes[..., ways[0]], chord), axis=-1)
    off = _off(places[slider.pair.point], start, chord)
    return np.asarray((leans <= ALONG * length) & (off <= ALONG * length))


def _off(place: Array, start: Array, chord: Array) -> Array:
    """Distance of a place from a line, (...)."""
    return np.asarray(np.linalg.norm(np.cross(place - start, chord), axis=-1) / np.linalg.norm(chord, axis=-1))


def _fraction(place: Array, ends: Ends, places: Mapping[str, Array]) -> Array:
    """Foot of the perpendicular on a beam, as a share of its length from the start, (...)."""
    start, chord = places[ends[0]], places[ends[1]] - places[ends[0]]
    return np.asarray(np.sum((place - start) * chord, axis=-1) / np.sum(chord * chord, axis=-1))


def _distance(one: Array, other: Array) -> Array:
    return np.asarray(np.linalg.norm(one - other, axis=-1))
