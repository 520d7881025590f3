"""The numbers of a frame with a single batch entry, as input to the program of its topology.

The whole solution of such a frame, from the joint tree to the displacement of the last node, is one list of operations
on these numbers, which all frames of a topology share: see `linkframe.framework.batched.entry_recording`. The program
is found by a key: which number belongs to which joint, member or load, and which of them are zero.
"""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..cache import PATTERNS, STACKS
from ..description import Description
from ..protocol import is_proven
from ..structure.assembly import component_loads, member_and_mass_loads
from ..structure.disjoint_sets import joining
from ..structure.edge import GROUND, preference
from ..structure.parts import Grid, is_zero
from ..structure.topology import Group, Topology

# A joint, tie or support: what its part of the key is, its two nodes, and its rank in the choice of the joint tree
# (number of ideal components, stiffest spring).
Head = tuple[Hashable, tuple[int, int], tuple[int, float]]

# Numbers of each joint, tie and support: six springs, the pitch over 2 pi, and six offsets; where these begin.
PITCH, OFFSETS, EACH = 6, 7, 13
_ALL_OF_THEM = (0.0,) * EACH
# Values of axes that become part of the key and of the program, instead of being given to it.
UNITS = (0.0, 1.0, -1.0)


class EntryLinks:
    """The numbers of joints, ties, supports and bodies of a frame with a single batch entry.

    Parameters
    ----------
    topology
        Its nodes and members.

    Attributes
    ----------
    edges
        For each joint, tie and support in turn: six springs, pitch over 2 pi, six offsets.
    turns
        Components of the axes of joints, the arms of rigid links and the axes of bodies.
    order
        Indices of joints, ties and supports in order of preference for the joint tree.
    key
        What each number belongs to, and which are zero.
    """

    def __init__(self, topology: Topology) -> None:
        frame, self._number = topology.frame, topology.number
        self.edges: list[float] = []
        self.turns: list[float] = []
        heads = [*self._joints(frame), *self._ties(frame), *self._supports(frame)]
        self.order = preference([ends for _, ends, _ in heads], [strength for _, _, strength in heads])
        places: dict[str, int] = {}
        on = tuple([None if body is None else places.setdefault(body, len(places)) for body in topology.bodies])
        for body in places:
            self.turns += frame.bodies[body].axes.reshape(-1).tolist()
        turns = tuple([turn if turn in UNITS else 2.0 for turn in self.turns])
        nonzero = (np.array(self.edges) != 0.0).tobytes()
        self.key: tuple[Hashable, ...] = (
            on,
            (*self.order,),
            (*((head, ends) for head, ends, _ in heads),),
            nonzero,
            turns,
        )

    def _joints(self, frame: Description) -> list[Head]:
        number, heads = self._number, list[Head]()
        for name, link in frame.joints.items():
            element = link.element
            springs = element.stiffness.reshape(-1).tolist()
            ideal: tuple[int, ...] = ()
            if np.inf in springs:
                ideal = tuple(k for k in range(6) if springs[k] == np.inf)
                springs = [0.0 if spring == np.inf else spring for spring in springs]
            offsets = _six(frame.offsets[name]) if name in frame.offsets else [0.0] * 6
            self.edges += [*springs, float(element.pitch / (2.0 * np.pi)), *offsets]
            if element.axes is not None:
                self.turns += element.axes.reshape(-1).tolist()
            ends = number[link.first], number[link.second]
            heads.append((("joint", ideal, element.axes is None), ends, (len(ideal), max(springs))))
        return heads

    def _ties(self, frame: Description) -> list[Head]:
        number, heads = self._number, list[Head]()
        for tie in frame.ties:
            self.edges += _ALL_OF_THEM
            if tie.rigid:
                self.turns += (frame.position(tie.slave) - frame.position(tie.master)).reshape(-1).tolist()
            ends = number[tie.master], number[tie.slave]
            heads.append((("tie", tie.components, tie.rigid), ends, (len(tie.components), 0.0)))
        return heads

    def _supports(self, frame: Description) -> list[Head]:
        number, heads = self._number, list[Head]()
        for node, constrained in frame.supports.items():
            self.edges += (*_ALL_OF_THEM[:OFFSETS], *_six(constrained))
            ideal = (*sorted(constrained),)
            heads.append((("support", ideal), (GROUND, number[node]), (len(ideal), 0.0)))
        return heads


