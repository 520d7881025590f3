"""Machine code kept on disk, so that the next process compiles nothing.

It lies in the folder for such things: ``LINKFRAME_CACHE`` where that is set, else ``linkframe`` in ``XDG_CACHE_HOME``,
or where the system has its caches. ``LINKFRAME_CACHE=off`` switches it off. A file is named by all that its content
depends on: the text that is compiled, the version of LLVM, and the processor with its features. It is written whole or
not at all, carries a checksum, and is compiled anew where that is not right. What others may write to is not taken up.
"""

from __future__ import annotations

import os
import sys
import tempfile
from collections.abc import Iterable
from contextlib import suppress
from hashlib import sha256
from pathlib import Path

VARIABLE = "LINKFRAME_CACHE"
# Files kept; of more, those that were not used for the longest time go.
MOST = 500
_HEAD = b"linkframe machine code 1\n"


def folder() -> Path | None:
    """Where it lies; None where it is switched off, or nobody knows where home is."""
    asked = os.environ.get(VARIABLE, "")
    if asked.lower() in ("off", "0", "no"):
        return None
    if asked:
        return Path(asked)
    try:
        return _caches() / "linkframe"
    except RuntimeError:
        return None


def _caches() -> Path:
    if os.environ.get("XDG_CACHE_HOME"):
        return Path(os.environ["XDG_CACHE_HOME"])
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA") or Path.home() / "AppData" / "Local")
    return Path.home() / ("Library/Caches" if sys.platform == "darwin" else ".cache")


def key(parts: Iterable[str]) -> str:
    """Name of what depends on these texts."""
    return sha256("\0".join(parts).encode()).hexdigest()


def read(name: str) -> bytes | None:
    """What is kept under a name; None where nothing is, or it is damaged, or others may have written it."""
    place = folder()
    if place is None:
        return None
    path = place / f"{name}.o"
    try:
        if not _own(place):
            return None
        whole = path.read_bytes()
        os.utime(path)
    except OSError:
        return None
    head, content = whole[: len(_HEAD) + 32], whole[len(_HEAD) + 32 :]
    return content if head == _HEAD + sha256(content).digest() else None


def write(name: str, content: bytes) -> None:
    """Keep it; where there is no room, or no right to, do without."""
    place = folder()
    if place is None:
        return
    with suppress(OSError):
        place.mkdir(mode=0o700, parents=True, exist_ok=True)
        if not _own(place):
            return
        handle, path = tempfile.mkstemp(dir=place, suffix=".new")
        try:
            with os.fdopen(handle, "wb") as file:
                file.write(_HEAD + sha256(content).digest() + content)
            os.replace(path, place / f"{name}.o")
        except OSError:
            os.unlink(path)
            return
        _forget(place)


def _own(place: Path) -> bool:
    """Whether a folder belongs to who asks, and nobody else may write to it."""
    if not hasattr(os, "getuid"):
        return True
    found = place.stat()
    return found.st_uid == os.getuid() and not found.st_mode & 0o022


def _forget(place: Path) -> None:
    """Leave the files that were used last."""
    files = list(place.glob("*.o"))
    if len(files) > MOST:
        for path in sorted(files, key=lambda each: each.stat().st_mtime)[: len(files) - MOST]:
            path.unlink(missing_ok=True)
