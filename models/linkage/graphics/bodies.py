"""A motion as bodies in space: links with their sections, joints by kind, ground, springs, forces."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from ....elements.cross_section import CrossSection
from ....elements.outlines import outlines
from ....framework.batch import Array
from ....framework.graphics.canvas import ARROW, FREE
from ....framework.graphics.deformed import round_scale
from ....framework.graphics.scene import JointSymbol, LoadArrow, Scene
from ....framework.graphics.style import COLOURS
from ....framework.pictures.bearings import ARC_POINTS, circle_arcs
from ....framework.pictures.shapes import Surface, arrow, arrows, block, copies, joined, prism, sphere, tubes, upright
from ..description.parts import LinkageLink, Pair
from .places import FREE_TEXT, DrawnPoses, PosePlaces, beam_axes, free_arrows
from .plane import plane
from .regions import DrawnRegion, drawn_regions, magnified, outline_of, told
from .scene import lines, linkage_scene

# Size at which the largest clearance is drawn, in radii of a pin.
SHOWN = 1.2
BEARING = "#1b7f5c"
STEEL, DRIVE, GROUND_COLOUR, FORCE = "#3a3f4a", "#d55e00", "#9aa0aa", "#c8352b"
SQUARE = np.array([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)])
# Half length along the axis and half width of joints drawn as boxes, and half length of those drawn as cylinders, in
# radii of a pin.
BOXES = {"prismatic": (2.4, 1.4), "planar": (0.5, 2.2), "fixed": (1.2, 1.2)}
ROUND = {"revolute": 1.8, "cylindrical": 3.4, "screw": 2.6, "universal": 1.8}


@dataclass(frozen=True, eq=False)
class Looks:
    """Options of a picture.

    Attributes
    ----------
    regions, level, magnify
        Regions about points, the probability of ellipsoids, and the factor on them; see `drawn_regions`.
    clearances
        Factor on the clearances; a round one if None; 0 draws none.
    names
        Whether points are named.
    units
        Units of length and force.
    """

    regions: object = None
    level: float = 0.95
    magnify: float | None = None
    clearances: float | None = None
    names: bool = True
    units: tuple[str, str] = ("m", "N")


@dataclass(frozen=True, eq=False)
class MotionBodies:
    """Bodies of a motion at some of its poses.

    Attributes
    ----------
    motion
        The motion.
    poses
        Flat indices of the poses drawn.
    looks
        Options of the picture.
    scenes
        Scenes by number of the pose, made when first asked for.
    """

    motion: DrawnPoses
    poses: tuple[int, ...]
    looks: Looks = Looks()
    scenes: dict[int, Scene] = field(default_factory=dict)

    def scene(self, pose: int) -> Scene:
        """Lines, symbols and texts of one of the poses, by its number in `poses`."""
        if pose not in self.scenes:
            places = PosePlaces(self.motion, self.poses[pose])
            scene = linkage_scene(places, self.flat, names=self.looks.names, force_unit=self.looks.units[1])
            scene.moves.extend(free_arrows(self.motion, self.poses[pose]))
            self.scenes[pose] = scene
        return self.scenes[pose]

    @property
    def flat(self) -> tuple[int, int] | None:
        """The plane of the motion; None in space."""
        return plane(self.motion)

    @property
    def seen(self) -> Array:
        """Points that must be in view, at all poses, (n, 3)."""
        scenes = [self.scene(k) for k in range(len(self.poses))]
        tips = [a.at + self.arrow(s, a.force) for s in scenes for a in s.arrows]
        ways = np.concatenate([np.eye(3), -np.eye(3)])
        for region in self.regions:
            for pose in self.poses:
                at = PosePlaces(self.motion, pose).position(region.point, region.link)
                tips += list(at + np.nan_to_num(self.region_scale * region.outermost(pose, ways)))
        tips += [each.at + ARROW * scene.size * each.force for scene in scenes for each in scene.moves]
        return np.concatenate([*(scene.points for scene in scenes), np.reshape(tips, (-1, 3))])

    @property
    def across(self) -> int | None:
        """The global axis of view for a planar motion; None for a motion in space."""
        return None if self.flat is None else 3 - sum(self.flat)

    @property
    def up(self) -> Array:
        """Unit vector that points upwards in the picture: y if it shows the xy plane, else z."""
        return np.asarray(np.eye(3)[1 if self.across == 2 else 2])

    @property
    def margin(self) -> float:
        """Distance by which bodies extend beyond the points, a length."""
        return 4.5 * self.pin

    @property
    def pin(self) -> float:
        """Radius of a pin: as large as the thickest section, within limits relative to the linkage's size."""
        scene = self.scene(0)
        thick = [float(np.abs(part).max()) for _, parts in self._sections() for part in parts]
        least, most = scene.pin(scene.size), 0.03 * scene.size
        return float(np.clip(1.05 * max(thick, default=0.0), least, most))

    def arrow(self, scene: Scene, force: Array) -> Array:
        """Vector of the arrow by which a force is drawn, (3,)."""
        longest = max(float(np.linalg.norm(each.force)) for each in scene.arrows)
        return np.asarray(ARROW * scene.size * force / longest)

    @cached_property
    def regions(self) -> list[DrawnRegion]:
        """Regions about points."""
        return drawn_regions(self.motion, self.looks.regions, self.looks.level)

    @cached_property
    def region_scale(self) -> float:
        """Factor on the regions."""
        if self.looks.magnify is not None:
            return self.looks.magnify
        return magnified(self.regions, self.poses, self.scene(0).size)

    @cached_property
    def clearance_scale(self) -> float:
        """Factor on the clearances; 0 if none are drawn."""
        if self.looks.clearances is not None:
            return self.looks.clearances
        most = max(
            (float(np.max(gap)) for pair in self._with_clearance if (gap := pair.clearance) is not None), default=0.0
        )
        return round_scale(np.array([[most, 0.0, 0.0]]), SHOWN * self.pin) if most > 0.0 else 0.0

    @property
    def _with_clearance(self) -> list[Pair]:
        """Joints with clearance."""
        return [pair for pair in self.motion.linkage.joints.values() if pair.clearance is not None]

    @cached_property
    def caption(self) -> str:
        """Text with the factors on regions and clearances, and the meaning of arrows."""
        lines = [told(self.regions, self.region_scale)]
        if self._with_clearance and self.clearance_scale > 0.0:
            lines.append(f"clearances × {self.clearance_scale:g}")
        if self._most_moving:
            lines.append(FREE_TEXT)
        return "\n".join(line for line in lines if line)

    def surfaces(self, pose: int) -> dict[str, tuple[Surface, str]]:
        """Bodies and their colours by name; they have the same names and topology at all poses."""
        places, scene = PosePlaces(self.motion, self.poses[pose]), self.scene(pose)
        found = {}
        for number, link in enumerate(self.motion.linkage.links.values()):
            found[f"link {link.name}"] = joined(list(self._link(places, link))), COLOURS[number % len(COLOURS)]
        for name, colour, driven in (("joints", STEEL, False), ("drives", DRIVE, True)):
            bodies = [body for joint in scene.joints if joint.driven is driven for body in self._joint(joint)]
            found[name] = joined(bodies), colour
        found["ground"] = joined([self._foot(joint) for joint in scene.joints if joint.grounded]), GROUND_COLOUR
        lines = [self._tube(stroke.points, 0.25) for stroke in scene.strokes if stroke.kind == "spring"]
        found["springs"] = joined(lines), STEEL
        found["forces"] = joined([self._force(scene, each.at, each.force) for each in scene.arrows]), FORCE
        if self.clearance_scale > 0.0:
            rings = [self._bearing(places, joint) for joint in scene.joints]
            found["clearances"] = joined([ring for each in rings for ring in each]), BEARING
        if self._most_moving:
            found["free"] = self._free(scene), FREE
        for number, region in enumerate(self.regions):
            colour = COLOURS[(number + 3) % len(COLOURS)]
            found[f"region {region.point} {number}"] = self._region(region, self.poses[pose]), colour
        return {name: (body, colour) for name, (body, colour) in found.items() if len(body.points)}

    def _sections(self) -> Iterator[tuple[tuple[str, str], list[Array]]]:
        for link in self.motion.linkage.links.values():
            for pair, beam in link.beams.items():
                section = getattr(beam, "section", None)
                if isinstance(section, CrossSection):
                    yield pair, outlines(section)

    def _link(self, places: PosePlaces, link: LinkageLink) -> Iterator[Surface]:
        """Beams with their sections, other elements as round bars, and a rigid link as bars along its outline."""
        if not link.beams and len(link.points) > 1:
            yield from (self._tube(line, 0.6) for line in lines(places, link))
        at = {point: places.position(point, link.name) for point in link.points}
        for (first, second), beam in link.beams.items():
            section = getattr(beam, "section", None)
            if not isinstance(section, CrossSection):
                yield self._tube(np.stack([at[first], at[second]]), 0.6)
                continue
            rotated = beam_axes(places, (first, second), beam) @ places.value(self.motion.axes(link.name), 2).T
            for part in outlines(section):
                yield prism(part, at[first], at[second], rotated)

    def _tube(self, line: Array, share: float) -> Surface:
        """Round bars along the segments of a line (k, 3)."""
        curves = np.stack([line[:-1], line[1:]], axis=1)
        long = np.linalg.norm(curves[:, 1] - curves[:, 0], axis=-1) > 0.0
        return tubes(curves[long], np.zeros((int(long.sum()), 2)), share * self.pin)

    def _joint(self, joint: JointSymbol) -> Iterator[Surface]:
        pin, rows = self.pin, joint.axes.T[[2, 0, 1]]
        if joint.kind in BOXES:
            half, width = BOXES[joint.kind]
            yield prism(width * pin * SQUARE, joint.at - half * pin * rows[0], joint.at + half * pin * rows[0], rows)
        elif joint.kind == "spherical":
            yield copies(sphere(), joint.at[None], np.array([1.7 * pin]), np.eye(3)[None])
        else:
            ways = rows[:2] if joint.kind == "universal" else rows[:1]
            for way in ways:
                yield self._cylinder(joint.at, way, ROUND.get(joint.kind, 1.8))

    def _cylinder(self, at: Array, way: Array, half: float) -> Surface:
        """A pin along a unit vector; `half` is half its length in its radii."""
        body = copies(block(), np.zeros((1, 3)), np.ones(1), upright(way[None]))
        # the template is as long as it is thick, with its upper end at the origin
        along = body.points @ way
        round_part = 1.25 * self.pin * (body.points - along[:, None] * way)
        points = round_part + self.pin * half * (2.0 * along[:, None] + 1.0) * way
        return Surface(at + points, body.normals, body.faces, body.values)

    def _bearing(self, places: PosePlaces, joint: JointSymbol) -> Iterator[Surface]:
        """The bearing of a joint with clearance, as rings or frames about its journal."""
        pair = self.motion.linkage.joints[joint.name]
        if pair.clearance is None:
            return
        gap = self.clearance_scale * float(places.value(pair.clearance, 0))
        rows, thick = joint.axes.T[[2, 0, 1]], 0.16 * self.pin
        if joint.kind in BOXES:
            half, width = BOXES[joint.kind]
            corners = (width * self.pin + gap) * SQUARE @ rows[1:]
            for end in (-half, half):
                frame = joint.at + end * self.pin * rows[0] + np.concatenate([corners, corners[:1]])
                yield tubes(np.stack([frame[:-1], frame[1:]], axis=1), np.zeros((4, 2)), thick)
            return
        if joint.kind == "spherical":
            around = [(joint.at, rows[k], 1.7) for k in range(3)]
        else:
            half = ROUND.get(joint.kind, 1.8)
            around = [(joint.at + end * half * self.pin * rows[0], rows[0], 1.25) for end in (-1.0, 1.0)]
        for at, axis, radius in around:
            yield tubes(circle_arcs(at, axis, radius * self.pin + gap), np.zeros((4, ARC_POINTS)), thick)

    @cached_property
    def _most_moving(self) -> int:
        """Largest number of arrows of a free motion over the poses."""
        return max(len(self.scene(k).moves) for k in range(len(self.poses)))

    def _free(self, scene: Scene) -> Surface:
        """Arrows of a free motion, the same number at each pose; those that are not needed have no length."""
        nothing = [LoadArrow(scene.points[0], np.zeros(3), "")] * (self._most_moving - len(scene.moves))
        shown = [*scene.moves, *nothing]
        ways = ARROW * scene.size * np.array([each.force for each in shown])
        return arrows(np.array([each.at for each in shown]) + ways, ways, self.up)

    def _region(self, region: DrawnRegion, pose: int) -> Surface:
        """A region as a body about its point, in a plane as a prism; thickened to remain visible."""
        least = 0.1 * self.pin
        if self.flat is None:
            ball = sphere()
            at = PosePlaces(self.motion, pose).position(region.point, region.link)
            reach = self.region_scale * region.outermost(pose, ball.normals)
            return Surface(at + np.nan_to_num(reach) + least * ball.normals, ball.normals, ball.faces, ball.values)
        first, second = self.flat
        corners = np.nan_to_num(outline_of(self.motion, region, pose, self.flat, self.region_scale))
        middle = corners.mean(axis=0)
        turn = np.linspace(0.0, 2.0 * np.pi, len(corners), endpoint=False)
        flat = (corners - middle)[:, [first, second]] + least * np.stack([np.cos(turn), np.sin(turn)], axis=-1)
        rows = np.stack([np.cross(np.eye(3)[first], np.eye(3)[second]), np.eye(3)[first], np.eye(3)[second]])
        # it extends beyond the bodies at the point on both sides, so as to be visible from everywhere
        return prism(flat, middle - 4.0 * self.pin * rows[0], middle + 4.0 * self.pin * rows[0], rows)

    def _foot(self, joint: JointSymbol) -> Surface:
        """Ground below a joint, in the picture's upward direction."""
        up = self.up
        side = np.eye(3)[0] if abs(up[0]) < 0.5 else np.eye(3)[1]
        rows = np.stack([-up, side, np.cross(-up, side)])
        top = joint.at - 1.3 * self.pin * up
        return prism(1.9 * self.pin * SQUARE, top, top - 1.2 * self.pin * up, rows)

    def _force(self, scene: Scene, at: Array, force: Array) -> Surface:
        """An arrow of a force that starts at its point of application."""
        drawn = self.arrow(scene, force)
        length = float(np.linalg.norm(drawn))
        return copies(arrow(), (at + drawn)[None], np.array([length]), upright(drawn[None]))
