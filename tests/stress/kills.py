"""Runs that are killed at random moments, each resumed from its checkpoint: the same bits, or this says which."""

from __future__ import annotations

import os
import random
import signal
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from linkframe.models import propagate
from linkframe.models.sampling import BLOCK
from scipy import stats

INPUTS = {"a": stats.norm(3.0, 2.0), "b": stats.uniform()}
CHUNKS = 16


def fn(a, b):
    """Two results; slow enough for a signal to come at any moment of a chunk."""
    time.sleep(0.004)
    return np.stack([a * b, np.where(a > 9.0, np.nan, a - b)], axis=-1)


def run(folder: Path | None) -> tuple[bytes, int]:
    """Bits of the statistics, and how many samples failed."""
    found = propagate(
        fn,
        INPUTS,
        n=2 * CHUNKS * BLOCK,
        rng=5,
        sampler="sobol",
        chunk=2 * BLOCK,
        keep_samples=False,
        also=("histogram", "covariance"),
        checkpoint=folder,
        progress=False,
    )
    numbers = (found.mean, found.std_standard_error, *found.envelope, found.quantile([0.01, 0.9]), found.covariance)
    return b"".join(np.asarray(each).tobytes() for each in numbers), found.failures.count


def killed(folder: Path, after: float) -> int:
    """Start the run in another process and kill it after some seconds; how many chunks it left."""
    child = os.fork()
    if child == 0:
        run(folder)
        os._exit(0)
    time.sleep(after)
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)
    return len(list(folder.glob("chunk-*"))) if folder.is_dir() else 0


def kills(count: int, seed: int = 0) -> list[int]:
    """Kill and resume so many runs; how many chunks each had left."""
    rng = random.Random(seed)
    start = time.perf_counter()
    wanted = run(None)
    seconds = 0.9 * (time.perf_counter() - start)
    left = []
    for _ in range(count):
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name) / "run"
            left.append(killed(folder, rng.uniform(0.0, seconds)))
            if run(folder) != wanted:
                raise AssertionError(
                    f"other bits after a run that was killed with {left[-1]} of {CHUNKS} chunks stored"
                )
            if list(folder.glob(".*")) and len(list(folder.glob("chunk-*"))) != CHUNKS:
                raise AssertionError("a chunk is missing")
    return left


if __name__ == "__main__":
    import warnings

    warnings.simplefilter("ignore")
    found = kills(int(sys.argv[1]) if len(sys.argv) > 1 else 20)
    print(f"{len(found)} runs killed with {min(found)} to {max(found)} of {CHUNKS} chunks stored: same bits")
