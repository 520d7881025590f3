"""Remarks that a reader should know before using the numbers of a run."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING

import numpy as np

from ...framework.errors import expected_mechanisms
from ..job.large_table import failed_samples
from ..job.remarks import beyond_size, without_result

if TYPE_CHECKING:
    from ..four_bar.study import Study
    from .inputs import Inputs
    from .result import Result


def remarks(result: Result) -> list[str]:
    """Sentences for the terminal and the report."""
    inputs, study = result.inputs, result.study
    where = [f"θ = {np.degrees(angle):g}°" for angle in study.theta]
    found = [
        f"--{name.replace('_', '-')} {getattr(inputs, name)} has no effect: {why}."
        for name, why in inputs.without_effect.items()
    ]
    found += failed_samples(result)
    found += beyond_size("P", study.nominal.compliance, _size(inputs), where)
    return found + without_result(lost(study), len(where), study.n, study.nan_policy)


def beforehand(result: Result) -> list[str]:
    """Remarks that are known before samples and large displacements, which take longer the softer the linkage is."""
    with expected_mechanisms():
        moved = result.compliance
    return beyond_size("P", moved, _size(result.inputs), [f"θ = {drive}" for drive in result.drives])


def _size(inputs: Inputs) -> float:
    """Length of the chain of links, metres."""
    return inputs.crank + inputs.coupler + inputs.rocker


def lost(study: Study) -> Counter[str]:
    """Number of samples without a result where the nominal linkage is regular, by reason, over all poses."""
    found = Counter[str]()
    for status in study.status[~study.nominal.motion.singular & (study.status != "regular")].tolist():
        reason, _, count = status.rpartition(" in ")
        found[reason] += int(count.split()[0])
    return found
