"""Sparse stiffness and mass of one batch entry in joint-relative coordinates."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import scipy

from ..batch import Array
from ..batched.plan import Plan
from ..batched.unloaded import Unloaded
from ..lazily import cached_property
from ..solvers.node_blocks import Stack, summed
from .assembly import point_masses
from .parts import Row, Value
from .topology import Index


class Matrices:
    """Sparse matrices ``T^T K T`` and ``T^T M T`` over the n unknowns q of ``u = T q + g``.

    Parameters
    ----------
    plan
        The plan of the frame, or its part without loads.
    entry
        Indices of the batch entry; of no effect where the stiffness does not vary.
    """

    def __init__(self, plan: Plan | Unloaded, entry: tuple[int, ...] = ()) -> None:
        self.plan, self.entry = plan, entry
        self.unknown: Index = plan.graph.unknown

    @cached_property
    def _members(self) -> list[Stack]:
        """Node numbers of each group of members, and the function that returns their matrices."""
        return [(group.nodes, group.stiffness) for group in self.plan.topology.groups]

    @cached_property
    def stiffness(self) -> scipy.sparse.csr_matrix:
        """``T^T K T`` of the members, plus the joint springs, (n, n)."""
        members = self.reduced(self._members)
        if not self.plan.tree.springs:
            return members
        rows = self.spread([spring.row for spring in self.plan.tree.springs])
        return scipy.sparse.csr_matrix(members + rows.T @ scipy.sparse.diags(self.springs) @ rows)

    @property
    def springs(self) -> list[float]:
        """Stiffnesses of the joint springs."""
        return [self.at(spring.stiffness) for spring in self.plan.tree.springs]

    @cached_property
    def mass(self) -> scipy.sparse.csr_matrix:
        """T^T M T of members and point masses, (n, n)."""
        points = point_masses(self.plan.topology)
        stacks: list[Stack] = [(np.array([[node]]), matrix[None].__getitem__) for node, matrix in points]
        return self.reduced([(group.nodes, group.mass) for group in self.plan.topology.groups] + stacks)

    @cached_property
    def members(self) -> scipy.sparse.csr_matrix:
        """Stiffness of the members over all DOFs, (DOFs, DOFs)."""
        return summed(self._members, np.ones_like(self.plan.graph.free))

    @cached_property
    def substitution(self) -> scipy.sparse.csr_matrix:
        """T, (DOFs, n)."""
        rows, count = self.plan.graph.transformation, 6 * len(self.plan.graph.free)
        if not rows.factors and not rows.imposed:
            start = rows.start[: count + 1]
            within = slice(0, int(start[-1]))
            return scipy.sparse.csr_matrix((rows.share[within], rows.column[within], start), (count, rows.size))
        free = np.flatnonzero(self.plan.graph.free)
        own = (6 * free[:, None] + np.arange(6)).reshape(-1)
        nodes = self.plan.tree.rows
        given = self.spread([row for six in nodes.values() for row in six]).tocoo()
        dofs = (6 * np.array(list(nodes), dtype=np.int64)[:, None] + np.arange(6)).reshape(-1)[given.row]
        columns = np.concatenate([np.searchsorted(self.unknown, own), given.col])
        data = np.concatenate([np.ones(len(own)), given.data])
        where = np.concatenate([own, dofs]), columns
        return scipy.sparse.coo_matrix((data, where), shape=(count, len(self.unknown))).tocsr()

    def global_substitution(self, nodes: list[int]) -> scipy.sparse.csr_matrix:
        """Matrix from the unknowns to the displacements of `nodes` in global axes, (6 nodes, n)."""
        return self.spread([row for node in nodes for row in self.plan.tree.global_rows(node)])

    def spread(self, rows: Sequence[Row]) -> scipy.sparse.csr_matrix:
        """Rows over the unknowns as a matrix, (rows, n)."""
        entries = [(r, k, self.at(v)) for r, row in enumerate(rows) for k, v in row.items() if k >= 0]
        r, k, v = (np.array(part) for part in zip(*entries, strict=True)) if entries else (np.zeros(0, dtype=int),) * 3
        return scipy.sparse.coo_matrix(
            (v, (r, np.searchsorted(self.unknown, k))), shape=(len(rows), len(self.unknown))
        ).tocsr()

    def reduced(self, stacks: Sequence[Stack]) -> scipy.sparse.csr_matrix:
        """T^T A T, (n, n), of a sum of element matrices.

        Parameters
        ----------
        stacks
            For each stack the node numbers of its elements, and a function that returns their matrices.
        """
        free = self.plan.graph.free
        if self._free_or_constrained:
            return summed(stacks, free)
        change = self.substitution
        return scipy.sparse.csr_matrix(change.T @ summed(stacks, np.ones_like(free)) @ change)

    @cached_property
    def _free_or_constrained(self) -> bool:
        """Whether each node either has six unknowns of its own or is fully constrained."""
        return bool(6 * self.plan.graph.free.sum() == len(self.unknown))

    def gathered(self, nodal: Array) -> Array:
        """``T^T f``, (n, load cases), of loads f (DOFs, load cases)."""
        if self._free_or_constrained:
            return nodal.reshape(-1, 6, nodal.shape[1])[self.plan.graph.free].reshape(-1, nodal.shape[1])
        out: Array = self.substitution.T @ nodal
        return out

    def at(self, value: Value) -> float:
        """The value of a number at the batch entry."""
        if not isinstance(value, np.ndarray):
            return float(value)
        return float(value[tuple(k if n > 1 else 0 for k, n in zip(self.entry, value.shape, strict=True))])
