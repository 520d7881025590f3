"""The deformed structure as surfaces to look at: members, joints, supports and forces, at every pose."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..batch import Array
from ..errors import FrameError
from ..graphics.deformed import named_places, round_scale
from ..graphics.diagrams import between_segment_ends
from ..graphics.free_modes import free_modes
from ..graphics.units import quantity, scaled, stress_unit
from ..paraview.entries import Index
from ..paraview.scene import beams, placed, solved, taken
from .bearings import Bearing, bearings
from .shapes import Surface, arrows, block, cone, copies, joined, sphere, tubes, upright

if TYPE_CHECKING:
    from ..solution import Solution

STATIONS = 24
# What can colour the members, in words.
COLOURS = {"von_mises": "von Mises stress", "displacement": "displacement"}
# Ends of a colour range, per power of ten.
TOPS = (1.0, 1.2, 1.6, 2.0, 2.4, 2.8, 3.2, 4.0, 5.0, 6.0, 8.0)
# Largest displacement and longest arrow drawn, as shares of the structure's size.
SHOWN, LONGEST = 0.08, 0.16
# Places up to which they are named: more names hide what they name.
MOST_NAMED = 40


@dataclass(frozen=True)
class Drawing:
    """Content of a picture or movie at T poses.

    Attributes
    ----------
    rest, shift, values
        Points of the members and their displacements (T, m, k, 3), and the values that colour them (T, m, k).
    joints
        Joints and their displacements, two arrays (T, j, 3).
    supports, constrained
        Supported nodes (T, s, 3) and which of their components are constrained (s, 6).
    members_at
        Sum of the unit vectors along the members that leave each supported node, (T, s, 3).
    loaded, forces
        Loaded nodes and their displacements, two arrays (T, f, 3), and the forces there (T, f, 3).
    scale
        Factor on the displacements.
    solved
        Whether there is a solution, (T,).
    label
        Name of the values, with their unit.
    force_unit
        Unit of the forces.
    free
        Free motion of the nodes at poses without a solution, (T, n, 3), the largest if there are several; else zero.
    nodes
        All nodes and their displacements, two arrays (T, n, 3).
    names
        Names of places, and the node at each.
    status
        What is told of poses without a solution, (T,).
    bearings, bearings_at
        Those of joints with clearance, and where they are, two arrays (T, b, 3).
    """

    rest: Array
    shift: Array
    values: Array
    joints: tuple[Array, Array]
    supports: Array
    constrained: NDArray[np.bool_]
    members_at: Array
    loaded: tuple[Array, Array]
    forces: Array
    scale: float
    solved: NDArray[np.bool_]
    label: str = ""
    force_unit: str = "N"
    free: Array = field(default_factory=lambda: np.zeros((1, 0, 3)))
    nodes: tuple[Array, Array] = field(default_factory=lambda: (np.zeros((1, 0, 3)), np.zeros((1, 0, 3))))
    names: tuple[tuple[str, int], ...] = ()
    status: tuple[str, ...] = ()
    bearings: tuple[Bearing, ...] = ()
    bearings_at: tuple[Array, Array] = field(default_factory=lambda: (np.zeros((1, 0, 3)), np.zeros((1, 0, 3))))

    @property
    def top(self) -> float:
        """A round number not below any value, whose quarters are round too; 1 where all values are zero.

        Springs and poses that are not solved have no value.
        """
        greatest = float(self.values.max(initial=0.0, where=np.isfinite(self.values)))
        if greatest <= 0.0:
            return 1.0
        power = 10.0 ** np.floor(np.log10(greatest))
        return float(min(step * power for step in (*TOPS, 10.0) if step * power >= greatest))

    @cached_property
    def points(self) -> Array:
        """Members, deformed and not, at all poses, (n, 3)."""
        return np.concatenate([self.rest, self.rest + self.scale * self.shift]).reshape(-1, 3)

    @cached_property
    def seen(self) -> Array:
        """The members' points and the far ends of the arrows, at all poses, (n, 3)."""
        nodes, moved = self.loaded
        tails = nodes + self.scale * moved - self._arrows
        tips = self.nodes[0] + self._moves if self.free.any() else np.zeros((0, 3))
        rings = [self._bearings(pose).points for pose in range(len(self.rest))] if self.bearings else []
        return np.concatenate([self.points, tails.reshape(-1, 3), tips.reshape(-1, 3), *rings])

    def told_names(self, pose: int) -> list[tuple[Array, str]]:
        """Places (3,) of the labels of nodes, beside the nodes, and the names."""
        places = self._displaced(self.nodes, pose) + 4.0 * self._radius * self.up
        return [(places[node], name) for name, node in self.names]

    def told_forces(self, pose: int) -> list[tuple[Array, str]]:
        """Start (3,) of each arrow, and its force as text; forces of zero have none."""
        sizes = np.linalg.norm(self.forces[pose], axis=-1)
        tails = self._displaced(self.loaded, pose) - 1.12 * self._arrows[pose]
        return [(tail, quantity(size, self.force_unit)) for tail, size in zip(tails, sizes, strict=True) if size > 0.0]

    @property
    def margin(self) -> float:
        """Greatest distance of surfaces from the points: the thickness of members and supports."""
        return 3.7 * self._radius

    @cached_property
    def across(self) -> int | None:
        """The global axis at right angles to a plane structure; None for one in space."""
        return plane_of(self.points)

    @property
    def up(self) -> Array:
        """The upward direction of the picture: y if it shows the xy plane, else z."""
        up: Array = np.eye(3)[1 if self.across == 2 else 2]
        return up

    def surfaces(self, pose: int) -> dict[str, Surface]:
        """Surfaces of one pose by kind, without empty kinds."""
        shapes = {
            "undeformed": tubes(self.rest[pose], self.values[pose], 0.35 * self._radius),
            "members": tubes(self.rest[pose] + self.scale * self.shift[pose], self.values[pose], self._radius),
            "joints": self._joints(pose),
            "bearings": self._bearings(pose),
            "clamps": self._supports(pose, block(), self._clamped, self._inwards(pose)),
            "pins": self._supports(pose, cone(), self._pinned, self._upheld),
            "forces": self._forces(pose),
            "free": self._free(pose),
        }
        return {kind: shape for kind, shape in shapes.items() if len(shape.points)}

    @cached_property
    def _radius(self) -> float:
        """Radius of the members: thin against the structure and against themselves."""
        length = np.linalg.norm(self.rest[:, :, -1] - self.rest[:, :, 0], axis=-1)
        return min(0.01 * diagonal(self.rest), 0.06 * float(np.median(length)))

    @property
    def _counts(self) -> NDArray[np.bool_]:
        """Which components matter to the supports: in a plane structure those in its plane, (6,)."""
        if self.across is None:
            return np.ones(6, dtype=bool)
        turning = np.arange(3) == self.across
        return np.concatenate([~turning, turning])

    @property
    def _clamped(self) -> NDArray[np.bool_]:
        clamped: NDArray[np.bool_] = np.all(self.constrained | ~self._counts, axis=1)
        return clamped

    @property
    def _pinned(self) -> NDArray[np.bool_]:
        constrained: NDArray[np.bool_] = np.any((self.constrained & self._counts)[:, :3], axis=1)
        return constrained & ~self._clamped

    def _joints(self, pose: int) -> Surface:
        places = self._displaced(self.joints, pose)
        axes = np.broadcast_to(np.eye(3), (len(places), 3, 3))
        return copies(sphere(), places, np.full(len(places), 1.6 * self._radius), axes)

    def _bearings(self, pose: int) -> Surface:
        """Rings about the journals, as much wider as the clearance is to the scale of the displacements."""
        places = self._displaced(self.bearings_at, pose)
        return joined(
            [
                each.surface(pose, place, 1.6 * self._radius, self.scale * each.clearance[pose], 0.3 * self._radius)
                for each, place in zip(self.bearings, places, strict=True)
            ]
        )

    def _supports(self, pose: int, template: Surface, chosen: NDArray[np.bool_], directions: Array) -> Surface:
        places, axes = self.supports[pose, chosen], upright(directions[chosen])
        return copies(template, places, np.full(len(places), 2.6 * self._radius), axes)

    def _inwards(self, pose: int) -> Array:
        """Direction from each support into the structure, upwards where no member says, (s, 3)."""
        clear = np.linalg.norm(self.members_at[pose], axis=-1, keepdims=True) > 1e-3
        return np.where(clear, self.members_at[pose], self.up)

    @property
    def _upheld(self) -> Array:
        """Upwards where a support holds that way, else a direction in which it holds, (s, 3)."""
        constrained = (self.constrained & self._counts)[:, :3]
        return np.where((constrained @ self.up > 0.0)[:, None], self.up, np.eye(3)[constrained.argmax(axis=1)])

    @property
    def _arrows(self) -> Array:
        """The forces as long as they are drawn, (T, f, 3)."""
        greatest = float(np.linalg.norm(self.forces, axis=-1).max(initial=np.finfo(float).tiny))
        return LONGEST * diagonal(self.rest) / greatest * self.forces

    def _forces(self, pose: int) -> Surface:
        """Arrows that end at the loaded nodes."""
        return arrows(self._displaced(self.loaded, pose), self._arrows[pose], self.up)

    @property
    def _moves(self) -> Array:
        """The free motion as long as it is drawn, (T, n, 3)."""
        return np.asarray(LONGEST * diagonal(self.rest) * self.free)

    def _free(self, pose: int) -> Surface:
        """Arrows that begin at the nodes; of those that do not move in any pose there are none."""
        moving = np.linalg.norm(self.free, axis=-1).max(axis=0) > 1e-6
        drawn = self._moves[pose][moving]
        return arrows(self.nodes[0][pose][moving] + drawn, drawn, self.up)

    def _displaced(self, nodes: tuple[Array, Array], pose: int) -> Array:
        rest, shift = nodes
        places: Array = rest[pose] + self.scale * shift[pose]
        return places


