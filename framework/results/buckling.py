"""Linear buckling: load factors at which the stiffness under the axial forces of the load becomes singular."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..batch import Array
from ..batched.plan import Plan
from ..errors import FrameError
from ..frame import Frame
from ..solution import Solution
from ..solvers.sparse import SparseSolver
from ..structure.assembly import member_loads
from ..structure.topology import Group
from . import dense
from .shapes import Shapes, check_count
from .sparse_spectrum import SparsePencil
from .spectrum import DENSE, inverse_pencil, stiffness_halves

# Roundings that make an axial force where there is none, and an eigenvalue for each unknown.
_ROUNDINGS = 16.0
_TRANSLATIONS = [0, 1, 2, 6, 7, 8]


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
    moving = np.argwhere(~np.isin(solution.own_status, ("regular", "absent")))
    if len(moving):
        raise FrameError(f"buckling: the frame is a mechanism even without the load: {solution.mechanism(*moving[0])}")
    large = plan.large and size > DENSE
    values, vectors = _sparse(solution, count) if large else _dense(solution)
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


def _dense(solution: Solution) -> tuple[Array, Array]:
    """All eigenvalues of what the load takes off by the stiffness, (..., n), and vectors (..., n, n); of what is absent
    those of nothing in particular."""
    plan, absent = solution.plan, solution.frame.absent
    stacks = [
        (group, group.turned(group.element.geometric_matrix(group.length, axial))) for group, axial in _axial(solution)
    ]
    taken = -dense.reduced(plan, dense.nodal(plan, stacks))
    half, root = stiffness_halves(plan)
    if absent is not None:
        left = absent[..., None, None]
        half, taken = np.where(left, np.eye(len(plan.unknowns)), half), np.where(left, 0.0, taken)
    return inverse_pencil(half, root, taken, len(plan.unknowns))


def _sparse(solution: Solution, count: int) -> tuple[Array, Array]:
    """The greatest of these eigenvalues for each load case of one large frame, (..., count), and vectors."""
    assert isinstance(solution.solver, SparseSolver)
    solver, shape = solution.solver, solution.shape
    pencil = SparsePencil(solver)
    forces = _axial(solution)
    values, vectors = np.zeros((*shape, count)), np.zeros((*shape, len(solution.plan.unknowns), count))
    for entry in np.ndindex(*shape):
        stacks = []
        for group, axial in forces:
            own = axial[(slice(None), *entry)].reshape(-1, *(1,) * len(shape))
            matrices = group.turned(group.element.geometric_matrix(group.length, own))
            stacks.append((group.nodes, matrices.__getitem__))
        values[entry], vectors[entry] = pencil.greatest(-solver.matrices.reduced(stacks), count)
    return values, vectors


def _axial(solution: Solution) -> list[tuple[Group, Array]]:
    """Mean axial forces of pieces, tension positive, (n, ...); zero where they are rounding of what their ends move."""
    plan, ndim = solution.plan, len(solution.shape)
    topology = plan.topology
    nodes = range(len(topology.number))
    nodal = solution.stacked([plan.tree.row(node, k) for node in nodes for k in range(6)])
    carried: dict[int, Array] = {}
    for group, positions, local in member_loads(topology):
        own = carried.setdefault(id(group), np.zeros((len(group.pieces), *solution.shape)))
        np.add.at(own, positions, (local[..., 6] - local[..., 0]) / 2.0)
    out = []
    for group in topology.groups:
        ends = np.moveaxis(nodal[..., group.dofs], -2, 0)
        moved = (group.transform @ ends[..., None])[..., 0]
        forces = group.element.end_forces(group.length, moved)
        axial = (forces[..., 6] - forces[..., 0]) / 2.0 - carried.get(id(group), 0.0)
        stiffness = group.element.stiffness_matrix(group.length)[..., 0, 0]
        stiffness = stiffness.reshape(len(stiffness), *(1,) * (ndim + 1 - stiffness.ndim), *stiffness.shape[1:])
        rounding = _ROUNDINGS * np.finfo(float).eps * stiffness * np.abs(moved[..., _TRANSLATIONS]).max(axis=-1)
        out.append((group, np.where(np.abs(axial) < rounding, 0.0, axial)))
    return out
