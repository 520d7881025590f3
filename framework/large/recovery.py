"""What follows from an equilibrium: forces and displacements along members and in joints, and contact.

They are given in axes that follow: those of members the chords of their pieces, those of joints their first node.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import rotation
from ..arm import transferred_along_x
from ..batch import Array, aligned, rotated
from ..clearances.contact import Contact
from ..clearances.joints import UNLOADED, joints_with_clearance
from ..entries import flattened
from ..member_law import DEFORMATIONS
from ..results.along_member import AlongMembers
from ..results.base import Results, checked_fractions
from ..states import ClearanceState, put, states_of
from ..structure.member_loads import applied_forces, weight_forces
from .clearances import TOUCHING
from .equations import EquilibriumEquations, SpatialLinearisation
from .links import EdgeGeometry
from .model import Model
from .numbers import Numbers, batch_first
from .state import DisplacedState


class Stations(AlongMembers):
    """Forces and displacements along the members of a frame in equilibrium.

    Parameters
    ----------
    equations
        The whole batch.
    state
        Where it is.
    linear
        Forces there.
    """

    def __init__(self, equations: EquilibriumEquations, state: DisplacedState, linear: SpatialLinearisation) -> None:
        super().__init__(equations.model.topology)
        self.model, self.equations, self.state, self.linear = equations.model, equations, state, linear
        self.motions = [response.at for response in linear.responses]

    def end_forces(self, member: str) -> Array:
        """Forces on both ends of a member (..., 12)."""
        pieces = self.topology.pieces_of[member]
        ends = self._piece_forces(pieces[0])[:6], self._piece_forces(pieces[-1])[6:]
        return batch_first(np.concatenate(ends), self.model.frame.shape, 1)

    def internal(self, piece: int, x: Array) -> Array:
        """Internal forces at stations of a piece, (k, ..., 6): equilibrium of what lies before them."""
        flat = self._stations(x)
        out = -transferred_along_x(np.moveaxis(self._piece_forces(piece)[:6], 0, -1), -flat)
        for s, force in self._loads(piece, x):
            out -= transferred_along_x(np.concatenate([force, np.zeros_like(force)], axis=-1), s - flat)
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
        rows = self.motions[k].axes[:, :, position].transpose(2, 1, 0)
        return self._shaped(np.broadcast_to(rows.reshape(-1, 9), (len(x), len(rows), 9)))

    def _piece_forces(self, piece: int) -> Array:
        """Forces on both ends of a piece, in its moving axes (12, m)."""
        k, position = self.placed[piece]
        return self._end_forces[k][:, position] - self._shares(piece)

    @cached_property
    def _end_forces(self) -> list[Array]:
        """By stack, forces on the ends of its pieces with the loads between shared out to them (12, n, m)."""
        pairs = zip(self.linear.responses, self.linear.stresses, strict=True)
        return [response.local_forces(stress) for response, stress in pairs]

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


class RecoveredResults(Results):
    """Results in members and joints, in axes that follow the displacement."""

    model: Model

    @property
    @abstractmethod
    def displaced(self) -> DisplacedState:
        """Where everything is."""

    @property
    @abstractmethod
    def equations(self) -> EquilibriumEquations:
        """Equations of the whole batch at the whole load."""

    @property
    @abstractmethod
    def linear(self) -> SpatialLinearisation:
        """Forces of the whole batch."""

    @property
    @abstractmethod
    def converged(self) -> NDArray[np.bool_]:
        """Whether an equilibrium was found, (...)."""

    @abstractmethod
    def _masked(self, array: Array) -> Array:
        """A result (..., components), NaN where there is no equilibrium."""

    @property
    @abstractmethod
    def _recovery(self) -> Stations: ...

    @property
    def journals(self) -> list[str]:
        """Names of the joints whose clearance is taken into account."""
        return joints_with_clearance(self.frame) if self.model.clearance else []

    def section_axes_at(self, fractions: ArrayLike) -> Array:
        """Find the axes in which `forces_at` tells forces: those that follow the chords of the pieces.

        Parameters
        ----------
        fractions
            Shares of the length from the start, 0 to 1, (k,).

        Returns
        -------
        ndarray
            The axes as rows in global components, (..., members, k, 3, 3).
        """
        at = checked_fractions(fractions)
        rows = self._each(lambda name, x: self._masked(self._recovery.axes_along(name, x)), at, 9)
        return rows.reshape(*rows.shape[:-1], 3, 3)

    def joint_global(self, joint: str, vectors: Array) -> Array:
        """Turn vectors in a joint's axes, which turn with its first node, into global ones.

        Parameters
        ----------
        joint
            Name of the joint.
        vectors
            Vectors (..., 3), or pairs of these (..., 6).

        Returns
        -------
        ndarray
            The same in global axes, (..., 3) or (..., 6).
        """
        frame, link = self.frame, self.frame.joints[joint]
        axes = link.element.axes
        start = vectors if axes is None else rotated(aligned(axes, len(frame.shape), 2), vectors)
        turn = rotation.matrix(self.displaced.rotations[:, self.model.topology.number[link.first]])
        return rotated(np.moveaxis(turn, -1, 0).reshape(*frame.shape, 3, 3), start)

    # -- joints -----------------------------------------------------------------------------------------------------

    def joint_displacement(self, joint: str) -> Array:
        """Displacement of a joint's second node relative to its first, in axes that follow the first.

        Parameters
        ----------
        joint
            Name of the joint.

        Returns
        -------
        ndarray
            ``ux uy uz rx ry rz``, (..., 6); imposed offsets included.
        """
        number = self._link(joint)
        return self._shaped(self._edge(number).whole(self.equations.own(self.displaced, number)))

    def joint_force(self, joint: str) -> Array:
        """Force and moment that a joint exerts on its first node, in axes that follow it.

        Parameters
        ----------
        joint
            Name of the joint.

        Returns
        -------
        ndarray
            ``fx fy fz mx my mz``, (..., 6): of the springs, and of what holds ideal components.
        """
        number = self._link(joint)
        return self._shaped(-self._edge(number).exerted(self.linear.own[:, number]))

    def contact(self, joint: str) -> Contact:
        """Where a joint with clearance is in contact, and how hard it is pressed.

        Parameters
        ----------
        joint
            Name of the joint.

        Returns
        -------
        Contact
            Its normal in global axes where the frame has come to; `unresolved` where no equilibrium was found.

        Raises
        ------
        FrameError
            If the joint has no clearance, or clearances were left out.
        """
        name = self._with_clearance(joint, self.journals)
        return self._contact(name)

    def _contact(self, name: str) -> Contact:
        frame, joint, number = self.frame, self.frame.joints[name], self._link(name)
        directions = list(joint.element.clearance_directions)
        gap = self._vector(directions, self._beyond(number)[directions])
        force = self._vector(directions, -self.linear.own[directions, number])
        radius = np.broadcast_to(joint.element.clearance, frame.shape)
        length, contact_force = (np.hypot.reduce(vector, axis=-1) for vector in (gap, force))
        beyond = (length >= radius * (1.0 - TOUCHING)) & (contact_force > self._unloaded.reshape(frame.shape))
        closed = self._closed(number, beyond)
        state = put(states_of(frame.shape, ClearanceState.OPEN), closed, ClearanceState.CLOSED)
        state = put(state, ~self.converged, ClearanceState.UNRESOLVED)
        state = state if frame.absent is None else put(state, frame.absent, ClearanceState.ABSENT)
        unknown = np.where(state >= ClearanceState.UNRESOLVED, np.nan, 0.0)
        along = force / np.where(contact_force > 0.0, contact_force, 1.0)[..., None]
        inside = gap * np.where(closed, radius / np.where(length > 0.0, length, 1.0), 1.0)[..., None]
        return Contact(
            joint=name,
            state=state,
            normal=np.where(closed[..., None], self.joint_global(name, along), 0.0) + unknown[..., None],
            force=np.where(closed, contact_force, 0.0) + unknown,
            gap=np.where(closed, 0.0, np.maximum(radius - length, 0.0)) + unknown,
            offset=inside + unknown[..., None],
        )

    def _closed(self, number: int, beyond: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Whether a joint is pressed: a rigid one by its force, one with a stiffness where `beyond` its clearance."""
        if number not in self.model.contacts:
            return beyond
        force = self.displaced.contact_force[:, self.model.contacts[number]]
        pressed: NDArray[np.bool_] = np.hypot.reduce(force, axis=0) > self._unloaded
        return pressed.reshape(beyond.shape)

    def _unpressed(self) -> NDArray[np.bool_]:
        """Where some journal in a clearance is not pressed, (entries,): nothing resists it."""
        out = np.zeros(self.equations.count, dtype=bool)
        for number, joint in enumerate(self.model.edges):
            if joint.clearance_directions:
                directions = list(joint.clearance_directions)
                length, contact_force = (
                    np.hypot.reduce(v[directions], axis=0) for v in (self._beyond(number), self.linear.own[:, number])
                )
                out |= length < joint.clearance.at(self.equations.where) * (1.0 - TOUCHING)
                out |= contact_force <= self._unloaded
        return out

    @property
    def _unloaded(self) -> Array:
        """Force that is none beside the largest at a node (entries,)."""
        return np.asarray(UNLOADED * np.abs(self.linear.nodal[:3]).max(axis=(0, 1)))

    def _beyond(self, number: int) -> Array:
        """Displacement of a joint beyond its imposed offset (6, m)."""
        equations = self.equations
        return equations.own(self.displaced, number) - self.model.edges[number].offset.at(equations.where)

    def _vector(self, directions: list[int], values: Array) -> Array:
        """Values by clearance direction, (n, m), as vectors in the joint's axes, (..., 3)."""
        out = np.zeros((3, values.shape[-1]))
        out[[k % 3 for k in directions]] = values
        return batch_first(out, self.frame.shape, 1)

    def _shaped(self, array: Array) -> Array:
        """A result (components, m) in the shape of the batch, NaN where there is no equilibrium."""
        return self._masked(batch_first(array, self.frame.shape, array.ndim - 1))

    def _edge(self, number: int) -> EdgeGeometry:
        return self.model.edges[number].at(self.equations.where)

    def _link(self, joint: str) -> int:
        wanted = "joint", self._joint(joint)
        return next(k for k, link in enumerate(self.model.edges) if (link.edge.kind, link.edge.name) == wanted)
