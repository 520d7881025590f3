"""Supports, prescribed displacements, offsets in joints, rigid links and ties of a description."""

from __future__ import annotations

from numpy.typing import ArrayLike

from ..batch import ZERO
from ..dofs import DISPLACEMENTS, components, values
from ..errors import FrameError
from ..names import found
from .members import DescribedMembers
from .parts import Tie


class DescribedSupports(DescribedMembers):
    """The part of a description that takes supports, prescribed displacements, joint offsets, rigid links and ties."""

    def rigid(self, master: str, *slaves: str) -> None:
        """Join nodes by rigid links, exactly: they move as one body.

        Parameters
        ----------
        master
            Name of the node that the others follow.
        *slaves
            Names of the nodes that follow, each at the end of a rigid arm.

        Raises
        ------
        FrameError
            If a node is unknown, or tied to itself.

        Examples
        --------
        A force at the end of a rigid arm of 0.1 m is a force and a moment on the node that it follows.

        >>> from linkframe.elements import Beam, Circle, Material
        >>> from linkframe.framework import Frame
        >>> frame = Frame()
        >>> for name, place in {"A": (0.0, 0.0, 0.0), "B": (1.0, 0.0, 0.0), "C": (1.0, 0.1, 0.0)}.items():
        ...     frame.node(name, place)
        >>> frame.add("AB", Beam(Circle(diameter=0.02), Material(E=200e9, nu=0.3)), "A", "B")
        >>> frame.rigid("B", "C"); frame.fix("A"); frame.load("C", fx=100.0)
        >>> frame.solve().reaction("A").round(6).tolist()
        [-100.0, 0.0, 0.0, 0.0, 0.0, 10.0]
        """
        self._tie(master, slaves, tuple(range(6)), rigid=True)

    def tie(self, master: str, slave: str, *names: str) -> None:
        """Make the named global displacement components of two nodes equal (all six where none is named).

        Parameters
        ----------
        master, slave
            Names of the two nodes; they need not coincide, and no arm between them is taken into account.
        *names
            Components ``ux uy uz rx ry rz``.

        Raises
        ------
        FrameError
            If a node or a component is unknown, or a node is tied to itself.

        Examples
        --------
        Two rods side by side whose free ends go up together share the force.

        >>> from linkframe.elements import Beam, Circle, Material
        >>> from linkframe.framework import Frame
        >>> rod, frame = Beam(Circle(diameter=0.02), Material(E=200e9, nu=0.3)), Frame()
        >>> for k, (start, end) in enumerate(("AB", "CD")):
        ...     frame.node(start, (0.0, 0.0, k)); frame.node(end, (1.0, 0.0, k))
        ...     frame.add(start + end, rod, start, end); frame.fix(start)
        >>> frame.tie("B", "D", "uy"); frame.load("B", fy=10.0)
        >>> frame.solve().reactions()[:, 1].round(9).tolist()
        [-5.0, -5.0]
        """
        self._tie(master, (slave,), components(names), rigid=False)

    def fix(self, node: str, *names: str) -> None:
        """Support a node: set displacement components to zero, all six where none is named.

        Parameters
        ----------
        node
            Name of the node.
        *names
            Global displacement components ``ux uy uz rx ry rz``.

        Raises
        ------
        FrameError
            If the node or a component is unknown.

        Examples
        --------
        A hinge about z: everything is constrained but ``rz``.

        >>> from linkframe.framework import Frame
        >>> frame = Frame()
        >>> frame.node("A", (0.0, 0.0, 0.0))
        >>> frame.fix("A", "ux", "uy", "uz", "rx", "ry")
        >>> sorted(frame.supports["A"])
        [0, 1, 2, 3, 4]
        """
        node, zeros = self._node(node, "support"), dict.fromkeys(components(names), ZERO)
        self.supports[node] = {**self.supports.get(node, {}), **zeros}

    def prescribe(self, node: str, **displacement: ArrayLike) -> None:
        """Prescribe displacement components of a node, such as a settlement.

        Parameters
        ----------
        node
            Name of the node.
        **displacement
            Values by component, (...): ``ux uy uz`` in length and ``rx ry rz`` in radians.

        Raises
        ------
        FrameError
            If the node or a component is unknown, or shapes do not broadcast.

        Examples
        --------
        A beam of 2 m whose right support settles by 3 mm turns by 1.5 mrad.

        >>> from linkframe.elements import Beam, Circle, Material
        >>> from linkframe.framework import Frame
        >>> frame = Frame()
        >>> for name, x in {"A": 0.0, "B": 2.0}.items():
        ...     frame.node(name, (x, 0.0, 0.0))
        >>> frame.add("AB", Beam(Circle(diameter=0.02), Material(E=200e9, nu=0.3)), "A", "B")
        >>> frame.fix("A", "ux", "uy", "uz", "rx", "ry"); frame.fix("B", "uz", "rx", "ry")
        >>> frame.prescribe("B", uy=-3e-3)
        >>> frame.solve().displacement("A")[5].round(9).tolist()
        -0.0015
        """
        node = self._node(node, "support")
        given = values(f"support of {node!r}", displacement, DISPLACEMENTS)
        self._join({f"{DISPLACEMENTS[k]} prescribed at {node!r}": value.shape for k, value in given.items()})
        self.supports[node] = {**self.supports.get(node, {}), **given}

    def offset(self, joint: str, **displacement: ArrayLike) -> None:
        """Impose a relative displacement in a joint, in its own axes: clearance, misfit, actuation.

        The joint's springs act on the difference between its displacement and the offset. In a screw joint an imposed
        ``rz`` advances the second node along z by the pitch.

        Parameters
        ----------
        joint
            Name of the joint.
        **displacement
            Displacement of the second node relative to the first by component, (...): ``ux uy uz`` in length and ``rx
            ry rz`` in radians.

        Raises
        ------
        FrameError
            If the joint or a component is unknown, a value is not finite, or shapes do not broadcast.

        Examples
        --------
        A joint that is 0.1 mm out along y lifts the free end of what it carries.

        >>> from linkframe.elements import Beam, Circle, Joint, Material
        >>> from linkframe.framework import Frame
        >>> frame = Frame()
        >>> for name, x in {"A": 0.0, "B": 0.0, "C": 1.0}.items():
        ...     frame.node(name, (x, 0.0, 0.0))
        >>> frame.add("seat", Joint(stiffness=(1e9, 1e9, 1e9, 1e6, 1e6, 1e6)), "A", "B")
        >>> frame.add("BC", Beam(Circle(diameter=0.02), Material(E=200e9, nu=0.3)), "B", "C")
        >>> frame.fix("A"); frame.offset("seat", uy=1e-4)
        >>> frame.solve().displacement("C")[:3].round(9).tolist()
        [0.0, 0.0001, 0.0]
        """
        joint = found("offset joint", joint, self.joints)
        given = values(f"offset of {joint!r}", displacement, DISPLACEMENTS)
        if any(value.ndim and value.shape not in self._shapes for value in given.values()):
            self._join({f"offset {DISPLACEMENTS[k]} of {joint!r}": value.shape for k, value in given.items()})
        self.offsets[joint] = {**self.offsets.get(joint, {}), **given}

    def _tie(self, master: str, slaves: tuple[str, ...], components: tuple[int, ...], *, rigid: bool) -> None:
        master, *others = (self._node(node, "tie") for node in (master, *slaves))
        if master in others:
            raise FrameError(f"node {master!r} is tied to itself: give two different nodes")
        self.ties.extend(Tie(master, slave, components, rigid) for slave in others)
