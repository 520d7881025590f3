"""Pictures, movies and a window of a motion in space, with PyVista."""

from __future__ import annotations

from contextlib import closing
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from ....framework.errors import FrameError
from ....framework.paraview.files import whole_or_nothing
from ....framework.pictures.rendering import REMEDY, RenderingError, can_render, quiet
from ....framework.pictures.shapes import Surface
from ....framework.view import INK, aim
from .bodies import Looks, MotionBodies
from .places import DrawnPoses, series_of

# How much of a region is seen.
CLEAR = 0.55


def picture(
    motion: DrawnPoses,
    path: str | Path,
    pose: int | tuple[int, ...] | None,
    looks: Looks,
    size: tuple[int, int],
) -> None:
    """See `Motion.picture`."""
    path = _checked(path, (".png", ".jpg"))
    bodies = MotionBodies(motion, (series_of(motion, pose)[1],), looks)
    with whole_or_nothing(path.parent) as stage, quiet(), closing(_plotter(bodies, size, True)[0]) as plotter:
        plotter.screenshot(stage / path.name)


def movie(motion: DrawnPoses, path: str | Path, looks: Looks, size: tuple[int, int], rate: int) -> None:
    """See `Motion.movie`."""
    path = _checked(path, (".gif", ".mp4"))
    if find_spec("imageio") is None or (path.suffix == ".mp4" and find_spec("imageio_ffmpeg") is None):
        raise RenderingError(f"{path.name} needs the extra `movie`: pip install 'linkframe[movie]'")
    bodies = MotionBodies(motion, _assembled(motion), looks)
    with whole_or_nothing(path.parent) as stage, quiet():
        plotter, meshes = _plotter(bodies, size, True)
        with closing(plotter):
            if path.suffix == ".gif":
                plotter.open_gif(str(stage / path.name), fps=rate)
            else:
                plotter.open_movie(str(stage / path.name), framerate=rate)
            for number in range(len(bodies.poses)):
                _move(plotter, meshes, bodies, number)
                plotter.write_frame()


def show(motion: DrawnPoses, pose: int | tuple[int, ...] | None, looks: Looks) -> Any:
    """See `Motion.show`."""
    chosen = series_of(motion, pose)[1]
    there = _assembled(motion)
    poses = there if chosen in there else (chosen,)
    bodies = MotionBodies(motion, poses, looks)
    plotter, meshes = _plotter(bodies, (1200, 800), False)
    _move(plotter, meshes, bodies, poses.index(chosen))
    if len(poses) > 1:
        plotter.add_slider_widget(
            lambda value: _move(plotter, meshes, bodies, round(value)),
            (0, len(poses) - 1),
            value=poses.index(chosen),
            title="pose",
            fmt="%.0f",
        )
    plotter.add_axes()
    return plotter.show()


def _assembled(motion: DrawnPoses) -> tuple[int, ...]:
    """Flat numbers of the assembled poses along the longest batch axis."""
    series, _ = series_of(motion, None)
    there = np.broadcast_to(motion.is_assembled, motion.shape).reshape(-1)
    return tuple(k for k in series if there[k])


def _checked(path: str | Path, endings: tuple[str, ...]) -> Path:
    path = Path(path)
    if path.suffix not in endings:
        raise FrameError(f"{path.name} does not end in {' or '.join(endings)}: choose one of them")
    if not can_render():
        raise RenderingError(f"{path.name} was not made: {REMEDY}")
    return path


def _plotter(bodies: MotionBodies, size: tuple[int, int], off_screen: bool) -> tuple[Any, dict[str, Any]]:
    """A plotter that shows the first pose, and its meshes by name."""
    import pyvista

    plotter = pyvista.Plotter(off_screen=off_screen, window_size=list(size), theme=pyvista.themes.DocumentTheme())
    if off_screen:
        plotter.enable_anti_aliasing("ssaa")
    meshes = {}
    for name, (surface, colour) in bodies.surfaces(0).items():
        faces: Any = surface.faces
        mesh = pyvista.PolyData.from_regular_faces(surface.points, faces)
        mesh.point_data.active_normals = surface.normals
        actor = plotter.add_mesh(
            mesh, copy_mesh=False, color=colour, specular=0.25, specular_power=20, ambient=0.25, show_scalar_bar=False,
            opacity=CLEAR if name.startswith("region") else 1.0,
        )  # fmt: skip
        actor.prop.interpolation = "Phong"
        meshes[name] = mesh
    if bodies.caption:
        width, height = plotter.window_size
        plotter.add_text(bodies.caption, position=(0.03 * width, 0.93 * height), font_size=height // 75, color=INK)
    _texts(plotter, bodies, 0)
    aim(plotter.camera, bodies, size[0] / size[1])
    return plotter, meshes


def _move(plotter: Any, meshes: dict[str, Any], bodies: MotionBodies, number: int) -> None:
    """Show another pose: the same bodies elsewhere."""
    for name, (surface, _) in bodies.surfaces(number).items():
        _put(meshes[name], surface)
    _texts(plotter, bodies, number)
    plotter.render()


def _put(mesh: Any, surface: Surface) -> None:
    mesh.points = surface.points
    mesh.point_data["Normals"][:] = surface.normals


def _texts(plotter: Any, bodies: MotionBodies, number: int) -> None:
    """Names of points and sizes of forces, over everything else."""
    scene = bodies.scene(number)
    look: dict[str, Any] = {"shape": None, "always_visible": True, "show_points": False, "reset_camera": False}
    font = max(10, plotter.window_size[1] // 40)
    if scene.labels:
        # Beside the pin, not on it.
        places = np.array([label.at for label in scene.labels]) + 2.3 * bodies.pin * bodies.up
        texts = [label.text for label in scene.labels]
        plotter.add_point_labels(places, texts, font_size=font, text_color=INK, name="names", render=False, **look)
    if scene.arrows:
        tips = np.array([each.at + 1.06 * bodies.arrow(scene, each.force) for each in scene.arrows])
        text = [each.text for each in scene.arrows]
        plotter.add_point_labels(tips, text, font_size=font, text_color="#c8352b", name="sizes", render=False, **look)
