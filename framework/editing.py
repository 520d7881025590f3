"""Changes of a description in place: other elements, coordinates or loads, everything else being kept."""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, cast

import numpy as np
from numpy.typing import ArrayLike

from .batch import Array, Shape, vector
from .described.parts import JointLink, MassPoint, Member, Node, check_ideal
from .description import Description
from .dofs import DISPLACEMENTS, FORCES, values
from .errors import FrameError
from .examination import examine_mass
from .formed import FormedElement
from .joint_examination import examine_joint
from .joint_protocol import JointElement
from .names import plain
from .protocol import LineElement, PointElement, is_proven

Element = LineElement | JointElement | PointElement


@dataclass(eq=False, repr=False)
class Editable(Description):
    """The part of a description that changes it in place; a base class of `linkframe.framework.Frame`."""

    def change(self, name: str | Sequence[str], new: Element | Sequence[Element] | ArrayLike) -> None:
        """Replace the elements of members, joints or masses, or move nodes.

        Everything else stays: names, connections, supports, loads and forms added to a member. The next solution reuses
        what depends on these alone, such as the order of elimination.

        Parameters
        ----------
        name
            The member, joint or mass, or several of them; or the node, or several nodes that are moved at once, such as
            the two of a joint.
        new
            An element of the same sort, such as a beam for a beam, or a sequence with one for each name; or
            coordinates, in the axes of the nodes' bodies or global: (..., 3), one place for all of the nodes, or
            (..., n, 3) with one for each of n nodes.

        Raises
        ------
        FrameError
            Where a name is unknown, an element is of another sort, or the change would give a member without length, a
            joint between distant nodes, or a load beyond the end of its member. The frame is then left unchanged.

        Examples
        --------
        >>> from linkframe.elements import Beam, Circle, Material
        >>> from linkframe.framework import Frame
        >>> frame = Frame()
        >>> frame.node("A", (0.0, 0.0, 0.0))
        >>> frame.node("B", (1.0, 0.0, 0.0))
        >>> frame.add("AB", Beam(Circle(diameter=0.02), Material(E=200e9, nu=0.3)), "A", "B")
        >>> frame.fix("A"); frame.load("B", fy=-10.0)
        >>> before = frame.solve().displacement("B")[1]
        >>> frame.change("B", (2.0, 0.0, 0.0))
        >>> float((frame.solve().displacement("B")[1] / before).round(12))
        8.0
        """
        names = [name] if isinstance(name, str) else list(name)
        kind: Any = type(new)
        if kind in (list, tuple) and any(map(_sort, {*map(type, cast(Sequence[Any], new))})):
            self._change_elements(names, cast(Sequence[Element], new))
        elif kind is not np.ndarray and _sort(kind):
            self._change_elements(names, [cast(Element, new)])
        else:
            self._move(names, cast(ArrayLike, new))

    def set_load(self, node: str, **force: ArrayLike) -> None:
        """Replace all loads on a node.

        Parameters
        ----------
        node
            Name of the node.
        **force
            Values by component, (...): force ``fx fy fz`` and moment ``mx my mz`` in global axes. Without any, the node
            is unloaded.

        Examples
        --------
        >>> from linkframe.framework import Frame
        >>> frame = Frame()
        >>> frame.node("A", (0.0, 0.0, 0.0)); frame.fix("A")
        >>> frame.load("A", fx=1.0); frame.set_load("A", fy=2.0)
        >>> frame.solve().reaction("A")[:3].tolist()
        [0.0, -2.0, 0.0]
        """
        node = self._node(node, "load")
        given = values(f"load at {node!r}", force, FORCES) if force else {}
        loads, before = self.loads, self.loads.get(node, [])
        self.loads = {**loads, node: list(given.items())} if given else {k: v for k, v in loads.items() if k != node}
        try:
            shapes = {f"{FORCES[k]} at {node!r}": value.shape for k, value in given.items() if value.ndim}
            self._rejoin([value.shape for _, value in before if value.ndim], shapes)
        except FrameError:
            self.loads = loads
            raise

    def unload(self, *names: str) -> None:
        """Remove all loads from nodes and members.

        Parameters
        ----------
        *names
            Nodes and members to unload; where none is named, all loads are removed, gravity included.

        Examples
        --------
        >>> from linkframe.framework import Frame
        >>> frame = Frame()
        >>> for name in "AB":
        ...     frame.node(name, (0.0, 0.0, 0.0)); frame.fix(name); frame.load(name, fx=1.0)
        >>> frame.unload("A")
        >>> frame.solve().reactions()[:, 0].tolist()
        [0.0, -1.0]
        """
        nodes = [self.aliases.get(name, name) for name in names]
        for name, node in zip(names, nodes, strict=True):
            if node not in self.nodes and name not in self.members:
                raise FrameError(f"unload was given {name!r}, which is neither a node nor a member: give one of them")
        before = list(self._shapes_given())
        if not names:
            self.loads, self.member_loads, self.weight = {}, {}, None
        for name, node in zip(names, nodes, strict=True):
            self.loads.pop(node, None)
            self.member_loads.pop(name, None)
        if any(shape for _, shape in before):
            self._rejoin([shape for _, shape in before], {})

    # -- inside -----------------------------------------------------------------------------------------------------

    def _change_elements(self, names: list[str], elements: Sequence[Element]) -> None:
        names = [plain("element", name) for name in names]
        if len(elements) != len(names) or len(set(names)) < len(names):
            count = "one element" if len(elements) == 1 else f"{len(elements)} elements"
            remedy = "give a list of one for each, each named once, or change them one by one"
            raise FrameError(f"change was given {count} for {names}: {remedy}")
        whole, known = self.shape, self._shapes
        before: list[tuple[dict[str, Any], str, Any]] = []
        kinds: dict[Hashable, str] = {}
        try:
            for name, new in zip(names, elements, strict=True):
                parts = self._parts_like(name, new)
                before.append((parts, name, parts[name]))
                kinds |= self._change_element(parts, name, new)
        except FrameError:
            for parts, name, part in before:
                parts[name] = part
            self.shape, self._shapes = whole, known
            raise
        self._examined |= kinds

    def _parts_like(self, name: str, new: Element) -> dict[str, Any]:
        """The members, joints or masses, whichever are of the sort of an element; `name` must be one of them."""
        sort = _sort(type(new))
        parts: dict[str, Any] = self.members if sort == "member" else self.joints if sort == "joint" else self.masses
        if sort and name in parts:
            return parts
        by_sort: dict[str, dict[str, Any]] = {"member": self.members, "joint": self.joints, "mass": self.masses}
        found = [other for other, parts in by_sort.items() if name in parts]
        text = f"is a {found[0]}" if found else "is no member, joint or mass of the frame"
        given = f"{type(new).__name__}(...), a {sort}" if sort else f"{new!r}"
        raise FrameError(f"{name!r} {text}, and change was given {given}: give its like")

    def _change_element(self, parts: dict[str, Any], name: str, new: Element) -> dict[Hashable, str]:
        """Replace one element; the kinds that were checked, for `_examined`."""
        before = parts[name]
        if isinstance(before.element, FormedElement) and isinstance(new, LineElement):
            new = replace(before.element, own=new)
        kinds = self._fitting(name, before, new)
        parts[name] = type(before)(new, *before[1:])
        if new.shape != before.element.shape:
            self._rejoin([before.element.shape], {f"{_sort(type(new))} {name!r}": new.shape})
        return kinds

    def _fitting(self, name: str, part: Member | JointLink | MassPoint, new: Element) -> dict[Hashable, str]:
        """Check an element that is to replace another; the kinds that were checked, for `_examined`."""
        if isinstance(part, Member):
            assert isinstance(new, LineElement)
            # with formulas, which only batches need, an element has the default axes, which suit any chord
            if not new.shape or new.formulas is None:
                new.check(self._chord(part.start, part.end))
            return self._examine(name, new, (part.start, part.end))
        if isinstance(part, JointLink):
            assert isinstance(new, JointElement)
            if not is_proven(new):
                examine_joint(name, new)
            check_ideal(f"joint {name!r}", new.stiffness)
        elif not is_proven(new):
            assert isinstance(new, PointElement)
            examine_mass(name, new)
        return {}

    def _move(self, names: list[str], coordinates: ArrayLike) -> None:
        nodes = [self._node(name) for name in names]
        what = f"coordinates of node {nodes[0]!r}" if len(nodes) == 1 else f"coordinates of {len(nodes)} nodes"
        if not nodes or len(set(nodes)) < len(nodes):
            raise FrameError(f"change was given the nodes {names}: give each node once, one at least")
        places = vector(coordinates, what)
        each = [places] * len(nodes)
        if len(nodes) > 1 and places.ndim > 1:
            if places.shape[-2] != len(nodes):
                wanted = f"(3,) for one place, or (..., {len(nodes)}, 3)"
                raise FrameError(f"{what} have shape {places.shape}: give {wanted}")
            each = [places[..., k, :] for k in range(len(nodes))]
        before, size = {node: self.nodes[node] for node in nodes}, self.size
        whole, known = self.shape, self._shapes
        formed = {name: part for name, part in self.members.items() if type(part.element) is FormedElement}
        try:
            for node, place in zip(nodes, each, strict=True):
                self.nodes[node] = Node(place, before[node].body)
            self.size = self._size_after(before, places)
            self._check_near(set(nodes))
            shapes, last = [at.shape[:-1] for at in each], [at.coordinates.shape[:-1] for at in before.values()]
            if shapes != last:
                self._rejoin(last, {f"node {node!r}": shape for node, shape in zip(nodes, shapes, strict=True)})
        except FrameError:
            self.nodes.update(before)
            self.members.update(formed)
            self.size, self.shape, self._shapes = size, whole, known
            raise

    def _size_after(self, before: dict[str, Node], places: Array) -> float:
        """Largest absolute coordinate of all nodes after some of them were moved to these places."""
        bodies = [node.body for node in before.values() if node.body is not None]
        reached = self._reach(before) if bodies else _largest(places)
        if reached >= self.size or len(before) == len(self.nodes):
            return reached
        # all nodes are measured anew only where a moved node may have been the farthest
        last = np.inf if bodies else max([_largest(at.coordinates) for at in before.values()])
        return self.size if last < self.size else self._reach(self.nodes)

    def _reach(self, names: Iterable[str]) -> float:
        """Largest absolute coordinate of some nodes."""
        nodes = [(name, self.nodes[name]) for name in names]
        return max([_largest(at.coordinates if at.body is None else self.position(name)) for name, at in nodes])

    def _check_near(self, moved: set[str]) -> None:
        """Refuse positions of moved nodes that their members, member loads or joints do not allow."""
        for name, member in self.members.items():
            if member.start in moved or member.end in moved:
                chord = self._check_length(name, member.start, member.end)
                if type(member.element) is FormedElement and member.element.length is not None:
                    self.members[name] = member._replace(element=replace(member.element, length=self.length(name)))
                member.element.check(chord)
                for load in self.member_loads.get(name, ()):
                    end = max(load.places, default=0.0)
                    if end > self._least_length(name):
                        text = f"a load on it reaches to {end:.6g}: move its ends less, or unload it first"
                        raise FrameError(f"member {name!r} would be {self._least_length(name):.6g} long, and {text}")
        for name, joint in self.joints.items():
            if joint.first in moved or joint.second in moved:
                self._check_coincident(name, joint.first, joint.second)

    def _rejoin(self, before: Sequence[Shape], given: dict[str, Shape]) -> None:
        """Update the batch shape after values of the shapes `before` were replaced by those `given` by name."""
        if not any(shape and shape not in given.values() for shape in before):
            self._join(given)
            return
        whole, known = self.shape, self._shapes
        self.shape, self._shapes = (), {}
        try:
            self._join({name: shape for name, shape in self._shapes_given() if shape})
        except FrameError:
            self.shape, self._shapes = whole, known
            raise

    def _shapes_given(self) -> Iterator[tuple[str, Shape]]:
        """Name and batch shape of every number that is described."""
        for name, body in self.bodies.items():
            yield f"origin of body {name!r}", body.origin.shape[:-1]
            yield f"axes of body {name!r}", body.axes.shape[:-2]
        for name, node in self.nodes.items():
            yield f"node {name!r}", node.coordinates.shape[:-1]
        for sort, parts in (("member", self.members), ("joint", self.joints), ("mass", self.masses)):
            for name, part in parts.items():
                yield f"{sort} {name!r}", part.element.shape
        for at, by_kind in self.supports.items():
            yield from ((f"{DISPLACEMENTS[k]} prescribed at {at!r}", value.shape) for k, value in by_kind.items())
        for joint, offsets in self.offsets.items():
            yield from ((f"offset {DISPLACEMENTS[k]} of {joint!r}", value.shape) for k, value in offsets.items())
        for at, loads in self.loads.items():
            yield from ((f"{FORCES[k]} at {at!r}", value.shape) for k, value in loads)
        for member, on in self.member_loads.items():
            for load in on:
                yield from ((f"load on {member!r}", force.shape[:-1]) for force in load.forces)
        if self.weight is not None:
            yield "gravity", self.weight.shape[:-1]
        if self.absent is not None:
            yield "entries left out", self.absent.shape


def _largest(place: Array) -> float:
    """Largest absolute coordinate; by Python floats for a single place, which is faster than an array operation."""
    return max(map(abs, place.tolist())) if place.ndim == 1 else float(np.abs(place).max(initial=0.0))


def _sort(kind: type) -> str:
    """What an element of a class is: a member, a joint or a mass; empty where the class is of no element."""
    if issubclass(kind, LineElement):
        return "member"
    if issubclass(kind, JointElement):
        return "joint"
    return "mass" if issubclass(kind, PointElement) else ""
