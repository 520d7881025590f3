"""Runs that are killed at random moments: the same bits, or this says which.

Runs on one worker are resumed from their checkpoints. On a cluster of dask on this machine, where it is installed, the
workers are killed, and the run goes on.
"""

from __future__ import annotations

import os
import random
import signal
import sys
import tempfile
import time
from contextlib import closing
from functools import partial
from pathlib import Path
from threading import Timer
from typing import Any

import numpy as np
from linkframe.models import propagate
from linkframe.models.propagation import run as propagation_run
from linkframe.models.propagation.ordered import StoredChunks
from linkframe.models.sampling import BLOCK
from scipy import stats

INPUTS = {"a": stats.norm(3.0, 2.0), "b": stats.uniform()}
CHUNKS = 16


def fn(a, b):
    """Two results; slow enough for a signal to come at any moment of a chunk."""
    time.sleep(0.004)
    return np.stack([a * b, np.where(a > 9.0, np.nan, a - b)], axis=-1)


def run(folder: Path | None, workers: Any = 1) -> tuple[bytes, int]:
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
        workers=workers,
        progress=False,
    )
    numbers = (found.mean, found.std_standard_error, *found.envelope, found.quantile([0.01, 0.9]), found.covariance)
    return b"".join(np.asarray(each).tobytes() for each in numbers), found.failures.count


def killed(folder: Path, after: float) -> int:
    """Start the run in another process and kill it after some seconds; how many chunks it left, several in a file."""
    child = os.fork()
    if child == 0:
        propagation_run.StoredChunks = partial(StoredChunks, pause=0.02)  # type: ignore[misc,assignment]
        run(folder)
        os._exit(0)
    time.sleep(after)
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)
    return stored(folder) if folder.is_dir() else 0


def stored(folder: Path) -> int:
    """How many chunks its files hold."""
    ranges = (path.stem.split("-")[1:] for path in folder.glob("chunk-*"))
    return sum(int(stop) - int(start) for start, stop in ranges) // (2 * BLOCK)


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
            if list(folder.glob(".*")) or stored(folder) != CHUNKS:
                raise AssertionError("a chunk is missing")
    return left


def cluster_kills(count: int, seed: int = 0) -> None:
    """Kill one of two workers of so many clusters, each while a run is on its way."""
    from distributed import Client, LocalCluster

    rng, wanted = random.Random(seed), run(None)
    for _ in range(count):
        with (
            closing(LocalCluster(2, threads_per_worker=1, dashboard_address=None, silence_logs=60)) as cluster,
            closing(Client(cluster)) as client,
        ):
            start = time.perf_counter()
            if run(None, client) != wanted:
                raise AssertionError("other bits on the cluster")
            seconds = time.perf_counter() - start
            victim = rng.choice(list(client.run(os.getpid).values()))
            timer = Timer(rng.uniform(0.0, seconds), os.kill, (victim, signal.SIGKILL))
            timer.start()
            found = run(None, client)
            timer.join()
            if found != wanted:
                raise AssertionError("other bits after a worker of the cluster was killed")


if __name__ == "__main__":
    import warnings

    warnings.simplefilter("ignore")
    many = int(sys.argv[1]) if len(sys.argv) > 1 else 20
    found = kills(many)
    print(f"{len(found)} runs killed with {min(found)} to {max(found)} of {CHUNKS} chunks stored: same bits")
    try:
        cluster_kills(many)
        print(f"{many} runs on two workers of a cluster, of which one was killed: same bits")
    except ImportError:
        print("dask is not installed: no worker of a cluster was killed")
