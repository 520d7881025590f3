"""Stress on the rim of a circular section."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..framework.protocol import Array
from .cross_section import greatest, split
from .parameters import Real

SAMPLES = 32
STEPS = 12


def rim_stress(forces: Array, area: Real, inertia: Real, radius: Real, peak: Real) -> Array:
    """Least and greatest normal stress and greatest von Mises stress on a rim, (..., 3).

    At the angle a, with y = R cos a and z = R sin a, the rim carries ::

        normal     = N / A + (My sin a - Mz cos a) R / I
        tangential = T R / (2 I) + peak (Vz cos a - Vy sin a) / A

    Parameters
    ----------
    forces
        ``N Vy Vz T My Mz``, (..., 6).
    area, inertia, radius
        A, I about a diameter, and R, (...).
    peak
        Shear stress at the neutral axis over the mean one, (...).
    """
    N, Vy, Vz, T, My, Mz = split(forces)
    axial, bending = N / area, np.hypot(My, Mz) * radius / inertia
    normal = (axial, -Mz * radius / inertia, My * radius / inertia)
    root3 = np.sqrt(3.0)
    shear = (root3 * T * radius / (2.0 * inertia), root3 * peak * Vz / area, -root3 * peak * Vy / area)
    return np.stack(np.broadcast_arrays(axial - bending, axial + bending, _greatest(normal, shear)), axis=-1)


def _greatest(*waves: tuple[Real, Real, Real]) -> Array:
    """Maximum over the angle of the root of the sum of (p + q cos a + r sin a)^2.

    The square is a trigonometric polynomial of degree two: it has at most two maxima. The two
    best of the samples are led uphill by Newton steps no longer than a sample's distance.
    """

    def derivatives(angle: NDArray[np.floating]) -> tuple[Array, Array]:
        slope, bow = np.zeros(()), np.zeros(())
        c, s = np.cos(angle), np.sin(angle)
        for p, q, r in waves:
            wave, turn = p + q * c + r * s, r * c - q * s
            slope, bow = slope + wave * turn, bow + turn**2 - wave * (wave - p)
        return slope, bow

    def height(angle: NDArray[np.floating]) -> Array:
        c, s = np.cos(angle), np.sin(angle)
        return np.asarray(sum((p + q * c + r * s) ** 2 for p, q, r in waves))

    sizes = [np.abs(p) + np.hypot(q, r) for p, q, r in waves]
    scale = greatest(*sizes)
    scale = np.where(scale > 0.0, scale, 1.0)
    waves = tuple((p / scale, q / scale, r / scale) for p, q, r in waves)
    shape = scale.shape
    step = 2.0 * np.pi / SAMPLES
    angles = (step * np.arange(SAMPLES)).reshape((SAMPLES,) + (1,) * len(shape))
    value = np.broadcast_to(height(angles), (SAMPLES, *shape))
    peak = (value >= np.roll(value, 1, axis=0)) & (value >= np.roll(value, -1, axis=0))
    peaks = np.where(peak, value, -1.0)
    first = np.argmax(peaks, axis=0)[None]
    np.put_along_axis(peaks, first, -2.0, axis=0)
    angle = step * np.concatenate([first, np.argmax(peaks, axis=0)[None]])
    for _ in range(STEPS):
        slope, bow = derivatives(angle)
        near = np.abs(slope) < step * np.abs(bow)
        angle = angle + np.divide(slope, np.abs(bow), out=step * np.sign(slope), where=near)
    return np.asarray(scale * np.sqrt(np.max(np.maximum(height(angle), value.max(axis=0)), axis=0)))
