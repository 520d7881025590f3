"""The plane as complex numbers: x + i y, turned by a product, and back to 3-vectors for the world."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]


def vector(point: Complex) -> Array:
    """Points x + i y, (...), as vectors (..., 3) in the plane z = 0."""
    point = np.asarray(point, dtype=np.complex128)
    found = np.zeros((*point.shape, 3))
    found[..., 0], found[..., 1] = point.real, point.imag
    return found


def cross(first: Complex, second: Complex) -> Array:
    """z component of the product of two vectors, (...): the moment of the force `second` at the arm `first`."""
    product: Array = np.asarray((np.conj(first) * second).imag)
    return product


def rotation(direction: Complex) -> Array:
    """Axes (..., 3, 3), as columns, of a body whose x axis is the unit vector `direction`; its z axis is global z."""
    direction = np.asarray(direction, dtype=np.complex128)
    axes = np.zeros((*direction.shape, 3, 3))
    axes[..., 0, 0] = axes[..., 1, 1] = direction.real
    axes[..., 1, 0], axes[..., 2, 2] = direction.imag, 1.0
    np.negative(direction.imag, out=axes[..., 0, 1])
    return axes


def dyad(chord: Complex, first: Array, second: Array, side: Array) -> Complex:
    """Close two bars over `chord`: the vector from its start to the pin that joins them.

    The pin is where the circle of radius `first` about the chord's start meets that of radius `second` about its
    end. With s the chord's length and X twice the triangle's signed area,

        u = ((s² + b² − c²)/2 + i X) / conj(chord),    16 area² = ((b + c)² − s²)(s² − (b − c)²)

    Parameters
    ----------
    chord
        Vector from the first centre to the second, (...).
    first, second
        Lengths b and c of the two bars, (...).
    side
        +1 for a pin to the left of the chord, -1 to its right, (...).

    Returns
    -------
    ndarray
        Pin relative to the first centre, (...); NaN where the circles do not meet.
    """
    s = np.abs(chord)
    with np.errstate(invalid="ignore", divide="ignore"):
        area = 0.5 * np.sqrt((first + second - s) * (first + second + s) * (s - first + second) * (s + first - second))
        along = 0.5 * (s * s + (first - second) * (first + second))
        return np.asarray((along + 1j * (side * area)) / np.conj(chord), dtype=np.complex128)
