"""Links and joints of a linkage as bodies, beams and joints of a frame."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise

import numpy as np

from ....elements import Joint
from ....elements.joint import known_joint
from ....framework.batch import ZERO, Array, any_of
from ....framework.described.known_parts import add_body, add_joint, add_node
from ....framework.described.parts import check_ideal
from ....framework.errors import FrameError
from ....framework.frame import Frame
from ....framework.protocol import LineElement
from ..description.joints import COMPONENTS
from ..description.linkage_description import LinkageDescription
from ..description.parts import LinkageLink, Pair
from .guides import Ends, Layout, Slider
from .inertia import beams_with_mass
from .nodes import Nodes

# By link: member, beam, start and end in the link's axes.
Pieces = dict[str, list[tuple[str, LineElement, Array, Array]]]


class LinkBuilder:
    """Adds links and joints to a frame, each where its poses are.

    Parameters
    ----------
    linkage
        The linkage, of which links, joints and names are read.
    frame
        The frame.
    nodes
        Names of its nodes and members.

    Attributes
    ----------
    pieces
        By link: its members in the frame.
    """

    def __init__(self, linkage: LinkageDescription, frame: Frame, nodes: Nodes) -> None:
        self.linkage, self.frame, self.nodes = linkage, frame, nodes
        self.pieces: Pieces = {}

    def add_ground(self, name: str, place: Array) -> None:
        """Add a fixed node."""
        add_node(self.frame, name, place)
        self.frame.fix(name)

    def add_link(
        self, name: str, origin: Array, axes: Array, places: Mapping[str, Array], sliders: Sequence[Slider] = ()
    ) -> Layout:
        """Add a link: its body, nodes, beams or rigid connections.

        Parameters
        ----------
        name
            Name of the link.
        origin, axes
            Where its axes are at each pose, (..., 3) and (..., 3, 3).
        places
            Positions of its points in these axes, (..., 3).
        sliders
            What slides on it.

        Returns
        -------
        Layout
            How its beams are cut.
        """
        link, nodes = self.linkage.links[name], self.nodes.on[name]
        add_body(self.frame, name, origin, axes)
        for point, node in nodes.items():
            add_node(self.frame, node, places[point], name)
        layout = Layout.of(link.beams, places, sliders)
        for node in layout.fractions:
            add_node(self.frame, node, layout.at[node], name)
        self._add_beams(link, layout)
        self._add_rigid(link, places)
        return layout

    def add_joint(self, name: str, element: Joint, first: str, second: str) -> None:
        """Add a joint element between two nodes, which coincide as far as the linkage is assembled.

        Raises
        ------
        FrameError
            If it is ideal at some entries only, or shapes do not broadcast.
        """
        check_ideal(f"joint {name!r}", element.stiffness)
        add_joint(self.frame, name, element, first, second)

    def _add_beams(self, link: LinkageLink, layout: Layout) -> None:
        pieces: list[tuple[LineElement, Ends]] = []
        for pair, beam in beams_with_mass(self.linkage, link).items():
            chain = layout.chains[pair]
            parts = layout.parts(pair, beam) if len(chain) > 2 else [beam]
            pieces += zip(parts, pairwise(chain), strict=True)
        nodes, names = self.nodes.on[link.name], self.nodes.members(link, len(pieces))
        for member, (beam, ends) in zip(names, pieces, strict=True):
            self.frame.add(member, beam, *(nodes.get(end, end) for end in ends))
            self.pieces.setdefault(link.name, []).append((member, beam, layout.at[ends[0]], layout.at[ends[1]]))

    def _add_rigid(self, link: LinkageLink, at: Mapping[str, Array]) -> None:
        """Connect rigidly what no beam joins to the link's first beam, each to the nearest point joined to that beam.

        A link without beams becomes rigid as a whole.
        """
        main = _reached(link, next(iter(link.beams), link.points)[0])
        if len(main) == len(link.points):
            return
        joined = set(main)
        for point in link.points:
            if point not in joined:
                part = _reached(link, point)
                pairs = [(_apart(at[there], at[here]), there, here) for there in sorted(main) for here in sorted(part)]
                _, there, here = min(pairs)
                self.frame.rigid(self.nodes.on[link.name][there], self.nodes.on[link.name][here])
                joined |= part


def joint_element(pair: Pair, stiffness: Array, axes: Array | None, clearance: Array | None) -> Joint:
    """Element of a joint of a linkage.

    Parameters
    ----------
    pair
        The joint.
    stiffness
        Its stiffness in the frame, (..., 6).
    axes
        Its axes, (..., 3, 3); the global ones if None.
    clearance
        Its clearance, (...), or None without.

    Raises
    ------
    FrameError
        If it has clearance in directions in which it is not equally stiff, or shapes do not broadcast.
    """
    gap, advance = ZERO if clearance is None else clearance, ZERO if pair.pitch is None else pair.pitch
    directions: tuple[int, ...] = ()
    if any_of(gap):
        directions = tuple(COMPONENTS.index(name) for name in pair.kind.clearance)
        _check_contact(pair, stiffness[..., directions])
    stiffness.setflags(write=False)
    return known_joint(stiffness, axes, gap, directions, advance)


def _check_contact(pair: Pair, own: Array) -> None:
    """Refuse a clearance if the joint's stiffness is not the same in all clearance directions."""
    wrong = np.any((own != own[..., :1]) | (own == 0.0), axis=-1)
    if np.any(wrong):
        raise FrameError(
            f"joint {pair.name!r} has clearance in {' '.join(pair.kind.clearance)}, where its stiffness is "
            f"{', '.join(f'{each:g}' for each in own[wrong][0])}: give one stiffness above 0 for all of these, or "
            "leave the clearance out, by frame(clearance=False) for a frame alone"
        )


def _reached(link: LinkageLink, point: str) -> set[str]:
    """Points that beams join to `point`, itself included."""
    reached, left = {point}, list(link.beams)
    while touched := [pair for pair in left if pair[0] in reached or pair[1] in reached]:
        reached.update(*touched)
        left = [pair for pair in left if not reached.issuperset(pair)]
    return reached


def _apart(one: Array, other: Array) -> float:
    return float(np.max(np.linalg.norm(other - one, axis=-1)))
