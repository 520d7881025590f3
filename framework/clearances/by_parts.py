"""Contact of a long batch, found for one part of its entries after the other, so that memory does not grow with it.

Stiffness against offsets and joint trees take some hundred numbers an entry, contact itself some twenty.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..batch import Array
from ..described.at_entries import frame_at
from ..description import Description
from ..entries import Stretch
from ..errors import FrameError
from ..states import States
from .contact_search import ContactSearch
from .contact_state import ClearanceComponents, Tally
from .determinate import kept_in_memory
from .without_loads import count_of_entries

# Largest number of entries whose contact is found at a time. Parts of longer batches have more than half as many.
MOST = 2**18


@dataclass(frozen=True, eq=False)
class ContactOfParts:
    """The contact of all journals at equilibrium, as found for each part of a batch.

    Attributes
    ----------
    count
        Number of parts.
    lost, unfit
        Entries without results, (...), see `ContactSearch`.
    offset, force
        Displacement within the clearance and contact force by component, (n, ...).
    size
        Magnitude of the contact force in each joint, (joints, ...).
    state
        State of each joint, a `ClearanceState`, (joints, ...).
    tally
        How the minima of energy were found.
    """

    count: int
    lost: NDArray[np.bool_]
    unfit: NDArray[np.bool_]
    offset: Array
    force: Array
    size: Array
    state: States
    tally: Tally


def is_long(frame: Description) -> bool:
    """Whether a batch is long enough for its contact to be found in parts."""
    return math.prod(frame.shape) > MOST


def too_much_varies(frame: Description, components: ClearanceComponents) -> bool:
    """Whether motions by unit offsets vary over so many entries that contact in closed form is out of question."""
    count = len(components.pairs) * count_of_entries(frame, {}, {})
    return not kept_in_memory(count, math.prod(frame.shape))


def contact_of_parts(
    frame: Description, components: ClearanceComponents, search: Callable[[Description, bool | None], ContactSearch]
) -> ContactOfParts | None:
    """The contact of a batch, one part of it after the other.

    Parameters
    ----------
    frame
        The frame, of a long batch.
    components
        Its components with clearance.
    search
        Function that returns the search for the contact of some entries, given whether offsets cause forces at the
        first entry, or None.

    Returns
    -------
    ContactOfParts or None
        The contact; None where an error is told of a part, such as that none of its entries has results, which need
        not be one of the whole batch.
    """
    shape, count, joints = frame.shape, len(components.pairs), len(components.names)
    masks = [np.zeros(shape, dtype=bool) for _ in range(2)]
    vectors = [np.empty((count, *shape)) for _ in range(2)]
    out = [*masks, *vectors, np.empty((joints, *shape)), np.empty((joints, *shape), dtype=np.int8)]
    tally, parts = Tally(), _parts(frame)
    resists: bool | None = None
    for part in parts:
        try:
            found = search(frame_at(frame, part, _shape_of(part, frame)), resists)
            found.finish()
        except FrameError:
            return None
        numbers = found.lost, found.unfit, found.offset, found.force, found.size, found.state
        where: Any = (..., *part.where)
        for place, values in zip(out, numbers, strict=True):
            place[where] = values
        resists = found.known_to_resist
        tally = tally.and_of(found.tally)
    lost, unfit, offset, force, size, state = out
    return ContactOfParts(len(parts), lost, unfit, offset, force, size, state, tally)


def _parts(frame: Description) -> list[Stretch]:
    """Parts of a batch along its longest axis, of almost equal size."""
    axis = int(np.argmax(frame.shape))
    length = frame.shape[axis]
    parts = min(length, -(-math.prod(frame.shape) // MOST))
    ends = [k * length // parts for k in range(parts + 1)]
    return [Stretch(ndim=len(frame.shape), axis=axis, indices=slice(*pair)) for pair in pairwise(ends)]


def _shape_of(part: Stretch, frame: Description) -> tuple[int, ...]:
    sizes = list(frame.shape)
    sizes[part.axis] = part.indices.stop - part.indices.start
    return tuple(sizes)
