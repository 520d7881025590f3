"""Whether this machine can render a scene, and how to make it able to."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from typing import Any

PROBE = f"from {__name__} import renders; raise SystemExit(not renders())"

REMEDY = (
    "3-D pictures need OpenGL, which this machine lacks; on Debian or Ubuntu install it with "
    "`apt-get install --no-install-recommends libegl1 libgl1-mesa-dri`; everything else works without"
)


class RenderingError(RuntimeError):
    """A picture cannot be rendered on this machine; the message says what to install."""


def renders() -> bool:
    """Whether something small can be rendered off screen in this process; without OpenGL that ends it."""
    import pyvista

    plotter = pyvista.Plotter(off_screen=True, window_size=[64, 64])
    plotter.add_mesh(pyvista.Sphere())
    image: Any = plotter.screenshot(None, return_img=True)
    return bool(image.std() > 0.0)


@cache
def can_render() -> bool:
    """Whether a 3-D scene can be rendered off screen here.

    Without OpenGL the first rendering kills its process, which no ``try`` catches: so it is tried, once, in
    a child process.

    Returns
    -------
    bool
        Whether `picture` and `movie` will work.
    """
    try:
        probe = subprocess.run([sys.executable, "-P", "-c", PROBE], capture_output=True, timeout=120, check=False)
    except (OSError, subprocess.TimeoutExpired):
        return False
    return probe.returncode == 0


@contextmanager
def quiet() -> Iterator[None]:
    """Keep VTK from telling the terminal that it looks for another way to render without a display."""
    from vtkmodules.vtkCommonCore import vtkLogger

    before = vtkLogger.GetCurrentVerbosityCutoff()
    vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_OFF)
    try:
        yield
    finally:
        vtkLogger.SetStderrVerbosity(before)
