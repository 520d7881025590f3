"""Clearance of a revolute joint: the journal rests against the bearing, off its centre by the clearance."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .planar import Complex

Array = NDArray[np.float64]

# A force below this share of the largest in the linkage is the rounding of none.
UNLOADED = 1e-12


def offset(clearance: Array, contact: Array) -> Complex:
    """Displacement of the second link's pin centre relative to the first's, Eq. (11) of the accuracy paper.

        ε_x = ε cos γ,  ε_y = ε sin γ,   ε = R_bearing − R_journal

    Parameters
    ----------
    clearance
        Radial clearance ε, (...), length.
    contact
        Contact angle γ from global x, (...), radians.

    Returns
    -------
    ndarray
        ε_x + i ε_y, (...).
    """
    return np.asarray(clearance * np.cos(contact) + 1j * (clearance * np.sin(contact)))


def pressed(clearance: Array, force: Complex, largest: Array) -> Complex:
    """Offset of a joint that transmits a force: the journal lies against the bearing along it.

    `force` is what the joint exerts on its first link. If the second link carries the journal, the journal moves
    along `force` until it presses the bearing that way; if the first carries it, the bearing moves that way and
    presses the journal: the offset is the same. A joint without force stays centred, as nothing brings it into contact.

    Parameters
    ----------
    clearance
        Radial clearance ε, (...), length.
    force
        F_x + i F_y on the first link, (...).
    largest
        Largest force in the linkage, (...), by which rounding is told from force.

    Returns
    -------
    ndarray
        ε F/|F|, (...); 0 where F is 0 to rounding, or not finite, as at a singular pose.
    """
    size = np.abs(force)
    loaded = size > UNLOADED * largest
    return np.asarray(np.where(loaded, clearance * (force / np.where(loaded, size, 1.0)), 0.0))
