"""How corotational pieces respond to motions of their ends: forces and tangent, from the derivatives of their energy.

Only motions that deform them bear on it. See `corotation`; components lead, as there.
"""

from __future__ import annotations

import numpy as np

from .. import rotation
from ..batch import Array
from ..elementwise import less, where, zeros
from ..rotation import times, transposed
from .corotation import CorotatedPieces, Pieces, elongated, slope

# Cosine that is one of a right angle, by rounding.
_ROUND = float(np.finfo(np.float64).eps)


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
        self.vectors = at.deformation[1:4], at.deformation[4:7]
        self.back = rotation.inverse_tangent(self.vectors[0]), rotation.inverse_tangent(self.vectors[1])
        self.lever = _lever(at)

    def deformed(self, ends: Array) -> Array:
        """Variation of the deformations (7, n, m) by that of the ends in global axes (12, n, m)."""
        turn = transposed(self.at.axes)
        apart, *spins = (times(turn, each) for each in (ends[6:9] - ends[:3], ends[3:6], ends[9:]))
        along = times(self.lever, np.concatenate([apart, *spins]))
        bent = [times(back, each - along) for back, each in zip(self.back, spins, strict=True)]
        return np.concatenate([apart[:1], *bent])

    def global_change(self) -> Array:
        """The same as a matrix (7, 12, n, m)."""
        out = zeros((7, 9, *self.at.chord.shape), self.at.chord)
        out[0, 0] = 1.0
        for end, back in enumerate(self.back):
            beyond = -self.lever
            beyond[range(3), range(3 * end + 3, 3 * end + 6)] += 1.0
            out[3 * end + 1 : 3 * end + 4] = times(back, beyond)
        return transposed(_twelve(self._turned(transposed(out))))

    def local_forces(self, stress: Array) -> Array:
        """Forces on the ends in the moving axes (12, n, m)."""
        return _twelve(self._forces(stress))

    def forces(self, stress: Array) -> Array:
        """Forces on the ends, in global axes (12, n, m)."""
        return _twelve(self._turned(self._forces(stress)))

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
        inner = k[1:, 1:] + axial_force * even(self.pieces.bow)
        arm, right, left = (self._by_end(each) for each in (bent, k[0, 1:], k[1:, 0]))
        twist = total[0] / _upright(at.ends[0] + at.ends[1])
        out = zeros((9, 9, *at.chord.shape), at.chord)
        out[0, 0] = k[0, 0]
        for i, (a, back) in enumerate(zip(arm, self.back, strict=True)):
            rows = slice(3 * i + 3, 3 * i + 6)
            out[0, rows], out[rows, 0] = k[0, 0] * a + right[i], k[0, 0] * a + left[i]
            for j in range(i if symmetric else 0, 2):
                columns, beam = slice(3 * j + 3, 3 * j + 6), inner[3 * i : 3 * i + 3, 3 * j : 3 * j + 3]
                block = times(transposed(back), times(beam, self.back[j]))
                block = block + rotation.outer(a, k[0, 0] * arm[j] + right[j]) + rotation.outer(left[i], arm[j])
                if i == j:
                    turned = rotation.inverse_tangent_slope(self.vectors[i], force[3 * i + 1 : 3 * i + 4])
                    block = block + even(times(turned, back)) - twist * _twist(at.ends[i], symmetric=symmetric)
                out[rows, columns] = block
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

    def _by_end(self, values: Array) -> tuple[Array, Array]:
        """What acts on the end rotations (6, n, m), by the turns of each end (3, n, m)."""
        first, second = (times(transposed(each), values[k : k + 3]) for each, k in zip(self.back, (0, 3), strict=True))
        return first, second

    def _by_spins(self, rows: Array) -> Array:
        """Rows by the deformations (i, 7, n, m) as rows by the elongation and the turns of the ends (i, 9, n, m)."""
        out = zeros((len(rows), 9, *rows.shape[2:]), rows)
        out[:, 0] = rows[:, 0]
        for k, back in zip((1, 4), self.back, strict=True):
            out[:, k + 2 : k + 5] = times(rows[:, k : k + 3], back)
        return out

    def _moments(self, force: Array, torque: Array | None) -> tuple[tuple[Array, Array], Array]:
        """Moments on the ends in the frame, and what turns the frame."""
        first, second = self._by_end(force[1:])
        return (first, second), first + second if torque is None else first + second + torque

    def _pushed(self, force: Array, moments: tuple[Array, Array], total: Array) -> Array:
        """Forces on the variations (9, n, m)."""
        none = np.zeros_like(force[:2])
        out: Array = np.concatenate([force[:1], none, *moments]) - times(transposed(self.lever), total)
        return out

    def _forces(self, stress: Array) -> Array:
        force, torque, _ = self._loaded(stress)
        return self._pushed(force, *self._moments(force, torque))

    def _turned(self, rows: Array) -> Array:
        """Blocks of three components (9, ..., n, m) from the moving to the global axes."""
        split = rows.reshape(3, 3, *rows.shape[1:])
        pattern = "ij...,bj...->bi..." if rows.ndim == 3 else "ij...,bjk...->bik..."
        out: Array = np.einsum(pattern, self.at.axes, split)
        return out.reshape(rows.shape)

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
    """How an end's share in the twist of the frame changes as it turns in it (3, 3, n, m)."""
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
    half = np.einsum("ij...,bjcl...->bicl...", axes, split)
    out: Array = np.einsum("kl...,bicl...->bick...", axes, half)
    return out.reshape(a.shape)
