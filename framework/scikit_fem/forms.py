"""Frame analysis in scikit-fem forms, over a `Basis` of `ElementLineFrame`."""

from __future__ import annotations

from typing import Any

import numpy as np
from skfem import Basis, BilinearForm, LinearForm
from skfem.element import DiscreteField

from ..batch import Array
from .shaped import Shaped


def strains(u: DiscreteField) -> Array:
    """Strains and curvatures conjugate to ``N Vy Vz T My Mz``, (6, elements, points)."""
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
    """Work of the axial force, with ``w.initial`` (6, elements, points): 0, N, N, N (Iy + Iz) / A, 0, 0."""
    return _dot(w.initial, u.grad, v.grad)


def _load(v: DiscreteField, w: Any) -> Array:
    """Work of the distributed load ``w.load`` (6, elements, points), local, per length."""
    return np.asarray(np.sum(np.asarray(w.load) * np.asarray(v), axis=0))


def _internal_forces(v: DiscreteField, w: Any) -> Array:
    """Work of the section forces of the interpolated displacement ``w.displacement``; it gives the end forces."""
    return _dot(w.rigidity, strains(w.displacement), strains(v))


def _restrained(v: DiscreteField, w: Any) -> Array:
    """Work of given section forces ``w.forces`` (6, elements, points), such as those of a restrained free strain."""
    return np.asarray(np.sum(np.asarray(w.forces) * strains(v), axis=0))


stiffness = BilinearForm(_stiffness)
mass = BilinearForm(_mass)
geometric = BilinearForm(_geometric)
load = LinearForm(_load)
internal_forces = LinearForm(_internal_forces)
restrained = LinearForm(_restrained)


def section_forces(u: DiscreteField, rigidity: Array) -> Array:
    """``N Vy Vz T My Mz`` of an interpolated displacement, (6, elements, points).

    Without shear deformation the strains do not determine the shear forces, which are returned as 0:
    they follow from `internal_forces` by equilibrium.
    """
    return rigidity * strains(u)


def rigidity_of(member: Shaped, basis: Basis) -> Array:
    """Rigidities of `member` at the points of `basis`, (6, elements, points); 0 for a zero flexibility (no strain)."""
    flexibility = on_points(basis, member.section_flexibility(stations(basis)))
    return np.divide(1.0, flexibility, out=np.zeros_like(flexibility), where=flexibility > 0.0)


def inertia_of(member: Shaped, basis: Basis) -> Array:
    """Inertias of `member` at the points of `basis`, (6, elements, points), for `mass`."""
    return on_points(basis, member.section_inertia(stations(basis)))


def initial_of(member: Shaped, basis: Basis, axial: Array) -> Array:
    """Axial force `axial` (...) in `member` at the points of `basis`, (6, elements, points), for `geometric`."""
    return on_points(basis, np.asarray(axial)[..., None] * member.section_sway(stations(basis)))


def stations(basis: Basis) -> Array:
    """Fractions of the length at the points of `basis`, (points, ...): their axis leads the batch."""
    shape = (basis.nelems,) if basis.elem.shape is None else basis.elem.shape
    points = basis.X[0].T
    return np.asarray(points.reshape(-1, *(shape if points.ndim == 2 else (1,) * len(shape))))


def on_points(basis: Basis, values: Array) -> Array:
    """`values` (points, ..., 6) as scikit-fem lays them out, (6, elements, points)."""
    shape = (basis.nelems,) if basis.elem.shape is None else basis.elem.shape
    full = np.broadcast_to(values, (basis.X.shape[-1], *shape, 6))
    return np.ascontiguousarray(full.reshape(len(full), -1, 6).T)


def _dot(weight: Array, u: Array, v: Array) -> Array:
    return np.asarray(np.sum(np.asarray(weight) * (np.asarray(u) * np.asarray(v)), axis=0))
