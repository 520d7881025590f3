"""Linear buckling: load factors at which the stiffness under the axial forces of the load becomes singular."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..batch import Array
from ..batched.plan import Plan
from ..errors import FrameError
from ..frame import Frame
from ..solution import Solution
from ..structure.topology import Group
from . import dense
from .recovery import Recovery
from .shapes import Shapes, check_count
from .spectrum import inverse_pencil

# Roundings that make an axial force where there is none, and an eigenvalue for each unknown.
_ROUNDINGS = 16.0


@dataclass(frozen=True, eq=False)
class Buckling(Shapes):
    """Load factors and buckling shapes, the smallest positive factor first.

    The size of `shapes` means nothing, and where a factor is inf so does the shape.

    Attributes
    ----------
    factors
        By which all loads may grow before the frame buckles, (..., count); inf where there are no more.

    Examples
    --------
    A column of 1 m, clamped at its foot, and the same one pulled: Euler's load ``pi^2 E I / 4 L^2``.

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


def buckling(frame: Frame, count: int) -> Buckling:
    """The `count` smallest positive factors of ``(K + factor Kg) x = 0`` for every batch entry.

    Raises
    ------
    FrameError
        Where the frame is a mechanism, or `count` is not from 1 to the number of its unknowns.
    """
    described = frame.copy()
    solution = Solution(described, Plan(described, cut=True))
    plan = solution.plan
    size = len(plan.unknowns)
    check_count("buckling", count, size)
    moving = np.argwhere(~np.isin(solution.status, ("regular", "absent")))
    if len(moving):
        raise FrameError(f"buckling: the frame is a mechanism even without the load: {solution.mechanism(*moving[0])}")
    values, vectors = inverse_pencil(*_matrices(solution), size)
    # Axial forces that are zero come with rounding, and their factors would be rounding as well.
    least = _ROUNDINGS * np.finfo(float).eps * size * np.abs(values[..., :1])
    order = np.argsort(-values, axis=-1, kind="stable")[..., :count]
    values = np.take_along_axis(values, order, axis=-1)
    vectors = np.take_along_axis(vectors, order[..., None, :], axis=-1)
    factors = np.divide(1.0, values, out=np.full(values.shape, np.inf), where=values > least)
    factors = np.array(np.broadcast_to(factors, (*frame.shape, count)))
    if frame.absent is not None:
        factors[np.broadcast_to(frame.absent, frame.shape)] = np.nan
    return Buckling(factors, _plan=plan, _vectors=vectors)


def _matrices(solution: Solution) -> tuple[Array, Array]:
    """Stiffness, and what the load takes off it, both (..., n, n); of what is absent those of nothing in particular."""
    stiffness, geometric, absent = dense.stiffness(solution.plan), _geometric(solution), solution.frame.absent
    if absent is None:
        return stiffness, -geometric
    left = absent[..., None, None]
    return np.where(left, np.eye(stiffness.shape[-1]), stiffness), -np.where(left, 0.0, geometric)


def _geometric(solution: Solution) -> Array:
    plan, recovery = solution.plan, Recovery(solution)
    stacks = []
    for group in plan.topology.groups:
        axial = np.stack([_axial(recovery, group, position) for position in range(len(group.pieces))])
        stacks.append((group, group.turned(group.element.geometric_matrix(group.length, axial))))
    return dense.reduced(plan, dense.nodal(plan, stacks))


def _axial(recovery: Recovery, group: Group, position: int) -> Array:
    """Mean axial force of a piece, tension positive, (...); zero where it is rounding of what its ends move."""
    piece = int(group.pieces[position])
    forces, moved = recovery.piece_forces(piece), recovery.piece_displacement(piece)
    axial: Array = (forces[..., 6] - forces[..., 0]) / 2.0
    stiffness = group.element.stiffness_matrix(group.length[position])[..., 0, 0]
    rounding = _ROUNDINGS * np.finfo(float).eps * stiffness * np.abs(moved[..., [0, 1, 2, 6, 7, 8]]).max(axis=-1)
    return np.where(np.abs(axial) < rounding, 0.0, axial)
