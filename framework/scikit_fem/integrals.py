"""Matrices, loads and forces of any member, in its own axes, by scikit-fem forms.

They are integrated by quadrature of the member's own shape functions and section law.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from skfem import Basis, MeshLine1
from skfem.assembly.form.coo_data import COOData

from ..batch import Array, Shape
from ..shape_rules import after_first
from .arc_length import ArcLengthMapping
from .forms import (
    geometric,
    inertia_of,
    initial_of,
    internal_forces,
    load,
    mass,
    on_points,
    restrained,
    rigidity_of,
    stations,
    stiffness,
)
from .line_frame import ElementLineFrame
from .shaped import Real, Shaped

Rule = tuple[Array, Array]


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


def integrated_loads(member: Shaped, length: Real, x: Array, forces: Array) -> Array:
    """End forces (..., 12) that do the same work as `forces` (points, ..., 6) at the distances `x` (points, ...)."""
    fraction = np.asarray(after_first(x, max(x.ndim - 1, np.ndim(length))) / length)
    shape = np.broadcast_shapes(member.sections_shape, fraction.shape[1:], forces.shape[1:-1])
    # the forces stand for the integrals over their stretches: no length of the element enters by the quadrature
    rule = fraction, np.broadcast_to(1.0 / np.asarray(length), fraction.shape)

    def loads(basis: Basis) -> COOData:
        return load.elemental(basis, load=on_points(basis, after_first(forces, len(shape), 1)))

    return _vectors(member, length, shape, loads, rule)


def integrated_strain(member: Shaped, length: Real) -> Array:
    """End forces of a member with a free strain, such as by heat, that are equivalent to it, (..., 12)."""
    shape = np.broadcast_shapes(member.sections_shape, np.shape(length))

    def forces(basis: Basis) -> COOData:
        given = member.restrained_forces(stations(basis))
        assert given is not None
        return restrained.elemental(basis, forces=on_points(basis, given))

    return _vectors(member, length, shape, forces)


def integrated_forces(member: Shaped, length: Real, displacement: Array) -> Array:
    """End forces of any member, (..., 12), at the displacements of its ends, (..., 12)."""
    shape = np.broadcast_shapes(member.sections_shape, np.shape(length), displacement.shape[:-1])
    moved = np.broadcast_to(displacement, (*shape, 12)).reshape(-1)

    def forces(basis: Basis) -> COOData:
        return internal_forces.elemental(
            basis, rigidity=rigidity_of(member, basis), displacement=basis.interpolate(moved)
        )

    return _vectors(member, length, shape, forces)


def _integrated(member: Shaped, length: Real, matrices: Callable[[Basis], COOData], more: Shape = ()) -> Array:
    """Matrices (..., 12, 12) of a member, whose batch shape is that of its sections, its length and `more`."""
    shape = np.broadcast_shapes(member.sections_shape, np.shape(length), more)
    return np.zeros((*shape, 12, 12)) if 0 in shape else _stack(matrices(detached(member, length, shape)), shape)


def _vectors(
    member: Shaped, length: Real, shape: Shape, vectors: Callable[[Basis], COOData], rule: Rule | None = None
) -> Array:
    """Vectors (..., 12) of a member of a batch of this shape."""
    if 0 in shape:
        return np.zeros((*shape, 12))
    return np.asarray(vectors(detached(member, length, shape, rule)).tolocal()).reshape(*shape, 12)


def detached(member: Shaped, length: Real, shape: Shape, rule: Rule | None = None) -> Basis:
    """Basis over one member of each batch entry, in its own axes.

    Parameters
    ----------
    member
        The member.
    length
        Its length, (...).
    shape
        The batch; its entries, in C order, are the elements of the mesh.
    rule
        Points of the quadrature as fractions of the length, and weights, (points, ...); the member's own where None.
    """
    lengths = np.broadcast_to(length, shape).ravel()
    points = np.zeros((3, 2 * lengths.size))
    points[0, 1::2] = lengths
    mesh = MeshLine1(points, np.ascontiguousarray(np.arange(2 * lengths.size).reshape(-1, 2).T))
    mapping = ArcLengthMapping(mesh)
    mapping.length = np.array(lengths, dtype=np.float64)
    t, w = member.integration_points if rule is None else rule
    if t.ndim > 1:
        t, w = (
            np.broadcast_to(after_first(part, len(shape)), (len(part), *shape)).reshape(len(part), -1)
            for part in (t, w)
        )
    element = ElementLineFrame(member, shape, local=True)
    return Basis(mesh, element, mapping, quadrature=(t.T[None] if t.ndim > 1 else t[None], w.T), disable_doflocs=True)


def _stack(data: COOData, shape: Shape) -> Array:
    return np.asarray(data.tolocal()).reshape(*shape, 12, 12)
