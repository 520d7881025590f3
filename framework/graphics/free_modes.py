"""Motions that nothing resists, as figures show them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np

from ..batch import Array


class FreeShapes(Protocol):
    """Motions of one batch entry that nothing resists."""

    @property
    def count(self) -> int:
        """How many there are."""

    def displacement(self, node: str) -> Array:
        """Of a node, (count, 6)."""


def free_modes(solution: object, entry: Sequence[int]) -> Array:
    """Displacements of all nodes in the motions that nothing resists at a batch entry, (count, nodes, 3).

    The greatest displacement of each is one. None are known of a solution at large displacement.

    Parameters
    ----------
    solution
        The solution.
    entry
        Indices of the batch entry.
    """
    found: FreeShapes | None = solution.free_motion(*entry) if hasattr(solution, "free_motion") else None
    nodes = list(solution.frame.nodes) if hasattr(solution, "frame") else []
    if found is None or not found.count:
        return np.zeros((0, len(nodes), 3))
    moved = np.stack([found.displacement(node)[:, :3] for node in nodes], axis=1)
    most = np.linalg.norm(moved, axis=-1).max(axis=-1)[:, None, None]
    # Of a motion that only rotates about an axis through its nodes there is nothing to draw.
    return np.asarray(moved / np.where(most > 0.0, most, 1.0))


def told_modes(modes: Array) -> str:
    """Text that explains the arrows of free motions; empty if there are none."""
    if not len(modes):
        return ""
    return "free motion" if len(modes) == 1 else f"first of {len(modes)} free motions"
