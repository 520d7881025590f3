"""Estimated run times of the methods for a batch, with constants measured on one machine: only their ratios matter."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .band_factors import in_lanes, side_by_side
from .coupling import Coupling, EvaluatedBlock
from .graph import Graph

# Seconds of the broadcasting elimination: in all, for a member, for an operation; and for each batch entry: for a
# member whose geometry varies, for one whose geometry does not, for an operation.
_START, _MEMBER, _STEP = 2e-3, 0.28e-3, 0.2e-6
_MOVED, _FIXED, _OPERATION = 1.2e-6, 0.4e-6, 0.6e-9
# Seconds for a member of a small frame of constant stiffness, a chain; with loops it takes up to twice as long.
_CONSTANT = 0.15e-3
# Slowdown of extended precision, for members and for operations. It is used in batches of up to _SHORT entries and up
# to _FINE entries times members.
_EXTENDED, _SHORT, _FINE = (15.0, 2.5), 2**10, 2**12
# Seconds of banded factors: in all, for a member; for each batch entry and column of the band, and number in it; and
# below for each batch entry and member whose geometry varies, or does not.
_SET_UP, _NUMBERED = 2e-3, 0.035e-3
_COLUMN, _NUMBER = 0.05e-6, 7e-9
# Seconds for each batch entry and column, and number in it, where machine code factorises several entries at a time.
_LANE_COLUMN, _LANE_NUMBER = 0.01e-6, 3e-9
_TURNED, _SUMMED = 6e-6, 0.58e-6
# Seconds of a single matrix: in all, for a member, and for an unknown in each load case.
_ONE, _ASSEMBLED, _CASE = 3e-3, 0.025e-3, 0.1e-6


def extended(entries: int, pieces: int) -> bool:
    """Whether the broadcasting elimination of a batch uses extended precision."""
    return entries <= _SHORT and entries * pieces <= _FINE


def one(pieces: int, unknowns: int, cases: int, factor: float) -> float:
    """Estimated seconds of a single matrix, given those of its factor."""
    return _ONE + _ASSEMBLED * pieces + _CASE * unknowns * cases + factor


def recorded(pieces: int, entries: int = 1) -> float:
    """Estimated seconds of the broadcasting elimination of a small frame whose stiffness varies over the entries."""
    each = _FIXED * _EXTENDED[0] if extended(entries, pieces) else _FIXED
    return _START + pieces * (_MEMBER + each * entries)


def few(pieces: int) -> float:
    """Estimated seconds of the broadcasting elimination of a small frame of constant stiffness."""
    return _START + _CONSTANT * pieces


def broadcast(coupling: Coupling, graph: Graph, condensed: Sequence[int], most: float = np.inf) -> float:
    """Estimated seconds of the broadcasting elimination; a lower bound on them where that is above `most`.

    Parameters
    ----------
    coupling
        The equations.
    graph
        Nodes and their coupling.
    condensed
        Numbers of the pieces of members that are condensed first: they cost next to nothing.
    most
        Seconds above which the estimate need not be complete.
    """
    pieces = max(1, sum(map(_count, _members(coupling))))
    fine = extended(coupling.grid.sizes[-1], pieces)
    per_member, per_operation = _EXTENDED if fine else (1.0, 1.0)
    sizes, seconds = np.array(coupling.grid.sizes), _START
    for block in _members(coupling):
        assert block.group is not None
        count = len(set(block.group.pieces.tolist()).difference(condensed))
        seconds += count * (_MEMBER + per_member * sizes[block.mask] * (_MOVED if block.rows is None else _FIXED))
    if seconds > most:  # counting operations takes longer than all the rest of the estimate
        return seconds
    operations = _operations(coupling, graph) * (1.0 - len(condensed) / pieces)
    seconds += _STEP * operations
    # A pivot is computed once for all entries over which its coupling does not vary.
    entries = sizes[coupling.masks[coupling.loaded]]
    return float(seconds + per_operation * _OPERATION * operations * (entries.mean() if len(entries) else 0.0))


def banded(coupling: Coupling, graph: Graph) -> float:
    """Estimated seconds of banded factors, one for each entry.

    Parameters
    ----------
    coupling
        The equations.
    graph
        Nodes and their coupling.
    """
    entries, sizes = coupling.grid.sizes[coupling.mask], coupling.pattern.loaded_sizes
    # Where bending planes are not coupled, the band is narrower by as much.
    size, width = int(sizes.sum()), graph.width * int(sizes.max(initial=0)) / max(1, coupling.size)
    beside = side_by_side(entries, size, int(width))
    column, number = (_LANE_COLUMN, _LANE_NUMBER) if beside else (_COLUMN, _NUMBER)
    seconds = _SET_UP + (in_lanes(entries) if beside else entries) * size * (column + number * width)
    for block in _members(coupling):
        seconds += _count(block) * (_NUMBERED + entries * (_TURNED if block.rows is None else _SUMMED))
    return float(seconds)


def _members(coupling: Coupling) -> list[EvaluatedBlock]:
    return [block for block in coupling.blocks if block.group is not None]


def _count(block: EvaluatedBlock) -> int:
    return 0 if block.group is None else len(block.group.pieces)


def _operations(coupling: Coupling, graph: Graph) -> float:
    """Number of multiplications of an elimination of the loaded components."""
    sizes = coupling.pattern.loaded_sizes
    whole = 6.0 * max(1, len(np.unique(graph.node)))
    return graph.dissection.operations * float(((sizes / whole) ** 3).sum())
