"""Joint forces under unit loads, which by virtual work are derivatives by misalignments of the joints.

With locked drives, let the second link of a joint be displaced by d from its place in the ideal joint. By virtual work
the displacement of a point in the direction of a unit load there is ``u = f . d``, with the force f in the joint that
balances the load. One solution for the load, with the transposed Jacobian of the loop closure, serves all joints
(Innocenti, Journal of Mechanical Design 124, 2002, for clearances of spatial structures).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ....framework.arm import transferred
from ....framework.batch import Array
from ..description.joints import COMPONENTS
from ..description.parts import GROUND, Pair
from ..kinematics.dimensions import by_component
from ..kinematics.linear import by_singular_values, stacked_solve
from ..poses.classified import ClassifiedPoses
from ..poses.singular import SINGULAR

# Share of a load left unbalanced above which the load has no equilibrium.
IDLE = 1e-6


@dataclass(frozen=True, eq=False)
class JointPlace:
    """A joint's point on its second link (..., 3), in units of the linkage's size, and its axes (..., 3, 3)."""

    point: Array
    axes: Array

    def components(self, wrench: Array) -> Array:
        """Wrenches (..., k, 6) about the joint's point in its axes, from global ones (..., k, 6) about the origin."""
        here = transferred(wrench, -self.point[..., None, :])
        return np.concatenate([here[..., :3] @ self.axes, here[..., 3:] @ self.axes], axis=-1)


