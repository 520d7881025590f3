"""The parameters of a four-bar that may be uncertain, by name, and the four-bar that samples of them make."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...elements import Beam, Material
from ...framework.errors import FrameError
from .description import JOINTS, LINKS, LOADS, PerJoint, each_joint
from .four_bar import FourBar

Array = NDArray[np.float64]
Samples = Mapping[str, Array]

LENGTHS = (*LINKS, "ground")
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
    """Check that all names are parameters of the four-bar."""
    for name in names:
        if name not in NAMES:
            known = ", ".join((*LENGTHS, "drive", *LOADS, *OF_JOINTS, "E"))
            ends = "after a joint's, .B, .D or .E may follow, after E, .crank, .coupler or .rocker"
            raise FrameError(f"{name!r} is no parameter of the four-bar: choose from {known}; {ends}")


def check_overwritten(names: Iterable[str], four_bar: FourBar, clearance: PerJoint, contact: PerJoint | str) -> None:
    """Check that no distribution stands for numbers whose nominal values differ: its draws would replace them all."""
    given = set(names)
    for name, values in _shared(four_bar, clearance, contact).items():
        # Parts that have a distribution of their own are not replaced.
        of = {part: value for part, value in values.items() if given.isdisjoint(_own_names(name, part))}
        first = next(iter(of), "")
        apart = next((part for part in of if not np.array_equal(of[part], of[first])), None)
        if name in given and apart is not None:
            raise FrameError(
                f"distribution of {name!r}: that of {first} is {np.ravel(of[first])[0]:g} and that of {apart} is "
                f"{np.ravel(of[apart])[0]:g}, and one draw would stand in place of both: give each its own, such as "
                f"{_own_names(name, apart)[-1]!r}"
            )


def _shared(four_bar: FourBar, clearance: PerJoint, contact: PerJoint | str) -> dict[str, dict[str, ArrayLike]]:
    """Nominal values that a common name stands for, by name and part."""
    springs = {joint: four_bar.joint_stiffness(joint) for joint in JOINTS}
    out: dict[str, dict[str, ArrayLike]] = {
        "E": {link: four_bar.link_beam(link).material.E for link in LINKS},
        "clearance": per_joint(clearance, "clearance", {}),
        "contact": {} if isinstance(contact, str) else per_joint(contact, "contact", {}),
    }
    out |= {name: {joint: springs[joint][..., k] for joint in JOINTS} for k, name in enumerate(COMPONENTS)}
    # Free and ideal springs stay what they are.
    finite = {
        f"{name}.{joint}": springs[joint][..., k]
        for joint in JOINTS
        for k, name in enumerate(COMPONENTS)
        if np.all((springs[joint][..., k] > 0.0) & np.isfinite(springs[joint][..., k]))
    }
    out["stiffness"] = dict(finite)
    return out | {f"stiffness.{j}": {k: v for k, v in finite.items() if k.endswith(j)} for j in JOINTS}


def _own_names(name: str, part: str) -> tuple[str, ...]:
    """The more specific names of a part, which take precedence over a common name."""
    component, _, joint = part.partition(".")
    if name == "stiffness":
        return f"stiffness.{joint}", component, part
    return (component, part) if name.startswith("stiffness") else (f"{name}.{part}",)


def toleranced(four_bar: FourBar, samples: Samples) -> FourBar:
    """The four-bar with sampled lengths, moduli and joint stiffnesses, (n,)."""
    lengths = {name: samples[name] for name in LENGTHS if name in samples}
    beams = {link: _beam(four_bar.link_beam(link), link, samples) for link in LINKS}
    springs = {joint: _stiffness(four_bar.joint_stiffness(joint), joint, samples) for joint in JOINTS}
    return replace(four_bar, **lengths, beam=beams, stiffness=springs)  # type: ignore[arg-type]


def per_joint(given: PerJoint, name: str, samples: Samples) -> dict[str, ArrayLike]:
    """Value of `name` for each joint: its own samples, else the common ones, else what was given."""
    return {joint: _own(name, joint, samples, value) for joint, value in each_joint(given).items()}


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
