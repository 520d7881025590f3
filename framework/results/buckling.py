"""Linear buckling: load factors at which the stiffness under the axial forces of the load becomes singular."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..batch import Array
from ..batched.plan import Plan
from ..errors import FrameError
from ..frame import Frame
from ..solution import Solution
from . import dense
from .spectrum import inverse_pencil


@dataclass(frozen=True)
class Buckling:
    """Load factors and buckling shapes, the smallest positive factor first.

    Attributes
    ----------
    factors
        By which all loads may grow before the frame buckles, (..., count); inf where there are no more.
    """

    factors: Array
    _plan: Plan
    _vectors: Array

    def shapes(self, node: str) -> Array:
        """Displacement of a node in each buckling shape, (..., count, 6), global."""
        number = self._plan.topology.number[self._plan.frame.aliases.get(node, node)]
        return np.swapaxes(dense.global_substitution(self._plan, [number]) @ self._vectors, -1, -2)


def buckling(frame: Frame, count: int) -> Buckling:
    """The `count` smallest positive factors of ``(K + factor Kg) x = 0`` for every batch entry.

    Raises
    ------
    FrameError
        Where the frame is a mechanism, or fewer factors exist than asked for.
    """
    described = frame.copy()
    solution = Solution(described, Plan(described, cut=True))
    plan = solution.plan
    size = len(plan.unknowns)
    if not 1 <= count <= size:
        raise FrameError(f"buckling({count}): give a number from 1 to the frame's {size} unknowns")
    if not np.all(solution.status == "regular"):
        moving = solution.mechanism(*_first(solution))
        raise FrameError(f"buckling: the frame is a mechanism even without the load: {moving}")
    stiffness, geometric = dense.stiffness(plan), _geometric(solution)
    values, vectors = inverse_pencil(stiffness, -geometric, size)
    order = np.argsort(-values, axis=-1, kind="stable")[..., :count]
    values = np.take_along_axis(values, order, axis=-1)
    vectors = np.take_along_axis(vectors, order[..., None, :], axis=-1)
    least = np.finfo(float).eps * size * np.abs(values[..., :1])
    with np.errstate(divide="ignore"):
        factors = np.where(values > least, 1.0 / np.where(values > least, values, 1.0), np.inf)
    return Buckling(np.array(np.broadcast_to(factors, (*frame.shape, count))), plan, vectors)


def _geometric(solution: Solution) -> Array:
    plan = solution.plan
    stacks = []
    for group in plan.topology.groups:
        axial = np.stack([_axial(solution, int(piece)) for piece in group.pieces])
        stacks.append((group, group.turned(group.element.geometric_matrix(group.length, axial))))
    return dense.reduced(plan, dense.nodal(plan, stacks))


def _axial(solution: Solution, piece: int) -> Array:
    """Mean axial force of a piece, tension positive."""
    forces = solution.piece_forces(piece)
    return (forces[..., 6] - forces[..., 0]) / 2.0


def _first(solution: Solution) -> tuple[int, ...]:
    return tuple(int(k) for k in np.argwhere(solution.status != "regular")[0]) if solution.shape else ()
