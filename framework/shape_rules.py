"""Strains, springs and matrices that follow from a member's own shape functions and section law by quadrature.

All of it has the precision of the length; strains in rigid motions are zero to rounding in that precision.
"""

from __future__ import annotations

from functools import cache
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from .batch import Array, Shape, merged

Real = NDArray[Any]
# Chebyshev points, as fractions of the length, of the polynomial that gives the derivative of shape functions.
PLACES = 0.5 - 0.5 * np.cos(np.pi * np.arange(8) / 7.0)
# Number of points up to which Gauss's rule is computed from a full matrix.
_DENSE = 300
# Share of a deformation that is surely the rounding of double precision in what a rigid motion makes of it.
_ROUNDED = 1e-10


class Law(Protocol):
    """A member with shape functions and a section law."""

    @property
    def sections_shape(self) -> Shape:
        """Batch shape of the section law."""
        ...

    @property
    def integration_points(self) -> tuple[Array, Array]:
        """Fractions of the length and weights, (points, ...)."""
        ...

    def shape_functions(self, length: Array, x: Array) -> Array:
        """Displacements by those of the ends, (..., 6, 12)."""
        ...

    def shape_rows(self, length: Array, fraction: Array) -> tuple[Array, Array]:
        """Displacements by those of the ends, and their derivatives, (..., 6, 12)."""
        ...

    def section_flexibility(self, fraction: Array) -> Array:
        """Strain and curvature per unit ``N Vy Vz T My Mz``, (..., 6)."""
        ...


@cache
def gauss_legendre(count: int) -> tuple[Array, Array]:
    """Nodes and weights of Gauss's rule on (-1, 1).

    Parameters
    ----------
    count
        Number of nodes.
    """
    if count <= _DENSE:
        return np.polynomial.legendre.leggauss(count)
    # its work grows by the square of their number, not by the cube
    from scipy.special import roots_legendre

    nodes, weights = roots_legendre(count)
    return nodes, weights


@cache
def gauss(count: int) -> tuple[Array, Array]:
    """Nodes and weights of Gauss's rule on (0, 1).

    Parameters
    ----------
    count
        Number of nodes.
    """
    nodes, weights = gauss_legendre(count)
    found = 0.5 * (1.0 + nodes), 0.5 * weights
    for part in found:
        part.setflags(write=False)
    return found


def gradients(member: Law, length: Real, fraction: Real) -> Real:
    """Derivative along the member of its shape functions, (..., 6, 12): of the polynomial through eight places.

    Parameters
    ----------
    member
        The member.
    length, fraction
        Length and fraction of it, (...).
    """
    kind = np.result_type(length, fraction, np.float64)
    places, fraction = PLACES.astype(kind), np.asarray(fraction, dtype=kind)
    out: Any = 0.0
    for place, share in zip(places, _derivatives(places, fraction), strict=True):
        values = member.shape_functions(length, np.asarray(place * length))
        out = out + (share / length)[..., None, None] * values
    return np.asarray(out)


def _derivatives(places: Real, at: Real) -> list[Real]:
    """Derivatives (...) at some fractions of the polynomials that are one at one place and zero at the others."""
    out = []
    for j, here in enumerate(places):
        others = [(k, place) for k, place in enumerate(places) if k != j]
        total = np.zeros_like(at)
        for i, left in others:
            term = np.full_like(at, 1.0) / (here - left)
            for k, place in others:
                if k != i:
                    term = term * (at - place) / (here - place)
            total = total + term
        out.append(total)
    return out


def strain_rows(values: Real, slopes: Real) -> Real:
    """Strains and curvatures that work with ``N Vy Vz T My Mz``, (..., 6, 12), of fields and their derivatives."""
    out = np.array(slopes)
    out[..., 1, :] -= values[..., 5, :]
    out[..., 2, :] += values[..., 4, :]
    return out


def balanced_rows(rows: Real, length: Real) -> Real:
    """Deformations (..., n, 12); those that a rigid motion changes by rounding alone are then not changed at all.

    What it makes of them by the start is what it makes of them by the end, taken back.

    Parameters
    ----------
    rows
        Deformations by the displacements of both ends.
    length
        Length, (...).
    """
    length = np.asarray(length)[..., None]
    start, end = rows[..., :6], rows[..., 6:]
    shape = np.broadcast_shapes(end.shape, (*length.shape, 1))
    rigid = np.array(np.broadcast_to(end, shape), dtype=np.result_type(end, length))
    rigid[..., 4] -= length * end[..., 2]
    rigid[..., 5] += length * end[..., 1]
    size = np.abs(start) + np.abs(end)
    along, about = size[..., :3].max(axis=-1), size[..., 3:].max(axis=-1)
    most = _ROUNDED * np.maximum(along, about / length)[..., None]
    arms = np.stack(np.broadcast_arrays(*(1.0 + 0.0 * length,) * 3, *(length,) * 3), axis=-1)
    still = (np.abs(start + rigid) <= most * arms).all(axis=-1)
    out = np.array(np.broadcast_to(rows, (*rigid.shape[:-1], 12)), dtype=rigid.dtype)
    out[..., :6] = np.where(still[..., None], -rigid, start)
    return out


