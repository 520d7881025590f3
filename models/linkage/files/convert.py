"""A file of a linkage in another format."""

from __future__ import annotations

import warnings
from pathlib import Path

from ....framework.errors import FrameError
from ..robot_files.left_out import ConversionWarning
from .read import JOB
from .read_linkage import read_linkage
from .source import Source
from .write_linkage import write_linkage


def convert(file: Path, out: Path) -> None:
    """Read one file and write the other; tables of the job of ``linkframe run`` are left out, and told.

    Raises
    ------
    FrameError
        If both are the same file, or as by `read_linkage` and `write_linkage`.
    """
    if file.resolve() == out.resolve():
        raise FrameError(f"{file} would be written over itself: give another name")
    linkage = read_linkage(file)
    write_linkage(linkage, out)
    if file.suffix.lower() != ".xml":
        tables = [name for name in JOB if name in Source(file).data]
        if tables:
            text = f"{out}: what {file} has for linkframe run is left out: {', '.join(tables)}"
            warnings.warn(text, ConversionWarning, stacklevel=2)
