"""The samples at large displacement, for the poses at which linear mechanics has no numbers, or none that hold."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..four_bar.study import SampledAccuracy, Study, part_of
from ..four_bar.tolerances import toleranced
from ..job.outcome import LargeSpread, taken
from ..job.parts import Parts

Array = NDArray[np.float64]


def large_parts(study: Study) -> tuple[Parts, NDArray[np.bool_]]:
    """The first samples at the poses at which all of them can be assembled, and which these are, (poses,)."""
    n = taken(study.n)
    nominal, inputs, contacts = study.nominal, part_of(study.inputs, slice(n)), study.nominal.contacts
    at = study.theta[:, None] + inputs.get("drive", np.zeros(1))
    varied = toleranced(nominal.motion.four_bar, inputs)
    closes = np.asarray(np.broadcast_to(varied.assembles(at), (len(at), n)).all(axis=-1))

    sampled = SampledAccuracy(
        nominal.motion.four_bar,
        at[closes],
        inputs,
        nominal.load,
        nominal.clearances,
        "equilibrium" if contacts is None else contacts,
    )
    return Parts(sampled, (int(closes.sum()), n), soon=contacts is None), closes


def large_samples(study: Study, parts: Parts, closes: NDArray[np.bool_]) -> LargeSpread:
    """The samples at large displacement; NaN where the linkage cannot be assembled."""
    samples = np.full((len(closes), parts.shape[1], 3), np.nan)
    samples[closes] = parts.taken("large") + parts.taken("rigid") - study.rigid[closes, None]
    passed = np.zeros(samples.shape[:2], dtype=bool)
    passed[closes] = parts.taken("large_passes")
    return LargeSpread(samples, "omit" if study.nan_policy == "omit" else "propagate", passed=passed)
