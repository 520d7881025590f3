"""The samples at the poses at which P was measured, and what was measured beside them."""

from __future__ import annotations

import numpy as np

from ...framework.errors import FrameError
from ..four_bar.four_bar import FourBar
from ..four_bar.study import Study
from ..job.measured import MeasuredOutcome
from .inputs import DRIVE, Inputs
from .study import study_of


def study_at_measured_poses(inputs: Inputs, linkage: FourBar) -> Study | None:
    """The samples at the measured poses that can be assembled; None where nothing was measured."""
    drive = inputs.measured_drive
    if inputs.measured is None or drive is None:
        return None
    theta = np.radians(drive.values)
    closes = linkage.assembles(theta)
    if not closes.any():
        gap = linkage.gap(theta).min()
        raise FrameError(
            f"{inputs.measured.name}: the linkage cannot be assembled at any measured pose, coupler and rocker "
            f"leave a gap of {gap:.3g} m or more: check the drive angles, column '{DRIVE} [deg]'"
        )
    try:
        return study_of(inputs, linkage, theta[closes])
    except FrameError as error:
        raise FrameError(f"{inputs.measured.name}: {error}") from error


def beside_measured(inputs: Inputs, study: Study) -> MeasuredOutcome | None:
    """Measured positions of P beside those of a study at their poses; None where there are none."""
    given, drive = inputs.measured_point, inputs.measured_drive
    if given is None or drive is None:
        return None
    closes = study.nominal.motion.four_bar.assembles(np.radians(drive.values))
    place, covariance = np.full((len(closes), 3), np.nan), np.full((len(closes), 3, 3), np.nan)
    place[closes], covariance[closes] = study.rigid + study.mean, study.covariance
    try:
        return MeasuredOutcome.of(given, {DRIVE: drive}, place, covariance)
    except FrameError as error:
        raise FrameError(f"{given.file.name}: {error}") from error
