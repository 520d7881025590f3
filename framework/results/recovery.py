"""Recovery of forces from displacements: at member ends, in joints and supports, and along members."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import cached_property, partial
from itertools import chain

import numpy as np

from ..batch import Array, rotated
from ..error_bounds.equilibrium import rounded
from ..error_bounds.kinematics import FrameKinematics
from ..error_bounds.sharing import load_shares
from ..program import sweep
from ..program.sweep import Sweep
from ..structure.connections import TreeEdge
from ..structure.edge import Edge
from ..structure.parts import Row, Value
from .along_member import AlongMembers
from .force_numbers import ForceNumbers
from .member_field import deflection, internal_forces
from .piece_ends import PieceEnds, WithoutFormula, refused
from .primary import Primary

# A function that returns the n numbers of a result.
Numbers = Callable[[ForceNumbers], Sequence[Value]]


class Recovery(AlongMembers):
    """Forces and displacements that follow from the unknowns of a solution.

    Parameters
    ----------
    solution
        The values of the unknowns.
    """

    def __init__(self, solution: Primary) -> None:
        super().__init__(solution.plan.topology)
        self.solution = solution
        self.plan = solution.plan
        self.tree = solution.plan.tree
        self._piece_ends = PieceEnds(solution)

    # -- members ----------------------------------------------------------------------------------------------------

    def end_forces(self, member: str) -> Array:
        """Forces on both ends of a member in its local axes, (..., 12); the array must not be modified."""
        pieces = self.topology.pieces_of[member]
        start, end = self._piece_ends.forces(pieces[0]), self._piece_ends.forces(pieces[-1])
        if start is end:
            return start
        return np.concatenate([start[..., :6], end[..., 6:]], axis=-1)

    def moved(self, piece: int, x: Array) -> Array:
        """Displacement at stations of a piece in global axes, (k, ..., 6)."""
        group, position = self.group(piece)
        ends = self._piece_ends.displacement(piece)[None]
        local = deflection(self.topology, group, np.array([position]), x[:, None], ends)[:, 0]
        return rotated(np.swapaxes(group.local_axes[position], -1, -2), local)

    def moved_along(self, member: str, at: Array) -> Array:
        """Displacement at stations in each free motion of consistent mechanisms, in global axes, (motions, m, k, 6)."""
        mechanisms = self.solution.consistent_mechanisms
        assert mechanisms is not None
        count = len(mechanisms.motions([]))

        def displacement(piece: int, x: Array, motion: int) -> Array:
            group, position = self.group(piece)
            ends = np.zeros((*self.solution.shape, 12))
            ends[mechanisms.mask] = mechanisms.motions(self._piece_ends.rows(piece))[motion]
            local = group.local(position, ends)
            shapes = group.of(position).shape_functions(group.length[position], x)
            moved = np.einsum("...ij,...j->...i", shapes, local)
            return rotated(np.swapaxes(group.local_axes[position], -1, -2), moved)

        whole = [self.along(member, at, partial(displacement, motion=motion)) for motion in range(count)]
        return np.stack([each[mechanisms.mask] for each in whole])

    def internal(self, piece: int, x: Array) -> Array:
        """Internal forces at stations of a piece, (k, ..., 6)."""
        group, position = self.group(piece)
        ends = self._piece_ends.forces(piece)[None]
        return internal_forces(self.topology, group, np.array([position]), x[:, None], ends)[:, 0]

    # -- joints and supports ----------------------------------------------------------------------------------------

    def joint_rows(self, joint: str) -> list[Row]:
        """Rows of the relative displacement in a joint, in the joint's axes."""
        if joint in self._branches:
            return [self.tree.joint_row(self._branches[joint], k) for k in range(6)]
        return next(rows for edge, rows in self.tree.closing if edge.kind == "joint" and edge.name == joint)

    def joint_force(self, joint: str) -> Array:
        """Force and moment of a joint on its first node, in the joint's axes, (..., 6)."""
        edge = self._edge("joint", joint)
        found = self._alone(lambda numbers: numbers.of_edge(edge))
        return found - self._excess[edge] if edge in self._excess else found

    def joint_components(self, pairs: Sequence[tuple[str, int]]) -> Array:
        """Single components of joint forces, given by joint and component, (..., n), in one pass.

        They are those of a joint whose offsets are possible, so that they have no part in what redundant constraints
        may do to each other.
        """
        return self.together([self._components(pairs)])[0]

    def against_offsets(
        self,
        pairs: Sequence[tuple[str, int]],
        others: Sequence[Numbers],
        parameters: Sequence[int],
        *,
        loads: bool = False,
    ) -> list[Array] | None:
        """The stiffness against offsets in joints, and other results per unit offset, in one pass over the batch.

        Parameters
        ----------
        pairs
            Name of the joint, and component of the joint, for each of n offsets; () if no stiffness is asked for.
        others
            Functions that return m numbers, given those of the forces.
        parameters
            Index of the right-hand-side parameter that is the offset, for each of them.
        loads
            Whether the forces under the loads, without these offsets, are asked for as well.

        Returns
        -------
        list of ndarray or None
            Decrease of the force in each component per unit offset in each, (n, n, ...), the mean of both that are
            equal by Betti's theorem; the other results, (n, ..., m) each; and, if asked for, the forces (n, ...). None
            where they do not hold at all entries, or follow from the end forces of an element without a formula.
        """
        components = range(len(pairs))

        def results(under: Callable[[int | None], Sweep]) -> list[Sequence[Value]]:
            kinds = [self._components(pairs), *others]
            forces = self._written(kinds[:1], under(None), ends=refused) if loads else []
            each = [self._written(kinds, under(parameter), ends=refused, loaded=False) for parameter in parameters]
            stiffness = [-0.5 * (each[j][0][i] + each[i][0][j]) for i in components for j in components]
            return [stiffness, *([x for found in each for x in found[k]] for k in range(1, len(kinds))), *forces]

        try:
            with np.errstate(all="ignore"):  # of mechanisms, for which there is no result
                found = self.solution.per_unit(parameters, results)
        except WithoutFormula:
            return None
        if found is None:
            return None
        forces = [np.moveaxis(found.pop(), -1, 0)] if loads else []
        stiffness, *rest = (
            np.moveaxis(array, -1, 0).reshape(len(parameters), array.shape[-1] // len(parameters), *array.shape[:-1])
            for array in found
        )
        return [stiffness, *(np.moveaxis(array, 1, -1) for array in rest), *forces]

    def _components(self, pairs: Sequence[tuple[str, int]]) -> Numbers:
        edges = {name: self._edge("joint", name) for name, _ in pairs}

        def components(numbers: ForceNumbers) -> list[Value]:
            forces = {name: numbers.of_edge(edge) for name, edge in edges.items()}
            return [forces[name][k] for name, k in pairs]

        return components

    def reaction(self, node: str) -> Array:
        """Force and moment of the support on a node, in global axes, (..., 6)."""
        edge = self._edge("support", node)
        found = self._alone(lambda numbers: [0.0 - x for x in numbers.of_edge(edge)])
        return found + self._excess[edge] if edge in self._excess else found

    def _edge(self, kind: str, name: str) -> Edge:
        return next(edge for edge in self.tree.edges if edge.kind == kind and edge.name == name)

    @cached_property
    def _excess(self) -> dict[Edge, Array]:
        """Correction of the forces of edges with redundant constraints, to be subtracted to give the shared forces."""
        if not self.tree.elimination.self_stresses:
            return {}
        kinematics = FrameKinematics.of(self.plan).mapped(rounded)
        links, out = kinematics.links, {}
        for load_share in load_shares(kinematics):
            edges = [links[k].edge for k in load_share.place]
            whole = self.together([partial(ForceNumbers.of_edge, edge=edge) for edge in edges])
            forces = {k: links[k].worked(force) for k, force in zip(load_share.place, whole, strict=True)}
            with np.errstate(invalid="ignore"):  # of mechanisms
                for k, excess in load_share.excess(forces).items():
                    out[links[k].edge] = np.asarray(links[k].exerted(excess), dtype=np.float64)
        return out

    @cached_property
    def _branches(self) -> dict[str, TreeEdge]:
        return {b.edge.name: b for b in self.tree.branches if b.edge.kind == "joint" and b.edge.name is not None}

    # -- many results at once ---------------------------------------------------------------------------------------

    def all_of(self, kinds: Iterable[str]) -> list[Array] | None:
        """Some fields of `AllResults`, in one pass over a long batch; None where that is not possible.

        Parameters
        ----------
        kinds
            Names of the fields.
        """
        frame, number = self.plan.frame, self.topology.number
        if not self._piece_ends.long or self.tree.elimination.self_stresses:
            return None

        def of(kind: str, numbers: ForceNumbers) -> Iterator[Sequence[Value]]:
            if kind == "displacements":
                return (numbers.displacement(number[node]) for node in frame.nodes)
            if kind == "end_forces":
                return (numbers.member_ends(member) for member in frame.members)
            if kind == "reactions":
                return ([0.0 - x for x in numbers.of_edge(self._edge("support", node))] for node in frame.supports)
            if kind == "joint_displacements":
                return (numbers.values(self.joint_rows(joint)) for joint in frame.joints)
            return (numbers.of_edge(self._edge("joint", joint)) for joint in frame.joints)

        def flat(numbers: ForceNumbers, kind: str) -> list[Value]:
            # component by component, so that those that are zero, as in a plane frame, are contiguous
            return list(chain.from_iterable(zip(*of(kind, numbers), strict=True)))

        found = self.together([partial(flat, kind=kind) for kind in kinds])
        sizes = [12 if kind == "end_forces" else 6 for kind in kinds]
        return [
            np.swapaxes(array.reshape(*array.shape[:-1], size, array.shape[-1] // size), -1, -2)
            for array, size in zip(found, sizes, strict=True)
        ]

    def together(self, results: Sequence[Numbers]) -> list[Array]:
        """Some results, each (..., n), in one pass over the batch if that is long."""
        with np.errstate(all="ignore"):  # of mechanisms, whose entries are masked
            if self._piece_ends.long:
                return self.solution.recorded(partial(self._written, results))
            return [self._stacked(result(self._numbers)) for result in results]

    def _written(
        self,
        results: Sequence[Numbers],
        once: Sweep,
        ends: Callable[[int], Array] | None = None,
        *,
        loaded: bool = True,
    ) -> list[Sequence[Value]]:
        numbers = self._piece_ends.written(once, ends, loaded=loaded)
        return [result(numbers) for result in results]

    def _alone(self, result: Numbers) -> Array:
        """One result, (..., n).

        As others are likely to follow, intermediate arrays are kept, unless the batch is very long: recording each
        result separately takes longer.
        """
        if math.prod(self.solution.shape) >= 2 * sweep.LONG:
            return self.together([result])[0]
        with np.errstate(all="ignore"):  # of mechanisms, whose entries are masked
            return self._stacked(result(self._numbers))

    @cached_property
    def _numbers(self) -> ForceNumbers:
        return self._piece_ends.of_arrays()

    def _stacked(self, numbers: Sequence[Value]) -> Array:
        whole = np.zeros((len(numbers), *self.solution.shape))
        for k, number in enumerate(numbers):
            whole[k, ...] = number
        return np.moveaxis(whole, 0, -1)
