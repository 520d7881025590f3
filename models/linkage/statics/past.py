"""Sign changes of determinants, which tell that a singular configuration was passed; for linkages and four-bars."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ....framework.batch import Array

Bools = NDArray[np.bool_]


def past(before: Sequence[Array], after: Sequence[Array], there: Bools) -> Bools:
    """Entries of `there` at which one of the determinants changes its sign from `before` to `after`, (...)."""
    changed = [one * other < 0.0 for one, other in zip(before, after, strict=True)]
    return np.asarray(there & np.any(np.broadcast_arrays(*changed), axis=0)) if changed else np.zeros_like(there)
