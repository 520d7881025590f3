"""Pictures and movies of the deformed structure, rendered off screen."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from .batch import finite
from .errors import FrameError
from .graphics.style import COLOURS as COLOURS_OF_LINES
from .paraview.entries import Entry, one, series
from .paraview.files import whole_or_nothing
from .pictures import plotting
from .pictures.drawing import COLOURS, Drawing, drawing
from .pictures.rendering import quiet

if TYPE_CHECKING:
    import pyvista

    from .solution import Solution

Colour = Literal["von_mises", "displacement"]

SIZE = (1600, 1000)
BEARING = "#1b7f5c"
# How each thing looks; members take the colour of their values.
LOOKS: Mapping[str, Mapping[str, Any]] = {
    "undeformed": {"color": "#b4bac4", "specular": 0.0, "ambient": 0.3},
    "members": {"cmap": "viridis", "specular": 0.25, "specular_power": 20, "ambient": 0.2},
    "joints": {"color": plotting.INK, "specular": 0.5, "specular_power": 30},
    "bearings": {"color": BEARING, "specular": 0.25, "ambient": 0.25},
    "clamps": {"color": "#6b7380", "ambient": 0.2},
    "pins": {"color": "#6b7380", "ambient": 0.2},
    "forces": {"color": plotting.FORCE, "ambient": 0.25},
    "free": {"color": COLOURS_OF_LINES[3], "ambient": 0.25},
}


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
    at nodes red arrows. Joints with clearance are drawn inside rings, wider by the clearance at the scale of the
    displacements. If stress is known only at the ends of segments, as under an added form, colours are interpolated
    between them. A plane structure is seen at right angles. If there is no solution, as at a singular pose of
    ``motion.frame()``, violet arrows show the free motion.

    Parameters
    ----------
    solution
        What `Frame.solve` returned.
    path
        Image to write, ``.png`` or ``.jpg``.
    entry
        Indices of the batch entry; not needed where the batch holds one.
    scale
        Factor on the displacements; if None, a round number that makes them visible.
    colour
        ``von_mises`` or ``displacement``.
    size
        Width and height in pixels.
    units
        Units of length and force for the colour bar.
    names
        Whether nodes are labelled; done only with up to 40 of them at different places.

    Raises
    ------
    RenderingError
        If this machine cannot render; the message says what to install.
    FrameError
        If the name ends otherwise, the batch does not fit, or the folder cannot be written.
    """
    _check(Path(path).name, scale, colour)
    path = plotting.image_path(path, size)
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
    _check(Path(path).name, scale, colour)
    path = plotting.movie_path(path, size, rate)
    shown = drawing(solution, series(solution.shape, axis, entry, path.name), scale, colour, units, names)
    with plotting.filming(path, rate, lambda: _plotted(shown, size)) as (plotter, meshes):
        for pose in range(len(shown.rest)):
            for kind, surface in shown.surfaces(pose).items():
                plotting.move(meshes[kind], surface)
            _texts(plotter, shown, pose)
            plotter.write_frame()


def _check(name: str, scale: float | None, colour: str) -> None:
    if colour not in COLOURS:
        raise FrameError(f"{name} was given colour={colour!r}: choose one of {', '.join(COLOURS)}")
    if scale is not None and finite(scale, f"scale of {name}").ndim:
        raise FrameError(f"{name} was given scale={scale!r}: give one number")


def _plotted(drawing: Drawing, size: tuple[int, int]) -> plotting.Plotted:
    """A plotter that shows the first pose, and its meshes by kind."""
    plotter, meshes = plotting.plotter_of(size), {}
    for kind, surface in drawing.surfaces(0).items():
        values = "values" if kind == "members" else None
        meshes[kind], actor = plotting.add_surface(
            plotter, surface, scalars=values, clim=(0.0, drawing.top), **LOOKS[kind]
        )
        if kind == "members" and drawing.solved.any():
            _bar(plotter, actor.mapper, drawing.label, size)
    _texts(plotter, drawing, 0)
    plotting.aim(plotter, drawing)
    return plotter, meshes


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
        color=plotting.INK,
    )
    place = (0.28 * size[0], 0.098 * size[1])
    plotter.add_text(title, position=place, font_size=size[1] // 75, color=plotting.INK, name="title", render=False)


def _texts(plotter: pyvista.Plotter, drawing: Drawing, pose: int) -> None:
    for name, told in (("forces", drawing.told_forces(pose)), ("names", drawing.told_names(pose))):
        plotting.add_texts(plotter, name, [place for place, _ in told], [text for _, text in told], 48)
    moved = f"displacements × {drawing.scale:g}"
    plotting.add_caption(plotter, moved if drawing.solved[pose] else _without_solution(drawing, pose))


def _without_solution(drawing: Drawing, pose: int) -> str:
    """What stands above a pose without a solution."""
    status = drawing.status[pose] if drawing.status else "mechanism"
    arrows = "; arrows: free motion" if drawing.free[pose].any() else ""
    return f"{status}: undeformed shape, no solution{arrows}"
