"""Pictures and movies of the deformed structure, rendered off screen."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import closing
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, Protocol

import numpy as np

from .batch import Array, finite
from .errors import FrameError
from .graphics.style import COLOURS as COLOURS_OF_LINES
from .paraview.entries import Entry, one, series
from .paraview.files import whole_or_nothing
from .pictures.drawing import COLOURS, Drawing, drawing
from .pictures.rendering import REMEDY, RenderingError, can_render, quiet
from .pictures.shapes import Surface
from .solution import Solution

if TYPE_CHECKING:
    import pyvista

Colour = Literal["von_mises", "displacement"]

SIZE = (1600, 1000)
INK, BEARING = "#262a33", "#1b7f5c"
# How each thing looks; members take the colour of their values.
LOOKS: Mapping[str, Mapping[str, Any]] = {
    "undeformed": {"color": "#b4bac4", "specular": 0.0, "ambient": 0.3},
    "members": {"cmap": "viridis", "specular": 0.25, "specular_power": 20, "ambient": 0.2},
    "joints": {"color": INK, "specular": 0.5, "specular_power": 30},
    "bearings": {"color": BEARING, "specular": 0.25, "ambient": 0.25},
    "clamps": {"color": "#6b7380", "ambient": 0.2},
    "pins": {"color": "#6b7380", "ambient": 0.2},
    "forces": {"color": "#c8352b", "ambient": 0.25},
    "free": {"color": COLOURS_OF_LINES[3], "ambient": 0.25},
}


class Seen(Protocol):
    """What a camera must know of what it looks at."""

    @property
    def seen(self) -> Array:
        """Points that are to be in the picture, (n, 3)."""

    @property
    def across(self) -> int | None:
        """The global axis along which a plane thing is looked at; None for one in space."""

    @property
    def up(self) -> Array:
        """Upwards in the picture, (3,)."""

    @property
    def margin(self) -> float:
        """How far what is drawn reaches beyond the points."""


def picture(
    solution: Solution,
    path: str | Path,
    *,
    entry: Entry | None = None,
    scale: float | None = None,
    colour: Colour = "von_mises",
    size: tuple[int, int] = SIZE,
    units: tuple[str, str] = ("m", "N"),
    names: bool = True,
) -> None:
    """Draw the deformed structure over the undeformed one.

    Members are coloured by their values; joints are spheres, clamps cubes, other supports cones, and forces
    at nodes red arrows. Joints with clearance lie in rings, as much wider than they as the clearance is to the scale of
    the displacements. Where stress is known at the ends of segments alone, as under an added form, colours go straight
    from one to the next. A plane structure is seen at right angles. Where there is no solution, as at a singular pose
    of ``motion.frame()``, violet arrows show the motion that nothing resists.

    Parameters
    ----------
    solution
        What `Frame.solve` returned.
    path
        Image to write, ``.png`` or ``.jpg``.
    entry
        Indices of the batch entry; not needed where the batch holds one.
    scale
        Factor on the displacements; a round number that makes them visible where None.
    colour
        ``von_mises`` or ``displacement``.
    size
        Width and height in pixels.
    units
        Units of length and force, for the bar of colours.
    names
        Whether nodes are named, of a structure with no more than 40 places.

    Raises
    ------
    RenderingError
        If this machine cannot render; the message says what to install.
    FrameError
        If the name ends otherwise, the batch does not fit, or the folder cannot be written.
    """
    path = _checked(path, (".png", ".jpg"), scale, colour, size)
    shown = drawing(solution, one(solution.shape, entry, path.name), scale, colour, units, names)
    with whole_or_nothing(path.parent) as stage:
        rendered(shown, stage / path.name, size)


def rendered(shown: Drawing, path: Path, size: tuple[int, int] = SIZE) -> None:
    """Render a drawing at its first pose; without OpenGL this ends the process, see `picture`.

    Parameters
    ----------
    shown
        The drawing.
    path
        Image to write, ``.png`` or ``.jpg``.
    size
        Width and height in pixels.
    """
    with quiet():
        plotter, _ = _plotted(shown, size)
        with closing(plotter):
            plotter.screenshot(path)


def movie(
    solution: Solution,
    path: str | Path,
    *,
    axis: int | None = None,
    entry: Entry | None = None,
    scale: float | None = None,
    colour: Colour = "von_mises",
    size: tuple[int, int] = (960, 608),
    rate: int = 12,
    units: tuple[str, str] = ("m", "N"),
    names: bool = False,
) -> None:
    """Draw the poses along a batch axis one after the other, with one camera, scale and colour range.

    Parameters
    ----------
    solution
        What `Frame.solve` returned.
    path
        Movie to write, ``.gif`` or ``.mp4``; needs the extra ``movie``.
    axis
        Batch axis; not needed where only one is longer than 1.
    entry
        Indices into the other axes; not needed where these have size 1.
    scale, colour, size
        As for `picture`.
    rate
        Poses a second.
    units, names
        As for `picture`.

    Raises
    ------
    RenderingError
        If this machine cannot render or the extra is not installed; the message says what to install.
    FrameError
        If the name ends otherwise, the batch does not fit, or the folder cannot be written.
    """
    path = _checked(path, (".gif", ".mp4"), scale, colour, size)
    _whole(rate, f"{path.name} was given rate={rate!r}", "poses a second")
    if find_spec("imageio") is None or (path.suffix == ".mp4" and find_spec("imageio_ffmpeg") is None):
        raise RenderingError(f"{path.name} needs the extra `movie`: pip install 'linkframe[movie]'")
    shown = drawing(solution, series(solution.shape, axis, entry, path.name), scale, colour, units, names)
    with whole_or_nothing(path.parent) as stage, quiet():
        plotter, meshes = _plotted(shown, size)
        with closing(plotter):
            if path.suffix == ".gif":
                plotter.open_gif(str(stage / path.name), fps=rate)
            else:
                plotter.open_movie(str(stage / path.name), framerate=rate)
            for pose in range(len(shown.rest)):
                _update(meshes, shown.surfaces(pose))
                _caption(plotter, shown, pose)
                plotter.write_frame()


def _checked(
    path: str | Path, endings: tuple[str, ...], scale: float | None, colour: str, size: tuple[int, int]
) -> Path:
    path = Path(path)
    if path.suffix not in endings:
        raise FrameError(f"{path.name} does not end in {' or '.join(endings)}: choose one of them")
    if colour not in COLOURS:
        raise FrameError(f"{path.name} was given colour={colour!r}: choose one of {', '.join(COLOURS)}")
    if scale is not None and finite(scale, f"scale of {path.name}").ndim:
        raise FrameError(f"{path.name} was given scale={scale!r}: give one number")
    if np.shape(size) != (2,):
        raise FrameError(f"{path.name} was given size={size!r}: give width and height in pixels")
    for length in size:
        _whole(length, f"{path.name} was given size={size!r}", "pixels each way")
    if not can_render():
        raise RenderingError(f"{path.name} was not made: {REMEDY}")
    return path


def _whole(number: int, what: str, unit: str) -> None:
    if not isinstance(number, int | np.integer) or number < 1:
        raise FrameError(f"{what}: give a whole number of {unit}, 1 or more")


def _plotted(drawing: Drawing, size: tuple[int, int]) -> tuple[pyvista.Plotter, dict[str, pyvista.PolyData]]:
    """A plotter that shows the first pose, and its meshes by kind."""
    import pyvista

    plotter = pyvista.Plotter(off_screen=True, window_size=list(size), theme=pyvista.themes.DocumentTheme())
    plotter.enable_anti_aliasing("ssaa")
    meshes = {}
    for kind, surface in drawing.surfaces(0).items():
        faces: Any = surface.faces
        mesh = pyvista.PolyData.from_regular_faces(surface.points, faces)
        mesh.point_data.active_normals = surface.normals
        mesh.point_data["values"] = surface.values
        actor = plotter.add_mesh(
            mesh,
            copy_mesh=False,
            scalars="values" if kind == "members" else None,
            clim=(0.0, drawing.top),
            show_scalar_bar=False,
            **LOOKS[kind],
        )
        actor.prop.interpolation = "Phong"
        meshes[kind] = mesh
        if kind == "members" and drawing.solved.any():
            _bar(plotter, actor.mapper, drawing.label, size)
    _caption(plotter, drawing, 0)
    aim(plotter.camera, drawing, size[0] / size[1])
    return plotter, meshes


def _update(meshes: Mapping[str, pyvista.PolyData], surfaces: Mapping[str, Surface]) -> None:
    """Move the meshes in place: their topology is the same at all poses."""
    for kind, surface in surfaces.items():
        meshes[kind].points = surface.points
        data: Any = meshes[kind].point_data
        data["Normals"][:] = surface.normals
        data["values"][:] = surface.values


def _bar(plotter: Any, mapper: Any, title: str, size: tuple[int, int]) -> None:
    plotter.add_scalar_bar(
        title="",  # its own title would lie on the labels
        mapper=mapper,
        width=0.44,
        height=0.075,
        position_x=0.28,
        position_y=0.02,
        label_font_size=size[1] // 42,
        n_labels=5,
        fmt="%.3g",
        color=INK,
    )
    place = (0.28 * size[0], 0.098 * size[1])
    plotter.add_text(title, position=place, font_size=size[1] // 75, color=INK, name="title", render=False)


def _caption(plotter: pyvista.Plotter, drawing: Drawing, pose: int) -> None:
    moved = f"displacements \u00d7 {drawing.scale:g}"
    if told := drawing.told_forces(pose):
        plotter.add_point_labels(
            np.array([place for place, _ in told]), [text for _, text in told], name="forces", text_color="#c8352b",
            font_size=max(10, plotter.window_size[1] // 48), shape=None, always_visible=True, show_points=False,
            reset_camera=False, render=False,
        )  # fmt: skip
    if named := drawing.told_names(pose):
        plotter.add_point_labels(
            np.array([place for place, _ in named]), [text for _, text in named], name="names", text_color=INK,
            font_size=max(10, plotter.window_size[1] // 48), shape=None, always_visible=True, show_points=False,
            reset_camera=False, render=False,
        )  # fmt: skip
    text = moved if drawing.solved[pose] else _without_solution(drawing, pose)
    width, height = plotter.window_size
    plotter.add_text(
        text, position=(0.03 * width, 0.93 * height), font_size=height // 75, color=INK, name="caption", render=False
    )


def _without_solution(drawing: Drawing, pose: int) -> str:
    """What stands above a pose without a solution."""
    status = drawing.status[pose] if drawing.status else "mechanism"
    arrows = "; arrows: free motion" if drawing.free[pose].any() else ""
    return f"{status}: undeformed shape, no solution{arrows}"


def aim(camera: Any, drawing: Seen, aspect: float) -> None:
    """Look in parallel projection at all poses, a plane structure at right angles, with room for the bar below."""
    towards = np.array([-1.0, 1.6, -0.9])
    if drawing.across is not None:
        towards = -np.eye(3)[drawing.across] * (-1.0 if drawing.across == 1 else 1.0)
    towards /= np.linalg.norm(towards)
    right = np.cross(towards, drawing.up)
    right /= np.linalg.norm(right)
    upward = np.cross(right, towards)
    axes = np.stack([right, upward, towards], axis=-1)
    seen = drawing.seen @ axes
    low, high = seen.min(axis=0) - drawing.margin, seen.max(axis=0) + drawing.margin
    width, height, depth = high - low
    # The bar takes the lowest sixth of the picture and the caption the highest tenth.
    half = max(height / (2.0 * 0.73), width / (2.0 * 0.94 * aspect))
    centre = axes @ (low + high) / 2.0 - 0.065 * half * upward
    camera.focal_point = centre
    camera.position = centre - 2.0 * (half + depth) * towards
    camera.up = upward
    camera.parallel_projection = True
    camera.parallel_scale = half
    camera.clipping_range = (0.5 * (half + depth), 4.0 * (half + depth))
