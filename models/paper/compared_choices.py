"""Effects of the choices that the paper leaves open, at one pose."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from ..job import choices
from ..job.tables import readable
from .inputs import Inputs
from .result import compute


@dataclass(frozen=True, eq=False)
class ComparedChoices:
    """Effects of the choices; made by `compare_choices`.

    Attributes
    ----------
    angle
        Drive angle of the pose, degrees.
    lines
        For each choice, of which the first is the run itself: cells of the table by heading.
    kappa
        Least and largest condition number of the run's samples.
    """

    angle: float
    lines: list[dict[str, str]]
    kappa: tuple[float, float]


def compare_choices(inputs: Inputs, angle: float) -> ComparedChoices:
    """Run the job again with one choice changed at a time.

    Parameters
    ----------
    inputs
        Inputs of the run.
    angle
        Drive angle of the pose, degrees.
    """
    alone = inputs.but(poses=(angle, angle, 1.0), histogram_pose=None, samples=min(inputs.samples, choices.COMPARED))
    lines, ranges = [], []
    for name, change in _choices(inputs).items():
        other = compute(alone.but(**change), large=False)
        ranges.append(choices.bounds(other.sampled_kappa[0][0]))
        lines.append(
            {
                "choice": name,
                "compliance, µm": choices.micrometres(other),
                **dict(choices.deviations(other)),
                "κ": readable(other.kappa[0], ".3e"),
                **dict(choices.condition_ranges(other)),
            }
        )
    return ComparedChoices(angle, lines, ranges[0])


def _choices(inputs: Inputs) -> Mapping[str, Mapping[str, object]]:
    side = "short" if inputs.in_plane == "long" else "long"
    draws = "shared" if inputs.joints == "independent" else "independent"
    gap = "diameter" if inputs.clearance_is == "radius" else "radius"
    nu = 0.0 if inputs.poisson else 0.3
    found: dict[str, dict[str, object]] = {
        "this run": {},
        f"the {side} side of the section in the plane": {"in_plane": side},
        f"ν = {nu:g}": {"poisson": nu},
        f"{draws} draws of k, ε, γ in the joints": {"joints": draws},
        f"ε on the {gap}": {"clearance_is": gap},
        "contact along the joint's force": {"contact": "reaction"},
    }
    if isinstance(inputs.contact, str) or not inputs.load:
        del found["contact along the joint's force"]
    return found
