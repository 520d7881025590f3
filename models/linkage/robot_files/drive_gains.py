"""Stiffness and damping with which a drive follows its signal in a program of rigid-body dynamics."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ....framework.errors import FrameError
from ..description.joints import COMPONENTS
from ..description.linkage_description import LinkageDescription
from ..loaded_motion import LoadedMotion
from .placed import Placed

# For drives without a stiffness of their own: least natural angular frequency with the inertia that they move, per unit
# of time, and largest deflection in the reference configuration under the loads there, in radians or sizes.
FREQUENCY = 100.0
DEFLECTION = 1e-2


@dataclass(frozen=True)
class Gains:
    """Force of a drive per coordinate, and per rate of it."""

    stiffness: float
    damping: float


def drive_gains(placed: Placed, joint: str) -> list[Gains]:
    """Gains of each driven coordinate of a joint: its given stiffness, or else one by `FREQUENCY` and `DEFLECTION`.

    Damping is critical for the inertia that the drive moves in the reference configuration.
    """
    linkage, size = placed.linkage, placed.size
    pair, out = linkage.joints[joint], []
    moved, carried = _moved_and_carried(linkage, joint)
    for k, coordinate in enumerate(linkage.drives[joint]):
        unit = 1.0 if coordinate[0] == "r" else size
        inertia = moved[k] or sum(own.mass for own in placed.masses.values()) * (size / unit) ** 2 / 10.0
        given = float(np.max(pair.full_stiffness[..., COMPONENTS.index(coordinate)]))
        needed = max(inertia * FREQUENCY**2, carried[k] / (DEFLECTION * unit))
        stiffness = given if pair.stiffness is not None and 0.0 < given < np.inf else needed
        out.append(Gains(stiffness, 2.0 * float(np.sqrt(stiffness * inertia))))
    return out


def _moved_and_carried(linkage: LinkageDescription, joint: str) -> tuple[list[float], list[float]]:
    """Inertia that each driven coordinate moves, and its force at rest, in the reference configuration.

    The inertia is twice the kinetic energy at a rate of one. Both are zero if they cannot be computed.
    """
    count = len(linkage.drives[joint])
    rates = np.ones(1) if count == 1 else np.eye(count)
    try:
        inertia = 2.0 * LoadedMotion.of(linkage, {}, {joint: rates}, {}).kinetic_energy()
        force = np.abs(LoadedMotion.of(linkage, {}, {}, {}).reactions().drive(joint))
    except FrameError:
        return [0.0] * count, [0.0] * count
    return np.nan_to_num(inertia).tolist(), np.nan_to_num(force).tolist()
