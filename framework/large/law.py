"""How the force in a joint depends on its displacement, beyond six springs: the place for contact."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol, runtime_checkable

import numpy as np

from ..batch import Array
from ..errors import FrameError
from ..protocol import JointElement

Pick = Callable[[Array, int], Array]


@runtime_checkable
class Law(Protocol):
    """What a joint element offers where springs do not describe it.

    It replaces the springs of the components that are not ideal. Forces must be the gradient of the energy, and the
    tangent its second derivative (where the force has a kink, that of either side).
    """

    def resistance(self, displacement: Array, pick: Pick) -> tuple[Array, Array, Array]:
        """Energy (m,), force (m, 6) and tangent (m, 6, 6) at a displacement (m, 6), in the joint's axes.

        The displacement counts from the joint's imposed offset. ``pick(array, trailing)`` takes from a parameter
        (..., components) of the batch the rows of the entries asked for, (m, components) or (1, components).
        """
        ...


def law_of(element: JointElement) -> Law | None:
    """The law of a joint element with clearance; None where it has springs only.

    Raises
    ------
    FrameError
        Where the joint is ideal in the components in which it has play: a rigid contact has no energy.
    """
    if not (isinstance(element, Law) and element.clearance.any()):
        return None
    if np.isinf(element.stiffness[..., list(element.play)]).any():
        raise FrameError(
            "a joint with clearance is ideal (inf) where it has play: large displacement needs a finite contact "
            "stiffness, such as 2e11; or leave clearances out with clearance=False"
        )
    return element
