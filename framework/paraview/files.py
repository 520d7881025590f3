"""Output that is there whole or not at all."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

from ..errors import FrameError


@contextmanager
def whole_or_nothing(directory: Path) -> Iterator[Path]:
    """Lend a folder to write in; its files move to `directory` at the end, and after an error none do.

    Parameters
    ----------
    directory
        An existing folder. Files keep their place relative to it; the deepest move first, so that a file
        that lists others appears after them.

    Raises
    ------
    FrameError
        If `directory` is missing or cannot be written.
    """
    try:
        with TemporaryDirectory(dir=directory, prefix=".linkframe-") as name:
            stage = Path(name)
            yield stage
            written = [file for file in stage.rglob("*") if file.is_file()]
            for file in sorted(written, key=lambda file: (-len(file.parts), file)):
                target = directory / file.relative_to(stage)
                target.parent.mkdir(exist_ok=True)
                os.replace(file, target)
    except OSError as error:
        raise FrameError(
            f"cannot write in {directory}: {error.strerror or error}; choose a folder that exists and can be written"
        ) from error