class EntryNumbers:
    """The numbers of a frame with a single batch entry, without its loads.

    Parameters
    ----------
    topology
        Its nodes and members.
    stacks
        Stiffness matrices of the members, stack by stack, if they are known; computed where None.
    links
        Its joints, ties, supports and bodies, if they are known; found where None.

    Attributes
    ----------
    stacks
        Stiffness matrices of the members in the nodes' axes, (n, 12, 12) for each stack.
    links
        Joints, ties, supports and bodies.
    key
        What each number belongs to, and which are zero.
    former
        The program that was last run on these numbers, in which way, and the results of its first part.
    """

    def __init__(
        self, topology: Topology, stacks: list[NDArray[Any]] | None = None, links: EntryLinks | None = None
    ) -> None:
        self.topology = topology
        self.stacks = [_stack(group) for group in topology.groups] if stacks is None else stacks
        self.links = EntryLinks(topology) if links is None else links
        self.former: tuple[Any, Any, tuple[list[Any], Any]] | None = None
        stacks_of = [
            (dofs.tobytes(), (stack != 0.0).tobytes())
            for dofs, stack in zip(topology.stack_dofs, self.stacks, strict=True)
        ]
        self.key: tuple[Hashable, ...] = *self.links.key, *stacks_of

    def __getstate__(self) -> dict[str, Any]:
        """The fields to pickle: without the last program, which another process records itself."""
        return vars(self) | {"former": None}


class EntryLoads:
    """The loads on a frame with a single batch entry.

    Parameters
    ----------
    topology
        Its nodes and members, and the loads on them.
    grid
        The batch, with a single entry.

    Attributes
    ----------
    nodal
        Node, component and value of each load at a node that is not zero.
    shares
        DOF and value of the equivalent nodal loads of members, and of the weights of masses.
    key
        Nodes, components and DOFs of the loads, without their values.
    """

    def __init__(self, topology: Topology, grid: Grid) -> None:
        loads = component_loads(topology)
        self.nodal = [(node, k, push) for node, k, value in loads if (push := float(value)) != 0.0]
        found = member_and_mass_loads(topology, grid)
        self.shares = [(dof, float(share)) for dof, share in found if not is_zero(share)]
        self.values = [value for _, _, value in self.nodal] + [value for _, value in self.shares]
        self.key = tuple([(node, k) for node, k, _ in self.nodal]), tuple([dof for dof, _ in self.shares])


def _stack(group: Group) -> NDArray[Any]:
    """Stiffness matrices of a group of members, (n, 12, 12); cached for members on a body, in whose axes they stay the
    same while it moves.
    """
    if group.body is None or group.axes != (None, None) or group.stacked or not is_proven(group.element):
        return group.extended_stiffness()

    def made() -> NDArray[Any]:
        found = group.extended_stiffness()
        found.setflags(write=False)
        return found

    key = group.element.kind, group.chord.tobytes(), group.counts.tobytes()
    found: NDArray[Any] = STACKS.found(key, made, 144 * len(group.pieces))
    return found


def _six(given: Mapping[int, Any]) -> list[float]:
    return [float(given[k]) if k in given else 0.0 for k in range(6)]


def forest(frame: Description) -> bool:
    """Whether joints, ties and supports close no loop: then they cannot contradict each other."""
    pairs = [(link.first, link.second) for link in frame.joints.values()]
    pairs += [(tie.master, tie.slave) for tie in frame.ties]
    # no node has an empty name
    pairs += [("", node) for node in frame.supports]
    return bool(PATTERNS.found(("forest", *pairs), lambda: all(joining(pairs)), len(pairs)))
