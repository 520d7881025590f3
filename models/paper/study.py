"""What the inputs of the accuracy job ask for: the four-bar, its samples, and how many they are."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...elements import Beam, Material, Rectangle
from ...framework.errors import FrameError
from ..four_bar.description import JOINTS, LINKS
from ..four_bar.four_bar import FourBar
from ..four_bar.study import Study, monte_carlo
from ..job.measured import MEASURED_WAY
from ..job.outcome import LARGE_WAY, LINEAR_WAY, taken
from ..sampling import Distribution, Normal
from .given_tolerances import given_tolerances
from .inputs import LENGTHS, Inputs

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
    """Normal distributions (12) of what is uncertain, or those given in words; what has no deviation is left out."""
    each = [f".{joint}" for joint in JOINTS] if inputs.joints == "independent" else [""]
    spread = {name: (getattr(inputs, name), inputs.length_sd) for name in (*LINKS, "ground")}
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
    """The samples at drive angles at which the linkage can be assembled, radians, (poses,)."""
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


def work(inputs: Inputs) -> dict[str, int]:
    """Poses times samples to be computed: by linear mechanics, at large displacement, and at measured poses."""
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
    """How many of the poses can be assembled and are not singular."""
    return int((linkage.assembles(theta) & ~linkage.singular(theta)).sum())
