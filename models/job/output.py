"""The folder for the results of a job, rid of what an earlier run left."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

from ...framework.paraview.files import whole_or_nothing


@contextmanager
def results(out: Path, earlier: Iterable[str]) -> Iterator[Path]:
    """Lend a folder to write in; its files replace those of an earlier run in `out`, all of them or none.

    Parameters
    ----------
    out
        Folder for the results, made where it is missing.
    earlier
        Patterns of files that a run may leave; those that this one does not write are removed.

    Raises
    ------
    FrameError
        If `out` cannot be made or written; then nothing is left behind.
    """
    with whole_or_nothing(out) as stage:
        yield stage
        new = {path.relative_to(stage) for path in stage.rglob("*")}
    for pattern in earlier:
        for path in out.glob(pattern):
            if path.relative_to(out) not in new:
                path.unlink(missing_ok=True)
