"""Forces in joints, rigid links, ties and supports of a linear solution, all of them at once."""

from __future__ import annotations

import numpy as np

from ..batch import Array, merged
from ..structure.edge import GROUND
from .deformations import on_nodes
from .equilibrium import EquilibriumResidual
from .kinematic_edge import Real
from .kinematics import FrameKinematics
from .sharing import shared


def link_forces(state: EquilibriumResidual) -> list[Array]:
    """Force and moment of each link on its first node, in its axes, (..., 6), in N and N m.

    Forces of springs follow from their displacements, constraint forces from equilibrium; in the order of
    ``state.kinematics.links``.

    Parameters
    ----------
    state
        The solution in its equations of equilibrium.
    """
    links = zip(state.double.links, working_forces(state), strict=True)
    return [np.asarray(link.exerted(force), dtype=np.float64) for link, force in links]


def working_forces(state: EquilibriumResidual) -> list[Array]:
    """Force conjugate to the relative displacement of each link, (..., 6), in the same order.

    Parameters
    ----------
    state
        The solution in its equations of equilibrium.
    """
    return [np.asarray(force, dtype=np.float64) for force in shared(state.load_shares, _unshared(state))]


def _unshared(state: EquilibriumResidual) -> list[Array]:
    """The same in one state of equilibrium, that of the tree, before redundant components share the load."""
    kinematics = state.double
    generalised_forces = [
        np.asarray(generalised_force, dtype=np.float64) for generalised_force in state.generalised_forces
    ]
    residual = np.asarray(state.residual, dtype=np.float64)
    if kinematics.dependents:
        multipliers = _multipliers(kinematics, residual)
        generalised_forces = [
            generalised_force + multipliers.get(k, 0.0) for k, generalised_force in enumerate(generalised_forces)
        ]
        # The forces that close the loops act on the links of the tree as well.
        constrained: list[Real | None] = [multipliers.get(k) for k in range(len(generalised_forces))]
        nothing = np.zeros((kinematics.count, 6))
        residual = residual - kinematics.generalised(nothing, constrained)
    out = []
    for link, generalised_force in zip(kinematics.links, generalised_forces, strict=True):
        if link.sign and link.edge.ideal:
            ideal = np.isin(np.arange(6), link.edge.ideal)
            generalised_force = np.where(ideal, residual[..., link.child, :], generalised_force)
        out.append(generalised_force)
    return out


def _multipliers(kinematics: FrameKinematics, residual: Array) -> dict[int, Array]:
    """By number of a link that closes a loop, its constraint forces (..., 6)."""
    flat = merged(residual, -2, -1)
    out: dict[int, Array] = {}
    for key, (_, by) in kinematics.dependents.items():
        for (number, component), factor in by.items():
            force = -factor * flat[..., key]
            own = out.setdefault(number, np.zeros((*residual.shape[:-2], 6)))
            if own.shape[:-1] != force.shape:
                own = out[number] = np.array(
                    np.broadcast_to(own, (*np.broadcast_shapes(own.shape[:-1], force.shape), 6))
                )
            own[..., component] += force
    return out


def link_roundings(state: EquilibriumResidual, ends: list[Array]) -> list[Array]:
    """Bound on the rounding error of the forces in links, by link (..., 2): of force and moment.

    Parameters
    ----------
    state
        The solution in its equations of equilibrium.
    ends
        By kind of member, the same for the forces on both ends, (..., n, 2, 2).
    """
    kinematics = state.double
    count = kinematics.count
    flat = [own.reshape(*own.shape[:-2], 4) for own in ends]
    nodal = on_nodes(np.zeros((count, 2)), zip(state.springs, flat, strict=True))
    passed = _passed_on(kinematics, nodal)
    for key, (_, by) in kinematics.dependents.items():
        node, component = divmod(key, 6)
        for (number, constrained), factor in by.items():
            link, size = kinematics.links[number], np.zeros((*passed.shape[:-2], 2))
            size = (
                np.abs(factor)[..., None] * passed[..., node, component // 3, None] * (np.arange(2) == constrained // 3)
            )
            for end in (link.first, link.second):
                if end != GROUND:
                    nodal = nodal + np.where(
                        np.arange(count)[:, None] == end, _moved(size, link.arm)[..., None, :], 0.0
                    )
    passed = _passed_on(kinematics, nodal) if kinematics.dependents else passed
    found = [passed[..., link.child if link.sign else link.second, :] for link in kinematics.links]
    out = list(found)
    forces = _unshared(state) if state.load_shares else []
    for load_share in state.load_shares:
        # the shared forces have errors, and so has the share, relative to the sizes of all shared forces
        own = load_share.rounding[..., None]
        sizes = {n: np.repeat(found[n], 3, axis=-1) + own * np.abs(forces[n]) for n in load_share.place}
        for number in load_share.place:
            more = np.asarray(load_share.sizes(number, sizes), np.float64)
            out[number] = found[number] + more.reshape(*more.shape[:-1], 2, 3).max(axis=-1)
    return out


def _passed_on(kinematics: FrameKinematics, nodal: Array) -> Array:
    """Sizes (..., nodes, 2), with those of all nodes that a node carries added."""
    links = [link for link in kinematics.links if link.sign]
    arms = [link.arm.shape[:-1] for link in links if link.arm is not None]
    shape = np.broadcast_shapes(nodal.shape[:-2], *arms)
    out = np.array(np.broadcast_to(nodal, (*shape, *nodal.shape[-2:])))
    for link in reversed(links):
        if link.parent != GROUND:
            out[..., link.parent, :] += _moved(out[..., link.child, :], link.arm)
    return out


def _moved(size: Array, arm: Real | None) -> Array:
    """Sizes of a force and a moment (..., 2) at the end of an arm, transferred to its root."""
    if arm is None:
        return size
    arm_length = np.linalg.norm(np.asarray(arm, dtype=np.float64), axis=-1)
    moment = size[..., 1] + arm_length * size[..., 0]
    return np.stack([np.broadcast_to(size[..., 0], moment.shape), moment], axis=-1)
