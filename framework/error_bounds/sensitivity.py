"""Derivatives of a result by every input, from one adjoint solve.

With the displacements z under the unit force whose work equals the result R, a change of a spring's stiffness k changes
R by ``-e(z) e(u) dk``; the derivative by a load is the displacement z where it acts, that by an imposed displacement
the force there under the unit force (Choi & Kim, *Structural Sensitivity Analysis and Optimization 1*, 2005, ch. 2).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from ..batch import Array, aligned, rotated
from ..composed import OfAnother
from ..dofs import DISPLACEMENTS, FORCES, component
from ..errors import FrameError
from .adjoint import Adjoint, unit_forces
from .bounds import BoundedResults
from .equilibrium import EquilibriumResidual
from .kinematic_edge import extended
from .member_shapes import MemberWork, by_coordinates, by_rotations, by_sizes
from .requested import checked, requested


@dataclass(frozen=True)
class Sensitivity:
    """Derivatives of one result by the inputs of a frame, each of the batch shape and one for each component.

    Attributes
    ----------
    loads
        By node: by a force and moment on it, ``fx fy fz mx my mz``, (..., 6).
    joints
        By joint: by its six stiffnesses, (..., 6); 0 where ideal.
    offsets
        By joint: by a displacement imposed on it, in its axes, (..., 6).
    supports
        By node: by its prescribed displacements, (..., 6); 0 where they are not prescribed.
    members
        By member: by the relative change of its stiffness in tension, shear along y and z, torsion, bending about
        y and z, (..., 6). Young's modulus E scales all six (nu fixed): their sum is E dR/dE. The moment of inertia
        Iz of a member without shear scales shear along y and bending about z. Of an element of one's own by the
        relative change of each of its springs, in their order, (..., n).
    """

    loads: dict[str, Array]
    joints: dict[str, Array]
    offsets: dict[str, Array]
    supports: dict[str, Array]
    members: dict[str, Array]
    _solution: BoundedResults = field(repr=False)
    _work: MemberWork = field(repr=False)
    _kind: str = field(repr=False)

    @cached_property
    def nodes(self) -> dict[str, Array]:
        """By node: by its coordinates, (..., 3), of a node on a body in its axes.

        Members and rigid links follow their nodes, joints and loads stay as they are. Of nodes that share a place, add
        theirs up.

        Raises
        ------
        FrameError
            If a member has a force at rest, or rigid links close a loop.
        """
        return {name: self._known(value, 1) for name, value in by_coordinates(self._solution.plan, self._work).items()}

    @cached_property
    def sections(self) -> dict[str, dict[str, Array]]:
        """By member that has a section: by each of its sizes, (...), such as ``y``; of a taper's far end ``end.y``.

        Raises
        ------
        FrameError
            If a beam of one's own cannot be made with another section.
        """
        found = by_sizes(self._solution.plan, self._work)
        return {member: {size: self._known(v, 0) for size, v in own.items()} for member, own in found.items()}

    @cached_property
    def bodies(self) -> dict[str, Array]:
        """By moving body: by a small rotation of it about its origin, a vector in global axes, (..., 3).

        Its members and rigid links turn with it; loads and the axes of joints stay as they are.
        """
        return {name: self._known(value, 1) for name, value in by_rotations(self._solution.plan, self._work).items()}

    @cached_property
    def pitches(self) -> dict[str, Array]:
        """By screw joint: by its pitch, (...).

        The spring along z acts on ``uz - pitch rz/(2 pi)``, in the displacements as in those of the adjoint.

        Raises
        ------
        FrameError
            If the result is one of a joint, which may depend on the pitch by itself.
        """
        if self._kind.startswith("joint"):
            raise FrameError("sensitivity of a joint's own result to pitches: ask for a displacement")
        solution, out = self._solution, {}
        for name, joint in solution.plan.frame.joints.items():
            if np.any(joint.element.pitch):
                apart = rotated(np.swapaxes(self._axes(name), -1, -2), self._apart(name))[..., 5]
                work = solution.joint_force(name)[..., 2] * apart
                work = work + self.offsets[name][..., 2] * solution.joint_displacement(name)[..., 5]
                out[name] = self._known(work / (2.0 * np.pi), 0)
        return out

    @cached_property
    def joint_axes(self) -> dict[str, Array]:
        """By joint: by a small rotation of its axes alone, a vector in global axes, (..., 3).

        Raises
        ------
        FrameError
            If the result is one of a joint, in whose axes it is.
        """
        if self._kind.startswith("joint"):
            raise FrameError("sensitivity of a joint's own result to the axes of joints: ask for a displacement")
        solution, out = self._solution, {}
        for name in solution.plan.frame.joints:
            axes, apart = self._axes(name), self._apart(name)
            moved = rotated(axes, solution.joint_displacement(name))
            unit = self.offsets[name].copy()
            # A screw's force along z does work on its rotation as well, which the force on an offset does not include.
            unit[..., 5] -= solution.plan.frame.joints[name].element.pitch / (2.0 * np.pi) * unit[..., 2]
            forces = rotated(axes, solution.joint_force(name)), rotated(axes, unit)
            total = np.zeros((*solution.shape, 3))
            for half in (slice(0, 3), slice(3, 6)):
                total = total - np.cross(forces[1][..., half], moved[..., half])
                total = total - np.cross(forces[0][..., half], apart[..., half])
            out[name] = total
        return out

    @cached_property
    def moduli(self) -> dict[str, Array]:
        """By member that has a material: by Young's modulus E, Poisson's ratio being kept, (...).

        Forces that heat would cause in a restrained member, and forms on it, are taken as they are.
        """
        out = {}
        for name, member in self._solution.plan.frame.members.items():
            element = member.element.innermost if isinstance(member.element, OfAnother) else member.element
            material = getattr(element, "material", None)
            if material is not None:
                own = element.springs(np.ones(()))[0].shape[-1]  # those of forms come after them
                out[name] = np.sum(self.members[name][..., :own], axis=-1) / material.E
        return out

    def _axes(self, joint: str) -> Array:
        """Axes of a joint as columns, (..., 3, 3)."""
        axes = self._solution.plan.frame.joints[joint].element.axes
        return np.eye(3) if axes is None else aligned(np.asarray(axes), len(self._solution.shape), 2)

    def _apart(self, joint: str) -> Array:
        """Displacement of a joint's second node relative to the first under the unit load, global, (..., 6)."""
        plan = self._solution.plan
        first, second = (plan.topology.number[node] for node in plan.frame.joints[joint][1:3])
        return np.asarray(self._work.adjoint[..., second, :] - self._work.adjoint[..., first, :])

    def _known(self, value: Array, trailing: int) -> Array:
        movable = self._solution.movable.reshape((*self._solution.movable.shape, *(1,) * trailing))
        return np.where(movable, np.nan, value)


