"""Shapes of natural modes and of buckling: their displacements at nodes, and the check of how many can be asked for."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass, field

import numpy as np

from ..batch import Array
from ..batched.plan import Plan
from ..errors import FrameError
from ..names import found
from . import dense


@dataclass(frozen=True, eq=False)
class Shapes:
    """Shapes, the displacements that belong to eigenvalues, with one shape for each."""

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
            ``ux uy uz rx ry rz`` in each shape, (..., count, 6).

        Raises
        ------
        FrameError
            If the node is unknown.
        """
        frame, number = self._plan.frame, self._plan.topology.number
        name = found("node", node, frame.nodes, frame.aliases)
        moved = np.swapaxes(dense.global_substitution(self._plan, [number[name]]) @ self._vectors, -1, -2)
        return np.broadcast_to(moved, np.broadcast_shapes(moved.shape, (*frame.shape, 1, 1)))


def check_count(what: str, count: int, size: int) -> None:
    """Refuse a number of shapes that a frame with `size` unknowns cannot have."""
    if not size:
        raise FrameError(
            f"{what}({count!r}): the frame has no unknowns, nothing in it can move: release a component, give beams to "
            "rigid links, or more segments to beams"
        )
    if isinstance(count, bool) or not isinstance(count, int | np.integer) or not 1 <= count <= size:
        raise FrameError(f"{what}({count!r}): give a whole number from 1 to the frame's {size} unknowns")


def check_count_of(what: str, count: int, plan: Plan) -> None:
    """Refuse a number of shapes that the frame of a plan cannot have, at any batch entry."""
    size, idle = len(plan.unknowns), plan.tree.elimination.idle
    check_count(what, count, size)
    if not idle:
        return
    own = size - np.broadcast_to(sum(np.asarray(where) for where in idle.values()), plan.frame.shape).astype(np.int64)
    own = own if plan.frame.absent is None else np.where(plan.frame.absent, size, own)
    if np.any(own < count):
        least = int(own.min())
        entry = np.argwhere(own == least)[0].tolist()
        raise FrameError(
            f"{what}({count}): batch entry {entry}, where loops of ideal joints hold more than at others, has {least} "
            f"unknowns: give a whole number from 1 to {least}"
        )
