"""Compute all numbers that the job's tables, figures and report show."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ...elements import Beam
from ...framework.errors import FrameError, expected_mechanisms
from ..four_bar.four_bar import FourBarMotion
from ..four_bar.kinetostatics import Kinetostatics, Link
from ..four_bar.study import Study
from ..job.measured import MEASURED_WAY, MeasuredOutcome
from ..job.memory import check
from ..job.outcome import LARGE_WAY, LINEAR_WAY, SPECTRA, LargeSpread, Outcome, magnification
from ..job.parts import Parts
from ..job.sharing import ALONE, SampleKind, Sharing
from ..job.stages import Advance
from ..spread import Spread
from .inputs import Inputs
from .study import beside_measured, check_reach, four_bar, large_parts, large_samples, study_at_measured_poses, study_of

if TYPE_CHECKING:
    from ...framework.solution import Solution

Array = NDArray[np.float64]

EPS = float(np.finfo(np.float64).eps)
# Rounding error of a position by the closed form, in units of the machine epsilon times the sum of the lengths.
CLOSED_FORM = 8.0
USUAL_POSE = 30.0
DRAWN_SPREAD = 0.12
# Memory of a sample for its inputs, and at each pose for results, statistics and figures, bytes.
BYTES_ALONE, BYTES = 8 * 40, 8 * 50


@dataclass(frozen=True, eq=False)
class Result(Outcome):
    """Outcome of the accuracy job; made by `compute`. Poses that are singular or cannot be assembled have NaN.

    `Outcome` describes its attributes.

    Attributes
    ----------
    inputs
        Inputs of the job.
    study
        The samples and their statistics, at the poses that can be assembled.
    """

    inputs: Inputs
    study: Study

    heading, point, axes = "θ", "P", (0, 1)
    singular_place = "the line of coupler and rocker"
    unknowns = 48  # displacements of the frame's eight nodes

    @property
    def degrees(self) -> Array:
        """Drive angles, degrees, (poses,)."""
        return self.inputs.degrees

    @property
    def drives(self) -> list[str]:
        """Drive angles in words, (poses,)."""
        return [f"{angle:g}°" for angle in self.degrees]

    @property
    def count(self) -> int:
        return self.inputs.samples

    @property
    def nan_policy(self) -> str:
        return self.inputs.nan_policy

    @property
    def place_error(self) -> float:
        inputs = self.inputs
        return CLOSED_FORM * EPS * (inputs.crank + inputs.ground + inputs.coupler + inputs.rocker)

    @property
    def motion(self) -> FourBarMotion:
        """Motion of the nominal linkage at the poses that can be assembled, (assembled,)."""
        return self.study.nominal.motion

    @cached_property
    def assembled(self) -> NDArray[np.bool_]:
        return self.motion.four_bar.assembles(self.inputs.theta)

    @property
    def singular(self) -> NDArray[np.bool_]:
        """Poses at which coupler and rocker are in line, (poses,)."""
        return np.asarray(self._everywhere(self.motion.singular, False))

    @property
    def entry(self) -> int:
        """Index of the pose of the histograms among those that can be assembled."""
        return int(np.count_nonzero(self.assembled[: self.pose]))

    def _everywhere(self, values: NDArray[Any], nothing: object = np.nan) -> NDArray[Any]:
        """Values (assembled, ...) of the poses that can be assembled, put at all poses, (poses, ...)."""
        if self.assembled.all():
            return values
        out = np.full((self.degrees.size, *values.shape[1:]), nothing, dtype=values.dtype)
        out[self.assembled] = values
        return out

    @property
    def beam(self) -> Beam:
        """Beam of every link."""
        return self.motion.four_bar.link_beam("crank")

    @property
    def status(self) -> NDArray[np.str_]:
        """``"regular"``, or why a pose has no statistics, (poses,)."""
        gaps = self.motion.four_bar.gap(self.inputs.theta)
        lost = [f"not assembled: gap {gap:.3g}" for gap in gaps]
        found = np.where(self.assembled, self._everywhere(self.study.status.astype(object), ""), lost)
        return found.astype(np.str_)

    @property
    def regular(self) -> NDArray[np.bool_]:
        """Poses that have statistics, (poses,)."""
        return np.asarray(self.status == "regular")

    @property
    def nonlinearity(self) -> Array:
        """Estimated relative error of linear mechanics for the compliance under the mean load, (poses,)."""
        return self._everywhere(self.study.nominal.nonlinearity)

    @cached_property
    def error_bound(self) -> Array:
        """Bound on the numerical error over all samples at a pose, (poses, 3); NaN where there are none."""
        out = np.full((self.study.kept.size, 3), np.nan)
        out[self.study.kept] = self.study.parts["error_bound"].max(axis=1)
        return self._everywhere(out)

    @property
    def rigid(self) -> Array:
        return self._everywhere(self.study.rigid)

    @property
    def path(self) -> Array:
        """Rigid position of P at closely spaced poses, (steps, 3); NaN where the linkage cannot be assembled."""
        theta = self.inputs.theta
        fine = np.linspace(theta[0], theta[-1], 721)
        closes = self.motion.four_bar.assembles(fine)
        path = np.full((fine.size, 3), np.nan)
        path[closes] = self.motion.four_bar.move(fine[closes]).position("P")
        return path

    @cached_property
    def large(self) -> LargeSpread:
        found = large_samples(self.study, *self.large_parts)
        samples, passed = self._everywhere(found.samples), self._everywhere(found.passed, False)
        return LargeSpread(samples, found.nan_policy, passed=passed)

    @property
    def closes(self) -> NDArray[np.bool_]:
        return np.asarray(self._everywhere(self.large_parts[1], False))

    @cached_property
    def large_mean_inputs(self) -> Array:
        """Displacement of P under the mean load at large displacement, without clearance, (poses, 3).

        NaN where coupler and rocker are not in line: there the linear displacement is valid.
        """
        found = np.full((self.degrees.size, 3), np.nan)
        if self.singular.any():
            frame = self.motion.four_bar.move(self.inputs.theta[self.singular]).frame()
            frame.load("P", fy=self.inputs.load)
            found[self.singular] = frame.solve(large=True).displacement("P")[..., :3]
        return found

    @cached_property
    def reactions(self) -> Kinetostatics:
        """Joint forces and drive torque of the rigid linkage at rest under the mean load, (assembled,)."""
        return self.motion.reactions(coupler=Link(force=(0.0, self.inputs.load), at=self.inputs.point))

    @cached_property
    def forces(self) -> Array:
        """``Ax Ay Bx By Dx Dy Ex Ey`` and the drive torque of `reactions`, (poses, 9)."""
        return self._everywhere(self.reactions.unknowns)

    @cached_property
    def large_parts(self) -> tuple[Parts, NDArray[np.bool_]]:
        """Results at large displacement, computed some samples at a time, and the poses at which they are."""
        return large_parts(self.study)

    def kinds(self, *, large: bool) -> dict[str, SampleKind]:
        """Results that depend on samples, by kind: linear, large displacement, at measured poses."""
        linear = ("rigid", "compliance", "clearance", "clearance_exact")
        if not large:
            return {"linear": SampleKind(LINEAR_WAY, self.study.parts, linear)}
        found = {
            "linear": SampleKind(LINEAR_WAY, self.study.parts, (*linear, "error_bound")),
            "large": SampleKind(LARGE_WAY, self.large_parts[0], ("rigid", "large", "large_passes")),
        }
        if self.at_measured_poses is not None:
            found["measured"] = SampleKind(MEASURED_WAY, self.at_measured_poses.parts, linear)
        return found

    @cached_property
    def at_measured_poses(self) -> Study | None:
        """The samples at the measured poses that can be assembled; None without measurements."""
        return study_at_measured_poses(self.inputs, self.motion.four_bar)

    @cached_property
    def measured(self) -> MeasuredOutcome | None:
        """Measured positions of P compared with predicted ones; None without measurements."""
        return None if self.at_measured_poses is None else beside_measured(self.inputs, self.at_measured_poses)

    @cached_property
    def spread(self) -> Spread:
        """Displacement of P from its rigid position, (poses, samples, 3)."""
        whole = self.study.total
        return whole if self.assembled.all() else Spread(self._everywhere(whole.samples), whole.nan_policy)

    @property
    def draws(self) -> Mapping[str, Array]:
        """Samples of the inputs, (samples,) each."""
        return self.study.inputs

    @property
    def has_kappa(self) -> bool:
        """Whether the paper's matrix exists, which needs joints with a finite stiffness."""
        return bool(np.isfinite(self.inputs.stiffness))

    @property
    def kappa(self) -> Array:
        """Condition number as the paper assembles the stiffness matrix, at the mean inputs, (poses,)."""
        return self._everywhere(self.study.kappa) if self.has_kappa else np.full_like(self.degrees, np.nan)

    @cached_property
    def planar_kappa(self) -> Array:
        if not self.has_kappa:
            return np.full_like(self.degrees, np.nan)
        return self._everywhere(self.study.nominal.planar_condition_number())

    @property
    def kappa_scaled(self) -> Array:
        return self._everywhere(self.study.kappa_scaled)

    @cached_property
    def sampled_kappa(self) -> tuple[Array, Array]:
        if not self.has_kappa:
            return np.full((1, 1), np.nan), np.full((1, 1), np.nan)
        some = self.study.some(slice(SPECTRA))
        return some.condition_number(), some.planar_condition_number()

    @cached_property
    def compliance(self) -> Array:
        """Displacement of P under the mean load, without clearance, (poses, 3)."""
        return self._everywhere(self.study.nominal.compliance)

    @cached_property
    def solution(self) -> Solution:
        """Solution of the frame at the mean inputs under the mean load, without clearance, (assembled,)."""
        frame = self.motion.frame()
        frame.load("P", fy=self.inputs.load)
        return frame.solve()

    @cached_property
    def pose(self) -> int:
        """Number of the pose of the histograms."""
        wanted, chosen = self.inputs.histogram_pose, self._nearest(self.regular)
        if not self.regular.any():
            raise FrameError(
                f"no pose has a result for every sample (at {self.degrees[0]:g}°: {self.status[0]}): give other poses, "
                "or smaller clearances and deviations"
            )
        if not self.regular[chosen]:
            raise FrameError(f"--histogram-pose {wanted:g} has no samples, it is {self.status[chosen]}: take another")
        return chosen

    @property
    def expected_pose(self) -> int:
        """`pose` if every sample has a result where the mean inputs have one; known without the samples."""
        return self._nearest(self.assembled & ~self.singular)

    def _nearest(self, regular: NDArray[np.bool_]) -> int:
        """Number of the given pose, or of the regular one nearest to the usual one."""
        wanted = self.inputs.histogram_pose
        distance = np.abs(self.degrees - (USUAL_POSE if wanted is None else wanted))
        return int(np.argmin(np.where(regular, distance, np.inf) if wanted is None else distance))

    @cached_property
    def magnify(self) -> float:
        """Factor on drawn displacements, by default 1, 2 or 5 times a power of ten that makes the spread visible."""
        if self.inputs.magnify is not None:
            return self.inputs.magnify
        longest = max(self.inputs.crank, self.inputs.rocker)
        return magnification(np.abs(self.samples), DRAWN_SPREAD * longest)


