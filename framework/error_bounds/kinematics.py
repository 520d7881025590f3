"""Displacements of all nodes from joint-relative coordinates, and forces on coordinates from nodal ones.

The coordinates of a node are those of `linkframe.framework.structure.tree`: its own displacement in its axes, or that
of the joint, rigid link, tie or support that carries it, ideal components included. A unit virtual displacement of an
ideal component is then a coordinate like any other, and its work is the constraint force there. All holds in any
precision.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np

from ..batch import aligned, merged, rotated
from ..batched.plan import Plan
from ..batched.unloaded import Unloaded
from ..entries import WHOLE, Change, Entries
from ..structure.edge import GROUND, Edge
from ..structure.parts import is_zero
from ..structure.topology import Index
from .exchanged_links import Dependents, dependent_coordinates, exchanged_links
from .kinematic_edge import KinematicEdge, Real, extended, sizes_of, spread_over
from .redundancy import RedundantLoops, redundant_loops

# Corrections of coordinates that constraints determine: each squares the relative error, down to rounding.
_CORRECTIONS = 3


@dataclass(frozen=True)
class FrameKinematics:
    """The tree of a frame and the edges that close its loops, as numbers.

    Attributes
    ----------
    count
        Number of nodes, including the extra ends of edges in the tree of some entries only, which come last.
    shape
        Batch shape of the geometry and of the dependent coordinates.
    bodies
        Nodes that no other carries, with displacements in the axes (..., 1, 3, 3) of a body.
    links
        Edges of the tree, parents first, then those that close a loop.
    dependents
        By coordinate that loop-closing ideal components determine: its row over the unknowns, and by (number of the
        link, component) the factor with which the error in that component corrects it. An unknown with a row of its
        own stands for other coordinates at the entries at which the row says so.
    idle
        By unknown, one at entries at which it stands for no coordinate, zero at the others.
    redundant
        Loops with redundant ideal components.
    """

    count: int
    shape: tuple[int, ...]
    bodies: list[tuple[Index, Real]]
    links: list[KinematicEdge]
    dependents: Dependents
    idle: dict[int, Real]
    redundant: list[RedundantLoops]

    @classmethod
    def of(cls, plan: Plan, determinate: Sequence[KinematicEdge] = (), entries: Entries = WHOLE) -> FrameKinematics:
        """Kinematics of a frame in extended precision.

        Parameters
        ----------
        plan
            The compiled frame.
        determinate
            Members one end of which carries the other, as links, at the entries.
        entries
            The entries of the batch.
        """
        tree, topology = plan.tree, plan.topology
        carried = {branch.child for branch in tree.branches} | {link.child for link in determinate}
        own: dict[str, list[int]] = {}
        for node, body in enumerate(topology.bodies):
            if body is not None and node not in carried:
                own.setdefault(body, []).append(node)
        bodies = [
            (np.array(nodes), extended(entries(np.asarray(topology.axes(nodes[0])), 2))[..., None, :, :])
            for nodes in own.values()
        ]
        link = partial(_link, plan, entries)
        links = [link(branch.edge, branch.sign) for branch in tree.branches]
        links = _parents_first([*links, *determinate]) if determinate else links
        exchanged, closures = exchanged_links(len(topology.number), [link(e, 1.0) for e in tree.exchanged])
        links += exchanged
        links += [link(edge, 0.0) for edge, _ in tree.closing if edge not in tree.exchanged]
        links += closures
        dependents = _at(dependent_coordinates(tree, links), entries)
        idle = {key: entries(np.asarray(where), 0) for key, where in tree.elimination.idle.items()}
        redundant = redundant_loops(plan, links, entries)
        count = len(topology.number) + len(exchanged)
        return cls(count, _shape(bodies, links, dependents), bodies, links, dependents, idle, redundant)

    def mapped(self, change: Change) -> FrameKinematics:
        """A copy with `change`, given the number of trailing axes, applied to every array."""

        def each(array: Real | None, trailing: int) -> Real | None:
            return None if array is None else change(array, trailing)

        bodies = [(nodes, change(axes, 3)) for nodes, axes in self.bodies]
        links = [
            replace(link, axes=each(link.axes, 2), arm=each(link.arm, 1), lead=each(link.lead, 0))
            for link in self.links
        ]
        dependents = _at(self.dependents, change)
        idle = {key: change(where, 0) for key, where in self.idle.items()}
        redundant = [loops.mapped(change) for loops in self.redundant]
        shape = _shape(bodies, links, dependents)
        return FrameKinematics(self.count, shape, bodies, links, dependents, idle, redundant)

    # -- coordinates --------------------------------------------------------------------------------------------------

    def coordinates(self, unknowns: Sequence[int], values: Real, imposed: Sequence[Real | None]) -> Real:
        """Coordinates that satisfy all constraints and imposed displacements.

        Parameters
        ----------
        unknowns
            Numbers of the free coordinates (n,).
        values
            Their values (..., n).
        imposed
            By link: displacement (..., 6) imposed on it, in its axes; None for none.

        Returns
        -------
        ndarray
            (..., nodes, 6).
        """
        given = [each.shape[:-1] for each in imposed if each is not None]
        shape = np.broadcast_shapes(values.shape[:-1], self.shape, *given)
        out = np.zeros((*shape, 6 * self.count), values.dtype)
        out[..., list(unknowns)] = values
        self._determine(out)
        out = out.reshape(*shape, self.count, 6)
        for link, offset in zip(self.links, imposed, strict=True):
            if offset is not None and link.sign:
                out[..., link.child, :] += offset
        for _ in range(_CORRECTIONS):
            self._correct(out, imposed)
        return out

    def reduced(self, unknowns: Sequence[int], forces: Real) -> Real:
        """Forces (..., n) on the free coordinates for forces (..., nodes, 6) on all.

        It is the transpose of `coordinates`: forces on constrained and dependent coordinates are included, with the
        corrections of both, as a virtual displacement of an unknown moves them by the rounding of the axes.
        """
        if not self.dependents and not self._rotated:
            taken: Real = merged(forces, -2, -1)[..., list(unknowns)]
            return taken
        forces = self._corrected_forces(forces)
        taken = self.gathered(merged(forces, -2, -1), lambda factor: factor)[..., list(unknowns)]
        return taken

    def gathered(self, flat: Real, weight: Callable[[Real], Real]) -> Real:
        """Forces (..., 6 nodes) on all coordinates, with those on dependent ones, times a `weight` of their rows, added
        to the coordinates from which these follow, in place."""
        own = {key: flat[..., key].copy() for key in self._standing}
        for key in own:
            flat[..., key] = 0.0
        for key, (row, _) in self.dependents.items():
            force = own.get(key)
            for k, factor in row.items():
                flat[..., k] += weight(factor) * (flat[..., key] if force is None else force)
        return flat

    def _determine(self, flat: Real) -> None:
        """Put dependent coordinates in among all (..., 6 nodes), from the unknowns there."""
        values = {key: flat[..., key].copy() for key in self._standing}
        for key in values:
            flat[..., key] = 0.0
        for key, (row, _) in self.dependents.items():
            for k, factor in row.items():
                flat[..., key] += factor * values.get(k, flat[..., k])

    @cached_property
    def _standing(self) -> list[int]:
        """Unknowns that stand for other coordinates at some entries."""
        met = {key for row, _ in self.dependents.values() for key in row}
        return [key for key in self.dependents if key in met]

    @property
    def _rotated(self) -> list[tuple[int, KinematicEdge]]:
        """Edges of the tree with ideal components in axes of their own, with their numbers."""
        return [
            (k, link) for k, link in enumerate(self.links) if link.sign and link.axes is not None and link.edge.ideal
        ]

    def _corrected_forces(self, forces: Real) -> Real:
        """The transpose of `_correct`, for forces (..., nodes, 6) on the coordinates."""
        generalised_forces: list[Real | None] = [None] * len(self.links)
        flat = merged(forces, -2, -1)
        for key, (_, by) in self.dependents.items():
            for (k, component), factor in by.items():
                generalised_force = -(factor * flat[..., key])[..., None] * np.eye(6)[component]
                before = generalised_forces[k]
                generalised_forces[k] = generalised_force if before is None else before + generalised_force
        out = np.array(forces)
        if self.dependents:
            out = out + self.generalised(np.zeros((self.count, 6), forces.dtype), generalised_forces)
        for _, link in self._rotated:
            constrained = np.where(np.isin(np.arange(6), link.edge.ideal), out[..., link.child, :], 0.0)
            out[..., link.child, :] -= link.worked(link.into(link.out(link.exerted(constrained)))) - constrained
        return out

    def _correct(self, coordinates: Real, imposed: Sequence[Real | None]) -> None:
        for k, link in self._rotated:
            constrained = list(link.edge.ideal)
            # the given axes are orthonormal to rounding only
            found = link.rest(link.into(link.out(link.whole(coordinates[..., link.child, :]))))
            wanted = imposed[k]
            gap = found[..., constrained] if wanted is None else found[..., constrained] - wanted[..., constrained]
            coordinates[..., link.child, constrained] -= gap
        if not self.dependents:
            return
        relative_displacements = self.relative_displacements(coordinates, self.displacements(coordinates))
        gaps = {}
        for k, component in {where for _, by in self.dependents.values() for where in by}:
            wanted = imposed[k]
            gap = relative_displacements[k][..., component]
            gaps[k, component] = gap if wanted is None else gap - wanted[..., component]
        flat = merged(coordinates, -2, -1)
        for key, (_, by) in self.dependents.items():
            for where, factor in by.items():
                flat[..., key] += factor * gaps[where]

    # -- displacements ------------------------------------------------------------------------------------------------

    def displacements(self, coordinates: Real) -> Real:
        """Displacements of the nodes in global axes, (..., nodes, 6), from their coordinates."""
        shape = np.broadcast_shapes(coordinates.shape[:-2], self.shape)
        out = np.array(np.broadcast_to(coordinates, (*shape, self.count, 6)))
        for nodes, axes in self.bodies:
            out[..., nodes, :] = rotated(axes, out[..., nodes, :])
        for link in self.links:
            if link.sign and not link.alone:
                own = link.sign * link.out(link.whole(out[..., link.child, :]))
                if link.parent != GROUND:
                    own = own + link.carry(out[..., link.parent, :], link.sign)
                out[..., link.child, :] = own
        return out

    def relative_displacements(self, coordinates: Real, displacements: Real) -> list[Real]:
        """By link: displacement (..., 6) of the second node from the first in its axes, less a screw's advance."""
        out = []
        for link in self.links:
            if link.sign:
                own = coordinates[..., link.child, :]
                out.append(own if link.axes is None else link.rest(link.into(link.out(link.whole(own)))))
            else:
                second = displacements[..., link.second, :]
                if link.first != GROUND:
                    second = second - link.carry(displacements[..., link.first, :], 1.0)
                out.append(link.rest(link.into(second)))
        return out

    def sizes(self, coordinates: Real) -> Real:
        """Sizes of the displacements, (..., nodes, 6), in double precision."""
        return self._sizes(self._magnitudes(coordinates))

    def displacement_sizes(self, coordinates: Real, sizes: Real) -> list[Real]:
        """By link: sizes of the relative displacements, (..., 6)."""
        return self._displacement_sizes(self._magnitudes(coordinates), sizes)

    def _magnitudes(self, coordinates: Real) -> Real:
        """Sizes of the coordinates; for those that constraints determine, including the terms of the constraints."""
        shape = np.broadcast_shapes(coordinates.shape[:-2], self.shape)
        out = np.array(np.broadcast_to(np.abs(coordinates).astype(np.float64), (*shape, self.count, 6)))
        if self.dependents:
            relative_displacements = self._displacement_sizes(out, self._sizes(out))
            flat = merged(out, -2, -1)
            for key, (_, by) in self.dependents.items():
                for (k, component), factor in by.items():
                    flat[..., key] += sizes_of(factor) * relative_displacements[k][..., component]
        return out

    def _sizes(self, magnitudes: Real) -> Real:
        out: Real = magnitudes.copy()
        for nodes, axes in self.bodies:
            out[..., nodes, :] = rotated(sizes_of(axes), out[..., nodes, :])
        for link in self.links:
            if link.sign:
                own = link.spread(out[..., link.child, :])
                own = own if link.axes is None else rotated(sizes_of(link.axes), own)
                if link.parent != GROUND:
                    own = own + spread_over(out[..., link.parent, :], link.arm)
                out[..., link.child, :] = own
        return out

    def _displacement_sizes(self, magnitudes: Real, sizes: Real) -> list[Real]:
        out = []
        for link in self.links:
            if link.sign:
                own = link.spread(magnitudes[..., link.child, :])
                own = own if link.axes is None else rotated(sizes_of(link.axes), own)
            else:
                own = sizes[..., link.second, :]
                if link.first != GROUND:
                    own = own + spread_over(sizes[..., link.first, :], link.arm)
            out.append(
                link.spread(own if link.axes is None else rotated(np.swapaxes(sizes_of(link.axes), -1, -2), own))
            )
        return out

    # -- forces -------------------------------------------------------------------------------------------------------

    def generalised(self, forces: Real, generalised_forces: Sequence[Real | None]) -> Real:
        """Forces (..., nodes, 6) on the coordinates.

        Parameters
        ----------
        forces
            Forces on the nodes, global, (..., nodes, 6).
        generalised_forces
            By link: force (..., 6) conjugate to its relative displacement; None for none.
        """
        shapes = [
            generalised_force.shape[:-1] for generalised_force in generalised_forces if generalised_force is not None
        ]
        shape = np.broadcast_shapes(forces.shape[:-2], self.shape, *shapes)
        out = np.array(np.broadcast_to(forces, (*shape, self.count, 6)))
        for link, generalised_force in zip(self.links, generalised_forces, strict=True):
            if not link.sign and generalised_force is not None:
                force = link.out(link.exerted(generalised_force))
                out[..., link.second, :] += force
                if link.first != GROUND:
                    out[..., link.first, :] -= link.transfer(force, 1.0)
        for link, generalised_force in zip(reversed(self.links), reversed(list(generalised_forces)), strict=True):
            if link.sign:
                force = out[..., link.child, :]
                if link.parent != GROUND:
                    out[..., link.parent, :] += link.transfer(force, link.sign)
                own = link.sign * link.into(force)
                if generalised_force is not None:
                    own = own + link.into(link.out(link.exerted(generalised_force)))
                out[..., link.child, :] = link.worked(own)
        for nodes, axes in self.bodies:
            out[..., nodes, :] = rotated(np.swapaxes(axes, -1, -2), out[..., nodes, :])
        return out


