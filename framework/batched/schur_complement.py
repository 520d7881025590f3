"""The trailing unknowns of an elimination, those that vary over most of the batch, and their solution as a program.

Loads and results are sums over right-hand-side parameters and unknowns, with factors that mostly vary over fewer axes,
so that they are computed as matrix products.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..ldl import backward_parts
from ..program.direct import Arithmetic, double
from ..structure.parts import Grid, Parts, Row, Value, entry, is_zero, total
from .order import in_turn, pattern_of
from .stage import Stage

# A coupling below this share of the geometric mean of its two diagonal entries is less than the rounding, in extended
# precision, of the terms that it came from. Such couplings occur: the forces in a statically determinate linkage do not
# depend on its springs.
_NOTHING = 2.0**-60
# Where pivot ratios are proved to stay above this, they need not be computed.
_SOUND = 1e-6


@dataclass(frozen=True)
class TrailingSchurComplement:
    """The Schur complement that remains when all shared steps are done, in double precision.

    Attributes
    ----------
    grid
        Shape of the batch, and its size for each mask.
    pivots
        The remaining unknowns in order of elimination.
    matrix
        For each row the parts of the diagonal entry and of the entries after it, by place in `pivots`.
    scale
        Parts of the scale of each diagonal entry.
    pivot_ratio
        Lower bound on all pivot ratios; 0.0 where none above `_SOUND` can be proved beforehand.
    loads
        Load on each unknown as a row over the right-hand-side parameters.
    rhs_parameters
        Values of the right-hand-side parameters.
    negligible
        Number of couplings that are neglected because they are below rounding.
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
        """The part of `stage` in the unknowns `pivots`, after steps with the masks `done`."""
        matrix = _upper(stage, pivots)
        left = set(pivots)
        coupled = sum(len(left & stage.matrix.get(k, {}).keys() - {k}) for k in pivots) // 2
        negligible = coupled - sum(len(row) - 1 for row in matrix)
        forces = [stage.forces.get(k, {}) for k in pivots]
        loads = [{-1 - s: double(total(parts)[1]) for s, parts in by_source.items()} for by_source in forces]
        scale = [{mask: double(v) for mask, v in stage.scale.get(k, {}).items()} for k in pivots]
        pivot_ratio = _pivot_ratio(stage, pivots, done)
        return cls(grid, pivots, matrix, scale, pivot_ratio, loads, [double(v) for v in rhs_parameters], negligible)

    def under(self, rhs_parameters: Sequence[Value]) -> TrailingSchurComplement:
        """The same under other right-hand-side parameters."""
        return replace(self, rhs_parameters=[double(v) for v in rhs_parameters])

    def recorded(self, recording: Arithmetic) -> Recorded:
        """Record elimination and substitution, of numbers that vary over the whole batch."""
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
        order = in_turn(pattern_of(stage.matrix, ()), range(size))
        wanted = [True] * (every + 1)
        stage.eliminate(order, wanted)
        stage.forward(order, wanted)
        found: dict[int, Value] = {}
        backward_parts(order.pivots, stage.pivots, stage.forces, [1.0], found)
        least = None if self.pivot_ratio else total(stage.pivot_ratio)[1]
        return Recorded({k: found[place] for place, k in enumerate(self.pivots)} | known, least)


@dataclass(frozen=True)
class Recorded:
    """Recorded results of the elimination.

    Attributes
    ----------
    numbers
        Values of the unknowns, and of right-hand-side parameter s under -1 - s.
    pivot_ratio
        Least pivot ratio; None where a bound is known beforehand.
    """

    numbers: dict[int, Value]
    pivot_ratio: Value | None


def _whole(recording: Arithmetic, every: int, parts: Parts) -> Parts:
    """A sum of parts as a single part that varies over the whole batch."""
    return {every: total({mask: recording.take(value) for mask, value in parts.items()})[1]} if parts else {}


def _upper(stage: Stage, pivots: list[int]) -> list[dict[int, Parts]]:
    """Rows of the matrix from the diagonal on, without negligible couplings."""
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
    """Lower bound on the ratio of a pivot d to its scale s; 0.0 where it may be less than `_SOUND`.

    The matrix is the sum of a diagonal matrix of springs D and a positive semidefinite matrix A. So ``d_i >= D_i``, the
    earlier pivots reduce the diagonal by ``sum l_ik^2 d_k <= A_ii``, and with ``s_i = w_i + sum l_ik^2 s_k`` it follows
    that ``s_i / d_i <= (w_i + A_ii max_k<i s_k / d_k) / D_i``.
    """
    worst = 1.0
    for k in pivots:
        row = stage.matrix.get(k, {})
        diagonal, others = row.get(k, {}), {mask for j, parts in row.items() if j != k for mask in parts} | done
        # springs: parts of the diagonal with a mask that no coupling, no step and no other part covers
        alone = {m for m in diagonal if not any(m & other == m for other in others | diagonal.keys() - {m})}
        springs = sum(float(np.min(diagonal[mask])) for mask in alone)
        rest = sum(float(np.max(np.abs(value))) for mask, value in diagonal.items() if mask not in alone)
        weight = sum(float(np.max(value)) for value in stage.scale.get(k, {}).values())
        if not (springs > 0.0 and (weight + rest * worst) * _SOUND < springs):
            return 0.0
        worst = max(worst, (weight + rest * worst) / springs)
    return 1.0 / worst
