"""Pictures, movies and a window of a motion in space, with PyVista."""

from __future__ import annotations

from contextlib import closing
from pathlib import Path
from typing import Any

from ....framework.paraview.files import whole_or_nothing
from ....framework.pictures import plotting
from ....framework.pictures.rendering import quiet
from .bodies import Looks, MotionBodies
from .places import DrawnPoses, assembled_of, series_of

# Opacity of regions.
CLEAR = 0.55


def picture(
    motion: DrawnPoses,
    path: str | Path,
    pose: int | tuple[int, ...] | None,
    looks: Looks,
    size: tuple[int, int],
) -> None:
    """See `Motion.picture`."""
    path = plotting.image_path(path, size)
    bodies = MotionBodies(motion, (series_of(motion, pose)[1],), looks)
    with whole_or_nothing(path.parent) as stage, quiet(), closing(_plotter(bodies, size, True)[0]) as plotter:
        plotter.screenshot(stage / path.name)


def movie(motion: DrawnPoses, path: str | Path, looks: Looks, size: tuple[int, int], rate: int) -> None:
    """See `Motion.movie`."""
    path = plotting.movie_path(path, size, rate)
    bodies = MotionBodies(motion, _assembled(motion), looks)
    with plotting.filming(path, rate, lambda: _plotter(bodies, size, True)) as (plotter, meshes):
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
    """Flat indices of the assembled poses along the longest batch axis."""
    return tuple(assembled_of(motion, series_of(motion, None)[0]))


def _plotter(bodies: MotionBodies, size: tuple[int, int], off_screen: bool) -> tuple[Any, dict[str, Any]]:
    """A plotter that shows the first pose, and its meshes by name."""
    plotter, meshes = plotting.plotter_of(size, off_screen=off_screen), {}
    for name, (surface, colour) in bodies.surfaces(0).items():
        meshes[name], _ = plotting.add_surface(
            plotter, surface, color=colour, specular=0.25, specular_power=20, ambient=0.25,
            opacity=CLEAR if name.startswith("region") else 1.0,
        )  # fmt: skip
    if bodies.caption:
        plotting.add_caption(plotter, bodies.caption)
    _texts(plotter, bodies, 0)
    plotting.aim(plotter, bodies)
    return plotter, meshes


def _move(plotter: Any, meshes: dict[str, Any], bodies: MotionBodies, number: int) -> None:
    """Show another pose by moving the meshes."""
    for name, (surface, _) in bodies.surfaces(number).items():
        plotting.move(meshes[name], surface)
    _texts(plotter, bodies, number)
    plotter.render()


def _texts(plotter: Any, bodies: MotionBodies, number: int) -> None:
    """Add names of points beside the pins, and magnitudes of forces at the tips of their arrows."""
    scene = bodies.scene(number)
    places = [label.at + 2.3 * bodies.pin * bodies.up for label in scene.labels]
    plotting.add_texts(plotter, "names", places, [label.text for label in scene.labels], 40)
    tips = [each.at + 1.06 * bodies.arrow(scene, each.force) for each in scene.arrows]
    plotting.add_texts(plotter, "forces", tips, [each.text for each in scene.arrows], 40)
