"""Mechanisms in a batch of small frames, each solved with one unknown constrained for each free motion.

Deformations per unknown and free motions depend on the geometry alone, the matrix on the stiffness as well, and there
are many loads and offsets for each. So the former are found once for each geometry, the matrix is inverted once for
each stiffness, and for each entry only ``p - B^T k (B u + e)`` is balanced, in extended precision, by small dense
matrices.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from functools import cached_property, reduce

import numpy as np
from numpy.typing import NDArray

from ..batch import Array, Shape, merged
from ..entries import Entries
from ..error_bounds.compliance import DenseCompliance, by_units, resistances, together
from ..error_bounds.deformations import Springs
from ..error_bounds.equilibrium import EquilibriumResidual, Statics
from ..error_bounds.kinematic_edge import Real, extended
from ..error_bounds.kinematics import FrameKinematics
from ..error_bounds.resolved import alike, distinct, geometry_shape, grouped, matrix_shape
from ..error_bounds.tree_members import MEMBER
from ..solvers.freedom import constrained_unknowns
from ..structure.parts import Extended
from ..structure.topology import Index
from .constrained import COMPUTED, GIVEN, ConstrainedSolution, extent, free, weighed

Indices = tuple[Index, ...]
# Constrained unknowns of one entry also suit another if their independence there is at least this share of the former.
_ALIKE = 0.1
# Largest factor of the error in a step of refinement with an inverse in double precision; number of steps with another.
_ROUGH, _STEPS = 1e-6, 4
# Entries handled at a time: so many that their matrices have _NUMBERS numbers, but at least _LEAST and at most _MOST.
_NUMBERS, _LEAST, _MOST = 2**20, 256, 2**11
# Relative error after refinement.
_LEFT = 1e-22


def small(statics: Statics, suspects: NDArray[np.bool_], unknowns: list[int]) -> Iterator[ConstrainedSolution]:
    """Solutions of entries of a batch, without those at which rounding hides whether there are free motions.

    Parameters
    ----------
    statics
        The equilibrium equations of the frame.
    suspects
        Mask of the entries to examine, (...) of the batch shape.
    unknowns
        Numbers of the unknowns that count as loaded.
    """
    by_matrix = matrix_shape(statics)
    by_geometry = geometry_shape(statics) if alike(statics) else by_matrix
    count = min(_MOST, max(_LEAST, _NUMBERS // max(1, len(unknowns)) ** 2))
    for some, first, which in grouped(suspects, by_matrix, count):
        index, matrices = () if some is None else some, () if first is None else first
        geometry, own = distinct(matrices, by_geometry)
        frames = MovingGeometries(statics, geometry, unknowns)
        k = np.broadcast_to(stiffness_at(statics, matrices), (len(own), frames.columns.shape[-2]))
        # the free motions of a geometry are the same for all stiffnesses
        scaled, root = weighed(frames.double, frames.sizes, k[np.unique(own, return_index=True)[1]])
        for take, basis, constrained in same_constrained(*free(scaled, frames.count, plainly=False)):
            taken = np.flatnonzero(np.isin(own, take))
            entries = np.flatnonzero(np.isin(which, taken))
            group = ConstrainedMatrices(frames, np.delete(np.arange(len(unknowns)), constrained), own[taken], k[taken])
            motions = group.refined(np.moveaxis(basis * root[take][:, None], 1, 0), take)
            part = tuple(each[entries] for each in index)
            found = _solved(statics, part, group, np.searchsorted(taken, which[entries]), motions)
            yield found if suspects.ndim else found.alone


class MovingGeometries:
    """g geometries of a frame, at which it has free motions.

    Attributes
    ----------
    columns, sizes
        Deformations per unknown, (g, e, n), and magnitudes of their terms in double precision, (n, g, e).
    """

    def __init__(self, statics: Statics, index: Indices, unknowns: list[int]) -> None:
        change = Entries(index)
        self.statics, self.unknowns, self.count = statics, unknowns, len(index[0]) if index else 1
        self.kinematics = statics.kinematics.mapped(change)
        self.springs = [each.mapped(change) for each in statics.springs]
        self.extent = np.broadcast_to(change(extent(statics), 0), (self.count,)).astype(np.float64)
        rows, sizes = by_units(self.kinematics, self.springs, unknowns, Extended)
        if rows.ndim == 2:  # frames without members have no axis for their places
            rows, sizes = rows[:, None], sizes[:, None]
        whole = (len(unknowns), self.count, rows.shape[-1])
        self.columns = np.moveaxis(np.broadcast_to(rows, whole), 0, -1)
        self.sizes = np.broadcast_to(sizes, whole).astype(np.float64)
        self.double = self.columns.astype(np.float64)

    @cached_property
    def units(self) -> Real:
        """Displacements of the nodes per unit of each unknown, (n, g or 1, nodes, 6)."""
        unit = np.eye(len(self.unknowns), dtype=Extended)[:, None]
        none: list[Real | None] = [None] * len(self.kinematics.links)
        return self.kinematics.displacements(self.kinematics.coordinates(self.unknowns, unit, none))

    @cached_property
    def length_scale(self) -> Real:
        """Length of the longest piece, (g,)."""
        lengths = [np.max(each.length, axis=-1) for each in self.springs]
        found = reduce(np.maximum, lengths, extended(0.0))
        return np.broadcast_to(np.where(found > 0.0, found, self.statics.plan.frame.size), (self.count,))

    def deformation_sizes(self, coordinates: Real, spread: Array) -> Real:
        """Magnitudes of the terms of deformations, (r, g, e), from those of nodal displacements (r, g, nodes, 6)."""
        opened = self.kinematics.displacement_sizes(coordinates, extended(spread))
        members = [merged(each.sizes(extended(spread), coordinates), -2, -1) for each in self.springs]
        none = extended(np.zeros((1, 1, len(self.kinematics.idle))))
        return together([*members, *opened, none])

    def displaced(self, motions: Real) -> Real:
        """Displacements of the nodes in motions (r, g, n) of the unknowns, (r, g, nodes, 6)."""
        units = np.broadcast_to(self.units, (len(self.unknowns), self.count, *self.units.shape[2:]))
        found: Real = np.einsum("rgn,nguk->rguk", motions, units)
        return found

    def by_imposed(self, imposed: Sequence[tuple[int, int]]) -> tuple[Array, Array]:
        """Deformations per unit of each displacement imposed on a link, (u, g, e), and the magnitudes of their terms.

        The u imposed displacements are given as (number of the link, component).
        """
        units = units_of(imposed, len(self.kinematics.links))
        rest = extended(np.zeros((len(imposed), 1, len(self.unknowns))))
        _, *both = deformed_by_imposed(self.kinematics, self.springs, self.unknowns, rest, units)
        shape = (len(imposed), self.count, both[0].shape[-1])
        deformations, sizes = (np.broadcast_to(each.astype(np.float64), shape) for each in both)
        return deformations, sizes

    def strained(self, motions: Real) -> Real:
        """Deformations by motions (r, g, n) of the unknowns, (r, g, e)."""
        return _forth(self.columns, motions)

    def absolute(self, values: Real, own: Index, given: Real) -> Real:
        """Unknowns (..., m, n) in the frame's own coordinates, for geometries `own` (m,).

        `given` are the displacements of nodes by imposed displacements, (m or 1, nodes, 6).
        """
        out, at = values.copy(), own if len(self.units[0]) > 1 else np.zeros(1, dtype=np.int64)
        determinate = {link.child for link in self.kinematics.links if link.edge.kind == MEMBER}
        for k, unknown in enumerate(self.unknowns):
            node, component = divmod(unknown, 6)
            if node in determinate:
                by_unit = self.units[:, at, node, component]
                out[..., k] = given[..., node, component] + np.einsum("...mn,nm->...m", values, by_unit)
        return out


class ConstrainedMatrices:
    """m matrices with the same unknowns constrained.

    Parameters
    ----------
    frames
        The geometries.
    kept
        Indices of the unknowns that are not constrained.
    own
        Index of the geometry of each matrix, (m,).
    k
        Stiffness against the deformations, (m, e).
    """

    def __init__(self, frames: MovingGeometries, kept: Index, own: Index, k: Array) -> None:
        self.frames, self.kept, self.own, self.k = frames, kept, own, k
        sizes = frames.sizes[kept]
        found = DenseCompliance.of(frames.double[own][..., kept], sizes[:, own], k)
        rough = float(np.max(found.backward_error / np.where(found.least > 0.0, found.least, np.nan), initial=0.0))
        self.steps = _STEPS
        if 0.0 < rough <= _ROUGH:
            self.steps = math.ceil(math.log(_LEFT) / math.log(rough))
        elif rough != 0.0:
            found = DenseCompliance.of(frames.columns[own][..., kept], sizes[:, own].astype(Extended), k)
        self.root, self._inverse = found.root, found.inverse
        self.sure = np.broadcast_to(found.least > 0.0, own.shape)

    def balanced(self, load: Real, which: Index) -> tuple[Real, Real]:
        """Unknowns (..., n), the constrained ones zero, that balance loads (..., n) of the matrices `which`; and the
        residual, which is the constraint force.
        """
        own, k, kept = self.own[which], self.k[which], self.kept
        root, inverse = self.root[which], self._inverse[which]
        columns = self.frames.columns[own]
        left, out = load, extended(np.zeros(load.shape))
        for _ in range(self.steps):
            scaled = root * left[..., kept].astype(root.dtype)
            out[..., kept] += root * np.einsum("...ij,...j->...i", inverse, scaled)
            left = load - _back(columns, k * _forth(columns, out))
        return out, left

    def refined(self, motions: Array, take: Index) -> Real:
        """Refined free motions (r, g, n), from rough ones (r, m, n) of the geometries `take`.

        The largest displacement is one, rotations being multiplied by the length of the longest piece.
        """
        known, first = np.unique(self.own, return_index=True)
        first = first[np.searchsorted(known, take)]
        columns, rough, frames = self.frames.columns[take], extended(motions), self.frames
        left = -_back(columns, self.k[first] * _forth(columns, rough))
        out = extended(np.zeros((len(rough), frames.count, rough.shape[-1])))
        out[:, take] = rough + self.balanced(left, first)[0]
        moved = np.abs(frames.displaced(out))
        moved[..., 3:] *= frames.length_scale[:, None, None]
        largest = np.max(moved, axis=(-1, -2))
        return out / np.where(largest > 0.0, largest, 1.0)[..., None]


class _Loading:
    """Loads and imposed displacements of l entries.

    Attributes
    ----------
    load
        Loads on the unknowns, without imposed displacements, (l, n).
    forces, error_bound
        Forces on the nodes, and their error bounds, (l, nodes, 6).
    deformations, sizes
        Deformations by imposed displacements alone, (l, e), and the magnitudes of their terms.
    displacements
        Displacements of the nodes by imposed displacements alone, (l, nodes, 6).
    """

    def __init__(self, statics: Statics, index: Indices, unknowns: list[int]) -> None:
        change, kinematics = Entries(index), statics.kinematics.mapped(Entries(index))
        springs, loads = [each.mapped(change) for each in statics.springs], statics.loads.mapped(change)
        imposed = [None if each is None else change(each, 1) for each in statics.imposed]
        self.forces, self.error_bound = loads.forces, loads.error_bound
        none: list[Real | None] = [None] * len(kinematics.links)
        self.load = kinematics.reduced(unknowns, kinematics.generalised(loads.forces, none))
        rest = extended(np.zeros((1, len(unknowns))))
        self.displacements, self.deformations, self.sizes = deformed_by_imposed(
            kinematics, springs, unknowns, rest, imposed
        )

    @staticmethod
    def shape(statics: Statics) -> Shape:
        """Batch shape over which loads and imposed displacements vary, with all batch axes."""
        imposed = [each.shape[:-1] for each in statics.imposed if each is not None]
        loads = statics.loads
        return np.broadcast_shapes(geometry_shape(statics), loads.acting.shape[:-2], loads.rounded.shape[:-2], *imposed)


def _solved(
    statics: Statics, index: Indices, group: ConstrainedMatrices, which: Index, motions: Real
) -> ConstrainedSolution:
    """Solution of the entries at some indices, whose matrices are `which` of a group, with free motions (r, g, n)."""
    frames, own = group.frames, group.own[which]
    first, like = distinct(index, _Loading.shape(statics))
    loading = _Loading(statics, first, frames.unknowns)
    load = _some(loading.load, like) - _back(frames.columns[own], group.k[which] * _some(loading.deformations, like))
    values, left = group.balanced(load, which)
    whole = frames.absolute(values, own, _some(loading.displacements, like))
    moving = frames.absolute(motions, np.arange(frames.count), extended(np.zeros(loading.displacements.shape[1:])))
    work = np.abs(np.einsum("rmn,mn->rm", motions[:, own], left))
    driven = ~(work <= _least_work(loading, like, group, which, motions, values)).all(axis=0)
    return ConstrainedSolution(index, whole, moving[:, own], frames.length_scale[own], ~driven & group.sure[which])


def _least_work(
    loading: _Loading, like: Index, group: ConstrainedMatrices, which: Index, motions: Real, values: Real
) -> Real:
    """Bound on the rounding error in the work of loads on free motions (r, g, n), (r, m), for values (m, n) of the
    unknowns.
    """
    frames, own, fine = group.frames, group.own[which], EquilibriumResidual.fine
    none: list[Real | None] = [None] * len(frames.kinematics.links)
    coordinates = frames.kinematics.coordinates(frames.unknowns, motions, none)
    spread, moved = frames.kinematics.sizes(coordinates), np.abs(frames.displaced(motions)).astype(np.float64)
    # the rounding of a position is relative to its distance from the origin; a rotation acts on it
    off = np.max(moved[..., 3:], axis=-1) * frames.extent[:, None]
    moved[..., :3] += off[..., None]
    # in extended precision, in which the work of the smallest loads does not underflow
    forces = np.abs(_some(loading.forces, like))
    uncertain = _some(loading.error_bound, like) + fine * forces
    could = np.einsum("rmuk,muk->rm", moved[:, own], np.broadcast_to(forces, (len(own), *forces.shape[1:])))
    noise = np.sum(spread.astype(np.float64)[:, own] * uncertain, axis=(-1, -2))
    size = np.einsum("mn,nme->me", np.abs(values), frames.sizes[:, own])
    size = np.abs(group.k[which]) * (size + _some(loading.sizes, like))
    sizes = np.einsum("rgn,nge->rge", np.abs(motions).astype(np.float64), frames.sizes)
    noise = noise + fine * np.sum(sizes[:, own] * size, axis=-1)
    borne = np.abs(group.k[which] * (_forth(frames.columns[own], values) + _some(loading.deformations, like)))
    deformed = frames.deformation_sizes(coordinates, moved).astype(np.float64)
    could = could + np.einsum("rme,me->rm", deformed[:, own], borne)
    # a motion that is almost free carries a force of this size at displacements like the given ones
    borne_by_motion = np.sum(np.abs(frames.strained(motions))[:, own] * size, axis=-1)
    least: Real = GIVEN * could + COMPUTED * noise + borne_by_motion
    return least


def same_constrained(bases: Array, ranks: Index) -> Iterator[tuple[Index, Array, Index]]:
    """Groups of geometries that can have the same unknowns constrained: numbers, free motions (m, r, n), unknowns."""
    left = np.flatnonzero(ranks)
    while left.size:
        rank = int(ranks[left[0]])
        same = left[ranks[left] == rank]
        motions = bases[same, -rank:]
        constrained = np.sort(constrained_unknowns(motions[0]))
        independence = np.linalg.svd(motions[..., constrained], compute_uv=False)[..., -1]
        good = independence >= _ALIKE * independence[0]
        yield same[good], motions[good], constrained
        left = np.setdiff1d(left, same[good])


def units_of(imposed: Sequence[tuple[int, int]], links: int) -> list[Real | None]:
    """For each link, unit displacements (u, 1, 6) for the imposed ones, given as (number of the link, component)."""
    units: list[Real | None] = [None] * links
    for number, (link, component) in enumerate(imposed):
        known = units[link]
        one = extended(np.zeros((len(imposed), 1, 6))) if known is None else known
        one[number, ..., component] = 1.0
        units[link] = one
    return units


def imposed_components(statics: Statics) -> list[tuple[int, int]]:
    """The displacements that are imposed at any entry, as (number of the link, component)."""
    given = [(link, each) for link, each in enumerate(statics.imposed) if each is not None]
    return [(link, k) for link, each in given for k in range(6) if each[..., k].any()]


def imposed_at(statics: Statics, index: Indices, imposed: Sequence[tuple[int, int]]) -> Array:
    """Values of the imposed displacements at m entries, (u, m)."""
    count = len(index[0]) if index else 1
    given = [Entries(index)(np.asarray(statics.imposed[link])[..., k], 0).astype(np.float64) for link, k in imposed]
    return np.stack([np.zeros(count), *(np.broadcast_to(each, (count,)) for each in given)])[1:]


def deformed_by_imposed(
    kinematics: FrameKinematics, springs: list[Springs], unknowns: list[int], rest: Real, imposed: list[Real | None]
) -> tuple[Real, Real, Real]:
    """Displacements of the nodes (..., nodes, 6) and deformations (..., e) by displacements imposed on links, (..., 6).

    The magnitudes of the terms of the deformations come last; `rest` are zeros for the unknowns, (..., n).
    """
    coordinates = kinematics.coordinates(unknowns, rest, imposed)
    displacements, spread = kinematics.displacements(coordinates), kinematics.sizes(coordinates)
    relative = kinematics.relative_displacements(coordinates, displacements)
    opened = kinematics.displacement_sizes(coordinates, spread)
    given = [np.zeros((1, 6)) if each is None else each for each in imposed]
    idle = [extended(np.zeros((1, len(kinematics.idle))))]
    members = [merged(each.of(displacements, coordinates), -2, -1) for each in springs]
    deformations = together([*members, *map(np.subtract, relative, given), *idle])
    members = [merged(each.sizes(spread, coordinates), -2, -1) for each in springs]
    sizes = together([*members, *(a + np.abs(b) for a, b in zip(opened, given, strict=True)), *idle])
    return displacements, deformations, sizes


def stiffness_at(statics: Statics, index: Indices) -> Array:
    """Stiffness against deformations at m entries, (m or 1, e)."""
    change = Entries(index)
    kinematics, springs = statics.kinematics.mapped(change), [each.mapped(change) for each in statics.springs]
    stiffness = [change(each, 1) for each in statics.stiffness]
    return resistances(kinematics, springs, stiffness, 1).astype(np.float64)


def _forth(columns: Real, values: Real) -> Real:
    """Deformations (..., e) for values (..., n) of the unknowns."""
    found: Real = np.einsum("...en,...n->...e", columns, values)
    return found


def _back(columns: Real, forces: Real) -> Real:
    """Forces on the unknowns (..., n) for forces on the deformations (..., e)."""
    found: Real = np.einsum("...en,...e->...n", columns, forces)
    return found


def _some(array: Real, like: Index) -> Real:
    """Items of an array (l, ...) for m entries, given the item that each has; the array itself if it has one item."""
    return array if len(array) == 1 else array[like]
