"""Beams on which sliders run: they are cut where the sliders stand."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np

from ....elements import Beam
from ....framework.batch import Array

# A slider stands on a beam when it is off its line by less, as a share of the beam's length.
OFF_LINE = 1e-9


def inside(start: Array, end: Array, local: Array) -> bool:
    """Whether a place lies between the ends of a beam at all poses."""
    chord = end - start
    length = np.linalg.norm(chord, axis=-1)
    along = np.sum((local - start) * chord, axis=-1) / length
    off = np.linalg.norm(np.cross(local - start, chord), axis=-1) / length
    return bool(
        np.all(off < OFF_LINE * length) and np.all((along > OFF_LINE * length) & (length - along > OFF_LINE * length))
    )


def _fraction(chain: list[str], at: dict[str, Array], name: str) -> Array:
    start, end = at[chain[0]], at[chain[-1]]
    return np.asarray(np.linalg.norm(at[name] - start, axis=-1) / np.linalg.norm(end - start, axis=-1))


def in_order(chain: list[str], at: dict[str, Array]) -> list[str]:
    """Ends of a beam and the sliders on it in their order; sliders that pass each other cannot be told apart."""
    start, end, *between = chain[0], chain[1], *chain[2:]
    return [start, *sorted(between, key=lambda name: float(np.min(_fraction([start, end], at, name)))), end]


def cut(beam: Beam, chain: list[str], at: dict[str, Array]) -> list[Beam]:
    """The beam, cut where sliders stand on it."""
    if len(chain) == 2:
        return [beam]
    cuts = [np.zeros(()), *(_fraction(chain, at, name) for name in chain[1:-1]), np.ones(())]
    parts = []
    for index, (here, there) in enumerate(pairwise(cuts)):
        ends = {"start": index == 0, "end": index == len(cuts) - 2}
        release = tuple(name for name in beam.release if ends[name.split()[0]])
        sections: dict[str, Any] = {}
        if beam.end is not None:
            sections = {"section": beam.section.between(beam.end, here), "end": beam.section.between(beam.end, there)}
        parts.append(replace(beam, release=release, **sections))
    return parts
