"""Pairs of points between which the beams of a link run, if only its points are given."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from ....elements import Beam
from ....framework.arm import crossed
from ....framework.batch import Array
from ....framework.errors import FrameError
from ....framework.protocol import LineElement

Ends = tuple[str, str]

# Largest angle between two pieces of a link that lie in one line, radians.
IN_LINE = 1e-2


def neighbours(link: str, points: Sequence[str], places: Mapping[str, Array], beam: object) -> list[Ends]:
    """Pairs of points between which the beams of a link run, one after the other.

    Beams follow the points in the given order. If points on a straight line are not in their order along it, so that
    beams would overlap, there is one bar with all of these points on it.

    Raises
    ------
    FrameError
        If such a bar tapers or has releases, its points change their order within the batch, or it is straight at some
        entries only.
    """
    pairs = list(pairwise(points))
    if len(pairs) < 2:
        return pairs
    chords = [places[end] - places[start] for start, end in pairs]
    lengths = [np.sqrt(np.vecdot(chord, chord)) for chord in chords]
    if all(_leads_on(*both) for both in pairwise(zip(chords, lengths, strict=True))):
        return pairs
    longest = max((np.abs(chord).max(initial=0.0) for chord in chords), default=0.0)
    chords = [chord / (longest or 1.0) for chord in chords]  # their fourth powers are finite in any unit of length
    if not all(np.all(np.vecdot(chord, chord)) for chord in chords):
        return pairs
    _check_alike(link, points, chords)
    out: list[Ends] = []
    first = 0
    for index in range(1, len(pairs) + 1):
        if index == len(pairs) or not _in_line(chords[first], chords[index]).all():
            stretch = list(points[first : index + 1])
            back = any(np.any(np.vecdot(chords[first], chord) < 0.0) for chord in chords[first:index])
            out += pairwise(_in_order(link, stretch, places, chords[first], beam) if back else stretch)
            first = index
    return out


def _leads_on(one: tuple[Array, Array], other: tuple[Array, Array]) -> bool:
    """Whether the angle between two successive pieces (vector, length) is below 135 degrees at all entries."""
    (first, size), (second, other_size) = one, other
    return bool(np.all(np.vecdot(first, second) > -np.sqrt(0.5) * size * other_size))


def _in_line(one: Array, other: Array) -> NDArray[np.bool_]:
    across, size = crossed(one, other), np.vecdot(one, one) * np.vecdot(other, other)
    return np.asarray(np.vecdot(across, across) <= IN_LINE**2 * size)


def _check_alike(link: str, points: Sequence[str], chords: Sequence[Array]) -> None:
    """Check that a line that runs back over itself is straight at all entries or at none."""
    for first, along in enumerate(chords):
        straight = np.ones((), dtype=bool)
        for last, chord in enumerate(chords[first + 1 :], start=first + 1):
            straight = straight & _in_line(along, chord)
            if not straight.any():
                break
            if not straight.all() and np.any(straight & (np.vecdot(along, chord) < 0.0)):
                text = ", ".join(points[first : last + 2])
                raise FrameError(
                    f"link {link!r}: its line runs back over itself along {text} at some entries of the batch and is "
                    "not straight at others: split the batch, or give beam= by pairs of points"
                )


def _in_order(
    link: str, points: Sequence[str], places: Mapping[str, Array], along: Array, beam: object
) -> Sequence[str]:
    """The points of a straight line in their order on it."""
    text = ", ".join(points)
    if isinstance(beam, LineElement) and (beam.releases or (isinstance(beam, Beam) and beam.end is not None)):
        raise FrameError(
            f"link {link!r}: its line runs back over itself along {text}, and its beam tapers or has releases: name "
            "the points in their order along the link, or give beam= by pairs of points"
        )
    where = {point: np.sum((places[point] - places[points[0]]) * along, axis=-1) for point in points}
    ordered = sorted(points, key=lambda point: float(np.min(where[point])))
    if any(np.any(where[here] >= where[there]) for here, there in pairwise(ordered)):
        raise FrameError(
            f"link {link!r}: the order of {text} along it changes within the batch, or two of them coincide: "
            "split the batch, or give beam= by pairs of points"
        )
    return ordered