def _link(plan: Plan, entries: Entries, edge: Edge, sign: float) -> KinematicEdge:
    axes = None if edge.axes is None else extended(entries(edge.axes, 2))
    arm = None
    if edge.kind == "rigid":
        names = plan.topology.names
        arm = entries(position(plan, names[edge.second]) - position(plan, names[edge.first]), 1)
    lead = None if is_zero(edge.pitch) or edge.name is None else entries(_lead(plan, edge.name), 0)
    return KinematicEdge(edge, edge.first, edge.second, sign, axes, arm, lead)


def _at(dependents: Dependents, change: Change) -> Dependents:
    return {
        key: ({k: change(v, 0) for k, v in row.items()}, {k: change(v, 0) for k, v in by.items()})
        for key, (row, by) in dependents.items()
    }


def _lead(plan: Plan, joint: str) -> Real:
    """Advance of a screw per radian, in extended precision, with all batch axes."""
    turn = 8.0 * np.arctan(extended(1.0))
    return aligned(extended(plan.frame.joints[joint].element.pitch) / turn, len(plan.frame.shape))


def _parents_first(links: list[KinematicEdge]) -> list[KinematicEdge]:
    by_parent: dict[int, list[KinematicEdge]] = {}
    for link in links:
        by_parent.setdefault(link.parent, []).append(link)
    children = {link.child for link in links}
    queue = [node for node in by_parent if node not in children]
    out: list[KinematicEdge] = []
    for node in queue:
        out += by_parent.get(node, [])
        queue += [link.child for link in by_parent.get(node, [])]
    return out


def position(plan: Plan | Unloaded, name: str) -> Real:
    """Position of a described node in extended precision, (..., 3), with all batch axes."""
    at = plan.frame.nodes[name]
    place = extended(at.coordinates)
    if at.body is not None:
        body = plan.frame.bodies[at.body]
        place = extended(body.origin) + rotated(extended(body.axes), place)
    return aligned(place, len(plan.frame.shape), 1)


def _shape(bodies: list[tuple[Index, Real]], links: list[KinematicEdge], dependents: Dependents) -> tuple[int, ...]:
    """Batch shape of a geometry and of its dependent coordinates."""
    shapes = [axes.shape[:-3] for _, axes in bodies]
    shapes += [link.axes.shape[:-2] for link in links if link.axes is not None]
    shapes += [link.arm.shape[:-1] for link in links if link.arm is not None]
    shapes += [link.lead.shape for link in links if link.lead is not None]
    shapes += [value.shape for each in dependents.values() for part in each for value in part.values()]
    return np.broadcast_shapes(*shapes)
