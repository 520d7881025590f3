"""Where the points of a link lie on it."""

from __future__ import annotations

import numpy as np

from ....framework.batch import Array
from .sketch import Sketch


def place(linkage: Sketch, link: str, point: str) -> Array:
    """Where a point is in its link's axes, (..., 3), which are the global ones in the reference configuration.

    It is that of the reference configuration, but for the second point of a link that was given its true length.
    """
    reference_place, given = linkage.points[point], linkage.links.get(link)
    if given is None or given.length is None or point == given.points[0]:
        return reference_place
    start = linkage.points[given.points[0]]
    chord = reference_place - start
    return np.asarray(start + chord * (given.length / np.linalg.norm(chord, axis=-1))[..., None])


def places(linkage: Sketch, link: str) -> dict[str, Array]:
    """Where all points of a link are, as `place` has it; of the ground, those of the whole linkage."""
    points = linkage.links[link].points if link in linkage.links else linkage.points
    return {point: place(linkage, link, point) for point in points}
