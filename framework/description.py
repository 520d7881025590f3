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
from .batch import Array, Shape, aligned, finite, joined, rotation, turned, unvaried, vector
from .dofs import DISPLACEMENTS, FORCES, components, values
from .errors import FrameError
from .examination import examine_joint, examine_mass, examine_member
from .formed import FormedElement
from .loads import LineLoad, MemberLoad, PointLoad
from .names import found, new, plain
from .protocol import JointElement, LineElement, PointElement, is_proven
from .provenance import HasStatus, Told

# Two nodes of a joint coincide when their distance is below this share of the frame's size.
COINCIDENT = 1e-9

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
            Position (..., 3), in the axes of `body` or global.
        body
            Body that carries the node.
        """
        name = new("node", name, self.nodes, self.aliases)
        if body is not None:
            body = found(f"node {name!r}: body", body, self.bodies)
        place = vector(coordinates, f"coordinates of node {name!r}")
        self._join({f"node {name!r}": place.shape[:-1]})
        self.nodes[name] = Node(place, body)
        if body is None or self.bodies[body].far + float(np.linalg.norm(place, axis=-1).max(initial=0.0)) > self.size:
            self.size = max(self.size, float(np.abs(self.position(name)).max(initial=0.0)))

    def alias(self, name: str, node: str) -> None:
        """Give a node another name, by which it is loaded, held and asked for results as well.

        Parameters
        ----------
        name
            The other name.
        node
            The node.
        """
        name = new("node", name, self.nodes, self.aliases)
        self.aliases[name] = self._node(node)

    def position(self, node: str) -> Array:
        """Global position of a node, (..., 3).

        Parameters
        ----------
        node
            The node.
        """
        at = self.nodes[self._node(node)]
        if at.body is None:
            return at.coordinates
        body = self.bodies[at.body]
        return body.origin + turned(body.axes, at.coordinates)

    def chord(self, member: str) -> Array:
        """Vector from start to end of a member, (..., 3), in the axes of its body where both ends share one.

        Parameters
        ----------
        member
            The member.
        """
        ends = self.members[self._member(member)]
        return self._chord(ends.start, ends.end)

    def length(self, member: str) -> Array:
        """Length of a member, (...).

        Parameters
        ----------
        member
            The member.
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
            What is added; its parameters may carry a batch. Of an element that is not linkframe's own, what it
            returns is put to the test.
        *nodes
            Names of its nodes, start (first) before end (second).
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
            What the form finds in ``w``, each a number or a batch of numbers.

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
        made: dict[object, LineElement] = {}
        examined: set[object] = set()
        for name in names:
            member = self.members[name]
            key = name if apart else id(member.element)
            if key not in made:
                made[key] = FormedElement.of(member.element, added, lengths[name] if apart else None)
                # what the form makes of one proven element it makes of all of that class
                kind = type(member.element) if is_proven(member.element) else key
                if made[key] is not member.element and kind not in examined:
                    examine_member(name, made[key], self._chord(member.start, member.end))
                    examined.add(kind)
        self._shape, self._shapes = widened
        for name in names:
            member = self.members[name]
            self.members[name] = replace(member, element=made[name if apart else id(member.element)])
            if added.pushes:
                self.member_loads.setdefault(name, []).append(FormLoad(added))

    def rigid(self, master: str, *slaves: str) -> None:
        """Join nodes by rigid links, exactly: they move as one body.

        Parameters
        ----------
        master
            The node that leads.
        *slaves
            The nodes that follow.
        """
        self._tie(master, slaves, tuple(range(6)), rigid=True)

    def tie(self, master: str, slave: str, *names: str) -> None:
        """Make the named global displacement components of two nodes equal (all six where none is named).

        Parameters
        ----------
        master, slave
            The two nodes; they need not coincide, and no arm between them is taken into account.
        *names
            Components ``ux uy uz rx ry rz``.
        """
        self._tie(master, (slave,), components(names), rigid=False)

    def members_on(self, on: str | Sequence[str], what: str = "members_on") -> list[str]:
        """Names of the members that names of members and bodies stand for, each once.

        Parameters
        ----------
        on
            A member, a body (all members on it), ``"beam"`` for all members, or several of these.
        what
            What asks, for messages.

        Raises
        ------
        FrameError
            If `on` names nothing.
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
            The node.
        *names
            Global displacement components ``ux uy uz rx ry rz``.
        """
        node, zeros = self._node(node, "support"), {index: np.zeros(()) for index in components(names)}
        self.supports.setdefault(node, {}).update(zeros)

    def prescribe(self, node: str, **displacement: ArrayLike) -> None:
        """Prescribe displacement components of a node, such as a settlement.

        Parameters
        ----------
        node
            The node.
        **displacement
            Values by component, ``ux uy uz`` in length and ``rx ry rz`` in radians; each may carry a batch.
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
            Displacement of the second node relative to the first by component.
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
            The node.
        **force
            Values by component ``fx fy fz mx my mz``; each may carry a batch.
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
            The member.
        local
            Components in the member's own axes instead of the global ones.
        span
            Distances from the member's start between which the load acts; the whole length where None.
        **force
            ``fx fy fz`` per length; a tuple ``(start, end)`` varies linearly over the span.
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
            The member.
        at
            Distance from the member's start.
        local
            Components in the member's own axes instead of the global ones.
        **force
            Values by component ``fx fy fz mx my mz``.
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
            Acceleration of gravity (..., 3), such as ``(0, 0, -9.81)``.
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
        """
        left = np.array(where)
        if left.dtype != np.bool_:
            raise FrameError(f"exclude was given {where!r}: give True for the entries to leave out")
        self._join({"entries left out": left.shape})
        self.absent = left if self.absent is None else self.absent | left

    def copy(self) -> Self:
        """The description as it is now; what is said of the one later does not change the other."""
        twin = object.__new__(type(self))
        for name, value in vars(self).items():
            setattr(twin, name, value)
            if isinstance(value, dict):
                held = dict(value)
                if name in _GROWING:
                    held = {key: copy.copy(v) for key, v in value.items()}
                setattr(twin, name, held)
            elif isinstance(value, list):
                setattr(twin, name, list(value))
        return twin

    __copy__ = copy

    def __getstate__(self) -> dict[str, object]:
        """What another process needs."""
        made_from = None if self.made_from is None else Told(self.made_from.status, self.made_from.is_regular)
        return vars(self) | {"_examined": {}, "made_from": made_from}

    def __repr__(self) -> str:
        counts = f"{len(self.nodes)} nodes, {len(self.members)} members, {len(self.joints)} joints"
        return f"<Frame of shape {self.shape}: {counts}>"

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
        for name, shape in given.items():
            if shape and shape not in known:
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
        length = np.linalg.norm(self._chord(start, end), axis=-1)
        if np.any(length <= 0.0):
            where = f" at batch entry {np.argwhere(length <= 0)[0].tolist()}" if length.ndim else ""
            raise FrameError(f"member {name!r} has zero length{where}: nodes {start!r} and {end!r} coincide")

    def _check_coincident(self, name: str, first: str, second: str) -> None:
        gaps = np.linalg.norm(self.position(second) - self.position(first), axis=-1)
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

    def _tie(self, master: str, slaves: tuple[str, ...], held: tuple[int, ...], *, rigid: bool) -> None:
        master, *others = (self._node(node, "tie") for node in (master, *slaves))
        if master in others:
            raise FrameError(f"node {master!r} is tied to itself: give two different nodes")
        self.ties.extend(Tie(master, slave, held, rigid) for slave in others)


def alone(frame: Description) -> Description:
    """The same description, dicts and all, which does not tell what it was made from."""
    twin = object.__new__(type(frame))
    for name, value in vars(frame).items():
        setattr(twin, name, value)
    twin.made_from = None
    return twin


def _stacked(given: Mapping[int, Array], size: int) -> Array:
    """Values by component as one array (..., size), zero where none is given."""
    return np.stack(np.broadcast_arrays(*(given.get(k, np.zeros(())) for k in range(size))), axis=-1)


def check_ideal(name: str, element: JointElement) -> None:
    """Refuse a joint that is ideal at some batch entries only."""
    infinite = np.isinf(element.stiffness).reshape(-1, 6)
    if len(infinite) and np.any(infinite.any(axis=0) != infinite.all(axis=0)):
        raise FrameError(f"joint {name!r} is ideal (inf) at some batch entries only: give those a frame of their own")
