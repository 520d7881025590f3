"""The samples at large displacement, for the poses at which linear mechanics has no numbers, or none that hold."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..job.tables import aligned, markdown, readable
from ..spread import Spread
from .accuracy import Accuracy, accuracy
from .parts import Parts
from .tolerances import LOADS, per_joint, toleranced

if TYPE_CHECKING:
    from .result import Result
    from .study import Study

Array = NDArray[np.float64]

HEADING = ("θ", *(f"{name} {way}" for way in ("linear", "large") for name in ("μ_x", "μ_y", "σ_x", "σ_y")), "status")
EXPLAINED = """\
Mean and standard deviation of the position of P over the samples, in metres, by linear mechanics and at large
displacement, at the poses that are singular or at which the two differ by a tenth of the spread. Large displacement
takes each sample's links, joints and clearances to the stable equilibrium to which its load leads; `table1.csv` holds
it for all poses."""


def large_parts(study: Study) -> tuple[Parts, NDArray[np.bool_]]:
    """The samples at the poses at which all of them can be assembled, and which these are, (poses,)."""
    nominal, inputs = study.nominal, study.inputs
    at = study.theta[:, None] + inputs.get("drive", np.zeros(1))
    varied = toleranced(nominal.motion.four_bar, inputs)
    closes = np.asarray(np.broadcast_to(varied.assembles(at), (len(at), study.n)).all(axis=-1))
    contacts = nominal.contacts

    def sampled(drawn: Mapping[str, Array]) -> Accuracy:
        return accuracy(
            toleranced(nominal.motion.four_bar, drawn),
            study.theta[closes, None] + drawn.get("drive", np.zeros(1)),
            load=tuple(drawn.get(name, value) for name, value in zip(LOADS, nominal.load, strict=True)),  # type: ignore[arg-type]
            clearance=per_joint(nominal.clearances, "clearance", drawn),
            contact="equilibrium" if contacts is None else per_joint(contacts, "contact", drawn),
        )

    return Parts(sampled, inputs, (int(closes.sum()), study.n), soon=contacts is None), closes


def large_samples(study: Study, parts: Parts, closes: NDArray[np.bool_]) -> Spread:
    """Displacement of P from its nominal position (poses, n, 3), NaN where the linkage cannot be assembled."""
    samples = np.full((len(closes), study.n, 3), np.nan)
    samples[closes] = parts["large"] + parts["rigid"] - study.rigid[closes, None]
    return Spread(samples)


def rows(result: Result) -> Iterator[tuple[list[float], str]]:
    """Angle, linear and large means and deviations, and the status of the poses that need the large ones."""
    columns = (result.mean, result.std, result.rigid + result.large.mean, result.large.std)
    mean, spread, true_mean, true_spread = (column[:, :2] for column in columns)
    needed = result.marked_status != "regular"
    numbers = np.column_stack([result.degrees, mean, spread, true_mean, true_spread])
    yield from zip(numbers[needed].tolist(), result.marked_status[needed].tolist(), strict=True)


def as_text(result: Result) -> str:
    """The table for a terminal; empty where no pose needs it."""
    found = _cells(result)
    return aligned([HEADING, *found]) if found else ""


def as_markdown(result: Result) -> str:
    """The table for the report."""
    found = _cells(result)
    return markdown(HEADING, found) if found else "Linear mechanics holds at all poses."


def _cells(result: Result) -> list[list[str]]:
    return [
        [f"{values[0]:g}°", *(readable(value, form) for value, form in zip(values[1:], _FORMS, strict=True)), status]
        for values, status in rows(result)
    ]


_FORMS = (*["z.6f"] * 2, *[".2e"] * 2) * 2
