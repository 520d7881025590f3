"""The command ``linkframe``: one subcommand a job."""

from __future__ import annotations

import sys
from argparse import ArgumentParser
from collections.abc import Sequence
from importlib.metadata import version
from io import TextIOWrapper

from ..framework.errors import FrameError
from .four_bar import command as four_bar
from .linkage.job import command as linkage


def parser() -> ArgumentParser:
    """Parser of the whole command line; each job adds its own subcommand."""
    top = ArgumentParser(
        prog="linkframe",
        description="Frame elements for mechanisms: where every point of a linkage really goes.",
    )
    top.add_argument("--version", action="version", version=f"linkframe {version('linkframe')}")
    jobs = top.add_subparsers(title="jobs", dest="job", metavar="JOB", required=True)
    four_bar.add_to(jobs)
    linkage.add_to(jobs)
    return top


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line.

    Parameters
    ----------
    arguments
        Words after the program's name; those of the process if None.

    Returns
    -------
    int
        Exit code: 0 when the job is done, 2 for bad input, 130 when interrupted.
    """
    for stream in (sys.stdout, sys.stderr):
        # A terminal whose encoding has no Greek letters shows question marks for them.
        if isinstance(stream, TextIOWrapper):
            stream.reconfigure(errors="replace")
    options = parser().parse_args(arguments)
    try:
        options.run(options)
    except FrameError as error:
        print(f"linkframe {options.job}: error: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print(f"linkframe {options.job}: interrupted; nothing was written", file=sys.stderr)
        return 130
    return 0
