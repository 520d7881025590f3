"""The parts of a linkage: links, joints, springs and loads."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ....elements.parameters import given_state
from ....framework.arm import crossed
from ....framework.batch import Array, finite, vector
from ....framework.errors import FrameError
from ....framework.lazily import cached_property
from ....framework.protocol import LineElement
from .elastic_axis import neighbours
from .joints import Kind

GROUND = "ground"
# Rounding error below which directions count as parallel, perpendicular or zero.
ROUNDING = 1e-9
# Axes along the global ones.
UNTURNED = np.eye(3)
UNTURNED.setflags(write=False)


@dataclass(frozen=True, eq=False)
class LinkageLink:
    """A body of the linkage.

    Attributes
    ----------
    name
        Its name.
    points
        Names of its points, in the order given.
    beams
        Beam, or other line element, between pairs of points; empty for a rigid link.
    mass, centre, inertia
        Mass (...), and in the reference configuration centre of mass (..., 3) and inertia about it in global axes
        (..., 3, 3); None if not given, and then that of the beams.
    length
        Given length of a link of two points, (...); None if it is the distance of the points.
    """

    name: str
    points: tuple[str, ...]
    beams: dict[tuple[str, str], LineElement]
    mass: Array | None = None
    centre: Array | None = None
    inertia: Array | None = None
    length: Array | None = None


@dataclass(frozen=True, eq=False)
class Pair:
    """A joint between two links at a point.

    Attributes
    ----------
    name
        Its name.
    kind
        Its kind, an entry of the catalogue.
    point
        Name of its point.
    first, second
        Links that it joins; coordinates are of the second relative to the first.
    axes
        Joint axes in the reference configuration, as columns x y z, (..., 3, 3).
    reference
        Coordinates in the reference configuration, (..., f).
    stiffness
        Given stiffness, (..., 6) in joint axes; None for an ideal joint.
    clearance
        Given clearance, (...); None without clearance.
    pitch
        Advance of a screw per turn, (...); None for other joints.
    contact
        Given contact angle of the journal in the bearing, radians, (...); None if equilibrium determines the contact.
    directions
        Given axis and second axis, (..., 3), of any length; None if they were not given.
    """

    name: str
    kind: Kind
    point: str
    first: str
    second: str
    axes: Array
    reference: Array
    stiffness: Array | None = None
    clearance: Array | None = None
    pitch: Array | None = None
    contact: Array | None = None
    directions: tuple[Array, Array | None] | None = None

    def __getstate__(self) -> dict[str, object]:
        return given_state(self)

    @property
    def is_unturned(self) -> bool:
        """Whether its axes are the global ones in the reference configuration, at all entries."""
        return self.axes.ndim == 2 and bool(self.axes.tolist() == UNTURNED.tolist())

    @cached_property
    def full_stiffness(self) -> Array:
        """Six springs in joint axes, (..., 6): as given, or inf where the joint constrains and 0 where it is free."""
        if self.stiffness is not None:
            return self.stiffness
        constrained, components = self.kind.constrained, ("ux", "uy", "uz", "rx", "ry", "rz")
        springs = np.array([np.inf if name in constrained else 0.0 for name in components])
        springs.setflags(write=False)
        return springs


def about_first(pair: Pair) -> str:
    """Name in frames of the cross of a universal joint, and of the joint between it and the first link."""
    return f"{pair.name}.rz"


@dataclass(frozen=True, eq=False)
class LinkageSpring:
    """A spring with a parallel damper between two points, each ``(link, point)``."""

    first: tuple[str, str]
    second: tuple[str, str]
    stiffness: Array
    length: Array
    damping: Array


@dataclass(frozen=True, eq=False)
class Load:
    """Force and moment (..., 6), global, on a link at a point; `point` is None for a torque.

    A `follower` load rotates with the link, and its components are those in the reference configuration.
    """

    link: str
    point: str | None
    value: Array
    follower: bool = False


def beams_of(
    link: str, points: tuple[str, ...], beam: object, beams: object, places: Mapping[str, Array]
) -> dict[tuple[str, str], LineElement]:
    """The beams of a link by pair of points, from the arguments ``beam=`` and ``beams=`` of the user.

    `places` are the positions of the points in the reference configuration, (..., 3).
    """
    if isinstance(beam, Mapping):
        given = {tuple(pair): value for pair, value in beam.items()}
    elif beam is None and beams is None:
        return {}
    else:
        named = [tuple(pair) for pair in beams] if isinstance(beams, (list, tuple)) else None
        given = dict.fromkeys(neighbours(link, points, places, beam) if named is None else named, beam)
    out: dict[tuple[str, str], LineElement] = {}
    for pair, element in given.items():
        if len(pair) != 2 or pair[0] == pair[1] or any(point not in points for point in pair):
            raise FrameError(f"link {link!r}: beam between {pair}: give two different points of {', '.join(points)}")
        if not isinstance(element, LineElement):
            raise FrameError(
                f"link {link!r}: beam is {element!r}: give a Beam or another LineElement, or no beam for a rigid link"
            )
        out[pair[0], pair[1]] = element
    return out


def inertia_of(link: str, value: ArrayLike) -> Array:
    """Inertia tensor (..., 3, 3) from a tensor, from six numbers xx yy zz xy yz zx, or from one, about z."""
    given = finite(value, f"inertia of link {link!r}")
    if given.shape[-2:] == (3, 3):
        tensor = given
    elif given.shape[-1:] == (6,):
        xx, yy, zz, xy, yz, zx = np.moveaxis(given, -1, 0)
        tensor = np.stack([np.stack(row, axis=-1) for row in ((xx, xy, zx), (xy, yy, yz), (zx, yz, zz))], axis=-2)
    else:
        tensor = np.zeros((*given.shape, 3, 3))
        tensor[..., 2, 2] = given
    # a rotated tensor, R I R^T, is symmetric but for rounding
    skew, size = np.abs(tensor - np.swapaxes(tensor, -1, -2)), np.abs(tensor).max(axis=(-2, -1), keepdims=True)
    if np.any(np.diagonal(tensor, axis1=-2, axis2=-1) < 0.0) or np.any(skew > ROUNDING * size):
        raise FrameError(
            f"link {link!r}: inertia {given.tolist()} is not a tensor of inertia: give a symmetric (3, 3) with a "
            "diagonal that is not negative, six numbers xx yy zz xy yz zx, or one number about z"
        )
    return 0.5 * (tensor + np.swapaxes(tensor, -1, -2))


def unit_vector(value: ArrayLike, what: str) -> Array:
    """A unit vector (..., 3) along one (..., 3), or (..., 2) in the plane z = 0."""
    return _unit(vector(value, what, flat=True), what)


def _unit(given: Array, what: str) -> Array:
    norm = np.linalg.norm(given, axis=-1, keepdims=True)
    if np.any(norm == 0.0):
        raise FrameError(f"{what} is {given.tolist()}: give a direction, such as (0, 0, 1)")
    return np.asarray(given / norm)


def joint_axes(what: str, axis: ArrayLike, second: ArrayLike | None = None) -> Array:
    """`axes_along` directions (..., 3), or (..., 2) in the plane z = 0, which are checked first."""
    x = None if second is None else vector(second, f"second axis of joint {what!r}", flat=True)
    return axes_along(what, vector(axis, f"axis of joint {what!r}", flat=True), x)


def axes_along(what: str, axis: Array, second: Array | None = None) -> Array:
    """Joint axes as columns x y z, (..., 3, 3): z along `axis`, x along `second` or as near to global x as possible.

    If the axis is within some 25° of global x, x is as near to global y as possible.
    """
    if second is None and axis.ndim == 1 and axis.tolist() == [0.0, 0.0, 1.0]:  # as most often
        return np.eye(3)
    z = _unit(axis, f"axis of joint {what!r}")
    if second is None:
        along_x = np.abs(z[..., :1]) > 0.9
        near = np.where(along_x, np.array([0.0, 1.0, 0.0]), np.array([1.0, 0.0, 0.0]))
        x = near - np.sum(near * z, axis=-1, keepdims=True) * z
        x = x / np.linalg.norm(x, axis=-1, keepdims=True)
    else:
        x = _unit(second, f"second axis of joint {what!r}")
        lean = np.sum(x * z, axis=-1, keepdims=True)
        if (skew := np.abs(lean).max()) > ROUNDING:
            raise FrameError(
                f"joint {what!r}: axis and second are not perpendicular (cosine {skew:.2g}): "
                "give the two axes of the cross at a right angle"
            )
        x = _unit(x - lean * z, f"second axis of joint {what!r}")  # axes given with few digits are not perpendicular
    z, x = np.broadcast_arrays(z, x)
    return np.stack([x, crossed(z, x), z], axis=-1)
