"""The stiffness matrix of one large frame, with its factors, shared by all load cases."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np
import scipy
from numpy.typing import NDArray

from ..batch import Array, all_of, any_of
from ..batched.unloaded import Unloaded
from ..clock import timed
from ..examined import Examined
from ..lazily import cached_property
from ..structure.matrices import Matrices
from ..structure.topology import Index
from .banded import BandedFactor
from .cholesky import CholeskyFactor
from .condensed import Places
from .deformation_table import Deformations
from .factor import Factor, NoFactor
from .freedom import unsupported_motions
from .graph import Graph
from .iterative import Iterative
from .lu import LUFactor
from .method import BANDED, CHOLESKY, ITERATIVE, available
from .patterns import connected_by, part
from .refinement import REFINED
from .spring_residual import are_described
from .tensions import TensionFactor, affordable


class SparseStiffness:
    """The stiffness of a frame, constant over the batch, and its factors, computed when first needed.

    Parameters
    ----------
    unloaded
        The frame without its loads.
    method
        Name of the method, see `linkframe.framework.solvers.method`.
    """

    def __init__(self, unloaded: Unloaded, method: str) -> None:
        self.unloaded, self.method, self.matrices = unloaded, method, Matrices(unloaded)
        self.unknown: Index = unloaded.graph.unknown
        self.factors: dict[bytes, Factor] = {}
        self._better: dict[bytes, Factor] = {}
        self._some: dict[bytes, Deformations] = {}

    @cached_property
    def deformations(self) -> Deformations | None:
        """Deformations per unknown, for refinement; None where there is none, or they would contain rounding."""
        rows = self.unloaded.graph.transformation
        if self.method == ITERATIVE or len(self.unknown) > REFINED or rows.imposed:
            return None
        if not are_described(self.unloaded, rows):
            return None
        return Deformations(self.unloaded, rows, np.arange(len(self.unknown)))

    @cached_property
    def assembled(self) -> scipy.sparse.csr_matrix:
        """The stiffness that is factorised, (n, n): from the deformations, if these are needed in any case.

        If there are user-defined elements, it is assembled from their stiffness matrices.
        """
        found = None
        own = any(isinstance(group.element, Examined) for group in self.unloaded.topology.groups)
        if self.deformations is not None and not own:
            found = self.deformations.stiffness()
        return self.matrices.stiffness if found is None else found

    def deformations_of(self, where: NDArray[np.bool_]) -> Deformations | None:
        """Deformations per unknown in the mask `where` (n,)."""
        if self.deformations is None or all_of(where):
            return self.deformations
        key = where.tobytes()
        if key not in self._some:
            self._some[key] = self.deformations.restricted(where)
        return self._some[key]

    def telling_deformations(self, where: NDArray[np.bool_]) -> Deformations | None:
        """Deformations by which a matrix that is singular in double precision is examined; None if too costly."""
        rows, graph = self.unloaded.graph.transformation, self.unloaded.graph
        if not (affordable(int(where.sum()), graph.width) and are_described(self.unloaded, rows)):
            return None
        found = self.deformations_of(where)
        if found is None:
            key = where.tobytes()
            if key not in self._some:
                self._some[key] = Deformations(self.unloaded, rows, np.where(where, np.cumsum(where) - 1, -1))
            found = self._some[key]
        return found

    @cached_property
    def label(self) -> Index:
        """Number of the connected component of each unknown, (n,)."""
        return connected_by(self.assembled)

    @cached_property
    def unsupported_motions(self) -> Array:
        """Rigid motions of unsupported parts, as values of the unknowns, (n, m)."""
        return unsupported_motions(self.unloaded)

    def factor(self, where: NDArray[np.bool_], times: dict[str, float]) -> Factor:
        """Factor of the stiffness of some unknowns; by tensions if it is singular in double precision.

        Parameters
        ----------
        where
            Mask of the unknowns, (n,).
        times
            Dict to which the time is added, by kind of work.
        """
        found, key = self.direct_factor(where, times), where.tobytes()
        if key not in self._better:
            with timed(times, "factorisation"):
                better = self._by_tensions(where) if found.singular else None
            self._better[key] = found if better is None else better
        return self._better[key]

    def direct_factor(self, where: NDArray[np.bool_], times: dict[str, float]) -> Factor:
        """Factor of the stiffness matrix itself of some unknowns, computed once.

        Parameters
        ----------
        where
            Mask of the unknowns, (n,).
        times
            Dict to which the time is added, by kind of work.
        """
        key = where.tobytes()
        if key not in self.factors:
            with timed(times, "assembly"):
                matrix = self._matrix(where)
            with timed(times, "factorisation"):
                self.factors[key] = self._factorised(matrix, where)
        return self.factors[key]

    def direct(self, where: NDArray[np.bool_]) -> Callable[[scipy.sparse.csr_matrix], Factor]:
        """Function that factorises a matrix of the unknowns in a mask (n,), of the pattern of the stiffness."""
        return partial(_direct, self.method, self.unloaded.graph, self.label, where)

    def _matrix(self, where: NDArray[np.bool_]) -> scipy.sparse.csr_matrix:
        return self.assembled if all_of(where) else part(self.assembled, where)

    def _factorised(self, matrix: scipy.sparse.csr_matrix, where: NDArray[np.bool_]) -> Factor:
        if not any_of(where):
            return NoFactor(matrix)
        direct = self.direct(where)
        return direct(matrix) if self.method != ITERATIVE else self._iterated(matrix, where, direct)

    def _by_tensions(self, where: NDArray[np.bool_]) -> Factor | None:
        """Factor by tensions, for a stiffness that is singular in double precision; None if it costs too much."""
        deformations, graph = self.telling_deformations(where), self.unloaded.graph
        if deformations is None or (deformations.springs < 0.0).any():
            return None
        order = graph.order(graph.band, where)
        return TensionFactor(self._matrix(where), deformations.by_unknowns, deformations.springs, order)

    def _iterated(
        self, matrix: scipy.sparse.csr_matrix, where: NDArray[np.bool_], direct: Callable[..., Factor]
    ) -> Factor:
        graph = self.unloaded.graph
        free = graph.free & np.array([body is None for body in self.unloaded.topology.bodies])
        places = Places(graph.node, self.unknown % 6, graph.points[graph.node], free[graph.node])
        return Iterative(matrix, places.of(where), direct)


def _direct(name: str, graph: Graph, label: Index, where: NDArray[np.bool_], matrix: scipy.sparse.csr_matrix) -> Factor:
    """Factor of the matrix of the unknowns in the mask `where`; `label` (n,) are their connected components."""
    if name == BANDED:
        order = graph.order(graph.band, where)
        # unknowns are grouped by component, which makes the band of a plane frame half as wide
        return BandedFactor(matrix, order[np.argsort(label[where][order], kind="stable")])
    if name == CHOLESKY or (name == ITERATIVE and available()):
        return CholeskyFactor(matrix, graph.order(graph.dissection.order, where))
    return LUFactor(matrix)
