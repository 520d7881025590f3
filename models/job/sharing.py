"""Processes that compute the samples of a job, and the checkpoint from which an interrupted run continues."""

from __future__ import annotations

import json
import sys
import warnings
from argparse import ArgumentParser, ArgumentTypeError, Namespace, _ArgumentGroup
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from itertools import zip_longest
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

from ...framework.errors import CheckpointWarning, FrameError, expected_mechanisms
from ..propagation import checkpoint, ordered, packed, workers
from . import parts

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from ..propagation.checkpoint import Checkpoint
    from ..propagation.ordered import StoredChunks
    from .parts import Parts, PartTask
    from .stages import Advance


class SamplePiece(NamedTuple):
    """Some of the samples of one kind.

    Attributes
    ----------
    start, stop
        Number of the first sample, and of the one after the last.
    of
        Name of the kind.
    """

    start: int
    stop: int
    of: str

    @property
    def cut(self) -> slice:
        """The numbers of the samples."""
        return slice(self.start, self.stop)


@dataclass(frozen=True, eq=False)
class SampleKind:
    """Samples of one kind, such as those at large displacement.

    Attributes
    ----------
    what
        Name in progress messages.
    parts
        Their results.
    names
        Names of the results that are needed.
    """

    what: str
    parts: Parts
    names: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class Sharing:
    """Processes that compute the samples of a job, and the folder of its checkpoint.

    Attributes
    ----------
    workers
        Number of processes; −1 for all processors.
    folder
        Folder in which each part is stored soon after it is done; None for no checkpoint.
    about
        By name: everything that distinguishes this run from others.
    """

    workers: int = 1
    folder: Path | None = None
    about: Mapping[str, Any] = field(default_factory=dict)

    def compute(self, kinds: Mapping[str, SampleKind], advance: Advance) -> None:
        """Compute samples of several kinds in turns, so that the first parts show how long all will take.

        Parameters
        ----------
        kinds
            Kinds by name, in lower-case letters.
        advance
            Called with the name of a kind in messages, and the number of poses times samples that were done.

        Raises
        ------
        FrameError
            If a sample cannot be computed, or a part cannot be stored.
        """
        task = PieceTask({name: kind.parts.begin(kind.names) for name, kind in kinds.items()})
        wanted = {name: kinds[name] for name, part in task.tasks.items() if part.names}
        turns = zip_longest(
            *([SamplePiece(cut.start, cut.stop, name) for cut in k.parts.cuts] for name, k in wanted.items())
        )
        pieces = [piece for turn in turns for piece in turn if piece is not None]
        kept = self._opened()
        stored = {} if kept is None else ordered.covered(pieces, _stored(kept.checkpoint))
        # new processes are spawned, as a copy of this one would lack the thread that shows the progress; this process
        # does the first piece of each kind, after which the remaining time is known
        with parts.sparing_what_is_there(any(part.several for part in task.tasks.values())):
            ordered.gather(
                pieces,
                lambda left: workers.computed(task, left, self.workers, "spawn", len(wanted)),
                _Collected(wanted, advance, self.folder),
                kept,
                stored,
            )

    def _opened(self) -> StoredChunks[Mapping[str, NDArray[Any]]] | None:
        if self.folder is None:
            return None
        kept = checkpoint.Checkpoint.open(self.folder, _plain(self.about))
        return ordered.StoredChunks(kept, packed.packed_arrays, packed.unpacked_arrays)


# This process computes all samples, without a checkpoint.
ALONE = Sharing()


@dataclass(frozen=True, eq=False)
class PieceTask:
    """Computation of a piece of any kind.

    Attributes
    ----------
    tasks
        Computation by kind.
    """

    tasks: Mapping[str, PartTask]

    def __call__(self, piece: SamplePiece) -> dict[str, NDArray[Any]]:
        """Results of the piece's samples by name."""
        with expected_mechanisms():
            return self.tasks[piece.of](piece.cut)