NAMED = ("loads", "joints", "offsets", "supports", "members")


def weighed_sum(found: Sequence[Sensitivity], weights: Array) -> Sensitivity:
    """Derivatives of a weighted sum of results of one kind and solution.

    Parameters
    ----------
    found
        Derivatives of the k results.
    weights
        Weights of the results, (..., k).
    """

    def summed(parts: Sequence[Array]) -> Array:
        axes = parts[0].ndim - weights.ndim + 1
        rows = (np.reshape(weights[..., k], (*weights.shape[:-1], *(1,) * axes)) for k in range(len(parts)))
        return np.asarray(sum(row * part for row, part in zip(rows, parts, strict=True)))

    def by_name(parts: Sequence[Mapping[Any, Array]]) -> dict[Any, Array]:
        return {name: summed([each[name] for each in parts]) for name in parts[0]}

    works = [each._work for each in found]
    work = replace(
        works[0],
        adjoint=summed([each.adjoint for each in works]),
        adjoint_forces=by_name([each.adjoint_forces for each in works]),
    )
    named = {kind: by_name([getattr(each, kind) for each in found]) for kind in NAMED}
    return Sensitivity(**named, _solution=found[0]._solution, _work=work, _kind=found[0]._kind)


def sensitivity(solution: BoundedResults, name: str, what: str, kind: str) -> Sensitivity:
    """Derivatives of one component of a result."""
    if checked(kind) == "end_forces":
        raise FrameError("sensitivity of end forces: ask for that of a reaction, a joint force or a displacement")
    index = component(what, FORCES if kind in ("reaction", "joint_force") else DISPLACEMENTS)
    # A result has derivatives by loads and offsets even if all of these are zero and no unknown was solved for.
    solution = solution.reaching(_unknowns_of_result(solution, name, kind, index))
    getattr(solution, kind)(name)  # warns of what can move though no load makes it
    out: dict[tuple[str, str], Array] = {}
    work = MemberWork.empty(solution.bounds.statics, solution.shape)
    for where, adjoint in solution.bounds.influence(name, kind, index):
        constrained = adjoint.constrained(0)
        work.enter(where, adjoint, 0, constrained)
        for key, value in _derivatives(adjoint, name, kind, index, constrained):
            out.setdefault(key, np.zeros((*solution.shape, value.shape[-1])))[where] = value
    singular = solution.movable
    for value in out.values():
        value[singular] = np.nan
    named = {kind: {name: v for (k, name), v in out.items() if k == kind} for kind in NAMED}
    return Sensitivity(**named, _solution=solution, _work=work, _kind=kind)


