"""Finite rotation: quaternions, rotation vectors and their derivatives, components first and batch axes behind.

A rotation vector turns about its own direction by its length. Quaternions are (4, ...), scalar first: they keep the
relative digits of a small rotation, which a matrix does not.
"""

from __future__ import annotations

from math import factorial

import numpy as np

from .batch import Array
from .elementwise import (
    angle,
    contracted,
    cosine,
    is_recorded,
    less,
    maximum,
    minimum,
    rounded,
    sinc,
    sine,
    square_root,
    where,
)

# Up to this angle coefficients are summed as series, above it in closed form; both to rounding.
_SERIES = 1.0
_TERMS = 11
# Coefficients of (1 - (a/2) cot(a/2)) / a^2 in even powers: |Bernoulli number| / (2k)!, for k = 1, 2, ...
_COTANGENT = [1 / 12, 1 / 720, 1 / 30240, 1 / 1209600, 1 / 47900160, 691 / 1307674368000, 1 / 74724249600]
_COTANGENT += [_COTANGENT[-1] / (4.0 * np.pi**2) ** k for k in range(1, 6)]


def cross(a: Array, b: Array) -> Array:
    """Cross product of (3, ...) and (3, ...)."""
    out: Array = np.stack([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])
    return out


def dot(a: Array, b: Array) -> Array:
    """Scalar product of (n, ...) and (n, ...)."""
    out: Array = contracted("i...,i...->...", a, b)
    return out


def times(a: Array, b: Array) -> Array:
    """Matrix product of (i, j, ...) and (j, k, ...), or of (i, j, ...) and a vector (j, ...)."""
    out: Array = contracted("ij...,jk...->ik..." if a.ndim == b.ndim else "ij...,j...->i...", a, b)
    return out


def transposed(a: Array) -> Array:
    """Matrices (i, j, ...) as (j, i, ...)."""
    return np.swapaxes(a, 0, 1)


def inverse(a: Array) -> Array:
    """Inverse of matrices (i, i, m), recorded ones of three rows."""
    if is_recorded(a):
        cofactors = np.stack([cross(a[1], a[2]), cross(a[2], a[0]), cross(a[0], a[1])])
        return transposed(cofactors) / dot(a[0], cofactors[0])
    return np.moveaxis(np.asarray(np.linalg.inv(np.moveaxis(a, -1, 0)), dtype=np.float64), 0, -1)


def spin(a: Array) -> Array:
    """Matrix (3, 3, ...) of the cross product with `a` (3, ...) from the left."""
    zero = np.zeros_like(a[0])
    return np.array([[zero, -a[2], a[1]], [a[2], zero, -a[0]], [-a[1], a[0], zero]])


def identity(a: Array) -> Array:
    """Unit matrices (3, 3, ...) for vectors `a` (3, ...)."""
    return np.broadcast_to(np.eye(3).reshape(3, 3, *(1,) * (a.ndim - 1)), (3, 3, *a.shape[1:]))


def outer(a: Array, b: Array) -> Array:
    """Dyads (i, j, ...) of (i, ...) and (j, ...)."""
    return a[:, None] * b[None, :]


# -- quaternions ----------------------------------------------------------------------------------------------------


def product(p: Array, q: Array) -> Array:
    """Rotation `q` followed by `p`."""
    scalar = p[0] * q[0] - dot(p[1:], q[1:])
    vector = p[0] * q[1:] + q[0] * p[1:] + cross(p[1:], q[1:])
    return np.concatenate([scalar[None], vector])


def conjugate(q: Array) -> Array:
    """The opposite rotation."""
    return np.concatenate([q[:1], -q[1:]])


def normalised(q: Array) -> Array:
    """`q` scaled to length one."""
    out: Array = q / square_root(dot(q, q))
    return out


