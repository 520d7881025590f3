"""Forces and tangent of corotational pieces by the motion of their ends: the derivatives of the energy of `corotation`.

Only motions that deform the pieces matter. Components lead, as there.
"""

from __future__ import annotations

import numpy as np

from .. import rotation
from ..batch import Array
from ..elementwise import contracted, less, where, zeros
from ..rotation import times, transposed
from .corotation import CorotatedPieces, Pieces, elongated, slope

# Cosine up to which an angle is taken for a right one: beyond, the spin of the frame would change without bound.
_ROUND = 1e-5


class Response:
    """First and second derivatives of the energy, in the moving frame.

    As the frame follows, nine variations v bear on the energy: of ``u2 - u1``, and the spins of the two ends. With the
    spin ``G v`` of the frame, an end turns by ``p = spin - G v`` in it, and its rotation vector changes by ``T^-1 p``.
    So forces n on the deformations, with the moments ``m = T^-T n`` on the ends, are forces ``(n_0, 0, 0, m_1, m_2) -
    G^T (m_1 + m_2 + t)`` on the variations; t is the moment of dead loads that turn with nothing.

    Parameters
    ----------
    pieces
        The stack.
    at
        Where it is.
    """

    def __init__(self, pieces: Pieces, at: CorotatedPieces) -> None:
        self.pieces, self.at = pieces, at
        self.vectors = _ends(at.deformation[1:])
        self.back = rotation.inverse_tangent(self.vectors)
        self.lever = _lever(at)

    def deformed(self, ends: Array) -> Array:
        """Variation of the deformations (7, n, m) by that of the ends in global axes (12, n, m)."""
        moved = np.stack([ends[6:9] - ends[:3], ends[3:6], ends[9:]], axis=1)
        moved = times(transposed(self.at.axes)[:, :, None], moved)
        along = times(self.lever, np.concatenate([moved[:, k] for k in range(3)]))
        bent = times(self.back, moved[:, 1:] - along[:, None])
        return np.concatenate([moved[:1, 0], bent[:, 0], bent[:, 1]])

    def global_change(self) -> Array:
        """The same as a matrix (7, 12, n, m)."""
        out = zeros((7, 9, *self.at.chord.shape), self.at.chord)
        out[0, 0] = 1.0
        for end in range(2):
            beyond = -self.lever
            beyond[range(3), range(3 * end + 3, 3 * end + 6)] += 1.0
            out[3 * end + 1 : 3 * end + 4] = times(self.back[:, :, end], beyond)
        return transposed(_twelve(self._rotated(transposed(out))))

    def local_forces(self, stress: Array) -> Array:
        """Forces on the ends in the moving axes (12, n, m)."""
        return _twelve(self._forces(stress))

    def forces(self, stress: Array) -> Array:
        """Forces on the ends, in global axes (12, n, m)."""
        return _twelve(self._rotated(self._forces(stress)))

    def tangent(self, stress: Array, *, symmetric: bool = False) -> Array:
        """Derivative of `forces` by displacements and spins of the ends, global (12, 12, n, m).

        `stress` may differ from that of the deformation: it is what the geometric stiffness is made of. Where
        `symmetric`, it is the symmetric part of that.
        """
        force, torque, (mixed, spun) = self._loaded(stress)
        moments, total = self._moments(force, torque)
        own = self._own(stress[0], force, total, symmetric=symmetric)
        # What the ends turn less by, as the frame turns with them: the sum of rows, of columns and of both.
        rows, columns = own[3:6] + own[6:], own[:, 3:6] + own[:, 6:]
        both = rows[:, 3:6] + rows[:, 6:]
        if torque is not None:
            swept = self._by_spins(transposed(mixed))
            rows, columns = rows + swept, columns + transposed(swept)
            turned = swept[:, 3:6] + swept[:, 6:]
            both = both + turned + transposed(turned) - spun
        pushed = self._pushed(force, moments, total)
        carried = np.concatenate([rotation.spin(pushed[k : k + 3]) for k in (0, 3, 6)])
        if symmetric:
            half = times(transposed(self.lever), rows + 0.5 * (transposed(carried) - times(both, self.lever)))
            out = own - (half + transposed(half))
        else:
            columns = columns + carried - times(transposed(self.lever), both)
            out = own - times(transposed(self.lever), rows) - times(columns, self.lever)
        out = _both(self.at.axes, out)
        return transposed(_twelve(transposed(_twelve(_mirrored(out) if symmetric else out))))

    def _own(self, axial_force: Array, force: Array, total: Array, *, symmetric: bool) -> Array:
        """The tangent by the elongation and the turns of the ends in the frame, in the places of `v` (9, 9, n, m)."""
        at, even = self.at, _even if symmetric else _as_it_is
        _, bent = elongated(self.pieces, at.deformation)
        k = even(slope(self.pieces, at.deformation))
        arm, right, left = (self._by_end(each) for each in (bent, k[0, 1:], k[1:, 0]))
        row = k[0, 0] * arm + right
        beam = (k[1:, 1:] + axial_force * even(self.pieces.bow)).reshape(2, 3, 2, 3, *at.chord.shape)
        half = contracted("aci...,iajb...->icjb...", self.back, beam)
        beam = contracted("icjb...,bdj...->icjd...", half, self.back)
        turned = even(times(rotation.inverse_tangent_slope(self.vectors, _ends(force[1:])), self.back))
        twist = total[0] / _upright(at.ends[0] + at.ends[1])
        turned = turned - twist * _twist(np.stack(at.ends, axis=1), symmetric=symmetric)
        for end in range(2):
            beam[end, :, end] += turned[:, :, end]
        out = zeros((9, 9, *at.chord.shape), at.chord)
        out[0, 0] = k[0, 0]
        out[0, 3:], out[3:, 0] = row, k[0, 0] * arm + left
        out[3:, 3:] = beam.reshape(6, 6, *at.chord.shape) + rotation.outer(arm, row) + rotation.outer(left, arm)
        swung = self._swung(total, twist)
        out[1, 0], out[2, 0] = 0.5 * swung if symmetric else swung
        if symmetric:
            out[0, 1], out[0, 2] = out[1, 0], out[2, 0]
        return _mirrored(out) if symmetric else out

    def _swung(self, total: Array, twist: Array) -> Array:
        """What the lever of transverse displacements loses as the chord grows (2, n, m)."""
        chord, q = self.at.chord, self.at.ends[0] + self.at.ends[1]
        square = chord * chord
        out: Array = np.stack([(total[2] + twist * q[2]) / square, (twist * q[3] - total[1]) / square])
        return out

    def _by_end(self, values: Array) -> Array:
        """What acts on the rotation vectors of the ends (6, n, m), on their turns (6, n, m)."""
        turned = times(transposed(self.back), _ends(values))
        return np.concatenate([turned[:, 0], turned[:, 1]])

    def _by_spins(self, rows: Array) -> Array:
        """Rows by the deformations (i, 7, n, m) as rows by the elongation and the turns of the ends (i, 9, n, m)."""
        out = zeros((len(rows), 9, *rows.shape[2:]), rows)
        out[:, 0] = rows[:, 0]
        for end in range(2):
            out[:, 3 * end + 3 : 3 * end + 6] = times(rows[:, 3 * end + 1 : 3 * end + 4], self.back[:, :, end])
        return out

    def _moments(self, force: Array, torque: Array | None) -> tuple[Array, Array]:
        """Moments on the ends in the frame (6, n, m), and what turns the frame."""
        moments = self._by_end(force[1:])
        total = moments[:3] + moments[3:]
        return moments, total if torque is None else total + torque

    def _pushed(self, force: Array, moments: Array, total: Array) -> Array:
        """Forces on the variations (9, n, m)."""
        none = np.zeros_like(force[:2])
        out: Array = np.concatenate([force[:1], none, moments]) - times(transposed(self.lever), total)
        return out

    def _forces(self, stress: Array) -> Array:
        force, torque, _ = self._loaded(stress)
        return self._pushed(force, *self._moments(force, torque))

    def _rotated(self, rows: Array) -> Array:
        """Blocks of three components (9, ..., n, m) from the moving to the global axes."""
        split = rows.reshape(3, 3, *rows.shape[1:])
        pattern = "ij...,bj...->bi..." if rows.ndim == 3 else "ij...,bjk...->bik..."
        out: Array = contracted(pattern, self.at.axes, split)
        return out.reshape(rows.shape)

    def _loaded(self, stress: Array) -> tuple[Array, Array | None, tuple[Array, Array]]:
        """Forces on the deformations, tension included, less those of the loads between; moment of these loads; its
        derivatives."""
        work, at = self.pieces.work, self.at
        if self.pieces.tension is not None:
            stress = stress + self.pieces.tension * (np.arange(len(stress)) == 0)[:, None, None]
        if work is None:
            return stress, None, (stress, stress)
        seen = contracted("ab...,acj...->bcj...", at.turn, work)
        mixed = np.moveaxis(_axial(seen), 0, 1)
        whole = contracted("abj...,j...->ab...", seen, at.deformation)
        trace = whole[0, 0] + whole[1, 1] + whole[2, 2]
        spun = trace * np.eye(3)[..., None, None] - whole
        push = seen[0, 0] + seen[1, 1] + seen[2, 2]
        return stress - push, _axial(whole), (mixed, -spun)


