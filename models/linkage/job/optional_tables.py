"""Further tables of the job, which a file asks for."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ....framework.batch import Array
from ...job import choices, digits, large_table
from ...job.outcome import Outcome
from .result import RunResult, compute

CONDITION = """\
`kappa` in `table.csv` is the condition number (2-norm) of the stiffness matrix as usually assembled, with a twin node
for each joint, and `kappa_scaled` that of the matrix that is solved, with its diagonal scaled to ones, both of the
linkage as the file has it."""
WITHOUT_BOUND = "Where contacts are found in equilibrium there is no bound on the numerical error of displacements."


def sections(result: RunResult) -> Iterator[str]:
    """Paragraphs of the report for the further tables that the file asks for."""
    also, outcome = result.inputs.also, result.outcome
    point = result.inputs.points[0]
    if "condition" in also:
        yield CONDITION
    if "digits" in also:
        yield from digits.section(outcome)
        if np.isnan(outcome.error_bound).all():
            yield WITHOUT_BOUND
    if "large" in also:
        yield from large_table.section(outcome, point, "table.csv")
    if result.inputs.choices:
        yield "### Choices"
        yield choices.EXPLAINED.format(where=result.where(result.pose), first=choices.first(outcome.count))
        yield choices.as_markdown(_chosen(result))


def columns(result: RunResult) -> dict[str, Array]:
    """Further columns of ``table.csv``, (poses,) each."""
    outcome, also, found = result.outcome, result.inputs.also, dict[str, Array]()
    if "condition" in also:
        found |= {"kappa": outcome.kappa, "kappa_scaled": outcome.kappa_scaled}
    if "large" in also:
        large, point = outcome.large, result.inputs.points[0]
        parts = {"mu": outcome.rigid + large.mean, "sigma": large.std}
        parts |= {"se_mu": large.standard_error, "se_sigma": large.std_standard_error}
        for name, values in list(parts.items())[:: 1 if outcome.count > 1 else 2][: 4 if outcome.count > 1 else 1]:
            found |= {f"{point}_large_{name}_{'xyz'[k]}": values[:, k] for k in range(3)}
    return found


def _chosen(result: RunResult) -> Iterator[tuple[str, Outcome]]:
    """The run at the pose of the figures, and the same with each choice of the file."""
    for name, inputs in result.inputs.chosen(result.pose, choices.COMPARED):
        yield name, compute(inputs).outcome
