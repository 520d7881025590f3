"""Files, surfaces, texts and camera of pictures with PyVista, shared by those of structures and of motions."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import closing, contextmanager
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol, TypeAlias

import numpy as np

from ..batch import Array
from ..checked import whole_number
from ..errors import FrameError
from ..paraview.files import whole_or_nothing
from .rendering import REMEDY, RenderingError, can_render, quiet
from .shapes import Surface

if TYPE_CHECKING:
    import pyvista

# A plotter that shows the first pose, and its meshes by name.
Plotted: TypeAlias = "tuple[pyvista.Plotter, dict[str, pyvista.PolyData]]"

INK, FORCE = "#262a33", "#c8352b"
IMAGES, MOVIES = (".png", ".jpg"), (".gif", ".mp4")


class Seen(Protocol):
    """Content of a picture, as far as the camera needs it."""

    @property
    def seen(self) -> Array:
        """Points that must be in the picture, (n, 3)."""

    @property
    def across(self) -> int | None:
        """The global axis along which a plane structure is viewed; None for one in space."""

    @property
    def up(self) -> Array:
        """Upwards in the picture, (3,)."""

    @property
    def margin(self) -> float:
        """Greatest distance of surfaces from the points."""


def image_path(path: str | Path, size: tuple[int, int]) -> Path:
    """Where an image of that size in pixels goes, if it can be made here."""
    return _checked(Path(path), IMAGES, size)


def movie_path(path: str | Path, size: tuple[int, int], rate: int) -> Path:
    """Where a movie of that size in pixels, of so many poses a second, goes, if it can be made here."""
    path = _checked(Path(path), MOVIES, size)
    whole_number(rate, f"{path.name}: rate in poses a second", 1)
    if find_spec("imageio") is None or (path.suffix == ".mp4" and find_spec("imageio_ffmpeg") is None):
        raise RenderingError(f"{path.name} needs the extra `movie`: pip install 'linkframe[movie]'")
    return path


def _checked(path: Path, endings: tuple[str, ...], size: tuple[int, int]) -> Path:
    if path.suffix not in endings:
        raise FrameError(f"{path.name} does not end in {' or '.join(endings)}: choose one of them")
    if np.shape(size) != (2,):
        raise FrameError(f"{path.name} was given size={size!r}: give width and height in pixels")
    for length in size:
        whole_number(length, f"{path.name}: size in pixels", 1)
    if not can_render():
        raise RenderingError(f"{path.name} was not made: {REMEDY}")
    return path


@contextmanager
def filming(path: Path, rate: int, plotted: Callable[[], Plotted]) -> Iterator[Plotted]:
    """Plot with `plotted`, and write its frames to a movie, completely or not at all."""
    with whole_or_nothing(path.parent) as stage, quiet():
        plotter, meshes = plotted()
        with closing(plotter):
            if path.suffix == ".gif":
                plotter.open_gif(str(stage / path.name), fps=rate)
            else:
                plotter.open_movie(str(stage / path.name), framerate=rate)
            yield plotter, meshes


def plotter_of(size: tuple[int, int], *, off_screen: bool = True) -> pyvista.Plotter:
    """A plotter without anything in it."""
    import pyvista

    plotter = pyvista.Plotter(off_screen=off_screen, window_size=list(size), theme=pyvista.themes.DocumentTheme())
    if off_screen:
        plotter.enable_anti_aliasing("ssaa")
    return plotter


def add_surface(plotter: pyvista.Plotter, surface: Surface, **look: Any) -> tuple[pyvista.PolyData, pyvista.Actor]:
    """Show a surface with a look, and give the mesh that holds its normals and values."""
    import pyvista

    faces: Any = surface.faces
    mesh = pyvista.PolyData.from_regular_faces(surface.points, faces)
    mesh.point_data.active_normals = surface.normals
    mesh.point_data["values"] = surface.values
    actor = plotter.add_mesh(mesh, copy_mesh=False, show_scalar_bar=False, **look)
    actor.prop.interpolation = "Phong"
    return mesh, actor


def move(mesh: pyvista.PolyData, surface: Surface) -> None:
    """Bring a mesh to another pose in place: its topology is the same at all."""
    data: Any = mesh.point_data
    mesh.points = surface.points
    data["Normals"][:] = surface.normals
    data["values"][:] = surface.values


def add_texts(plotter: pyvista.Plotter, name: str, places: Sequence[Array], texts: Sequence[str], share: int) -> None:
    """Write texts over everything else, forces in red, their letters a `share` of the height of the picture."""
    if texts:
        plotter.add_point_labels(
            np.array(places), list(texts), name=name, text_color=INK if name == "names" else FORCE,
            font_size=max(10, plotter.window_size[1] // share), shape=None, always_visible=True, show_points=False,
            reset_camera=False, render=False,
        )  # fmt: skip


def add_caption(plotter: pyvista.Plotter, text: str) -> None:
    """Write a text above, in place of the one before."""
    width, height = plotter.window_size
    place = (0.03 * width, 0.93 * height)
    plotter.add_text(text, position=place, font_size=height // 75, color=INK, name="caption", render=False)


def aim(plotter: pyvista.Plotter, drawing: Seen) -> None:
    """Look in parallel projection at all poses, a plane structure at right angles, with room for the bar below."""
    camera: Any = plotter.camera
    aspect = plotter.window_size[0] / plotter.window_size[1]
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