def section_springs(member: Law, length: Real) -> tuple[Array, Array]:
    """A section law at the points of the quadrature as springs k (..., n) on deformations b (..., n, 12).

    Parameters
    ----------
    member
        The member.
    length
        Length, (...).
    """
    length = np.asarray(length)
    fractions, weights = member.integration_points
    lead = (slice(None), *(None,) * max(0, length.ndim + 1 - fractions.ndim))
    fractions, shares = fractions[lead], weights[lead] * length
    flexibility = member.section_flexibility(fractions)
    resists = np.divide(1.0, flexibility, out=np.zeros(np.shape(flexibility)), where=flexibility > 0.0)
    k = np.moveaxis(np.asarray(shares, dtype=np.float64)[..., None] * resists, 0, -2)
    rows = np.moveaxis(strain_rows(*member.shape_rows(length, fractions)), 0, -3)
    k, rows = merged(k, -2, -1), merged(rows, -3, -2)
    b = balanced_rows(rows, length)
    acts = (k != 0.0).reshape(-1, k.shape[-1]).any(axis=0) & (b != 0.0).reshape(-1, *b.shape[-2:]).any(axis=(0, 2))
    acts = acts if acts.any() else np.arange(len(acts)) == 0
    return k[..., acts], b[..., acts, :]


def summed(stiffness: Array, rows: Array) -> Array:
    """Stiffness (..., 12, 12) of springs (..., n) on deformations (..., n, 12), symmetric to the last bit."""
    half = np.swapaxes(rows, -1, -2) @ (stiffness[..., None] * rows)
    out: Array = 0.5 * (half + np.swapaxes(half, -1, -2))
    return out


def spring_forces(stiffness: Array, rows: Array, displacement: Array) -> Array:
    """End forces (..., 12) of springs (..., n) on deformations (..., n, 12) at the end displacements (..., 12)."""
    forces = stiffness * (rows @ np.asarray(displacement)[..., None])[..., 0]
    out: Array = (forces[..., None, :] @ rows)[..., 0, :]
    return out


def work_equivalent(shapes: Array, force: Array) -> Array:
    """End forces (..., 12) that do the same work as a force and moment (..., 6) where the shapes are (..., 6, 12)."""
    out: Array = np.einsum("...ij,...i->...j", shapes, force)
    return out


def after_first(array: Array, ndim: int, trailing: int = 0) -> Array:
    """An array (points, ...) with axes of length one after the first, so that `ndim` precede the `trailing` ones."""
    return array.reshape(len(array), *(1,) * (ndim + 1 + trailing - array.ndim), *array.shape[1:])


def summed_work(shapes: Array, forces: Array) -> Array:
    """End forces (..., 12) of forces and moments (points, ..., 6) where the shapes are (points, ..., 6, 12)."""
    total: Array = work_equivalent(shapes, after_first(forces, shapes.ndim - 3, 1)).sum(axis=0)
    return total


def straight_shapes(length: Array, x: Array) -> Array:
    """Shape functions (..., 6, 12) of a straight line between its ends, which turns as they move, and not with them.

    Parameters
    ----------
    length, x
        Length and distance from the start, (...).

    Returns
    -------
    ndarray
        ``ux uy uz rx ry rz`` there by the twelve of the ends, (..., 6, 12).

    Examples
    --------
    >>> from linkframe.framework import straight_shapes
    >>> straight_shapes(2.0, 0.5)[1, [1, 7]].tolist()
    [0.75, 0.25]
    """
    kind = np.result_type(length, x, np.float64)
    length, s = np.asarray(length, kind), np.asarray(x, kind) / length
    rows = np.zeros((*np.broadcast_shapes(length.shape, s.shape), 6, 12), kind)
    for i in range(3):
        rows[..., i, i], rows[..., i, i + 6] = 1.0 - s, s
    for turn, moved, sign in ((4, 2, -1.0), (5, 1, 1.0)):
        rows[..., turn, moved], rows[..., turn, moved + 6] = -sign / length, sign / length
    return rows


def cubic_shapes(length: Array, x: Array) -> Array:
    """Shape functions (..., 6, 12) of a beam that bends and does not shear: lines along and about it, cubics across.

    Parameters
    ----------
    length, x
        Length and distance from the start, (...).

    Returns
    -------
    ndarray
        ``ux uy uz rx ry rz`` there by the twelve of the ends, (..., 6, 12).

    Examples
    --------
    Half way a beam that bends takes half of each deflection, and an eighth of the length times each rotation.

    >>> from linkframe.framework import cubic_shapes
    >>> cubic_shapes(2.0, 1.0)[1, [1, 5, 7, 11]].tolist()
    [0.5, 0.25, 0.5, -0.25]
    """
    kind = np.result_type(length, x, np.float64)
    length, s = np.asarray(length, kind), np.asarray(x, kind) / length
    rows = np.zeros((*np.broadcast_shapes(length.shape, s.shape), 6, 12), kind)
    for i in (0, 3):
        rows[..., i, i], rows[..., i, i + 6] = 1.0 - s, s
    moved = (
        1.0 - s * s * (3.0 - 2.0 * s),
        length * s * (1.0 - s) ** 2,
        s * s * (3.0 - 2.0 * s),
        length * s * s * (s - 1.0),
    )
    rotated = (
        6.0 * s * (s - 1.0) / length,
        (1.0 - s) * (1.0 - 3.0 * s),
        6.0 * s * (1.0 - s) / length,
        s * (3.0 * s - 2.0),
    )
    for v, r, sign in ((1, 5, 1.0), (2, 4, -1.0)):
        for dof, value, slope, way in zip((v, r, v + 6, r + 6), moved, rotated, (1.0, sign, 1.0, sign), strict=True):
            rows[..., v, dof], rows[..., r, dof] = way * value, sign * way * slope
    return rows
