"""How redundant ideal components share the load: with the least sum of squared forces.

Of all forces in equilibrium, those with the least sum of squares over joints and supports are taken, moments being
divided by a length of their loops (`RedundantLoops.length`). This is how joints and supports of equal, high stiffness
share the load if rigid links and ties are stiffer still. It depends on the pose only, neither on the order of the
description nor on which edges close the loops.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ..batch import Array, merged
from ..structure.edge import GROUND
from .kinematic_edge import KinematicEdge, Real
from .kinematics import FrameKinematics
from .redundancy import SHARING, RedundantLoops

# Singular values of states of self-stress of unit size, relative to the largest, below which they count as zero.
_NONE = 1e-11
# Relative smallest singular value above which the states are so independent that their normal equations suffice.
_INDEPENDENT = 1e-3
# Roundings of a share, relative to its size and the square root of its number of terms.
_ROUNDINGS = 4.0


@dataclass(frozen=True)
class LoadShare:
    """The forces in some loops as redundant components share them, as linear functions of any forces in equilibrium.

    Forces are conjugate to the relative displacements of links, see `KinematicEdge`; there are k links and s states of
    self-stress.

    Attributes
    ----------
    place
        By number of a link, its position among the k.
    self_stresses
        Forces in the states of self-stress, (s, ..., k, 6).
    parts
        Factors whose sum of products with any forces is the amount of each state in them, (s, ..., k, 6).
    rounding
        Rounding error of a share, relative to its size, (...).
    """

    place: dict[int, int]
    self_stresses: Real
    parts: Array
    rounding: Array

    def excess(self, forces: Mapping[int, Real]) -> dict[int, Real]:
        """By link: the self-stress in given forces, to be subtracted from them, (..., 6)."""
        amounts = sum(np.sum(self.parts[..., k, :] * forces[link], axis=-1) for link, k in self.place.items())
        amounts = np.asarray(amounts)[..., None]
        return {link: np.sum(self.self_stresses[..., k, :] * amounts, axis=0) for link, k in self.place.items()}

    def sizes(self, link: int, forces: Mapping[int, Real]) -> Real:
        """Size of the self-stress subtracted from a link's force, (..., 6), for given forces (..., 6) by link."""
        parts = np.abs(self.parts)
        amounts = sum(np.sum(parts[..., k, :] * np.abs(forces[each]), axis=-1) for each, k in self.place.items())
        own = np.abs(self.self_stresses[..., self.place[link], :])
        return np.asarray(np.sum(own * np.asarray(amounts)[..., None], axis=0))

    def relative_displacements(self, link: int) -> Iterator[tuple[int, Real]]:
        """Relative displacements (6, ..., 6) of links that, with a unit one of each component of `link`, are compatible
        with all loops: the unit load for the shared force in that component."""
        own = np.moveaxis(self.self_stresses[..., self.place[link], :], -1, 1)[..., None]
        for each, k in self.place.items():
            yield each, -np.sum(own * self.parts[:, None, ..., k, :], axis=0)


def load_shares(kinematics: FrameKinematics) -> list[LoadShare]:
    """The shares in all loops of a frame that have redundant components."""
    return [_sharing(kinematics, loops) for loops in kinematics.redundant]


def shared(found: Sequence[LoadShare], forces: Sequence[Real]) -> list[Real]:
    """Forces by link (..., 6) as redundant components share them, from forces in any equilibrium.

    Parameters
    ----------
    found
        The shares in all loops with redundant components.
    forces
        Forces conjugate to the relative displacements of all links, (..., 6) each; those in springs do not change.
    """
    out = list(forces)
    for load_share in found:
        for link, more in load_share.excess(dict(enumerate(forces))).items():
            out[link] = out[link] - more
    return out


def _sharing(kinematics: FrameKinematics, loops: RedundantLoops) -> LoadShare:
    links = [kinematics.links[k] for k in loops.links]
    stresses = _self_stresses(kinematics, loops)
    ideal = np.array([np.isin(np.arange(6), link.edge.ideal) for link in links])
    weights = np.ones((*loops.length.shape, len(links), 6))
    weights[..., 3:] /= np.asarray(loops.length, np.float64)[..., None, None]
    weights[..., [k for k, link in enumerate(links) if link.edge.kind not in SHARING], :] = 0.0
    weighed = weights * np.asarray(_of_screws(links, stresses, KinematicEdge.exerted), np.float64)
    inverse, condition = _inverse(merged(weighed, -2, -1))
    inverse = weights * inverse.reshape(weighed.shape)
    # for screws, the forces on their coordinates
    parts = np.where(ideal, np.asarray(_of_screws(links, inverse, KinematicEdge.rest), np.float64), 0.0)
    rounding = _ROUNDINGS * np.sqrt(6.0 * len(links)) * np.finfo(np.float64).eps * condition
    return LoadShare({int(k): at for at, k in enumerate(loops.links)}, stresses, parts, rounding)


