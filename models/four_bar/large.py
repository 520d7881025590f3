"""The samples at large displacement, for the poses at which linear mechanics has no numbers, or none that hold."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ..spread import Spread
from .accuracy import Accuracy, accuracy
from .parts import Parts
from .study import Study
from .tolerances import LOADS, per_joint, toleranced

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class LargeSpread(Spread):
    """Displacement of P from its nominal position at large displacement, (poses, n, 3), NaN where it has none.

    Attributes
    ----------
    passed
        Samples in which coupler and rocker passed through one line, so that they stand near the other branch,
        (poses, n).
    """

    passed: NDArray[np.bool_] = field(kw_only=True)


def large_parts(study: Study) -> tuple[Parts, NDArray[np.bool_]]:
    """The samples at the poses at which all of them can be assembled, and which these are, (poses,)."""
    nominal, inputs, contacts = study.nominal, study.inputs, study.nominal.contacts
    at = study.theta[:, None] + inputs.get("drive", np.zeros(1))
    varied = toleranced(nominal.motion.four_bar, inputs)
    closes = np.asarray(np.broadcast_to(varied.assembles(at), (len(at), study.n)).all(axis=-1))

    def sampled(cut: slice) -> Accuracy:
        drawn = {name: values[cut] for name, values in inputs.items()}
        return accuracy(
            toleranced(nominal.motion.four_bar, drawn),
            study.theta[closes, None] + drawn.get("drive", np.zeros(1)),
            load=tuple(drawn.get(name, value) for name, value in zip(LOADS, nominal.load, strict=True)),  # type: ignore[arg-type]
            clearance=per_joint(nominal.clearances, "clearance", drawn),
            contact="equilibrium" if contacts is None else per_joint(contacts, "contact", drawn),
        )

    return Parts(sampled, (int(closes.sum()), study.n), soon=contacts is None), closes


def large_samples(study: Study, parts: Parts, closes: NDArray[np.bool_]) -> LargeSpread:
    """The samples at large displacement; NaN where the linkage cannot be assembled."""
    samples = np.full((len(closes), study.n, 3), np.nan)
    samples[closes] = parts["large"] + parts["rigid"] - study.rigid[closes, None]
    passed = np.zeros(samples.shape[:2], dtype=bool)
    passed[closes] = parts["large_passes"]
    return LargeSpread(samples, passed=passed)
