"""A linkage for programs of rigid-body dynamics: bodies on a tree of joints, and the joints that close its loops."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ....framework.batch import Array
from ..description.linkage_description import LinkageDescription
from ..description.parts import GROUND, Pair
from ..kinematics.tree import LinkBranch, spanning_tree
from .placed import BodyMass, Placed

# Kinds of joints that can close a loop directly. For others the joint carries a part of the link as a body of its own,
# which is fixed to the link.
CLOSING = ("spherical", "revolute", "fixed")


@dataclass(frozen=True, eq=False)
class TreeStep:
    """One motion of a joint: of the child relative to its parent along or about `axis`, or that of a spherical joint.

    Attributes
    ----------
    name
        Name of the joint, followed by the component if the joint has several.
    joint, component
        Joint, and ``ux uy uz rx ry rz`` or ``ball``.
    axis
        Direction (3,), global in the reference configuration, along or about which the coordinate increases.
    reference
        Coordinate in the reference configuration.
    """

    name: str
    joint: str
    component: str
    axis: Array
    reference: float

    @property
    def is_rotation(self) -> bool:
        """Whether it turns about its axis."""
        return self.component[0] == "r"


@dataclass(frozen=True, eq=False)
class TreeBody:
    """A body of the tree: a link, or a part of one.

    Attributes
    ----------
    name, parent
        Names of the body and of the one that carries it.
    joint
        The joint between them.
    is_reversed
        Whether this body is the joint's first link.
    steps
        Motions of the joint in their order from the parent to this body.
    origin
        The joint's point, (3,), global in the reference configuration.
    mass
        Mass and inertia.
    points
        Positions (3,) of its points, by name.
    lines
        Pairs of points between which it is drawn.
    part_of
        The link of which it is a part; None for a whole link.
    """

    name: str
    parent: str
    joint: Pair
    is_reversed: bool
    steps: tuple[TreeStep, ...]
    origin: Array
    mass: BodyMass
    points: dict[str, Array]
    lines: tuple[tuple[str, str], ...]
    part_of: str | None = None


@dataclass(frozen=True, eq=False)
class LoopClosure:
    """A joint that closes a loop: its kind, the two bodies, its global position (3,) and axis (3,)."""

    name: str
    kind: str
    first: str
    second: str
    place: Array
    axis: Array


@dataclass(frozen=True, eq=False)
class BodyTree:
    """Bodies from the ground outwards, loop closures, and the linkage in its reference configuration."""

    placed: Placed
    bodies: list[TreeBody]
    closures: list[LoopClosure]

    @property
    def linkage(self) -> LinkageDescription:
        """Description of the linkage."""
        return self.placed.linkage

    @property
    def steps(self) -> dict[str, TreeStep]:
        """All motions by name."""
        return {step.name: step for body in self.bodies for step in body.steps}


def body_tree(linkage: LinkageDescription) -> BodyTree:
    """The tree of a linkage: its joints are those of the spanning tree by which poses are solved, others close loops.

    Raises
    ------
    FrameError
        If a link is not connected to ground, the description carries a batch, or cannot be assembled.
    """
    placed = Placed(linkage)
    tree = spanning_tree(linkage)
    branches = [branch for branch in tree.branches if branch.child not in tree.twins]
    carried = {branch.edge.name for branch in branches}
    cuts = [linkage.joints[name] for name in sorted(linkage.joints) if name not in carried]
    parts = {pair.name: _part(pair) for pair in cuts if pair.kind.name not in CLOSING or pair.name in linkage.drives}
    bodies = [_body(placed, branch, branch.child, parts) for branch in branches]
    closures = []
    for pair in cuts:
        if pair.name in parts:
            branch = parts[pair.name]
            bodies.append(_body(placed, branch, f"{branch.child} at {pair.name}", parts))
        closures.append(_closure(placed, pair, parts.get(pair.name)))
    return BodyTree(placed, bodies, closures)


def _part(pair: Pair) -> LinkBranch:
    """Branch from a joint's other link to a part of its second link, or of its first if the second is the ground."""
    if pair.second == GROUND:
        return LinkBranch(pair, GROUND, pair.first, -1.0)
    return LinkBranch(pair, pair.first, pair.second, 1.0)


def _body(placed: Placed, branch: LinkBranch, name: str, parts: dict[str, LinkBranch]) -> TreeBody:
    pair, link = branch.edge, branch.child
    is_part = name != link
    own = placed.linkage.links[link]
    names = (pair.point,) if is_part else own.points
    count = 1 + sum(part.child == link for part in parts.values())
    return TreeBody(
        name,
        branch.parent,
        pair,
        branch.is_reversed,
        _steps(placed, branch),
        placed.place(link, pair.point),
        placed.masses[link].part(count),
        {point: placed.place(link, point) for point in names},
        () if is_part else tuple(own.beams) or _outline(own.points),
        link if is_part else None,
    )


def _outline(points: tuple[str, ...]) -> tuple[tuple[str, str], ...]:
    """Lines from point to point, closed to a polygon if there are more than two points."""
    ring = tuple(zip(points, (*points[1:], points[0]), strict=True))
    return ring if len(points) > 2 else ring[: len(points) - 1]


def _steps(placed: Placed, branch: LinkBranch) -> tuple[TreeStep, ...]:
    pair = branch.edge
    components = ("ball",) if pair.kind.name == "spherical" else pair.kind.moving
    axes, values = placed.axes(pair), placed.coordinates(pair)
    sign = branch.sign
    steps = []
    for component in components:
        name = pair.name if len(components) == 1 else f"{pair.name} {component}"
        axis = sign * (axes[:, 2] if component == "ball" else axes[:, "xyz".index(component[1])]) + 0.0
        known = component in pair.kind.coordinates
        reference = float(values[pair.kind.coordinates.index(component)]) if known else 0.0
        steps.append(TreeStep(name, pair.name, component, axis, reference))
    if pair.kind.tied and branch.is_reversed:
        return tuple(steps)  # along one axis the order does not matter, and the angle comes first
    return tuple(reversed(steps) if branch.is_reversed else steps)


def _closure(placed: Placed, pair: Pair, part: LinkBranch | None) -> LoopClosure:
    axis, place = placed.axes(pair)[:, 2], placed.place(pair.first, pair.point)
    if part is None:
        return LoopClosure(pair.name, pair.kind.name, pair.first, pair.second, place, axis)
    return LoopClosure(pair.name, "fixed", f"{part.child} at {pair.name}", part.child, place, axis)


def advance_of(pair: Pair) -> float:
    """Advance of a screw per radian."""
    return 0.0 if pair.pitch is None else float(np.asarray(pair.pitch)) / (2.0 * np.pi)