class VirtualWork:
    """Equilibrium of a linkage with locked drives under loads on its links; lengths are in units of its size.

    Parameters
    ----------
    motion
        The motion, (...).

    Attributes
    ----------
    regular
        Poses at which loads have finite reactions: assembled, and no dead point, (...).
    """

    def __init__(self, motion: ClassifiedPoses) -> None:
        self.motion, self.mechanism = motion, motion.mechanism
        self.regular = motion.is_assembled & ~(motion.conditioning < SINGULAR)
        self.origin = self.mechanism.bodies[GROUND].place
        tree = self.mechanism.tree
        self.signs = {branch.edge.name: branch.sign for branch in tree.branches}
        self.ways: dict[str, dict[str, float]] = {GROUND: {}}
        for branch in tree.branches:
            self.ways[branch.child] = self.ways[branch.parent] | {branch.edge.name: self.signs[branch.edge.name]}

    def place(self, point: Array) -> Array:
        """A global position (..., 3) in units of the size; zero where the pose is not regular."""
        return np.where(self.regular[..., None], (point - self.origin) / by_component(self.mechanism.size), 0.0)

    @cached_property
    def places(self) -> dict[str, JointPlace]:
        """Point and axes of each joint, by name."""
        motion, regular = self.motion, self.regular[..., None, None]
        return {
            name: JointPlace(
                self.place(motion.position(pair.point, pair.second)),
                np.where(regular, motion.joint_axes(name), np.eye(3)),
            )
            for name, pair in motion.linkage.joints.items()
        }

    def at_point(self, position: Array) -> Array:
        """Wrenches about the origin of unit forces and moments at a global position, one a row, (..., 6, 6)."""
        return transferred(np.eye(6), self.place(position)[..., None, :])

    def joint_forces(self, loads: Mapping[str, Array]) -> dict[str, Array]:
        """Forces and moments of the joints that balance the loads, in the joints' axes, (..., k, 6) by name.

        Parameters
        ----------
        loads
            By link: forces and moments (..., k, 6) about the origin, of k load cases.
        """
        tree = self._through_tree(loads)
        rows = self._row_forces(tree)
        cut = {link: wrench for link, wrench in self._on_links(rows).items() if link != GROUND}
        through_cuts = self._through_tree(cut) if cut else {}
        return self._with_cuts({name: force + through_cuts.get(name, 0.0) for name, force in tree.items()}, rows)

    def self_stresses(self) -> dict[str, Array]:
        """By joint: forces and moments in its axes, (..., s, 6), of s independent states of self-stress.

        There is one for each redundant constraint, those included on which no coordinate acts.
        """
        count, every = self.redundant, len(self.mechanism.rows)
        rows = np.broadcast_to(np.eye(every), (*self.regular.shape, every, every))
        if self.mechanism.unknown:
            rows = np.linalg.svd(self._transposed, full_matrices=True)[2][..., every - count :, :]
        through = self._through_tree({link: wrench for link, wrench in self._on_links(rows).items() if link != GROUND})
        none = np.zeros((*self.regular.shape, count, 6))
        return self._with_cuts({name: through.get(name, none) for name in self.signs}, rows)

    # -- equations --------------------------------------------------------------------------------------------------

    @property
    def redundant(self) -> int:
        """Number of redundant closing equations."""
        return len(self.mechanism.rows) - self.motion.assembly.loops.linear.rank

    def _through_tree(self, loads: Mapping[str, Array]) -> dict[str, Array]:
        """Force and moment of each joint of the tree from loads on all links beyond it, in its axes, (..., k, 6)."""
        total: dict[str, Array] = {}
        for link, wrench in loads.items():
            for name, sign in self.ways[link].items():
                total[name] = total[name] + sign * wrench if name in total else sign * wrench
        shape = np.broadcast_shapes(*(wrench.shape for wrench in loads.values()))
        return {
            name: self.places[name].components(total[name]) if name in total else np.zeros(shape) for name in self.signs
        }

    @cached_property
    def _closing(self) -> list[tuple[Pair, slice, Array]]:
        """Joints that close loops, their rows, and the unit wrench of each row about the origin, (..., rows, 6)."""
        out, start = [], 0
        for pair in self.mechanism.tree.cuts:
            constrained = pair.kind.constrained
            out.append((pair, slice(start, start + len(constrained)), self._row_wrenches(pair, constrained)))
            start += len(constrained)
        return out

    def _row_wrenches(self, pair: Pair, constrained: tuple[str, ...]) -> Array:
        """Unit wrenches about the origin, (..., rows, 6), in the directions of the mechanism's closing equations."""
        place = self.places[pair.name]
        axes = place.axes
        if pair.first in self.mechanism.tree.twins:
            axes = np.where(self.regular[..., None, None], self.motion.axes(pair.second), np.eye(3)) @ pair.axes
        forces = axes
        if sum(name[0] == "u" for name in constrained) == 3:
            forces = np.broadcast_to(self.mechanism.bodies[GROUND].reference_axes, axes.shape)
        wrenches = np.zeros((*self.regular.shape, len(constrained), 6))
        for row, name in enumerate(constrained):
            part, k = divmod(COMPONENTS.index(name), 3)
            wrenches[..., row, 3 * part : 3 * part + 3] = (axes if part else forces)[..., k]
        return transferred(wrenches, place.point[..., None, :])

    def _on_links(self, rows: Array) -> dict[str, Array]:
        """Wrenches (..., k, 6) on the links joined by the closing joints, from forces in their rows (..., k, rows)."""
        out: dict[str, Array] = {}
        for pair, own, wrenches in self._closing:
            wrench = rows[..., own] @ wrenches
            for link, sign in ((pair.second, 1.0), (pair.first, -1.0)):
                out[link] = out[link] + sign * wrench if link in out else sign * wrench
        return out

    def _with_cuts(self, out: dict[str, Array], rows: Array) -> dict[str, Array]:
        """Add to the forces in the tree's joints those in the closing joints, from their rows (..., k, rows)."""
        for pair, own, wrenches in self._closing:
            if pair.name not in out:
                out[pair.name] = -self.places[pair.name].components(rows[..., own] @ wrenches)
        return out

    def _coordinates(self, forces: Mapping[str, Array]) -> Array:
        """Force on each coordinate that is not driven, (..., k, unknowns), from the forces in the tree's joints."""
        return np.stack([self._on_coordinate(forces, *self.mechanism.columns[k]) for k in self.mechanism.unknown], -1)

    def _on_coordinate(self, forces: Mapping[str, Array], joint: str, component: str) -> Array:
        force = forces[joint]
        along = force[..., COMPONENTS.index(component)]
        pair = self.motion.linkage.joint(joint)
        if pair.pitch is None:
            return along
        lead = pair.pitch / (2.0 * np.pi * self.mechanism.size)
        return np.asarray(along + lead[..., None] * force[..., COMPONENTS.index("uz")])

    @cached_property
    def _transposed(self) -> Array:
        """Transposed Jacobian: force on each unknown coordinate by a unit force in each row, (..., unknowns, rows)."""
        units = np.broadcast_to(
            np.eye(len(self.mechanism.rows)), (*self.regular.shape, *2 * (len(self.mechanism.rows),))
        )
        loads = {link: wrench for link, wrench in self._on_links(units).items() if link != GROUND}
        return np.swapaxes(self._coordinates(self._through_tree(loads)), -1, -2)

    def _row_forces(self, tree: Mapping[str, Array]) -> Array:
        """Forces in the closing rows that balance the forces on the coordinates, (..., k, rows)."""
        shape = next(iter(tree.values())).shape[:-1]
        out = np.zeros((*shape, len(self.mechanism.rows)))
        active, linear = self.mechanism.active, self.motion.assembly.loops.linear
        if not active or not self.mechanism.unknown:
            return out
        matrix = self._transposed[..., active]
        matrix = np.where(self.regular[..., None, None], matrix, np.eye(*matrix.shape[-2:]))
        right = -np.swapaxes(self._coordinates(tree), -1, -2)
        if linear.square:
            found = stacked_solve(matrix, right)
        else:
            found = by_singular_values(matrix, right, linear.rank)
            # idle motions, such as the spin of a rod between two spherical joints, cannot balance a load
            left = np.linalg.norm(matrix @ found - right, axis=-2, keepdims=True)
            found = np.where(left > IDLE * np.linalg.norm(right, axis=-2, keepdims=True), np.nan, found)
        out[..., active] = np.swapaxes(found, -1, -2)
        return out
