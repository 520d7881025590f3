"""Clearance with a given contact angle: an offset in the joint, instead of contact found by equilibrium."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from ....framework.batch import Array, rotated
from ....framework.errors import FrameError
from ...clearance import offset
from ...planar import vector
from ..description.parts import ROUNDING, Pair

if TYPE_CHECKING:
    from ....framework.frame import Frame


def impose_contacts(frame: Frame, joints: Mapping[str, Pair]) -> None:
    """Offset each journal whose contact angle γ is given by ε cos γ along x and ε sin γ along y, Eq. (11) of the paper.

    x and y are the joint's axes in the reference configuration; they do not turn with the linkage.

    Parameters
    ----------
    frame
        The frame of the linkage at its poses, in which these joints have no clearance.
    joints
        The linkage's joints by name.

    Raises
    ------
    FrameError
        If the axis of such a joint changes its direction.
    """
    for pair in _given(joints):
        x, y = _offset(frame, pair)
        frame.offset(pair.name, ux=x, uy=y)


def without_contacts(frame: Frame, joints: Mapping[str, Pair]) -> Frame:
    """Copy of the frame without the offsets of given contact angles; the frame itself if there are none."""
    given = _given(joints)
    if not given:
        return frame
    clone = frame.copy()
    for pair in given:
        clone.offset(pair.name, ux=0.0, uy=0.0)
    return clone


def has_contacts(joints: Mapping[str, Pair]) -> bool:
    """Whether the contact angle of one of the joints is given."""
    return bool(_given(joints))


def _given(joints: Mapping[str, Pair]) -> list[Pair]:
    return [pair for pair in joints.values() if pair.contact is not None]


def _offset(frame: Frame, pair: Pair) -> tuple[Array, Array]:
    """Offset in the joint's axes at every pose, x and y, (...)."""
    assert pair.contact is not None
    assert pair.clearance is not None
    place = rotated(pair.axes, vector(offset(pair.clearance, pair.contact)))
    axes = np.asarray(frame.joints[pair.name].element.axes)
    local = rotated(np.swapaxes(axes, -1, -2), place)
    if np.any(np.abs(local[..., 2]) > ROUNDING * np.max(pair.clearance)):
        raise FrameError(
            f"joint {pair.name!r}: a contact angle is measured about the joint's axis, which does not keep its "
            "direction here: leave contact out, so that it is found in equilibrium"
        )
    return local[..., 0], local[..., 1]
