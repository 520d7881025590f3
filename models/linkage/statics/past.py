"""When a determinant tells that a singular configuration was passed, of any linkage and of a four-bar's closed form."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ....framework.batch import Array

Bools = NDArray[np.bool_]


def past(before: Sequence[Array], after: Sequence[Array], there: Bools) -> Bools:
    """Where, of `there`, a determinant has changed its sign, (...)."""
    changed = [one * other < 0.0 for one, other in zip(before, after, strict=True)]
    return np.asarray(there & np.any(np.broadcast_arrays(*changed), axis=0)) if changed else np.zeros_like(there)
