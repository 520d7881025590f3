"""What each choice that the paper leaves open changes, at one pose."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..job import choices
from ..job.tables import readable
from .inputs import Inputs
from .result import compute


@dataclass(frozen=True, eq=False)
class ComparedChoices:
    """What the choices change; made by `compare_choices`.

    Attributes
    ----------
    angle
        Drive angle of the pose, degrees.
    lines
        By choice, the first of which is the run itself, the cells of a table by their headings.
    kappa
        Least and greatest condition number of the run's samples.
    """

    angle: float
    lines: list[dict[str, str]]
    kappa: tuple[float, float]


def compare_choices(inputs: Inputs, angle: float) -> ComparedChoices:
    """Run the job again with one choice changed at a time.

    Parameters
    ----------
    inputs
        Those of the run.
    angle
        Drive angle of the pose, degrees.
    """
    alone = inputs.but(poses=(angle, angle, 1.0), histogram_pose=None, samples=min(inputs.samples, choices.COMPARED))
    lines, ranges = [], []
    for name, change in _choices(inputs).items():
        other = compute(alone.but(**change), large=False)
        whole, plane = (each[0] for each in other.sampled_kappa)
        ranges.append((float(whole.min()), float(whole.max())))
        lines.append(
            {
                "choice": name,
                "compliance, µm": choices.micrometres(other),
                **dict(choices.deviations(other)),
                "κ": readable(other.kappa[0], ".3e"),
                "range of κ": _range(whole),
                "κ in the plane": readable(other.planar_kappa[0], ".3e"),
                "its range": _range(plane),
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


def _range(values: NDArray[np.float64]) -> str:
    return f"{readable(values.min(), '.2e')} … {readable(values.max(), '.2e')}"
