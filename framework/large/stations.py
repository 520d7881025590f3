"""Forces and displacement along members, in the axes of their moving pieces."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from .. import rotation
from ..batch import Array
from ..entries import flattened
from ..member_law import DEFORMATIONS
from ..results.along_member import AlongMembers
from ..results.member_field import about
from ..structure.member_loads import applied_forces, weight_forces
from . import corotation
from .corotation import CorotatedPieces
from .equations import EquilibriumEquations
from .model import Model
from .numbers import Numbers, batch_first
from .response import Response
from .state import DisplacedState


class Stations(AlongMembers):
    """What follows from an equilibrium along the members.

    Parameters
    ----------
    model, equations, state
        The frame, its whole batch, and where it is.
    """

    def __init__(self, model: Model, equations: EquilibriumEquations, state: DisplacedState) -> None:
        super().__init__(model.topology)
        self.model, self.equations, self.state = model, equations, state
        self.motions: list[CorotatedPieces] = equations.motions(state)

    def end_forces(self, member: str) -> Array:
        """Forces on both ends of a member (..., 12)."""
        pieces = self.topology.pieces_of[member]
        ends = self._piece_forces(pieces[0])[:6], self._piece_forces(pieces[-1])[6:]
        return batch_first(np.concatenate(ends), self.model.frame.shape, 1)

    def internal(self, piece: int, x: Array) -> Array:
        """Internal forces at stations of a piece, (k, ..., 6): equilibrium of what lies before them."""
        flat = self._stations(x)
        out = -about(np.moveaxis(self._piece_forces(piece)[:6], 0, -1), -flat)
        for s, force in self._loads(piece, x):
            out -= about(np.concatenate([force, np.zeros_like(force)], axis=-1), s - flat)
        return self._shaped(out)

    def moved(self, piece: int, x: Array) -> Array:
        """Displacement and rotation at stations of a piece in global axes, (k, ..., 6)."""
        k, position = self.placed[piece]
        group, at = self.topology.groups[k], self.motions[k]
        flat, length = self._stations(x), self._length(piece)
        shapes = group.of(position).shape_functions(group.length[position], x)
        shapes = flattened(shapes, (len(x), *self.model.frame.shape), 2).reshape(*flat.shape, 6, 12)
        deformation = at.deformation[:, position]
        local = np.einsum("kmij,jm->ikm", shapes[..., list(DEFORMATIONS)], deformation)
        first = self.topology.pieces[piece].nodes[0]
        turn = at.turn[:, :, position]
        local_axes = self._flat(group.local_axes[position], 2)
        # the chord from the displaced start, against the point's place before: both from differences
        beyond = local[:3].copy()
        shift = turn[:, 0] * (at.chord[position] / length)
        shift[0] -= 1.0
        beyond[0] -= flat / length * deformation[0]
        displacements = np.einsum("ijm,jkm->ikm", turn, beyond) + flat * shift[:, None]
        place = self.state.displacements[:, first][:, None] + np.einsum("jim,jkm->ikm", local_axes, displacements)
        frame = self._frame(k, position, first)
        rotations = rotation.product(frame[:, None] + np.zeros((4, *flat.shape)), rotation.exponential(local[3:]))
        back = np.concatenate([rotations[:1], np.einsum("jim,jkm->ikm", local_axes, rotations[1:])])
        return self._shaped(np.moveaxis(np.concatenate([place, rotation.logarithm(back)]), 0, -1))

    def axes_along(self, member: str, at: Array) -> Array:
        """Axes of the moving pieces at stations (..., k), as rows in global components, (..., k, 9)."""
        return self.along(member, at, self._axes)

    # -- pieces -----------------------------------------------------------------------------------------------------

    def _axes(self, piece: int, x: Array) -> Array:
        """Axes of a piece as rows, the same at all its stations, (k, ..., 9)."""
        k, position = self.placed[piece]
        local_axes = self._flat(self.topology.groups[k].local_axes[position], 2)
        rows = np.einsum("abm,acm->mbc", self.motions[k].turn[:, :, position], local_axes)
        return self._shaped(np.broadcast_to(rows.reshape(-1, 9), (len(x), len(rows), 9)))

    def _piece_forces(self, piece: int) -> Array:
        k, position = self.placed[piece]
        response = Response(self.equations.pieces[k], self.motions[k])
        return response.local_forces(corotation.stress(self.equations.pieces[k], self.motions[k].deformation))[
            :, position
        ] - self._shares(piece)

    def _shares(self, piece: int) -> Array:
        """Loads between the ends as shared between them, in the moving axes (12, m)."""
        out: Array = np.zeros((12, self.equations.count))
        length = self._length(piece)
        for x, force in self._loads(piece):
            out[:3] += (1.0 - x / length) * force.T
            out[6:9] += x / length * force.T
        return out

    def _length(self, piece: int) -> Array:
        group, position = self.group(piece)
        return self._flat(group.length[position], 0)

    def _loads(self, piece: int, upto: Array | None = None) -> Iterator[tuple[Array, Array]]:
        """Distances (m,) from the start, and forces (m, 3) in the moving axes, that stand for the loads on a piece.

        Of those before stations `upto` (k, ...), if there are any, (k, m) and (k, m, 3).
        """
        group, position = self.group(piece)
        stations, shape = (() if upto is None else (len(upto),)), self.model.frame.shape
        turn = self.motions[self.placed[piece][0]].turn[:, :, position]
        before = None if upto is None else upto[:, None]
        weights = weight_forces(self.topology, group, np.array([position]), before)
        given = [(np.squeeze(x, len(stations)), np.squeeze(force, len(stations))) for x, force in weights]
        given += [(x[0], force[0]) for x, force in applied_forces(self.topology, group, position, upto)]
        for x, force in given:
            flat = flattened(force[..., :3], (*stations, *shape), 1).reshape(*stations, -1, 3)
            yield (
                flattened(x, (*stations, *shape), 0).reshape(*stations, -1),
                np.einsum("abm,...ma->...mb", turn, flat),
            )

    # -- the batch as one axis ---------------------------------------------------------------------------------------

    def _flat(self, array: Array, trailing: int) -> Array:
        """(batch..., components) as (components, m)."""
        return Numbers.of(array, self.model.ndim, trailing).at(self.equations.where) + np.zeros(self.equations.count)

    def _stations(self, x: Array) -> Array:
        """Stations (k, ...) as (k, m)."""
        return np.broadcast_to(x, (len(x), *self.model.frame.shape)).reshape(len(x), -1)

    def _shaped(self, array: Array) -> Array:
        """(k, m, components) as (k, ..., components)."""
        return array.reshape(len(array), *self.model.frame.shape, array.shape[-1])

    def _frame(self, k: int, position: int, first: int) -> Array:
        """Quaternion of a piece's moving frame in its axes at the start (4, m)."""
        local_axes = self.equations.pieces[k].local_axes[:, :, position]
        q = self.state.rotations[:, first]
        local = np.concatenate([q[:1], np.einsum("ij...,j...->i...", local_axes, q[1:])])
        return rotation.product(local, rotation.conjugate(self.motions[k].ends[0][:, position]))
