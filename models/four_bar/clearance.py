"""Where the coupler point goes when joints have clearance: the loop closed again, exactly."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from ..planar import Complex, dyad, vector
from .motion import FourBarMotion

Array = NDArray[np.float64]


def clearance_displacement(motion: FourBarMotion, offsets: Mapping[str, Complex]) -> Array:
    """Displacement of P when the pin centres of the joints part by given offsets, the links being rigid.

    Offsets are those of the later link's centre relative to the earlier one's, along crank, coupler, rocker and
    ground. The crank is held, so that coupler and rocker close the dyad between B + δ_B and E − δ_E − δ_D, on the
    side of the diagonal on which they were.

    Parameters
    ----------
    motion
        Motion of the four-bar, (...).
    offsets
        δ_x + i δ_y of the joints ``"B"``, ``"D"``, ``"E"``, (...).

    Returns
    -------
    ndarray
        Displacement, (..., 3); NaN where the offset loop does not close, or the pose is singular.
    """
    loop = motion.closure
    x, y = motion.four_bar.point
    chord = loop.diagonal - (offsets["B"] + offsets["D"] + offsets["E"])
    side = np.where(loop.singular, np.nan, np.sign(loop.area))
    turned = dyad(chord, loop.coupler, loop.rocker, side) - loop.coupler_vector
    arm = (np.asarray(x) + 1j * np.asarray(y)) / loop.coupler
    return vector(offsets["B"] + arm * turned)
