"""Names by which a process marks its unfinished files, so that others can tell which an ended process left."""

from __future__ import annotations

import os
import platform
import re
from contextlib import suppress
from hashlib import sha256
from pathlib import Path

# The machine, the process on it, and when that began.
NAME = re.compile(r"([0-9a-f]{12})-(\d+)-(\d+)")
# Fields of /proc/PID/stat behind the name of the program: the state, and the moment of the start.
STATE, START = 0, 19
# States of a process that has ended and that nobody has asked for yet.
ENDED = ("Z", "X", "x")


def owner() -> str:
    """Name of this process, which no other has: ``machine-process-start``."""
    stat = _stat(os.getpid())
    return f"{_machine()}-{os.getpid()}-{stat[START] if stat else 0}"


def is_gone(name: str) -> bool:
    """Whether the process of that name has ended for certain.

    For a process on another machine, or if the system has no information, that is not certain.

    Parameters
    ----------
    name
        As `owner` gave it.
    """
    match = NAME.fullmatch(name)
    if match is None or os.name != "posix" or match[1] != _machine():
        return False
    process, start = int(match[2]), match[3]
    try:
        os.kill(process, 0)  # asks whether it is there
    except (ProcessLookupError, OverflowError):
        return True
    except OSError:
        pass  # it is there, and somebody else's
    stat = _stat(process)
    if stat is None:
        return False
    # The number of an ended process is given to a later one.
    return stat[STATE] in ENDED or start not in ("0", stat[START])


def _machine() -> str:
    """Identifier of this machine, and this container on it, among those that share its disks."""
    told = [platform.node()]
    with suppress(OSError):
        told.append(Path("/etc/machine-id").read_text(encoding="ascii"))
    with suppress(OSError):
        told.append(os.readlink("/proc/self/ns/pid"))
    return sha256("\n".join(told).encode()).hexdigest()[:12]


def _stat(process: int) -> list[str] | None:
    """Fields of ``/proc/PID/stat`` of a process; None if there are none."""
    try:
        text = Path(f"/proc/{process}/stat").read_text(encoding="utf-8", errors="replace")
    except OSError:
        return None
    fields = text.rpartition(")")[2].split()
    return fields if len(fields) > START else None
