"""``linkframe new``: a file with a small linkage to begin with."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from argparse import _SubParsersAction

DESCRIPTION = """\
Write a commented TOML file with a small linkage, its loads, sections, tolerances and drive, to be changed into one's
own. `linkframe run FILE` then computes it."""


def add_to(jobs: _SubParsersAction[ArgumentParser]) -> None:
    """Add the subcommand ``new`` to the jobs of the command line."""
    parser = jobs.add_parser("new", help="write a commented file of a linkage to begin with", description=DESCRIPTION)
    parser.add_argument("file", type=Path, metavar="FILE", help="TOML file to write; one that is there is left alone")
    parser.set_defaults(run=_start)


def _start(options: Namespace) -> None:
    from ..files.sketch_file import write_sketch

    write_sketch(options.file)
    print(f"Written: {options.file}. Change it into your linkage, and compute it: linkframe run {options.file}")
