"""Status of a frame's entries taken over from its origin, such as the poses of a motion."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from .batch import Shape

REGULAR, STABLE = "regular", "stable"


class HasStatus(Protocol):
    """An origin that has a status for each batch entry."""

    @property
    def status(self) -> NDArray[np.str_]:
        """``regular`` or what is special, (...)."""
        ...

    @property
    def is_regular(self) -> NDArray[np.bool_]:
        """Whether nothing is special, (...)."""
        ...


@dataclass(frozen=True, eq=False)
class GivenStatus:
    """A status without the object it came from."""

    status: NDArray[np.str_]
    is_regular: NDArray[np.bool_]


def regular_there(made_from: HasStatus | None) -> NDArray[np.bool_]:
    """Whether the origin of each entry is regular, (...)."""
    return np.ones((), dtype=bool) if made_from is None else made_from.is_regular


def with_origin(status: NDArray[np.str_], made_from: HasStatus | None, shape: Shape) -> NDArray[np.str_]:
    """The status of a solution (...), with that of the origin at entries where the origin is not regular.

    An entry that is regular as a solution has the origin's status alone; one that is stable at large displacement has
    both.
    """
    if made_from is None:
        return status
    of_origin = np.broadcast_to(made_from.status, shape)
    alone = np.where(status == REGULAR, of_origin, status)
    both = np.where(np.char.startswith(status, STABLE), np.char.add(np.char.add(status, "; "), of_origin), alone)
    return np.where(made_from.is_regular, status, both)
