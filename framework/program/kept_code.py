"""Machine code cached on disk, so that the next process need not compile it.

The folder is ``LINKFRAME_CACHE`` if that is set, else ``linkframe`` in ``XDG_CACHE_HOME`` or in the system's folder for
caches; ``LINKFRAME_CACHE=off`` switches the cache off. The name of a file is a hash of all that its content depends on:
the LLVM code, the versions of llvmlite and LLVM, and the processor with its features. A file is written completely or
not at all, has a checksum, and is compiled anew if that is wrong. Files that other users may write are not read.
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
# Number of files that are kept; beyond it the least recently used are deleted.
MOST = 500
_HEAD = b"linkframe machine code 1\n"


def folder() -> Path | None:
    """Folder of the cache; None if it is switched off, or there is no home folder."""
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
    """Name of a file, a hash of the texts on which its content depends."""
    return sha256("\0".join(parts).encode()).hexdigest()


def read(name: str) -> bytes | None:
    """Content of the cached file of a name; None if there is none, it is damaged, or other users may write it."""
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
    """Write a file into the cache; do nothing if there is no space or permission."""
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
    """Whether a folder belongs to the current user and nobody else may write to it."""
    if not hasattr(os, "getuid"):
        return True
    found = place.stat()
    return found.st_uid == os.getuid() and not found.st_mode & 0o022


def _forget(place: Path) -> None:
    """Delete all but the most recently used files."""
    files = list(place.glob("*.o"))
    if len(files) > MOST:
        for path in sorted(files, key=lambda each: each.stat().st_mtime)[: len(files) - MOST]:
            path.unlink(missing_ok=True)