@dataclass(frozen=True, eq=False)
class _Collected:
    """Stores the results of pieces, and reports the progress."""

    kinds: Mapping[str, SampleKind]
    advance: Advance
    folder: Path | None

    def expect(self, piece: SamplePiece) -> None:
        self.advance(self.kinds[piece.of].what, 0)

    def add(self, piece: SamplePiece, found: Mapping[str, NDArray[Any]]) -> None:
        kind = self.kinds[piece.of]
        if lacking := [name for name in kind.names if name not in found and not kind.parts.knows(name)]:
            raise FrameError(
                f"checkpoint {self.folder} is of another release, without {lacking[0]}: give another folder"
            )
        kind.parts.put(piece.cut, found)
        self.advance(kind.what, kind.parts.size(piece.cut))

    def progress(self, done: int, of: int) -> str:
        if self.folder is None:
            return f"{done} of {of} parts were done; with --checkpoint DIR an interrupted run can be resumed"
        return f"{done} of {of} parts are stored in {self.folder}: the same command goes on from there"


def _stored(kept: Checkpoint) -> set[tuple[Any, ...]]:
    """Complete pieces of a checkpoint; damaged ones are reported on the standard error."""
    with warnings.catch_warnings(record=True) as damaged:
        warnings.simplefilter("always", CheckpointWarning)
        found = kept.stored()
    for each in damaged:
        print(f"linkframe: note: {each.message}", file=sys.stderr, flush=True)
    return found


def _plain(about: Mapping[str, Any]) -> dict[str, Any]:
    """The same data as read back from JSON."""
    found: dict[str, Any] = json.loads(json.dumps(about, default=str))
    return found


# -- the command line -------------------------------------------------------------------------------------------------


def add_sharing(parser: ArgumentParser | _ArgumentGroup) -> None:
    """Add the options for worker processes and the checkpoint."""
    parser.add_argument(
        "--workers", type=_workers, metavar="N", default=1,
        help="processes that compute samples, -1 for one a processor; the results are the same to the last bit",
    )  # fmt: skip
    parser.add_argument(
        "--checkpoint", type=Path, metavar="DIR",
        help="store each part of the samples in DIR as it is done; the same command then goes on where it was ended",
    )  # fmt: skip
    parser.add_argument(
        "--resume", action="store_true", help="go on with the run in --checkpoint DIR, and begin none there"
    )


def _workers(text: str) -> int:
    try:
        value = int(text)
    except ValueError:
        value = 0
    if value < 1 and value != -1:
        raise ArgumentTypeError(f"is {text!r}: give a whole number of processes, or -1 for one for each processor")
    return value


class SampledInputs(Protocol):
    """The part of a job's inputs that concerns its samples."""

    @property
    def about(self) -> Mapping[str, object]:
        """Everything that the samples depend on, by name."""

    @property
    def uncertain(self) -> bool:
        """Whether there are samples."""


def sharing(options: Namespace, inputs: SampledInputs) -> Sharing:
    """Worker processes and checkpoint by the options, checked before anything is computed.

    Parameters
    ----------
    options
        Options of the command line.
    inputs
        Inputs of the job.

    Raises
    ------
    FrameError
        If the folder has another run or cannot be read, or there is nothing to resume.
    """
    given = {"--workers": options.workers != 1, "--checkpoint": options.checkpoint, "--resume": options.resume}
    for name in [name for name, there in given.items() if there]:
        if not inputs.uncertain:
            raise FrameError(f"{name} has no effect, as the file has no tolerances: leave it out")
    if options.resume and options.checkpoint is None:
        raise FrameError("--resume has no folder to go on in: give it with --checkpoint DIR")
    if options.checkpoint is None:
        return Sharing(options.workers)
    from importlib.metadata import version

    whole = {"the job": options.job, "the release of linkframe": version("linkframe"), **inputs.about}
    found = Sharing(options.workers, options.checkpoint, whole)
    for note in _taken_up(found, options.resume):
        print(f"linkframe {options.job}: note: {note}", file=sys.stderr, flush=True)
    return found


def _taken_up(found: Sharing, resume: bool) -> Iterator[str]:
    """Refuse the folder of another run, and with `resume` an empty one; yields notes on a run that is continued."""
    if found.folder is None:
        return
    if checkpoint.Checkpoint(found.folder).holds(_plain(found.about)):
        count = sum(checkpoint.CHUNK.fullmatch(path.name) is not None for path in found.folder.iterdir())
        stored = "part of this run is" if count == 1 else "parts of this run are"
        yield f"{count} {stored} stored in {found.folder}: it goes on from there"
    elif resume:
        raise FrameError(f"--resume finds no run in {found.folder}: leave it out to begin one there")
