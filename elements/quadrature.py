"""Matrices of any beam, tapered or with releases, by quadrature of its own shape functions in scikit-fem."""

from __future__ import annotations

import numpy as np
from skfem import Basis, MeshLine1
from skfem.assembly.form.coo_data import COOData

from ..framework.protocol import Array
from .arc_length import ArcLengthMapping
from .flexibility import spread_points
from .forms import geometric, inertia_of, initial_of, mass
from .line_frame import ElementLineFrame
from .parameters import Real
from .shaped import ShapedBeam


def integrated_mass(beam: ShapedBeam, length: Real) -> Array:
    """Consistent mass of any beam by quadrature, (..., 12, 12), in axes that a chord along x has by default."""
    shape = np.broadcast_shapes(beam.sections_shape, np.shape(length))
    if 0 in shape:
        return np.zeros((*shape, 12, 12))
    basis = _detached(beam, length, shape, 6)
    return _stack(mass.elemental(basis, inertia=inertia_of(beam, basis)), shape)


def integrated_geometric(beam: ShapedBeam, length: Real, axial: Real) -> Array:
    """Geometric stiffness of any beam by quadrature, (..., 12, 12), in axes that a chord along x has by default."""
    shape = np.broadcast_shapes(beam.sections_shape, np.shape(length), np.shape(axial))
    if 0 in shape:
        return np.zeros((*shape, 12, 12))
    basis = _detached(beam, length, shape, 4)
    return _stack(geometric.elemental(basis, initial=initial_of(beam, basis, np.asarray(axial))), shape)


def _detached(beam: ShapedBeam, length: Real, shape: tuple[int, ...], intorder: int) -> Basis:
    """Basis over one member of each batch entry, each along x from a node of its own to another."""
    lengths = np.broadcast_to(length, shape).ravel()
    points = np.zeros((3, 2 * lengths.size))
    points[0, 1::2] = lengths
    mesh = MeshLine1(points, np.ascontiguousarray(np.arange(2 * lengths.size).reshape(-1, 2).T))
    element, mapping = ElementLineFrame(beam, shape), ArcLengthMapping(mesh)
    if beam.end is None:
        return Basis(mesh, element, mapping, intorder=intorder, disable_doflocs=True)
    # curves and sections of a taper are no polynomials: the points of its flexibility suit them too
    t, w = spread_points(beam.section, beam.end)
    if t.ndim > 1:
        t, w = (np.broadcast_to(_led(part, len(shape)), (len(part), *shape)).reshape(len(part), -1) for part in (t, w))
    return Basis(mesh, element, mapping, quadrature=(t.T[None], w.T), disable_doflocs=True)


def _led(part: Array, ndim: int) -> Array:
    """(points, ...) with `ndim` axes after the leading one."""
    return part.reshape(len(part), *(1,) * (ndim + 1 - part.ndim), *part.shape[1:])


def _stack(data: COOData, shape: tuple[int, ...]) -> Array:
    return np.asarray(data.tolocal()).reshape(*shape, 12, 12)
