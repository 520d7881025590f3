"""Parts of a linkage that formats of robotics cannot describe, and the warning that names them."""

from __future__ import annotations

import warnings
from collections.abc import Sequence

import numpy as np

from ....framework.batch import Array
from ..description.linkage_description import LinkageDescription


class ConversionWarning(UserWarning):
    """Parts of a description that the other format cannot describe are left out."""


def not_rigid(linkage: LinkageDescription) -> list[str]:
    """Parts of a linkage that are not rigid bodies on ideal joints."""
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
    """Whether a moment of inertia is above the sum of the two others, unless it was given alone, about z."""
    alone = not np.any(tensor[..., :2, :]) and not np.any(tensor[..., :2])
    moments = np.linalg.eigvalsh(tensor)
    return not alone and bool(np.any(moments[..., 2] > (1.0 + 1e-9) * (moments[..., 0] + moments[..., 1])))


def acting(linkage: LinkageDescription) -> list[str]:
    """Actions on a linkage other than its weight and its drives: springs and loads."""
    there = {"springs": linkage.springs, "loads": linkage.loads}
    return [what for what, own in there.items() if own]


def tell(file: object, left: Sequence[str], format_name: str, depth: int) -> None:
    """Warn of what was left out of a file; the warning points at the call `depth` levels above."""
    if left:
        text = f"{file}: {format_name} has no words for the {'; the '.join(left)}: left out"
        warnings.warn(text, ConversionWarning, stacklevel=depth + 1)
