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
from ..elementwise import contracted, less, square_root, where
from ..rotation import dot, times, transposed

Law = Callable[[Array], tuple[Array, Array, Array]]


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
    # of a chord that points back the sum cancels, and all that tells its direction is across
    across = ahead[1] * ahead[1] + ahead[2] * ahead[2]
    cosine = where(less(ahead[0], 0.0), across / (1.0 + np.abs(ahead[0])), 1.0 + ahead[0])
    chord_rotation = np.array([cosine, np.zeros_like(length), -ahead[2], ahead[1]])
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
    strain, _ = elongated(pieces, deformation)
    return times(pieces.stiffness, strain) if pieces.law is None else pieces.law(strain)[1]


def stress(pieces: Pieces, deformation: Array) -> Array:
    """Elongating force and both end moments (7, n, m), gradient of the strain energy by the deformation."""
    _, bent = elongated(pieces, deformation)
    out = strain_forces(pieces, deformation)
    out[1:] += out[0] * bent
    return out


def stiffness(pieces: Pieces, deformation: Array, generalised_force: Array) -> Array:
    """Derivative of `stress` (7, 7, n, m); `generalised_force` is the elongating force that resists further bowing."""
    _, bent = elongated(pieces, deformation)
    k = slope(pieces, deformation)
    rows = k + 0.0 * generalised_force
    rows[1:] += bent[:, None] * k[0]
    rows[:, 1:] += rows[:, :1] * bent[None]
    rows[1:, 1:] += generalised_force * pieces.bow
    return rows


def stress_change(pieces: Pieces, deformation: Array, generalised_force: Array, change: Array) -> Array:
    """`stiffness` times a change of the deformation (7, n, m)."""
    _, bent = elongated(pieces, deformation)
    stretched = np.concatenate([change[:1] + dot(bent, change[1:]), change[1:]])
    out = times(slope(pieces, deformation), stretched)
    out[1:] += out[0] * bent + generalised_force * times(pieces.bow, change[1:])
    return out


def strain_energy(pieces: Pieces, at: CorotatedPieces) -> Array:
    """Strain energy (n, m)."""
    strain, _ = elongated(pieces, at.deformation)
    if pieces.law is not None:
        return pieces.law(strain)[0]
    out: Array = 0.5 * dot(strain, times(pieces.stiffness, strain))
    return out


def elongated(pieces: Pieces, deformation: Array) -> tuple[Array, Array]:
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
        out = contracted("ab...,abj...,j...->...", at.turn, pieces.work, at.deformation)
    return out if pieces.tension is None else out - pieces.tension * at.deformation[0]


def _in_axes(local_axes: Array, q: Array) -> Array:
    """A quaternion with its axis in local components."""
    return np.concatenate([q[:1], times(local_axes, q[1:])])


def slope(pieces: Pieces, deformation: Array) -> Array:
    """Derivative of the forces by the strains (7, 7, n, m)."""
    return pieces.stiffness if pieces.law is None else pieces.law(elongated(pieces, deformation)[0])[2]
