"""The samples at large displacement, for the poses at which linear mechanics has no numbers, or none that hold."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..job.parts import Parts
from ..job.remarks import without_equilibrium
from ..job.tables import aligned, markdown, readable, with_error
from ..spread import Spread
from .accuracy import Accuracy, accuracy
from .study import part_of
from .tolerances import LOADS, per_joint, toleranced

if TYPE_CHECKING:
    from .inputs import Inputs
    from .result import Result
    from .study import Study

Array = NDArray[np.float64]

HEADING = ("θ", *(f"{name} {way}" for way in ("linear", "large") for name in ("μ_x", "μ_y", "σ_x", "σ_y")), "status")
# Samples that are taken to large displacement, each of which takes as long as hundreds by linear mechanics.
MOST = 2000
# Samples of a pose that are named one by one.
MOST_NAMED = 5
EXPLAINED = """\
Mean and standard deviation of the position of P over the samples, in metres, by linear mechanics and at large
displacement, at the poses that are singular or at which the two differ by a tenth of the spread; in brackets the
standard error of the last digits. Large displacement takes each sample's links, joints and clearances to the stable
equilibrium to which its load leads; `table1.csv` holds it for all poses."""


@dataclass(frozen=True, eq=False)
class LargeSpread(Spread):
    """Displacement of P from its nominal position at large displacement, (poses, m, 3), NaN where it has none.

    Attributes
    ----------
    passed
        Samples in which coupler and rocker passed through one line, so that they stand near the other branch,
        (poses, m).
    """

    passed: NDArray[np.bool_] = field(kw_only=True)


def taken(samples: int) -> int:
    """How many of the samples are taken to large displacement, the first ones."""
    return min(samples, MOST)


def large_parts(study: Study) -> tuple[Parts, NDArray[np.bool_]]:
    """The first samples at the poses at which all of them can be assembled, and which these are, (poses,)."""
    n = taken(study.n)
    nominal, inputs, contacts = study.nominal, part_of(study.inputs, slice(n)), study.nominal.contacts
    at = study.theta[:, None] + inputs.get("drive", np.zeros(1))
    varied = toleranced(nominal.motion.four_bar, inputs)
    closes = np.asarray(np.broadcast_to(varied.assembles(at), (len(at), n)).all(axis=-1))

    def sampled(cut: slice) -> Accuracy:
        drawn = part_of(inputs, cut)
        return accuracy(
            toleranced(nominal.motion.four_bar, drawn),
            study.theta[closes, None] + drawn.get("drive", np.zeros(1)),
            load=tuple(drawn.get(name, value) for name, value in zip(LOADS, nominal.load, strict=True)),  # type: ignore[arg-type]
            clearance=per_joint(nominal.clearances, "clearance", drawn),
            contact="equilibrium" if contacts is None else per_joint(contacts, "contact", drawn),
        )

    return Parts(sampled, (int(closes.sum()), n), soon=contacts is None), closes


def large_samples(study: Study, parts: Parts, closes: NDArray[np.bool_]) -> LargeSpread:
    """The samples at large displacement; NaN where the linkage cannot be assembled."""
    samples = np.full((len(closes), parts.shape[1], 3), np.nan)
    samples[closes] = parts.taken("large") + parts.taken("rigid") - study.rigid[closes, None]
    passed = np.zeros(samples.shape[:2], dtype=bool)
    passed[closes] = parts.taken("large_passes")
    return LargeSpread(samples, "omit" if study.nan_policy == "omit" else "propagate", passed=passed)


def told(result: Result) -> list[str]:
    """Sentences where large displacement is not that of all samples."""
    return [*_first(result.inputs), *_lost(result)]


def _lost(result: Result) -> list[str]:
    """How many samples came to no equilibrium, and at which poses."""
    large = result.large
    lost = np.isnan(large.samples[..., 0]) & result.closes[:, None]
    at = [f"θ = {result.degrees[pose]:g}°" for pose in np.flatnonzero(lost.any(axis=1))]
    return without_equilibrium(int(lost.sum()), (len(lost), large.n), at, result.inputs.nan_policy)


def _first(inputs: Inputs) -> list[str]:
    if inputs.samples <= MOST:
        return []
    return [
        f"Large displacement is that of the first {MOST} of the {inputs.samples} samples, as each of them takes as "
        "long as hundreds by linear mechanics; where the two are compared, it is on the same samples."
    ]


def passages(result: Result) -> Iterator[str]:
    """A sentence for each pose at which samples ended near the other branch, and what they do to the spread."""
    large = result.large
    for pose in np.flatnonzero(large.passed.any(axis=1)):
        passed, moved = large.passed[pose], large.samples[pose, :, :2]
        others = moved[~passed & np.isfinite(moved).all(axis=-1)]
        rest = others.std(axis=0, ddof=1) if len(others) > 1 else np.full(2, np.nan)
        numbers = np.flatnonzero(passed)
        named = ", ".join(map(str, numbers[:MOST_NAMED])) + (" ..." if len(numbers) > MOST_NAMED else "")
        farthest = 1e3 * np.linalg.norm(moved[passed], axis=-1).max()
        without = " and ".join(readable(value, ".2e") for value in rest)
        one = len(numbers) == 1
        yield (
            f"At {result.degrees[pose]:g}° {len(numbers)} of {len(passed)} samples at large displacement"
            f" {'has' if one else 'have'} passed through the line of coupler and rocker and {'ends' if one else 'end'}"
            f" on the side of the other branch, P up to {farthest:.1f} mm from its rigid position (number {named} of"
            f" samples.npz, counted from 0); without {'it' if one else 'them'} σ_x and σ_y are {without} m."
        )


def rows(result: Result) -> Iterator[tuple[float, list[float], list[float], str]]:
    """Angle, linear and large means and deviations, their standard errors, and the status, of the poses that need it.

    Those are the poses that can be assembled and at which linear mechanics does not hold.
    """
    large = result.large
    numbers = (result.mean, result.std, result.rigid + large.mean, large.std)
    errors = (result.standard_error, result.std_standard_error, large.standard_error, large.std_standard_error)
    needed = result.assembled & (result.marked_status != "regular")
    values, doubts = (np.hstack([each[needed, :2] for each in columns]).tolist() for columns in (numbers, errors))
    yield from zip(result.degrees[needed].tolist(), values, doubts, result.marked_status[needed].tolist(), strict=True)


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
        [f"{angle:g}°", *(with_error(*each) for each in zip(values, doubts, _FORMS, strict=True)), status]
        for angle, values, doubts, status in rows(result)
    ]


_FORMS = (*["z.6f"] * 2, *[".2e"] * 2) * 2