def _derivatives(
    adjoint: Adjoint, name: str, kind: str, index: int, constrained: list[Array]
) -> Iterator[tuple[tuple[str, str], Any]]:
    """Derivatives by name, (..., 6), from the adjoint of the result's component `index` alone."""
    state = adjoint.state
    plan, links = state.plan, state.kinematics.links
    moved = adjoint.displacements[0]
    for node in plan.frame.nodes:
        yield ("loads", node), moved[..., plan.topology.number[node], :]
    for member, pieces in plan.topology.pieces_of.items():
        total: Any = 0.0
        for piece in pieces:
            group, at = state.place(piece)
            if np.ndim(total) and np.shape(total)[-1] != state.springs[group].stiffness.shape[-1]:
                raise FrameError(
                    f"sensitivity: parts of member {member!r} have different numbers of springs: divide it into members"
                )
            total = total - adjoint.deformations[group][0][..., at, :] * state.member_forces[group][..., at, :]
        yield ("members", member), total
    for k, link in enumerate(links):
        edge = link.edge
        if edge.name is None:
            continue
        if edge.kind == "support":
            yield ("supports", edge.name), constrained[k]
            continue
        stiffness, relative_displacement = state.stiffness[k], adjoint.relative_displacements[k][0]
        offset = state.imposed[k]
        stretch = state.relative_displacements[k] if offset is None else state.relative_displacements[k] - offset
        own = np.zeros(6)
        if kind == "joint_force" and edge.name == name:
            unit = np.eye(6).reshape(6, *(1,) * state.ndim, 6)
            own = np.moveaxis(link.exerted(unit)[..., index], 0, -1)
        elastic = ~np.isin(np.arange(6), edge.ideal)
        yield ("joints", edge.name), np.where(elastic, (own - relative_displacement) * stretch, 0.0)
        imposed = np.where(elastic, stiffness * (relative_displacement - own), constrained[k])
        yield ("offsets", edge.name), imposed


def _unknowns_of_result(solution: BoundedResults, name: str, kind: str, index: int) -> list[int]:
    """Unknowns on which the unit load of one component of a result acts."""
    unknowns = solution.plan.unknowns
    if not unknowns:
        return []
    found = np.zeros(len(unknowns), dtype=bool)
    none = extended(np.zeros((*(1,) * len(solution.shape), len(unknowns))))
    for cut in solution.bounds.cuts():
        state = EquilibriumResidual(solution.bounds.statics, cut, unknowns, none)
        forces = unit_forces(state, requested(state, name, kind).only((index,)))
        found |= (forces != 0.0).reshape(-1, len(unknowns)).any(axis=0)
    return [unknown for unknown, acting in zip(unknowns, found.tolist(), strict=True) if acting]
