"""Bodies and nodes of a description, and the distances between nodes."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ..batch import Array, rotated, rotation, vector
from ..names import found, new
from .data import DescriptionData
from .parts import Body, Node


class DescribedNodes(DescriptionData):
    """A description whose bodies and nodes are placed."""

    def body(self, name: str, origin: ArrayLike = (0.0, 0.0, 0.0), axes: ArrayLike | None = None) -> None:
        """Name a moving frame of reference, in which nodes may keep constant coordinates over all poses.

        A member between two nodes of one body has its stiffness computed, and its interior condensed, once for all
        poses of the body.

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
        if body is not None:
            body = found(f"node {name!r}: body", body, self.bodies)
        place = vector(coordinates, f"coordinates of node {name!r}")
        self._join({f"node {name!r}": place.shape[:-1]})
        self.nodes[name] = Node(place, body)
        if body is None and place.ndim == 1:
            self.size = max(self.size, *map(abs, place.tolist()))
        elif body is None or self.bodies[body].far + float(np.linalg.norm(place, axis=-1).max(initial=0.0)) > self.size:
            self.size = max(self.size, float(np.abs(self.position(name)).max(initial=0.0)))

    def alias(self, name: str, node: str) -> None:
        """Give a node another name, by which it is loaded, supported and asked for results as well.

        Parameters
        ----------
        name
            Further name, not that of a node.
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
        """Position of a node without loads, in global axes.

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
        at = self.nodes[self._node(node)]
        if at.body is None:
            return at.coordinates
        body = self.bodies[at.body]
        return body.origin + rotated(body.axes, at.coordinates)

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
            Length without loads, (...).

        Raises
        ------
        FrameError
            If the member is unknown.
        """
        length: Array = np.linalg.norm(self.chord(member), axis=-1)
        return length

    def _chord(self, start: str, end: str) -> Array:
        a, b = self.nodes[start], self.nodes[end]
        if a.body == b.body:
            return b.coordinates - a.coordinates
        return self.position(end) - self.position(start)
