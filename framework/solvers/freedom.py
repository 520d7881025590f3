"""Free motions of a large frame, and the factor of its stiffness with one unknown constrained for each of them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from ..arm import carrying
from ..batch import Array
from ..batched.unloaded import Unloaded
from ..structure.topology import Index
from .factor import Factor

# Largest number of searches for further motions, with the known ones constrained.
_ROUNDS = 8

Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class Freedom:
    """Free motions.

    Attributes
    ----------
    motions
        Values of the unknowns in each motion, (n, motions).
    constrained
        Mask of unknowns, one for each motion, whose constraint prevents all motions, (n,).
    factor
        Factor of the matrix without these unknowns; None where not all motions were found.
    """

    motions: Array
    constrained: Mask
    factor: Factor | None


def freedom(
    unsupported_motions: Array, factor: Callable[[Mask], Factor], direct: Callable[[Mask], Callable[..., Factor]]
) -> Freedom:
    """All free motions of n unknowns: those of unsupported parts, and those found when they are constrained.

    Parameters
    ----------
    unsupported_motions
        Rigid motions of unsupported parts, (n, m).
    factor
        Function that factorises the matrix of the unknowns in a mask (n,).
    direct
        Function that, for a mask (n,), returns the function to factorise a shifted matrix of these unknowns.
    """
    motions = unsupported_motions
    constrained = np.zeros(len(unsupported_motions), dtype=bool)
    constrained[constrained_unknowns(_orthonormal(unsupported_motions).T)] = True
    for _ in range(_ROUNDS):
        kept = ~constrained
        if not kept.any():
            return Freedom(motions, constrained, None)
        rest = factor(kept)
        if not rest.singular:
            return Freedom(motions, constrained, rest)
        found = rest.motions(direct(kept))
        if not found.shape[1]:
            break
        more = np.zeros((len(constrained), found.shape[1]))
        more[kept] = found
        motions = np.hstack([motions, more])
        constrained[np.flatnonzero(kept)[constrained_unknowns((found / rest.root[:, None]).T)]] = True
    return Freedom(motions, constrained, None)


def constrained_unknowns(motions: Array) -> Index:
    """Numbers (r,) of unknowns whose constraint prevents all of r motions (r, n), where the motions are largest."""
    return np.asarray(scipy.linalg.qr(motions, mode="r", pivoting=True)[1][: len(motions)], dtype=np.int64)


def unsupported_motions(plan: Unloaded) -> Array:
    """Rigid motions (n, 6 parts) of the unsupported parts of a frame, from the topology alone.

    Parts with a tie, or with a member on an elastic foundation, are left out: these may resist rigid motion.
    """
    topology, tree, graph = plan.topology, plan.tree, plan.graph
    links, label = graph.links, plan.connected_components
    if not len(links.unsupported):
        return np.zeros((len(graph.unknown), 0))
    floats = np.zeros(label.max(initial=-1) + 1, dtype=bool)
    floats[links.unsupported] = True
    for group in topology.groups:
        if group.resists:
            floats[label[group.nodes[:, 0]]] = False
    if not floats.any():
        return np.zeros((len(graph.unknown), 0))
    own = np.ones(len(topology.number), dtype=bool)
    own[[branch.child for branch in tree.branches]] = False
    columns = []
    for part in np.flatnonzero(floats):
        nodes = np.flatnonzero((label == part) & own)
        at = np.flatnonzero(np.isin(graph.node, nodes))
        if at.size:
            column = np.zeros((len(graph.unknown), 6))
            column[at] = _rigid(plan, nodes)[np.searchsorted(nodes, graph.node[at]), graph.unknown[at] % 6]
            columns.append(column)
    return np.hstack(columns) if columns else np.zeros((len(graph.unknown), 0))


def _rigid(plan: Unloaded, nodes: Index) -> Array:
    """Displacements (nodes, 6, 6) in the nodes' axes per unit of the six rigid motions about the nodes' centre."""
    points = plan.graph.points[nodes]
    arm = points - points.mean(axis=0)
    size = float(np.abs(arm).max(initial=0.0)) or 1.0
    out = carrying(arm)
    out[..., 3:] /= size
    for place, node in enumerate(nodes):
        axes = plan.topology.axes(int(node))
        if axes is not None:
            back = np.asarray(axes, dtype=np.float64).reshape(-1, 3, 3)[0].T
            out[place] = np.kron(np.eye(2), back) @ out[place]
    return out


def _orthonormal(motions: Array) -> Array:
    return np.linalg.qr(motions)[0] if motions.shape[1] else motions
