"""Possible meanings of the paper's clearances, which it does not specify, and the spread of P for each."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from ..four_bar.clearance import clearance_map
from ..four_bar.description import JOINTS
from ..four_bar.four_bar import FourBar, FourBarMotion
from .inputs import Inputs
from .printed import Printed

Array = NDArray[np.float64]
Maps = dict[str, Array]

# Number of decimals of the paper's lengths, in metres.
DECIMALS = 4
AVERAGED = "two chains averaged, the loop not closed"


@dataclass(frozen=True, eq=False)
class Reading:
    """One possible meaning of the paper's clearances.

    Attributes
    ----------
    name
        Description of the reading.
    closed
        Whether the loop is closed again.
    std
        Standard deviation of the displacement of P by the clearances, (poses, 2).
    """

    name: str
    closed: bool
    std: Array

    def equal(self, printed: Array) -> int:
        """Number of printed standard deviations (poses, 2) that equal those of the reading, rounded in the same way."""
        return int(np.count_nonzero(np.round(self.std, DECIMALS) == np.round(printed, DECIMALS)))


def offset_covariance(mean: float, deviation: float, contact: float, contact_deviation: float) -> Array:
    """Covariance of the offset ε (cos γ, sin γ) in a joint, Eq. (11), with independent normal ε and γ.

    It follows from E[exp(i k γ)] = exp(i k γ̄ − k² s²/2) for k = 1 and 2.

    Parameters
    ----------
    mean, deviation
        Mean and standard deviation of ε.
    contact, contact_deviation
        Mean and standard deviation s of γ, radians.

    Returns
    -------
    ndarray
        Covariance, (2, 2).
    """
    once, twice = (np.exp(1j * k * contact - 0.5 * (k * contact_deviation) ** 2) for k in (1, 2))
    square = mean**2 + deviation**2
    first = mean * np.array([once.real, once.imag])
    second = 0.5 * square * np.array([[1.0 + twice.real, twice.imag], [twice.imag, 1.0 - twice.real]])
    return np.asarray(second - np.outer(first, first))


def population_std(maps: Maps, covariance: Array, *, shared: bool = False) -> Array:
    """Standard deviation of P over the whole population of clearances, to first order, (..., 2).

    Parameters
    ----------
    maps
        By joint with an offset: derivative of the displacement of P by it, (..., 2, 2).
    covariance
        Covariance of the offset in each joint, (2, 2).
    shared
        Whether all joints share one draw.

    Returns
    -------
    ndarray
        Standard deviation in x and y, (..., 2).
    """
    parts = [sum(maps.values(), start=np.zeros(()))] if shared else list(maps.values())
    variance = sum((part @ covariance @ np.swapaxes(part, -1, -2) for part in parts), start=np.zeros(()))
    return np.asarray(np.sqrt(np.diagonal(variance, axis1=-2, axis2=-1)))


def run_std(inputs: Inputs, motion: FourBarMotion) -> Array | None:
    """Standard deviation of the whole population by the clearances of a run, (..., 2).

    None if these are not normal, or contact angles follow from forces.
    """
    if isinstance(inputs.contact, str) or not inputs.has_normal_clearances:
        return None
    return population_std(clearance_map(motion), _covariance(inputs), shared=inputs.joints == "shared")


def readings(table: Printed) -> list[Reading]:
    """The readings of the paper's clearances, at the regular printed poses.

    Parameters
    ----------
    table
        The printed table.

    Returns
    -------
    list of Reading
        Readings with the loop closed or not, a draw for each joint or one for all, and ε on the radius or the diameter.
    """
    motion = FourBar().move(np.radians(table.theta[table.regular]))
    found = []
    for (name, closed, maps), given in product(_chains(motion), ("radius", "diameter")):
        for draws in ("",) if len(maps) == 1 else ("; a draw for each joint", "; one draw for all joints"):
            std = population_std(maps, _covariance(Inputs(clearance_is=given)), shared=draws.startswith("; one"))
            std = np.broadcast_to(std, (len(motion.theta), 2))
            found.append(Reading(f"{name}{draws}; ε on the {given}", closed, std))
    return found


def _covariance(inputs: Inputs) -> Array:
    scale = 0.5 if inputs.clearance_is == "diameter" else 1.0
    gap, spread = scale * inputs.clearance, scale * inputs.clearance_sd
    assert not isinstance(inputs.contact, str)
    return offset_covariance(gap, spread, np.radians(inputs.contact), np.radians(inputs.contact_sd))


def _chains(motion: FourBarMotion) -> Iterator[tuple[str, bool, Maps]]:
    """Ways in which offsets displace P: name, whether the loop is closed, and the map of each joint."""
    maps = clearance_map(motion)
    yield "loop closed", True, maps
    for joint in JOINTS:
        yield f"loop closed, clearance in {joint} alone", True, {joint: maps[joint]}
    unit = np.eye(2)
    yield "chain A B P alone, the loop not closed", False, {"B": unit}
    yield "chain E D P alone, the loop not closed", False, {"D": -unit, "E": -unit}
    yield AVERAGED, False, {"B": 0.5 * unit, "D": -0.5 * unit, "E": -0.5 * unit}
