"""Eigenvalues of a frame come with shapes: what their displacements are at a node, and how many there can be."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass, field

import numpy as np

from ..batch import Array
from ..batched.plan import Plan
from ..errors import FrameError
from ..names import found, plain
from . import dense


@dataclass(frozen=True, eq=False)
class Shapes:
    """Displacements that go with eigenvalues."""

    _: KW_ONLY
    _plan: Plan = field(repr=False)
    _vectors: Array = field(repr=False)

    def shapes(self, node: str) -> Array:
        """Displacement of a node in each shape, in global axes.

        Parameters
        ----------
        node
            Name of the node.

        Returns
        -------
        ndarray
            ``ux uy uz rx ry rz``, (..., count, 6).

        Raises
        ------
        FrameError
            If the node is unknown.
        """
        frame, number = self._plan.frame, self._plan.topology.number
        name = found("node", frame.aliases.get(plain("node", node), node), frame.nodes)
        return np.swapaxes(dense.global_substitution(self._plan, [number[name]]) @ self._vectors, -1, -2)


def check_count(what: str, count: int, size: int) -> None:
    """Refuse a number of shapes that a frame with `size` unknowns cannot have."""
    if isinstance(count, bool) or not isinstance(count, int | np.integer) or not 1 <= count <= size:
        raise FrameError(f"{what}({count!r}): give a whole number from 1 to the frame's {size} unknowns")