def _lever(at: CorotatedPieces) -> Array:
    """Spin of the frame by the variations, all in the moving axes (3, 9, n, m)."""
    total = at.ends[0] + at.ends[1]
    out = zeros((3, 9, *at.chord.shape), at.chord)
    out[2, 1] = 1.0 / at.chord
    out[1, 2] = -out[2, 1]
    for end, q in enumerate(at.ends):
        row = 3 * end + 3
        out[0, row], out[0, row + 1], out[0, row + 2] = q[0], q[3], -q[2]
    out[0] += total[2] * out[2] - total[3] * out[1]
    out[0] /= _upright(total)
    return out


def _twist(q: Array, *, symmetric: bool) -> Array:
    """How an end's share in the twist of the frame changes as it turns in it (3, 3, ends, n, m)."""
    w, x, y, z = -0.5 * q
    if symmetric:
        out: Array = x * rotation.identity(q[1:])
        return out
    return np.array([[x, y, z], [-y, x, -w], [-z, w, x]])


def _upright(total: Array) -> Array:
    """Scalar part of the sum of the ends' quaternions, not zero where the chord has swung right round between them."""
    out: Array = where(less(np.abs(total[0]), _ROUND), _ROUND, total[0])
    return out


def _axial(a: Array) -> Array:
    """Moment of a dyad of force and arm, (3, ...) for (3, 3, ...)."""
    out: Array = np.stack([a[2, 1] - a[1, 2], a[0, 2] - a[2, 0], a[1, 0] - a[0, 1]])
    return out


def _ends(values: Array) -> Array:
    """Components of both ends (6, ...) as vectors of each (3, 2, ...)."""
    return np.stack([values[:3], values[3:]], axis=1)


def _twelve(rows: Array) -> Array:
    """What acts on the variations (9, ...) on the displacements and spins of both ends (12, ...)."""
    return np.concatenate([-rows[:3], rows[3:6], rows[:3], rows[6:]])


def _even(a: Array) -> Array:
    """Symmetric part of matrices (i, i, ...)."""
    out: Array = 0.5 * (a + transposed(a))
    return out


def _as_it_is(a: Array) -> Array:
    return a


def _mirrored(a: Array) -> Array:
    """Matrices whose lower half is taken from the upper: where it is recorded, one of them is calculated."""
    out = a.copy()
    first, second = np.triu_indices(len(out), 1)
    out[second, first] = out[first, second]
    return out


def _both(axes: Array, a: Array) -> Array:
    """A 9 x 9 matrix turned from the moving to the global axes on both sides."""
    split = a.reshape(3, 3, 3, 3, *a.shape[2:])
    half = contracted("ij...,bjcl...->bicl...", axes, split)
    out: Array = contracted("kl...,bicl...->bick...", axes, half)
    return out.reshape(a.shape)
