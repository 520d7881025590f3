"""A motion beside what was measured of it."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from ...framework.batch import Array
from ...framework.errors import FrameError
from ..measured.calibration import Calibration, calibrate, checked_start
from ..measured.comparison import Comparison, compare
from ..measured.table import Measured
from .derivatives.built import along_inputs
from .derivatives.position_sensitivity import position_sensitivity
from .poses.kinematics import Kinematics
from .zone import Build, built, check_build, driven_values

# Differences of the description, by which it depends on the dimensions, are taken over this share of their size.
STEP = 1e-5


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
    start = checked_start(start)
    check_build(build, start)
    drives = {name: driven_values(motion, name) for name in motion.linkage.drives}

    def predict(**dimensions: Array) -> Array:
        columns = {name: values[:, None] for name, values in dimensions.items()}
        return built(build, columns).move(drives).position(point)

    steps = {name: STEP * abs(float((scales or {}).get(name, value))) for name, value in start.items()}

    def gradient(**dimensions: float) -> dict[str, Array]:
        rows = {name: np.full(len(measured.position), value) for name, value in dimensions.items()}
        ends = {name: (values - steps[name], values + steps[name]) for name, values in rows.items()}
        by = position_sensitivity(built(build, rows).move(drives), point)
        weights = np.broadcast_to(np.eye(3)[:, None], (3, len(measured.position), 3))
        each = [along_inputs(by, weight, build, rows, ends) for weight in weights]
        return {name: np.stack([slopes[name] for slopes in each], axis=-1) for name in rows}

    return calibrate(
        predict, start, measured.position, uncertainty=measured.uncertainty, scales=scales, gradient=gradient
    )


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
