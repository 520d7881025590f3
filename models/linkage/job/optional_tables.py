"""Further tables of the job, if the file asks for them."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...job import choices, digits, large_table
from ...job.outcome import SPECTRA, Outcome
from .result import RunResult, compute

CONDITION = """\
`kappa` in `table.csv` is the condition number (2-norm) of the stiffness matrix as usually assembled, with a twin node
for each joint, `kappa_plane` that of its rows and columns in the plane in which the linkage moves, and `kappa_scaled`
that of the matrix that is solved, scaled node by node; all of the linkage as the file has it."""
WITHOUT_BOUND = "Where contacts are found in equilibrium there is no bound on the numerical error of displacements."


def sections(result: RunResult) -> Iterator[str]:
    """Paragraphs of the report for the further tables that the file asks for."""
    also, outcome = result.inputs.also, result.outcome
    if "condition" in also:
        yield CONDITION
        yield from _ranges(result)
    if "digits" in also:
        yield from digits.section(outcome)
        if np.isnan(outcome.error_bound).all():
            yield WITHOUT_BOUND
    if "large" in also:
        yield from large_table.section(outcome, "table.csv")
    if result.inputs.choices:
        yield "### Choices"
        yield choices.EXPLAINED.format(where=result.where(result.pose), first=choices.first(outcome.count))
        yield choices.as_markdown(_chosen(result))


def columns(result: RunResult) -> dict[str, NDArray[Any]]:
    """Further columns of ``table.csv``, (poses,) each."""
    outcome, also, found = result.outcome, result.inputs.also, dict[str, NDArray[Any]]()
    if "condition" in also:
        found |= {"kappa": outcome.kappa, "kappa_plane": outcome.planar_kappa, "kappa_scaled": outcome.kappa_scaled}
    if "large" in also:
        large, point = outcome.large, result.inputs.points[0]
        parts = {"mu": outcome.rigid + large.mean, "sigma": large.std}
        parts |= {"se_mu": large.standard_error, "se_sigma": large.std_standard_error}
        for name, values in list(parts.items())[:: 1 if outcome.count > 1 else 2][: 4 if outcome.count > 1 else 1]:
            found |= {f"{point}_large_{name}_{'xyz'[k]}": values[:, k] for k in range(3)}
        found |= {f"{point}_large_passes": np.count_nonzero(large.passed, axis=1)}
    return found


def _ranges(result: RunResult) -> Iterator[str]:
    """Sentence with the range of the condition numbers over the samples, at the pose of the figures."""
    if not result.inputs.tolerances:
        return
    at = RunResult(result.inputs.at_pose(result.pose))
    each = zip(("κ", "κ in the plane"), map(choices.bounds, at.outcome.sampled_kappa), strict=True)
    told = [f"{name} lies between {least:.3e} and {most:.3e}" for name, (least, most) in each if np.isfinite(least)]
    if told:
        count = min(result.inputs.samples, SPECTRA)
        yield f"At {result.where(result.pose)}, over {count} samples, {', '.join(told)}."


def _chosen(result: RunResult) -> Iterator[tuple[str, Outcome]]:
    """Outcome at the pose of the figures, unchanged and with each choice of the file."""
    for name, inputs in result.inputs.chosen(result.pose, choices.COMPARED):
        yield name, compute(inputs).outcome
