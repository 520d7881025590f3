"""The last unknowns of an elimination, those that vary over most of the batch, as a program.

Loads and results, which are sums over right-hand-side parameters and unknowns with factors that mostly vary less than
these, are matrix products.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..program.direct import Arithmetic, double
from ..structure.parts import Grid, Parts, Row, Value, entry, is_zero, total
from .order import Order
from .stage import Stage, backward

# A coupling smaller than this share of the two diagonal entries is less than the rounding of what it came from, in
# extended precision. There are such: forces in a statically determinate linkage do not depend on its springs.
_NOTHING = 2.0**-60
# Least ratio of pivots to their scale from which on nothing needs to be watched.
_SOUND = 1e-6


@dataclass(frozen=True)
class TrailingSchurComplement:
    """What is left of a stage when all that many entries share is done, in double precision.

    Attributes
    ----------
    grid
        The batch.
    pivots
        The unknowns in order.
    matrix
        Parts of the entries by place: of each row the diagonal and what is above it, room for the fill included.
    scale
        Parts of the stiffness whose rounding the diagonal carries.
    pivot_ratio
        What no ratio of a pivot to its scale falls below; 0.0 where that is not known beforehand.
    loads
        Loads on the unknowns, over the right-hand-side parameters.
    rhs_parameters
        The right-hand-side parameters.
    negligible
        Number of couplings left out because they are less than rounding.
    """

    grid: Grid
    pivots: list[int]
    matrix: list[dict[int, Parts]]
    scale: list[Parts]
    pivot_ratio: float
    loads: list[Row]
    rhs_parameters: list[Value]
    negligible: int

    @classmethod
    def of(
        cls, stage: Stage, pivots: list[int], rhs_parameters: list[Value], grid: Grid, done: set[int]
    ) -> TrailingSchurComplement:
        """What `stage` leaves of `pivots` after steps that vary over the masks `done`."""
        matrix = _upper(stage, pivots)
        left = set(pivots)
        coupled = sum(len(left & stage.matrix.get(k, {}).keys() - {k}) for k in pivots) // 2
        negligible = coupled - sum(len(row) - 1 for row in matrix)
        _fill(matrix)
        forces = [stage.forces.get(k, {}) for k in pivots]
        loads = [{-1 - s: double(total(parts)[1]) for s, parts in by_source.items()} for by_source in forces]
        scale = [{mask: double(v) for mask, v in stage.scale.get(k, {}).items()} for k in pivots]
        pivot_ratio = _pivot_ratio(stage, pivots, done)
        return cls(grid, pivots, matrix, scale, pivot_ratio, loads, [double(v) for v in rhs_parameters], negligible)

    def recorded(self, recording: Arithmetic) -> Recorded:
        """Elimination and substitution, all of it over the whole batch."""
        grid, size = self.grid, len(self.pivots)
        every = len(grid.sizes) - 1
        known = {-1 - s: recording.take(value) for s, value in enumerate(self.rhs_parameters)}
        loads = recording.products(self.loads, known)
        stage = Stage(forces={k: {0: {every: load}} for k, load in enumerate(loads) if not is_zero(load)})
        for k, row in enumerate(self.matrix):
            for j, parts in row.items():
                entry(stage.matrix, k, j).update(_whole(recording, every, parts))
            if not self.pivot_ratio:
                stage.scale[k] = _whole(recording, every, self.scale[k])
        below = {k: sorted(row.keys() - {k}) for k, row in enumerate(self.matrix)}
        order = Order(list(range(size)), below, dict.fromkeys(range(size), every))
        wanted = [True] * (every + 1)
        stage.eliminate(order, wanted)
        stage.forward(order, wanted)
        found: dict[int, Value] = {}
        backward(order, set(range(size)), found, stage, [1.0])
        least = None if self.pivot_ratio else total(stage.pivot_ratio)[1]
        return Recorded({k: found[place] for place, k in enumerate(self.pivots)} | known, least)


@dataclass(frozen=True)
class Recorded:
    """What a recording has made.

    Attributes
    ----------
    numbers
        The unknowns and the right-hand-side parameters.
    pivot_ratio
        Least ratio of a pivot to its scale, None where that is known beforehand.
    """

    numbers: dict[int, Value]
    pivot_ratio: Value | None


def _whole(recording: Arithmetic, every: int, parts: Parts) -> Parts:
    """A sum of parts as one number, which will vary over the whole batch."""
    return {every: total({mask: recording.take(value) for mask, value in parts.items()})[1]} if parts else {}


def _upper(stage: Stage, pivots: list[int]) -> list[dict[int, Parts]]:
    """Rows of the matrix from the diagonal on, without the couplings that are nothing."""
    place = {k: a for a, k in enumerate(pivots)}
    least = {k: sum(float(np.min(v)) for v in stage.matrix.get(k, {}).get(k, {}).values()) for k in pivots}
    out: list[dict[int, Parts]] = []
    for k in pivots:
        row: dict[int, Parts] = {place[k]: {}}
        for j, parts in stage.matrix.get(k, {}).items():
            if place[j] < place[k] or (j != k and _negligible(parts, least[k], least[j])):
                continue
            row[place[j]] = {mask: double(value) for mask, value in parts.items()}
        out.append(row)
    return out


def _negligible(parts: Parts, first: float, second: float) -> bool:
    most = sum(float(np.max(np.abs(value))) for value in parts.values())
    return min(first, second) > 0.0 and most <= _NOTHING * np.sqrt(first) * np.sqrt(second)


def _pivot_ratio(stage: Stage, pivots: list[int], done: set[int]) -> float:
    """Least ratio of a pivot d to its scale s, from below; 0.0 where it may be less than `_SOUND`.

    On the diagonal stand springs D, coupled with nothing, and the rest A, which is positive semidefinite as a whole. So
    ``d_i >= D_i``, the pivots before take ``sum l_ik^2 d_k <= A_ii`` from it, and with ``s_i = w_i + sum l_ik^2 s_k``
    every ``s_i / d_i <= (w_i + A_ii max_k<i s_k / d_k) / D_i``.
    """
    worst = 1.0
    for k in pivots:
        row = stage.matrix.get(k, {})
        diagonal, others = row.get(k, {}), {mask for j, parts in row.items() if j != k for mask in parts} | done
        # A part of the diagonal that varies as no coupling, no step and no other part does.
        alone = {m for m in diagonal if not any(m & other == m for other in others | diagonal.keys() - {m})}
        springs = sum(float(np.min(diagonal[mask])) for mask in alone)
        rest = sum(float(np.max(np.abs(value))) for mask, value in diagonal.items() if mask not in alone)
        weight = sum(float(np.max(value)) for value in stage.scale.get(k, {}).values())
        if not (springs > 0.0 and (weight + rest * worst) * _SOUND < springs):
            return 0.0
        worst = max(worst, (weight + rest * worst) / springs)
    return 1.0 / worst


def _fill(matrix: list[dict[int, Parts]]) -> None:
    """Make room for what the elimination adds."""
    for k, row in enumerate(matrix):
        after = sorted(row.keys() - {k})
        for a, i in enumerate(after):
            for j in after[a:]:
                matrix[i].setdefault(j, {})
