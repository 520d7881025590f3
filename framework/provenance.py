"""What is said of the entries of a frame that was made from something else, such as the poses of a motion."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from .batch import Shape

REGULAR, STABLE = "regular", "stable"


class HasStatus(Protocol):
    """What can say of each batch entry whether it is regular."""

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
    """A status by itself, without what it was told by."""

    status: NDArray[np.str_]
    is_regular: NDArray[np.bool_]


def regular_there(made_from: HasStatus | None) -> NDArray[np.bool_]:
    """Whether nothing is special about what entries were made from, (...)."""
    return np.ones((), dtype=bool) if made_from is None else made_from.is_regular


def with_origin(status: NDArray[np.str_], made_from: HasStatus | None, shape: Shape) -> NDArray[np.str_]:
    """The status of a solution (...), with what is said of the entries that are not regular to begin with.

    An entry that is regular as a solution says that alone; one that is stable at large displacement says both.
    """
    if made_from is None:
        return status
    of_origin = np.broadcast_to(made_from.status, shape)
    alone = np.where(status == REGULAR, of_origin, status)
    both = np.where(np.char.startswith(status, STABLE), np.char.add(np.char.add(status, "; "), of_origin), alone)
    return np.where(made_from.is_regular, status, both)
