"""Nodes and connections as a scikit-fem line mesh in space, and the numbering of its displacements."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..batch import Array
from ..dofs import DISPLACEMENTS

Index = NDArray[np.int64]


def line_mesh(points: Array, kinds: Mapping[str, Index], names: Mapping[str, Index], nodes: Mapping[str, int]) -> Any:
    """A ``MeshLine1`` of several kinds of connections between points.

    Parameters
    ----------
    points
        Positions (n, 3).
    kinds
        By kind, such as ``beam`` and ``joint``: the numbers of the points that its cells connect, (m, 2). Each kind is
        a subdomain.
    names
        Numbers of the cells of further subdomains by name; a name that is also a kind is ignored.
    nodes
        Numbers of the points that become boundaries, by name; points without a cell are ignored.
    """
    from skfem import MeshLine1

    counts = np.cumsum([0, *(len(ends) for ends in kinds.values())])
    cells = np.concatenate([np.zeros((0, 2), dtype=np.int64), *kinds.values()]).T
    parts = {kind: np.arange(start, stop) for kind, start, stop in zip(kinds, counts, counts[1:], strict=False)}
    mesh = MeshLine1(
        np.ascontiguousarray(points.T), np.ascontiguousarray(cells), sort_t=False, validate=False
    ).with_subdomains({**names, **parts})
    # the facets of a line mesh in scikit-fem are the points that belong to a cell
    touched = np.unique(cells)
    places = {name: np.searchsorted(touched, [node]) for name, node in nodes.items() if node in touched}
    return mesh.with_boundaries(places) if places else mesh


def numbered(mesh: Any) -> Any:
    """scikit-fem ``Dofs`` of a line mesh: ``ux uy uz rx ry rz`` at each node."""
    from skfem import Dofs, ElementLineP1, ElementVector

    element = ElementVector(ElementLineP1(), 6)
    element.dofnames = list(DISPLACEMENTS)
    return Dofs(mesh, element)
