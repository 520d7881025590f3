"""Descriptions in bulk: many nodes, members, supports or loads by one call each, and frames from line meshes."""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain, repeat
from operator import attrgetter, eq
from typing import Any, Self, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .batch import ZERO, Array, distinct, finite, rotated, vector
from .described.many_elements import alike, one_each
from .described.members import LONGEST, SHORTEST
from .described.parts import JointLink, Member, Node, check_ideal
from .dofs import FORCES, component, components
from .editing import Editable
from .errors import FrameError
from .garbage import without_search
from .joint_examination import examine_joint
from .joint_protocol import JointElement
from .meshes import lines, sources
from .names import found, plain
from .protocol import LineElement, is_proven
from .stacking import stacked

Names = Sequence[str]
Row = TypeVar("Row", Node, Member, JointLink)


@dataclass(eq=False, repr=False)
class InBulk(Editable):
    """The part of a description that takes many parts by one call; a base class of `linkframe.framework.Frame`."""

    @classmethod
    def from_mesh(cls, mesh: Any, element: Any, *, scale: float = 1.0, drop_unconnected: bool = False) -> Self:
        """Make a frame of a line mesh: its points become nodes, its lines members.

        Nodes are named by their numbers, ``"0"``, ``"1"``, ..., or by what an Abaqus file calls them. A member bears
        the name of the smallest set that it is in: ``"mast"`` if the set has one line, ``"mast 0"``, ``"mast 1"``, ...
        if it has more (with the labels of an Abaqus file in place of the numbers). Sets are the physical groups of
        gmsh, the sets of Abaqus and meshio, and the subdomains and boundaries of scikit-fem, also from files written by
        ``frame.mesh.save``. They become ``node_sets``, which `fix_many` and `load_many` take by name, and
        ``element_sets``; the name of a set of one node becomes an alias of that node unless a node has that name.

        Parameters
        ----------
        mesh
            Path of a file (gmsh .msh, Abaqus .inp, .vtu, or what else meshio reads), a ``meshio.Mesh``, or a
            ``skfem.MeshLine1``. Lines of higher order are cut at their inner nodes.
        element
            One element for all lines; or by the name of a set its element, a `LineElement`, a `JointElement` where
            lines have no length, or None for lines to leave out. ``"material 2"`` is the set of lines with 2 in an
            array ``material`` of whole numbers.
        scale
            Factor by which coordinates are multiplied: 1e-3 for a mesh in millimetres and a frame in metres.
        drop_unconnected
            Whether to leave out nodes that are on no line; if False, such nodes are an error.

        Returns
        -------
        Frame
            The frame, without supports and loads.

        Raises
        ------
        FrameError
            If the mesh cannot be read or has no lines, a set is unknown, a line is in none of the sets given or in
            several with different elements, or a node is on no line.

        Examples
        --------
        >>> import meshio
        >>> from linkframe.elements import Beam, Circle, Material
        >>> from linkframe.framework import Frame
        >>> points = [(0.0, 0.0, 0.0), (0.0, 1.0, 0.0), (1.0, 1.0, 0.0), (2.0, 1.0, 0.0)]
        >>> sets = {"mast": [[0]], "boom": [[1, 2]]}
        >>> mesh = meshio.Mesh(points, {"line": [(0, 1), (1, 2), (2, 3)]}, point_sets={"foot": [0]}, cell_sets=sets)
        >>> steel = Material(E=200e9, nu=0.3)
        >>> rods = {"mast": Beam(Circle(diameter=0.04), steel), "boom": Beam(Circle(diameter=0.02), steel)}
        >>> frame = Frame.from_mesh(mesh, rods)
        >>> list(frame.members), frame.node_sets
        (['mast', 'boom 0', 'boom 1'], {'foot': ['0']})
        >>> frame.fix("foot"); frame.load("3", fy=-10.0)
        >>> float(frame.solve().displacement("3")[1].round(6))
        -0.018568
        """
        whole = sources.line_mesh_of(mesh, scale)
        families = lines.lines_by_element(whole, element)
        kept = np.sort(np.concatenate([at for _, at in families]))
        taken = whole.taken(kept, drop_unconnected)
        names = taken.line_names()
        frame = cls()
        nodes = frame.add_nodes(taken.point_labels or len(taken.points), taken.points)
        for one, at in families:
            there = np.searchsorted(kept, at)
            frame.add_many(one, taken.lines[there], [names[k] for k in there])
        frame.node_sets = {name: [nodes[k] for k in at] for name, at in taken.point_sets.items() if at.size}
        frame.element_sets = {name: [names[k] for k in at] for name, at in taken.line_sets.items() if at.size}
        for name, of in frame.node_sets.items():
            if len(of) == 1 and name not in frame.nodes:
                frame.alias(name, of[0])
        return frame

    @without_search()
    def add_nodes(self, names: Names | int, coordinates: ArrayLike, body: str | None = None) -> list[str]:
        """Place many nodes.

        Parameters
        ----------
        names
            Names of the n nodes; or n itself, for consecutive numbers as names: ``"0"``, ``"1"``, ...
        coordinates
            Positions (..., n, 3), length, in the axes of `body` or global; batch axes come first.
        body
            Body that carries the nodes.

        Returns
        -------
        list of str
            The names.

        Raises
        ------
        FrameError
            As for `node`; no node is placed then.

        Examples
        --------
        >>> import numpy as np
        >>> from linkframe.elements import Beam, Circle, Material
        >>> from linkframe.framework import Frame
        >>> frame = Frame()
        >>> x = np.linspace(0.0, 1.0, 101)
        >>> names = frame.add_nodes(101, np.stack([x, 0.0 * x, 0.0 * x], axis=-1))
        >>> rod = Beam(Circle(diameter=0.02), Material(E=200e9, nu=0.3))
        >>> beams = frame.add_many(rod, zip(names[:-1], names[1:]))
        >>> frame.fix(names[0]); frame.load_many(names[1:], fy=-0.1)
        >>> float(frame.solve().displacement(names[-1])[1].round(6))
        -0.000806
        """
        counted = isinstance(names, (int, np.integer))
        new = _numbers(len(self.nodes), names) if counted else list(names)  # type: ignore[arg-type]
        self._check_new("node", new, self.nodes, self.aliases, counted=counted)
        if body is not None:
            body = found("nodes: body", body, self.bodies)
        what = f"coordinates of {len(new)} nodes"
        places = vector(coordinates, what)
        if places.ndim < 2 or places.shape[-2] != len(new):
            raise FrameError(f"{what} have shape {places.shape}: give (..., {len(new)}, 3)")
        if not new:
            return []
        self._join({f"nodes {new[0]!r} to {new[-1]!r}": places.shape[:-2]})
        rows = list(places) if places.ndim == 2 else [places[..., k, :] for k in range(len(new))]
        self.nodes.update(zip(new, _rows(Node, rows, repeat(body)), strict=True))
        there = places
        if body is not None:
            frame = self.bodies[body]
            there = frame.origin[..., None, :] + rotated(frame.axes[..., None, :, :], places)
        self.size = max(self.size, float(np.abs(there).max(initial=0.0)))
        return new

    @without_search()
    def add_many(
        self,
        element: LineElement | JointElement | Sequence[LineElement | JointElement],
        pairs: Iterable[tuple[str, str]] | NDArray[np.integer[Any]],
        names: Names | None = None,
    ) -> list[str]:
        """Add many members or joints.

        Parameters
        ----------
        element
            One element for all, whose parameters may be arrays (..., n) with one number for each, or (..., 1) for a
            batch that is the same for all; or n elements, one for each.
        pairs
            Names of the two nodes of each, n pairs; or the numbers of these nodes in the order of description, (n, 2).
        names
            Names of the n members or joints; None gives consecutive numbers: ``"0"``, ``"1"``, ...

        Returns
        -------
        list of str
            The names.

        Raises
        ------
        FrameError
            As for `add`; nothing is added then.

        Examples
        --------
        Three rods between four nodes, given by the numbers of the nodes.

        >>> import numpy as np
        >>> from linkframe.elements import Beam, Circle, Material
        >>> from linkframe.framework import Frame
        >>> frame = Frame()
        >>> names = frame.add_nodes(4, [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (1.0, 1.0, 0.0), (0.0, 1.0, 0.0)])
        >>> frame.add_many(Beam(Circle(diameter=0.02), Material(E=200e9, nu=0.3)), np.array([(0, 1), (1, 2), (2, 3)]))
        ['0', '1', '2']
        """
        starts, stops, numbers = self._ends(pairs)
        count = len(self.members) + len(self.joints) + len(self.masses)
        new = _numbers(count, len(starts)) if names is None else list(names)
        if len(new) != len(starts):
            raise FrameError(f"add_many was given {len(new)} names for {len(starts)} pairs of nodes: give one for each")
        self._check_new("element", new, self.members, self.joints, self.masses, counted=names is None)
        one = isinstance(element, (LineElement, JointElement))
        each = one_each(element, len(new)) if one else list(element)  # type: ignore[arg-type]
        if not (one and len(each) == 1) and len(each) != len(new):
            raise FrameError(f"add_many was given {len(each)} elements for {len(new)} pairs: give one, or one for each")
        if not new:
            return []
        kinds = {type(given) for given in each}
        if all(issubclass(kind, LineElement) for kind in kinds):
            families = [np.arange(len(new))] if one else alike(each)  # type: ignore[arg-type]
            self._add_members(new, each, starts, stops, numbers, families)  # type: ignore[arg-type]
        elif all(issubclass(kind, JointElement) for kind in kinds):
            self._add_joints(new, each, starts, stops)  # type: ignore[arg-type]
        else:
            text = ", ".join(sorted(kind.__name__ for kind in kinds))
            raise FrameError(f"add_many was given elements of the kinds {text}: give members alone, or joints alone")
        return new

    @without_search()
    def fix_many(self, nodes: Names, *names: str) -> None:
        """Support many nodes: set displacement components to zero, all six where none is named.

        Parameters
        ----------
        nodes
            Names of the nodes, or the name of a set of them.
        *names
            Global displacement components ``ux uy uz rx ry rz``.
        """
        constrained = dict.fromkeys(components(names), ZERO)
        for node in self._known(nodes, "support"):
            self.supports[node] = {**self.supports.get(node, {}), **constrained}

    @without_search()
    def load_many(self, nodes: Names, **force: ArrayLike) -> None:
        """Apply a force or moment at each of many nodes, in global axes; loads add up.

        Parameters
        ----------
        nodes
            Names of the nodes, n of them, or the name of a set of them.
        **force
            Values by component ``fx fy fz mx my mz``: one number for all nodes, or (..., n) with one for each; batch
            axes come first.
        """
        there = self._known(nodes, "load")
        what = f"load at {len(there)} nodes"
        if not force:
            raise FrameError(f"{what} names no component: give at least one of {', '.join(FORCES)}")
        given = {component(name, FORCES): finite(value, f"{what}, {name},") for name, value in force.items()}
        for k, value in given.items():
            if value.ndim and value.shape[-1] != len(there):
                raise FrameError(
                    f"{what}, {FORCES[k]}, has shape {value.shape}: give one number, or (..., {len(there)})"
                )
        self._join({f"{FORCES[k]} of the {what}": value.shape[:-1] for k, value in given.items()})
        for k, value in given.items():
            # the value of each node: one for all, or its own, an array (...) where there is a batch
            parts = repeat(value) if not value.ndim else map(np.asarray, np.moveaxis(value, -1, 0))
            loads = self.loads
            for node, part in zip(there, parts, strict=False):
                if node in loads:
                    loads[node].append((k, part))
                else:
                    loads[node] = [(k, part)]

    # -- inside -----------------------------------------------------------------------------------------------------

    def _check_new(self, what: str, names: list[str], *known: Mapping[str, object], counted: bool) -> None:
        """Refuse names that exist already; unless they are `counted` numbers, also invalid and repeated ones."""
        if not counted:
            if set(map(type, names)) - {str} or not all(names):
                names[:] = [plain(what, name) for name in names]
            if len(set(names)) < len(names):
                seen: set[str] = set()
                twice = next(name for name in names if name in seen or seen.add(name))  # type: ignore[func-returns-value]
                raise FrameError(f"{what} {twice!r} is given twice: choose another name")
        for names_known in known:
            if not names_known.keys().isdisjoint(names):
                clash = min(names_known.keys() & set(names))
                raise FrameError(f"{what} {clash!r} exists already: choose another name")

    def _known(self, nodes: Names, of: str) -> list[str]:
        """The names by which nodes are described, from names, aliases or the name of a set."""
        given = self.node_sets.get(nodes, [nodes]) if isinstance(nodes, str) else list(nodes)
        if set(map(type, given)) <= {str} and all(map(self.nodes.__contains__, given)):
            return given
        return [self._node(name, of) for name in given]

    def _ends(
        self, pairs: Iterable[tuple[str, str]] | NDArray[np.integer[Any]]
    ) -> tuple[list[str], list[str], NDArray[np.integer[Any]] | None]:
        """Names of the first and of the second node of each pair, and their numbers where these were given."""
        numbers: NDArray[np.integer[Any]] | None = None
        if isinstance(pairs, np.ndarray) and pairs.dtype.kind in "iu":
            names = list(self.nodes)
            inside = not pairs.size or 0 <= pairs.min() <= pairs.max() < len(names)
            if pairs.ndim != 2 or pairs.shape[1] != 2 or not inside:
                text = f"numbers of nodes from 0 to {len(names) - 1}, (n, 2)"
                raise FrameError(f"add_many was given pairs of shape {pairs.shape}: give {text}")
            starts, stops = (list(map(names.__getitem__, side)) for side in pairs.T.tolist())
            numbers = pairs
        else:
            given: list[Any] = list(pairs)
            if set(map(type, given)) & {str} or set(map(len, given)) - {2}:
                wrong = next(pair for pair in given if isinstance(pair, str) or len(pair) != 2)
                raise FrameError(f"add_many was given the pair {wrong!r}: give the names of two nodes")
            starts, stops = (self._known([pair[side] for pair in given], "pair") for side in (0, 1))
        if any(map(eq, starts, stops)):
            alone = next(a for a, b in zip(starts, stops, strict=True) if a == b)
            raise FrameError(f"add_many was given the pair {(alone, alone)}: give two different nodes")
        return starts, stops, numbers

    def _add_members(
        self,
        names: list[str],
        elements: list[LineElement],
        starts: list[str],
        stops: list[str],
        numbers: NDArray[np.integer[Any]] | None,
        families: list[NDArray[np.int64]],
    ) -> None:
        """Add members, making the checks of `add` for all members of one family of elements at once."""
        kinds: dict[Hashable, str] = {}
        chords = self._chords(starts, stops, numbers)
        if chords is not None:
            lengths = np.abs(chords).max(axis=-1)
            for k in np.flatnonzero(~((lengths > SHORTEST) & (lengths < LONGEST))).tolist():
                self._check_length(names[k], starts[k], stops[k])
        for at in families:
            mine = [elements[k] for k in at.tolist()] if len(elements) > 1 else elements
            element = mine[0]
            if chords is None:
                for k, one in zip(at.tolist(), mine if len(mine) > 1 else repeat(element), strict=False):
                    self._check_length(names[k], starts[k], stops[k])
                    one.check(self._chord(starts[k], stops[k]))
            else:
                whole = stacked(mine, len(element.shape)) if len(mine) > 1 else element
                whole.check(chords[at].reshape(-1, *(1,) * len(element.shape), 3))
            kinds |= self._examine(names[at[0]], element, (starts[at[0]], stops[at[0]]))
            self._join({f"member {names[at[0]]!r}": element.shape})
        each = elements if len(elements) == len(names) else repeat(elements[0])
        self.members.update(zip(names, _rows(Member, each, starts, stops), strict=True))
        self._examined |= kinds

    def _add_joints(self, names: list[str], elements: list[JointElement], starts: list[str], stops: list[str]) -> None:
        """Add joints, checking each different element once."""
        for name, first, second in zip(names, starts, stops, strict=True):
            self._check_coincident(name, first, second)
        leaders, _ = distinct(elements)
        for k in leaders:
            if not is_proven(elements[k]):
                examine_joint(names[k], elements[k])
            check_ideal(f"joint {names[k]!r}", elements[k].stiffness)
        self._join({f"joint {names[k]!r}": elements[k].shape for k in leaders})
        each = elements if len(elements) == len(names) else repeat(elements[0])
        self.joints.update(zip(names, _rows(JointLink, each, starts, stops), strict=True))

    def _chords(self, starts: list[str], stops: list[str], numbers: NDArray[np.integer[Any]] | None) -> Array | None:
        """Vector from start to end of each member, (n, 3); None where nodes are on bodies or vary over the batch."""
        whole = None
        if numbers is not None and len(self.nodes) <= 4 * len(starts):
            whole = _plain_places(list(self.nodes.values()))
        if whole is None:
            # each node once: a member has two ends, and a node some members
            number = {node: k for k, node in enumerate(dict.fromkeys(chain(starts, stops)))}
            numbers = np.array([list(map(number.__getitem__, side)) for side in (starts, stops)]).T
            whole = _plain_places(list(map(self.nodes.__getitem__, number)))
        return None if whole is None or numbers is None else whole[numbers[:, 1]] - whole[numbers[:, 0]]


def _plain_places(nodes: list[Node]) -> Array | None:
    """Positions of nodes, (n, 3); None where one of them lies on a body or varies over the batch."""
    places = list(map(attrgetter("coordinates"), nodes))
    if set(map(attrgetter("body"), nodes)) != {None} or set(map(attrgetter("ndim"), places)) != {1}:
        return None
    whole: Array = np.concatenate(places).reshape(-1, 3)
    return whole


def _rows(kind: type[Row], *columns: Iterable[object]) -> Iterator[Row]:
    """Named tuples from columns of their fields, in half the time that their constructor takes."""
    return map(tuple.__new__, repeat(kind), zip(*columns, strict=False))


def _numbers(first: int, count: int) -> list[str]:
    """Consecutive numbers as names, `count` of them from `first` on."""
    return list(map(str, range(first, first + count)))
