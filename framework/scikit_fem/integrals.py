"""Matrices of any member, in its own axes, by quadrature of its own shape functions and section law in scikit-fem."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from skfem import Basis, MeshLine1
from skfem.assembly.form.coo_data import COOData

from ..batch import Array, Shape
from .arc_length import ArcLengthMapping
from .forms import geometric, inertia_of, initial_of, mass, rigidity_of, stiffness
from .line_frame import ElementLineFrame
from .shaped import Real, Shaped


def integrated_stiffness(member: Shaped, length: Real) -> Array:
    """Stiffness of any member by quadrature, (..., 12, 12)."""
    return _integrated(member, length, lambda basis: stiffness.elemental(basis, rigidity=rigidity_of(member, basis)))


def integrated_mass(member: Shaped, length: Real) -> Array:
    """Consistent mass of any member by quadrature, (..., 12, 12)."""
    return _integrated(member, length, lambda basis: mass.elemental(basis, inertia=inertia_of(member, basis)))


def integrated_geometric(member: Shaped, length: Real, axial: Real) -> Array:
    """Geometric stiffness of any member by quadrature, (..., 12, 12)."""

    def matrices(basis: Basis) -> COOData:
        return geometric.elemental(basis, initial=initial_of(member, basis, np.asarray(axial)))

    return _integrated(member, length, matrices, np.shape(axial))


def _integrated(member: Shaped, length: Real, matrices: Callable[[Basis], COOData], more: Shape = ()) -> Array:
    """Matrices (..., 12, 12) of a member, whose batch shape is that of its sections, its length and `more`."""
    shape = np.broadcast_shapes(member.sections_shape, np.shape(length), more)
    return np.zeros((*shape, 12, 12)) if 0 in shape else _stack(matrices(detached(member, length, shape)), shape)


def detached(member: Shaped, length: Real, shape: Shape) -> Basis:
    """Basis over one member of each batch entry, in its own axes.

    Parameters
    ----------
    member
        The member.
    length
        Its length, (...).
    shape
        The batch; its entries, in C order, are the elements of the mesh.
    """
    lengths = np.broadcast_to(length, shape).ravel()
    points = np.zeros((3, 2 * lengths.size))
    points[0, 1::2] = lengths
    mesh = MeshLine1(points, np.ascontiguousarray(np.arange(2 * lengths.size).reshape(-1, 2).T))
    mapping = ArcLengthMapping(mesh)
    mapping.length = np.array(lengths, dtype=np.float64)
    t, w = member.integration_points
    if t.ndim > 1:
        t, w = (np.broadcast_to(_led(part, len(shape)), (len(part), *shape)).reshape(len(part), -1) for part in (t, w))
    element = ElementLineFrame(member, shape, local=True)
    return Basis(mesh, element, mapping, quadrature=(t.T[None] if t.ndim > 1 else t[None], w.T), disable_doflocs=True)


def _led(part: Array, ndim: int) -> Array:
    """(points, ...) with `ndim` axes after the leading one."""
    return part.reshape(len(part), *(1,) * (ndim + 1 - part.ndim), *part.shape[1:])


def _stack(data: COOData, shape: Shape) -> Array:
    return np.asarray(data.tolocal()).reshape(*shape, 12, 12)
