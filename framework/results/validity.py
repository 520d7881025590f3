"""How far the displaced shape of a linear solution is from equilibrium: whether linear mechanics holds.

In the displaced shape the internal forces of each member go with its chord. What they leave unbalanced at the nodes,
``g = sum over members of psi x f`` with the rotation psi of the chord, would move the frame by ``K^-1 g``: the first
step of an iteration to large displacement, with f taken as dead. Its size in the energy norm over that of the solution,
``sqrt(g . K^-1 g / u . K u)``, is the relative error by which the linear result is off, to first order; and a chord
that turns by psi draws its end back by half of psi times what it moves (Crisfield, *Non-linear Finite Element Analysis
of Solids and Structures* 1, 1991, ch. 7, for the forces that go with the chord). The displaced shape includes what
journals move within their clearances, which turns links however small the load is.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..batch import Array
from ..error_bounds.deformations import Springs
from ..error_bounds.kinematics import Real

if TYPE_CHECKING:
    from ..error_bounds.bounds import Part
    from ..solution import Solution

# Relative error above which a linear result is not one to be printed.
LINEAR = 0.05


def nonlinearity(solution: Solution) -> Array:
    """Estimated relative error of a linear solution by its being linear, (...); inf where it is a mechanism."""
    out = np.zeros(solution.shape)
    with np.errstate(all="ignore"):  # of mechanisms
        for part in solution.bounds.parts():
            out[part.where] = _of(part)
    out[solution.own_status == "mechanism"] = np.inf
    return out


def _of(part: Part) -> Real:
    state, compliance = part.state, part.compliance
    count = state.kinematics.count
    unbalanced: Any = np.zeros((count, 6))
    largest: Any = 0.0
    energy: Any = 0.0
    for springs, pull, found in zip(state.springs, state.member_pulls, state.deformations, strict=True):
        turn = _rotation(springs, state.displacements)
        forces = np.einsum("...nij,...ni->...nj", springs.rows, pull)
        split = forces.reshape(*forces.shape[:-1], 4, 3)
        swung = np.cross(turn[..., None, :], split).reshape(forces.shape)
        unbalanced = unbalanced - springs.gathered(swung, count)
        largest = np.maximum(largest, np.sum(turn * turn, axis=-1).max(axis=-1))
        energy = energy + np.sum(pull * found, axis=(-1, -2))
    for k, pull in zip(state.stiffness, state.pulls, strict=True):
        energy = energy + np.sum(np.where(k > 0.0, pull * pull / np.where(k > 0.0, k, 1.0), 0.0), axis=-1)
    none: list[Real | None] = [None] * len(state.kinematics.links)
    load = state.kinematics.reduced(state.unknowns, state.kinematics.generalised(unbalanced, none))
    work = np.sum(load * compliance.solve(load.astype(compliance.root.dtype)), axis=-1)
    ratio = np.sqrt(np.maximum(work, 0.0) / np.where(energy > 0.0, energy, 1.0))
    out: Real = np.maximum(np.where(energy > 0.0, ratio, 0.0), 0.5 * np.sqrt(largest))
    return out


def _rotation(springs: Springs, displacements: Real) -> Real:
    """Rotation of the chords, and twist, of members, (..., n, 3)."""
    ends = displacements[..., springs.nodes, :]
    along = springs.level[..., 0, :]
    apart = ends[..., 1, :3] - ends[..., 0, :3]
    twist = np.sum(along * (ends[..., 0, 3:] + ends[..., 1, 3:]), axis=-1, keepdims=True) / 2.0
    out: Real = np.cross(along, apart) / springs.length[..., None] + twist * along
    return out
