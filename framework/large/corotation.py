"""Corotational members: an element's own linear stiffness in a frame that follows its chord.

The frame's x axis is the chord and its twist the mean of the ends' (the x components of the ends' quaternions, seen
from the frame, add up to zero). What the ends do beyond the frame is small where pieces are short: an elongation and
two rotation vectors, on which the linear stiffness acts; the axis is longer than its chord by its bow, for which the
element's geometric stiffness stands (as in shallow arches: Crisfield, Non-linear Finite Element Analysis of Solids and
Structures, vol. 1, 1991, sec. 7.3). So any linear element takes part in finite motion (Rankin &
Nour-Omid, Comput. Struct. 30 (1988) 257-267; Felippa & Haugen, Comput. Methods Appl. Mech. Engrg. 194 (2005)
2285-2335; local rotation vectors as in Battini & Pacoste, ibid. 191 (2002) 1755-1789).

Components lead, then the piece, then the batch entry: (3, pieces, entries). Variations of an end's rotation are spins.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from .. import rotation
from ..batch import Array
from ..elementwise import less, square_root, where, zeros
from ..rotation import dot, times, transposed

Law = Callable[[Array], tuple[Array, Array, Array]]

# Cosine that is one of a right angle, by rounding.
_ROUND = float(np.finfo(np.float64).eps)


@dataclass(frozen=True)
class Pieces:
    """Numbers of a stack of pieces.

    Attributes
    ----------
    local_axes
        Local axes at the start, as rows (3, 3, n, m).
    length
        (n, m).
    stiffness
        Of the seven deformations (7, 7, n, m).
    bow
        Matrix of the elongation ``1/2 p.G p`` of the bent axis by the six end rotations p (6, 6, n, m): the geometric
        stiffness of a unit axial force.
    work
        Work of the dead loads between the ends on a unit of each deformation, by component of load in the axes at the
        start and of displacement in the moving frame (3, 3, 7, n, m); None without such loads.
    tension
        Force along the chord that does not depend on its elongation (n, m); None without one.
    law
        Energy (n, m), forces (7, n, m) and tangent (7, 7, n, m) at strains (7, n, m), in place of the stiffness; None
        without a law.
    free
        Strains that take no force, such as those of heat (7, n, m); None without.
    """

    local_axes: Array
    length: Array
    stiffness: Array
    bow: Array
    work: Array | None
    tension: Array | None = None
    law: Law | None = None
    free: Array | None = None


@dataclass(frozen=True)
class CorotatedPieces:
    """Where pieces are: moving frame and deformation.

    Attributes
    ----------
    turn
        The moving axes as columns in the axes at the start (3, 3, n, m).
    axes
        The moving axes as columns in global axes (3, 3, n, m).
    chord
        Present length of the chord (n, m).
    ends
        Quaternions of the two ends, seen from the frame.
    deformation
        Elongation and both rotation vectors (7, n, m).
    """

    turn: Array
    axes: Array
    chord: Array
    ends: tuple[Array, Array]
    deformation: Array


def motion(pieces: Pieces, displacements: tuple[Array, Array], rotations: tuple[Array, Array]) -> CorotatedPieces:
    """Frame and deformation for the displacements (3, n, m) and quaternions (4, n, m) of the ends, global.

    Only differences from the start enter, so that small displacements keep their digits.
    """
    first, second = (_in_axes(pieces.local_axes, q) for q in rotations)
    along = times(pieces.local_axes, displacements[1] - displacements[0])
    second = where(less(dot(first, second), 0.0), -second, second)
    mean = rotation.normalised(first + second)
    chord = along.copy()
    chord[0] += pieces.length
    length = square_root(dot(chord, chord))
    ahead = times(transposed(rotation.matrix(mean)), chord) / length
    chord_rotation = np.array([1.0 + ahead[0], np.zeros_like(length), -ahead[2], ahead[1]])
    swung = less(-dot(chord_rotation, chord_rotation), 0.0)
    chord_rotation[3] = where(swung, chord_rotation[3], 1.0)  # else right round, in any plane
    frame = rotation.product(mean, rotation.normalised(chord_rotation))
    back = rotation.conjugate(frame)
    ends = rotation.product(back, first), rotation.product(back, second)
    elongation = (2.0 * pieces.length * along[0] + dot(along, along)) / (length + pieces.length)
    deformation = np.concatenate([elongation[None], *(rotation.logarithm(end) for end in ends)])
    turn = rotation.matrix(frame)
    return CorotatedPieces(turn, times(transposed(pieces.local_axes), turn), length, ends, deformation)


def strain_forces(pieces: Pieces, deformation: Array) -> Array:
    """Gradient of the strain energy by the strains (7, n, m)."""
    strain, _ = _strain(pieces, deformation)
    return times(pieces.stiffness, strain) if pieces.law is None else pieces.law(strain)[1]


def stress(pieces: Pieces, deformation: Array) -> Array:
    """Elongating force and both end moments (7, n, m), gradient of the strain energy by the deformation."""
    _, bent = _strain(pieces, deformation)
    out = strain_forces(pieces, deformation)
    out[1:] += out[0] * bent
    return out


def stiffness(pieces: Pieces, deformation: Array, generalised_force: Array) -> Array:
    """Derivative of `stress` (7, 7, n, m); `generalised_force` is the elongating force that resists further bowing."""
    strain, bent = _strain(pieces, deformation)
    k = pieces.stiffness if pieces.law is None else pieces.law(strain)[2]
    rows = k + 0.0 * generalised_force
    rows[1:] += bent[:, None] * k[0]
    rows[:, 1:] += rows[:, :1] * bent[None]
    rows[1:, 1:] += generalised_force * pieces.bow
    return rows


def strain_energy(pieces: Pieces, at: CorotatedPieces) -> Array:
    """Strain energy (n, m)."""
    strain, _ = _strain(pieces, at.deformation)
    if pieces.law is not None:
        return pieces.law(strain)[0]
    out: Array = 0.5 * dot(strain, times(pieces.stiffness, strain))
    return out


def _strain(pieces: Pieces, deformation: Array) -> tuple[Array, Array]:
    """Elongation of the axis, its bow included, with the rotations, less what takes no force (7, n, m); and the bow's
    derivative (6, n, m)."""
    rotations = deformation[1:]
    bent = times(pieces.bow, rotations)
    axis = deformation[0] + 0.5 * dot(rotations, bent)
    strain = np.concatenate([axis[None], rotations])
    return strain if pieces.free is None else strain - pieces.free, bent


def work(pieces: Pieces, at: CorotatedPieces) -> Array:
    """Work of tensions, and of the loads between the ends beyond that of their shares at the ends (n, m)."""
    out: Array = np.zeros_like(at.chord)
    if pieces.work is not None:
        out = np.einsum("ab...,abj...,j...->...", at.turn, pieces.work, at.deformation)
    return out if pieces.tension is None else out - pieces.tension * at.deformation[0]


class Response:
    """First and second derivatives of the energy, in the moving frame.

    With the deformations d, their variation ``B v`` and the spin ``G v`` of the frame for a variation v of the ends,
    the forces on the ends are ``B^T n - G^T t``; n are the forces on the deformations and t the moment of dead loads
    that turn with nothing.

    Parameters
    ----------
    pieces
        The stack.
    at
        Where it is.
    """

    def __init__(self, pieces: Pieces, at: CorotatedPieces) -> None:
        self.pieces, self.at = pieces, at
        first, second = (at.deformation[1:4], at.deformation[4:7])
        self.back = rotation.inverse_tangent(first), rotation.inverse_tangent(second)
        self.lever = _lever(at)
        self.beyond = tuple(-self.lever for _ in range(2))
        for end, share in enumerate(self.beyond):
            share[range(3), range(6 * end + 3, 6 * end + 6)] += 1.0
        self.change = zeros((7, 12, *at.chord.shape), at.chord)
        self.change[0, 0], self.change[0, 6] = -1.0, 1.0
        self.change[1:4] = times(self.back[0], self.beyond[0])
        self.change[4:7] = times(self.back[1], self.beyond[1])

    def rotated(self, vectors: Array) -> Array:
        """Blocks of three components (12, ..., n, m) from the moving to the global axes."""
        split = vectors.reshape(4, 3, *vectors.shape[1:])
        pattern = "ij...,bj...->bi..." if vectors.ndim == 3 else "ij...,bjk...->bik..."
        out: Array = np.einsum(pattern, self.at.axes, split)
        return out.reshape(vectors.shape)

    def global_change(self) -> Array:
        """Variation of the deformations by that of the ends in global axes (7, 12, n, m)."""
        return transposed(self.rotated(transposed(self.change)))

    def local_forces(self, stress: Array) -> Array:
        """Forces on the ends in the moving axes (12, n, m)."""
        generalised_force, torque, _ = self._loaded(stress)
        out: Array = np.einsum("ji...,j...->i...", self.change, generalised_force)
        return out if torque is None else out - np.einsum("ji...,j...->i...", self.lever, torque)

    def forces(self, stress: Array) -> Array:
        """Forces on the ends, in global axes (12, n, m)."""
        return self.rotated(self.local_forces(stress))

    def tangent(self, stress: Array, *, symmetric: bool = False) -> Array:
        """Derivative of `forces` by displacements and spins of the ends, global (12, 12, n, m).

        `stress` may differ from that of the deformation: it is what the geometric stiffness is made of. Where
        `symmetric`, it is the symmetric part of that.
        """
        change, lever = self.change, self.lever
        generalised_force, torque, turning = self._loaded(stress)
        congruent = _symmetric_congruent if symmetric else _congruent
        out = congruent(change, stiffness(self.pieces, self.at.deformation, stress[0]))
        moments = [
            times(transposed(back), generalised_force[k : k + 3]) for back, k in zip(self.back, (1, 4), strict=True)
        ]
        for end, k in enumerate((1, 4)):
            slope = rotation.inverse_tangent_slope(self.at.deformation[k : k + 3], generalised_force[k : k + 3])
            out += congruent(self.beyond[end], times(slope, self.back[end]))
        total = moments[0] + moments[1]
        if torque is not None:
            total = total + torque
            mixed, spun = turning
            swept = times(mixed, lever)
            out -= times(transposed(change), swept) + times(transposed(swept), change)
            out -= _congruent(lever, spun)
        out -= self._lever_change(total)
        local = self.local_forces(stress)
        for block in range(4):
            rows = slice(3 * block, 3 * block + 3)
            out[rows] -= times(rotation.spin(local[rows]), lever)
        return _both(self.at.axes, 0.5 * (out + transposed(out)) if symmetric else out)

    def _loaded(self, stress: Array) -> tuple[Array, Array | None, tuple[Array, Array]]:
        """Forces on the deformations, tension included, less those of the loads between; moment of these loads; its
        derivatives."""
        work, at = self.pieces.work, self.at
        if self.pieces.tension is not None:
            stress = stress + self.pieces.tension * (np.arange(len(stress)) == 0)[:, None, None]
        if work is None:
            return stress, None, (stress, stress)
        seen = np.einsum("ab...,acj...->bcj...", at.turn, work)
        mixed = np.moveaxis(_axial(seen), 0, 1)
        whole = np.einsum("abj...,j...->ab...", seen, at.deformation)
        trace = np.einsum("aa...->...", whole)
        spun = trace * np.eye(3)[..., None, None] - whole
        push = np.einsum("bbj...->j...", seen)
        return stress - push, _axial(whole), (mixed, -spun)

    def _lever_change(self, moment: Array) -> Array:
        """Derivative of ``G^T moment`` at a constant moment (12, 12, n, m)."""
        at, lever = self.at, self.lever
        stretch = self.change[0] / at.chord
        total = at.ends[0] + at.ends[1]
        across = moment[1] * lever[1] + moment[2] * lever[2]
        tilt = total[3] * lever[1] - total[2] * lever[2]
        twist = rotation.outer(tilt, stretch)
        sums = zeros((4, *lever.shape[1:]), lever)
        for end, share in enumerate(self.beyond):
            q = at.ends[end]
            scalar = -0.5 * np.einsum("i...,ij...->j...", q[1:], share)
            vector = 0.5 * (q[0] * share - times(rotation.spin(q[1:]), share))
            sums += np.concatenate([scalar[None], vector])
            row = 6 * end + 3
            twist[row] += scalar
            twist[row + 1] += vector[2]
            twist[row + 2] -= vector[1]
        twist += (
            rotation.outer(lever[2], sums[2]) - rotation.outer(lever[1], sums[3]) - rotation.outer(lever[0], sums[0])
        )
        out: Array = moment[0] / _upright(total) * twist - rotation.outer(across, stretch)
        return out


def _in_axes(local_axes: Array, q: Array) -> Array:
    """A quaternion with its axis in local components."""
    return np.concatenate([q[:1], times(local_axes, q[1:])])


def _lever(at: CorotatedPieces) -> Array:
    """Spin of the frame by displacements and spins of the ends, all in the moving axes (3, 12, n, m)."""
    total = at.ends[0] + at.ends[1]
    out = zeros((3, 12, *at.chord.shape), at.chord)
    out[1, 2] = 1.0 / at.chord
    out[1, 8] = -out[1, 2]
    out[2, 1] = -out[1, 2]
    out[2, 7] = out[1, 2]
    for end, q in enumerate(at.ends):
        row = 6 * end + 3
        out[0, row], out[0, row + 1], out[0, row + 2] = q[0], q[3], -q[2]
    out[0] += total[2] * out[2] - total[3] * out[1]
    out[0] /= _upright(total)
    return out


def _upright(total: Array) -> Array:
    """Scalar part of the sum of the ends' quaternions, not zero where the chord has swung right round between them."""
    out: Array = where(less(np.abs(total[0]), _ROUND), _ROUND, total[0])
    return out


def _axial(a: Array) -> Array:
    """Moment of a dyad of force and arm, (3, ...) for (3, 3, ...)."""
    out: Array = np.stack([a[2, 1] - a[1, 2], a[0, 2] - a[2, 0], a[1, 0] - a[0, 1]])
    return out


def _congruent(change: Array, matrix: Array) -> Array:
    """``B^T A B`` for (i, k, ...) and (i, j, ...)."""
    return times(transposed(change), times(matrix, change))


def _symmetric_congruent(change: Array, matrix: Array) -> Array:
    """Symmetric part of ``B^T A B``, of which one half is calculated where it is recorded."""
    out = _congruent(change, 0.5 * (matrix + transposed(matrix)))
    first, second = np.triu_indices(len(out), 1)
    out[first, second] = out[second, first]
    return out


def _both(axes: Array, a: Array) -> Array:
    """A 12 x 12 matrix turned from the moving to the global axes on both sides."""
    split = a.reshape(4, 3, 4, 3, *a.shape[2:])
    half = np.einsum("ij...,bjcl...->bicl...", axes, split)
    out: Array = np.einsum("kl...,bicl...->bick...", axes, half)
    return out.reshape(a.shape)
