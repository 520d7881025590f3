"""Straight lines in space for scikit-fem, measured along the line."""

from __future__ import annotations

import numpy as np
from skfem.mapping import Mapping
from skfem.mesh import Mesh

from ..batch import Array


class ArcLengthMapping(Mapping):  # type: ignore[misc]
    """From the fraction of each line of a mesh to points in space.

    scikit-fem's own affine mapping takes a line mesh with 3-D points for a mesh of solids, and is
    silently wrong there: pass this one to `Basis`.

    Parameters
    ----------
    mesh : MeshLine1
        Line mesh with points (3, N).

    Examples
    --------
    >>> from skfem import MeshLine1
    >>> mesh = MeshLine1(np.array([[0.0, 3.0], [0.0, 4.0], [0.0, 0.0]]), np.array([[0], [1]]))
    >>> ArcLengthMapping(mesh).detDF(np.array([[0.5]]))
    array([[5.]])
    """

    def __init__(self, mesh: Mesh) -> None:
        self.mesh = mesh
        self.start = mesh.p[:, mesh.t[0]]
        self.chord = mesh.p[:, mesh.t[1]] - self.start
        self.length = np.linalg.norm(self.chord, axis=0)

    def F(self, X: Array, tind: Array | None = None) -> Array:
        """Point in space at a fraction of each line.

        Parameters
        ----------
        X
            Fractions, (1, points) or (1, elements, points).
        tind
            Numbers of the elements, (elements,); all if None.

        Returns
        -------
        ndarray
            Coordinates, (3, elements, points), length.
        """
        e = chosen(tind)
        return np.asarray(self.start[:, e, None] + self.chord[:, e, None] * X[0])

    def invF(self, x: Array, tind: Array | None = None) -> Array:
        """Fraction of each line at which a point in space projects on it.

        Parameters
        ----------
        x
            Points in space, (3, elements, points).
        tind
            Numbers of the elements, (elements,); all if None.

        Returns
        -------
        ndarray
            Fractions, (1, elements, points), 0 at the start and 1 at the end.
        """
        e = chosen(tind)
        along = np.einsum("ie,ieq->eq", self.chord[:, e], x - self.start[:, e, None])
        return np.asarray(along[None] / self.length[e, None] ** 2)

    def DF(self, X: Array, tind: Array | None = None) -> Array:
        """Jacobian of `F`: length per fraction.

        Parameters
        ----------
        X
            Fractions, (1, points) or (1, elements, points).
        tind
            Numbers of the elements, (elements,); all if None.

        Returns
        -------
        ndarray
            Length of each line, (1, 1, elements, points).
        """
        return self.detDF(X, tind)[None, None]

    def invDF(self, X: Array, tind: Array | None = None) -> Array:
        """Inverse of the Jacobian: fraction per length.

        Parameters
        ----------
        X
            Fractions, (1, points) or (1, elements, points).
        tind
            Numbers of the elements, (elements,); all if None.

        Returns
        -------
        ndarray
            One over the length of each line, (1, 1, elements, points).
        """
        return 1.0 / self.DF(X, tind)

    def detDF(self, X: Array, tind: Array | None = None) -> Array:
        """Determinant of the Jacobian, by which integrals along the line are weighted.

        Parameters
        ----------
        X
            Fractions, (1, points) or (1, elements, points).
        tind
            Numbers of the elements, (elements,); all if None.

        Returns
        -------
        ndarray
            Length of each line, (elements, points).
        """
        return np.repeat(self.length[chosen(tind), None], X.shape[-1], axis=1)


def chosen(tind: Array | None) -> Array | slice:
    """Index of the elements `tind`, or of all."""
    return slice(None) if tind is None else tind
