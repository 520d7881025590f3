"""The folder for the results of a job, without files of an earlier run."""

from __future__ import annotations

import shutil
import sys
from argparse import ArgumentParser, ArgumentTypeError, _ArgumentGroup
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

from ...framework.errors import FrameError
from ...framework.paraview.files import whole_or_nothing

# Files that each job writes in every run; no other job writes all of them.
SIGNS = {"four-bar": ("table1.csv", "reactions.csv"), "run": ("table.csv", "reactions.csv")}

# Figures that a job draws: none, those in the plane, or these and the picture in space.
FIGURES = ("none", "2d", "all")
# Formats of figures in the plane; the picture in space is always a PNG.
FORMATS = ("png", "svg", "pdf")


@contextmanager
def results(out: Path, job: str, earlier: Iterable[str]) -> Iterator[Path]:
    """Give a temporary folder to write in; its files replace those of an earlier run in `out`, all of them or none.

    Parameters
    ----------
    out
        Folder for the results, made if it is missing.
    job
        Key of `SIGNS`.
    earlier
        Patterns of files that an earlier run may have left; those that this run does not write are removed.

    Raises
    ------
    FrameError
        If `out` cannot be made or written, or has the results of another job, with which these would mix; then nothing
        in it is changed.
    """
    _refuse_mixing(out, job)
    with whole_or_nothing(out) as stage:
        yield stage
        new = {path.relative_to(stage) for path in stage.rglob("*")}
    for pattern in _any_format(earlier):
        for path in out.glob(pattern):
            if path.relative_to(out) not in new:
                path.unlink(missing_ok=True)


def _any_format(patterns: Iterable[str]) -> Iterator[str]:
    """Patterns of files, those of figures in every format."""
    for pattern in patterns:
        stem, dot, ending = pattern.rpartition(".")
        yield from (f"{stem}{dot}{each}" for each in FORMATS) if ending == "png" else (pattern,)


def _refuse_mixing(out: Path, job: str) -> None:
    for other, signs in SIGNS.items():
        if other != job and all((out / name).is_file() for name in signs):
            raise FrameError(
                f"--out {out} holds the results of linkframe {other} ({', '.join(signs)}, ...), which would mix with "
                f"those of linkframe {job}: give another folder, or remove them first"
            )


def terminal_width() -> int | None:
    """Characters in a line of the terminal; None if the output does not go to a terminal."""
    return shutil.get_terminal_size().columns if sys.stdout.isatty() else None


def written(stage: Path) -> list[str]:
    """Names of the files and folders in the folder of `results`, folders with a slash at the end."""
    return sorted(path.name + "/" * path.is_dir() for path in stage.iterdir())


def folder(text: str) -> Path:
    """A folder's name from the command line."""
    if not text:
        raise ArgumentTypeError("is empty: give a folder; . is the current folder")
    return Path(text)


def add_output(parser: ArgumentParser | _ArgumentGroup, out: Path | None, text: str = "") -> None:
    """Add the options for the folder of the results and for the figures.

    Parameters
    ----------
    parser
        Parser to which they are added.
    out
        Default folder; None if it depends on other options.
    text
        The default in words, if `out` is None.
    """
    parser.add_argument("--out", type=folder, metavar="DIR", default=out, help=f"directory for the results{text}")
    parser.add_argument(
        "--figures", choices=FIGURES, default="all",
        help="which are drawn: none, those in the plane, or these and the picture in space",
    )  # fmt: skip
    parser.add_argument("--wide", action="store_true", help="print the table in one piece, wider than the terminal")
    parser.add_argument(
        "--format", choices=FORMATS, nargs="+", default=["png"],
        help="forms of the figures in the plane, one or more; the report shows the first that browsers show",
    )  # fmt: skip