def drawing(
    solution: Solution,
    index: Index,
    scale: float | None,
    colour: str,
    units: tuple[str, str] = ("m", "N"),
    names: bool = True,
) -> Drawing:
    """Collect what is drawn of the batch entries `index`.

    Parameters
    ----------
    solution
        What `Frame.solve` returned.
    index
        Index into the batch that leaves one axis.
    scale
        Factor on the displacements; None for a round one that makes them visible.
    colour
        One of `COLOURS`.
    units
        Units of length and force, of which that of the values is made.
    names
        Whether places are named, where they are no more than `MOST_NAMED`.
    """
    frame = solution.frame
    if not frame.members:
        raise FrameError("the frame has no member to draw: add one")
    part = beams(solution, index, STATIONS)
    count = len(frame.members)

    def by_member(array: Array) -> Array:
        return array.reshape(len(array), count, STATIONS + 1, *array.shape[2:])

    shift = by_member(part.point_data["displacement"])
    values = np.linalg.norm(shift, axis=-1) if colour == "displacement" else by_member(part.point_data[colour])
    if colour == "von_mises":
        values = between_segment_ends(solution, index, values)
    greatest = float(np.abs(values).max(initial=0.0, where=np.isfinite(values)))
    factor, unit = scaled(greatest, units[0] if colour == "displacement" else stress_unit(units))
    loads = {node: force for node in frame.loads if np.any(force := _force(solution, node))}
    rest = by_member(part.points)
    joints = list(frame.joints.values())
    shown_bearings = bearings(solution, index, plane_of(rest + shift))
    return Drawing(
        rest=rest,
        shift=shift,
        values=factor * values,
        joints=_nodes(solution, index, [link.first for link in joints]),
        supports=_nodes(solution, index, list(frame.supports))[0],
        constrained=np.array(
            [[k in constrained for k in range(6)] for constrained in frame.supports.values()], dtype=bool
        ).reshape(-1, 6),
        members_at=_stacked(solution, index, [_leaving(solution, node) for node in frame.supports]),
        loaded=_nodes(solution, index, list(loads)),
        forces=_stacked(solution, index, list(loads.values())),
        scale=round_scale(shift, SHOWN * diagonal(rest)) if scale is None else scale,
        solved=solved(solution, index),
        label=f"{COLOURS[colour]} [{unit}]",
        force_unit=units[1],
        free=_free_motions(solution, index),
        nodes=_nodes(solution, index, list(frame.nodes)),
        names=_names(solution, index) if names else (),
        status=tuple(np.broadcast_to(solution.status, solution.shape)[index].tolist()),
        bearings=shown_bearings,
        bearings_at=_nodes(solution, index, [joints[each.joint].second for each in shown_bearings]),
    )


