"""Frame members as a scikit-fem element: line meshes with 3-D points, six components a node.

On a line mesh every form of the frame is an ordinary scikit-fem form over `ElementLineFrame`.
Fields are the six local components ``ux uy uz rx ry rz`` of the members, by global degrees of
freedom; ``u.grad`` is their derivative along the member.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from skfem import Basis, BilinearForm, LinearForm, MeshLine1
from skfem.assembly.form.coo_data import COOData
from skfem.element import DiscreteField, Element
from skfem.mapping import Mapping
from skfem.mesh import Mesh
from skfem.refdom import RefLine

from ..framework.protocol import Array
from .parameters import Real

if TYPE_CHECKING:
    from .beam import Beam

TAPER_ORDER = 23


class ArcLengthMapping(Mapping):  # type: ignore[misc]
    """Straight lines with points in space, measured along the line.

    Parameters
    ----------
    mesh
        A `MeshLine1` with points (3, N).
    """

    def __init__(self, mesh: Mesh) -> None:
        self.mesh = mesh
        self.start = mesh.p[:, mesh.t[0]]
        self.chord = mesh.p[:, mesh.t[1]] - self.start
        self.length = np.linalg.norm(self.chord, axis=0)

    def F(self, X: Array, tind: Array | None = None) -> Array:
        """Points (3, elements, points) of the fractions `X`."""
        e = _all(tind)
        return np.asarray(self.start[:, e, None] + self.chord[:, e, None] * X[0])

    def invF(self, x: Array, tind: Array | None = None) -> Array:
        """Fractions (1, elements, points) of the points `x`, by projection on the line."""
        e = _all(tind)
        along = np.einsum("ie,ieq->eq", self.chord[:, e], x - self.start[:, e, None])
        return np.asarray(along[None] / self.length[e, None] ** 2)

    def DF(self, X: Array, tind: Array | None = None) -> Array:
        """Length per fraction, (1, 1, elements, points)."""
        return self.detDF(X, tind)[None, None]

    def invDF(self, X: Array, tind: Array | None = None) -> Array:
        """Fraction per length, (1, 1, elements, points)."""
        return 1.0 / self.DF(X, tind)

    def detDF(self, X: Array, tind: Array | None = None) -> Array:
        """Length per fraction, (elements, points)."""
        length = self.length[_all(tind)]
        return np.repeat(length[:, None], X.shape[-1], axis=1)


class ElementLineFrame(Element):  # type: ignore[misc]
    """Beam with the shape functions of `beam`, on a line mesh with `ArcLengthMapping`.

    Parameters
    ----------
    beam
        Gives the shape functions and local axes.
    shape
        Batch shape whose entries, in C order, are the elements of the mesh; needed where
        parameters of `beam` are arrays.

    Examples
    --------
    >>> import numpy as np
    >>> from skfem import Basis, MeshLine1
    >>> from linkframe.elements import Beam, Material, Rectangle
    >>> from linkframe.elements.line_frame import ArcLengthMapping, ElementLineFrame, inertia_of, mass
    >>> beam = Beam(Rectangle(y=0.1, z=0.1), Material(E=200e9, nu=0.3, density=8000.0))
    >>> mesh = MeshLine1(np.array([[0.0, 3.0], [0.0, 4.0], [0.0, 0.0]]), np.array([[0], [1]]))
    >>> basis = Basis(mesh, ElementLineFrame(beam), ArcLengthMapping(mesh), intorder=6)
    >>> M = mass.assemble(basis, inertia=inertia_of(beam, basis))
    >>> float(round(M.toarray()[::6, ::6].sum(), 9))
    400.0
    """

    nodal_dofs = 6
    maxdeg = 3
    dofnames: ClassVar[list[str]] = ["ux", "uy", "uz", "rx", "ry", "rz"]
    doflocs = np.repeat([[0.0], [1.0]], 6, axis=0)
    refdom = RefLine

    def __init__(self, beam: Beam, shape: tuple[int, ...] | None = None) -> None:
        self.beam = beam
        self.shape = shape
        self._known: tuple[Any, Any, Any, Array, Array] | None = None

    def gbasis(self, mapping: ArcLengthMapping, X: Array, i: int, tind: Array | None = None) -> tuple[DiscreteField]:
        """Field (6, elements, points) of a unit global degree of freedom `i`, and its derivative."""
        values, slopes = self._rows(mapping, X, tind)
        return (DiscreteField(value=values[..., i], grad=slopes[..., i]),)

    def _rows(self, mapping: ArcLengthMapping, X: Array, tind: Array | None) -> tuple[Array, Array]:
        """Fields of all twelve, (6, elements, points, 12); kept, since they are asked for one by one."""
        known = self._known
        if known is None or known[0] is not mapping or known[1] is not X or known[2] is not tind:
            e = _all(tind)
            length, chord = mapping.length[e], mapping.chord[:, e].T
            shape = length.shape if self.shape is None else self.shape
            fraction = np.broadcast_to(X[0], (len(length), X.shape[-1])).T
            x = (fraction * length).reshape(-1, *shape)
            turn = np.zeros((len(length), 12, 12))
            for k in range(0, 12, 3):
                turn[:, k : k + 3, k : k + 3] = self.beam.axes(chord.reshape(*shape, 3)).reshape(-1, 3, 3)
            fields = [
                np.einsum("qeij,ejk->ieqk", rows(length.reshape(shape), x).reshape(len(x), -1, 6, 12), turn)
                for rows in (self.beam.shape_functions, self.beam.shape_gradients)
            ]
            known = self._known = (mapping, X, tind, fields[0], fields[1])
        return known[3], known[4]


def strains(u: DiscreteField) -> Array:
    """Strains and curvatures that work with ``N Vy Vz T My Mz``, (6, elements, points)."""
    field, strain = np.asarray(u), np.array(u.grad)
    strain[1] -= field[5]
    strain[2] += field[4]
    return strain


def _stiffness(u: DiscreteField, v: DiscreteField, w: Any) -> Array:
    """Work of the section forces ``rigidity * strain``, with ``w.rigidity`` (6, elements, points)."""
    return _dot(w.rigidity, strains(u), strains(v))


def _mass(u: DiscreteField, v: DiscreteField, w: Any) -> Array:
    """Inertia with ``w.inertia`` (6, elements, points): rho A three times, rho (Iy + Iz), rho Iy, rho Iz."""
    return _dot(w.inertia, np.asarray(u), np.asarray(v))


def _geometric(u: DiscreteField, v: DiscreteField, w: Any) -> Array:
    """Work of the axial force on the slopes, with ``w.initial`` (6, elements, points)."""
    return _dot(w.initial, u.grad, v.grad)


def _load(v: DiscreteField, w: Any) -> Array:
    """Work of the distributed load ``w.load`` (6, elements, points), local, per length."""
    return np.asarray(np.sum(np.asarray(w.load) * np.asarray(v), axis=0))


def _internal_forces(v: DiscreteField, w: Any) -> Array:
    """End forces by way of the section forces of the interpolated displacement ``w.displacement``."""
    return _dot(w.rigidity, strains(w.displacement), strains(v))


stiffness = BilinearForm(_stiffness)
mass = BilinearForm(_mass)
geometric = BilinearForm(_geometric)
load = LinearForm(_load)
internal_forces = LinearForm(_internal_forces)


def section_forces(u: DiscreteField, rigidity: Array) -> Array:
    """``N Vy Vz T My Mz`` of an interpolated displacement, (6, elements, points).

    Without shear deformation the strain says nothing of the shear forces, and they come as 0:
    they follow from `internal_forces` by equilibrium.
    """
    return rigidity * strains(u)


def rigidity_of(beam: Beam, basis: Basis) -> Array:
    """Rigidities of `beam` at the points of `basis`, (6, elements, points); 0 where there is no flexibility."""
    flexibility = _on_points(basis, beam.section_flexibility(_stations(basis)))
    return np.divide(1.0, flexibility, out=np.zeros_like(flexibility), where=flexibility > 0.0)


def inertia_of(beam: Beam, basis: Basis) -> Array:
    """Inertias of `beam` at the points of `basis`, (6, elements, points), for `mass`."""
    return _on_points(basis, beam.section_inertia(_stations(basis)))


def initial_of(beam: Beam, basis: Basis, axial: Array) -> Array:
    """Axial force `axial` (...) in `beam` at the points of `basis`, (6, elements, points), for `geometric`."""
    return _on_points(basis, np.asarray(axial)[..., None] * beam.section_sway(_stations(basis)))


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


def _stations(basis: Basis) -> Array:
    """Fractions of the length, (points, 1, ...): the axis of the points leads the batch."""
    shape = basis.elem.shape
    return np.asarray(basis.X[0].reshape((-1,) + (1,) * (1 if shape is None else len(shape))))


def _on_points(basis: Basis, values: Array) -> Array:
    """`values` (points, ..., 6) as scikit-fem lays them out, (6, elements, points)."""
    shape = (basis.nelems,) if basis.elem.shape is None else basis.elem.shape
    full = np.broadcast_to(values, (basis.X.shape[-1], *shape, 6))
    return np.ascontiguousarray(full.reshape(len(full), -1, 6).T)


def _dot(weight: Array, u: Array, v: Array) -> Array:
    return np.asarray(np.sum(np.asarray(weight) * (np.asarray(u) * np.asarray(v)), axis=0))


def _all(tind: Array | None) -> Array | slice:
    return slice(None) if tind is None else tind
