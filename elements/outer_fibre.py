"""Stress in the outer fibre of a circular section or tube, by bending, shear and torsion together."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..framework.protocol import Array
from .cross_section import greatest, split
from .parameters import Real

SAMPLES = 32
STEPS = 12
# Batch entries that are evaluated together, so that they stay in the processor's cache; and the step of the angle at
# which Newton's method ends, as the function is flat at its maximum.
BLOCK, SETTLED = 2048, 1e-8


def outer_fibre_stress(forces: Array, area: Real, inertia: Real, radius: Real, peak: Real) -> Array:
    """Least and greatest normal stress and greatest von Mises stress in the outer fibre, (..., 3).

    At the angle a, with y = R cos a and z = R sin a, the outer fibre carries ::

        normal     = N / A + (My sin a - Mz cos a) R / I
        tangential = T R / (2 I) + peak (Vz cos a - Vy sin a) / A

    Parameters
    ----------
    forces
        Internal forces ``N Vy Vz T My Mz``, (..., 6).
    area, inertia, radius
        Area A, second moment of area I about a diameter, and outer radius R, (...).
    peak
        Ratio of the shear stress at the neutral axis to the mean shear stress ``V / A``, (...).
    """
    N, Vy, Vz, T, My, Mz = split(forces)
    axial, bending = N / area, np.hypot(My, Mz) * radius / inertia
    normal = (axial, -Mz * radius / inertia, My * radius / inertia)
    root3 = np.sqrt(3.0)
    shear = (root3 * T * radius / (2.0 * inertia), root3 * peak * Vz / area, -root3 * peak * Vy / area)
    return np.stack(np.broadcast_arrays(axial - bending, axial + bending, _greatest(normal, shear)), axis=-1)


def _greatest(*waves: tuple[Real, Real, Real]) -> Array:
    """Maximum over the angle a of the square root of the sum of (p + q cos a + r sin a)^2, (...).

    The sum is a trigonometric polynomial of degree two, which has at most two maxima. The two highest local maxima
    among the samples are refined by Newton steps no longer than the distance of two samples.
    """
    sizes = [np.abs(p) + np.hypot(q, r) for p, q, r in waves]
    scale = greatest(*sizes)
    scale = np.where(scale > 0.0, scale, 1.0)
    parts = [[np.broadcast_to(part / scale, scale.shape).reshape(-1) for part in wave] for wave in waves]
    out = np.empty(scale.size)
    for start in range(0, scale.size, BLOCK):
        some = slice(start, start + BLOCK)
        out[some] = _highest([(p[some], q[some], r[some]) for p, q, r in parts])
    return np.asarray(scale * np.sqrt(out.reshape(scale.shape)))


def _highest(waves: Sequence[tuple[Array, Array, Array]]) -> Array:
    """Maximum over the angle a of the sum of (p + q cos a + r sin a)^2, (n,)."""

    def height(c: Array, s: Array) -> Array:
        return np.asarray(sum((p + q * c + r * s) ** 2 for p, q, r in waves))

    step = 2.0 * np.pi / SAMPLES
    angles = step * np.arange(SAMPLES)
    cosines, sines = np.cos(angles), np.sin(angles)
    value = height(cosines[:, None], sines[:, None])
    higher = value[1:] >= value[:-1]
    peak = np.empty(value.shape, dtype=bool)
    peak[1:-1] = higher[:-1] & (value[1:-1] >= value[2:])
    peak[0] = (value[0] >= value[-1]) & (value[0] >= value[1])
    peak[-1] = higher[-1] & (value[-1] >= value[0])
    peaks = np.where(peak, value, -1.0)
    first = np.argmax(peaks, axis=0)
    best = value.max(axis=0)
    np.put_along_axis(peaks, first[None], -2.0, axis=0)
    which = np.stack([first, np.argmax(peaks, axis=0)])
    c, s = cosines[which], sines[which]
    for _ in range(STEPS):
        slope, bow = _derivatives(waves, c, s)
        near = np.abs(slope) < step * np.abs(bow)
        turn = np.divide(slope, np.abs(bow), out=step * np.sign(slope), where=near)
        # Rotate by the angle 2 atan(t), whose cosine and sine are rational in t.
        t = 0.5 * turn
        whole = 1.0 / (1.0 + t * t)
        cosine, sine = (1.0 - t * t) * whole, 2.0 * t * whole
        c, s = c * cosine - s * sine, s * cosine + c * sine
        if np.abs(turn).max(initial=0.0) < SETTLED:
            break
    size = np.hypot(c, s)
    found: Array = np.maximum(height(c / size, s / size).max(axis=0), best)
    return found


def _derivatives(waves: Sequence[tuple[Array, Array, Array]], c: Array, s: Array) -> tuple[Array, Array]:
    """Half of the first and second derivative, by the angle, of the sum in `_highest`."""
    slope, bow = np.zeros(()), np.zeros(())
    for p, q, r in waves:
        swing = q * c + r * s
        wave, turn = p + swing, r * c - q * s
        slope, bow = slope + wave * turn, bow + turn * turn - wave * swing
    return slope, bow
