"""A picture of a linkage: its links at one pose, faint at others, the paths of points; plane or in space."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from ....framework.graphics.canvas import draw, finish
from ....framework.graphics.style import fitting_figure, space_figure, styled
from ..graphics.plots import scene_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ..motion import Motion


@styled
def draw_mechanism(motion: Motion, pose: int, points: Sequence[str], title: str = "") -> Figure:
    """Draw a linkage at one of its poses.

    Parameters
    ----------
    motion
        Its motion, (poses,).
    pose
        Number of the pose; the first that is assembled where it is not.
    points
        Points whose paths are drawn.
    title
        What stands above.

    Returns
    -------
    Figure
        A drawing in the plane of motion, or in space.
    """
    there = bool(motion.shape) and bool(motion.is_assembled[pose])
    scene = scene_of(motion, pose if there else None, points)
    axes: Any
    if scene.flat is None:
        drawn_on, axes = space_figure(6.4, 5.2)
    else:
        drawn_on, axes = fitting_figure(6.4, scene.extent)
    draw(scene, axes)
    finish(scene, axes, "m", title)
    return drawn_on
