"""Jobs that are killed at random moments, each resumed from its checkpoint: the same files, or this says which not."""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

EXAMPLE = Path(__file__).parents[2] / "examples" / "four_bar.toml"
# Before a job that is to hear an interrupt even where the tests do not, as in the background of a shell.
HEARING = "import signal; signal.signal(signal.SIGINT, signal.default_int_handler); "
# With parts that take a moment each.
COMMAND = f"""
{HEARING}
import sys
from linkframe.models.command_line import main
from linkframe.models.job import parts
if __name__ == "__main__":
    parts.ENTRIES = 24
    sys.exit(main(sys.argv[1:]))
"""
JOBS = (
    ["four-bar", "--poses", "30", "60", "30", "--samples", "150"],
    ["run", str(EXAMPLE), "--tolerance", "fy=± 5 %"],
)


def started(job: list[str], out: Path, *words: str) -> subprocess.Popen[bytes]:
    """The job in a process of its own."""
    command = [sys.executable, "-c", COMMAND, *job, "--figures", "none", "--out", str(out), *words]
    return subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)


def results(job: list[str], out: Path, *words: str) -> dict[str, bytes]:
    """Files of the job by name; the report, which has times, is left out."""
    with started(job, out, *words) as running:
        _, told = running.communicate()
    if running.returncode:
        raise AssertionError(told.decode())
    found = [path for path in out.rglob("*") if path.is_file() and path.name != "report.md"]
    return {str(path.relative_to(out)): path.read_bytes() for path in found}


def killed_jobs(count: int, seed: int = 0) -> list[int]:
    """Kill and resume so many jobs on two processes; how many parts each had left."""
    rng = random.Random(seed)
    left = []
    with tempfile.TemporaryDirectory() as name:
        place = Path(name)
        start = time.perf_counter()
        wanted = [results(job, place / f"wanted {index}") for index, job in enumerate(JOBS[:count])]
        seconds = (time.perf_counter() - start) / len(wanted)
        for turn in range(count):
            index = turn % len(JOBS)
            job, kept = JOBS[index], place / f"kept {turn}"
            words = ["--checkpoint", str(kept), "--workers", "2"]
            with started(job, place / "out", *words) as running:
                time.sleep(rng.uniform(0.2, 1.0) * seconds)
                os.kill(running.pid, signal.SIGKILL)
            left.append(len(list(kept.glob("chunk-*"))))
            words = [*words, *(["--resume"] if (kept / "run.json").exists() else [])]
            found = results(job, place / f"found {turn}", *words)
            if found != wanted[index]:
                others = [name for name in wanted[index] if found.get(name) != wanted[index][name]]
                raise AssertionError(f"other bytes in {others} after a job was killed with {left[-1]} parts stored")
    return left


if __name__ == "__main__":
    found = killed_jobs(int(sys.argv[1]) if len(sys.argv) > 1 else 20)
    print(f"{len(found)} jobs killed with {min(found)} to {max(found)} parts stored: same files")