def _of_screws(links: Sequence[KinematicEdge], forces: Real, change: Callable[[KinematicEdge, Real], Real]) -> Real:
    """Forces (..., k, 6) of links, those of screws transformed by `change`."""
    if all(link.lead is None for link in links):
        return forces
    each = (change(link, forces[..., k, :]) for k, link in enumerate(links))
    return np.stack(np.broadcast_arrays(*each), -2)


def _self_stresses(kinematics: FrameKinematics, loops: RedundantLoops) -> Real:
    """Forces in the states of self-stress, conjugate to the relative displacements of links, (s, ..., k, 6)."""
    links = kinematics.links
    own: dict[int, Real] = {}
    shapes = [value.shape for each in loops.self_stresses for value in each.values()]
    shape = np.broadcast_shapes(kinematics.shape, loops.length.shape, *shapes)
    kind = np.result_type(*(value for each in loops.self_stresses for value in each.values()))
    for number, each in enumerate(loops.self_stresses):
        for (link, component), value in each.items():
            force = own.setdefault(link, np.zeros((len(loops.self_stresses), *shape, 6), kind))
            force[number, ..., component] = value
    nodal: dict[int, Real] = {}
    for k in loops.links:
        if not links[k].sign and k in own:
            force = links[k].out(links[k].exerted(own[k]))
            _add(nodal, links[k].second, force)
            _add(nodal, links[k].first, -links[k].transfer(force, 1.0))
    # forces in closing edges act on the links of the tree as well; children first
    for k in reversed(loops.links):
        if links[k].sign and links[k].child in nodal:
            force = nodal[links[k].child]
            _add(nodal, links[k].parent, links[k].transfer(force, links[k].sign))
            ideal = np.isin(np.arange(6), links[k].edge.ideal)
            own[k] = np.where(ideal, -links[k].worked(links[k].sign * links[k].into(force)), 0.0)
    none = np.zeros((len(loops.self_stresses), *shape, 6), kind)
    return np.stack([own.get(k, none) for k in loops.links], axis=-2)


def _add(nodal: dict[int, Real], node: int, force: Real) -> None:
    """Add a force on a node, unless it is the ground."""
    if node != GROUND:
        nodal[node] = nodal[node] + force if node in nodal else force


def _inverse(weighed: Array) -> tuple[Array, Array]:
    """Pseudo-inverse (s, ..., n) of states of self-stress (s, ..., n), and their condition number, (...)."""
    size = np.sqrt(np.sum(weighed**2, axis=-1, keepdims=True))
    size = np.where(size > 0.0, size, 1.0)
    states = np.where(np.isfinite(weighed), weighed / size, 0.0)  # of absent entries none
    shape, used = states.shape[1:-1], np.flatnonzero(states.reshape(-1, states.shape[-1]).any(axis=0))
    flat = np.moveaxis(states.reshape(len(states), -1, states.shape[-1])[..., used], 0, 1)
    found, condition = _inverted(np.ascontiguousarray(flat))
    out = np.zeros(states.shape)
    out[..., used] = np.moveaxis(found, -1, 0).reshape(len(states), *shape, len(used))
    return out / size, condition.reshape(shape)


def _inverted(states: Array) -> tuple[Array, Array]:
    """Pseudo-inverses (m, n, s) of matrices (m, s, n), and their condition numbers, (m,)."""
    products = states @ np.swapaxes(states, -1, -2)
    # a one on the diagonal for states that vanish at an entry
    at = np.arange(states.shape[1])
    products[:, at, at] += products[:, at, at] == 0.0
    squares = np.linalg.eigvalsh(products)
    good = squares[:, 0] > _INDEPENDENT**2 * squares[:, -1]
    out, condition = np.zeros((len(states), *states.shape[:0:-1])), np.zeros(len(states))
    if good.any():
        some = states if good.all() else states[good]
        found = np.swapaxes(some, -1, -2) @ np.linalg.inv(products if good.all() else products[good])
        # the products have lost digits, which one step of Newton's iteration restores
        out[good] = found + found @ (np.eye(states.shape[1]) - some @ found)
        condition[good] = np.sqrt(squares[good, -1] / squares[good, 0])
    if not good.all():
        left, values, right = np.linalg.svd(states[~good], full_matrices=False)
        kept = values > _NONE * values[..., :1]
        inverse = np.divide(1.0, values, out=np.zeros_like(values), where=kept)
        out[~good] = np.swapaxes(right, -1, -2) * inverse[..., None, :] @ np.swapaxes(left, -1, -2)
        condition[~good] = values[..., 0] * inverse.max(axis=-1)
    return out, condition
