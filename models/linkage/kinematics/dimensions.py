"""The dimensions of a linkage on its spanning tree: which are constants of its formulas, and which are parameters.

A dimension that is 0, 1 or -1 in the whole batch is a constant of the formulas. Any other is a parameter, and equal
ones share one. Linkages that differ only in the values of their parameters have the same formulas.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ....framework.batch import Array
from ....framework.errors import FrameError
from ..description.linkage_description import LinkageDescription
from ..description.parts import GROUND, Pair
from ..description.sketch import places
from .terms import Value
from .tree import Tree, spanning_tree

EPS = float(np.finfo(np.float64).eps)
# Rounding of the points, as a share of the linkage's size, that leaves too few digits.
FEW_DIGITS = 1e-3


class Parameter(NamedTuple):
    """A dimension that is given when formulas are evaluated: its index among the parameters."""

    place: int


Number = float | Parameter


class Mount(NamedTuple):
    """Placement of a joint on a link, in the link's axes: its axes, None where they are the link's, and its point."""

    axes: tuple[tuple[Number, ...], ...] | None
    point: tuple[Number, ...]


@dataclass(frozen=True, eq=False)
class ReferenceLink:
    """Reference point of a link and its axes as columns, in the reference configuration."""

    place: Array
    reference_axes: Array


class Dimensions:
    """A linkage on a spanning tree, whose joints hold by construction: each link has the axes of its joint there.

    Lengths are divided by `size`, a power of two.

    Parameters
    ----------
    linkage
        The description.
    counted
        A joint whose coordinates must be part of the state, so that their whole turns are counted; or None.
    common
        Whether all members of the batch have one `size`.

    Attributes
    ----------
    tree
        Its spanning tree.
    size
        Power of two near the greatest distance of points in the reference configuration: one number, or one for each
        member of the batch, (...), where they differ, so that no member depends on the size of another.
    parameters
        Dimensions that the programs take, in units of `size`.
    bodies
        Its links, the ground and the twins of links.
    mounts
        By joint and link, the placement of the joint; a link has the axes and the point of the joint that carries it.
    pitches
        Advance of screws per radian, by joint.
    columns
        Joint and component of each velocity coordinate: for a spherical joint the angular velocity in the joint's axes
        on its first link, for others the rate of the coordinate.
    states, velocities
        By joint, the slice of its coordinates in the state, zero in the reference configuration (four Euler parameters
        for a spherical joint), and in the velocity coordinates.
    entries
        Number of entries of the state.
    driven, unknown
        Indices of the driven velocity coordinates, in the order of ``linkage.drives``, and of the others.
    """

    def __init__(self, linkage: LinkageDescription, counted: str | None = None, *, common: bool = False) -> None:
        self.linkage = linkage
        self.tree: Tree = spanning_tree(linkage, counted)
        self.size = _size(linkage, common=common)
        self._refuse_few_digits()
        self.parameters: list[Value] = []
        self._met: dict[tuple[tuple[int, ...], bytes], Parameter] = {}
        self._places: dict[str, dict[str, Array]] = {}
        self._arms: dict[tuple[str, bytes], list[Value]] = {}
        self.bodies: dict[str, ReferenceLink] = {GROUND: self._ground()}
        self.mounts: dict[tuple[str, str], Mount] = {}
        self.pitches: dict[str, Number] = {}
        self.columns: list[tuple[str, str]] = []
        self.states: dict[str, slice] = {}
        self.velocities: dict[str, slice] = {}
        self.entries = 0
        for branch in self.tree.branches:
            pair = branch.edge
            self._mount(pair, branch.parent)
            if pair.pitch is not None:
                advance = pair.pitch / (2.0 * np.pi * self.size)
                self.pitches[pair.name] = self._numbers(advance[..., None] * np.ones(3))[0]
            self.bodies[branch.child] = ReferenceLink(self.place(branch.child, pair.point), pair.axes)
            self._coordinates(pair)
        for pair in self.tree.cuts:
            self._mount(pair, pair.first)
            self._mount(pair, pair.second)
        self.driven = [self.columns.index((name, c)) for name, those in linkage.drives.items() for c in those]
        self.unknown = [k for k in range(len(self.columns)) if k not in self.driven]

    def _ground(self) -> ReferenceLink:
        """The ground with the axes of the first joint on it: in these, a planar linkage has many zero dimensions."""
        if not self.tree.branches:
            return ReferenceLink(np.zeros(3), np.eye(3))
        pair = self.tree.branches[0].edge
        return ReferenceLink(self.place(GROUND, pair.point), pair.axes if pair.axes.ndim == 2 else np.eye(3))

    def _coordinates(self, pair: Pair) -> None:
        kind, start = pair.kind, len(self.columns)
        self.columns += [(pair.name, component) for component in kind.coordinates]
        self.velocities[pair.name] = slice(start, len(self.columns))
        begin = self.entries
        self.entries += 4 if kind.name == "spherical" else len(kind.coordinates)
        self.states[pair.name] = slice(begin, self.entries)

    def formula_key(self) -> tuple[object, ...]:
        """Key of the formulas: everything on which they depend."""
        linkage, tree = self.linkage, self.tree
        return (
            tuple(linkage.links), tuple(linkage.drives.items()),
            tuple((each.edge.name, each.edge.kind, each.parent, each.child, each.sign) for each in tree.branches),
            tuple((pair.name, pair.kind, pair.first, pair.second) for pair in tree.cuts), tuple(tree.twins.items()),
            tuple(self.mounts.items()), tuple(self.pitches.items()),
        )  # fmt: skip

    def place(self, link: str, point: str) -> Array:
        """Position of a point of a link in the reference configuration, (..., 3), with the link's true length."""
        own = self.tree.twins.get(link, link)
        if own not in self._places:
            self._places[own] = places(self.linkage, own)
        return self._places[own][point]

    def arm(self, link: str, place: Array) -> list[Value]:
        """Components, over `size`, of the vector from a link's reference point to a position on it, in the link's axes.

        The position (..., 3) is that in the reference configuration.
        """
        key = link, place.tobytes() if place.ndim == 1 else b""
        if key in self._arms:
            return self._arms[key]
        arm = self._along(self.bodies[link], place)
        components: list[Value] = [arm[..., k] if np.any(arm[..., k]) else 0.0 for k in range(3)]
        if arm.ndim == 1:
            components = arm.tolist()
        if place.ndim == 1:
            self._arms[key] = components
        return components

    @cached_property
    def upright(self) -> bool:
        """Whether the ground's axes are the global ones."""
        return np.array_equal(self.bodies[GROUND].reference_axes, np.eye(3))

    def _mount(self, pair: Pair, link: str) -> None:
        body, axes = self.bodies[link], None
        if not (pair.axes is body.reference_axes or np.array_equal(pair.axes, body.reference_axes)):
            rotated = np.einsum("...ji,...jk->...ik", body.reference_axes, pair.axes)
            axes = tuple(self._numbers(rotated[..., k]) for k in range(3))
        self.mounts[pair.name, link] = Mount(axes, self._numbers(self._along(body, self.place(link, pair.point))))

    def _along(self, body: ReferenceLink, place: Array) -> Array:
        """Components (..., 3), over `size`, of vectors from a link's reference point to positions, in its axes."""
        axes, arm = body.reference_axes, place - body.place
        along = np.asarray(arm @ axes if axes.ndim == 2 else np.einsum("...ji,...j->...i", axes, arm))
        return along / by_component(self.size)

    def _numbers(self, value: Array) -> tuple[Number, ...]:
        """Constants or parameters for three numbers (..., 3) of the description."""
        return tuple(map(self._number, value.tolist() if value.ndim == 1 else np.moveaxis(value, -1, 0)))

    def _number(self, part: float | Array) -> Number:
        for exact in (0.0, 1.0, -1.0):
            off = abs(part - exact) if isinstance(part, float) else float(np.abs(part - exact).max(initial=0.0))
            if off <= self._rounding:
                return exact
        value = np.asarray(part)
        key = value.shape, value.tobytes()
        if key not in self._met:
            self._met[key] = Parameter(len(self.parameters))
            self.parameters.append(float(value) if value.ndim == 0 else np.ascontiguousarray(value))
        return self._met[key]

    @cached_property
    def _rounding(self) -> float:
        return 4.0 * EPS * max([1.0, *(float(np.max(far / self.size, initial=0.0)) for far in self._reach.values())])

    @property
    def _reach(self) -> dict[str, Array]:
        """Largest coordinate of each point in the reference configuration, (...)."""
        return {name: np.abs(point).max(axis=-1) for name, point in self.linkage.points.items()}

    def _refuse_few_digits(self) -> None:
        """Raise an error if the points lie so far from the origin that their distances are rounding."""
        if self._rounding > FEW_DIGITS:
            shares = {name: float(np.max(far / self.size)) for name, far in self._reach.items()}
            name = max(shares, key=shares.__getitem__)
            far = float(self._reach[name].max())
            raise FrameError(
                f"point {name!r} lies {far:.3g} from the origin, where numbers are {np.spacing(far):.2g} apart, so "
                "that points of the linkage coincide which are not meant to: give coordinates from an origin near it"
            )


