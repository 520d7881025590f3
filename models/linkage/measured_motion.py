"""Comparison of a motion with measurements, and calibration of its dimensions."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ...framework.batch import Array
from ...framework.errors import FrameError
from ..measured.calibration import Calibration, calibrate, checked_scales, checked_start
from ..measured.comparison import Comparison, compare
from ..measured.table import Measured
from .derivatives.built import along_inputs
from .derivatives.position_sensitivity import position_sensitivity
from .poses.kinematics import Kinematics
from .uncertain_motion import UncertainMotion
from .zone import Build, built, check_build, driven_values

# Step of the differences of the description by the dimensions, as a share of their size.
STEP = 1e-5


@dataclass(frozen=True, eq=False, repr=False)
class MeasuredMotion(UncertainMotion):
    """A motion that can be compared with measurements; see `Motion`."""

    def compare(
        self,
        point: str,
        measured: Measured,
        *,
        deviation: ArrayLike = 0.0,
        covariance: ArrayLike | None = None,
        level: float = 0.95,
    ) -> Comparison:
        """Compare the positions of a point with measured ones.

        Parameters
        ----------
        point
            Name of the point.
        measured
            Its measured positions at the poses of this motion, with their uncertainty; see `read_measured`.
        deviation
            Standard deviation of the prediction, such as that by tolerances, a length, (poses, 3) or broadcast to it.
        covariance
            Covariance of the prediction instead of it, (poses, 3, 3) or (poses, 3, poses, 3); see `compare`.
        level
            Probability with which a pose should lie within its band.

        Returns
        -------
        Comparison
            Residuals, their sum of squares, and the poses outside the band.

        Raises
        ------
        FrameError
            If the motion is at other poses than the measurement, or neither has an uncertainty.
        """
        _check(self, measured)
        return compare(self.position(point), measured, deviation=deviation, covariance=covariance, level=level)

    def calibrate(
        self,
        point: str,
        measured: Measured,
        build: Build,
        start: Mapping[str, float],
        *,
        scales: Mapping[str, float] | None = None,
    ) -> Calibration:
        """Find the dimensions with which the positions of a point fit measured ones best.

        Parameters
        ----------
        point
            Name of the point.
        measured
            Its measured positions at the poses of this motion.
        build
            Function of dimensions by name, (m, 1) or (m,) each, as keywords, which returns the linkage with them.
            Derivatives are those of `sensitivity`, so that each step of the search takes two motions, however many
            dimensions there are.
        start
            Initial dimensions by name: those of this motion.
        scales
            Typical changes of the dimensions; see `calibrate`.

        Returns
        -------
        Calibration
            Dimensions with their covariance, and the combinations of them that the data do not determine.

        Raises
        ------
        FrameError
            If the motion is at other poses than the measurement, or as for `calibrate`.

        Examples
        --------
        The length of a crank, from two measured positions of its end.

        >>> import numpy as np
        >>> from linkframe.models import Linkage, Measured
        >>> def crank(length):
        ...     places = np.stack(np.broadcast_arrays(length, 0.0, 0.0), axis=-1)
        ...     linkage = Linkage(A=(0, 0), P=places)
        ...     linkage.link("crank", "A", "P")
        ...     linkage.revolute("A", "ground", "crank", drive=True)
        ...     return linkage
        >>> seen = Measured([[0.2001, 0.0, np.nan], [0.0, 0.2003, np.nan]], 1e-4, {"A": np.radians([0.0, 90.0])})
        >>> found = crank(0.2).move(seen.drives).calibrate("P", seen, crank, {"length": 0.2})
        >>> round(found.values["length"], 9)
        0.2002
        """
        _check(self, measured)
        start = checked_start(start)
        check_build(build, start)
        drives = {name: driven_values(self, name) for name in self.linkage.drives}

        def predict(**dimensions: Array) -> Array:
            columns = {name: values[:, None] for name, values in dimensions.items()}
            return built(build, columns).move(drives).position(point)

        sizes, own = checked_scales(scales, start), scales or {}

        def gradient(**dimensions: float) -> dict[str, Array]:
            rows = {name: np.full(len(measured.position), value) for name, value in dimensions.items()}
            steps = {
                name: STEP * (sizes[name] if name in own else max(sizes[name], abs(value)))
                for name, value in dimensions.items()
            }
            ends = {name: (values - steps[name], values + steps[name]) for name, values in rows.items()}
            by = position_sensitivity(built(build, rows).move(drives), point)
            weights = np.broadcast_to(np.eye(3)[:, None], (3, len(measured.position), 3))
            each = [along_inputs(by, weight, build, rows, ends) for weight in weights]
            return {name: np.stack([slopes[name] for slopes in each], axis=-1) for name in rows}

        return calibrate(
            predict, start, measured.position, uncertainty=measured.uncertainty, scales=scales, gradient=gradient
        )


def _check(motion: Kinematics, measured: Measured) -> None:
    """Refuse a motion whose poses are not the measured ones."""
    if motion.shape != measured.position.shape[:1]:
        raise FrameError(
            f"the motion has shape {motion.shape} and {len(measured.position)} poses were measured: move the linkage "
            "to the drives of the measurement"
        )
    for name, values in measured.drives.items():
        if name not in motion.linkage.drives:
            driven = ", ".join(motion.linkage.drives) or "none"
            raise FrameError(f"the table has a column {name!r}, which is no drive of the linkage (driven: {driven})")
        unit = measured.units.get(name)
        if unit and not any(coordinate.startswith("r") for coordinate in motion.linkage.drives[name]):
            raise FrameError(
                f"the table has a column '{name} [{unit}]', and that drive is a length: leave the unit out"
            )
        there = driven_values(motion, name)
        known = ~np.isnan(there)  # poses that are not assembled have no coordinates
        if there.ndim == 1 and not np.allclose(there[known], np.asarray(values)[known], rtol=1e-9, atol=1e-9):
            raise FrameError(f"drive {name!r} of the motion is not at the values of the measurement: move it there")