def _free_motions(solution: Solution, index: Index) -> Array:
    """Free motion of all nodes where there is no solution, else zero, (T, nodes, 3)."""
    there = solved(solution, index)
    out = np.zeros((len(there), len(solution.frame.nodes), 3))
    each = np.arange(int(np.prod(solution.shape))).reshape(solution.shape)[index]
    for pose in np.flatnonzero(~there):
        modes = free_modes(solution, [int(k) for k in np.unravel_index(each[pose], solution.shape)])
        out[pose] = modes[0] if len(modes) else 0.0
    return out


def _names(solution: Solution, index: Index) -> tuple[tuple[str, int], ...]:
    """Names of places at the first pose, and the node at each; none where they are many."""
    nodes = list(solution.frame.nodes)
    if len(nodes) > 4 * MOST_NAMED:
        return ()
    at = dict(zip(nodes, _nodes(solution, index, nodes)[0][0], strict=True))
    named = named_places(at, 1e-6 * (diagonal(np.array(list(at.values()))) or 1.0))
    numbers = [int(np.argmin([np.linalg.norm(place - other) for other in at.values()])) for _, place in named]
    return tuple(zip([name for name, _ in named], numbers, strict=True)) if len(named) <= MOST_NAMED else ()


def plane_of(points: Array) -> int | None:
    """The global axis at right angles to a plane in which points (..., 3) lie; None where there is none."""
    extent = np.ptp(points.reshape(-1, 3), axis=0)
    # The last of equals, so that what lies on a line is seen in the xy plane.
    axis = 2 - int(extent[::-1].argmin())
    return axis if extent[axis] <= 1e-3 * extent.max() else None


