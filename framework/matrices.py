"""Stiffness, mass and load of a frame as global matrices for scikit-fem, in the numbering of its `Dofs`."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
import scipy
from numpy.typing import NDArray

from .batch import Array, aligned, block_diagonal, one_entry, rotated
from .batched.plan import Plan
from .description import Description
from .errors import FrameError
from .results.under_load import at_entry, geometric_stacks
from .solution import Solution
from .solvers.node_blocks import Stack, summed
from .states import SolutionState
from .structure.assembly import nodal_loads
from .structure.edge import ABOUT, ALONG, Edge
from .structure.matrices import Matrices
from .structure.member_loads import consistent
from .structure.topology import Group, Index, Topology

Condensed = tuple[scipy.sparse.csr_matrix, Any, Array, tuple[Index, Callable[[Array], Array]]]


@dataclass(frozen=True, eq=False)
class FrameMatrices:
    """Global matrices of a frame at one batch entry, over the displacements u of all nodes, six per node.

    Obtained from ``frame.matrices()``. The members are cut into their segments; the degrees of freedom are numbered by
    the scikit-fem objects `mesh` and `dofs`. Supports are given by `D` and `x`, as scikit-fem's `condense` takes them.
    Constraints of ideal joints (inf), rigid links and ties are not in `K`: with any of them, solve in the coordinates q
    of ``u = T q + g``, which `condensed` prepares.

    Attributes
    ----------
    mesh
        ``MeshLine1`` of members, joints and rigid links, with their names as subdomains and supports as boundaries.
    dofs
        ``Dofs`` with the components ``ux uy uz rx ry rz``.
    K, M
        Stiffness of members and finite joint springs, and mass, sparse (6 nodes, 6 nodes).
    f
        Forces and moments of the loads, those on members as consistent nodal loads, (6 nodes,).
    D
        Numbers of the supported displacements.
    x
        Prescribed values of the supported displacements, 0 elsewhere, (6 nodes,).
    Kg
        Geometric stiffness of the forces that the loads cause in members, joints and rigid links, (6 nodes, 6 nodes).
    T, g
        All constraints, supports included: ``u = T q + g`` with independent coordinates q, T (6 nodes, q) and
        g (6 nodes,).

    Examples
    --------
    A cantilever by hand, ``F L^3 / (3 E I)`` (Timoshenko, *Strength of Materials* I).

    >>> import skfem
    >>> from linkframe.elements import Beam, Material, Rectangle
    >>> from linkframe.framework import Frame
    >>> frame = Frame()
    >>> for name, x in {"A": 0.0, "B": 2.0}.items():
    ...     frame.node(name, (x, 0.0, 0.0))
    >>> frame.add("AB", Beam(Rectangle(y=0.02, z=0.01), Material(E=200e9, nu=0.3)), "A", "B")
    >>> frame.fix("A"); frame.load("B", fy=-10.0)
    >>> by = frame.matrices()
    >>> u = skfem.solve(*skfem.condense(by.K, by.f, x=by.x, D=by.D))
    >>> (tip,) = by.dofs.get_vertex_dofs([1]).all(["uy"])
    >>> float(u[tip].round(9)), float(frame.solve().displacement("B")[1].round(9))
    (-0.02, -0.02)
    """

    mesh: Any
    dofs: Any
    K: scipy.sparse.csr_matrix
    M: scipy.sparse.csr_matrix
    f: Array
    D: Index
    x: Array
    T: scipy.sparse.csr_matrix
    g: Array
    _geometric: Callable[[], scipy.sparse.csr_matrix] = field(repr=False)

    @cached_property
    def Kg(self) -> scipy.sparse.csr_matrix:
        """Geometric stiffness under the loads, (6 nodes, 6 nodes): a frame buckles if ``K + factor Kg`` is singular.

        Raises
        ------
        FrameError
            If the frame is kinematically unstable.
        """
        return self._geometric()

    def condensed(self, matrix: scipy.sparse.csr_matrix | None = None) -> Condensed:
        """Prepare the arguments with which ``skfem.solve`` solves in the independent coordinates q and returns u.

        Master-slave elimination, by a congruence (Cook, Malkus, Plesha & Witt, *Concepts and Applications of Finite
        Element Analysis*, 4th ed., ch. 13).

        Parameters
        ----------
        matrix
            Another matrix over u in place of the loads, (6 nodes, 6 nodes), such as `M` for the eigenvalue problem
            ``K u = lambda M u``; `g` is then left out.

        Returns
        -------
        tuple
            ``T^T K T``; ``T^T (f - K g)`` or ``T^T matrix T``; g or 0; and the indices and function by which
            ``skfem.solve`` expands q to u.

        Examples
        --------
        A rod on an ideal hinge, whose constraints are not in `K` but in the coordinates q.

        >>> import skfem
        >>> from linkframe.elements import Beam, Circle, Joint, Material
        >>> from linkframe.framework import Frame
        >>> frame = Frame()
        >>> for name, x in {"A": 0.0, "B": 0.0, "C": 1.0}.items():
        ...     frame.node(name, (x, 0.0, 0.0))
        >>> frame.add("hinge", Joint(stiffness=(float("inf"),) * 5 + (100.0,)), "A", "B")
        >>> frame.add("BC", Beam(Circle(diameter=0.02), Material(E=200e9, nu=0.3)), "B", "C")
        >>> frame.fix("A"); frame.load("C", fy=1.0)
        >>> u = skfem.solve(*frame.matrices().condensed())
        >>> bool(abs(u.reshape(-1, 6) - frame.solve().displacements()).max() < 1e-12)
        True
        """
        everywhere = np.arange(len(self.f))
        if matrix is None:
            right: Any = self.T.T @ (self.f - self.K @ self.g)
            start = self.g
        else:
            right, start = scipy.sparse.csr_matrix(self.T.T @ matrix @ self.T), np.zeros_like(self.g)
        return scipy.sparse.csr_matrix(self.T.T @ self.K @ self.T), right, start, (everywhere, lambda q: self.T @ q)


def frame_matrices(frame: Description, entry: int | Sequence[int]) -> FrameMatrices:
    """Matrices of a frame at one batch entry; see `Frame.matrices`."""
    described = frame.copy()
    at = one_entry(frame.shape, entry, "matrices") if frame.shape else ()
    if frame.absent is not None and np.broadcast_to(frame.absent, frame.shape)[at]:
        raise FrameError(f"matrices: batch entry {list(at)} was left out: give one that is there")
    return _Assembly(Plan(described, cut=True), at).matrices()


class _Assembly:
    """Assembly of the matrices at one batch entry."""

    def __init__(self, plan: Plan, entry: tuple[int, ...]) -> None:
        self.plan, self.entry, self.sparse = plan, entry, Matrices(plan, entry)
        self.size = 6 * len(plan.topology.number)
        self.everywhere = np.ones(len(plan.topology.number), dtype=bool)

    def matrices(self) -> FrameMatrices:
        """All matrices of the entry."""
        mesh, dofs = self.plan.topology.mesh, self.plan.topology.numbering
        constrained, x = self._supports()
        rows = [row for node in range(len(self.everywhere)) for row in self.plan.tree.global_rows(node)]
        known = [(r, k, v) for r, row in enumerate(rows) for k, v in row.items() if k < 0]
        g = np.zeros(self.size)
        for r, k, value in known:
            g[r] += self.sparse.at(value) * self.sparse.at(self.plan.rhs_parameters.values[-1 - k])
        stiffness: list[Stack] = [(group.nodes, self._rotated(group, "stiffness").__getitem__) for group in self.groups]
        mass: list[Stack] = [(group.nodes, self._rotated(group, "mass").__getitem__) for group in self.groups]
        springs, pushed = self._joints()
        return FrameMatrices(
            mesh,
            dofs,
            summed([*stiffness, *springs], self.everywhere),
            summed([*mass, *self._points()], self.everywhere),
            self._loads() + pushed,
            constrained,
            x,
            self.sparse.spread(rows)[:, self._moving()],
            g,
            self._geometric,
        )

    def _moving(self) -> NDArray[np.bool_]:
        """Mask of the unknowns that stand for a coordinate at the entry, (n,)."""
        idle = [key for key, where in self.plan.tree.elimination.idle.items() if self.sparse.at(where)]
        return ~np.isin(self.sparse.unknown, idle)

    def _geometric(self) -> scipy.sparse.csr_matrix:
        solution = Solution(self.plan.frame, self.plan)
        if solution.own_state[self.entry] == SolutionState.MECHANISM:
            raise FrameError(f"matrices: the frame is kinematically unstable: {solution.mechanism(*self.entry)}")
        where, state = next((at, state) for at, state in solution.bounds.states() if self._within(at))
        local = tuple(k - part.indices(n)[0] for k, part, n in zip(self.entry, where, solution.shape, strict=True))
        stacks: list[Stack] = []
        for nodes, matrices in geometric_stacks(state):
            here = at_entry(local, matrices) if self.entry else matrices
            stacks.append((nodes, self._global(nodes, here).__getitem__))
        return summed(stacks, self.everywhere)

    def _within(self, where: tuple[slice, ...]) -> bool:
        """Whether a part of the batch contains the entry."""
        sizes = self.plan.frame.shape
        return all(k in range(*part.indices(n)) for k, part, n in zip(self.entry, where, sizes, strict=True))

    def _global(self, nodes: Index, matrices: Array) -> Array:
        """Matrices (n, 6 k, 6 k) in the axes of their nodes (n, k), turned into global axes."""
        axes = [self.plan.topology.axes(int(node)) for node in nodes.reshape(-1)]
        each = np.stack([np.eye(3) if own is None else self._at(own, 2) for own in axes])
        blocks = np.repeat(each.reshape(*nodes.shape, 3, 3), 2, axis=1)
        turn = block_diagonal([blocks[:, k] for k in range(blocks.shape[1])])
        out: Array = turn @ matrices @ np.swapaxes(turn, -1, -2)
        return out

    @cached_property
    def topology(self) -> Topology:
        """Members and their loads at the entry."""
        part = self.plan.topology
        for axis, index in enumerate(self.entry):
            part = part.cut(axis, slice(index, index + 1))
        return part

    @property
    def groups(self) -> list[Group]:
        """Members at the entry, by kind."""
        return self.topology.groups

    def _rotated(self, group: Group, kind: str) -> Array:
        """Stiffness or mass in global axes, (n, 12, 12)."""
        local = getattr(group.element, f"{kind}_matrix")(group.length)
        return group.in_node_axes(local, (group.local_axes, group.local_axes)).reshape(len(group.pieces), 12, 12)

    def _points(self) -> Iterator[Stack]:
        for mass in self.plan.frame.masses.values():
            matrix = self._at(mass.element.mass_matrix(), 2)
            yield np.array([[self.plan.topology.number[mass.node]]]), matrix[None].__getitem__

    def _joints(self) -> tuple[list[Stack], Array]:
        """Stiffness of finite joint springs, and the nodal forces of their imposed displacements, (6 nodes,)."""
        stacks: list[Stack] = []
        pushed = np.zeros(self.size)
        for edge in self.plan.tree.edges:
            if edge.kind != "joint":
                continue
            rows, stiffness = self._deformations(edge), np.array([self.sparse.at(k) for k in edge.stiffness])
            nodes = np.array([[edge.first, edge.second]])
            stacks.append((nodes, (rows.T @ (stiffness[:, None] * rows))[None].__getitem__))
            offset = [
                sum(self.sparse.at(v) * self.sparse.at(self.plan.rhs_parameters.values[-1 - k]) for k, v in row.items())
                for row in edge.offset
            ]
            dofs = (6 * nodes[0][:, None] + np.arange(6)).reshape(-1)
            pushed[dofs] += rows.T @ (stiffness * np.array(offset))
        return stacks, pushed

    def _deformations(self, edge: Edge) -> Array:
        """Deformations of a joint's springs by the global displacements of its two nodes, (6, 12)."""
        axes = np.eye(3) if edge.axes is None else self._at(edge.axes, 2)
        turn = block_diagonal((axes.T, axes.T))
        rows: Array = np.concatenate([-turn, turn], axis=1)
        rows[ALONG] -= self.sparse.at(edge.pitch) * rows[ABOUT]
        return rows

    def _loads(self) -> Array:
        out = np.zeros((len(self.everywhere), 6))
        for node, vector in nodal_loads(self.plan.topology):
            out[node] += self._at(vector, 1)
        for group, positions, local in consistent(self.topology):
            back = np.swapaxes(group.local_axes[positions], -1, -2)
            both = rotated(back, local).reshape(len(positions), 2, 6)
            np.add.at(out, group.nodes[positions], both)
        return out.reshape(-1)

    def _supports(self) -> tuple[Index, Array]:
        constrained, x = [], np.zeros(self.size)
        for node, given in self.plan.frame.supports.items():
            for k, value in given.items():
                constrained.append(6 * self.plan.topology.number[node] + k)
                x[constrained[-1]] = self._at(value, 0)
        return np.array(sorted(constrained), dtype=np.int64), x

    def _at(self, array: NDArray[Any], trailing: int) -> Array:
        """An array of the batch with `trailing` further axes, at the entry."""
        whole = aligned(array, len(self.entry), trailing)
        index = tuple(k if n > 1 else 0 for k, n in zip(self.entry, whole.shape, strict=False))
        out: Array = whole[index]
        return out
