"""What depends on the description alone: numbers, joint coordinates, connected components, elimination orders."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cached_property

from .assembly import force_entries, stiffness_entries
from .block import Block
from .frame import Frame
from .order import Order, Pattern, link, order
from .parts import Grid, Value, is_zero
from .stage import Forces, Matrix
from .topology import Topology
from .tree import Tree

# Unknowns above which a frame that does not vary goes the sparse way.
LARGE = 100


class Plan:
    """A frame compiled: which unknowns there are, how they are coupled, which of them a load can reach.

    Parameters
    ----------
    frame
        The description.
    """

    def __init__(self, frame: Frame) -> None:
        self.frame = frame
        self.grid = Grid(frame.shape)
        self.topology = Topology.of(frame)
        self.tree = Tree.of(self.topology)
        self._blocks: dict[int, Block] = {}

    @cached_property
    def large(self) -> bool:
        """Whether this is one large frame, whose stiffness does not vary over the batch: the sparse way is faster."""
        tree = self.tree
        constant = all(group.stiffness_size == 1 for group in self.topology.groups)
        numbers = [v for rows in tree.rows.values() for row in rows for v in row.values()]
        numbers += [v for s in tree.springs for v in (s.stiffness, *s.row.values())]
        return len(self.unknowns) > LARGE and constant and all(isinstance(v, float) for v in numbers)

    @cached_property
    def matrix(self) -> Matrix:
        """Parts of the members' stiffness by pair of DOFs, in the nodes' axes."""
        return stiffness_entries(self.topology, self.grid)

    @cached_property
    def forces(self) -> Forces:
        """Parts of the loads by DOF, in the nodes' axes."""
        return force_entries(self.topology, self.grid)

    @cached_property
    def shifts(self) -> dict[int, Value]:
        """Known displacements by DOF, where they are not zero."""
        return {
            6 * node + k: value
            for node, values in self.tree.shifts.items()
            for k, value in enumerate(values)
            if not is_zero(value)
        }

    @cached_property
    def unknowns(self) -> list[int]:
        """All unknowns: displacements of free nodes, joint-relative coordinates of the others."""
        on_edges = {k for rows in self.tree.rows.values() for row in rows for k in row}
        on_edges |= {k for spring in self.tree.springs for k in spring.row}
        free = (6 * n + k for n in self.topology.number.values() if n not in self.tree.rows for k in range(6))
        return sorted(on_edges.union(free))

    @cached_property
    def component(self) -> dict[int, int]:
        """Connected component of every unknown, named by one of its unknowns."""
        leader: dict[int, int] = {}

        def find(k: int) -> int:
            while leader.setdefault(k, k) != k:
                leader[k] = leader[leader[k]]
                k = leader[k]
            return k

        def join(keys: Iterable[int]) -> None:
            first, *others = (find(k) for k in keys)
            for k in others:
                leader[find(k)] = find(first)

        for a, row in self.matrix.items():
            for b in row:
                touched = self._coupled(a) + self._coupled(b)
                if touched and self._coupled(a) and self._coupled(b):
                    join(touched)
        for rows in self.tree.rows.values():
            for coupled in rows:
                if coupled:
                    join(coupled)
        for spring in self.tree.springs:
            if spring.row:
                join(spring.row)
        return {k: find(k) for k in self.unknowns}

    @cached_property
    def excited(self) -> set[int]:
        """Components that a load, an offset or a prescribed displacement reaches."""
        pushed = {dof for dof, parts in self.forces.items() if parts}
        pushed |= {a for b in self.shifts for a in self.matrix.get(b, {})}
        reached = {k for dof in pushed for k in self._coupled(dof)}
        reached |= {k for spring in self.tree.springs if not is_zero(spring.gap) for k in spring.row}
        return {self.component[k] for k in reached}

    def members_of(self, component: int) -> set[int]:
        """Unknowns of a component."""
        return {k for k, name in self.component.items() if name == component}

    @property
    def components(self) -> set[int]:
        """Names of all components."""
        return set(self.component.values())

    def block(self, component: int) -> Block:
        """A component assembled, with its elimination orders."""
        if component not in self._blocks:
            self._blocks[component] = self._assembled(component)
        return self._blocks[component]

    def _coupled(self, dof: int) -> list[int]:
        """Unknowns in a nodal displacement."""
        node, k = divmod(dof, 6)
        return list(self.tree.rows[node][k]) if node in self.tree.rows else [dof]

    def _assembled(self, component: int) -> Block:
        unknowns = self.members_of(component)
        ends = {
            6 * node + k: row
            for node, rows in self.tree.rows.items()
            for k, row in enumerate(rows)
            if row and self.component[next(iter(row))] == component
        }
        inner = sorted(k for k in unknowns if k // 6 not in self.tree.rows)
        own = set(inner) | set(ends)
        held = {b for a in own for b in self.matrix.get(a, {}) if b not in own and b in self.shifts}
        rows = ends | {b: {} for b in held}
        matrix: Matrix = {
            a: {b: parts for b, parts in self.matrix.get(a, {}).items() if b in own or b in held} for a in own
        }
        for a in own:
            matrix[a].setdefault(a, {})
            for b in held & matrix[a].keys():
                matrix.setdefault(b, {})[a] = matrix[a][b]
        for b in held:
            matrix[b].setdefault(b, {})
        springs = [
            (s.row, s.stiffness, s.gap)
            for s in self.tree.springs
            if s.row and self.component[next(iter(s.row))] == component
        ]
        forces = {a: self.forces[a] for a in own if a in self.forces}
        shifts = {a: self.shifts[a] for a in own | held if a in self.shifts}
        orders = self._orders(matrix, inner, rows, springs, unknowns)
        return Block(self.grid, orders, matrix, forces, rows, shifts, springs)

    def _orders(
        self,
        matrix: Matrix,
        inner: list[int],
        rows: dict[int, dict[int, Value]],
        springs: list[tuple[dict[int, Value], Value, Value]],
        unknowns: set[int],
    ) -> tuple[Order, Order]:
        mask = self.grid.mask
        pattern: Pattern = {}
        for a, row in matrix.items():
            for b, parts in row.items():
                if parts or (a == b and a not in rows):
                    link(pattern, a, b, _union(parts))
        first = order(pattern, inner, self.grid)
        reduced: Pattern = {k: {k: 0} for k in unknowns.difference(inner)}
        for a, coupled in pattern.items():
            for b, over in coupled.items():
                for i, left in rows.get(a, {}).items():
                    for j, right in rows.get(b, {}).items():
                        link(reduced, i, j, over | mask(left) | mask(right))
        for spring, stiffness, _ in springs:
            for i, left in spring.items():
                for j, right in spring.items():
                    link(reduced, i, j, mask(stiffness) | mask(left) | mask(right))
        return first, order(reduced, list(reduced), self.grid)


def _union(parts: dict[int, Value]) -> int:
    mask = 0
    for key in parts:
        mask |= key
    return mask
