"""Which joints carry the links from the ground, and which close loops."""

from __future__ import annotations

import heapq
from dataclasses import dataclass, replace

from ....framework.errors import FrameError
from ..description.joints import KINDS
from ..description.linkage_description import LinkageDescription
from ..description.parts import GROUND, Pair


@dataclass(frozen=True, eq=False)
class Branch:
    """A joint of the spanning tree: `child` is attached to `parent` by `pair`; `is_reversed` where the child is its
    first link."""

    pair: Pair
    parent: str
    child: str
    is_reversed: bool


@dataclass(frozen=True, eq=False)
class Tree:
    """Spanning tree of a linkage.

    Attributes
    ----------
    branches
        Joints of the tree, from the ground outwards.
    cuts
        Joints that close loops.
    twins
        Link by the name of its twin. Where a driven joint, a screw or the joint whose turns are counted would close a
        loop, its second link gets a twin without mass that the joint carries, and the loop is closed by fixing the twin
        to the link.
    """

    branches: list[Branch]
    cuts: list[Pair]
    twins: dict[str, str]


def spanning_tree(linkage: LinkageDescription, counted: str | None = None) -> Tree:
    """The tree with driven joints, screws and the joint `counted` first, and then with the least freedom.

    What it leaves over has the most freedom, so that the loops have the fewest equations (Prim's algorithm; the
    nearest to the ground first among equals, then by name: not in the order in which they were described).
    """
    names = sorted(linkage.joints)
    order = {name: index for index, name in enumerate(names)}
    heap: list[tuple[int, int, int, int, str, str]] = []
    depth, branches = {GROUND: 0}, []

    def visit(link: str) -> None:
        for name in names:
            pair = linkage.joints[name]
            if link in (pair.first, pair.second):
                other = pair.second if link == pair.first else pair.first
                rank = 0 if carried(linkage, pair, counted) else 1
                heapq.heappush(heap, (rank, pair.kind.freedom, depth[link], order[pair.name], link, other))

    visit(GROUND)
    while heap:
        _, _, _, index, parent, child = heapq.heappop(heap)
        if child not in depth:
            pair = linkage.joints[names[index]]
            branches.append(Branch(pair, parent, child, is_reversed=child == pair.first))
            depth[child] = depth[parent] + 1
            visit(child)
    unsupported = [name for name in linkage.links if name not in depth]
    if unsupported:
        links, are, them = ("links", "are", "them") if len(unsupported) > 1 else ("link", "is", "it")
        raise FrameError(
            f"{links} {', '.join(map(repr, unsupported))} {are} not connected to ground: connect {them} by a chain of "
            f"joints, or leave {them} out"
        )
    return _with_twins(linkage, branches, counted)


def carried(linkage: LinkageDescription, pair: Pair, counted: str | None = None) -> bool:
    """True where the joint's coordinates must be known as such: it is driven, a screw, or the one `counted`."""
    return pair.name in linkage.drives or pair.kind.name == "screw" or pair.name == counted


def _with_twins(linkage: LinkageDescription, branches: list[Branch], counted: str | None) -> Tree:
    in_tree = {branch.pair.name for branch in branches}
    cuts, twins = [], {}
    for name in sorted(linkage.joints):
        pair = linkage.joints[name]
        if name in in_tree:
            continue
        if not carried(linkage, pair, counted):
            cuts.append(pair)
            continue
        twin = f"{pair.second} at {pair.name}"
        twins[twin] = pair.second
        branches.append(Branch(replace(pair, second=twin), pair.first, twin, is_reversed=False))
        cuts.append(
            replace(pair, kind=KINDS["fixed"], first=twin, stiffness=None, clearance=None, pitch=None, contact=None)
        )
    return Tree(branches, cuts, twins)
