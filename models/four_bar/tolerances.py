"""The parameters of a four-bar that may be uncertain, by name, and the four-bar that samples of them make."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...elements import Beam, Material
from ...framework.errors import FrameError
from .four_bar import JOINTS, FourBar
from .motion import LINKS

Array = NDArray[np.float64]
Samples = Mapping[str, Array]

LENGTHS = (*LINKS, "ground")
LOADS = ("fx", "fy", "mz")
COMPONENTS = ("ktx", "kty", "ktz", "krx", "kry", "krz")
OF_JOINTS = ("stiffness", *COMPONENTS, "clearance", "contact")
NAMES = (
    *LENGTHS,
    "drive",
    *LOADS,
    *(name for common in OF_JOINTS for name in (common, *(f"{common}.{joint}" for joint in JOINTS))),
    "E",
    *(f"E.{link}" for link in LINKS),
)


def check_names(names: Iterable[str]) -> None:
    """Refuse a name that is no parameter."""
    for name in names:
        if name not in NAMES:
            known = ", ".join((*LENGTHS, "drive", *LOADS, *OF_JOINTS, "E"))
            ends = "after a joint's, .B, .D or .E may follow, after E, .crank, .coupler or .rocker"
            raise FrameError(f"{name!r} is no parameter of the four-bar: choose from {known}; {ends}")


def toleranced(four_bar: FourBar, samples: Samples) -> FourBar:
    """The four-bar with sampled lengths, moduli and joint stiffnesses, (n,)."""
    lengths = {name: samples[name] for name in LENGTHS if name in samples}
    beams = {link: _beam(four_bar.link_beam(link), link, samples) for link in LINKS}
    springs = {joint: _stiffness(four_bar.joint_stiffness(joint), joint, samples) for joint in JOINTS}
    return replace(four_bar, **lengths, beam=beams, stiffness=springs)  # type: ignore[arg-type]


def per_joint(common: ArrayLike | Mapping[str, ArrayLike], name: str, samples: Samples) -> dict[str, ArrayLike]:
    """Value of `name` for each joint: its own samples, else the common ones, else what was given."""
    given = {joint: common.get(joint, 0.0) if isinstance(common, Mapping) else common for joint in JOINTS}
    return {joint: _own(name, joint, samples, value) for joint, value in given.items()}


def _own(name: str, part: str, samples: Samples, otherwise: ArrayLike) -> ArrayLike:
    return samples.get(f"{name}.{part}", samples.get(name, otherwise))


def _beam(beam: Beam, link: str, samples: Samples) -> Beam:
    modulus = _own("E", link, samples, beam.material.E)
    if modulus is beam.material.E:
        return beam
    shear = beam.material.G * (np.asarray(modulus) / beam.material.E)
    return replace(beam, material=Material(E=modulus, G=shear, density=beam.material.density))


def _stiffness(nominal: Array, joint: str, samples: Samples) -> Array:
    springs = [nominal[..., index] for index in range(6)]
    every = _own("stiffness", joint, samples, np.nan)
    if np.all(np.isfinite(every)):
        springs = [np.where((spring > 0.0) & np.isfinite(spring), every, spring) for spring in springs]
    springs = [np.asarray(_own(name, joint, samples, k)) for name, k in zip(COMPONENTS, springs, strict=True)]
    return np.stack(np.broadcast_arrays(*springs), axis=-1)
