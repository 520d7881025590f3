"""Members and loads as numbers by entry of a batch: stiffness of stacks of pieces, dead loads on nodes and in between.

Arrays have their components first and the batch behind, so that those of some entries are taken from them at once.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np
import scipy
from numpy.typing import NDArray

from ..batch import Array, rotated
from ..elementwise import is_recorded, zeros
from ..entries import picked
from ..errors import FrameError
from ..member_law import DEFORMATIONS
from ..structure.assembly import component_loads, offset_weights
from ..structure.member_loads import loads_between, strain_forces
from ..structure.topology import Group, Index, Topology
from .corotation import Law, Pieces

Where = tuple[NDArray[np.int64], ...]
# Of scaled eigenvalues, those that count as zero; of a force, what may be left of it by rounding.
_RANK, _LEFT = 1e-12, 1e-8


@dataclass(frozen=True)
class Numbers:
    """An array (components..., batch...), the batch axes as they were given: of size one where nothing varies."""

    array: Array
    ndim: int

    @classmethod
    def of(cls, given: Array, ndim: int, trailing: int, leading: int = 0) -> Numbers:
        """From an array (leading..., batch..., trailing...), its batch axes perhaps not all there.

        The components of the result are the trailing axes, then the leading ones.
        """
        missing = ndim + trailing + leading - given.ndim
        shape = given.shape[:leading] + (1,) * missing + given.shape[leading:]
        whole = given.reshape(shape)
        order = (*range(leading + ndim, whole.ndim), *range(leading + ndim))
        return cls(whole.transpose(order).copy(order="C"), ndim)

    def at(self, where: Where) -> Array:
        """Numbers of some entries, (components..., m), or (components..., 1) where they are all alike."""
        return np.ascontiguousarray(picked(self.array, where, leading=self.array.ndim - self.ndim))


def at_index(where: Where, index: NDArray[np.int64] | NDArray[np.bool_]) -> Where:
    """Some of the entries, by their number among these or by a mask."""
    return tuple(axis[index] for axis in where)


def batch_first(array: Array, shape: tuple[int, ...], leading: int) -> Array:
    """(components..., m) as (batch..., components...)."""
    moved = np.moveaxis(array.reshape(*array.shape[:leading], *shape), range(leading), range(-leading, 0))
    return np.ascontiguousarray(moved)


def summed(matrix: scipy.sparse.csr_matrix, terms: Array) -> Array:
    """Sums of rows (n, m), numbers or terms of a recording, with the factors of a sparse matrix."""
    if not is_recorded(terms):
        out: Array = matrix @ terms
        return out
    out = zeros((matrix.shape[0], terms.shape[1]), terms)
    for row, (a, b) in enumerate(zip(matrix.indptr[:-1].tolist(), matrix.indptr[1:].tolist(), strict=True)):
        for column, factor in zip(matrix.indices[a:b].tolist(), matrix.data[a:b].tolist(), strict=True):
            out[row] = out[row] + factor * terms[column]
    return out


@dataclass(frozen=True)
class Stack:
    """Pieces of one group as `Numbers`; ``ends`` (n, 2) are their node numbers."""

    ends: Index
    local_axes: Numbers
    length: Numbers
    stiffness: Numbers
    bow: Numbers
    work: Numbers | None
    tension: Numbers | None
    free: Numbers | None
    group: Group
    ndim: int

    @classmethod
    def of(cls, topology: Topology, group: Group) -> Stack:
        """The numbers of a group."""
        ndim = len(topology.frame.shape)
        rows, columns = np.ix_(DEFORMATIONS, DEFORMATIONS)
        stiffness = group.element.stiffness_matrix(group.length)[..., rows, columns]
        turns = np.ix_(DEFORMATIONS[1:], DEFORMATIONS[1:])
        bow = group.element.geometric_matrix(group.length, np.ones(()))[..., turns[0], turns[1]]
        work, tension = _work(topology, group), _tension(group)
        numbers = partial(Numbers.of, ndim=ndim, leading=1)
        return cls(
            topology.ends[group.pieces],
            numbers(group.local_axes, trailing=2),
            numbers(group.length, trailing=0),
            numbers(stiffness, trailing=2),
            numbers(bow, trailing=2),
            None if work is None else numbers(work, trailing=3),
            None if tension is None else numbers(tension, trailing=0),
            numbers(_free(topology, group, stiffness), trailing=1) if group.strained else None,
            group,
            ndim,
        )

    @property
    def plain(self) -> bool:
        """Whether its pieces have their stiffness alone: no loads, tension, own law, or strain without force."""
        alone = self.work is None and self.tension is None and self.free is None
        return alone and not self.group.element.has_law

    def at(self, where: Where, factor: float) -> Pieces:
        """The numbers of some entries, with the loads multiplied by `factor`."""
        work, tension, free = (
            None if each is None else factor * each.at(where) for each in (self.work, self.tension, self.free)
        )
        local_axes, length = self.local_axes.at(where), self.length.at(where)
        law = self._law(where, length) if self.group.element.has_law else None
        return Pieces(local_axes, length, self.stiffness.at(where), self.bow.at(where), work, tension, law, free)

    def _law(self, where: Where, length: Array) -> Law:
        """The pieces' own law at some entries."""
        element, ndim, count = self.group.element, self.ndim, len(self.ends)

        def law(strain: Array) -> tuple[Array, Array, Array]:
            size = count, strain.shape[-1]

            def pick(array: Array, trailing: int) -> Array:
                taken = Numbers.of(array, ndim, trailing).at(where)
                trailing_shape = taken.shape[:-1]
                whole = np.broadcast_to(taken[..., None, :], (*trailing_shape, *size)).reshape(*trailing_shape, -1)
                return np.moveaxis(whole, -1, 0)

            along = np.broadcast_to(length, size).reshape(-1)
            energy, force, tangent = element.resistance(along, strain.reshape(7, -1).T, pick)
            return energy.reshape(size), force.T.reshape(7, *size), np.moveaxis(tangent, 0, -1).reshape(7, 7, *size)

        return law


