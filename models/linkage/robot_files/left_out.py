"""What a linkage has for which files of robotics have no words, and the warning that tells of it."""

from __future__ import annotations

import warnings
from collections.abc import Sequence

import numpy as np

from ....framework.batch import Array
from ..description.linkage_description import LinkageDescription


class ConversionWarning(UserWarning):
    """Parts of a description for which the other file format has no words; they are left out."""


def not_rigid(linkage: LinkageDescription) -> list[str]:
    """What makes a linkage other than rigid bodies on ideal joints."""
    joints = linkage.joints.values()
    kinds = {
        "sections and stiffness of the beams of": [link.name for link in linkage.links.values() if link.beams],
        "stiffness of joint": [pair.name for pair in joints if pair.stiffness is not None],
        "clearance of joint": [pair.name for pair in joints if pair.clearance is not None],
        "share of the inertia, more than a body can have about one axis, of link": [
            link.name for link in linkage.links.values() if link.inertia is not None and _is_no_body(link.inertia)
        ],
        "reference rotation of ball": [
            pair.name for pair in joints if pair.kind.name == "spherical" and np.any(pair.reference)
        ],
    }
    return [f"{what} {', '.join(names)}" for what, names in kinds.items() if names]


def _is_no_body(tensor: Array) -> bool:
    """Whether a moment of inertia is above the sum of the two others; but for one about z that was given alone."""
    alone = not np.any(tensor[..., :2, :]) and not np.any(tensor[..., :2])
    moments = np.linalg.eigvalsh(tensor)
    return not alone and bool(np.any(moments[..., 2] > (1.0 + 1e-9) * (moments[..., 0] + moments[..., 1])))


def acting(linkage: LinkageDescription) -> list[str]:
    """What acts on a linkage beside its weight and its drives."""
    there = {"springs": linkage.springs, "loads": linkage.loads}
    return [what for what, own in there.items() if own]


def tell(file: object, left: Sequence[str], format_name: str, depth: int) -> None:
    """Warn of what was left out of a file, at the call so many levels above."""
    if left:
        text = f"{file}: {format_name} has no words for the {'; the '.join(left)}: left out"
        warnings.warn(text, ConversionWarning, stacklevel=depth + 1)
