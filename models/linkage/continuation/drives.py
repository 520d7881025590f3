"""Values, rates and accelerations of the drives, as given by the user."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ....framework import rotation
from ....framework.batch import Array, Shape, finite, join
from ....framework.errors import FrameError
from ..description.linkage_description import LinkageDescription
from ..description.parts import Pair
from ..kinematics.blocks import common
from ..kinematics.mechanism import Mechanism

# Rate and acceleration of a drive that stands still.
_STILL = np.zeros(())
_STILL.setflags(write=False)


class Drives(NamedTuple):
    """Given motion of the driven coordinates, in the mechanism's units.

    Attributes
    ----------
    states
        Driven entries of the state, zero in the reference configuration.
    rates, accelerations
        Driven velocity coordinates and their time derivatives.
    shape
        Broadcast of the driven states.
    full_shape
        Broadcast with the rates and accelerations.
    """

    states: list[Array]
    rates: list[Array]
    accelerations: list[Array]
    shape: Shape
    full_shape: Shape


def given_drives(
    linkage: LinkageDescription,
    mechanism: Mechanism,
    values: Mapping[str, ArrayLike],
    rates: Mapping[str, ArrayLike],
    accelerations: Mapping[str, ArrayLike],
) -> Drives:
    """Check the values given for the drives, and put them in the order of the mechanism's drives."""
    for what, given in (("value", values), ("rate", rates), ("acceleration", accelerations)):
        for name in given:
            if name not in linkage.drives:
                linkage.joint(name)
                driven = ", ".join(linkage.drives) or "none"
                raise FrameError(
                    f"{what} of joint {name!r} is given, but nothing drives it (driven: {driven}): "
                    f"make it a drive with drive({name!r})"
                )
    shapes: dict[str, Shape] = {"the points": linkage.shape}
    states: list[Array] = []
    first: list[Array] = []
    second: list[Array] = []
    for name, components in linkage.drives.items():
        scales = [mechanism.size if component[0] == "u" else 1.0 for component in components]
        states += _states(linkage.joints[name], components, values.get(name), scales, shapes)
        for out, what, given in ((first, "rate", rates), (second, "acceleration", accelerations)):
            if name not in given:
                out += [_STILL] * len(components)
                continue
            array = _components(f"{what} of joint {name!r}", given[name], components)
            join(shapes, f"{what} of joint {name!r}", array.shape[:-1])
            out += _apart(array, scales)
    shape = common({state.shape for state in states})
    full = common({shape, *(x.shape for x in (*first, *second))}) if rates or accelerations else shape
    return Drives(states, first, second, shape, full)


def by_joint(**given: Mapping[str, ArrayLike] | None) -> list[Mapping[str, ArrayLike]]:
    """Numbers by joint, as given under names such as ``rates``; an empty mapping for None."""
    for what, numbers in given.items():
        if numbers is not None and type(numbers) is not dict and not isinstance(numbers, Mapping):
            raise FrameError(f"{what} is {numbers!r}: give numbers by joint, such as {what}={{'A': 1.0}}")
    return [numbers or {} for numbers in given.values()]


def _components(what: str, value: ArrayLike, components: tuple[str, ...]) -> Array:
    given = finite(value, what)
    if len(components) == 1:
        return given[..., None]
    if given.ndim == 0 or given.shape[-1] != len(components):
        raise FrameError(
            f"{what} has shape {given.shape}: its last axis must hold {len(components)} components {components}"
        )
    return given


def _states(
    pair: Pair,
    components: tuple[str, ...],
    value: ArrayLike | None,
    scales: Sequence[float | Array],
    shapes: dict[str, Shape],
) -> list[Array]:
    if isinstance(value, float) and pair.reference.shape == (1,) and math.isfinite(value):
        return [np.asarray((value - pair.reference.item()) / scales[0])]
    what = f"value of joint {pair.name!r}"
    chosen = pair.kind.places_of(components)
    if pair.kind.name == "spherical" and len(chosen) < 3:
        raise FrameError(f"joint {pair.name!r} is driven by {components}: drive all three rotations of a ball, or none")
    given = pair.reference[..., chosen] if value is None else _components(what, value, components)
    join(shapes, what, given.shape[:-1])
    if pair.kind.name == "spherical":
        both = np.broadcast_arrays(given, -pair.reference)
        now, before = (rotation.exponential(np.moveaxis(vectors, -1, 0)) for vectors in both)
        return list(rotation.product(now, before))
    return _apart(given - pair.reference[..., chosen], scales)


def _apart(numbers: Array, scales: Sequence[float | Array]) -> list[Array]:
    """Each of the numbers on the last axis in the mechanism's units."""
    return [np.asarray(numbers[..., k] / scale) for k, scale in enumerate(scales)]
