"""Sizes of the forces on coordinates: sums of the magnitudes of their terms, to which rounding is relative.

A member with both ends carried by one node pulls it to both sides; a force along a constrained component does no work
on the others. Such terms cancel, but their rounding errors do not, and these matter if the coordinate is soft.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..batch import merged, rotated
from ..structure.edge import ABOUT, ALONG, GROUND
from .kinematic_edge import KinematicEdge, Real, sheared, sizes_of
from .kinematics import FrameKinematics


def reduced_sizes(
    kinematics: FrameKinematics, unknowns: Sequence[int], forces: Real, generalised_forces: Sequence[Real | None]
) -> Real:
    """Sizes of the forces on the free coordinates, (..., n).

    Parameters
    ----------
    kinematics
        The frame.
    unknowns
        Numbers of the free coordinates (n,).
    forces
        Sizes of the forces on the nodes, global, (..., nodes, 6).
    generalised_forces
        By link: size of the force (..., 6) conjugate to its relative displacement; None for none.
    """
    flat = merged(_on_coordinates(kinematics, forces, generalised_forces), -2, -1)
    if kinematics.dependents:
        flat = flat + merged(
            _on_coordinates(kinematics, np.zeros((kinematics.count, 6)), _closing(kinematics, flat)), -2, -1
        )
    taken: Real = kinematics.gathered(flat, sizes_of)[..., list(unknowns)]
    return taken


def _closing(kinematics: FrameKinematics, flat: Real) -> list[Real | None]:
    """By link: forces on dependent coordinates, transferred to the components that determine these, (..., 6)."""
    out: list[Real | None] = [None] * len(kinematics.links)
    for key, (_, by) in kinematics.dependents.items():
        for (k, component), factor in by.items():
            generalised_force = (sizes_of(factor) * flat[..., key])[..., None] * np.eye(6)[component]
            before = out[k]
            out[k] = generalised_force if before is None else before + generalised_force
    return out


def _on_coordinates(kinematics: FrameKinematics, forces: Real, generalised_forces: Sequence[Real | None]) -> Real:
    """Sizes of the forces on all coordinates, (..., nodes, 6)."""
    shapes = [generalised_force.shape[:-1] for generalised_force in generalised_forces if generalised_force is not None]
    shape = np.broadcast_shapes(forces.shape[:-2], kinematics.shape, *shapes)
    out = np.array(np.broadcast_to(forces, (*shape, kinematics.count, 6)), dtype=np.float64)
    for link, generalised_force in zip(kinematics.links, generalised_forces, strict=True):
        if not link.sign and generalised_force is not None:
            force = _out(link, _exerted(link, generalised_force))
            out[..., link.second, :] += force
            if link.first != GROUND:
                out[..., link.first, :] += _moved(force, link.arm)
    for link, generalised_force in zip(reversed(kinematics.links), reversed(list(generalised_forces)), strict=True):
        if link.sign:
            force = out[..., link.child, :]
            if link.parent != GROUND:
                out[..., link.parent, :] += _moved(force, link.arm)
            own = _into(link, force)
            if generalised_force is not None:
                own = own + _into(link, _out(link, _exerted(link, generalised_force)))
            own = _worked(link, own)
            out[..., link.child, :] = own + _of_constrained(link, own)
    for nodes, axes in kinematics.bodies:
        out[..., nodes, :] = rotated(np.swapaxes(sizes_of(axes), -1, -2), out[..., nodes, :])
    return out


def _of_constrained(link: KinematicEdge, own: Real) -> Real:
    """Part of the force on constrained components that enters the others: axes are orthonormal to rounding only."""
    if link.axes is None or not link.edge.ideal:
        return np.zeros(6)
    constrained = np.where(np.isin(np.arange(6), link.edge.ideal), own, 0.0)
    return _worked(link, _into(link, _out(link, _exerted(link, constrained))))


def _out(link: KinematicEdge, sizes: Real) -> Real:
    return sizes if link.axes is None else rotated(sizes_of(link.axes), sizes)


def _into(link: KinematicEdge, sizes: Real) -> Real:
    return sizes if link.axes is None else rotated(np.swapaxes(sizes_of(link.axes), -1, -2), sizes)


def _worked(link: KinematicEdge, sizes: Real) -> Real:
    return sizes if link.lead is None else sheared(sizes, ABOUT, ALONG, sizes_of(link.lead))


# As sizes, both directions of a screw's transformation add the advance.
_exerted = _worked


def _moved(sizes: Real, arm: Real | None) -> Real:
    """Greatest force and moment at the root of an arm, (..., 6)."""
    if arm is None:
        return sizes
    arm_length = sizes_of(arm).sum(axis=-1, keepdims=True)
    moment = sizes[..., 3:] + arm_length * sizes[..., :3].max(axis=-1, keepdims=True)
    return np.concatenate([np.broadcast_to(sizes[..., :3], moment.shape), moment], axis=-1)
