"""Refuse inputs of a job that would have no effect or cannot be meant, before anything is computed."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..description.parts import GROUND
from ..files.source import Source
from ..files.toml import written
from ..files.write import tables
from ..linkage import Linkage
from ..study.tolerances import Tolerance, varied

# Options of [run] for samples, which exist only with tolerances.
OF_SAMPLES = ("samples", "rng", "sampler", "nan_policy")
# A probability at which no usual distribution has its nominal value.
TRIED = 0.31


def check_effects(source: Source, linkage: Linkage, distributions: Mapping[str, Tolerance]) -> None:
    """Refuse options and tolerances without effect, and tolerances of numbers that cannot have samples.

    Raises
    ------
    FrameError
        If there is one; the message names its line.
    """
    if not distributions:
        for key in OF_SAMPLES:
            if source.get(("run", key)) is not None:
                source.fail(("run", key), "has no effect, as the file has no tolerances: give [tolerances.name]")
        return
    tried = {name: np.full(2, tolerance.distribution.ppf(np.array(TRIED))) for name, tolerance in distributions.items()}
    varied(source, distributions, tried, Linkage)
    as_written = _described(linkage)
    for name, values in tried.items():
        if _described(varied(source, distributions, {name: values[0]}, Linkage)) == as_written:
            what = ", ".join(distributions[name].names)
            source.fail(("tolerances", name), f"has no effect, as the linkage does not use {what}: leave it out")


def check_clearances(source: Source, linkage: Linkage) -> None:
    """Refuse clearances larger than a link of the joint, which have a wrong unit.

    Raises
    ------
    FrameError
        If there is one; the message names its line.
    """
    for name, pair in linkage.joints.items():
        links = [linkage.links[link] for link in (pair.first, pair.second) if link != GROUND]
        sizes = {link.name: _size(linkage, link.points) for link in links if len(link.points) > 1}
        for link, size in sizes.items():
            if pair.clearance is not None and 0.0 < size <= pair.clearance:
                place = ("joints", name, "clearance")
                source.fail(
                    place, f"is {pair.clearance:g}, no less than link {link!r} is long ({size:g}): check its unit"
                )


def _size(linkage: Linkage, points: tuple[str, ...]) -> float:
    """Largest distance between two points."""
    places = np.array([linkage.points[point] for point in points])
    return float(np.linalg.norm(places[:, None] - places, axis=-1).max())


def _described(linkage: Linkage) -> str:
    """Description of the linkage as text, without unused points."""
    ends = (end for spring in linkage.springs for end in (spring.first, spring.second))
    used = {point for link in linkage.links.values() for point in link.points}
    used |= {point for link, point in ends if link == GROUND}
    out = tables(linkage)
    points: Mapping[str, object] = out.get("points", {})
    return written(out | {"points": {name: place for name, place in points.items() if name in used}})
