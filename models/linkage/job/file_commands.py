"""Other commands for files of linkages: ``linkframe new``, ``page`` and ``convert``."""

from __future__ import annotations

import warnings
from argparse import ArgumentParser, Namespace, RawDescriptionHelpFormatter
from pathlib import Path
from typing import TYPE_CHECKING

from ....framework.errors import FrameError
from ...job.output import terminal_width
from ...job.tables import folded
from ..files import read, read_linkage, sketch_file, source, write_linkage
from ..robot_files import left_out
from . import page

if TYPE_CHECKING:
    from argparse import _SubParsersAction

NEW = """\
Write a commented TOML file with a small linkage, its loads, sections, tolerances and drive, to be changed into one's
own. `linkframe run FILE` then computes it."""
PAGE = """\
Write one file that opens in a browser, without a network: drag the drive, and set the load, clearances and tolerances;
the path, where the point can be at worst, its deflection, forces and the contributors follow. Poses are those of [run]
in the file, or else the whole range of its drive. SI units."""
CONVERT = """\
Write the linkage of a file in another format; the endings tell which:

  .toml   linkframe's own, read and written
  .xml    MJCF of MuJoCo, closed loops included, read and written
  .urdf   URDF, written; only linkages without loops, and those whose joints follow the drive in proportion
  .sdf    SDF, likewise

What the other format has no words for is left out, and told."""
WRITTEN = (".toml", ".xml", ".urdf", ".sdf")


def add_to(jobs: _SubParsersAction[ArgumentParser]) -> None:
    """Add the subcommands to the jobs of the command line."""
    as_written = RawDescriptionHelpFormatter
    new = jobs.add_parser("new", help="write a commented file of a linkage to begin with", description=NEW)
    new.add_argument("file", type=Path, metavar="FILE", help="TOML file to write; one that is there is left alone")
    new.set_defaults(run=_new)
    parser = jobs.add_parser(
        "page", help="page for a browser of the linkage in a file", description=PAGE, formatter_class=as_written
    )
    parser.add_argument("file", type=Path, metavar="FILE", help="TOML file with the linkage")
    parser.add_argument("--point", metavar="NAME", help="the point that is looked at (default: the first to report)")
    parser.add_argument("--out", type=Path, metavar="PAGE", help="file to write (default: NAME.html for NAME.toml)")
    parser.set_defaults(run=_page)
    formats = "linkage of a file in another format: TOML, MJCF, URDF, SDF"
    convert = jobs.add_parser("convert", help=formats, description=CONVERT, formatter_class=as_written)
    convert.add_argument("file", type=Path, metavar="FILE", help="file with the linkage, .toml or .xml")
    convert.add_argument("out", type=Path, metavar="OUT", help="file to write; it is replaced")
    convert.set_defaults(run=_convert)


def _new(options: Namespace) -> None:
    sketch_file.write_sketch(options.file)
    print(f"Written: {options.file}. Change it into your linkage, and compute it: linkframe run {options.file}")


def _page(options: Namespace) -> None:
    out = options.out or Path(f"{options.file.stem}.html")
    point = page.write_file_page(source.Source(options.file), out, options.point)
    print(f"Written: {out}, where {point} goes. Open it in a browser.")


def _convert(options: Namespace) -> None:
    if options.out.suffix.lower() not in WRITTEN:
        raise FrameError(f"{options.out}: choose an ending of {', '.join(WRITTEN)}, which tells the format")
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always", left_out.ConversionWarning)
        _write_converted(options.file, options.out)
    print(f"Written: {options.out}")
    for warning in told:
        print(folded(f"Note: {warning.message}", terminal_width()))


def _write_converted(file: Path, out: Path) -> None:
    """Read one file and write the other; tables of the job of ``linkframe run`` are left out, with a warning."""
    if file.resolve() == out.resolve():
        raise FrameError(f"{file} would be written over itself: give another name")
    write_linkage.write_linkage(read_linkage.read_linkage(file), out)
    if file.suffix.lower() != ".xml":
        tables = [name for name in read.JOB if name in source.Source(file).data]
        if tables:
            text = f"{out}: what {file} has for linkframe run is left out: {', '.join(tables)}"
            warnings.warn(text, left_out.ConversionWarning, stacklevel=2)
