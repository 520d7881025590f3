"""The components of a joint in which it has clearance: their default, and the checks of those that are given."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..framework.dofs import DISPLACEMENTS, component
from ..framework.errors import FrameError
from ..framework.protocol import Array

TRANSLATIONS, ROTATIONS = (0, 1, 2), (3, 4, 5)


def radial(springs: Array) -> tuple[int, ...]:
    """Clearance directions of a bearing: the constrained translations, except along the axis of a single free rotation.

    A revolute or cylindrical joint about z has clearance in ``ux uy``, a spherical one in ``ux uy uz``, a slider along
    x in ``uy uz``. Components that are free (stiffness 0 in the whole batch) have no clearance.
    """
    constrained = np.any(springs.reshape(-1, 6) > 0.0, axis=0).tolist()
    turning = [k - 3 for k in ROTATIONS if not constrained[k]]
    along = turning if len(turning) == 1 else []
    return tuple(k for k in TRANSLATIONS if constrained[k] and k not in along)


def checked_directions(springs: Array, names: str | Sequence[str | int] | None) -> tuple[int, ...]:
    """Indices of the components `names` (names or indices); the default of `radial` where None.

    Raises
    ------
    FrameError
        If there are none, if translations and rotations are mixed, or if the springs of these components are not
        equal and above zero: the contact stiffness would depend on the direction, or there would be no contact.
    """
    names = (names,) if isinstance(names, str) else names
    found = radial(springs) if names is None else tuple(sorted({_index(name) for name in names}))
    text = " ".join(DISPLACEMENTS[k] for k in found)
    if not found:
        why = "no translation is constrained" if names is None else "in no direction"
        raise FrameError(
            f"Joint: clearance, but {why}; name components, such as clearance_directions=('ux', 'uy'), or None for "
            "those of a bearing"
        )
    if not (set(found) <= set(TRANSLATIONS) or set(found) <= set(ROTATIONS)):
        raise FrameError(f"Joint: clearance in {text} mixes lengths and angles; give translations or rotations")
    own = springs[..., list(found)]
    if not np.all(own > 0.0):
        raise FrameError(
            f"Joint: clearance given in a free direction of {text}, where the stiffness is 0; leave it out"
        )
    if not np.all(own == own[..., :1]):
        unequal = own[np.any(own != own[..., :1], axis=-1)][0]
        raise FrameError(
            f"Joint: clearance in {text} needs one contact stiffness, not {unequal}; name others by "
            "clearance_directions="
        )
    return found


def _index(name: str | int) -> int:
    known = not isinstance(name, str) and name in range(len(DISPLACEMENTS))
    return int(name) if known else component(name)  # type: ignore[arg-type]
