"""Stability out of the plane to which a solution was kept."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..batch import Array
from .elimination import LARGE, Elimination
from .equations import Equations, State
from .model import Model

if TYPE_CHECKING:
    from .march import March


def least_pivot(march: March, state: State, flat: Model) -> Array:
    """Least eigenvalue (of a large frame: pivot) of the tangent in space, scaled to a unit diagonal, (entries,)."""
    model = Model(flat.plan, flat=False)
    _, rows, columns = model.pattern
    elimination = Elimination(rows, columns, model.free)
    out = np.empty(march.count)
    for begin in range(0, march.count, march.chunk):
        index = np.arange(begin, min(begin + march.chunk, march.count))
        equations = Equations(model, march.where(index), len(index))
        values = equations.linearised(state.taken(index)).values
        if elimination.size > LARGE:
            out[index] = elimination.factor(values).pivots.min(axis=0)
            continue
        out[index] = elimination.spectrum(values)[1][:, 0]
    return out
