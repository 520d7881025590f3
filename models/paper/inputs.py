"""The inputs of the accuracy job; the defaults are the paper's example."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Self

import numpy as np
from numpy.typing import NDArray

from ...framework.errors import FrameError
from ..job import measured
from ..measured import table
from ..sampling import goes_on

if TYPE_CHECKING:
    from ..job.measured import DriveValues, MeasuredPoint

Array = NDArray[np.float64]
MOST_POSES = 100_000
# Name of the drive in tables of measured positions.
DRIVE = "A"

# Inputs that must stay positive, with the names of their deviations; at the largest deviation, one fifth of the mean,
# one sample in three million is negative.
LENGTHS = ("crank", "coupler", "rocker", "ground")
POSITIVE = {
    **dict.fromkeys(LENGTHS, "length_sd"),
    **{name: f"{name}_sd" for name in ("young", "stiffness", "clearance")},
}
MOST_DEVIATION = 0.2


@dataclass(frozen=True, kw_only=True)
class Inputs:
    """Inputs of the accuracy job as on the command line: SI units, angles in degrees.

    Attributes
    ----------
    crank, coupler, rocker, ground, length_sd
        Lengths of the links and the standard deviation of each.
    point
        Coordinates of P in the coupler's axes.
    branch
        Side of the rocker's pin; None as in `FourBar`.
    section, in_plane
        Sides of the links' rectangle; whether the ``"long"`` or the ``"short"`` one lies in the plane of motion.
    young, young_sd, poisson
        Elastic constants of the links and the standard deviation of the first.
    stiffness, stiffness_sd
        Stiffness of the joints in every direction but about the pin, and its standard deviation.
    clearance, clearance_sd, clearance_is
        Clearance, its standard deviation, and whether both are given on ``"radius"`` or ``"diameter"``.
    closure
        Displacement by the clearance: ``"first-order"``, or ``"exact"`` with the loop closed again.
    contact, contact_sd
        Contact angle, or ``"reaction"`` or ``"equilibrium"`` as in `accuracy`, and its standard deviation.
    joints
        ``"independent"`` draws for each joint, or one ``"shared"`` draw.
    load, load_sd
        Force on P along y, and its standard deviation.
    poses
        First and last drive angle and the step.
    samples, rng, sampler
        Number of samples at each pose, the seed, and how they are drawn, as in `monte_carlo`.
    nan_policy
        Treatment of samples without a result, as in `monte_carlo`.
    histogram_pose
        Drive angle of the histograms; if None, the regular one nearest to 30.
    magnify
        Factor on the displacements in the drawn trajectory; if None, one is chosen.
    tolerance
        Names of numbers with their deviations in words, which replace standard deviations.
    measured
        File of measured positions of P; None if there are none.
    """

    crank: float = 0.1
    coupler: float = 0.2
    rocker: float = 0.1
    ground: float = 0.2
    length_sd: float = 0.0
    point: tuple[float, float] = (0.1, 0.0)
    branch: str | None = None
    section: tuple[float, float] = (6.35e-3, 12.7e-3)
    in_plane: str = "long"
    young: float = 2e11
    young_sd: float = 0.0
    poisson: float = 0.3
    stiffness: float = 2e11
    stiffness_sd: float = 1e10
    clearance: float = 1e-3
    clearance_sd: float = 5e-5
    clearance_is: str = "radius"
    closure: str = "first-order"
    contact: float | str = 180.0
    contact_sd: float = 180.0
    joints: str = "independent"
    load: float = 100.0
    load_sd: float = 5.0
    poses: tuple[float, float, float] = (0.0, 360.0, 10.0)
    samples: int = 100
    rng: int = 0
    sampler: str = "random"
    nan_policy: str = "omit"
    histogram_pose: float | None = None
    magnify: float | None = None
    tolerance: tuple[tuple[str, str], ...] = ()
    measured: Path | None = None

    def __post_init__(self) -> None:
        first, last, step = self.poses
        if step <= 0.0 or last < first:
            raise FrameError(
                f"--poses is {first:g} {last:g} {step:g}: give FIRST LAST STEP with LAST ≥ FIRST and STEP > 0"
            )
        if (last - first) / step >= MOST_POSES:
            raise FrameError(
                f"--poses asks for {(last - first) / step:.3g} poses: take a greater STEP, at most {MOST_POSES}"
            )

        wanted = self.histogram_pose
        if wanted is not None and not np.isclose(self.degrees, wanted, rtol=0.0, atol=1e-9).any():
            near = self.degrees[np.argmin(np.abs(self.degrees - wanted))]
            raise FrameError(f"--histogram-pose {wanted:g} is none of the poses: the nearest is {near:g}")
        for name, deviation in POSITIVE.items():
            mean, sd = getattr(self, name), getattr(self, deviation)
            if sd > MOST_DEVIATION * mean:
                raise FrameError(
                    f"--{deviation.replace('_', '-')} is {sd:g} beside --{name} {mean:g}: normal samples would go below"
                    f" zero; give at most {MOST_DEVIATION * mean:g}"
                )
        if np.isinf(self.stiffness) and self.stiffness_sd > 0.0:
            raise FrameError(
                f"--stiffness inf leaves nothing to vary: give --stiffness-sd 0 and not {self.stiffness_sd:g}"
            )

        if isinstance(self.contact, str) and self.contact_sd not in (0.0, Inputs.contact_sd):
            raise FrameError(
                f"--contact-sd is {self.contact_sd:g} beside --contact {self.contact}: the angle follows from the "
                "forces and has no deviation of its own; leave out one of the two"
            )
        shortest = min(LENGTHS, key=lambda name: float(getattr(self, name)))
        radial, length = self.clearance * self.to_radius, getattr(self, shortest)
        if radial >= length:
            raise FrameError(
                f"--clearance is {self.clearance:g}, which on the radius is not less than --{shortest} {length:g}: "
                "check its unit, metres"
            )
        _ = self.measured_drive

    @property
    def to_radius(self) -> float:
        """Factor from the given clearance to the radial clearance."""
        return 0.5 if self.clearance_is == "diameter" else 1.0

    @property
    def without_effect(self) -> dict[str, str]:
        """By name: options that are not at their default and have no effect, with the reason."""
        found: dict[str, str] = {}
        if self.clearance == 0.0:
            found = dict.fromkeys(("closure", "contact", "contact_sd", "clearance_is"), "--clearance is 0")
        if self.in_plane != Inputs.in_plane and self.section[0] == self.section[1]:
            found["in_plane"] = "the section is a square"
        angles = not isinstance(self.contact, str) and self.contact_sd > 0.0 and self.clearance > 0.0
        if not (self.stiffness_sd or self.clearance_sd or angles or self.tolerance):
            found["joints"] = "no number of the joints has a deviation"
        return {name: why for name, why in found.items() if getattr(self, name) != getattr(Inputs, name)}

    @cached_property
    def degrees(self) -> Array:
        """Drive angles, degrees, (poses,)."""
        first, last, step = self.poses
        return np.asarray(first + step * np.arange(int((last - first) / step + 1e-9) + 1))

    @property
    def theta(self) -> Array:
        """Drive angles, radians, (poses,)."""
        return np.radians(self.degrees)

    @cached_property
    def measured_point(self) -> MeasuredPoint | None:
        """Measured positions of P; None if there are none."""
        if self.measured is None:
            return None
        return measured.MeasuredPoint(self.measured, "P", measured.LEVEL, table.read_measured(self.measured))

    @cached_property
    def measured_drive(self) -> DriveValues | None:
        """Drive angles at the measured poses, degrees, (poses,); None if there are none."""
        if self.measured_point is None:
            return None
        drive = measured.DriveValues(self.degrees, "deg")
        values = self.measured_point.drive_values({DRIVE: drive}).get(DRIVE, self.degrees)
        return measured.DriveValues(np.broadcast_to(values, self.measured_point.table.position.shape[:1]), drive.unit)

    @property
    def is_paper_linkage(self) -> bool:
        """Whether the printed table is of this linkage: whether lengths, point and branch are those of the paper."""
        same = all(getattr(self, name) == getattr(Inputs, name) for name in (*LENGTHS, "point"))
        return same and self.branch in (None, "parallel")

    @property
    def varies_geometry(self) -> bool:
        """Whether lengths or the drive angle are uncertain."""
        return bool(self.length_sd) or any(name in (*LENGTHS, "drive") for name, _ in self.tolerance)

    @property
    def has_normal_clearances(self) -> bool:
        """Whether clearances and contact angles have normal distributions, by their standard deviations."""
        return not any(word in name for name, _ in self.tolerance for word in ("clearance", "contact"))

    @property
    def uncertain(self) -> bool:
        """Whether there are samples: always."""
        return True

    @property
    def about(self) -> dict[str, object]:
        """All inputs on which the samples depend, by option.

        The number of samples is not among them if their sequence can be continued and the sampled poses do not depend
        on it.
        """
        given = {field.name: getattr(self, field.name) for field in fields(self)}
        more = goes_on(self.sampler) and not self.varies_geometry
        given["measured"] = None if self.measured_point is None else self.measured_point.about
        left_out = ("histogram_pose", "magnify", *(("samples",) if more else ()))
        return {f"--{name.replace('_', '-')}": value for name, value in given.items() if name not in left_out}

    def in_words(self, form: str) -> dict[str, str]:
        """The inputs as text, by name; numbers in a format such as ``"g"``."""
        given = {field.name: getattr(self, field.name) for field in fields(self)}
        return {name: _text(value, form) for name, value in given.items() if value is not None and value != ()}

    def but(self, **changes: object) -> Self:
        """Copy with some inputs changed; contact angles that follow from forces lose their tolerance."""
        changed = replace(self, **changes)  # type: ignore[arg-type]
        if isinstance(changes.get("contact"), str):
            changed = replace(changed, tolerance=tuple(each for each in self.tolerance if "contact" not in each[0]))
        return changed


def _text(value: object, form: str) -> str:
    if isinstance(value, tuple):
        return " ".join(_text(each, form) for each in value)
    return format(value, form) if isinstance(value, float) else str(value)
