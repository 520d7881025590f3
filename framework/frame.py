"""The description of a frame: nodes, members, joints, supports and loads, each number possibly a batch."""

from __future__ import annotations

import copy
from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .batch import Array, Shape, joined, rotation, turned, unvaried, vector
from .dofs import DISPLACEMENTS, FORCES, components, values
from .errors import FrameError
from .examination import examine_joint, examine_mass, examine_member
from .loads import LineLoad, MemberLoad, PointLoad
from .names import found, new, plain
from .protocol import JointElement, LineElement, PointElement, is_proven
from .provenance import HasStatus, Told

if TYPE_CHECKING:
    from .batched.plan import Plan
    from .large.path import EquilibriumPath
    from .large.solution import LargeSolution
    from .matrices import FrameMatrices
    from .results.buckling import Buckling
    from .results.modes import Modes
    from .solution import Solution
    from .structure.topology import Topology

# Two nodes of a joint coincide when their distance is below this share of the frame's size.
COINCIDENT = 1e-9

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
class Frame:
    """Frame of beams and joints; what varies over a batch is given as arrays.

    The batch shape is the NumPy broadcast of everything that the description holds: 36 poses given as ``(36, 1)``
    and 100 samples as ``(100,)`` make displacements ``(36, 100, 6)``.

    Attributes
    ----------
    bodies, nodes, members, joints, masses
        The description by name, in the order in which it was given.
    aliases
        Other names of nodes.
    ties
        Rigid links and ties.
    supports
        By node: component index and prescribed displacement.
    offsets
        By joint: component index and imposed relative displacement, in the joint's axes.
    loads
        By node: component index and value of each load.
    member_loads
        By member: line and point loads.
    weight
        Acceleration of gravity (..., 3).
    absent
        Batch entries that are left out, (...); None for none.
    made_from
        What the frame was made from, such as a motion: what its status says of entries that are not regular, solutions
        of the frame say too.
    size
        Largest coordinate, the measure of what coincides.
    tolerance
        Length up to which the two nodes of a joint may lie apart and count as one place.
    kept
        Plan of the last solution; the next takes it up where only loads have changed.

    Examples
    --------
    >>> from linkframe.elements import Beam, Material, Rectangle
    >>> steel = Material(E=200e9, nu=0.3)
    >>> frame = Frame()
    >>> frame.node("A", (0.0, 0.0, 0.0))
    >>> frame.node("B", (1.0, 0.0, 0.0))
    >>> frame.add("AB", Beam(Rectangle(y=0.02, z=0.01), steel), "A", "B")
    >>> frame.fix("A")
    >>> frame.load("B", fy=[-10.0, -20.0])
    >>> frame.solve().displacement("B")[:, 1]
    array([-0.0025, -0.005 ])
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
    _shapes: dict[str, Shape] = field(default_factory=dict, repr=False)
    _shape: Shape = ()
    _examined: dict[Hashable, str] = field(default_factory=dict, repr=False, compare=False)
    size: float = 0.0
    tolerance: float = 0.0
    kept: Plan | None = field(default=None, repr=False, compare=False)

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
            _check_ideal(name, element)
            self._join({f"joint {name!r}": element.shape})
            self.joints[name] = JointLink(element, *nodes)
        else:
            if not is_proven(element):
                examine_mass(name, element)
            self._join({f"mass {name!r}": element.shape})
            self.masses[name] = MassPoint(element, *nodes)

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

    def copy(self) -> Frame:
        """The description as it is now; what is said of the one later does not change the other."""
        twin = Frame.__new__(type(self))
        for name, value in vars(self).items():
            setattr(twin, name, value)
            if isinstance(value, dict):
                held = dict(value)
                if name in _GROWING:
                    held = {key: copy.copy(v) for key, v in value.items()}
                setattr(twin, name, held)
            elif isinstance(value, list):
                setattr(twin, name, list(value))
        twin.kept = None
        return twin

    __copy__ = copy

    def __getstate__(self) -> dict[str, object]:
        """What another process needs; the plan that is kept holds what cannot travel, and is made again."""
        made_from = None if self.made_from is None else Told(self.made_from.status, self.made_from.is_regular)
        return vars(self) | {"kept": None, "_examined": {}, "made_from": made_from}

    def __repr__(self) -> str:
        counts = f"{len(self.nodes)} nodes, {len(self.members)} members, {len(self.joints)} joints"
        return f"<Frame of shape {self.shape}: {counts}>"

    # -- answers ----------------------------------------------------------------------------------------------------

    @overload
    def solve(
        self, method: str | None = None, *, clearance: bool = True, large: Literal[False] = False
    ) -> Solution: ...

    @overload
    def solve(
        self, method: None = None, *, clearance: bool = True, large: Literal[True], steps: int = 1
    ) -> LargeSolution: ...

    def solve(
        self, method: str | None = None, *, clearance: bool = True, large: bool = False, steps: int = 1
    ) -> Solution | LargeSolution:
        """Static solution of the whole batch; lazy, so nothing is computed that nobody reads.

        Where joints have clearance, it is the equilibrium at which each journal rests in its bearing, found at once
        together with the compliance (see `linkframe.framework.clearances.clearance`); ``solution.contact(joint)``
        tells where.

        Parameters
        ----------
        method
            ``broadcast`` (any batch), or for one large frame, whose stiffness does not vary, ``banded`` (LAPACK),
            ``sparse`` (SuperLU), ``cholesky`` (CHOLMOD, with the extra ``fast``) or ``iterative`` (conjugate
            gradients). Where None, the plan takes what promises to be fastest; ``explain()`` says what and why. The
            results are the same.
        clearance
            Whether the joints' clearances are taken into account; False leaves compliance alone, so that the
            difference is the displacement by clearance.
        large
            Equilibrium at finite displacement and rotation, to which `method` does not apply. Members are cut into
            their ``segments``.
        steps
            For `large`, number of equal steps in which loads, offsets and prescribed displacements grow.

        Raises
        ------
        FrameError
            Where the method is unknown, not installed, or not for this batch.
        """
        from .solution import Solution

        for name, given in (("clearance", clearance), ("large", large)):
            if not isinstance(given, (bool, np.bool_)):
                raise FrameError(f"solve was given {name}={given!r}: give True or False")
        if not large and steps != 1:
            raise FrameError(f"solve was given steps={steps!r}, which a linear solution has not: add large=True")
        if large:
            from .large.solution import LargeSolution

            return LargeSolution.of(self, method, clearance, steps)
        return Solution.of(self, method, clearance=clearance)

    def path(self, node: str, component: str, to: float, *, steps: int = 200, first: float = 0.05) -> EquilibriumPath:
        """Equilibrium path at large displacement from rest on, past limit points where the load falls, by arc length.

        Parameters
        ----------
        node, component
            Displacement that tells where to end.
        to
            Its value there, length or radians.
        steps
            Largest number of points.
        first
            Load factor of the first step; later ones follow the number of iterations.

        Returns
        -------
        EquilibriumPath
            Points with their load ``factor`` (points, ...), ``displacement(node)`` (points, ..., 6), ``stable``
            (points, ...), the ``limits`` of the load factor, and where `to` was ``reached`` (...).

        Raises
        ------
        FrameError
            Where node or component are unknown, `to` is zero, or `steps` or `first` are not above zero.

        Warns
        -----
        PathWarning
            Where a path ends before `to`.
        """
        from .large.path import follow

        return follow(self, node, component, to, steps, first)

    def modes(self, count: int) -> Modes:
        """The lowest natural frequencies and mode shapes, of the frame with its joints in contact all round.

        Parameters
        ----------
        count
            Number of modes.
        """
        from .results.modes import modes

        return modes(self, count)

    def buckling(self, count: int) -> Buckling:
        """The lowest load factors at which the loaded frame buckles, with its joints in contact all round.

        Parameters
        ----------
        count
            Number of factors.
        """
        from .results.buckling import buckling

        return buckling(self, count)

    @property
    def mesh(self) -> Any:
        """The first batch entry as a scikit-fem ``MeshLine1`` with 3-D points, members cut into their segments.

        Its subdomains are ``beam``, ``joint`` and, if there are any, ``rigid``; each member and joint by its name; and
        each body with the members on it. Its boundaries are the supported nodes. A basis on it needs the mapping
        `linkframe.elements.ArcLengthMapping`, as scikit-fem's own is for solids.
        """
        return self._numbered.mesh

    @property
    def dofs(self) -> Any:
        """scikit-fem's ``Dofs`` of `mesh`: six a node, ``ux uy uz rx ry rz``, nodes in the order of description."""
        return self._numbered.numbering

    @property
    def _numbered(self) -> Topology:
        from .structure.topology import Topology

        return Topology.of(self.copy(), cut=True)

    def matrices(self, entry: int | Sequence[int] = ()) -> FrameMatrices:
        """Stiffness, mass and loads at one batch entry as sparse matrices in scikit-fem's numbering.

        Parameters
        ----------
        entry
            Indices of the batch entry, one for each batch axis.

        Returns
        -------
        FrameMatrices
            ``K M f`` over all displacements, supports as ``D x``, and ``T g`` of all that holds.

        Raises
        ------
        FrameError
            If the batch has no such entry.
        """
        from .matrices import frame_matrices

        return frame_matrices(self, entry)

    def explain(self) -> str:
        """What a linear solution will build, at which batch shapes, and what it skips and why, in plain words.

        For large displacement: ``frame.solve(large=True).explain()``.
        """
        return self.solve().explain()

    # -- checks -----------------------------------------------------------------------------------------------------

    def _node(self, name: str, of: str = "") -> str:
        what = f"{of} node".strip()
        return found(what, self.aliases.get(plain(what, name), name), self.nodes)

    def _member(self, name: str, of: str = "") -> str:
        return found(f"{of} member".strip(), name, self.members)

    def _join(self, given: Mapping[str, Shape]) -> None:
        """Widen the batch by the shapes of what one call gives: by all of them, or by none where one does not fit."""
        whole, known = self._shape, self._shapes
        for name, shape in given.items():
            if shape:
                whole = joined(name, shape, known)
                known = {**known, name: np.broadcast_shapes(shape, known.get(name, ()))}
        self._shape, self._shapes = whole, known

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


def _stacked(given: Mapping[int, Array], size: int) -> Array:
    """Values by component as one array (..., size), zero where none is given."""
    return np.stack(np.broadcast_arrays(*(given.get(k, np.zeros(())) for k in range(size))), axis=-1)


def _check_ideal(name: str, element: JointElement) -> None:
    infinite = np.isinf(element.stiffness).reshape(-1, 6)
    if len(infinite) and np.any(infinite.any(axis=0) != infinite.all(axis=0)):
        raise FrameError(f"joint {name!r} is ideal (inf) at some batch entries only: give those a frame of their own")
