"""Solver of one large frame: sparse assembly on scikit-fem's primitives and SuperLU in symmetric mode."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix, csr_matrix, diags
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import splu

from .assembly import member_loads, nodal_loads, point_masses
from .batch import Array, turned
from .parts import Row, Value
from .plan import Plan
from .spectrum import zero_eigenvalue
from .topology import Group, Index

# Inverse iterations that estimate the least eigenvalue; for a singular matrix the first tells.
_ITERATIONS = 4


class SparseSolver:
    """One matrix, any number of load cases.

    Parameters
    ----------
    plan
        The compiled frame; no stiffness in it varies over the batch.
    """

    def __init__(self, plan: Plan) -> None:
        self.plan = plan
        self.column = {k: index for index, k in enumerate(plan.unknowns)}
        self._factors: dict[bytes, SparseFactor] = {}

    def values(self, rows: Sequence[Row]) -> list[Value]:
        """Value of each of `rows` over the unknowns."""
        shape = self.plan.frame.shape
        size = len(self.column)
        out: list[Value] = []
        for row in rows:
            index = [self.column[k] if k >= 0 else size - 1 - k for k in row]
            factors = np.array([float(factor) for factor in row.values()])
            out.append(self.plan.grid.value((factors @ self._numbers[index]).reshape(shape)))
        return out

    def singular(self, *, excited: bool) -> NDArray[np.bool_]:
        """Whether the components that loads reach, or the others, are singular, (...) of the batch shape."""
        where = self._excited if excited else ~self._excited
        found = bool(where.any()) and self._factor(where).least_eigenvalue() <= zero_eigenvalue(int(where.sum()))
        return np.full(self.plan.frame.shape, found)

    @cached_property
    def unknowns(self) -> Array:
        """Displacements in joint-relative coordinates, (n, load cases)."""
        from skfem import solve

        out = np.zeros_like(self.load)
        where = self._excited
        if where.any():
            matrix = self.stiffness[where][:, where]
            out[where] = solve(matrix, self.load[where], solver=lambda _, b: self._factor(where).solve(b))
        return out

    @cached_property
    def stiffness(self) -> csr_matrix:
        """T^T K T and the springs, (n, n)."""
        groups = self.plan.topology.groups
        members = self.gathered([(group, group.stiffness()) for group in groups])
        rows = self._spread([spring.row for spring in self.plan.tree.springs])
        springs = diags([float(spring.stiffness) for spring in self.plan.tree.springs])
        return csr_matrix(members + (rows.T @ springs @ rows if rows.shape[0] else 0.0 * members))

    @cached_property
    def mass(self) -> csr_matrix:
        """T^T M T of members and point masses, (n, n)."""
        topology = self.plan.topology
        members = self.gathered([(group, group.mass()) for group in topology.groups])
        rows, columns, values = [], [], []
        for node, block in point_masses(self.plan):
            rows.append(6 * node + np.repeat(np.arange(6), 6))
            columns.append(6 * node + np.tile(np.arange(6), 6))
            values.append(block.reshape(-1))
        if not rows:
            return members
        size = self.substitution.shape[0]
        entries = np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))
        return csr_matrix(members + self.substitution.T @ coo_matrix(entries, (size, size)) @ self.substitution)

    def gathered(self, stacks: list[tuple[Group, Array]]) -> csr_matrix:
        """Sum of member matrices in joint-relative coordinates, (n, n)."""
        return csr_matrix(self.substitution.T @ self._nodal(stacks) @ self.substitution)

    def _nodal(self, stacks: list[tuple[Group, Array]]) -> csr_matrix:
        return summed([(group.dofs, stack) for group, stack in stacks], 6 * len(self.plan.topology.number))

    @cached_property
    def load(self) -> Array:
        """Load on the unknowns, (n, load cases)."""
        tree, groups = self.plan.tree, self.plan.topology.groups
        nodal = self._nodal_load()
        shifts = self._known(self._nodal_rows)
        if shifts.any():
            nodal -= self._nodal([(group, group.stiffness()) for group in groups]) @ shifts
        springs = [spring.row for spring in tree.springs]
        stiffness = np.array([float(spring.stiffness) for spring in tree.springs])
        out: Array = self.substitution.T @ nodal - self._spread(springs).T @ (stiffness[:, None] * self._known(springs))
        return out

    @cached_property
    def substitution(self) -> csr_matrix:
        """T of ``u = T q + g``, (DOFs, n)."""
        return self._spread(self._nodal_rows)

    # -- inside -----------------------------------------------------------------------------------------------------

    @property
    def _cases(self) -> int:
        return int(np.prod(self.plan.frame.shape, dtype=np.int64))

    @cached_property
    def _excited(self) -> NDArray[np.bool_]:
        _, label = connected_components(self.stiffness, directed=False)
        pushed = np.unique(label[np.any(self.load != 0.0, axis=1)])
        found: NDArray[np.bool_] = np.isin(label, pushed)
        return found

    def _factor(self, where: NDArray[np.bool_]) -> SparseFactor:
        key = where.tobytes()
        if key not in self._factors:
            self._factors[key] = SparseFactor(self.stiffness[where][:, where])
        return self._factors[key]

    @cached_property
    def _nodal_rows(self) -> list[Row]:
        tree = self.plan.tree
        return [tree.row(node, k) for node in range(len(self.plan.topology.number)) for k in range(6)]

    @cached_property
    def _numbers(self) -> Array:
        """Unknowns and known numbers, (n + knowns, load cases)."""
        shape = self.plan.frame.shape
        knowns = [np.broadcast_to(value, shape).reshape(-1) for value in self.plan.knowns.values]
        return np.concatenate([self.unknowns, np.stack(knowns)])

    def _known(self, rows: list[Row]) -> Array:
        """The known part of rows, (rows, load cases)."""
        out = np.zeros((len(rows), self._cases))
        values = self.plan.knowns.values
        for r, row in enumerate(rows):
            for k, factor in row.items():
                if k < 0:
                    out[r] += np.broadcast_to(factor * values[-1 - k], self.plan.frame.shape).reshape(-1)
        return out

    def _spread(self, rows: list[Row]) -> csr_matrix:
        entries = [(r, self.column[k], float(v)) for r, row in enumerate(rows) for k, v in row.items() if k >= 0]
        r, c, v = (np.array(part) for part in zip(*entries, strict=True)) if entries else (np.zeros(0, dtype=int),) * 3
        return coo_matrix((v, (r, c)), shape=(len(rows), len(self.column))).tocsr()

    def _nodal_load(self) -> Array:
        topology = self.plan.topology
        out: Array = np.zeros((6 * len(topology.number), self._cases))
        for node, vector in nodal_loads(topology):
            axes = topology.axes(node)
            local = vector if axes is None else turned(np.swapaxes(axes, -1, -2), vector)
            out[6 * node : 6 * node + 6] += self._flat(local[None])[0].T
        for group, positions, local in member_loads(topology):
            nodal = (np.swapaxes(group.transform[positions], -1, -2) @ local[..., None])[..., 0]
            self._add(out, group.dofs[positions], self._flat(nodal))
        return out

    def _flat(self, stack: Array) -> Array:
        """(n, ..., m) with its batch as one axis, (n, load cases, m)."""
        n, m = stack.shape[0], stack.shape[-1]
        return np.broadcast_to(stack, (n, *self.plan.frame.shape, m)).reshape(n, self._cases, m)

    @staticmethod
    def _add(out: Array, dofs: Index, stack: Array) -> None:
        np.add.at(out, dofs.reshape(-1), np.swapaxes(stack, -1, -2).reshape(dofs.size, -1))


def summed(stacks: list[tuple[Index, Array]], size: int) -> csr_matrix:
    """Sum over all DOFs, (size, size), of matrices (n, ..., m, m), one batch entry each, at DOF numbers (n, m)."""
    from skfem.assembly.form.coo_data import COOData

    total = COOData(np.zeros((2, 0), dtype=int), np.zeros(0), (size, size), None)
    for dofs, stack in stacks:
        m = dofs.shape[1]
        pairs = np.stack([np.repeat(dofs, m, axis=1), np.tile(dofs, (1, m))]).reshape(2, -1)
        total = total + COOData(pairs, stack.reshape(-1), (size, size), (m, m))
    return csr_matrix(total.tocsr())


class SparseFactor:
    """LU of a symmetric positive definite matrix scaled to unit diagonal.

    Parameters
    ----------
    matrix
        The matrix (n, n).
    """

    def __init__(self, matrix: csr_matrix) -> None:
        diagonal = matrix.diagonal()
        self.root = 1.0 / np.sqrt(np.where(diagonal > 0.0, diagonal, 1.0))
        scaled = (diags(self.root) @ matrix @ diags(self.root)).tocsc()
        options = {"SymmetricMode": True}
        try:
            self.factor: Any = splu(scaled, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=options)
        except RuntimeError:  # SuperLU's word for an exactly zero pivot
            self.factor = None

    def solve(self, load: Array) -> Array:
        """Solution for `load` (n, cases); NaN where the matrix has an exactly zero pivot."""
        if self.factor is None:
            return np.full_like(load, np.nan)
        out: Array = self.root[:, None] * self.factor.solve(self.root[:, None] * load)
        return out

    def least_eigenvalue(self) -> float:
        """Estimate, from above, of the scaled matrix's least eigenvalue by inverse iteration."""
        if self.factor is None:
            return 0.0
        vector = np.random.default_rng(0).standard_normal(len(self.root))
        growth = 1.0
        for _ in range(_ITERATIONS):
            vector = self.factor.solve(vector / np.linalg.norm(vector))
            growth = float(np.linalg.norm(vector))
        return 1.0 / growth if np.isfinite(growth) else 0.0
