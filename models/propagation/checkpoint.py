"""Chunks of a run on disk, each complete with a check sum, so that an interrupted run can continue."""

from __future__ import annotations

import json
import os
import re
import warnings
import zlib
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...framework.errors import CheckpointWarning, FrameError
from ...framework.owner import is_gone, owner

Array = NDArray[np.float64]

FORMAT = 6
ABOUT = "run.json"
FUNCTION = "what the function returns for the first samples"
# Name of a chunk's file: its first sample, the one after its last, and the kind of samples if there are several.
CHUNK = re.compile(r"chunk-(\d+)-(\d+)(?:-([a-z]+))?\.bin")
# Name of a file that is being written, with the process that writes it.
PART = re.compile(r"\..+\.(.+)\.part")
# Relative difference by which results of the first samples may differ from those of an earlier run on another machine
# or with another release of a library; and the share of the largest result below which a difference is rounding. The
# latter is small, as results of different units may differ by many orders.
SAME, NOTHING = 1e-9, 1e-15


@dataclass(frozen=True, eq=False)
class Checkpoint:
    """A folder that holds the chunks of one run.

    Parameters
    ----------
    folder
        The folder.
    """

    folder: Path

    @cached_property
    def _owner(self) -> str:
        return owner()

    @property
    def is_there(self) -> bool:
        """Whether the folder is there, with what was stored in it."""
        return self.folder.is_dir()

    @classmethod
    def open(cls, folder: str | os.PathLike[str], about: Mapping[str, Any]) -> Checkpoint:
        """Take up the run of a folder, or begin one there.

        Parameters
        ----------
        folder
            Made where it is missing.
        about
            Everything that the run depends on, by which it is told from another.

        Raises
        ------
        FrameError
            If the folder holds another run or cannot be written, and what differs.
        """
        found = cls(Path(folder))
        if not found.holds(about) and not found._begin(about):
            found.holds(about)  # another process began one meanwhile
        found._remove_abandoned()
        return found

    def holds(self, about: Mapping[str, Any]) -> bool:
        """Whether this run was begun in the folder.

        Parameters
        ----------
        about
            As for `open`.

        Raises
        ------
        FrameError
            If the folder holds another run or cannot be read, and what differs.
        """
        before = self._about()
        if before is None:
            return False
        other = [what for what in dict.fromkeys([*about, *before]) if before.get(what) != about.get(what)]
        # with other inputs the function returns other results in any case
        other = [what for what in other if what != FUNCTION] or other
        if other:
            raise FrameError(
                f"checkpoint {self.folder} belongs to another run: {', '.join(other)} "
                f"{'differs' if len(other) == 1 else 'differ'}; give another folder, or what that run was begun with"
            )
        return True

    @classmethod
    def known(cls, folder: str | os.PathLike[str]) -> dict[str, Any] | None:
        """Description of the run in a folder; None if there is none yet."""
        return cls(Path(folder))._about()

    @staticmethod
    def made(folder: str | os.PathLike[str]) -> None:
        """Make the folder if it is missing; an error if that fails, or if it cannot be written to."""
        try:
            Path(folder).mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise FrameError(f"checkpoint {folder} cannot be made: {error.strerror or error}") from error
        if not os.access(folder, os.W_OK | os.X_OK):
            raise FrameError(f"checkpoint {folder} cannot be written: give a folder that you may write to")

    def _about(self) -> dict[str, Any] | None:
        path = self.folder / ABOUT
        try:
            text = path.read_text(encoding="utf-8")
        except FileNotFoundError:
            if self.folder.is_dir() and any(CHUNK.fullmatch(each.name) for each in self.folder.iterdir()):
                raise FrameError(
                    f"checkpoint {self.folder} holds chunks, but no {ABOUT}: give another folder"
                ) from None
            return None
        except OSError as error:
            raise FrameError(f"checkpoint {self.folder} cannot be read: {error.strerror or error}") from error
        try:
            found = json.loads(text)
            if not isinstance(found, dict):
                raise ValueError
        except ValueError:
            raise FrameError(f"{path} is damaged: remove the folder, and the run begins anew") from None
        if found.pop("format", None) != FORMAT:
            raise FrameError(f"{path} is of another release: give another folder")
        return found

    def _begin(self, about: Mapping[str, Any]) -> bool:
        """Begin the run; False if another process has begun one meanwhile."""
        self.made(self.folder)
        text = json.dumps({"format": FORMAT, **about}, indent=1)
        return self._write(ABOUT, [text.encode()], "the run cannot be begun there", new=True)

    def _remove_abandoned(self) -> None:
        """Remove incomplete files of processes that have ended."""
        for path in self.folder.glob(".*.part"):
            match = PART.fullmatch(path.name)
            if match is not None and is_gone(match[1]):
                with suppress(OSError):
                    path.unlink()

    def stored(self) -> set[tuple[Any, ...]]:
        """Ranges of the chunks that are stored and undamaged; each damaged one gives a warning."""
        found: set[tuple[Any, ...]] = set()
        for path in sorted(self.folder.iterdir()):
            match = CHUNK.fullmatch(path.name)
            if match is None:
                continue
            if _payload(path) is None:
                warnings.warn(
                    f"{path} is damaged (its check sum is not that of its content): this chunk is computed again",
                    CheckpointWarning,
                    stacklevel=4,
                )
                continue
            start, stop, of = match.groups()
            found.add((int(start), int(stop)) if of is None else (int(start), int(stop), of))
        return found

    def load(self, cut: tuple[Any, ...]) -> bytes:
        """Content of a chunk that was stored."""
        payload = _payload(self._path(cut))
        if payload is None:
            raise FrameError(f"{self._path(cut)} was damaged while the run went on: start again, and it is done again")
        return payload

    def store(self, cut: tuple[Any, ...], content: Sequence[bytes | memoryview]) -> None:
        """Write the content of a chunk, given in pieces, all of it or nothing."""
        head = _check_sum(content) + b"\n"
        self._write(self._path(cut).name, [head, *content], "the chunks before it are whole: make room and start again")

    def _path(self, cut: tuple[Any, ...]) -> Path:
        start, stop, *of = cut
        return self.folder / f"chunk-{'-'.join([f'{start:012d}', f'{stop:012d}', *of])}.bin"

    def _write(self, name: str, content: Sequence[bytes | memoryview], remedy: str, *, new: bool = False) -> bool:
        """Write a file under a temporary name and rename it, so that a reader sees all of it or nothing.

        With `new`, an existing file is kept. Returns whether the file was written.
        """
        part = self.folder / f".{name}.{self._owner}.part"
        try:
            try:
                with part.open("wb") as file:
                    file.writelines(content)
                if new:
                    return _moved_to_new(part, self.folder / name)
                part.replace(self.folder / name)
                return True
            except BaseException:
                part.unlink(missing_ok=True)
                raise
        except OSError as error:
            if not self.is_there:
                raise FrameError(f"checkpoint {self.folder} is gone, and what was stored there: start again") from error
            raise FrameError(f"{self.folder / name} cannot be written: {error.strerror or error}; {remedy}") from error


