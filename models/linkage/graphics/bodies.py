"""A motion as bodies in space: links with their sections, joints by kind, ground, springs, forces."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from ....elements.cross_section import CrossSection
from ....elements.outlines import outlines
from ....framework.batch import Array
from ....framework.graphics.canvas import ARROW
from ....framework.graphics.scene import JointSymbol, Scene, outline
from ....framework.graphics.style import COLOURS
from ....framework.pictures.shapes import Surface, arrow, block, copies, joined, prism, sphere, tubes, upright
from ..description.parts import LinkageLink
from .places import DrawnPoses, PosePlaces
from .plane import plane
from .scene import linkage_scene

STEEL, DRIVE, GROUND_COLOUR, FORCE = "#3a3f4a", "#d55e00", "#9aa0aa", "#c8352b"
SQUARE = np.array([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)])
# Half the length of a joint's body along its axis, and half its width, in radii of a pin; those in between are round.
BOXES = {"prismatic": (2.4, 1.4), "planar": (0.5, 2.2), "fixed": (1.2, 1.2)}
ROUND = {"revolute": 1.8, "cylindrical": 3.4, "screw": 2.6, "universal": 1.8}


@dataclass(frozen=True, eq=False)
class MotionBodies:
    """What is drawn of a motion at some of its poses.

    Attributes
    ----------
    motion
        The motion.
    poses
        Flat numbers of the poses drawn.
    names
        Whether points are named.
    force_unit
        Unit of the forces.
    """

    motion: DrawnPoses
    poses: tuple[int, ...]
    names: bool = True
    force_unit: str = "N"
    scenes: dict[int, Scene] = field(default_factory=dict)

    def scene(self, pose: int) -> Scene:
        """Lines, symbols and texts of one of the poses, by its number among them."""
        if pose not in self.scenes:
            places = PosePlaces(self.motion, self.poses[pose])
            self.scenes[pose] = linkage_scene(places, self.flat, names=self.names, force_unit=self.force_unit)
        return self.scenes[pose]

    @property
    def flat(self) -> tuple[int, int] | None:
        """The plane of the motion; None in space."""
        return plane(self.motion)

    @property
    def seen(self) -> Array:
        """Points that are to be in the picture, at all poses, (n, 3)."""
        scenes = [self.scene(k) for k in range(len(self.poses))]
        tips = [a.at + self.arrow(s, a.force) for s in scenes for a in s.arrows]
        return np.concatenate([*(scene.points for scene in scenes), np.reshape(tips, (-1, 3))])

    @property
    def across(self) -> int | None:
        """The global axis along which a plane motion is looked at; None for one in space."""
        return None if self.flat is None else 3 - sum(self.flat)

    @property
    def up(self) -> Array:
        """Upwards in the picture: y if it shows the xy plane, else z."""
        return np.asarray(np.eye(3)[1 if self.across == 2 else 2])

    @property
    def margin(self) -> float:
        """How far bodies reach beyond the points."""
        return 4.5 * self.pin

    @property
    def pin(self) -> float:
        """Radius of a pin: that of the drawing, and no less than the links are thick."""
        scene = self.scene(0)
        thick = [float(np.abs(part).max()) for _, parts in self._sections() for part in parts]
        least, most = scene.pin(scene.size), 0.03 * scene.size
        return float(np.clip(1.05 * max(thick, default=0.0), least, most))

    def arrow(self, scene: Scene, force: Array) -> Array:
        """A force as long as it is drawn, (3,)."""
        longest = max(float(np.linalg.norm(each.force)) for each in scene.arrows)
        return np.asarray(ARROW * scene.size * force / longest)

    def surfaces(self, pose: int) -> dict[str, tuple[Surface, str]]:
        """Bodies and their colours by name, the same of them at all poses."""
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
        return {name: (body, colour) for name, (body, colour) in found.items() if len(body.points)}

    def _sections(self) -> Iterator[tuple[tuple[str, str], list[Array]]]:
        for link in self.motion.linkage.links.values():
            for pair, beam in link.beams.items():
                section = getattr(beam, "section", None)
                if isinstance(section, CrossSection):
                    yield pair, outlines(section)

    def _link(self, places: PosePlaces, link: LinkageLink) -> Iterator[Surface]:
        """Beams with their sections, other elements as round bars; a rigid link as bars along its outline."""
        at = {point: places.position(point, link.name) for point in link.points}
        for (first, second), beam in link.beams.items():
            section = getattr(beam, "section", None)
            if not isinstance(section, CrossSection):
                yield self._tube(np.stack([at[first], at[second]]), 0.6)
                continue
            drawn = self.motion.linkage.points
            rows = places.value(np.asarray(beam.axes(drawn[second] - drawn[first]), dtype=float), 2)
            rotated = rows @ places.value(self.motion.axes(link.name), 2).T
            for part in outlines(section):
                yield prism(part, at[first], at[second], rotated)
        if not link.beams and len(at) > 1:
            corners, closed = outline(np.array(list(at.values())))
            yield self._tube(np.concatenate([corners, corners[:1]]) if closed else corners, 0.6)

    def _tube(self, line: Array, share: float) -> Surface:
        """Round bars along a line (k, 3), piece by piece where it has corners."""
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
        """A pin along a unit vector, `half` as long each way in its radii."""
        body = copies(block(), np.zeros((1, 3)), np.ones(1), upright(way[None]))
        # The template is as long as it is thick and lies below its place.
        along = body.points @ way
        round_part = 1.25 * self.pin * (body.points - along[:, None] * way)
        points = round_part + self.pin * half * (2.0 * along[:, None] + 1.0) * way
        return Surface(at + points, body.normals, body.faces, body.values)

    def _foot(self, joint: JointSymbol) -> Surface:
        """Ground below a joint, where the picture's upward direction is up."""
        up = self.up
        side = np.eye(3)[0] if abs(up[0]) < 0.5 else np.eye(3)[1]
        rows = np.stack([-up, side, np.cross(-up, side)])
        top = joint.at - 1.3 * self.pin * up
        return prism(1.9 * self.pin * SQUARE, top, top - 1.2 * self.pin * up, rows)

    def _force(self, scene: Scene, at: Array, force: Array) -> Surface:
        """An arrow that begins at its place."""
        drawn = self.arrow(scene, force)
        length = float(np.linalg.norm(drawn))
        return copies(arrow(), (at + drawn)[None], np.array([length]), upright(drawn[None]))
