"""The four-bar of the accuracy job and its samples: linear, at large displacement and at measured poses."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...elements import Beam, Material, Rectangle
from ...framework.errors import FrameError
from ..four_bar.description import JOINTS, LINKS
from ..four_bar.four_bar import FourBar
from ..four_bar.study import SampledAccuracy, Study, monte_carlo, part_of
from ..four_bar.tolerances import toleranced
from ..job.measured import MEASURED_WAY, MeasuredOutcome
from ..job.outcome import LARGE_WAY, LINEAR_WAY, LargeSpread, taken
from ..job.parts import Parts
from ..sampling import Distribution, Normal
from .given_tolerances import given_tolerances
from .inputs import DRIVE, LENGTHS, Inputs

Array = NDArray[np.float64]


def four_bar(inputs: Inputs) -> FourBar:
    """The linkage at the mean inputs."""
    long, short = max(inputs.section), min(inputs.section)
    section = Rectangle(y=long, z=short) if inputs.in_plane == "long" else Rectangle(y=short, z=long)
    return FourBar(
        crank=inputs.crank,
        coupler=inputs.coupler,
        rocker=inputs.rocker,
        ground=inputs.ground,
        point=inputs.point,
        branch=inputs.branch,
        beam=Beam(section, Material(E=inputs.young, nu=inputs.poisson)),
        stiffness=(inputs.stiffness,) * 5 + (0.0,),
    )


def distributions(inputs: Inputs, scale: float) -> dict[str, Distribution]:
    """Normal distributions, Eq. (12), of the uncertain inputs, or distributions given in words."""
    each = [f".{joint}" for joint in JOINTS] if inputs.joints == "independent" else [""]
    spread = {name: (getattr(inputs, name), inputs.length_sd) for name in LENGTHS}
    spread |= {f"E.{link}": (inputs.young, inputs.young_sd) for link in LINKS}
    spread |= {f"stiffness{joint}": (inputs.stiffness, inputs.stiffness_sd) for joint in each}
    spread |= {f"clearance{joint}": (scale * inputs.clearance, scale * inputs.clearance_sd) for joint in each}
    if not isinstance(inputs.contact, str):
        angle = float(np.radians(inputs.contact)), float(np.radians(inputs.contact_sd))
        spread |= {f"contact{joint}": angle for joint in each}
    spread["fy"] = inputs.load, inputs.load_sd
    normal = {name: Normal(mean, deviation) for name, (mean, deviation) in spread.items() if deviation > 0.0}
    return normal | given_tolerances(inputs)


def study_of(inputs: Inputs, linkage: FourBar, theta: Array) -> Study:
    """The samples at drive angles `theta`, radians, (poses,), at which the linkage can be assembled."""
    scale = inputs.to_radius
    return monte_carlo(
        linkage,
        theta,
        distributions(inputs, scale),
        load=(0.0, inputs.load, 0.0),
        clearance=scale * inputs.clearance,
        contact=inputs.contact if isinstance(inputs.contact, str) else np.radians(inputs.contact),
        n=inputs.samples,
        rng=inputs.rng,
        sampler=inputs.sampler,
        exact=inputs.closure == "exact",
        nan_policy=inputs.nan_policy,
    )


def check_reach(linkage: FourBar, inputs: Inputs) -> None:
    """Refuse lengths with which no pose can be assembled."""
    gap = linkage.gap(inputs.theta)
    if (gap > 0.0).all():
        nearest = int(np.argmin(gap))
        lengths = ", ".join(f"--{name} {getattr(inputs, name):g}" for name in LENGTHS)
        raise FrameError(
            f"no pose can be assembled with {lengths}: coupler and rocker leave a gap of {gap[nearest]:.3g} m or more"
            f" (the least at {inputs.degrees[nearest]:g}°); change a length, or give other --poses"
        )


# -- at measured poses ------------------------------------------------------------------------------------------------


def study_at_measured_poses(inputs: Inputs, linkage: FourBar) -> Study | None:
    """The samples at the measured poses that can be assembled; None without measurements."""
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
    """Measured positions of P compared with those of a study at their poses; None without measurements."""
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


# -- at large displacement --------------------------------------------------------------------------------------------


def large_parts(study: Study) -> tuple[Parts, NDArray[np.bool_]]:
    """Results of the first samples at the poses at which all of them can be assembled, and a mask of these poses."""
    n = taken(study.n)
    nominal, inputs, contacts = study.nominal, part_of(study.inputs, slice(n)), study.nominal.contacts
    linkage, at = nominal.motion.four_bar, study.theta[:, None] + inputs.get("drive", np.zeros(1))
    assembles = toleranced(linkage, inputs).assembles(at)
    closes = np.asarray(np.broadcast_to(assembles, (len(at), n)).all(axis=-1))
    contact = "equilibrium" if contacts is None else contacts
    sampled = SampledAccuracy(linkage, at[closes], inputs, nominal.load, nominal.clearances, contact)
    return Parts(sampled, (int(closes.sum()), n), soon=contacts is None), closes


def large_samples(study: Study, parts: Parts, closes: NDArray[np.bool_]) -> LargeSpread:
    """The samples at large displacement; NaN where the linkage cannot be assembled."""
    samples = np.full((len(closes), parts.shape[1], 3), np.nan)
    samples[closes] = parts.taken("large") + parts.taken("rigid") - study.rigid[closes, None]
    passed = np.zeros(samples.shape[:2], dtype=bool)
    passed[closes] = parts.taken("large_passes")
    return LargeSpread(samples, "omit" if study.nan_policy == "omit" else "propagate", passed=passed)


# -- amount of work ---------------------------------------------------------------------------------------------------


def work(inputs: Inputs) -> dict[str, int]:
    """Number of poses times samples to compute, by part: linear, at large displacement, at measured poses."""
    linkage = four_bar(inputs)
    closes = linkage.assembles(inputs.theta)
    found = {
        LINEAR_WAY: _regular(linkage, inputs.theta) * inputs.samples,
        LARGE_WAY: int(closes.sum()) * taken(inputs.samples),
    }
    if inputs.measured_drive is not None:
        found[MEASURED_WAY] = _regular(linkage, np.radians(inputs.measured_drive.values)) * inputs.samples
    return found


def _regular(linkage: FourBar, theta: Array) -> int:
    """Number of poses that can be assembled and are not singular."""
    return int((linkage.assembles(theta) & ~linkage.singular(theta)).sum())
