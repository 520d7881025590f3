"""Spanning tree of a linkage: which joints carry the links from the ground outwards, and which close loops."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TypeAlias

from ....framework.errors import FrameError
from ....framework.structure.forest import Branch, rooted, spanning
from ..description.joints import KINDS
from ..description.linkage_description import LinkageDescription
from ..description.parts import GROUND, Pair

LinkBranch: TypeAlias = Branch[Pair, str]


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
        By the name of a twin, its link. If a driven joint, a screw or the joint whose turns are counted would close a
        loop, its second link gets a massless twin that the joint carries, and the loop is closed by fixing the twin to
        the link.
    """

    branches: list[LinkBranch]
    cuts: list[Pair]
    twins: dict[str, str]


def spanning_tree(linkage: LinkageDescription, counted: str | None = None) -> Tree:
    """The tree that takes driven joints, screws and the joint `counted` first, then joints with fewest degrees of
    freedom.

    The joints that close loops then have most degrees of freedom, so that the loops have fewest equations. Among equals
    the joint nearest to the ground comes first, then by name, so that the order of description does not matter.
    """
    pairs = [linkage.joints[name] for name in sorted(linkage.joints)]
    depth = {GROUND: 0}
    for branch in rooted(pairs, GROUND):
        if branch.parent in depth:
            depth[branch.child] = depth[branch.parent] + 1
    unsupported = [name for name in linkage.links if name not in depth]
    if unsupported:
        links, are, them = ("links", "are", "them") if len(unsupported) > 1 else ("link", "is", "it")
        raise FrameError(
            f"{links} {', '.join(map(repr, unsupported))} {are} not connected to ground: connect {them} by a chain of "
            f"joints, or leave {them} out"
        )

    def rank(pair: Pair) -> tuple[bool, int, int]:
        near = min(depth[pair.first], depth[pair.second])
        return not carried(linkage, pair, counted), pair.kind.freedom, near

    chosen, _ = spanning(sorted(pairs, key=rank))
    return _with_twins(linkage, rooted(chosen, GROUND), counted)


def carried(linkage: LinkageDescription, pair: Pair, counted: str | None = None) -> bool:
    """Whether the joint's coordinates must be part of the state: it is driven, a screw, or the one `counted`."""
    return pair.name in linkage.drives or pair.kind.name == "screw" or pair.name == counted


def _with_twins(linkage: LinkageDescription, branches: list[LinkBranch], counted: str | None) -> Tree:
    in_tree = {branch.edge.name for branch in branches}
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
        branches.append(Branch(replace(pair, second=twin), pair.first, twin, 1.0))
        cuts.append(
            replace(pair, kind=KINDS["fixed"], first=twin, stiffness=None, clearance=None, pitch=None, contact=None)
        )
    return Tree(branches, cuts, twins)
