"""The first point of a file's linkage, for the tables that all jobs share."""

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
    """Outcome of the first point to report; `Outcome` describes the attributes.

    Attributes
    ----------
    result
        Numbers of the job.
    """

    result: Computed

    singular_place = "a singular configuration"
    place_error = np.nan  # not known for positions found by iteration

    @property
    def drives(self) -> list[str]:
        """Values of the first drive with their unit, as texts."""
        return [self.result.where(pose).partition(" = ")[2] for pose in range(self.result.poses)]

    @property
    def heading(self) -> str:
        """Name of the first drive."""
        return next(iter(self.result.inputs.drives))

    @property
    def point(self) -> str:
        return self.result.inputs.points[0]

    @property
    def axes(self) -> tuple[int, ...]:
        return self.result.shown

    @property
    def count(self) -> int:
        """Number of samples; 1 without tolerances."""
        return self.result.inputs.samples if self.result.inputs.tolerances else 1

    @property
    def nan_policy(self) -> str:
        return self.result.inputs.nan_policy

    def _whole(self, values: Array) -> Array:
        """Values (..., 3 or more) broadcast to all poses, (poses, 3)."""
        return np.array(self.result.rows(values[..., :3]))

    @property
    def assembled(self) -> Mask:
        return np.broadcast_to(self.result.motion.is_assembled, (self.result.poses,))

    @cached_property
    def regular(self) -> Mask:
        """Poses at which motion and frame are regular, and the samples have statistics."""
        frame = np.broadcast_to(self.result.main.status == "regular", (self.result.poses,))
        known = np.isfinite(self.mean).all(axis=-1)
        return np.asarray(frame & known & np.broadcast_to(self.result.motion.is_regular, (self.result.poses,)))

    @property
    def status(self) -> NDArray[np.str_]:
        return np.where(self.regular, "regular", self.result.reported_status)

    @property
    def nonlinearity(self) -> Array:
        return np.broadcast_to(self.result.solution.nonlinearity(), (self.result.poses,))

    @property
    def rigid(self) -> Array:
        return self._whole(self.result.main.rigid)

    @property
    def compliance(self) -> Array:
        return self._whole(self.result.main.compliance)

    @cached_property
    def spread(self) -> Spread:
        """Displacement of the samples, or of the nominal linkage as one, (poses, samples, 3)."""
        return self.result.spread.get(self.point) or Spread(self._whole(self.result.main.total)[:, None])

    @property
    def error_bound(self) -> Array:
        """Bound on the numerical error over all samples, (poses, 3); NaN if contacts are found in equilibrium."""
        return self.result.error_bound

    @property
    def kappa(self) -> Array:
        """Condition number of the matrix as usually assembled, (poses,).

        NaN if a joint is ideal in some directions only, or nodes are tied.
        """
        return self._conditions[0]

    @property
    def planar_kappa(self) -> Array:
        """Condition number of its part in the plane in which the linkage moves, (poses,); NaN for motion in space."""
        return self._conditions[1]

    @cached_property
    def _conditions(self) -> tuple[Array, Array]:
        return conditions(self.result.main, (self.result.poses,))

    @cached_property
    def sampled_kappa(self) -> tuple[Array, Array]:
        return few_samples(self.result.inputs, self.result.nominal, SPECTRA).condition_numbers()

    @cached_property
    def kappa_scaled(self) -> Array:
        return np.broadcast_to(self.result.main.scaled_condition_number(), (self.result.poses,))

    @property
    def unknowns(self) -> int:
        return 6 * len(self.result.solution.frame.nodes)

    @cached_property
    def closes(self) -> Mask:
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
        """Results at large displacement, computed some samples at a time."""
        return large_parts(self.result.inputs, self.result.nominal, taken(self.count))
