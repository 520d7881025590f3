"""Tolerances of the four-bar's job that the command line gives in words."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ...framework.errors import FrameError
from ..four_bar.description import JOINTS, LINKS
from ..four_bar.tolerances import COMPONENTS, NAMES
from ..given_distributions import called, distribution_of, frozen, tolerance

if TYPE_CHECKING:
    from ..sampling import Distribution
    from .inputs import Inputs

# Options under the names of what they vary, and names in files of linkages under those of the four-bar.
ALIASES = (
    (r"joints\.([BDE])\.(stiffness|clearance|contact)", r"\2.\1"),
    (r"young(\.\w+)?", r"E\1"),
    (r"load|loads\.0\.fy", "fy"),
    (r"loads\.0\.(fx|mz)", r"\1"),
)
IN_PERCENT = re.compile(r"(?:±\s*|\+/?-\s*)?([\d.eE+-]+)\s*%")


@dataclass(frozen=True)
class Rescaled:
    """A distribution in another unit.

    Attributes
    ----------
    distribution
        That in the unit of the command line.
    factor
        From there to what is computed with.
    """

    distribution: Distribution
    factor: float

    def ppf(self, q: NDArray[np.float64], /) -> NDArray[np.float64]:
        """Quantile at probability `q`.

        Parameters
        ----------
        q
            Probabilities in (0, 1), (...).

        Returns
        -------
        ndarray
            Quantiles, (...).
        """
        return np.asarray(self.factor * self.distribution.ppf(q))


def given_tolerances(inputs: Inputs) -> dict[str, Distribution]:
    """Distributions that the command line gives, by the name of what they vary as in `monte_carlo`.

    Raises
    ------
    FrameError
        If a name is no parameter of the four-bar, or what it deviates by cannot be meant.
    """
    found = {}
    # One of all joints or links stands before those of one, which rule.
    given = [(parameter(name), text) for name, text in inputs.tolerance]
    for name, text in sorted(given, key=lambda each: "." in each[0]):
        nominal, factor = _nominal(inputs, name)
        distribution = _in_words(f"--tolerance {name}={text}", nominal, text)
        for each in _own(inputs, name):
            found[each] = distribution if factor == 1.0 else Rescaled(distribution, factor)
    return found


def parameter(name: str) -> str:
    """What a name stands for, checked."""
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
    """The parameters that draw on their own: one a link, and one a joint unless all share one draw."""
    if name == "E":
        return [f"E.{link}" for link in LINKS]
    of_joints = name in ("stiffness", "clearance", "contact", *COMPONENTS)
    return [f"{name}.{joint}" for joint in JOINTS] if of_joints and inputs.joints == "independent" else [name]


def _nominal(inputs: Inputs, name: str) -> tuple[float, float]:
    """Nominal value in the unit of the command line, and the factor from there to what is computed with."""
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


def _in_words(option: str, nominal: float, text: str) -> Distribution:
    """A deviation from the nominal value, or a distribution, in the unit of the command line."""
    if not np.isfinite(nominal):
        raise FrameError(f"{option}: the nominal value is {nominal}, which cannot vary: leave the tolerance out")
    try:
        table = called(text)
        if table is not None:
            return _called(option, nominal, *table)
        words, _, kind = text.rpartition(" ")
        kind = kind if kind in ("uniform", "normal") else ""
        words = words if kind else text
        if IN_PERCENT.fullmatch(words):
            words = f"± {IN_PERCENT.fullmatch(words)[1]} %"  # type: ignore[index]
        elif re.fullmatch(r"[\d.eE+-]+", words):
            words = f"± {words}"
        if words.startswith(("±", "+")):
            return tolerance(nominal, words, kind or "uniform")
        return distribution_of(option, text)
    except FrameError as error:
        raise FrameError(f"{option}: {error}") from error


def _called(option: str, nominal: float, name: str, numbers: Mapping[str, float | str]) -> Distribution:
    """A distribution of SciPy; numbers in percent are deviations from the nominal value, as a share of it."""
    values = {key: value for key, value in numbers.items() if not isinstance(value, str)}
    shares = {key: 0.01 * float(value.strip("±% ")) for key, value in numbers.items() if isinstance(value, str)}
    if shares and not (nominal and shares.keys() <= {"loc", "scale"} and not {"loc", "scale"} & values.keys()):
        raise FrameError(
            f"percentages are for loc and scale together, as deviations from the nominal value {nominal:g} (not 0), "
            "and loc may be left out: give other numbers without a percentage"
        )
    if shares:
        values |= {"loc": nominal * (1.0 + shares.get("loc", 0.0)), "scale": abs(nominal) * shares.get("scale", 0.0)}
    return distribution_of(option, frozen(name, values))
