"""Check that the numbers of a job fit the memory, before it starts."""

from __future__ import annotations

import os
from contextlib import suppress
from pathlib import Path

from ...framework.errors import FrameError

# Share of the free memory that a job may take.
MOST = 0.9


def available() -> int | None:
    """Bytes of memory that are free for this process; None if the system does not tell."""
    found = []
    with suppress(OSError, ValueError, StopIteration):
        lines = Path("/proc/meminfo").read_text(encoding="ascii").splitlines()
        found.append(1024 * next(int(line.split()[1]) for line in lines if line.startswith("MemAvailable")))
    with suppress(OSError, ValueError):
        group = Path("/sys/fs/cgroup")
        most, taken = ((group / name).read_text(encoding="ascii") for name in ("memory.max", "memory.current"))
        found.append(max(int(most) - int(taken), 0))
    if not found:
        with suppress(OSError, ValueError, AttributeError):
            found.append(os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE"))
    return min(found, default=None)


def check(bytes_each: int, count: int, what: str) -> None:
    """Refuse a number of items that do not fit the free memory.

    Parameters
    ----------
    bytes_each
        Memory of each item, bytes.
    count
        Number of items.
    what
        Name of their number, such as ``"--samples"``.

    Raises
    ------
    FrameError
        If they do not fit; the message tells the bytes, and how many items would fit.
    """
    free = available()
    if free is not None and bytes_each * count > MOST * free:
        raise FrameError(
            f"{what} {count} takes {bytes_each * count} bytes of memory, and {free} are free: "
            f"give at most {int(MOST * free) // bytes_each}"
        )
