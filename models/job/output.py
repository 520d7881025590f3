"""The folder for the results of a job, rid of what an earlier run left."""

from __future__ import annotations

from argparse import ArgumentTypeError
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

from ...framework.errors import FrameError
from ...framework.paraview.files import whole_or_nothing

# Files that each job writes in every run, and no other job does.
SIGNS = {"four-bar": ("figure5.png", "table1.csv"), "run": ("mechanism.png", "table.csv")}


@contextmanager
def results(out: Path, job: str, earlier: Iterable[str]) -> Iterator[Path]:
    """Lend a folder to write in; its files replace those of an earlier run in `out`, all of them or none.

    Parameters
    ----------
    out
        Folder for the results, made where it is missing.
    job
        Key of `SIGNS`.
    earlier
        Patterns of files that a run may leave; those that this one does not write are removed.

    Raises
    ------
    FrameError
        If `out` cannot be made or written, or holds the results of another job, with which these would mix; then
        nothing is left behind, and nothing there is changed.
    """
    _refuse_mixing(out, job)
    with whole_or_nothing(out) as stage:
        yield stage
        new = {path.relative_to(stage) for path in stage.rglob("*")}
    for pattern in earlier:
        for path in out.glob(pattern):
            if path.relative_to(out) not in new:
                path.unlink(missing_ok=True)


def _refuse_mixing(out: Path, job: str) -> None:
    for other, signs in SIGNS.items():
        if other != job and all((out / name).is_file() for name in signs):
            raise FrameError(
                f"--out {out} holds the results of linkframe {other} ({', '.join(signs)}, ...), which would mix with "
                f"those of linkframe {job}: give another folder, or remove them first"
            )


def written(stage: Path) -> list[str]:
    """Names of what stands in a folder lent by `results`, folders with a stroke behind."""
    return sorted(path.name + "/" * path.is_dir() for path in stage.iterdir())


def folder(text: str) -> Path:
    """A folder's name from the command line."""
    if not text:
        raise ArgumentTypeError("is empty: give a folder; . is the one that you are in")
    return Path(text)
