"""Loads on the unknowns of a batch of banded matrices: as they act, or per unit of each right-hand-side parameter."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..batch import Array
from ..batched.plan import Plan
from ..lazily import cached_property
from ..structure.topology import Index
from .coupling import Together
from .evaluation import Picked, Sums
from .stacked_bands import Bands
from .terms import SumPattern


class StackedLoads:
    """Loads on some unknowns, in the order of elimination.

    Parameters
    ----------
    plan
        The plan of the batch.
    loaded
        Mask of the unknowns, (n,).
    bands
        Their matrices.
    sources
        Indices of the right-hand-side parameters that act on them.
    by_units
        Whether solutions are sought for units of these, instead of for the loads of each entry.
    """

    def __init__(self, plan: Plan, loaded: NDArray[np.bool_], bands: Bands, sources: Index, *, by_units: bool) -> None:
        self._plan, self._loaded, self._bands, self._sources = plan, loaded, bands, sources
        self._by_units = by_units
        self._found: dict[bool, Sums] = {}

    def of(self, matrices: Index, columns: Index, picked: Picked, *, imposed: bool = True) -> Array:
        """Right-hand sides (size, matrices, columns), by `imposed` displacements as well.

        Parameters
        ----------
        matrices
            Numbers of the matrices.
        columns
            Load cases, or right-hand-side parameters where units of these are solved for.
        picked
            Batch entries: of each matrix, or of each matrix and load case.
        imposed
            Whether prescribed displacements count.
        """
        size, sums = self._bands.size, self._sums(imposed)
        if self._by_units:
            units = self._per_unit(sums, picked)[columns].transpose(1, 2, 0)
            return np.ascontiguousarray(np.broadcast_to(units, (size, len(matrices), len(columns))))
        whole = np.broadcast_to(self._per_case(sums, picked), (size, len(matrices) * len(columns)))
        return np.ascontiguousarray(whole).reshape(size, len(matrices), len(columns))

    def acting(self, picked: Picked) -> Array:
        """Loads (size, m) at some batch entries, or (size, 1) if they do not vary; units if these are solved for."""
        return self._per_case(self._sums(True), picked)

    @cached_property
    def given(self) -> Together:
        """Values of all right-hand-side parameters."""
        return Together(self._plan.rhs_parameters.values)

    def _per_unit(self, sums: Sums, picked: Picked) -> Array:
        """Loads per unit of each right-hand-side parameter, (parameters, size, m), or (parameters, size, 1)."""
        found: Array = sums.at(picked) if sums.varies else sums.constant
        return found.reshape(len(self._sources), self._bands.size, -1)

    def _per_case(self, sums: Sums, picked: Picked) -> Array:
        found = self._per_unit(sums, picked)
        if self._by_units:
            one: Array = found[0]
            return one
        values = self._acting
        acting = picked.of_values(values) if values.plain is None else values.plain[:, None]
        whole: Array = found[0] * acting[0] if len(acting) == 1 else np.einsum("snm,sm->nm", found, acting)
        return whole

    @cached_property
    def _acting(self) -> Together:
        """Values of the right-hand-side parameters that act on the unknowns."""
        values = self._plan.rhs_parameters.values
        return Together([values[source] for source in self._sources.tolist()])

    def _sums(self, imposed: bool) -> Sums:
        """Loads per unit of each right-hand-side parameter, (parameters times size)."""
        if imposed not in self._found:
            self._found[imposed] = Sums(self._plan.coupling, self._pattern(imposed))
        return self._found[imposed]

    def _pattern(self, imposed: bool) -> SumPattern:
        loaded, place, terms, size = self._loaded, self._bands.place, self._plan.coupling.pattern, self._bands.size

        def found() -> SumPattern:
            acting = ~terms.stiff if imposed else terms.source >= terms.blocks[-2]
            own = np.flatnonzero(acting & loaded[terms.low])
            target = np.searchsorted(self._sources, terms.high[own] - terms.size) * size + place[terms.low[own]]
            return SumPattern(terms, own, target, len(self._sources) * size)

        pattern: SumPattern = terms.known(("loads", imposed, loaded.tobytes(), place.tobytes()), found)
        return pattern
