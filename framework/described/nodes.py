"""The fields of a frame's description, and the methods that add bodies and nodes to it."""

from __future__ import annotations

import math
from collections.abc import Hashable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..batch import Array, Shape, joined, norms, placed, rotation, vector
from ..errors import FrameError
from ..loads import MemberLoad
from ..names import found, new
from ..provenance import GivenStatus, HasStatus
from .parts import Body, IdleRotation, JointLink, MassPoint, Member, Node, Tie

# Names of the dimensions that results have besides the batch axes; a batch axis cannot take one of them.
TAKEN = ("node", "component", "support", "force", "joint", "status")

# Of up to so many numbers einsum is the quickest.
_FEW = 2**12

# Containers of parts, which a copy of the description copies as well.
_HELD = (dict, list)
# Fields whose values are lists that grow in place, so that a copy needs lists of its own; values of other fields are
# replaced as a whole and can be shared.
_GROWING = ("loads", "member_loads")


@dataclass(eq=False, repr=False)
class DescribedNodes:
    """The fields of a description, and the methods that place bodies and nodes.

    Every call that adds a part broadcasts its batch shape with that of the frame. `linkframe.framework.Frame` lists
    the attributes.
    """

    bodies: dict[str, Body] = field(default_factory=dict)
    nodes: dict[str, Node] = field(default_factory=dict)
    members: dict[str, Member] = field(default_factory=dict)
    joints: dict[str, JointLink] = field(default_factory=dict)
    masses: dict[str, MassPoint] = field(default_factory=dict)
    aliases: dict[str, str] = field(default_factory=dict)
    node_sets: dict[str, list[str]] = field(default_factory=dict)
    element_sets: dict[str, list[str]] = field(default_factory=dict)
    ties: list[Tie] = field(default_factory=list)
    supports: dict[str, Mapping[int, Array]] = field(default_factory=dict)
    offsets: dict[str, Mapping[int, Array]] = field(default_factory=dict)
    idle: dict[str, IdleRotation] = field(default_factory=dict)
    loads: dict[str, list[tuple[int, Array]]] = field(default_factory=dict)
    member_loads: dict[str, list[MemberLoad]] = field(default_factory=dict)
    weight: Array | None = None
    absent: NDArray[np.bool_] | None = None
    made_from: HasStatus | None = field(default=None, repr=False, compare=False)
    shape: Shape = field(default=(), init=False)
    _shapes: dict[Shape, str] = field(default_factory=dict, repr=False)  # and what was given in it first
    _examined: dict[Hashable, str] = field(default_factory=dict, repr=False, compare=False)
    size: float = 0.0
    tolerance: float = 0.0
    axes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if self.axes:
            self._check_axes()

    def _check_axes(self) -> None:
        given = self.axes
        if not isinstance(given, tuple) or not all(isinstance(name, str) and name for name in given):
            raise FrameError(f'axes is {given!r}: give names of the batch axes, such as ("pose", "sample")')
        for name in given:
            if name in TAKEN or given.count(name) > 1:
                why = "is that of another dimension of results" if name in TAKEN else "stands twice"
                raise FrameError(f"axes is {given!r}, in which {name!r} {why}: give each batch axis a name of its own")

    def copy(self) -> Self:
        """Independent copy.

        Returns
        -------
        same type
            Later changes of the one do not affect the other. Arrays are shared.
        """
        clone = object.__new__(type(self))
        parts = clone.__dict__
        parts.update({name: value.copy() if type(value) in _HELD else value for name, value in vars(self).items()})
        for name in _GROWING:
            if parts[name]:
                parts[name] = {key: each.copy() for key, each in parts[name].items()}
        return clone

    __copy__ = copy

    def __getstate__(self) -> dict[str, object]:
        """The fields to pickle: of `made_from` only its status, and no record of which elements were checked."""
        made_from = None if self.made_from is None else GivenStatus(self.made_from.status, self.made_from.is_regular)
        return vars(self) | {"_examined": {}, "made_from": made_from}

    # -- bodies and nodes ---------------------------------------------------------------------------------------------

    def body(self, name: str, origin: ArrayLike = (0.0, 0.0, 0.0), axes: ArrayLike | None = None) -> None:
        """Define a body: a moving frame of reference in which nodes have constant coordinates over all poses.

        The stiffness of a member between two nodes of one body is computed, and its inner nodes are condensed, once for
        all poses of the body.

        Parameters
        ----------
        name
            Name of the body.
        origin
            Global position of its origin, (..., 3).
        axes
            Its axes as columns in global components, (..., 3, 3); the global axes where None.

        Raises
        ------
        FrameError
            If the name is taken, `axes` are not orthonormal and right-handed, or shapes do not broadcast.

        Examples
        --------
        A crank of 0.1 m at three angles: its end stays where it is in the crank's axes.

        >>> import numpy as np
        >>> from linkframe.framework import Frame
        >>> angle = np.radians([0.0, 90.0, 180.0])
        >>> c, s, o = np.cos(angle), np.sin(angle), np.zeros(3)
        >>> frame = Frame()
        >>> frame.body("crank", axes=np.moveaxis(np.array([[c, -s, o], [s, c, o], [o, o, o + 1.0]]), -1, 0))
        >>> frame.node("B", (0.1, 0.0, 0.0), body="crank")
        >>> frame.position("B").round(3).tolist()
        [[0.1, 0.0, 0.0], [0.0, 0.1, 0.0], [-0.1, 0.0, 0.0]]
        """
        name = new("body", name, self.bodies)
        place = vector(origin, f"origin of body {name!r}")
        turn = np.eye(3) if axes is None else rotation(axes, f"axes of body {name!r}")
        self._join({f"origin of body {name!r}": place.shape[:-1], f"axes of body {name!r}": turn.shape[:-2]})
        self.bodies[name] = Body(place, turn)

    def node(self, name: str, coordinates: ArrayLike, body: str | None = None) -> None:
        """Place a node.

        Parameters
        ----------
        name
            Name of the node.
        coordinates
            Position (..., 3), length, in the axes of `body` or global.
        body
            Name of the body that carries the node; global coordinates where None.

        Raises
        ------
        FrameError
            If the name is taken, the body unknown, a coordinate is not finite, or shapes do not broadcast.

        Examples
        --------
        Two nodes, the second at three heights.

        >>> from linkframe.framework import Frame
        >>> frame = Frame()
        >>> frame.node("A", (0.0, 0.0, 0.0))
        >>> frame.node("B", [(1.0, 0.0, 0.0), (1.0, 0.1, 0.0), (1.0, 0.2, 0.0)])
        >>> frame.shape
        (3,)
        """
        name = new("node", name, self.nodes, self.aliases)
        if body is not None and not (type(body) is str and body in self.bodies):
            body = found(f"node {name!r}: body", body, self.bodies)
        self._put(name, vector(coordinates, f"coordinates of node {name!r}"), body)

    def _put(self, name: str, place: Array, body: str | None) -> None:
        """Add a node whose name, place and body are known to be right."""
        if place.ndim > 1:
            self._join({f"node {name!r}": place.shape[:-1]})
        self.nodes[name] = Node(place, body)
        if body is None and place.ndim == 1:
            self.size = max(self.size, *map(abs, place.tolist()))
        elif body is None or self.bodies[body].far + _farthest(place) > self.size:
            there = self._place(name)
            if there.ndim == 1:
                self.size = max(self.size, *map(abs, there.tolist()))
            else:
                self.size = max(self.size, float(there.max(initial=0.0)), -float(there.min(initial=0.0)))

    def alias(self, name: str, node: str) -> None:
        """Give a node a second name, for loads, supports and results.

        Parameters
        ----------
        name
            The second name.
        node
            Name of the node.

        Raises
        ------
        FrameError
            If the name is taken or the node unknown.

        Examples
        --------
        >>> from linkframe.framework import Frame
        >>> frame = Frame()
        >>> frame.node("B", (1.0, 0.0, 0.0)); frame.alias("tip", "B")
        >>> frame.position("tip").tolist()
        [1.0, 0.0, 0.0]
        """
        name = new("node", name, self.nodes, self.aliases)
        self.aliases[name] = self._node(node)

    def position(self, node: str) -> Array:
        """Position of a node in the undeformed frame, in global axes.

        Parameters
        ----------
        node
            Name of the node.

        Returns
        -------
        ndarray
            Coordinates x y z, (..., 3), length.

        Raises
        ------
        FrameError
            If the node is unknown.
        """
        return self._place(self._node(node))

    def _place(self, node: str) -> Array:
        at = self.nodes[node]
        if at.body is None:
            return at.coordinates
        body = self.bodies[at.body]
        return placed(body.origin, body.axes, at.coordinates)

    def chord(self, member: str) -> Array:
        """Vector from start to end of a member, in the axes of its body where both ends share one, else global.

        Parameters
        ----------
        member
            Name of the member.

        Returns
        -------
        ndarray
            Components, (..., 3), length.

        Raises
        ------
        FrameError
            If the member is unknown.
        """
        ends = self.members[self._member(member)]
        return self._chord(ends.start, ends.end)

    def length(self, member: str) -> Array:
        """Distance between the two nodes of a member.

        Parameters
        ----------
        member
            Name of the member.

        Returns
        -------
        ndarray
            Length of the undeformed member, (...).

        Raises
        ------
        FrameError
            If the member is unknown.
        """
        return norms(self.chord(member))

    def _chord(self, start: str, end: str) -> Array:
        a, b = self.nodes[start], self.nodes[end]
        if a.body == b.body:
            return b.coordinates - a.coordinates
        return self._place(end) - self._place(start)

    # -- names and shapes -------------------------------------------------------------------------------------------

    def _node(self, name: str, of: str = "") -> str:
        if type(name) is str and name in self.nodes:  # as most often; no alias is the name of a node
            return name
        return found(f"{of} node".strip(), name, self.nodes, self.aliases)

    def _nodes(self, names: Iterable[str], of: str) -> tuple[str, ...]:
        return tuple([self._node(name, of) for name in names])

    def _member(self, name: str, of: str = "") -> str:
        if type(name) is str and name in self.members:
            return name
        return found(f"{of} member".strip(), name, self.members)

    def _join(self, given: Mapping[str, Shape]) -> None:
        """Broadcast the batch with the shapes that one call gives, by name; unchanged if one of them does not fit."""
        self.shape, self._shapes = self._widened(given)

    def _widened(self, given: Mapping[str, Shape]) -> tuple[Shape, dict[Shape, str]]:
        """The batch shape broadcast with the shapes that one call gives, by name; and the first name of each shape."""
        whole, known = self.shape, self._shapes
        if not any(given.values()):
            return whole, known
        for name, shape in given.items():
            if shape and shape not in known:
                if self.axes and len(shape) > len(self.axes):
                    raise FrameError(
                        f"{name} has the shape {shape}, and {len(self.axes)} batch axes have names: {self.axes}"
                    )
                for other, what in known.items():
                    joined(name, shape, {what: other})
                whole, known = np.broadcast_shapes(whole, shape), {**known, shape: name}
        return whole, known


def _farthest(places: Array) -> float:
    """The greatest distance of positions (..., 3) from the origin."""
    if places.ndim == 1:
        return math.hypot(*places.tolist())
    if places.size > _FEW:
        return float(norms(places).max(initial=0.0))
    return math.sqrt(np.einsum("...i,...i->...", places, places).max(initial=0.0))
