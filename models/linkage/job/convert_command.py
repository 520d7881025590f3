"""``linkframe convert``: the linkage of a file in another format."""

from __future__ import annotations

import warnings
from argparse import ArgumentParser, Namespace, RawDescriptionHelpFormatter
from pathlib import Path
from typing import TYPE_CHECKING

from ....framework.errors import FrameError
from ...job.output import terminal_width
from ...job.tables import folded

if TYPE_CHECKING:
    from argparse import _SubParsersAction

DESCRIPTION = """\
Write the linkage of a file in another format; the endings tell which:

  .toml   linkframe's own, read and written
  .xml    MJCF of MuJoCo, closed loops included, read and written
  .urdf   URDF, written; only linkages without loops, and those whose joints follow the drive in proportion
  .sdf    SDF, likewise

What the other format has no words for is left out, and told."""
WRITTEN = (".toml", ".xml", ".urdf", ".sdf")


def add_to(jobs: _SubParsersAction[ArgumentParser]) -> None:
    """Add the subcommand ``convert`` to the jobs of the command line."""
    parser = jobs.add_parser(
        "convert",
        help="linkage of a file in another format: TOML, MJCF, URDF, SDF",
        description=DESCRIPTION,
        formatter_class=RawDescriptionHelpFormatter,
    )
    parser.add_argument("file", type=Path, metavar="FILE", help="file with the linkage, .toml or .xml")
    parser.add_argument("out", type=Path, metavar="OUT", help="file to write; it is replaced")
    parser.set_defaults(run=_start)


def _start(options: Namespace) -> None:
    from ..robot_files.left_out import ConversionWarning

    if options.out.suffix.lower() not in WRITTEN:
        raise FrameError(f"{options.out}: choose an ending of {', '.join(WRITTEN)}, which tells the format")
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always", ConversionWarning)
        _convert(options.file, options.out)
    print(f"Written: {options.out}")
    for warning in told:
        print(folded(f"Note: {warning.message}", terminal_width()))


def _convert(file: Path, out: Path) -> None:
    """Read one file and write the other; tables of the job of ``linkframe run`` are left out, and told."""
    from ..files.read import JOB
    from ..files.read_linkage import read_linkage
    from ..files.source import Source
    from ..files.write_linkage import write_linkage
    from ..robot_files.left_out import ConversionWarning

    if file.resolve() == out.resolve():
        raise FrameError(f"{file} would be written over itself: give another name")
    write_linkage(read_linkage(file), out)
    if file.suffix.lower() != ".xml":
        tables = [name for name in JOB if name in Source(file).data]
        if tables:
            text = f"{out}: what {file} has for linkframe run is left out: {', '.join(tables)}"
            warnings.warn(text, ConversionWarning, stacklevel=2)
