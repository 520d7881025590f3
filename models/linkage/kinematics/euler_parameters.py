"""Euler parameters of ball joints: their rates, and unit length."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from .terms import Value


def unit_length(e: Sequence[Value]) -> list[Value]:
    """Euler parameters scaled to unit length."""
    a, b, c, d = e
    square = a * a + b * b + c * c + d * d
    norm = math.sqrt(square) if isinstance(square, float) else np.sqrt(square)
    return [a / norm, b / norm, c / norm, d / norm]


def euler_parameter_rate(e: Sequence[Value], omega: Sequence[Value]) -> list[Value]:
    """Rate of Euler parameters at an angular velocity along the axes on the first link: half of (0, ω) times e."""
    a, b, c, d = e
    x, y, z = omega
    return [
        -0.5 * (x * b + y * c + z * d),
        0.5 * (x * a + y * d - z * c),
        0.5 * (y * a + z * b - x * d),
        0.5 * (z * a + x * c - y * b),
    ]


def angular_velocity_of(e: Sequence[Value], rate: Sequence[Value]) -> list[Value]:
    """Angular velocity, along the axes on the first link, at a rate of the Euler parameters: inverse of
    `euler_parameter_rate`."""
    (a, b, c, d), (p, q, r, s) = e, rate
    return [
        2.0 * (q * a - p * b - r * d + s * c),
        2.0 * (r * a - p * c - s * b + q * d),
        2.0 * (s * a - p * d - q * c + r * b),
    ]
