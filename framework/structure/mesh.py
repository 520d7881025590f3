"""Nodes and connections as scikit-fem has them: a line mesh in space, and the numbering of its displacements."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..batch import Array
from ..dofs import DISPLACEMENTS

Index = NDArray[np.int64]


def line_mesh(points: Array, kinds: Mapping[str, Index], names: Mapping[str, Index], nodes: Mapping[str, int]) -> Any:
    """Connections of several kinds between points as a ``MeshLine1``.

    Parameters
    ----------
    points
        Positions (n, 3).
    kinds
        By kind, such as ``beam`` and ``joint``: the numbers of the points that its cells connect, (m, 2). Each is a
        subdomain.
    names
        Numbers of the cells of more subdomains; one that is called like a kind is left out.
    nodes
        Points that are boundaries by their names; what no cell touches has none.
    """
    from skfem import MeshLine1

    counts = np.cumsum([0, *(len(ends) for ends in kinds.values())])
    cells = np.concatenate([np.zeros((0, 2), dtype=np.int64), *kinds.values()]).T
    parts = {kind: np.arange(start, stop) for kind, start, stop in zip(kinds, counts, counts[1:], strict=False)}
    mesh = MeshLine1(
        np.ascontiguousarray(points.T), np.ascontiguousarray(cells), sort_t=False, validate=False
    ).with_subdomains({**names, **parts})
    # scikit-fem numbers as facets of a line mesh the points that cells touch
    touched = np.unique(cells)
    places = {name: np.searchsorted(touched, [node]) for name, node in nodes.items() if node in touched}
    return mesh.with_boundaries(places) if places else mesh


def numbered(mesh: Any) -> Any:
    """scikit-fem ``Dofs`` of a line mesh: six a node, ``ux uy uz rx ry rz``."""
    from skfem import Dofs, ElementLineP1, ElementVector

    element = ElementVector(ElementLineP1(), 6)
    element.dofnames = list(DISPLACEMENTS)
    return Dofs(mesh, element)