def matrix(q: Array) -> Array:
    """Rotation matrix (3, 3, ...)."""
    w, x, y, z = q
    return np.array(
        [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
            [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
            [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
        ]
    )


def rotated(q: Array, v: Array) -> Array:
    """Change of vectors (3, ...) by the rotation, ``R v - v``, in full relative accuracy."""
    half = cross(q[1:], v)
    out: Array = 2.0 * (q[0] * half + cross(q[1:], half))
    return out


def exponential(v: Array) -> Array:
    """Quaternion of a rotation vector (3, ...)."""
    half = 0.5 * square_root(dot(v, v))
    return np.concatenate([cosine(half)[None], 0.5 * sinc(half) * v])


def shortest(v: Array) -> Array:
    """The same rotation by a vector (3, ...) no longer than pi; one that is no longer stays as it is, to the bit."""
    size = square_root(dot(v, v))
    turns = rounded(size / (2.0 * np.pi))
    some = less(-turns, -0.5)
    safe = where(some, size, 1.0)
    out: Array = where(some, 1.0 - 2.0 * np.pi * turns / safe, 1.0) * v
    return out


def logarithm(q: Array) -> Array:
    """Rotation vector (3, ...), no longer than pi."""
    q = where(less(q[0], 0.0), -q, q)
    size = square_root(dot(q[1:], q[1:]))
    small = less(size, 1e-8)
    safe = where(small, 1.0, size)
    out: Array = where(small, 2.0, 2.0 * angle(size, q[0]) / safe) * q[1:]
    return out


def of_matrix(m: Array) -> Array:
    """Quaternion of a rotation matrix (3, 3, ...), whose largest component is taken from the diagonal (Shepperd 1978).

    Its scalar part is not negative.
    """
    trace = m[0, 0] + m[1, 1] + m[2, 2]
    four = np.stack([1.0 + trace, *(1.0 - trace + 2.0 * m[k, k] for k in range(3))])
    spun = [m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1]]
    both = {(i, j): m[i, j] + m[j, i] for i, j in ((0, 1), (0, 2), (1, 2))}
    rows = [np.stack([four[0], *spun])]
    for k in range(3):
        rows.append(np.stack([spun[k], *(four[k + 1] if i == k else both[min(i, k), max(i, k)] for i in range(3))]))
    best = np.argmax(four, axis=0)[None, None]
    q = normalised(np.take_along_axis(np.stack(rows), best, axis=0)[0])
    return np.where(q[0] < 0.0, -q, q)


# -- derivatives ----------------------------------------------------------------------------------------------------


def tangent(v: Array) -> Array:
    """T (3, 3, ...): the rotation turns by ``T dv``, in space, where its vector changes by dv."""
    (first, _), (second, _) = _coefficients(v)
    cross_v = spin(v)
    return identity(v) + first * cross_v + second * times(cross_v, cross_v)


def tangent_slope(v: Array, force: Array) -> Array:
    """Derivative (3, 3, ...) of ``T(v)^T force`` by v."""
    (first, first_slope), (second, second_slope) = _coefficients(v)
    one = cross(v, force)
    two = cross(v, one)
    bent = spin(one) + times(spin(v), spin(force))
    return first * spin(force) - second * bent + outer(second_slope * two - first_slope * one, v)


def inverse_tangent(v: Array) -> Array:
    """Inverse of `tangent`."""
    factor, _ = _cotangent(v)
    cross_v = spin(v)
    return identity(v) - 0.5 * cross_v + factor * times(cross_v, cross_v)


def inverse_tangent_slope(v: Array, force: Array) -> Array:
    """Derivative (3, 3, ...) of ``T(v)^-T force`` by v."""
    factor, slope = _cotangent(v)
    one = cross(v, force)
    two = cross(v, one)
    bent = spin(one) + times(spin(v), spin(force))
    return -0.5 * spin(force) - factor * bent + slope * outer(two, v)


def _coefficients(v: Array) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
    """(1 - cos a) / a^2 and (a - sin a) / a^3, each with its derivative by a, over a."""
    square = dot(v, v)
    near, far = minimum(square, _SERIES**2), maximum(square, _SERIES**2)
    a = square_root(far)
    half = sine(0.5 * a)
    across, versine = 2.0 * half * cosine(0.5 * a), 2.0 * half * half
    closed = (
        (versine / far, (a * across - 2.0 * versine) / (far * far)),
        ((a - across) / (a * far), (3.0 * across - a * (3.0 - versine)) / (a * (far * far))),
    )
    out = []
    for order, (value, slope) in zip((2, 3), closed, strict=True):
        series = [(-1.0) ** k / factorial(2 * k + order) for k in range(_TERMS)]
        out.append(_joined(square, series, near, value, slope))
    return out[0], out[1]


def _cotangent(v: Array) -> tuple[Array, Array]:
    """(1 - (a/2) cot(a/2)) / a^2 with its derivative by a, over a."""
    square = dot(v, v)
    near, far = minimum(square, _SERIES**2), maximum(square, _SERIES**2)
    a = square_root(far)
    half, rest = sine(0.5 * a), cosine(0.5 * a)
    square_of_half = half * half
    value = (1.0 - 0.5 * a * rest / half) / far
    slope = (a * (a + 2.0 * half * rest) - 8.0 * square_of_half) / (4.0 * (far * far) * square_of_half)
    return _joined(square, _COTANGENT, near, value, slope)


def _joined(square: Array, series: list[float], near: Array, value: Array, slope: Array) -> tuple[Array, Array]:
    """The series where the angle is small, else the closed forms `value` and `slope`."""
    total, rate = np.zeros_like(square), np.zeros_like(square)
    for k in range(len(series) - 1, -1, -1):
        rate = rate * near + 2.0 * total
        total = total * near + series[k]
    small = less(square, _SERIES**2)
    return where(small, total, value), where(small, rate, slope)
