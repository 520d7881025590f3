"""Output that is there whole or not at all."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from tempfile import TemporaryDirectory

from ..errors import FrameError
from ..interrupts import put_off
from ..owner import is_gone, owner

# Folders that are written in; behind it their owner, and what tells several of one owner apart.
STAGE = ".linkframe-"


@contextmanager
def whole_or_nothing(directory: Path) -> Iterator[Path]:
    """Lend a folder to write in; its files move to `directory` at the end, and after an error none do.

    Parameters
    ----------
    directory
        Where the files go, made where it is missing. Files keep their place relative to it; the deepest move
        first, so that a file that lists others appears after them. What a process that was killed left of its folder
        is removed.

    Raises
    ------
    FrameError
        If `directory` cannot be made or written.
    """
    try:
        with ExitStack() as begun:
            # What is made is known to what unmakes it before an interrupt comes.
            with put_off("SIGINT", "SIGTERM", "SIGHUP"):
                begun.enter_context(_made(directory))
                stage = Path(begun.enter_context(TemporaryDirectory(dir=directory, prefix=f"{STAGE}{owner()}-")))
            _remove_abandoned(directory)
            yield stage
            written = [file for file in stage.rglob("*") if file.is_file()]
            with put_off("SIGINT", "SIGTERM"):
                for file in sorted(written, key=lambda file: (-len(file.parts), file)):
                    target = directory / file.relative_to(stage)
                    target.parent.mkdir(exist_ok=True)
                    os.replace(file, target)
    except BrokenPipeError:  # of what the body prints to
        raise
    except OSError as error:
        raise FrameError(
            f"cannot write in {directory}: {error.strerror or error}; choose a folder that can be written"
        ) from error


def _remove_abandoned(directory: Path) -> None:
    """Remove the folders of processes that have ended; those of processes that may live are not touched."""
    for path in directory.glob(f"{STAGE}*"):
        if is_gone(path.name.removeprefix(STAGE).rpartition("-")[0]):
            shutil.rmtree(path, ignore_errors=True)


@contextmanager
def _made(directory: Path) -> Iterator[None]:
    """Create `directory` and its parents, and remove the created ones if the body fails."""
    missing = [path for path in (directory, *directory.parents) if not path.exists()]
    try:
        directory.mkdir(parents=True, exist_ok=True)
        yield
    except BaseException:
        for path in missing:
            with suppress(OSError):
                path.rmdir()
        raise
