"""How redundant ideal components share what they carry: by the least sum of squares.

Of all forces in equilibrium those are taken of which the sum of the squares is least, in joints and supports, moments
being divided by a length of their loops (`RedundantLoops.length`). It is how joints and supports of equal stiffness
share the load, however stiff, beside rigid links and ties that are stiffer still; it depends on the pose alone, and
neither on the order in which things are described nor on which edges close the loops.
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

# Singular values of states of self-stress of unit size, as a share of the largest, below which they are none.
_NONE = 1e-11
# Such a share, of the smallest, above which they are so independent that their products with each other will do.
_INDEPENDENT = 1e-3
# Roundings of a share, of what it is made of, for the root of the number of forces that it is a sum of.
_ROUNDINGS = 4.0


@dataclass(frozen=True)
class LoadShare:
    """The share in some loops, as linear functions of any forces in equilibrium there.

    Forces are those that work on the relative displacements of links, see `KinematicEdge`; k links, s states of
    self-stress.

    Attributes
    ----------
    place
        By number of a link, where it stands among the k.
    self_stresses
        Forces that need no load, (s, ..., k, 6).
    parts
        What makes, by a sum of products, the part of each state in any forces, (s, ..., k, 6).
    rounding
        Of a share, as a part of what it is made of, (...).
    """

    place: dict[int, int]
    self_stresses: Real
    parts: Array
    rounding: Array

    def excess(self, forces: Mapping[int, Real]) -> dict[int, Real]:
        """What forces (..., 6) by link exceed the share by."""
        amounts = sum(np.sum(self.parts[..., k, :] * forces[link], axis=-1) for link, k in self.place.items())
        amounts = np.asarray(amounts)[..., None]
        return {link: np.sum(self.self_stresses[..., k, :] * amounts, axis=0) for link, k in self.place.items()}

    def sizes(self, link: int, forces: Mapping[int, Real]) -> Real:
        """Size of what a link's share of forces (..., 6) is made of beside its own, (..., 6)."""
        parts = np.abs(self.parts)
        amounts = sum(np.sum(parts[..., k, :] * np.abs(forces[each]), axis=-1) for each, k in self.place.items())
        own = np.abs(self.self_stresses[..., self.place[link], :])
        return np.asarray(np.sum(own * np.asarray(amounts)[..., None], axis=0))

    def relative_displacements(self, link: int) -> Iterator[tuple[int, Real]]:
        """Relative displacements (6, ..., 6) of links that, with a unit of each component of a link, agree with all
        loops: the force in that component, as it is shared, does the work on them."""
        own = np.moveaxis(self.self_stresses[..., self.place[link], :], -1, 1)[..., None]
        for each, k in self.place.items():
            yield each, -np.sum(own * self.parts[:, None, ..., k, :], axis=0)


def load_shares(kinematics: FrameKinematics) -> list[LoadShare]:
    """The shares in all loops of a frame that have redundant components."""
    return [_sharing(kinematics, loops) for loops in kinematics.redundant]


def shared(found: Sequence[LoadShare], forces: Sequence[Real]) -> list[Real]:
    """Forces by link (..., 6) in any equilibrium, as redundant components share them.

    Parameters
    ----------
    found
        The shares in all loops that have such.
    forces
        On the relative displacements of all links; those in springs are as they are.
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
    # of a screw's forces those on its coordinates
    parts = np.where(ideal, np.asarray(_of_screws(links, inverse, KinematicEdge.rest), np.float64), 0.0)
    rounding = _ROUNDINGS * np.sqrt(6.0 * len(links)) * np.finfo(np.float64).eps * condition
    return LoadShare({int(k): at for at, k in enumerate(loops.links)}, stresses, parts, rounding)


def _of_screws(links: Sequence[KinematicEdge], forces: Real, change: Callable[[KinematicEdge, Real], Real]) -> Real:
    """Forces (..., k, 6) of links, those of screws changed."""
    if all(link.lead is None for link in links):
        return forces
    each = (change(link, forces[..., k, :]) for k, link in enumerate(links))
    return np.stack(np.broadcast_arrays(*each), -2)


def _self_stresses(kinematics: FrameKinematics, loops: RedundantLoops) -> Real:
    """Forces that need no load, on the relative displacements of links, (s, ..., k, 6)."""
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
    # what closes the loops acts on the links of the tree as well, on children first
    for k in reversed(loops.links):
        if links[k].sign and links[k].child in nodal:
            force = nodal[links[k].child]
            _add(nodal, links[k].parent, links[k].transfer(force, links[k].sign))
            ideal = np.isin(np.arange(6), links[k].edge.ideal)
            own[k] = np.where(ideal, -links[k].worked(links[k].sign * links[k].into(force)), 0.0)
    none = np.zeros((len(loops.self_stresses), *shape, 6), kind)
    return np.stack([own.get(k, none) for k in loops.links], axis=-2)


def _add(nodal: dict[int, Real], node: int, force: Real) -> None:
    """Add a force on a node, which the ground needs not."""
    if node != GROUND:
        nodal[node] = nodal[node] + force if node in nodal else force


def _inverse(weighed: Array) -> tuple[Array, Array]:
    """Least inverse (s, ..., n) of states of self-stress (s, ..., n), and their condition number, (...)."""
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
    """Least inverses (m, n, s) of matrices (m, s, n), and their condition numbers, (m,)."""
    products = states @ np.swapaxes(states, -1, -2)
    # one in place of states that are none at an entry, apart from all others
    at = np.arange(states.shape[1])
    products[:, at, at] += products[:, at, at] == 0.0
    squares = np.linalg.eigvalsh(products)
    good = squares[:, 0] > _INDEPENDENT**2 * squares[:, -1]
    out, condition = np.zeros((len(states), *states.shape[:0:-1])), np.zeros(len(states))
    if good.any():
        some = states if good.all() else states[good]
        found = np.swapaxes(some, -1, -2) @ np.linalg.inv(products if good.all() else products[good])
        # the products have lost digits, which one step of Newton's iteration brings back
        out[good] = found + found @ (np.eye(states.shape[1]) - some @ found)
        condition[good] = np.sqrt(squares[good, -1] / squares[good, 0])
    if not good.all():
        left, values, right = np.linalg.svd(states[~good], full_matrices=False)
        kept = values > _NONE * values[..., :1]
        inverse = np.divide(1.0, values, out=np.zeros_like(values), where=kept)
        out[~good] = np.swapaxes(right, -1, -2) * inverse[..., None, :] @ np.swapaxes(left, -1, -2)
        condition[~good] = values[..., 0] * inverse.max(axis=-1)
    return out, condition
