"""The first point of a file's linkage, as the tables that any job has show it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ....framework.batch import Array
from ...job.outcome import SPECTRA, LargeSpread, Mask, Outcome, taken
from ...job.parts import Parts
from ...spread import Spread
from .computed import Computed
from .sampled import conditions, few_samples, large_parts


@dataclass(frozen=True, eq=False)
class PointOutcome(Outcome):
    """The first point to report.

    Attributes
    ----------
    result
        What the job computed.
    """

    result: Computed

    @property
    def drives(self) -> list[str]:
        """Values of the first drive in words."""
        return [self.result.where(pose).partition(" = ")[2] for pose in range(self.result.poses)]

    @property
    def heading(self) -> str:
        """The first drive."""
        return next(iter(self.result.inputs.drives))

    @property
    def point(self) -> str:
        """Name of the first point."""
        return self.result.inputs.points[0]

    @property
    def singular_place(self) -> str:
        """Any singular configuration."""
        return "a singular configuration"

    @property
    def axes(self) -> tuple[int, ...]:
        """Components that are shown."""
        return self.result.shown

    @property
    def count(self) -> int:
        """Number of samples; 1 without tolerances."""
        return self.result.inputs.samples if self.result.inputs.tolerances else 1

    @property
    def nan_policy(self) -> str:
        """What is done with samples without a result."""
        return self.result.inputs.nan_policy

    @cached_property
    def _shape(self) -> tuple[int, int]:
        return self.result.poses, 3

    def _whole(self, values: Array) -> Array:
        """Values (poses, 3 or more), which may not vary with the pose, as (poses, 3)."""
        return np.array(np.broadcast_to(values[..., :3], self._shape))

    @property
    def assembled(self) -> Mask:
        """Poses that can be assembled."""
        return np.broadcast_to(self.result.motion.is_assembled, self._shape[:1])

    @cached_property
    def regular(self) -> Mask:
        """Poses at which motion and frame are regular, and the samples have statistics."""
        frame = np.broadcast_to(self.result.main.status == "regular", self._shape[:1])
        known = np.isfinite(self.mean).all(axis=-1)
        return np.asarray(frame & known & np.broadcast_to(self.result.motion.is_regular, self._shape[:1]))

    @property
    def status(self) -> NDArray[np.str_]:
        """Why a pose has no result, or ``"regular"``."""
        return np.where(self.regular, "regular", self.result.reported_status)

    @property
    def nonlinearity(self) -> Array:
        """Estimated relative error of the nominal displacement by its being linear."""
        return np.broadcast_to(self.result.solution.nonlinearity(), self._shape[:1])

    @property
    def rigid(self) -> Array:
        """Position with rigid links and no clearance."""
        return self._whole(self.result.main.rigid)

    @property
    def compliance(self) -> Array:
        """Nominal displacement without clearance."""
        return self._whole(self.result.main.compliance)

    @cached_property
    def spread(self) -> Spread:
        """Displacement of the samples, or of the nominal linkage as one, (poses, samples, 3)."""
        return self.result.spread.get(self.point) or Spread(self._whole(self.result.main.total)[:, None])

    @property
    def error_bound(self) -> Array:
        """Bound on the numerical error of every sample; NaN where contacts are found in equilibrium."""
        return self.result.error_bound

    @property
    def place_error(self) -> float:
        """None is known of a position that was iterated."""
        return np.nan

    @property
    def kappa(self) -> Array:
        """Condition number as usually assembled; NaN where a joint is ideal in some directions, or nodes are tied."""
        return self._conditions[0]

    @property
    def planar_kappa(self) -> Array:
        """The same of the plane in which the linkage moves; NaN for motion in space as well."""
        return self._conditions[1]

    @cached_property
    def _conditions(self) -> tuple[Array, Array]:
        return conditions(self.result.main, self._shape[:1])

    @cached_property
    def sampled_kappa(self) -> tuple[Array, Array]:
        """Condition numbers of the first samples, whole and in the plane, (poses, some)."""
        return few_samples(self.result.inputs, self.result.nominal, SPECTRA).condition_numbers()

    @cached_property
    def kappa_scaled(self) -> Array:
        """Scaled condition number of the matrix that is solved."""
        return np.broadcast_to(self.result.main.scaled_condition_number(), self._shape[:1])

    @property
    def unknowns(self) -> int:
        """Displacements of the frame's nodes."""
        return 6 * len(self.result.solution.frame.nodes)

    @cached_property
    def closes(self) -> Mask:
        """Poses at which all samples that are taken to large displacement can be assembled."""
        return np.asarray(np.isfinite(self._large[1]).all(axis=(1, 2)))

    @cached_property
    def large(self) -> LargeSpread:
        """Displacement from the nominal position at large displacement, (poses, m, 3)."""
        moved, places = self._large
        passed, policy = self.large_parts["large_passes"][0], self.nan_policy.replace("raise", "propagate")
        return LargeSpread(moved + places - self.rigid[:, None], policy, passed=passed)

    @cached_property
    def _large(self) -> tuple[Array, Array]:
        """Displacements at large displacement and rigid positions of the first samples, (poses, m, 3) each."""
        return self.large_parts["large"][0], self.large_parts["rigid"][0]

    @cached_property
    def large_parts(self) -> Parts:
        """Results at large displacement, some samples at a time."""
        return large_parts(self.result.inputs, self.result.nominal, taken(self.count))