def diagonal(points: Array) -> float:
    """Diagonal of the box around points (..., 3)."""
    flat = points.reshape(-1, 3)
    return float(np.linalg.norm(flat.max(axis=0) - flat.min(axis=0)))


def _force(solution: Solution, node: str) -> Array:
    """Sum of the forces at a node, (..., 3)."""
    force = np.zeros((*solution.shape, 3))
    for component, value in solution.frame.loads[node]:
        if component < 3:
            force[..., component] += value
    return force


def _leaving(solution: Solution, node: str) -> Array:
    """Sum of the unit vectors along the members that leave a node, (..., 3)."""
    frame = solution.frame
    total = np.zeros(3)
    for member in frame.members.values():
        if node in (member.start, member.end):
            chord = frame.position(member.end if node == member.start else member.start) - frame.position(node)
            total = total + chord / np.linalg.norm(chord, axis=-1, keepdims=True)
    return total


def _nodes(solution: Solution, index: Index, names: list[str]) -> tuple[Array, Array]:
    """Positions and displacements of nodes, each (T, n, 3)."""
    places = _stacked(solution, index, [solution.frame.position(name) for name in names])
    moved = _stacked(solution, index, [solution.displacement(name)[..., :3] for name in names])
    return places, placed(np.where(solved(solution, index)[:, None, None], moved, 0.0))


def _stacked(solution: Solution, index: Index, vectors: list[Array]) -> Array:
    """Vectors (..., 3) at the entries `index`, (T, n, 3)."""
    empty = np.zeros((*solution.shape, 0, 3))[index]
    return taken(solution, index, [v[..., None, :] for v in vectors])[:, :, 0] if vectors else empty
