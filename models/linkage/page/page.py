"""Write the page of a motion: one file that needs nothing else."""

from __future__ import annotations

import html
import json
import platform
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np

from ....framework.errors import FrameError
from ..statics.frame import FramedPoses
from ..worst_case.worst_case import WorstCase
from .data import checked, page_data


def write_page(
    motion: FramedPoses,
    path: str | Path,
    point: str,
    link: str | None,
    worst: WorstCase | None,
    *,
    title: str = "",
    drive: str | None = None,
    command: str = "",
) -> None:
    """See `Motion.page`."""
    path = Path(path)
    if path.suffix != ".html":
        raise FrameError(f"{path.name} does not end in .html: a page is one file for a browser")
    data = page_data(motion, point, link, worst, checked(motion, drive))
    data |= {"title": title or f"Where {point} goes", "command": command, "versions": versions()}
    try:
        path.write_text(page(data), encoding="utf-8")
    except OSError as error:
        raise FrameError(f"{path} cannot be written: {error.strerror or error}") from None


def page(data: dict[str, Any]) -> str:
    """The page with its numbers, styles and program in it."""
    room = files(__package__)
    text = room.joinpath("page.html").read_text(encoding="utf-8")
    # What closes a script must not stand in one.
    numbers = json.dumps(data, ensure_ascii=False, allow_nan=False, separators=(",", ":")).replace("<", "\\u003c")
    for mark, value in (
        ("{{title}}", html.escape(data["title"])),
        ("{{style}}", room.joinpath("page.css").read_text(encoding="utf-8")),
        ("{{program}}", room.joinpath("page.js").read_text(encoding="utf-8")),
        ("{{data}}", numbers),
    ):
        text = text.replace(mark, value, 1)
    return text


def versions() -> str:
    """Versions that the numbers come from."""
    from importlib.metadata import PackageNotFoundError, version

    try:
        own = version("linkframe")
    except PackageNotFoundError:
        own = "not installed"
    return f"linkframe {own}, NumPy {np.__version__}, Python {platform.python_version()}"
