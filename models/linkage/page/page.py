"""Write the page of a motion: one file with its numbers, styles and program."""

from __future__ import annotations

import html
import platform
from collections.abc import Sequence
from dataclasses import dataclass, field
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ....framework.batch import Array
from ....framework.errors import FrameError, expected_mechanisms
from ..statics.frame import FramedPoses
from ..worst_case.worst_case import WorstCase
from .about import about
from .data import MOST_POSES, as_json, checked, page_data, traced_point
from .grid import GridAxis

# Height of a page in a notebook, pixels.
HEIGHT = 620
# Element that is drawn on, and for the plane and for space its tag and the parts of the program in their order.
VIEW = '<{tag} id="view" role="img" aria-label="Drawing of the linkage; drag a joint to move it" tabindex="0"></{tag}>'
VIEWS = {
    2: ("svg", ("numbers", "view", "flat", "table", "controls")),
    3: ("canvas", ("numbers", "view", "space", "table", "controls")),
}


@dataclass(frozen=True, eq=False)
class PageText:
    """Texts of a page.

    Attributes
    ----------
    title
        Heading.
    command
        Command that made the page.
    units
        Units of length and force.
    about
        Headings and texts that can be unfolded, such as the inputs; if empty, the linkage and its drives.
    notes
        Sentences that are always shown.
    samples
        Description of the samples that are drawn.
    status
        Status of the poses in words, (poses,), where a job tells more of them than the page knows.
    """

    title: str = ""
    command: str = ""
    units: tuple[str, str] = ("m", "N")
    about: Sequence[tuple[str, str]] = ()
    notes: Sequence[str] = field(default=())
    samples: str = ""
    status: NDArray[np.str_] | None = None


def write_page(
    motion: FramedPoses,
    path: str | Path,
    point: str,
    link: str | None,
    worst: WorstCase | None,
    text: PageText,
    *,
    drive: str | None = None,
    samples: Array | None = None,
    grid: Sequence[GridAxis] = (),
) -> None:
    """See `Motion.page`."""
    path = Path(path)
    if path.suffix != ".html":
        raise FrameError(f"{path.name} does not end in .html: a page is one file for a browser")
    whole = page(motion, point, link, worst, text, drive=drive, samples=samples, grid=grid)
    try:
        path.write_text(whole, encoding="utf-8")
    except OSError as error:
        raise FrameError(f"{path} cannot be written: {error.strerror or error}") from None


def page(
    motion: FramedPoses,
    point: str,
    link: str | None,
    worst: WorstCase | None,
    text: PageText,
    *,
    drive: str | None = None,
    samples: Array | None = None,
    grid: Sequence[GridAxis] = (),
) -> str:
    """The page with its numbers, styles and program in it."""
    with expected_mechanisms():
        data = page_data(motion, point, link, worst, checked(motion, drive), samples, text.status)
    data |= {
        "grid": [axis.table() for axis in grid],
        "title": text.title or f"Where {point} goes",
        "command": text.command,
        "versions": versions(),
        "units": list(text.units),
        "about": [{"title": title, "text": whole} for title, whole in text.about or about(motion)],
        "notes": [*text.notes, *data["notes"]],
        "samples": text.samples,
    }
    return _filled(data)


def framed(motion: FramedPoses, worst: WorstCase | None, point: str) -> str:
    """The page in an inline frame, for a notebook."""
    inside = html.escape(page(motion, point, None, worst, PageText()), quote=True)
    style = f"width:100%;height:{HEIGHT}px;border:0"
    title = f"Where {html.escape(point)} goes"
    return f'<iframe sandbox="allow-scripts" title="{title}" style="{style}" srcdoc="{inside}"></iframe>'


def framed_point(motion: FramedPoses) -> str | None:
    """The point whose page a notebook shows; None if that is not clear, or the motion has nothing to drag."""
    if len(motion.shape) != 1 or not 1 < motion.shape[0] <= MOST_POSES or not motion.linkage.drives:
        return None
    return traced_point(motion) if motion.is_assembled.any() else None


def _filled(data: dict[str, Any]) -> str:
    room = files(__package__)
    text = room.joinpath("page.html").read_text(encoding="utf-8")
    tag, program = VIEWS[data["dimensions"]]
    # a closing tag within the numbers would end the script
    numbers = as_json(data).replace("<", "\\u003c")
    for mark, value in (
        ("{{title}}", html.escape(data["title"])),
        ("{{view}}", VIEW.format(tag=tag)),
        ("{{style}}", room.joinpath("page.css").read_text(encoding="utf-8")),
        ("{{program}}", "".join(room.joinpath(f"{name}.js").read_text(encoding="utf-8") for name in program)),
        ("{{data}}", numbers),
    ):
        text = text.replace(mark, value, 1)
    return text


def versions() -> str:
    """Versions of the programs that computed the numbers."""
    from importlib.metadata import PackageNotFoundError, version

    try:
        own = version("linkframe")
    except PackageNotFoundError:
        own = "not installed"
    return f"linkframe {own}, NumPy {np.__version__}, Python {platform.python_version()}"
