"""Clearance of a revolute joint: the journal touches the bearing, with its centre displaced by the clearance."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .planar import Complex

Array = NDArray[np.float64]

# A force below this share of the largest in the linkage counts as zero.
UNLOADED = 1e-12


def offset(clearance: Array, contact: Array) -> Complex:
    """Displacement of the second link's pin centre relative to that of the first, Eq. (11) of the accuracy paper.

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
    """Offset of a joint that transmits a force: journal and bearing are in contact along it.

    `force` is exerted by the joint on its first link. If the second link carries the journal, the journal moves along
    `force` until it presses against the bearing; if the first link carries it, the bearing moves in the same direction
    until it presses against the journal. The offset is the same. Without a force the joint is centred.

    Parameters
    ----------
    clearance
        Radial clearance ε, (...), length.
    force
        Force F_x + i F_y on the first link, (...).
    largest
        Largest force in the linkage, (...); a force much smaller than this counts as zero.

    Returns
    -------
    ndarray
        Offset ε F/|F|, (...), length; 0 where F is 0 to rounding or not finite, as at a singular pose.
    """
    size = np.abs(force)
    loaded = size > UNLOADED * largest
    return np.asarray(np.where(loaded, clearance * (force / np.where(loaded, size, 1.0)), 0.0))
