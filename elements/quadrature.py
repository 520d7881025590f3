"""Matrices of any beam, tapered or with releases, by quadrature of its own shape functions in scikit-fem."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from skfem import Basis, MeshLine1
from skfem.assembly.form.coo_data import COOData

from ..framework.protocol import Array
from .arc_length import ArcLengthMapping
from .forms import geometric, inertia_of, initial_of, mass
from .line_frame import ElementLineFrame
from .parameters import Real

if TYPE_CHECKING:
    from .beam import Beam

# Curves and sections of a taper are no polynomials: twelve points leave rounding (see the tests).
TAPER_ORDER = 23


def integrated_mass(beam: Beam, length: Real) -> Array:
    """Consistent mass of any beam by quadrature, (..., 12, 12)."""
    shape = np.broadcast_shapes(beam.sections_shape, np.shape(length))
    basis = _detached(beam, length, shape, 6)
    return _stack(mass.elemental(basis, inertia=inertia_of(beam, basis)), shape)


def integrated_geometric(beam: Beam, length: Real, axial: Real) -> Array:
    """Geometric stiffness of any beam by quadrature, (..., 12, 12)."""
    shape = np.broadcast_shapes(beam.sections_shape, np.shape(length), np.shape(axial))
    basis = _detached(beam, length, shape, 4)
    return _stack(geometric.elemental(basis, initial=initial_of(beam, basis, np.asarray(axial))), shape)


def _detached(beam: Beam, length: Real, shape: tuple[int, ...], intorder: int) -> Basis:
    """Basis over one member of each batch entry, each along x from a node of its own to another."""
    lengths = np.broadcast_to(length, shape).ravel()
    points = np.zeros((3, 2 * lengths.size))
    points[0, 1::2] = lengths
    mesh = MeshLine1(points, np.arange(2 * lengths.size).reshape(-1, 2).T)
    order = intorder if beam.end is None else TAPER_ORDER
    element = ElementLineFrame(replace(beam, up=None), shape)
    return Basis(mesh, element, ArcLengthMapping(mesh), intorder=order, disable_doflocs=True)


def _stack(data: COOData, shape: tuple[int, ...]) -> Array:
    return np.asarray(data.tolocal()).reshape(*shape, 12, 12)
