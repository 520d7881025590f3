"""Checks of joints, done once when they are added to a frame, and whether linear solutions can represent them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from .batch import Array
from .entries import flattened
from .errors import FrameError
from .examined import attribute_of, fits
from .joint_protocol import JointElement

# Relative difference up to which two results agree.
_ALIKE = 1e-9


def examine_joint(name: str, element: JointElement) -> None:
    """Check what a joint element holds and returns.

    Raises
    ------
    FrameError
        If a frame cannot use it.
    """
    what = f"{type(element).__name__} of joint {name!r}"
    for attribute, trailing in (("stiffness", (6,)), ("axes", (3, 3)), ("clearance", ()), ("pitch", ())):
        value = attribute_of(what, element, attribute)
        if attribute == "axes" and value is None:
            continue
        _constrained(what, attribute, value, trailing, element.shape)
    if np.any(element.stiffness < 0.0):
        raise FrameError(f"{what}: stiffness is {element.stiffness.min():.6g}: give 0 (free) to inf (ideal)")
    if np.any(element.clearance < 0.0):
        raise FrameError(f"{what}: clearance is {element.clearance.min():.6g}: give a length, zero or above")
    if element.axes is not None:
        turn = np.swapaxes(element.axes, -1, -2) @ element.axes
        if np.abs(turn - np.eye(3)).max(initial=0.0) > _ALIKE or np.any(np.linalg.det(element.axes) < 0.0):
            raise FrameError(f"{what}: axes are not right-handed and orthonormal: give the joint's axes as columns")
    _clearance_directions(what, element)
    _joint_matrix(what, element)
    _typical(what, element)
    if element.has_law:
        force, tangent = at_rest(what, element)
        if not np.isfinite(force).all() or not np.isfinite(tangent).all():
            raise FrameError(f"{what}: resistance returned numbers that are not finite at rest")


def _constrained(what: str, attribute: str, value: Any, trailing: tuple[int, ...], shape: tuple[int, ...]) -> None:
    if not isinstance(value, np.ndarray) or value.dtype.kind != "f":
        raise FrameError(f"{what}: {attribute} is {value!r}: give an array of floats")
    lead = value.shape[: value.ndim - len(trailing)]
    if value.shape[len(lead) :] != trailing or not fits(lead, shape):
        wanted = ", ".join(map(str, ("...", *trailing)))
        raise FrameError(f"{what}: {attribute} has shape {value.shape}: give ({wanted}), within its shape {shape}")
    if np.isnan(value).any() or (attribute != "stiffness" and np.isinf(value).any()):
        raise FrameError(f"{what}: {attribute} contains nan or inf: give finite numbers")


def _clearance_directions(what: str, element: JointElement) -> None:
    directions = attribute_of(what, element, "clearance_directions")
    known = isinstance(directions, tuple) and all(k in range(6) for k in directions)
    if not known or len({k // 3 for k in directions}) > 1:
        raise FrameError(
            f"{what}: clearance_directions are {directions!r}: give indices from 0 to 5, of translations or of "
            "rotations"
        )
    if element.clearance.any() and not directions:
        raise FrameError(
            f"{what}: clearance is given and clearance_directions are empty: give the components that have it"
        )
    springs = element.stiffness[..., list(directions)]
    if directions and (np.any(springs != springs[..., :1]) or not np.all(springs)):
        raise FrameError(
            f"{what}: clearance_directions {directions} are free or of unequal stiffness: give one and the same"
        )


def _joint_matrix(what: str, element: JointElement) -> None:
    if np.isinf(element.stiffness).any():
        return
    found, made = np.asarray(element.matrix()), element.springs_matrix()
    size = np.abs(made).max(initial=0.0)
    if found.shape[-2:] != (12, 12) or not np.all(np.abs(found - made) <= _ALIKE * size):
        raise FrameError(
            f"{what}: matrix is not what its stiffness, axes and pitch make, by which a frame takes it: change these, "
            "or describe what they cannot by its own method resistance"
        )


def _typical(what: str, element: JointElement) -> None:
    found = element.typical()
    free = (element.stiffness == 0.0).reshape(-1, 6).all(axis=0)
    wrong = not isinstance(found, JointElement) or found.stiffness.size != 6 or bool(found.clearance.any())
    if wrong or np.any((found.stiffness.reshape(6) == 0.0) != free):
        raise FrameError(
            f"{what}: typical returned {found!r}: give the joint with one stiffness (6,), the greatest of the batch, "
            "and no clearance"
        )


def at_rest(what: str, element: JointElement) -> tuple[Array, Array]:
    """Force (m, 6) and tangent (m, 6, 6) of a joint's nonlinear law at zero displacement, at all batch entries."""
    shape = element.shape
    count = int(np.prod(shape, dtype=np.int64))

    def pick(array: Array, trailing: int) -> Array:
        lead = np.shape(array)[: np.ndim(array) - trailing]
        if not fits(lead, shape):
            raise FrameError(
                f"{what}: resistance takes entries of a parameter of batch shape {lead}, and its shape is {shape}: "
                "give the shape to which all parameters broadcast"
            )
        return flattened(array, shape, trailing)

    found = element.resistance(np.zeros((count, 6)), pick)
    shapes = tuple(np.shape(part) for part in found) if isinstance(found, tuple) else ()
    wanted = ((count,), (count, 6), (count, 6, 6))
    if shapes != wanted:
        raise FrameError(f"{what}: resistance returned shapes {shapes} for {count} entries: give {wanted}")
    return np.asarray(found[1], dtype=np.float64), np.asarray(found[2], dtype=np.float64)


def require_springs(joints: Mapping[str, JointElement]) -> None:
    """Refuse joints that a linear solution cannot represent by their springs, or by contact in clearances.

    Parameters
    ----------
    joints
        The joints of a frame, by name.

    Raises
    ------
    FrameError
        If a joint with a nonlinear law has clearance, or its force or tangent at zero displacement is not the springs'.
    """
    for name, element in joints.items():
        if not element.has_law:
            continue
        text = f"joint {name!r}: {type(element).__name__} has a law of its own, resistance"
        if element.clearance.any():
            raise FrameError(
                f"{text}, and clearance: linear solutions follow its stiffness, and contact of that stiffness. Use "
                "solve(large=True)"
            )
        if not _springs_at_rest(f"joint {name!r}", element):
            raise FrameError(
                f"{text}, that is not its stiffness at rest: linear solutions follow the stiffness. Give it the one "
                "that its law has at rest, or use solve(large=True)"
            )


def _springs_at_rest(what: str, element: JointElement) -> bool:
    force, tangent = at_rest(what, element)
    stiffness = np.broadcast_to(element.stiffness, (*element.shape, 6)).reshape(-1, 6)
    constrained = np.isinf(stiffness)
    wanted = np.where(constrained, 0.0, stiffness)[..., None] * np.eye(6)
    free = ~constrained[:, :, None] & ~constrained[:, None, :]
    size = np.abs(wanted).max(initial=0.0)
    return not np.any(force[~constrained]) and bool(np.all(np.abs(tangent - wanted)[free] <= _ALIKE * size))
