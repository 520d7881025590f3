"""The page of the job: the four-bar at its poses, with the worst case of its clearances and lengths."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from ..distributions import SIGMAS, ends
from ..four_bar.description import JOINTS, LINKS
from ..job import digits
from ..linkage.page.data import MOST_POSES
from ..linkage.page.page import PageText, write_page
from .given_tolerances import given_tolerances

if TYPE_CHECKING:
    from ..linkage.motion import Motion
    from .inputs import Inputs
    from .result import Result

NUMBERS = (
    "Numbers are written to 12 digits. The table has a bound on the numerical error of the deflection at each pose. "
    "Worst cases are exact to first order in clearances and tolerances."
)


def write_job_page(result: Result, path: Path) -> None:
    """Write the page of P, with its samples."""
    inputs = result.inputs
    every = -(-len(inputs.theta) // MOST_POSES)
    motion = _motion(result, every)
    clearances, lengths = _limits(inputs)
    worst = motion.worst_case("P", clearances=clearances, lengths=lengths) if clearances or lengths else None
    text = PageText(
        title="Accuracy of a four-bar linkage",
        command="linkframe four-bar",
        about=[
            ("Inputs", _inputs(inputs)),
            ("Certainty of digits", f"{NUMBERS}\n\n{digits.as_text(result)}"),
            *([] if result.measured is None else [("Measured", result.measured.as_text())]),
        ],
        notes=list(_notes(inputs)),
        samples=f"outermost of {inputs.samples} samples, seed {inputs.rng}",
        status=result.marked_status[::every],
    )
    write_page(motion, path, "P", None, worst, text, samples=result.samples[::every])


def _motion(result: Result, every: int) -> Motion:
    """Motion of the four-bar under its mean load, at every `every`-th pose."""
    inputs = result.inputs
    linkage = result.motion.four_bar.linkage(inputs.theta[result.pose])
    linkage.load("P", fy=inputs.load)
    return linkage.move(A=inputs.theta[::every])


def _limits(inputs: Inputs) -> tuple[dict[str, float], dict[str | tuple[str, str, str], float]]:
    """Largest clearances, and tolerances of the lengths, for `Motion.worst_case`."""
    clearance = inputs.to_radius * (inputs.clearance + SIGMAS * inputs.clearance_sd)
    spans: tuple[str | tuple[str, str, str], ...] = ("crank", ("coupler", "B", "D"), "rocker", ("ground", "A", "E"))
    clearances = dict.fromkeys(JOINTS, clearance) if clearance else {}
    lengths = dict.fromkeys(spans, SIGMAS * inputs.length_sd) if inputs.length_sd else {}
    given = given_tolerances(inputs)
    for joint in JOINTS:
        if found := [given[name] for name in (f"clearance.{joint}", "clearance") if name in given]:
            clearances[joint] = ends(found[0])[1]
    for name, span in zip((*LINKS, "ground"), spans, strict=True):
        if name in given:
            lengths[span] = max(abs(end - getattr(inputs, name)) for end in ends(given[name]))
    return clearances, lengths


def _notes(inputs: Inputs) -> Iterator[str]:
    """Notes on the limits of the deviations, and on those without limits."""
    limited = ", or to the limits that --tolerance gives" if inputs.tolerance else ""
    yield (
        f"Clearances and lengths go to {SIGMAS:g} standard deviations{limited}. Not among the worst cases, as they "
        "do not move the rigid linkage: modulus of elasticity and stiffness of the joints; nor the load, which has its "
        "slider, and the contact angle, which is free."
    )


def _inputs(inputs: Inputs) -> str:
    """The options of the command line, one on each line."""
    options = [f"--{name.replace('_', '-')} {text}" for name, text in inputs.in_words(".12g").items()]
    return "\n".join(["SI units, angles in degrees; sd is the standard deviation of a normal distribution.", *options])
