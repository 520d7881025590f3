"""Linear buckling: load factors at which the stiffness under the forces of the load becomes singular.

The forces in members, joints and rigid links are those of the linear solution, acting on the undeformed shape:
displacements before buckling are neglected. Bending and torsional moments are included beside axial forces, so that
lateral-torsional buckling is found as well (see `linkframe.framework.results.geometric`).
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..batch import Array
from ..batched.idle import released
from ..batched.plan import Plan
from ..described.released_ends import with_hinges
from ..description import Description
from ..errors import FrameError, MechanismWarning
from ..solution import Solution
from ..solvers.sparse import SparseSolver
from ..states import SolutionState, among
from .shapes import Shapes, check_count_of
from .sparse_spectrum import SparsePencil
from .spectrum import DENSE, inverse_pencil, stiffness_halves
from .under_load import at_entry, geometric_stacks, geometric_stiffness

# Eigenvalues below this many roundings, times the number of unknowns, come from axial forces that are zero but for
# rounding.
_ROUNDINGS = 16.0


@dataclass(frozen=True, eq=False)
class Buckling(Shapes):
    """Load factors and buckling shapes, the smallest positive factor first.

    The size of `shapes` is arbitrary; where a factor is inf, the shape has no meaning either.

    Attributes
    ----------
    factors
        Factors by which all loads are multiplied when the frame buckles, (..., count); inf where there are fewer.

    Examples
    --------
    A column of 1 m, clamped at its foot, and the same one pulled: Euler's load ``pi^2 E I / (4 L^2)`` (Timoshenko &
    Gere, *Theory of Elastic Stability*, ch. 2).

    >>> from linkframe.elements import Beam, Circle, Material
    >>> from linkframe.framework import Frame
    >>> frame = Frame()
    >>> for name, z in {"A": 0.0, "B": 1.0}.items():
    ...     frame.node(name, (0.0, 0.0, z))
    >>> frame.add("AB", Beam(Circle(diameter=0.02), Material(E=200e9, nu=0.3), segments=8), "A", "B")
    >>> frame.fix("A"); frame.load("B", fz=[-1000.0, 1000.0])
    >>> frame.buckling(1).factors.round(3).tolist()
    [[3.876], [inf]]
    """

    factors: Array


def buckling(frame: Description, count: int) -> Buckling:
    """The `count` smallest positive factors of ``(K + factor Kg) x = 0`` for every batch entry.

    Raises
    ------
    FrameError
        Where the frame is a mechanism, or `count` is not from 1 to the number of its unknowns.
    """
    own = released(frame).copy()
    described = with_hinges(own)
    solution = Solution(described, Plan(described, cut=True))
    plan = solution.plan
    size = len(plan.unknowns)
    check_count_of("buckling", count, plan)
    left = _left_out(solution, own)
    if 0 in frame.shape:
        return Buckling(np.zeros((*frame.shape, count)), _plan=plan, _vectors=np.zeros((*frame.shape, size, count)))
    large = plan.large and size > DENSE
    values, vectors = _sparse(solution, count) if large else _dense(solution, left)
    # Axial forces that should be zero are rounding, and so would be their factors.
    least = _ROUNDINGS * np.finfo(float).eps * size * np.abs(values[..., :1])
    order = np.argsort(-values, axis=-1, kind="stable")[..., :count]
    values = np.take_along_axis(values, order, axis=-1)
    vectors = np.take_along_axis(vectors, order[..., None, :], axis=-1)
    factors = np.divide(1.0, values, out=np.full(values.shape, np.inf), where=values > least)
    factors = np.array(np.broadcast_to(factors, (*frame.shape, count)))
    factors[left] = np.nan
    return Buckling(factors, _plan=plan, _vectors=vectors)


def _left_out(solution: Solution, frame: Description) -> NDArray[np.bool_]:
    """Entries without buckling factors, (...): those left out and mechanisms; an error if no other entries remain.

    The message names no other nodes than those of `frame`.
    """
    left = among(solution.own_state, SolutionState.ABSENT)
    moving = ~among(solution.own_state, SolutionState.REGULAR, SolutionState.ABSENT)
    text = ""
    if moving.any():
        text = Solution(frame, Plan(frame, cut=True)).mechanism(*np.argwhere(moving)[0].tolist())
    return left | _told(moving, ~left, f"a mechanism even without the load: {text}")


def _told(wrong: NDArray[np.bool_], present: NDArray[np.bool_], what: str) -> NDArray[np.bool_]:
    """Warn of the entries `wrong`, at which the frame is `what`; an error if they are all that are `present`."""
    if wrong.any():
        if (wrong | ~present).all():
            raise FrameError(f"buckling: the frame is {what}")
        count, first = f"{wrong.sum()} of {wrong.size}", np.argwhere(wrong)[0].tolist()
        text = f"buckling: {count} batch entries have no factors: at the first, {first}, the frame is {what}"
        warnings.warn(text, MechanismWarning, stacklevel=5)
    return wrong


def _dense(solution: Solution, left: NDArray[np.bool_]) -> tuple[Array, Array]:
    """All eigenvalues of ``-Kg x = value K x``, the inverses of the factors, (..., n), and vectors (..., n, n).

    Those of entries that are `left` out are arbitrary. Entries that the preload of springs makes unstable are added to
    `left` in place.
    """
    plan = solution.plan
    with np.errstate(invalid="ignore"):  # of mechanisms
        taken = -geometric_stiffness(plan, solution.bounds.whole())
    half, root = stiffness_halves(plan)
    pushed = np.broadcast_to(np.isnan(half).any(axis=(-2, -1)), left.shape) & ~left
    left |= _told(pushed, ~left, "unstable even without the load, by the preload of its springs")
    if left.any():
        out = left[..., None, None]
        half, taken = np.where(out, np.eye(len(plan.unknowns)), half), np.where(out, 0.0, taken)
    return inverse_pencil(half, root, taken, len(plan.unknowns))


def _sparse(solution: Solution, count: int) -> tuple[Array, Array]:
    """The greatest eigenvalues as in `_dense`, for each load case of one large frame, (..., count), and the vectors
    (..., n, count).
    """
    assert isinstance(solution.solver, SparseSolver)
    solver, shape = solution.solver, solution.shape
    pencil = SparsePencil(solver)
    found = geometric_stacks(solution.bounds.whole())
    values, vectors = np.zeros((*shape, count)), np.zeros((*shape, len(solution.plan.unknowns), count))
    for entry in np.ndindex(*shape):
        stacks = [(nodes, at_entry(entry, matrices).__getitem__) for nodes, matrices in found]
        values[entry], vectors[entry] = pencil.greatest(-solver.matrices.reduced(stacks), count)
    return values, vectors