@dataclass(frozen=True)
class OffsetForce:
    """Weight `force` (..., 3) of a mass at the end of `arm` (..., 3), which turns with its node."""

    node: int
    force: Array
    arm: Array


@dataclass(frozen=True)
class Loads:
    """Dead loads on nodes.

    Attributes
    ----------
    nodal
        Forces and moments (6, nodes, ...), loads on members shared between the ends of pieces.
    largest
        Largest magnitude of what was summed up, by component (..., 6).
    offset_forces
        Weights that are not at their node.
    """

    nodal: Numbers
    largest: Array
    offset_forces: list[OffsetForce]

    @classmethod
    def of(cls, topology: Topology) -> Loads:
        """The loads of a frame."""
        at: dict[int, Array] = {}
        largest: Array = np.zeros(6)

        def put(node: int, force: Array) -> None:
            nonlocal largest
            largest = np.maximum(largest, np.abs(force))
            at[node] = at[node] + force if node in at else force

        for node, k, value in component_loads(topology):
            put(node, value[..., None] * np.eye(6)[k])
        offset_forces = [OffsetForce(*weight) for weight in offset_weights(topology)]
        for weight in offset_forces:
            put(weight.node, np.concatenate([weight.force, np.zeros_like(weight.force)], axis=-1))
        for group in topology.groups:
            for position, x, force in _between(topology, group):
                pushed = rotated(np.swapaxes(group.local_axes[position], -1, -2), force)
                share = (x / group.length[position])[..., None]
                for ends, near, far in zip(
                    topology.ends[group.pieces[position]].tolist(), pushed * (1.0 - share), pushed * share, strict=True
                ):
                    put(ends[0], near)
                    put(ends[1], far)
            tension = _tension(group)
            if tension is not None:  # exerted by the member, wherever it turns: not by the loads
                along = tension[..., None] * group.local_axes[..., 0, :]
                for ends, generalised_force in zip(topology.ends[group.pieces].tolist(), along, strict=True):
                    for node, force in zip(ends, (-generalised_force, generalised_force), strict=True):
                        put(node, np.concatenate([force, np.zeros_like(force)], axis=-1))
        shape = np.broadcast_shapes(*(force.shape[:-1] for force in at.values())) if at else ()
        out = np.zeros((len(topology.number), *shape, 6))
        for node, force in at.items():
            out[node] += force
        return cls(
            Numbers.of(out, len(topology.frame.shape), 1, leading=1), largest, [w for w in offset_forces if w.arm.any()]
        )


def _free(topology: Topology, group: Group, stiffness: Array) -> Array:
    """Deformations of pieces that take no force, (n, ..., 7), by the end forces that make them."""
    forces = strain_forces(group, np.arange(len(group.pieces)))[..., list(DEFORMATIONS)]
    size = np.sqrt(np.diagonal(stiffness, axis1=-2, axis2=-1))
    size = np.where(size > 0.0, size, 1.0)
    scaled = np.linalg.pinv(stiffness / (size[..., :, None] * size[..., None, :]), rcond=_RANK, hermitian=True)
    out: Array = (scaled @ (forces / size)[..., None])[..., 0] / size
    left = np.abs((stiffness @ out[..., None])[..., 0] - forces) / size
    if np.any(left > _LEFT * np.abs(forces / size).max(axis=-1, keepdims=True)):
        name = topology.pieces[group.pieces[0]].member
        raise FrameError(f"member {name!r} is strained where it has no stiffness: large displacement cannot follow it")
    return out


def _tension(group: Group) -> Array | None:
    """Forces at rest of pieces, with which the frame is loaded, (n, ...); None without one."""
    tension = np.asarray(group.element.tension)
    if not tension.any():
        return None
    return np.broadcast_to(tension, (len(group.pieces), *np.broadcast_shapes(group.length.shape[1:], tension.shape)))


def _between(topology: Topology, group: Group) -> Iterator[tuple[Index, Array, Array]]:
    """Point forces on pieces, in local axes: which pieces, where, how much; refused where there are moments."""
    for position, x, force in loads_between(topology, group):
        turned = np.any(force[..., 3:].reshape(len(force), -1), axis=1)
        if turned.any():
            member = topology.pieces[group.pieces[position[np.argmax(turned)]]].member
            raise FrameError(f"point load on {member!r} has a moment: put a node there and load it")
        yield position, x, force


def _work(topology: Topology, group: Group) -> Array | None:
    """Work of the loads between the ends on the deformations (n, ..., 3, 3, 7), None without such loads."""
    terms = []
    for position, x, force in _between(topology, group):
        length = group.length[position]
        shapes = group.of(position).shape_functions(length, x)[..., :3, list(DEFORMATIONS)]
        shapes[..., 0, 0] -= x / length
        terms.append((position, force[..., :3, None, None] * shapes[..., None, :, :]))
    if not terms:
        return None
    shape = np.broadcast_shapes(*(term.shape[1:] for _, term in terms))
    out = np.zeros((len(group.pieces), *shape))
    for position, term in terms:
        out[position] += term
    return out
