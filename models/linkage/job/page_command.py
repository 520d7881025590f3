"""``linkframe page``: the page of the linkage that a file describes."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace, RawDescriptionHelpFormatter
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from argparse import _SubParsersAction

DESCRIPTION = """\
Write one file that opens in a browser, without a network: drag the drive, and set the load, clearances and tolerances;
the path, where the point can be at worst, its deflection, forces and the contributors follow. Poses are those of [run]
in the file, or else the whole range of its drive. SI units."""


def add_to(jobs: _SubParsersAction[ArgumentParser]) -> None:
    """Add the subcommand ``page`` to the jobs of the command line."""
    parser = jobs.add_parser(
        "page",
        help="page for a browser of the linkage in a file",
        description=DESCRIPTION,
        formatter_class=RawDescriptionHelpFormatter,
    )
    parser.add_argument("file", type=Path, metavar="FILE", help="TOML file with the linkage")
    parser.add_argument("--point", metavar="NAME", help="the point that is looked at (default: the first to report)")
    parser.add_argument("--out", type=Path, metavar="PAGE", help="file to write (default: NAME.html for NAME.toml)")
    parser.set_defaults(run=_start)


def _start(options: Namespace) -> None:
    from ..files.source import Source
    from .page import write_file_page

    out = options.out or Path(f"{options.file.stem}.html")
    point = write_file_page(Source(options.file), out, options.point)
    print(f"Written: {out}, where {point} goes. Open it in a browser.")
