"""A linkage, or all poses of a motion, as a drawing for CAD: a layer for each link, a block for each pose."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from ....elements import CrossSection
from ....elements.outlines import outlines
from ....framework.batch import Array
from ....framework.errors import FrameError
from ....framework.graphics.scene import Label, Scene
from ....framework.paraview.files import whole_or_nothing
from ..description.linkage_description import LinkageDescription
from .places import DrawnPlaces, DrawnPoses, PosePlaces, ReferencePlaces, assembled_of, beam_axes, series_of
from .plane import plane
from .scene import linkage_scene

# Units of length by their code in the header of a drawing.
UNITS = {"in": 1, "ft": 2, "mm": 4, "cm": 5, "m": 6}
# Colours by AutoCAD's index: of links in turn, and of everything else.
LINK_COLOURS = (5, 1, 3, 6, 30, 4, 94, 200)
COLOURS = {"joints": 7, "drives": 30, "points": 8, "springs": 8, "paths": 4}
# Characters that are not allowed in names of layers.
FORBIDDEN = str.maketrans(dict.fromkeys("<>/\\\":;?*|='`,", "_"))
# Height of letters, in radii of a pin.
LETTER = 2.0
# Number of edges of a section that are drawn along a member in space.
EDGES = 4


def save_linkage(linkage: LinkageDescription, path: Path, entry: int, unit: str) -> None:
    """See `Linkage.save`."""
    if not linkage.points:
        raise FrameError(f"{path.name}: the linkage has no points, so there is nothing to save")
    many = math.prod(linkage.shape)
    if entry not in range(many):
        raise FrameError(f"{path.name} was given entry={entry!r}, but the linkage has {many}: give 0 to {many - 1}")
    drawing = CadDrawing.new(linkage, path, unit)
    places = ReferencePlaces(linkage, entry)
    drawing.add(drawing.space, places, places.flat, names=True)
    drawing.write(path)


def save_motion(motion: DrawnPoses, path: Path, unit: str) -> None:
    """See `Motion.save`."""
    if len(motion.shape) > 1:
        raise FrameError(f"{path.name} holds one row of poses, but the batch shape is {motion.shape}: save one row")
    drawing = CadDrawing.new(motion.linkage, path, unit)
    numbers, first = series_of(motion, None)
    flat, digits = plane(motion), max(3, len(str(len(numbers) - 1)))
    for number in assembled_of(motion, numbers):
        name = drawing.layer(f"pose {number:0{digits}d}", COLOURS["joints"])
        block = drawing.document.blocks.new(name)
        drawing.add(block, PosePlaces(motion, number), flat, names=number == first)
        drawing.space.add_blockref(name, (0.0, 0.0, 0.0), {"layer": name})
    drawing.add_paths(motion, numbers)
    drawing.write(path)


@dataclass
class CadDrawing:
    """A drawing of ezdxf, with layers for links, joints and other parts.

    Attributes
    ----------
    document
        The document of ezdxf.
    linkage
        The linkage that is drawn.
    names
        Name of each layer by the kind and the wanted name of its contents.
    """

    document: Any
    linkage: LinkageDescription
    names: dict[tuple[str, str], str] = field(default_factory=dict)

    @classmethod
    def new(cls, linkage: LinkageDescription, path: Path, unit: str) -> CadDrawing:
        """An empty drawing with a layer for each link."""
        if unit not in UNITS:
            raise FrameError(f"{path.name} was given unit={unit!r}: a drawing knows {', '.join(UNITS)}")
        try:
            from ezdxf.filemanagement import new
        except ModuleNotFoundError:
            raise FrameError(f"{path.name} needs the extra `dxf`: pip install 'linkframe[dxf]'") from None
        document = new("R2010", setup=False, units=UNITS[unit])
        drawing = cls(document, linkage)
        for number, link in enumerate(linkage.links):
            drawing.layer(link, LINK_COLOURS[number % len(LINK_COLOURS)], "link")
        return drawing

    @property
    def space(self) -> Any:
        """Model space of the document."""
        return self.document.modelspace()

    def layer(self, wanted: str, colour: int, kind: str = "") -> str:
        """Name of the layer for something, added when first asked for; names are unique regardless of case."""
        if (kind, wanted) not in self.names:
            plain = wanted.translate(FORBIDDEN).strip() or "_"
            name, taken = plain, {each.lower() for each in self.names.values()} | {"0", "defpoints"}
            number = 2
            while name.lower() in taken:
                name, number = f"{plain} {number}", number + 1
            self.names[kind, wanted] = name
            self.document.layers.add(name, color=colour)
        return self.names[kind, wanted]

    def add(self, layout: Any, places: DrawnPlaces, flat: tuple[int, int] | None, *, names: bool) -> None:
        """Draw one pose: links, sections, joints by kind, springs, points."""
        scene, links = linkage_scene(places, flat, names=True, loads=False), list(self.linkage.links)
        radius = scene.pin(scene.size)
        for stroke in scene.strokes:
            kind = (links[stroke.number], 0, "link") if stroke.kind != "spring" else ("springs", COLOURS["springs"])
            _line(layout, stroke.points, self.layer(*kind))
        for link, corners in _sections(places, flat):
            _line(layout, corners, self.layer(link, 0, "link"), close=True)
        self._add_joints(layout, scene, radius)
        layer = {"layer": self.layer("points", COLOURS["points"])}
        for label in scene.labels:
            layout.add_point(label.at.tolist(), layer)
            if names:
                self._add_name(layout, label, radius, flat, layer)

    def _add_name(
        self, layout: Any, label: Label, radius: float, flat: tuple[int, int] | None, layer: dict[str, str]
    ) -> None:
        """Add a name beside its point, parallel to the plane of the drawing, in space to that of x and y."""
        from ezdxf.math import OCS

        first, second = (np.eye(3)[k] for k in flat or (0, 1))
        normal = np.cross(first, second)
        text = layout.add_text(label.text, height=LETTER * radius, dxfattribs=layer | {"extrusion": normal.tolist()})
        text.set_placement(OCS(normal.tolist()).from_wcs((label.at + 1.2 * radius * (first + second)).tolist()))

    def _add_joints(self, layout: Any, scene: Scene, radius: float) -> None:
        """Add circles about the joints' axes on a layer of their kind; for drives a second one, for slides a line."""
        from ezdxf.math import OCS

        for joint in scene.joints:
            axis = joint.axes[:, 2]
            slides = joint.kind in ("prismatic", "cylindrical")
            # in the plane all circles are about its normal, which is the direction of view
            normal = joint.axes[:, 0] if joint.kind == "prismatic" else axis
            if scene.flat is not None:
                normal = np.eye(3)[3 - sum(scene.flat)]
            layer = {"layer": self.layer(f"joints {joint.kind}", COLOURS["joints"]), "extrusion": normal.tolist()}
            centre = OCS(normal.tolist()).from_wcs(joint.at.tolist())
            layout.add_circle(centre, radius, layer)
            if joint.driven:
                layout.add_circle(centre, 1.6 * radius, layer | {"layer": self.layer("drives", COLOURS["drives"])})
            if slides:
                _line(layout, joint.at + np.outer((-3.0, 3.0), radius * axis), layer["layer"])

    def add_paths(self, motion: DrawnPoses, numbers: list[int]) -> None:
        """Add paths of the points that move, interrupted at poses that are not assembled."""
        moved = {point: link.name for link in self.linkage.links.values() for point in reversed(link.points)}
        paths = {
            point: np.broadcast_to(motion.position(point, link), (*motion.shape, 3)).reshape(-1, 3)[numbers]
            for point, link in moved.items()
        }
        places = np.concatenate([np.zeros((0, 3)), *paths.values()])
        extent = np.ptp(places[np.isfinite(places).all(axis=-1)], axis=0).max(initial=0.0)
        for point, path in paths.items():
            known = np.asarray(np.isfinite(path).all(axis=-1))
            if np.ptp(path[known], axis=0).max(initial=0.0) <= 1e-9 * extent:
                continue
            for part in np.split(np.arange(len(path)), np.flatnonzero(~known)):
                row = path[part][known[part]]
                if len(row) > 1:
                    _line(self.space, row, self.layer(f"path of {point}", COLOURS["paths"]))

    def write(self, path: Path) -> None:
        """Write the drawing, whole or not at all."""
        with whole_or_nothing(path.parent) as stage:
            self.document.saveas(stage / path.name)


