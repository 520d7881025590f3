"""How a result depends on every input, from one adjoint solve.

With the displacements z under the unit force that does work equal to the result R, a change of a spring's stiffness k
changes R by ``-e(z) e(u) dk``, a change of a load by the displacement z where it acts, and a change of what is imposed
on an edge by the force there under the unit force (Choi & Kim, *Structural Sensitivity Analysis and Optimization 1*,
2005, ch. 2).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..batch import Array
from ..dofs import DISPLACEMENTS, FORCES, component
from ..errors import FrameError
from .adjoint import Adjoint
from .asked import checked
from .bounds import BoundedResults
from .reached import worked_on


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
        By node: by its prescribed displacements, (..., 6); 0 where it is not held.
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


def sensitivity(solution: BoundedResults, name: str, what: str, kind: str) -> Sensitivity:
    """Derivatives of one component of a result.

    Parameters
    ----------
    solution
        A linear solution.
    name
        Node or joint.
    what
        Component, such as ``uy``, or ``fy`` where the result is a force.
    kind
        ``displacement``, ``reaction``, ``joint_displacement`` or ``joint_force``.
    """
    if checked(kind) == "end_forces":
        raise FrameError("sensitivity of end forces: ask for that of a reaction, a joint force or a displacement")
    index = component(what, FORCES if kind in ("reaction", "joint_force") else DISPLACEMENTS)
    # By loads and offsets a result has derivatives even where all of them are zero, and nothing was solved for.
    solution = solution.reaching(worked_on(solution, name, kind, index))
    getattr(solution, kind)(name)  # warns of what can move though no load makes it
    out: dict[tuple[str, str], Array] = {}
    for where, adjoint in solution.bounds.influence(name, kind, index):
        for key, value in _derivatives(adjoint, name, kind, index):
            out.setdefault(key, np.zeros((*solution.shape, value.shape[-1])))[where] = value
    singular = solution.movable
    for value in out.values():
        value[singular] = np.nan
    named = {kind: {name: v for (k, name), v in out.items() if k == kind} for kind in Sensitivity.__annotations__}
    return Sensitivity(**named)


def _derivatives(adjoint: Adjoint, name: str, kind: str, index: int) -> Iterator[tuple[tuple[str, str], Any]]:
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
    held = adjoint.held(0)
    for k, link in enumerate(links):
        edge = link.edge
        if edge.name is None:
            continue
        if edge.kind == "support":
            yield ("supports", edge.name), held[k]
            continue
        stiffness, relative_displacement = state.stiffness[k], adjoint.relative_displacements[k][0]
        offset = state.imposed[k]
        stretch = state.relative_displacements[k] if offset is None else state.relative_displacements[k] - offset
        own = np.zeros(6)
        if kind == "joint_force" and edge.name == name:
            unit = np.eye(6).reshape(6, *(1,) * state.ndim, 6)
            own = np.moveaxis(link.exerted(unit)[..., index], 0, -1)
        sprung = ~np.isin(np.arange(6), edge.ideal)
        yield ("joints", edge.name), np.where(sprung, (own - relative_displacement) * stretch, 0.0)
        imposed = np.where(sprung, stiffness * (relative_displacement - own), held[k])
        yield ("offsets", edge.name), imposed
