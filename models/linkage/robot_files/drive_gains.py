"""How stiffly a drive follows its signal in an engine of rigid bodies."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ....framework.errors import FrameError
from ..description.joints import COMPONENTS
from ..description.linkage_description import LinkageDescription
from ..loaded_motion import LoadedMotion
from .placed import Placed

# Circular frequency with which a drive without a stiffness of its own comes to rest, per unit of time; and how far, in
# radians or sizes of the linkage, it deflects in the reference configuration under what acts there.
FREQUENCY = 100.0
DEFLECTION = 1e-2


@dataclass(frozen=True)
class Gains:
    """Force of a drive per coordinate, and per rate of it."""

    stiffness: float
    damping: float


def drive_gains(placed: Placed, joint: str) -> list[Gains]:
    """Of each driven coordinate of a joint: its stiffness as given, else what moves and holds the whole linkage.

    Damping is critical for the inertia that the drive has to move in the reference configuration.
    """
    linkage, size = placed.linkage, placed.size
    pair, out = linkage.joints[joint], []
    moved, held = _moved_and_held(linkage, joint)
    for k, coordinate in enumerate(linkage.drives[joint]):
        unit = 1.0 if coordinate[0] == "r" else size
        inertia = moved[k] or sum(own.mass for own in placed.masses.values()) * (size / unit) ** 2 / 10.0
        given = float(np.max(pair.full_stiffness[..., COMPONENTS.index(coordinate)]))
        needed = max(inertia * FREQUENCY**2, held[k] / (DEFLECTION * unit))
        stiffness = given if pair.stiffness is not None and 0.0 < given < np.inf else needed
        out.append(Gains(stiffness, 2.0 * float(np.sqrt(stiffness * inertia))))
    return out


def _moved_and_held(linkage: LinkageDescription, joint: str) -> tuple[list[float], list[float]]:
    """Inertia that each driven coordinate moves in the reference configuration, and force with which it holds it.

    The inertia is twice the kinetic energy at a rate of one. Zero where nothing tells.
    """
    count = len(linkage.drives[joint])
    rates = np.ones(1) if count == 1 else np.eye(count)
    try:
        inertia = 2.0 * LoadedMotion.of(linkage, {}, {joint: rates}, {}).kinetic_energy()
        force = np.abs(LoadedMotion.of(linkage, {}, {}, {}).reactions().drive(joint))
    except FrameError:
        return [0.0] * count, [0.0] * count
    return np.nan_to_num(inertia).tolist(), np.nan_to_num(force).tolist()
