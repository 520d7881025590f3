"""Estimated run times of the methods for a batch, with constants measured on one machine: only their ratios matter."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..program.machine_code import available
from .band_factors import in_lanes, in_one_pass, side_by_side
from .coupling import Coupling, EvaluatedBlock
from .graph import Graph

# Seconds of the broadcasting elimination: in all, for a member, for an operation; for a member and entry, up to _SHORT
# of them, as arrays are made and added; and for each batch entry, by NumPy and by machine code, which runs from more
# than _LONG entries on: for a member whose geometry varies, for one whose geometry does not, and for an operation.
_START, _MEMBER, _STEP, _ARRAYS = 1.5e-3, 0.2e-3, 0.1e-6, 0.45e-6
_NUMPY, _COMPILED = (0.2e-6, 0.13e-6, 0.6e-9), (0.18e-6, 0.06e-6, 0.08e-9)
_LONG = 3 * 2**14
# Seconds of a small frame of constant stiffness that is the first of its topology: in all, and for a member of a chain;
# with loops it takes up to twice as long.
_FIRST, _CONSTANT = 2.5e-3, 0.22e-3
# Slowdown of extended precision, for members and for operations. It is used in batches of up to _SHORT entries with up
# to _FINE entries times members, or members whose stiffness does not vary.
_EXTENDED, _SHORT, _FINE = (15.0, 6.0), 2**10, 2**12
# Seconds of banded factors: in all, on members alone whose places were solved before, and else; for a member, and a
# spring of a joint; for each batch entry and member whose geometry varies, or does not, and each term of the stiffness.
_KNOWN, _SET_UP, _NUMBERED, _JOINED = 0.45e-3, 2e-3, 0.0035e-3, 0.025e-3
_TURNED, _SUMMED, _TERM = 6e-6, 0.15e-6, 1e-9
# Seconds for each batch entry and column of the band, number in it, and product of two of these: by LAPACK, by machine
# code for several entries at a time, and where that does all in one pass; there also for each member.
_ALONE, _ABREAST, _IN_ONE_PASS = (0.03e-6, 7e-9, 0.0), (0.005e-6, 1.5e-9, 0.05e-9), (0.011e-6, 1.6e-9, 0.05e-9)
_SPRINGS = 0.017e-6
# Seconds of a single matrix: in all, for a member, for an unknown in each load case, and for a batch entry.
_ONE, _ASSEMBLED, _CASE, _ENTRY = 0.32e-3, 0.002e-3, 0.2e-6, 0.015e-6


def extended(entries: int, numbers: int) -> bool:
    """Whether the broadcasting elimination of a batch uses extended precision, by the `numbers` that its members have.

    Those of a member whose stiffness does not vary over the entries count once.
    """
    return entries <= _SHORT and numbers <= _FINE


def one(pieces: int, unknowns: int, cases: int, factor: float, entries: int = 1) -> float:
    """Estimated seconds of a single matrix, given those of its factor."""
    return _ONE + _ASSEMBLED * pieces + _CASE * unknowns * cases + _ENTRY * entries + factor


def recorded(pieces: int, entries: int = 1, *, moved: bool = False) -> float:
    """Estimated seconds of the broadcasting elimination of a small frame whose stiffness varies over the entries.

    `moved` tells that places of nodes vary, too.
    """
    varies, fixed, _ = _each(entries)
    each = (varies if moved else fixed) * (_EXTENDED[0] if extended(entries, pieces * entries) else 1.0)
    return _START + pieces * (_MEMBER + _ARRAYS * min(entries, _SHORT) + each * entries)


def _each(entries: int) -> tuple[float, float, float]:
    """Seconds for each batch entry, for a member whose geometry varies, for another, and for an operation."""
    return _COMPILED if entries > _LONG and available() else _NUMPY


def few(pieces: int) -> float:
    """Estimated seconds of the broadcasting elimination of a small frame of constant stiffness."""
    return _FIRST + _CONSTANT * pieces


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
    sizes, seconds, members = np.array(coupling.grid.sizes), _START, _members(coupling)
    pieces = max(1, sum(map(_count, members)))
    fine = extended(int(sizes[-1]), sum(_count(block) * int(sizes[block.mask]) for block in members))
    per_member, per_operation = _EXTENDED if fine else (1.0, 1.0)
    moved, fixed, one_operation = _each(coupling.grid.sizes[-1])
    for block in members:
        assert block.group is not None
        count = len(set(block.group.pieces.tolist()).difference(condensed))
        entries = int(sizes[block.mask])
        numbers = per_member * (moved if block.rows is None else fixed)
        seconds += count * (_MEMBER + _ARRAYS * min(entries, _SHORT) + numbers * entries)
    if seconds > most:  # counting operations takes longer than all the rest of the estimate
        return seconds
    operations = _operations(coupling, graph) * (1.0 - len(condensed) / pieces)
    seconds += _STEP * operations
    # A pivot is computed once for all entries over which its coupling does not vary.
    each = sizes[coupling.masks[coupling.loaded]]
    per_operation *= one_operation
    return float(seconds + per_operation * operations * (each.mean() if len(each) else 0.0))


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
    beside, members = side_by_side(entries, size, int(width)), _members(coupling)
    lanes = in_lanes(entries) if beside else entries
    moved = any(block.rows is None for block in members)
    springs = sum(block.count for block in coupling.blocks[:-1] if block.group is None)
    seconds = _SET_UP if moved or springs else _KNOWN
    seconds += _NUMBERED * sum(map(_count, members)) + _JOINED * springs
    together = beside and not moved and in_one_pass(entries)
    column, number, product = _IN_ONE_PASS if together else _ABREAST if beside else _ALONE
    seconds += lanes * size * (column + (number + product * width) * width)
    if together:
        return float(seconds + lanes * _SPRINGS * sum(map(_count, members)))
    seconds += entries * _TERM * coupling.pattern.stiff.sum()
    for block in members:
        seconds += _count(block) * entries * (_TURNED if block.rows is None else _SUMMED)
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
