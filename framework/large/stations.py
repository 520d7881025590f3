"""Forces and displacement along members, in the axes of their moving pieces."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from .. import rotation
from ..batch import Array, aligned
from ..member_law import DEFORMATIONS
from ..results.recovery import check_stations
from ..structure.member_loads import applied_forces, weight_forces
from ..structure.topology import Group
from . import corotation
from .corotation import CorotatedPieces, Response
from .equations import EquilibriumEquations
from .model import Model
from .numbers import Numbers, batch_first
from .state import DisplacedState

Field = Callable[[int, Array], Array]


class Stations:
    """What follows from an equilibrium along the members.

    Parameters
    ----------
    model, equations, state
        The frame, its whole batch, and where it is.
    """

    def __init__(self, model: Model, equations: EquilibriumEquations, state: DisplacedState) -> None:
        self.model, self.equations, self.state = model, equations, state
        self.topology = model.topology
        self.where = {
            int(piece): (k, position)
            for k, group in enumerate(model.topology.groups)
            for position, piece in enumerate(group.pieces)
        }
        self.motions: list[CorotatedPieces] = equations.motions(state)

    def end_forces(self, member: str) -> Array:
        """Forces on both ends of a member (..., 12)."""
        pieces = self.topology.pieces_of[member]
        ends = self._piece_forces(pieces[0])[:6], self._piece_forces(pieces[-1])[6:]
        return batch_first(np.concatenate(ends), self.model.frame.shape, 1)

    def forces(self, member: str, at: Array) -> Array:
        """Internal forces (..., k, 6)."""
        return self._along(member, at, self._cut)

    def stress(self, member: str, at: Array) -> Array:
        """Extreme stresses (..., k, 3)."""

        def stress(piece: int, x: Array) -> Array:
            group, position = self._group(piece)
            batch = self.model.frame.shape
            forces = np.moveaxis(self._cut(piece, x), 0, -1).reshape(len(x), *batch, 6)
            fraction = x.reshape(len(x), *batch) / group.length[position]
            found = group.of(position).stress(fraction, forces)
            return np.moveaxis(np.broadcast_to(found, (len(x), *batch, 3)).reshape(*x.shape, 3), -1, 0)

        return self._along(member, at, stress)

    def displacement(self, member: str, at: Array) -> Array:
        """Displacement and rotation (..., k, 6)."""
        return self._along(member, at, self._moved)

    # -- pieces -----------------------------------------------------------------------------------------------------

    def _group(self, piece: int) -> tuple[Group, int]:
        k, position = self.where[piece]
        return self.topology.groups[k], position

    def _piece_forces(self, piece: int) -> Array:
        k, position = self.where[piece]
        response = Response(self.equations.pieces[k], self.motions[k])
        return response.local_forces(corotation.stress(self.equations.pieces[k], self.motions[k].deformation))[
            :, position
        ] - self._shares(piece)

    def _shares(self, piece: int) -> Array:
        """Loads between the ends as shared between them, in the moving axes (12, m)."""
        out: Array = np.zeros((12, self.equations.count))
        length = self._length(piece)
        for x, force in self._loads(piece, None):
            out[:3] += (1.0 - x / length) * force
            out[6:9] += x / length * force
        return out

    def _length(self, piece: int) -> Array:
        group, position = self._group(piece)
        return self._flat(group.length[position], 0)

    def _loads(self, piece: int, upto: Array | None) -> Iterator[tuple[Array, Array]]:
        """Distances (m,) or (k, m) from the start, and forces in the moving axes."""
        group, position = self._group(piece)
        k, _ = self.where[piece]
        turn = self.motions[k].turn[:, :, position]
        if upto is not None:
            batch = self.model.frame.shape
            for station in range(len(upto)):
                stretch = upto[station].reshape(batch)
                for x, force in self._given(group, position, stretch):
                    whole = np.zeros((len(upto), self.equations.count)), np.zeros((3, *upto.shape))
                    whole[0][station] = self._flat(x[0], 0)
                    whole[1][:, station] = np.einsum("ab...,a...->b...", turn, self._flat(force[0, ..., :3], 1))
                    yield whole
            return
        for x, force in self._given(group, position, None):
            yield self._flat(x[0], 0), np.einsum("ab...,a...->b...", turn, self._flat(force[0, ..., :3], 1))

    def _given(self, group: Group, position: int, upto: Array | None) -> Iterator[tuple[Array, Array]]:
        yield from weight_forces(self.topology, group, np.array([position]), None if upto is None else upto[None])
        yield from applied_forces(self.topology, group, position, upto)

    def _flat(self, array: Array, trailing: int) -> Array:
        """(batch..., components) as (components, m)."""
        return Numbers.of(array, self.model.ndim, trailing).at(self.equations.where) + np.zeros(self.equations.count)

    def _cut(self, piece: int, x: Array) -> Array:
        """Internal forces at stations x (k, m) of a piece (6, k, m): equilibrium of what lies before them."""
        start = self._piece_forces(piece)[:6, None]
        out = -_about(start + np.zeros((6, *x.shape)), -x)
        for s, force in self._loads(piece, x):
            out -= _about(np.concatenate([force, np.zeros_like(force)]), s - x)
        return out

    def _moved(self, piece: int, x: Array) -> Array:
        k, position = self.where[piece]
        group, at = self.topology.groups[k], self.motions[k]
        length = self._length(piece)
        batch = self.model.frame.shape
        stations = x.reshape(len(x), *batch)
        shapes = group.of(position).shape_functions(group.length[position], stations)
        shapes = np.broadcast_to(shapes, (len(x), *batch, 6, 12)).reshape(*x.shape, 6, 12)
        deformation = at.deformation[:, position]
        local = np.einsum("kmij,jm->ikm", shapes[..., list(DEFORMATIONS)], deformation)
        first, second = self.topology.pieces[piece].nodes
        turn = at.turn[:, :, position]
        level = self._flat(group.level[position], 2)
        # the chord from the displaced start, against the point's place before: both from differences
        beyond = local[:3].copy()
        shift = turn[:, 0] * (at.chord[position] / length)
        shift[0] -= 1.0
        fraction = x / length
        beyond[0] -= fraction * deformation[0]
        moved = np.einsum("ijm,jkm->ikm", turn, beyond) + x * shift[:, None]
        place = self.state.moved[:, first][:, None] + np.einsum("jim,jkm->ikm", level, moved)
        frame = self._frame(k, position, first)
        turned = rotation.product(frame[:, None] + np.zeros((4, *x.shape)), rotation.exponential(local[3:]))
        back = np.concatenate([turned[:1], np.einsum("jim,jkm->ikm", level, turned[1:])])
        del second
        return np.concatenate([place, rotation.logarithm(back)])

    def _frame(self, k: int, position: int, first: int) -> Array:
        """Quaternion of a piece's moving frame in its axes at the start (4, m)."""
        level = self.equations.pieces[k].level[:, :, position]
        q = self.state.turned[:, first]
        local = np.concatenate([q[:1], np.einsum("ij...,j...->i...", level, q[1:])])
        return rotation.product(local, rotation.conjugate(self.motions[k].ends[0][:, position]))

    # -- stations ---------------------------------------------------------------------------------------------------

    def _along(self, member: str, at: Array, field: Field) -> Array:
        pieces = self.topology.pieces_of[member]
        shape = self.model.frame.shape
        whole = self.model.frame.length(member)
        check_stations(member, at, whole, self.model.frame.shape)
        fraction = aligned(at / whole[..., None], self.model.ndim, 1)
        stations = np.broadcast_to(at, np.broadcast_shapes(fraction.shape, (*shape, at.shape[-1])))
        fraction = np.broadcast_to(fraction, stations.shape)
        flat, share = (np.moveaxis(a, -1, 0).reshape(at.shape[-1], -1) for a in (stations, fraction))
        which = np.minimum((share * len(pieces)).astype(int), len(pieces) - 1)
        first, *others = np.unique(which).tolist() or [0]
        out = self._inside(field, pieces[first], first, flat)
        for index in others:
            out = np.where(which == index, self._inside(field, pieces[index], index, flat), out)
        return batch_first(np.swapaxes(out, 0, 1), shape, 2)

    def _inside(self, field: Field, piece: int, index: int, stations: Array) -> Array:
        """A field in the piece of this number along its member, at distances from the member's start."""
        length = self._length(piece)
        return field(piece, np.clip(stations - index * length, 0.0, length))


def _about(force: Array, arm: Array) -> Array:
    """A force (6, ...) at distance `arm` ahead, with its moment about the origin."""
    out = force.copy()
    out[4] -= arm * force[2]
    out[5] += arm * force[1]
    return out