def compute(inputs: Inputs, advance: Advance | None = None, *, large: bool = True, shared: Sharing = ALONE) -> Result:
    """Compute the accuracy job.

    Parameters
    ----------
    inputs
        Inputs of the job.
    advance
        Called with the name of a part of `work(inputs)`, and the number of poses times samples that were done.
    large
        Whether large displacement, error bounds and condition numbers are computed now, or when they are read.
    shared
        Workers that compute the samples, and the folder where these are kept.

    Returns
    -------
    Result
        All numbers of the job.

    Raises
    ------
    FrameError
        If the linkage cannot be assembled at any pose, a sample is out of range, the samples do not fit the memory, or
        the pose of the histograms is not among the regular ones.
    """
    return finish(begin(inputs), advance, large=large, shared=shared)


def begin(inputs: Inputs) -> Result:
    """The result before samples are computed; see `compute`."""
    poses = inputs.degrees.size + (0 if inputs.measured_drive is None else inputs.measured_drive.values.size)
    check(BYTES_ALONE + BYTES * poses, inputs.samples, "--samples")
    linkage = four_bar(inputs)
    check_reach(linkage, inputs)
    with expected_mechanisms():
        return Result(inputs, study_of(inputs, linkage, inputs.theta[linkage.assembles(inputs.theta)]))


def finish(result: Result, advance: Advance | None = None, *, large: bool = True, shared: Sharing = ALONE) -> Result:
    """Compute all numbers of a result; see `compute`."""
    with expected_mechanisms():
        shared.compute(result.kinds(large=large), advance or (lambda *_: None))
        _ = result.pose, result.std, result.compliance
        if large:
            _ = result.kappa, result.kappa_scaled, result.large.std, result.measured
    return result
