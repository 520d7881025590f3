"""Displacement of a point by thermal expansion of the links, through the loop closure."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from ....framework.batch import Array, finite, joined
from ....framework.errors import FrameError
from ..description.parts import GROUND
from ..description.sketch import place
from ..poses.classified import ClassifiedPoses
from .position_sensitivity import PositionSensitivity, position_sensitivity, with_redundant_rows

# Gap in overconstrained loops, as a share of the displacements, above which expanding links no longer fit.
OPENED = 1e-9

# Rises of temperature and coefficients of expansion: one for all links, or by link.
Temperature = Mapping[str, ArrayLike] | ArrayLike
Expansion = Mapping[str, float] | float


def expansions(
    linkage_links: Mapping[str, object], names: Mapping[str, object], given: Expansion | None
) -> dict[str, Array]:
    """Coefficient of thermal expansion of each link that has a temperature, checked.

    Parameters
    ----------
    linkage_links
        The links by name.
    names
        Rises of temperature by link, of which only the names are used.
    given
        One coefficient for all links, or one for each by name, 1/K.
    """
    for name in names:
        if name != GROUND and name not in linkage_links:
            known = ", ".join(linkage_links)
            raise FrameError(f"temperature of {name!r}, which is no link: name one of {known}, or the ground")
    if given is None:
        raise FrameError("a temperature needs an expansion: give its coefficient, such as expansion=1.2e-5 for steel")
    by_link = given if isinstance(given, Mapping) else dict.fromkeys(names, given)
    missing = [name for name in names if name not in by_link]
    if missing:
        raise FrameError(f"link {missing[0]!r} has a temperature and no expansion: give its coefficient")
    return {name: finite(by_link[name], f"expansion of {name!r}") for name in names}


def per_strain(motion: ClassifiedPoses, point: str, link: str | None, heated: str) -> Array:
    """Displacement and rotation of a point, (..., 6), per unit thermal strain of one link, to first order.

    The link expands about its first point, the ground about its first pivot. The thread of a screw expands with the
    first link of its joint.

    Raises
    ------
    FrameError
        If the link does not fit in overconstrained loops when it alone expands.
    """
    full = with_redundant_rows(position_sensitivity(motion, point, link))
    return _fitting(motion, _grown(full, heated), f"link {heated!r} that becomes warmer does")


def _fitting(motion: ClassifiedPoses, found: Array, what: str) -> Array:
    """Displacement and rotation, (..., 6), without the gaps in redundant constraints; refuses gaps above rounding."""
    moved = np.nanmax(np.abs(found[..., :3]), initial=0.0)
    unit = float(np.max(motion.mechanism.size)) * np.nanmax(np.abs(found), initial=0.0)
    if np.any(np.abs(found[..., 6:]) > OPENED * max(moved, unit)):
        raise FrameError(
            f"{what} not fit in the overconstrained loops, whose internal forces under heat are not computed here: "
            "leave the temperature out, or take the redundant constraints out"
        )
    return np.asarray(found[..., :6])


def _grown(by: PositionSensitivity, heated: str) -> Array:
    points = [point for link, point in by.places if link == heated]
    total = np.zeros((*by.motion.shape, by.rows))
    if not points:
        return total
    where = {point: place(by.linkage, heated, point) for point in points}
    first = where[points[0]]
    for point, own in where.items():
        total = total + np.sum(by.places[heated, point] * (own - first)[..., None, :], axis=-1)
    for name, per_pitch in by.pitches.items():
        screw = by.linkage.joint(name)
        if screw.first == heated and screw.pitch is not None:
            total = total + per_pitch * screw.pitch[..., None]
    return total


def expanded(
    motion: ClassifiedPoses, point: str, link: str | None, temperature: Temperature, expansion: Expansion | None
) -> Array:
    """Displacement and rotation, (..., 6), by rises of temperature, for all links or by link; see `Motion.accuracy`."""
    links = motion.linkage.links
    rises = temperature if isinstance(temperature, Mapping) else dict.fromkeys(links, temperature)
    by_link = expansions(links, rises, expansion)
    full = with_redundant_rows(position_sensitivity(motion, point, link))
    total = np.zeros((*motion.shape, full.rows))
    for name, rise in rises.items():
        degrees, coefficient = finite(rise, f"temperature of {name!r}"), np.asarray(by_link[name])
        known = {"the motion": total.shape[:-1], f"expansion of {name!r}": coefficient.shape}
        joined(f"temperature of {name!r}", degrees.shape, known)
        strain = degrees * coefficient
        total = total + _grown(full, name) * strain[..., None]
    return _fitting(motion, total, "links that become warmer do")
