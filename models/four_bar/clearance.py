"""Displacement of the coupler point by joint clearance, with the loop closed again exactly."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from ..planar import Complex, dyad, vector
from .kinematics import FourBarKinematics

Array = NDArray[np.float64]


def clearance_displacement(motion: FourBarKinematics, offsets: Mapping[str, Complex]) -> Array:
    """Displacement of P when the pin centres of the joints part by given offsets, the links being rigid.

    Offsets are those of the later link's centre relative to the earlier one's, along crank, coupler, rocker and
    ground. The crank is locked, so that coupler and rocker close the dyad between B + δ_B and E − δ_E − δ_D, on the
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
    rotated = dyad(chord, loop.coupler, loop.rocker, side) - loop.coupler_vector
    arm = (np.asarray(x) + 1j * np.asarray(y)) / loop.coupler
    return vector(offsets["B"] + arm * rotated)


def clearance_map(motion: FourBarKinematics) -> dict[str, Array]:
    """Displacement of P by a unit offset in each joint, to first order, the links being rigid.

    With the crank locked, an offset δ moves the pin D of the coupler by ``δ_B + i φ (D − B)``, and the rocker lets it
    leave its circle about E by what the offsets in D and E make up for: ``(δ_B + δ_D + δ_E + i φ (D − B)) · (D − E)``
    is zero, which gives the rotation φ of the coupler.

    Parameters
    ----------
    motion
        Motion of the four-bar, (...).

    Returns
    -------
    dict of ndarray
        By joint ``"B"``, ``"D"``, ``"E"``: u_x, u_y of P by δ_x, δ_y, (..., 2, 2); not finite at singular poses.
    """
    loop = motion.closure
    x, y = motion.four_bar.point
    rocker = loop.coupler_vector - loop.diagonal
    arm = (np.asarray(x) + 1j * np.asarray(y)) / loop.coupler * loop.coupler_vector
    with np.errstate(divide="ignore", invalid="ignore"):
        turn = vector(rocker)[..., :2] / (1j * loop.coupler_vector * np.conj(rocker)).real[..., None]
        rotated = np.swapaxes(vector(-1j * turn * arm[..., None])[..., :2], -1, -2)
    return {"B": np.eye(2) + rotated, "D": rotated, "E": rotated}
