"""Sliders on the beams of a link: where along the link's elastic axis each of them stands at every pose.

A slider may pass points of the link and its ends. The frame has one topology for all poses, so each slider divides
every beam that it runs on by a cut node of its own. At poses where the slider is elsewhere, the node divides the beam
at some other place, which does not change its stiffness. At each pose the slider stands on one of its cut nodes or on a
point of the link.
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

# Largest distance of a slot from the line of a beam, as a share of the beam's length, and largest angle between them
# (radians), with which the slider runs along the beam.
ALONG = 1e-2
# Largest distance from the line of a beam, as a share of its length, of a joint that slides in a plane.
OFF_LINE = 1e-9
# A slider nearer to a node than this share of the beam's length stands on the node, with a rigid arm: neglecting the
# bending over so short an arm is an error of second order in it.
AT_NODE = 1e-7
# Ratio of a slider's contact stiffness to the largest stiffness of the link's beams.
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
        Position in the link's axes, (..., 3).
    """

    guide: str
    pair: Pair
    place: Array


@dataclass(frozen=True, eq=False)
class Visit:
    """A slider on a beam: its position as a fraction of the beam's length (...), and the poses where it is there."""

    slider: Slider
    fraction: Array
    within: Mask


@dataclass
class Layout:
    """How the beams of a link are cut, and where its sliders stand.

    Attributes
    ----------
    at
        By point and cut node: position in the link's axes, (..., 3).
    chains
        By beam: its ends with the cut nodes between them, in order.
    fractions
        By cut node: position as a fraction of the beam's length, (...).
    bearing_points
        By guide: the nodes on which the slider stands, each with the poses where it does (...); empty if the slider
        never runs on a beam.
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
        """Pieces of a beam between its cut nodes.

        Raises
        ------
        FrameError
            If the element cannot be cut.
        """
        chain = self.chains[ends]
        if not isinstance(beam, Beam):
            if type(beam).part is LineElement.part and not beam.releases:
                return [beam] * (len(chain) - 1)
            raise FrameError(
                f"a slider runs along {'-'.join(ends)}, which is a {beam.title}: only a Beam, or an element whose "
                "parts equal the whole, can be cut at the slider: give it a Beam"
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
        """Cut a beam under the sliders that come to stand within it, and let them stand on the cut nodes."""
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
    """Stiffness (6,) between a slider and the node that it stands on, rigid to rounding compared with the link.

    As the joint's own coordinate it stands alone on the diagonal, so that its size costs no digits.
    """
    most = np.zeros(6)
    for ends, beam in beams.items():
        matrix = beam.stiffness_matrix(_distance(places[ends[1]], places[ends[0]]))
        most = np.maximum(most, np.diagonal(matrix, axis1=-2, axis2=-1).reshape(-1, 12).max(axis=0)[:6])
    return np.repeat([RIGID * most[:3].max(), RIGID * most[3:].max()], 3)


def _at_points(slider: Slider, runs: Mapping[Ends, Mask], places: Mapping[str, Array], where: Mask) -> dict[str, Mask]:
    """Poses, of those in `where`, at which a slider stands on each point.

    A slider at or beyond the end of a beam that it runs along stands on the nearest such end; one that runs along no
    beam stands on its joint's point.
    """
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
    """Sliders on a beam in the order in which they stand on it at common poses."""
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
    """Whether the first slider is further along the beam than the second, by more than `by`, at a common pose."""
    return bool(np.any(one.within & other.within & (one.fraction > other.fraction + by)))


def _nodes(visits: Sequence[Visit]) -> list[Array]:
    """Fractions at which a beam is cut: under its sliders, and evenly between these for sliders that are elsewhere."""
    shape = np.broadcast_shapes(*(visit.fraction.shape for visit in visits), *(visit.within.shape for visit in visits))
    within = np.stack([np.broadcast_to(visit.within, shape) for visit in visits])
    known = np.stack([np.broadcast_to(np.where(visit.within, visit.fraction, 0.0), shape) for visit in visits])
    count = np.arange(1, len(visits) + 1).reshape(-1, *(1,) * len(shape))
    # number and place of the nearest slider before and after each node, or else of the beam's end
    first = np.maximum.accumulate(np.where(within, count, 0), axis=0)
    start = np.maximum.accumulate(known, axis=0)
    last = np.minimum.accumulate(np.where(within, count, len(visits) + 1)[::-1], axis=0)[::-1]
    end = np.minimum.accumulate(np.where(within, known, 1.0)[::-1], axis=0)[::-1]
    share = (count - first) / np.where(within, 1, last - first)
    return list(np.where(within, known, start + share * (end - start)))


def _check_points(bearing_points: Mapping[str, set[str]]) -> None:
    """Check that sliders and the points they stand on form no loop, in which the contact stiffnesses would cancel.

    A slider closes a loop if two of its points are already connected through other sliders.
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
    """Poses at which the slot of a slider runs along the line of a beam, (...)."""
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
    """Foot of the perpendicular on a beam, as a fraction of its length from the start, (...)."""
    start, chord = places[ends[0]], places[ends[1]] - places[ends[0]]
    return np.asarray(np.sum((place - start) * chord, axis=-1) / np.sum(chord * chord, axis=-1))


def _distance(one: Array, other: Array) -> Array:
    return np.asarray(np.linalg.norm(one - other, axis=-1))
