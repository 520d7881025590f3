"""What the ways to solve a batch of matrices will take, as seen on one machine: only the ratio matters."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .band_factors import in_lanes, side_by_side
from .coupling import Coupling, EvaluatedBlock
from .graph import Graph

# Seconds of the broadcasting elimination: at all, for a member, for an operation; for an entry of the batch for a
# member whose geometry varies or does not, and for an operation.
_START, _MEMBER, _STEP = 2e-3, 0.28e-3, 0.2e-6
_MOVED, _FIXED, _OPERATION = 1.2e-6, 0.4e-6, 0.6e-9
# Seconds for a member of few unknowns that do not vary, of a chain; of what has loops it takes up to twice as long.
_CONSTANT = 0.15e-3
# Times longer what is done in extended precision takes: members and operations. That is all in batches of no more than
# so many entries with so many members in all.
_EXTENDED, _SHORT, _FINE = (15.0, 2.5), 2**10, 2**12
# Seconds of banded factors: at all, for a member; for an entry and a column of the band, and for each of its numbers;
# for an entry and a member whose geometry varies or does not.
_SET_UP, _NUMBERED = 2e-3, 0.035e-3
_COLUMN, _NUMBER = 0.05e-6, 7e-9
# The same where machine code takes entries side by side.
_LANE_COLUMN, _LANE_NUMBER = 0.01e-6, 3e-9
_TURNED, _SUMMED = 6e-6, 0.6e-6
# Seconds of one matrix: at all, for a member, and for an unknown in each load case.
_ONE, _ASSEMBLED, _CASE = 3e-3, 0.025e-3, 0.1e-6


def extended(entries: int, pieces: int) -> bool:
    """Whether a batch is broadcast in extended precision."""
    return entries <= _SHORT and entries * pieces <= _FINE


def one(pieces: int, unknowns: int, cases: int, factor: float) -> float:
    """Seconds of one matrix, of which the factor takes so many."""
    return _ONE + _ASSEMBLED * pieces + _CASE * unknowns * cases + factor


def recorded(pieces: int, entries: int = 1) -> float:
    """Seconds of few unknowns, whose stiffness varies over so many entries."""
    each = _FIXED * _EXTENDED[0] if extended(entries, pieces) else _FIXED
    return _START + pieces * (_MEMBER + each * entries)


def few(pieces: int) -> float:
    """Seconds of few unknowns, broadcast, whose stiffness does not vary."""
    return _START + _CONSTANT * pieces


def broadcast(coupling: Coupling, graph: Graph, condensed: Sequence[int], most: float = np.inf) -> float:
    """Seconds of the broadcasting elimination; where it is above `most`, no more than that may be told.

    Parameters
    ----------
    coupling
        The equations.
    graph
        Nodes and their coupling.
    condensed
        Members in line that are condensed before, numbers of the pieces: they cost next to nothing.
    most
        What need not be told apart.
    """
    pieces = max(1, sum(map(_count, _members(coupling))))
    fine = extended(coupling.grid.sizes[-1], pieces)
    per_member, per_operation = _EXTENDED if fine else (1.0, 1.0)
    sizes, seconds = np.array(coupling.grid.sizes), _START
    for block in _members(coupling):
        assert block.group is not None
        count = len(set(block.group.pieces.tolist()).difference(condensed))
        seconds += count * (_MEMBER + per_member * sizes[block.mask] * (_MOVED if block.rows is None else _FIXED))
    if seconds > most:  # to count operations takes longer than all the rest
        return seconds
    operations = _operations(coupling, graph) * (1.0 - len(condensed) / pieces)
    seconds += _STEP * operations
    # A pivot is computed once for all entries over which what it is coupled by does not vary.
    entries = sizes[coupling.masks[coupling.loaded]]
    return float(seconds + per_operation * _OPERATION * operations * (entries.mean() if len(entries) else 0.0))


def banded(coupling: Coupling, graph: Graph) -> float:
    """Seconds of banded factors, one for each entry.

    Parameters
    ----------
    coupling
        The equations.
    graph
        Nodes and their coupling.
    """
    entries, sizes = coupling.grid.sizes[coupling.mask], coupling.pattern.loaded_sizes
    # Of a frame whose planes are not coupled the band is as much narrower.
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
    """Multiplications of an elimination of what the loads reach, each component for itself."""
    sizes = coupling.pattern.loaded_sizes
    whole = 6.0 * max(1, len(np.unique(graph.node)))
    return graph.dissection.operations * float(((sizes / whole) ** 3).sum())
