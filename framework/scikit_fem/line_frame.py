"""Members as a scikit-fem element: six components a node on a line mesh in space."""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np
from skfem.element import DiscreteField, Element
from skfem.refdom import RefLine

from ..batch import Array
from .arc_length import ArcLengthMapping, chosen
from .shaped import Shaped


class ElementLineFrame(Element):  # type: ignore[misc]
    """Member with six degrees of freedom a node, global, on a line mesh with `ArcLengthMapping`.

    Its field is the displacement in the local axes of the members, ``ux uy uz rx ry rz``, by the shape functions
    of `member`; ``u.grad`` is the derivative along the member. With it the matrices and loads of a frame
    are ordinary scikit-fem forms, given in `linkframe.elements.forms`. State the order of integration: for a prismatic
    beam 2 for stiffness, 4 for geometric stiffness, 6 for mass.

    Parameters
    ----------
    member : LineElement
        Beam, or another member, that gives the shape functions and the local axes.
    shape : tuple of int, optional
        Batch shape whose entries, in C order, are the elements of the mesh; by default (elements,).
        Arrays in `member` broadcast against it.
    local : bool
        Degrees of freedom in the members' own axes (True) instead of the global ones.

    Examples
    --------
    >>> from skfem import Basis, MeshLine1
    >>> from linkframe.elements import Beam, Material, Rectangle
    >>> from linkframe.elements.forms import inertia_of, mass
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

    def __init__(self, member: Shaped, shape: tuple[int, ...] | None = None, *, local: bool = False) -> None:
        self.member, self.shape, self.local = member, shape, local
        self._known: tuple[Any, Any, Any, Array, Array] | None = None

    def gbasis(self, mapping: ArcLengthMapping, X: Array, i: int, tind: Array | None = None) -> tuple[DiscreteField]:
        """Field of one degree of freedom of each element, and its derivative along the member.

        Parameters
        ----------
        mapping
            Gives length and direction of the elements.
        X
            Fractions, (1, points) or (1, elements, points).
        i
            Degree of freedom, 0 to 11.
        tind
            Numbers of the elements, (elements,); all if None.

        Returns
        -------
        tuple of DiscreteField
            One field, its value and its grad (6, elements, points) each, in the members' local axes.
        """
        values, slopes = self._rows(mapping, X, tind)
        return (DiscreteField(value=values[i], grad=slopes[i]),)

    def _rows(self, mapping: ArcLengthMapping, X: Array, tind: Array | None) -> tuple[Array, Array]:
        """Fields of all twelve, (12, 6, elements, points); kept, since they are asked for one by one."""
        known = self._known
        if known is None or known[0] is not mapping or known[1] is not X or known[2] is not tind:
            length, chord = mapping.length[chosen(tind)], mapping.chord[:, chosen(tind)].T
            shape = length.shape if self.shape is None else self.shape
            # points shared by all elements stay one column, whose sections are then evaluated once
            fraction = X[0].T.reshape(-1, *(shape if X.ndim == 3 else (1,) * len(shape)))
            each = (len(fraction), *shape, 6, 12)
            local = (
                np.broadcast_to(rows, each).reshape(len(fraction), -1, 6, 12)
                for rows in self.member.shape_rows(length.reshape(shape), fraction)
            )
            if not self.local:
                turn = np.zeros((len(length), 12, 12))
                for k in range(0, 12, 3):
                    turn[:, k : k + 3, k : k + 3] = self.member.axes(chord.reshape(*shape, 3)).reshape(-1, 3, 3)
                local = (rows @ turn for rows in local)
            values, slopes = (np.ascontiguousarray(np.moveaxis(rows, (3, 2), (0, 1)).swapaxes(2, 3)) for rows in local)
            known = self._known = (mapping, X, tind, values, slopes)
        return known[3], known[4]
