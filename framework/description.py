"""The description of a frame: nodes, members, joints, supports and loads, each number possibly a batch."""

from __future__ import annotations

import copy
from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .added_forms import AddedForm, FormLoad
from .batch import Array, Shape, aligned, distinct, finite, joined, rotated, rotation, unvaried, vector
from .dofs import DISPLACEMENTS, FORCES, components, values
from .errors import FrameError
from .examination import examine_joint, examine_mass, examine_member
from .formed import FormedElement
from .listing import html_table
from .loads import LineLoad, MemberLoad, PointLoad
from .names import found, new, plain
from .protocol import JointElement, LineElement, PointElement, is_proven
from .provenance import GivenStatus, HasStatus

# Two nodes of a joint coincide when their distance is below this share of the frame's size.
COINCIDENT = 1e-9

# Dimensions of results beside the batch axes.
TAKEN = ("node", "component", "support", "force", "joint", "status")

# What stands for all members.
_ALL = "beam"

# What is held by name and may grow under that name.
_GROWING = ("supports", "offsets", "loads", "member_loads")


@dataclass(frozen=True)
class Body:
    """A moving frame of reference: global position = origin + axes @ local position."""

    origin: Array
    axes: Array

    @cached_property
    def far(self) -> float:
        """Largest coordinate of its origin, over the batch."""
        return float(np.abs(self.origin).max(initial=0.0))


@dataclass(frozen=True)
class Node:
    """A point with six degrees of freedom; coordinates (..., 3) in the axes of `body`, global where it is None."""

    coordinates: Array
    body: str | None


@dataclass(frozen=True)
class Member:
    """A line element between two nodes."""

    element: LineElement
    start: str
    end: str


@dataclass(frozen=True)
class JointLink:
    """A joint element between two coincident nodes."""

    element: JointElement
    first: str
    second: str


@dataclass(frozen=True)
class MassPoint:
    """Inertia at a node."""

    element: PointElement
    node: str


@dataclass(frozen=True)
class Tie:
    """Components of `slave` that equal those of `master`; all six, with the arm between them, where `rigid`."""

    master: str
    slave: str
    components: tuple[int, ...]
    rigid: bool


