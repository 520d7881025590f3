"""The command ``linkframe``, with a subcommand for each job."""

from __future__ import annotations

import codecs
import gc
import os
import signal
import sys
from argparse import Action, ArgumentParser, Namespace
from collections.abc import Sequence
from io import TextIOWrapper
from pathlib import Path
from time import perf_counter, process_time
from typing import Any

from ..framework.errors import FrameError
from .job.signals import Signals
from .linkage.job import command as linkage
from .linkage.job import file_commands
from .paper import command as four_bar

SPELT = "linkframe-spelt"
SPELLING = {
    "μ": "m", "µ": "u", "σ": "s", "θ": "t", "κ": "k", "ε": "e", "γ": "g", "×": "x", "·": ".", "−": "-", "–": "-",
    "│": "|", "±": "+-", "²": "^2", "³": "^3", "°": "deg", "…": "...",
}  # fmt: skip


def _spelt(error: UnicodeError) -> tuple[str, int]:
    """Replacement for letters that an encoding lacks, by `SPELLING`, or else question marks."""
    if not isinstance(error, UnicodeEncodeError):
        raise error
    return "".join(SPELLING.get(letter, "?") for letter in error.object[error.start : error.end]), error.end


codecs.register_error(SPELT, _spelt)


def parser() -> ArgumentParser:
    """Parser of the command line, to which each job adds its subcommand."""
    top = ArgumentParser(
        prog="linkframe",
        description="Frame elements for mechanisms: where every point of a linkage really goes.",
    )
    top.add_argument("--version", action=_Version, nargs=0, help="show program's version number and exit")
    jobs = top.add_subparsers(title="jobs", dest="job", metavar="JOB", required=True)
    four_bar.add_to(jobs)
    linkage.add_to(jobs)
    file_commands.add_to(jobs)
    return top


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line.

    Parameters
    ----------
    arguments
        Arguments after the program's name; those of the process if None.

    Returns
    -------
    int
        Exit code: 0 if the job is done, 2 for bad input, 130 if interrupted, 143 if terminated, 141 if the reader of
        its output has closed the pipe.
    """
    # Counted back by the computing time, because the process may have started earlier as a shell that waited.
    begun = perf_counter() - (process_time() if arguments is None else 0.0)
    _open_closed()
    for stream in (sys.stdout, sys.stderr):
        # If the encoding has no Greek letters, Latin ones replace them, so that mean and deviation can be told apart.
        if isinstance(stream, TextIOWrapper):
            stream.reconfigure(errors=SPELT)
    try:
        options = _options(arguments)
    except BrokenPipeError:
        return _unread()
    options.begun, options.alone = begun, arguments is None
    with Signals(last=arguments is None) as signals:
        try:
            options.run(options)
            sys.stdout.flush()
        except FrameError as error:
            print("\n".join([f"linkframe {options.job}: error: {error}", *_notes(error)]), file=sys.stderr)
            return 2
        except BrokenPipeError:
            return _unread()
        except KeyboardInterrupt as interrupt:
            signals.code = signals.code or 128 + signal.SIGINT
            told = [f"linkframe {options.job}: interrupted; files are written all or none", *_notes(interrupt)]
            print("\n".join(told), file=sys.stderr)
    if arguments is None:
        # The process ends: a last garbage collection would only take time.
        gc.freeze()
    return signals.code


def _options(arguments: Sequence[str] | None) -> Namespace:
    """The options of a job; ``--help`` and ``--version`` print and end the process."""
    top = parser()
    try:
        options, unknown = top.parse_known_args(arguments)
    except SystemExit:
        sys.stdout.flush()
        raise
    if unknown:
        job = f"linkframe {options.job}"
        top.exit(2, f"{job}: error: {' '.join(unknown)}: no such option; {job} --help lists them\n")
    return options


def _open_closed() -> None:
    """Open missing standard streams to the null device, so that no file of the job gets their descriptors."""
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:
            setattr(sys, name, Path(os.devnull).open("w", encoding="utf-8"))  # noqa: SIM115  # to the end of the process


def _unread() -> int:
    """Exit code if the reader has closed the pipe; buffered output is discarded when Python ends."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    return 128 + Signals.PIPE


class _Version(Action):
    """Print the version, which is looked up only on request because that takes longer than reading the options."""

    def __call__(self, parser: ArgumentParser, *_: Any) -> None:
        from importlib.metadata import version

        print(f"linkframe {version('linkframe')}")
        parser.exit()


def _notes(error: BaseException) -> list[str]:
    """Notes added to an error, such as how a run can be resumed."""
    return [f"  {note}" for note in getattr(error, "__notes__", ())]