def by_component(size: float | Array) -> float | Array:
    """A size, which may be one for each member of a batch (...), for division of vectors (..., 3)."""
    return size[..., None] if isinstance(size, np.ndarray) else size


def six_units(first: float | Array, second: float | Array) -> Array:
    """Units (..., 6) of three components and three more, each a number or one for each member of a batch, (...)."""
    return np.stack(np.broadcast_arrays(*[first] * 3, *[second] * 3), axis=-1)


def diagonals(points: Sequence[Array]) -> Array:
    """Diagonal of the bounding box of some points (..., 3), (...); 1 where all of them coincide."""
    if not points:
        return np.ones(())
    corners = np.array(points) if len({each.shape for each in points}) == 1 else np.stack(np.broadcast_arrays(*points))
    size: Array = np.linalg.norm(np.ptp(corners, axis=0), axis=-1)
    return np.where(size > 0.0, size, 1.0)


def _size(linkage: LinkageDescription, *, common: bool) -> float | Array:
    """Power of two just above the extent of the linkage, or of each member of its batch where they differ."""
    sizes: Array = 2.0 ** np.ceil(np.log2(diagonals([*linkage.points.values()])))
    largest = float(sizes.max(initial=0.0)) or 1.0
    return largest if common or bool((sizes == largest).all()) else sizes
