"""A motion beside what was measured of it."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from ...framework.batch import Array
from ...framework.errors import FrameError
from ..measured.calibration import Calibration, calibrate
from ..measured.comparison import Comparison, compare
from ..measured.table import Measured
from .poses.kinematics import Kinematics
from .zone import Build, driven_values


def comparison_of(motion: Kinematics, point: str, measured: Measured, deviation: ArrayLike, level: float) -> Comparison:
    """Measured positions of a point beside those of a motion; see `Motion.compare`."""
    _check(motion, measured)
    return compare(motion.position(point), measured, deviation=deviation, level=level)


def calibration_of(
    motion: Kinematics,
    point: str,
    measured: Measured,
    build: Build,
    start: Mapping[str, float],
    scales: Mapping[str, float] | None,
) -> Calibration:
    """Dimensions with which a point goes where it was measured; see `Motion.calibrate`."""
    _check(motion, measured)
    drives = {name: driven_values(motion, name) for name in motion.linkage.drives}

    def predict(**dimensions: Array) -> Array:
        columns = {name: values[:, None] for name, values in dimensions.items()}
        return build(**columns).move(drives).position(point)

    return calibrate(predict, start, measured.position, uncertainty=measured.uncertainty, scales=scales)


def _check(motion: Kinematics, measured: Measured) -> None:
    """Refuse a motion at other poses than those that were measured."""
    if motion.shape != measured.position.shape[:1]:
        raise FrameError(
            f"the motion has shape {motion.shape} and {len(measured.position)} poses were measured: move the linkage "
            "to the drives of the measurement"
        )
    for name, values in measured.drives.items():
        if name not in motion.linkage.drives:
            driven = ", ".join(motion.linkage.drives) or "none"
            raise FrameError(f"the table has a column {name!r}, which is no drive of the linkage (driven: {driven})")
        there = driven_values(motion, name)
        if there.ndim == 1 and not np.allclose(there, values, rtol=1e-9, atol=1e-9):
            raise FrameError(f"drive {name!r} of the motion is not at the values of the measurement: move it there")