def _moved_to_new(part: Path, path: Path) -> bool:
    """Rename a file, unless another process has made one of that name meanwhile; returns whether it was renamed."""
    try:
        os.link(part, path)
    except FileExistsError:
        part.unlink()
        return False
    except (OSError, NotImplementedError):  # a file has one name there
        part.replace(path)
        return True
    part.unlink()
    return True


def _payload(path: Path) -> bytes | None:
    """Content of a chunk's file; None if it is missing or damaged."""
    try:
        text, _, payload = path.read_bytes().partition(b"\n")
    except OSError:
        return None
    return payload if _check_sum([payload]) == text else None


def _check_sum(content: Sequence[bytes | memoryview]) -> bytes:
    """Length and cyclic redundancy check of a file's content.

    It detects damage by the disk, as in archives and images, in a third of the time of a cryptographic hash, which
    would be half the cost of storing a chunk.
    """
    length = total = 0
    for piece in content:
        length, total = length + len(piece), zlib.crc32(piece, total)
    return f"{length:012d} {total:08x}".encode()


def first_results(results: Array) -> dict[str, Any]:
    """Results of the first samples, by which a checkpoint recognises the function."""
    flat = results.reshape(len(results), -1)[:, :64]
    return {"shape": list(results.shape[1:]), "values": [[repr(float(x)) for x in row] for row in flat]}


def same_results(before: Mapping[str, Any], now: Mapping[str, Any]) -> bool:
    """Whether results of the first samples agree within rounding."""
    if before["shape"] != now["shape"]:
        return False
    a, b = (np.array(each["values"], dtype=object).astype(np.float64) for each in (before, now))
    greatest = np.abs(a[np.isfinite(a)]).max(initial=0.0)
    return bool(np.allclose(a, b, rtol=SAME, atol=NOTHING * greatest, equal_nan=True))
