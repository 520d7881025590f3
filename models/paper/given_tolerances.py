"""Tolerances in words of the command line of ``linkframe four-bar``."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from ...framework.errors import FrameError
from ..four_bar.description import JOINTS, LINKS
from ..four_bar.tolerances import COMPONENTS, NAMES
from ..given_deviations import Rescaled, deviation

if TYPE_CHECKING:
    from ..sampling import Distribution
    from .inputs import Inputs

# Names of parameters of the four-bar, by names of options and by those in files of linkages.
ALIASES = (
    (r"joints\.([BDE])\.(stiffness|clearance|contact)", r"\2.\1"),
    (r"young(\.\w+)?", r"E\1"),
    (r"load|loads\.0\.fy", "fy"),
    (r"loads\.0\.(fx|mz)", r"\1"),
)

# Parameters whose samples must not be negative, except for this share of them.
NOT_NEGATIVE = (*LINKS, "ground", "E", "stiffness", "clearance", *COMPONENTS)
RAREST = 1e-6


def given_tolerances(inputs: Inputs) -> dict[str, Distribution]:
    """Distributions of the command line, by name of the parameter as for `monte_carlo`.

    Raises
    ------
    FrameError
        If a name is not a parameter of the four-bar, or its deviation cannot be meant.
    """
    found = {}
    # tolerances of a single joint or link come last, and replace those of all joints or links
    given = [(parameter(option), option, text) for option, text in inputs.tolerance]
    for name, option, text in sorted(given, key=lambda each: "." in each[0]):
        nominal, factor = _nominal(inputs, name)
        distribution = _in_words(option, text, nominal)
        for each in _own(inputs, name):
            found[each] = distribution if factor == 1.0 else Rescaled(distribution, factor)
    return found


def parameter(name: str) -> str:
    """Parameter of the four-bar that a name stands for, checked."""
    for pattern, replacement in ALIASES:
        match = re.fullmatch(pattern, name)
        found = match.expand(replacement) if match else name
        if found in NAMES:
            return found
    raise FrameError(
        f"--tolerance {name}: the four-bar has no number of that name; give one of {', '.join(LINKS)}, ground, drive, "
        f"load, young, stiffness, clearance, contact, fx, mz or {', '.join(COMPONENTS)}; behind those of a joint "
        f".{', .'.join(JOINTS)} may stand, behind young .{', .'.join(LINKS)}"
    )


def _own(inputs: Inputs, name: str) -> list[str]:
    """Parameters with independent draws: one for each link, and one for each joint unless all share one draw."""
    if name == "E":
        return [f"E.{link}" for link in LINKS]
    of_joints = name in ("stiffness", "clearance", "contact", *COMPONENTS)
    return [f"{name}.{joint}" for joint in JOINTS] if of_joints and inputs.joints == "independent" else [name]


def _nominal(inputs: Inputs, name: str) -> tuple[float, float]:
    """Nominal value in the unit of the command line, and the factor from there to the unit of the computation."""
    what = name.partition(".")[0]
    if what == "contact":
        if isinstance(inputs.contact, str):
            raise FrameError(
                f"--tolerance {name} beside --contact {inputs.contact}: the angle follows from the forces and has no "
                "deviation of its own; leave out one of the two"
            )
        return inputs.contact, float(np.radians(1.0))
    if what == "clearance":
        return inputs.clearance, inputs.to_radius
    values: Mapping[str, float] = {
        "drive": 0.0, "fx": 0.0, "fy": inputs.load, "mz": 0.0, "E": inputs.young, "krz": 0.0,
        **dict.fromkeys(("stiffness", *COMPONENTS[:5]), inputs.stiffness),
    }  # fmt: skip
    found = values[what] if what in values else getattr(inputs, what)
    return float(found), float(np.radians(1.0)) if what == "drive" else 1.0


def _in_words(name: str, text: str, nominal: float) -> Distribution:
    """The given distribution, in the unit of the command line."""
    option = f"--tolerance {name}={text}"
    if not np.isfinite(nominal):
        raise FrameError(f"{option}: the nominal value is {nominal}, which cannot vary: leave the tolerance out")
    try:
        found = deviation(name, nominal, text)
        found.require_near(nominal, name)
        distribution = found.about(nominal)
        least = float(distribution.ppf(np.array(RAREST)))
        if parameter(name).partition(".")[0] in NOT_NEGATIVE and least < 0.0:
            raise FrameError(
                f"samples would go below zero, one in a million to {least:g}: give a narrower distribution"
            )
        return distribution
    except FrameError as error:
        raise FrameError(f"{option}: {error}") from error