def _line(layout: Any, points: Array, layer: str, close: bool = False) -> None:
    """Add a line, or a polyline of several segments, in space."""
    if len(points) == 2 and not close:
        layout.add_line(*points.tolist(), {"layer": layer})
    elif len(points) > 1:
        layout.add_polyline3d(points.tolist(), close=close, dxfattribs={"layer": layer})


def _sections(places: DrawnPlaces, flat: tuple[int, int] | None) -> Iterator[tuple[str, Array]]:
    """Outlines of beams, each with its link: in the plane as seen, in space sections at the ends and edges along."""
    for link in places.linkage.links.values():
        for (first, second), beam in link.beams.items():
            section = getattr(beam, "section", None)
            if not isinstance(section, CrossSection):
                continue
            ends = np.stack([places.position(point, link.name) for point in (first, second)])
            rows = beam_axes(places, (first, second), beam)
            across = np.stack([places.rotated(link.name, row) for row in rows[1:]])
            corners = [part @ across for part in outlines(section)]
            if flat is None:
                for part in corners:
                    for end in ends:
                        yield link.name, end + part
                    for corner in part[:: max(1, len(part) // EDGES)]:
                        yield link.name, ends + corner
                continue
            along = (ends[1] - ends[0]) / np.linalg.norm(ends[1] - ends[0])
            side = np.cross(np.eye(3)[3 - sum(flat)], along)
            reach = np.concatenate(corners) @ side
            least, most = reach.min() * side, reach.max() * side
            yield link.name, np.stack([ends[0] + least, ends[1] + least, ends[1] + most, ends[0] + most])
