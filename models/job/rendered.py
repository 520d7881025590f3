"""The picture in space, where the machine can make it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ...framework.paraview.entries import Entry
    from ...framework.solution import Solution


def rendered(solution: Solution, path: Path, entry: Entry) -> list[str]:
    """Draw a solved frame in space; what there is to tell where that cannot be done."""
    from ...framework.pictures.rendering import RenderingError
    from ...framework.view import picture

    try:
        picture(solution, path, entry=entry)
    except RenderingError as error:
        return [f"Without the 3-D picture: {error}."]
    return []