@dataclass(eq=False, repr=False)
class Description:
    """What a frame is made of and what acts on it: data alone, which nothing here solves.

    `linkframe.framework.Frame`, which a user describes, is one that answers as well; its docstring tells of the
    attributes.
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
    supports: dict[str, dict[int, Array]] = field(default_factory=dict)
    offsets: dict[str, dict[int, Array]] = field(default_factory=dict)
    loads: dict[str, list[tuple[int, Array]]] = field(default_factory=dict)
    member_loads: dict[str, list[MemberLoad]] = field(default_factory=dict)
    weight: Array | None = None
    absent: NDArray[np.bool_] | None = None
    made_from: HasStatus | None = field(default=None, repr=False, compare=False)
    _shapes: dict[Shape, str] = field(default_factory=dict, repr=False)  # and what was given in it first
    _shape: Shape = ()
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

    @property
    def shape(self) -> Shape:
        """Batch shape: the broadcast of all that has been described."""
        return self._shape

    # -- geometry ---------------------------------------------------------------------------------------------------

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
        """Give a node another name, by which it is loaded, held and asked for results as well.

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

    # -- elements ---------------------------------------------------------------------------------------------------

    def add(self, name: str, element: LineElement | JointElement | PointElement, *nodes: str) -> None:
        """Add a beam between two nodes, a joint between two coincident nodes, or a mass at one node.

        Parameters
        ----------
        name
            Name of the member, joint or mass.
        element
            What is added, such as a `linkframe.elements.Beam`, `Joint`, `Spring` or `PointMass`; its parameters may
            carry a batch. Of an element that is not linkframe's own, what it returns is put to the test.
        *nodes
            Names of its nodes, start (first) before end (second).

        Raises
        ------
        FrameError
            If the name is taken, a node is unknown or named twice, a member has no length, a joint's nodes do not
            coincide, or an element of one's own does not return what the protocol asks.

        Examples
        --------
        Two rods with a hinge about z between them, and a flywheel.

        >>> from linkframe.elements import Beam, Circle, Joint, Material, PointMass
        >>> from linkframe.framework import Frame
        >>> rod = Beam(Circle(diameter=0.02), Material(E=200e9, nu=0.3))
        >>> frame = Frame()
        >>> for name, x in {"A": 0.0, "B": 1.0, "C": 1.0, "D": 2.0}.items():
        ...     frame.node(name, (x, 0.0, 0.0))
        >>> frame.add("AB", rod, "A", "B"); frame.add("CD", rod, "C", "D")
        >>> frame.add("hinge", Joint(stiffness=(1e9, 1e9, 1e9, 1e6, 1e6, 0.0)), "B", "C")
        >>> frame.add("flywheel", PointMass(2.0, inertia=(0.1, 0.1, 0.2)), "D")
        >>> sorted(frame.members), sorted(frame.joints), sorted(frame.masses)
        (['AB', 'CD'], ['hinge'], ['flywheel'])
        """
        name = new("element", name, self.members, self.joints, self.masses)
        if not isinstance(element, (LineElement, JointElement, PointElement)):
            raise FrameError(f"element {name!r} is {element!r}: give a beam, a joint or a mass, such as Beam(...)")
        wanted = 1 if isinstance(element, PointElement) else 2
        if len(nodes) != wanted:
            kind = type(element).__name__
            raise FrameError(f"{name!r} was given {len(nodes)} nodes {nodes}: a {kind} takes {wanted}")
        nodes = tuple(self._node(node, f"{name!r}") for node in nodes)
        if wanted == 2 and nodes[0] == nodes[1]:
            raise FrameError(f"{name!r} begins and ends at node {nodes[0]!r}: give two different nodes")
        if isinstance(element, LineElement):
            self._check_length(name, *nodes)
            element.check(self._chord(*nodes))
            kinds = self._examine(name, element, nodes)
            self._join({f"member {name!r}": element.shape})
            self.members[name] = Member(element, *nodes)
            self._examined |= kinds
        elif isinstance(element, JointElement):
            self._check_coincident(name, *nodes)
            if not is_proven(element):
                examine_joint(name, element)
            check_ideal(name, element)
            self._join({f"joint {name!r}": element.shape})
            self.joints[name] = JointLink(element, *nodes)
        else:
            if not is_proven(element):
                examine_mass(name, element)
            self._join({f"mass {name!r}": element.shape})
            self.masses[name] = MassPoint(element, *nodes)

    def add_form(
        self,
        form: object,
        on: str | Sequence[str],
        *,
        into: str | None = None,
        intorder: int | None = None,
        **parameters: ArrayLike,
    ) -> None:
        """Add a scikit-fem form to members: an elastic foundation, an added mass, a strain by heat, a load.

        The form is integrated over the shape functions of each member. It sees the displacement in the member's own
        axes, ``u[0]`` to ``u[5]`` for ``ux uy uz rx ry rz``, its derivative along the member, ``u.grad[0]`` to
        ``u.grad[5]``, and in ``w`` the parameters, the distance ``w.x[0]`` from the member's start and the length
        ``w.h`` of its segment. It belongs to the members that there are when it is added, and takes part in statics,
        modes, buckling, error bounds, sensitivity and, as long as a rigid motion costs no energy, large displacement.

        Parameters
        ----------
        form
            ``skfem.BilinearForm``, symmetric and positive semidefinite at each point, or ``skfem.LinearForm``.
        on
            A member, a body or a link (all members on it), ``"beam"`` for all members, or several of these.
        into
            Where it goes: a bilinear form into the ``stiffness`` (where None) or the ``mass``, a linear form into the
            ``load``. Gravity does not weigh such a mass.
        intorder
            Order of integration as scikit-fem's, along each segment; that of the member's own matrices where None.
        **parameters
            What the form finds in ``w``, each a number or a batch of numbers, (...).

        Raises
        ------
        FrameError
            If `on` names nothing, if the form fails, is not symmetric or not positive semidefinite, or if a parameter
            is no finite number or does not fit the batch.

        Examples
        --------
        A beam on an elastic foundation, pushed down evenly: it sinks by the load over the modulus.

        >>> import skfem
        >>> from linkframe.elements import Beam, Material, Rectangle
        >>> from linkframe.framework import Frame
        >>> frame = Frame()
        >>> for name, x in {"A": 0.0, "B": 2.0}.items():
        ...     frame.node(name, (x, 0.0, 0.0))
        >>> frame.add("AB", Beam(Rectangle(y=0.02, z=0.01), Material(E=200e9, nu=0.3)), "A", "B")
        >>> frame.fix("A", "ux", "uz", "rx", "ry")
        >>> foundation = skfem.BilinearForm(lambda u, v, w: w.k * u[1] * v[1])
        >>> frame.add_form(foundation, on="AB", k=[1e4, 2e4])
        >>> frame.line_load("AB", fy=-30.0)
        >>> frame.solve().displacement("B")[:, 1].round(9)
        array([-0.003 , -0.0015])
        """
        names = self.members_on(on, "add_form")
        lengths = {name: self.length(name) for name in names}
        ndim = max(length.ndim for length in lengths.values())
        stacked = np.stack(np.broadcast_arrays(*(aligned(length, ndim) for length in lengths.values())))
        values = {name: finite(value, f"add_form: parameter {name}") for name, value in parameters.items()}
        widened = self._widened({f"parameter {name} of a form": value.shape for name, value in values.items()})
        added = AddedForm.of(form, into, stacked, values, intorder)
        apart = added.placed and added.strains
        members = [self.members[name] for name in names]
        leaders, which = distinct([member.element for member in members])
        if apart:
            leaders, which = list(range(len(names))), np.arange(len(names))
        made: list[LineElement] = []
        examined: set[object] = set()
        for k in leaders:
            member = members[k]
            made.append(FormedElement.of(member.element, added, lengths[names[k]] if apart else None))
            # what the form makes of one proven element it makes of all of that class
            kind = type(member.element) if is_proven(member.element) else k
            if made[-1] is not member.element and kind not in examined:
                examine_member(names[k], made[-1], self._chord(member.start, member.end))
                examined.add(kind)
        self._shape, self._shapes = widened
        for name, member, number in zip(names, members, which.tolist(), strict=True):
            self.members[name] = replace(member, element=made[number])
            if added.pushes:
                self.member_loads.setdefault(name, []).append(FormLoad(added))

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

    def members_on(self, on: str | Sequence[str], what: str = "members_on") -> list[str]:
        """Look up the members that names of members and bodies stand for, each once.

        Parameters
        ----------
        on
            Name of a member, of a body (all members on it), ``"beam"`` for all members, or several of these.
        what
            What asks, for messages.

        Returns
        -------
        list of str
            Names of the members.

        Raises
        ------
        FrameError
            If a name is unknown, or a body has no members on it.
        """
        chosen: dict[str, None] = {}
        for each in [on] if isinstance(on, str) else on:
            name = plain(f"{what}: on", each)
            if name in self.members:
                chosen[name] = None
                continue
            if name != _ALL:
                found(f"{what}: on", name, [*self.members, *self.bodies, _ALL])
            for key, member in self.members.items():
                if name == _ALL or self.nodes[member.start].body == name == self.nodes[member.end].body:
                    chosen[key] = None
        if not chosen:
            raise FrameError(f"{what}: there is no member on {on!r}: add members first")
        return list(chosen)

    # -- supports and loads -----------------------------------------------------------------------------------------

    def fix(self, node: str, *names: str) -> None:
        """Hold components of a node at zero; all six where none is named.

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
        A hinge about z: everything is held but ``rz``.

        >>> from linkframe.framework import Frame
        >>> frame = Frame()
        >>> frame.node("A", (0.0, 0.0, 0.0))
        >>> frame.fix("A", "ux", "uy", "uz", "rx", "ry")
        >>> sorted(frame.supports["A"])
        [0, 1, 2, 3, 4]
        """
        node, zeros = self._node(node, "support"), {index: np.zeros(()) for index in components(names)}
        self.supports.setdefault(node, {}).update(zeros)

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
        self.supports.setdefault(node, {}).update(given)

    def offset(self, joint: str, **displacement: ArrayLike) -> None:
        """Impose a relative displacement in a joint, in its own axes: clearance, misfit, actuation.

        The joint's springs act on what its displacement differs from the offset; an imposed turn drives a screw.

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
        self._join({f"offset {DISPLACEMENTS[k]} of {joint!r}": value.shape for k, value in given.items()})
        self.offsets.setdefault(joint, {}).update(given)

    def load(self, node: str, **force: ArrayLike) -> None:
        """Apply a force or moment at a node, in global axes; loads add up.

        Parameters
        ----------
        node
            Name of the node.
        **force
            Values by component: force ``fx fy fz`` and moment ``mx my mz``; each may carry a batch, (...).

        Raises
        ------
        FrameError
            If the node or a component is unknown, a value is not finite, or shapes do not broadcast.

        Examples
        --------
        A force on the tip of a cantilever in five load cases, and its moment at the clamp.

        >>> import numpy as np
        >>> from linkframe.elements import Beam, Circle, Material
        >>> from linkframe.framework import Frame
        >>> frame = Frame()
        >>> for name, x in {"A": 0.0, "B": 0.5}.items():
        ...     frame.node(name, (x, 0.0, 0.0))
        >>> frame.add("AB", Beam(Circle(diameter=0.02), Material(E=200e9, nu=0.3)), "A", "B")
        >>> frame.fix("A"); frame.load("B", fy=np.linspace(0.0, 40.0, 5))
        >>> frame.solve().reaction("A")[:, 5].round(9).tolist()
        [0.0, -5.0, -10.0, -15.0, -20.0]
        """
        node = self._node(node, "load")
        given = values(f"load at {node!r}", force, FORCES)
        self._join({f"{FORCES[k]} at {node!r}": value.shape for k, value in given.items()})
        self.loads.setdefault(node, []).extend(given.items())

    def line_load(
        self, member: str, *, local: bool = False, span: tuple[float, float] | None = None, **force: ArrayLike
    ) -> None:
        """Apply a force per length to a member.

        Parameters
        ----------
        member
            Name of the member.
        local
            Components in the member's own axes instead of the global ones.
        span
            Distances from the member's start between which the load acts; the whole length where None.
        **force
            Force per length by component, ``fx fy fz``, (...); a tuple ``(start, end)`` varies linearly over the span.

        Raises
        ------
        FrameError
            If the member or a component is unknown, the span is not on the member, or shapes do not broadcast.

        Examples
        --------
        A cantilever of 1 m under 100 N/m, ``M = q L^2 / 2`` at the clamp (Timoshenko, *Strength of Materials* I), and
        under a load that falls to zero at the tip, ``M = q L^2 / 6``.

        >>> from linkframe.elements import Beam, Circle, Material
        >>> from linkframe.framework import Frame
        >>> def clamp(force):
        ...     frame = Frame()
        ...     for name, x in {"A": 0.0, "B": 1.0}.items():
        ...         frame.node(name, (x, 0.0, 0.0))
        ...     frame.add("AB", Beam(Circle(diameter=0.02), Material(E=200e9, nu=0.3)), "A", "B")
        ...     frame.fix("A"); frame.line_load("AB", fy=force)
        ...     return float(frame.solve().reaction("A")[5].round(6))
        >>> clamp(-100.0), clamp((-100.0, 0.0))
        (50.0, 16.666667)
        """
        member = self._member(member, "line load")
        pairs = {k: v if isinstance(v, tuple) and len(v) == 2 else (v, v) for k, v in force.items()}
        what = f"line load on {member!r}"
        start, end = (values(what, {k: pair[side] for k, pair in pairs.items()}, FORCES[:3]) for side in (0, 1))
        stretch = None if span is None else self._span(member, span)
        starts = {f"{FORCES[k]} at the start of the {what}": value.shape for k, value in start.items()}
        self._join(starts | {f"{FORCES[k]} at the end of the {what}": value.shape for k, value in end.items()})
        load = LineLoad(_stacked(start, 3), _stacked(end, 3), stretch, local)
        self.member_loads.setdefault(member, []).append(load)

    def point_load(self, member: str, *, at: float, local: bool = False, **force: ArrayLike) -> None:
        """Apply a force or moment to a point of a member.

        Parameters
        ----------
        member
            Name of the member.
        at
            Distance from the member's start, length, from 0 to that of the member.
        local
            Components in the member's own axes instead of the global ones.
        **force
            Values by component: force ``fx fy fz`` and moment ``mx my mz``, (...).

        Raises
        ------
        FrameError
            If the member or a component is unknown, `at` is not on the member, or shapes do not broadcast.

        Examples
        --------
        >>> from linkframe.elements import Beam, Circle, Material
        >>> from linkframe.framework import Frame
        >>> frame = Frame()
        >>> for name, x in {"A": 0.0, "B": 1.0}.items():
        ...     frame.node(name, (x, 0.0, 0.0))
        >>> frame.add("AB", Beam(Circle(diameter=0.02), Material(E=200e9, nu=0.3)), "A", "B")
        >>> frame.fix("A"); frame.point_load("AB", at=0.25, fy=-100.0)
        >>> float(frame.solve().reaction("A")[5].round(9))
        25.0
        """
        member = self._member(member, "point load")
        given = values(f"point load on {member!r}", force, FORCES)
        place = unvaried(at)
        if place is None or not 0.0 <= place <= self._least_length(member):
            raise FrameError(f"point load on {member!r} at {at!r}: give one distance within its length")
        self._join({f"{FORCES[k]} of the point load on {member!r}": value.shape for k, value in given.items()})
        self.member_loads.setdefault(member, []).append(PointLoad(float(place), _stacked(given, 6), local))

    def gravity(self, acceleration: ArrayLike) -> None:
        """Load all members and masses with their weight.

        Parameters
        ----------
        acceleration
            Acceleration of gravity, global, (..., 3), length per time squared, such as ``(0, 0, -9.81)``.

        Raises
        ------
        FrameError
            If these are not three finite numbers, or shapes do not broadcast.

        Examples
        --------
        >>> from linkframe.elements import PointMass
        >>> from linkframe.framework import Frame
        >>> frame = Frame()
        >>> frame.node("A", (0.0, 0.0, 0.0)); frame.fix("A")
        >>> frame.add("block", PointMass(2.0), "A")
        >>> frame.gravity((0.0, 0.0, -9.81))
        >>> float(frame.solve().reaction("A")[2].round(9))
        19.62
        """
        weight = vector(acceleration, "gravity")
        self._join({"gravity": weight.shape[:-1]})
        self.weight = weight

    def exclude(self, where: ArrayLike) -> None:
        """Leave batch entries out, such as poses that a linkage cannot take.

        They must be described all the same, by any numbers; their status is ``absent`` and their results are NaN.

        Parameters
        ----------
        where
            True for the entries to leave out, (...).

        Raises
        ------
        FrameError
            If `where` does not broadcast with the batch.

        Examples
        --------
        >>> from linkframe.framework import Frame
        >>> frame = Frame()
        >>> frame.node("A", (0.0, 0.0, 0.0)); frame.fix("A")
        >>> frame.load("A", fx=[1.0, 2.0, 3.0]); frame.exclude([False, True, False])
        >>> frame.solve().status.tolist()
        ['regular', 'absent', 'regular']
        """
        left = np.array(where)
        if left.dtype != np.bool_:
            raise FrameError(f"exclude was given {where!r}: give True for the entries to leave out")
        self._join({"entries left out": left.shape})
        self.absent = left if self.absent is None else self.absent | left

    def copy(self) -> Self:
        """Independent copy.

        Returns
        -------
        same type
            The description as it is now; what is added to either later is not in the other. Arrays are shared.
        """
        clone = object.__new__(type(self))
        for name, value in vars(self).items():
            setattr(clone, name, value)
            if isinstance(value, dict):
                components = dict(value)
                if name in _GROWING:
                    components = {key: copy.copy(v) for key, v in value.items()}
                setattr(clone, name, components)
            elif isinstance(value, list):
                setattr(clone, name, list(value))
        return clone

    __copy__ = copy

    def __getstate__(self) -> dict[str, object]:
        """What another process needs."""
        made_from = None if self.made_from is None else GivenStatus(self.made_from.status, self.made_from.is_regular)
        return vars(self) | {"_examined": {}, "made_from": made_from}

    def __repr__(self) -> str:
        parts = {"node": len(self.nodes), "member": len(self.members), "joint": len(self.joints)}
        counts = ", ".join(f"{count} {name}{'' if count == 1 else 's'}" for name, count in parts.items())
        return f"<Frame of shape {self.shape}: {counts}>"

    def _repr_html_(self) -> str:
        """In a notebook: what there is of each kind, by name."""
        rows = [
            *([name, "member", f"{ends.start} to {ends.end}"] for name, ends in self.members.items()),
            *([name, "joint", f"{ends.first} to {ends.second}"] for name, ends in self.joints.items()),
            *(
                [name, "support", " ".join(DISPLACEMENTS[k] for k in sorted(components))]
                for name, components in self.supports.items()
            ),
            *([name, "load", " ".join(sorted({FORCES[k] for k, _ in given}))] for name, given in self.loads.items()),
        ]
        return html_table(repr(self).strip("<>"), ["name", "what", "where"], rows)

    # -- checks -----------------------------------------------------------------------------------------------------

    def _node(self, name: str, of: str = "") -> str:
        what = f"{of} node".strip()
        return found(what, self.aliases.get(plain(what, name), name), self.nodes)

    def _member(self, name: str, of: str = "") -> str:
        return found(f"{of} member".strip(), name, self.members)

    def _join(self, given: Mapping[str, Shape]) -> None:
        """Widen the batch by the shapes of what one call gives: by all of them, or by none where one does not fit."""
        self._shape, self._shapes = self._widened(given)

    def _widened(self, given: Mapping[str, Shape]) -> tuple[Shape, dict[Shape, str]]:
        """The batch, and what was given in each shape, with the shapes of what one call gives."""
        whole, known = self._shape, self._shapes
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

    def _chord(self, start: str, end: str) -> Array:
        a, b = self.nodes[start], self.nodes[end]
        if a.body == b.body:
            return b.coordinates - a.coordinates
        return self.position(end) - self.position(start)

    def _examine(self, name: str, element: LineElement, nodes: tuple[str, ...]) -> dict[Hashable, str]:
        """Put an element to the test that no tests of its own prove, one of each kind; that kind, and the name."""
        if is_proven(element):
            return {}
        kind = type(element), element.kind
        try:
            known = kind in self._examined
        except TypeError:  # it cannot be hashed, which the test refuses
            known = False
        if not known:
            examine_member(name, element, self._chord(nodes[0], nodes[1]))
        return {} if known else {kind: name}

    def _check_length(self, name: str, start: str, end: str) -> None:
        chord = self._chord(start, end)
        if chord.ndim == 1 and any(part * part > 0.0 for part in chord.tolist()):
            return
        length = np.linalg.norm(chord, axis=-1)
        if np.any(length <= 0.0):
            where = f" at batch entry {np.argwhere(length <= 0)[0].tolist()}" if length.ndim else ""
            raise FrameError(f"member {name!r} has zero length{where}: nodes {start!r} and {end!r} coincide")

    def _check_coincident(self, name: str, first: str, second: str) -> None:
        apart = self.position(second) - self.position(first)
        if apart.ndim == 1 and not any(apart.tolist()):
            return
        gaps = np.linalg.norm(apart, axis=-1)
        # Entries that are left out may lie anyhow.
        gap = float(np.max(gaps if self.absent is None else np.where(self.absent, 0.0, gaps), initial=0.0))
        if gap > max(COINCIDENT * self.size, self.tolerance):
            raise FrameError(
                f"joint {name!r} joins nodes {first!r} and {second!r}, which are {gap:.6g} apart: "
                "place them at one point, or put a rigid link or a beam between them"
            )

    def _least_length(self, member: str) -> float:
        """The length of a member over which loads may lie: the least of the batch, and the rounding in it."""
        return float(self.length(member).min(initial=np.inf)) * (1.0 + 1e-12)

    def _span(self, member: str, span: tuple[float, float]) -> tuple[float, float]:
        ends, length = unvaried(span, (2,)), self._least_length(member)
        if ends is None or not 0.0 <= ends[0] < ends[1] <= length:
            wanted = f"two distances 0 <= x1 < x2 <= its length {length:.6g}"
            raise FrameError(f"line load on {member!r} spans {span!r}: give {wanted}")
        return float(ends[0]), float(ends[1])

    def _tie(self, master: str, slaves: tuple[str, ...], components: tuple[int, ...], *, rigid: bool) -> None:
        master, *others = (self._node(node, "tie") for node in (master, *slaves))
        if master in others:
            raise FrameError(f"node {master!r} is tied to itself: give two different nodes")
        self.ties.extend(Tie(master, slave, components, rigid) for slave in others)


def alone(frame: Description) -> Description:
    """The same description, dicts and all, which does not tell what it was made from."""
    if frame.made_from is None:
        return frame
    clone = object.__new__(type(frame))
    for name, value in vars(frame).items():
        setattr(clone, name, value)
    clone.made_from = None
    return clone


def _stacked(given: Mapping[int, Array], size: int) -> Array:
    """Values by component as one array (..., size), zero where none is given."""
    return np.stack(np.broadcast_arrays(*(given.get(k, np.zeros(())) for k in range(size))), axis=-1)


def check_ideal(name: str, element: JointElement) -> None:
    """Refuse a joint that is ideal at some batch entries only."""
    infinite = np.isinf(element.stiffness).reshape(-1, 6)
    if len(infinite) and np.any(infinite.any(axis=0) != infinite.all(axis=0)):
        raise FrameError(f"joint {name!r} is ideal (inf) at some batch entries only: give those a frame of their own")
