"""Benchmark 1b, all results of the paper's job beside the displacement of P alone, and what bounds them.

The steps of the programs are counted, a plain write of as many numbers is timed in new memory and in memory that has
been written to before, and both are done by one thread and by two. Two threads share the machine code alone; its share
of one thread's time bounds what they give.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from time import perf_counter, process_time
from unittest.mock import patch

import numpy as np
from linkframe.framework import AllResults, Frame
from linkframe.framework.program.calculation import Calculation
from linkframe.framework.program.machine_code import Kernel
from linkframe.framework.program.program import Operation
from numpy.typing import NDArray

from .harness import Row, Target, least_each, main, write
from .job import job

Array = NDArray[np.float64]
POSES = 361
# Operations that are two of arithmetic.
FUSED = {Operation.MULTIPLY_ADD, Operation.MULTIPLY_SUBTRACT, Operation.SUBTRACT_PRODUCT}
WANTED = 4.0


def run(out: Path, quick: bool) -> list[Target]:
    """All results against one, in the plane and in space."""
    samples, repeats = (100, 3) if quick else (1000, 9)
    rows = [compared(job(POSES, samples, space=space).frame(), repeats) for space in (False, True)]
    for row, name in zip(rows, ("in plane", "in space"), strict=True):
        row["case"] = name
    write(out, "all_results", rows)
    write(out, "all_results_threads", [each for space in (False, True) for each in threads(samples, repeats, space)])
    return [target(row) for row in rows]


def one(frame: Frame) -> Array:
    """The displacement of P, solved as if for the first time."""
    found: Array = frame.copy().solve().displacement("P")
    return found


def every(frame: Frame) -> tuple[NDArray[np.str_], AllResults]:
    """Status and all results, likewise."""
    solution = frame.copy().solve()
    return solution.status, solution.all_results()


def compared(frame: Frame, repeats: int) -> dict[str, object]:
    """Microseconds an entry, and what is done for an entry."""
    entries = int(np.prod(frame.shape))
    with counted() as counts:
        results = every(frame)[1]
    numbers = sum(int(each.reshape(-1, each.shape[-2] * each.shape[-1]).any(axis=0).sum()) for each in results)
    place = np.empty((numbers, entries))
    calls: dict[str, Callable[[], object]] = {
        "P": partial(one, frame),
        "all": partial(every, frame),
        "new": lambda: np.empty((numbers, entries)).fill(1.0),
        "again": lambda: place.fill(1.0),
    }
    spent = {name: 1e6 * s / entries for name, s in least_each(calls, repeats).items()}
    steps, operations, loads = counts[-1] if counts else (0, 0, 0)
    return {
        "case": "",
        "numbers": numbers,
        "us_P": spent["P"],
        "us_all": spent["all"],
        "times_P": spent["all"] / spent["P"],
        "us_write_new": spent["new"],
        "us_write_again": spent["again"],
        "steps": steps,
        "operations": operations,
        "numbers_read": loads,
    }


@contextmanager
def counted() -> Iterator[list[tuple[int, int, int]]]:
    """Of each program that is run as machine code: steps, operations of arithmetic, and numbers read, an entry."""
    found: list[tuple[int, int, int]] = []
    plain = Calculation.run

    def run(self: Calculation, *given: object, **named: object) -> None:
        program = self.program
        made = [program.steps[k] for k in program.made(program.widest)]
        twice = sum(step.operation in FUSED for step in made)
        read = {k for step in made for k in step.operands if k < program.first}
        found.append((len(made), len(made) + twice, len(read)))
        plain(self, *given, **named)  # type: ignore[arg-type]

    with patch.object(Calculation, "run", run):
        yield found


def threads(samples: int, repeats: int, space: bool) -> list[Row]:
    """Seconds that pass with one thread and two: P alone, all results, and a plain write of new memory."""
    frame = job(POSES, samples, space=space).frame()
    size = 64 * POSES * samples

    def written(count: int) -> None:
        parts = np.split(np.empty(size), count)
        with ThreadPoolExecutor(count) as pool:
            list(pool.map(lambda part: np.add(part, 1.0, out=part), parts))

    def threaded(call: Callable[[Frame], object], count: int) -> None:
        with patch.dict(os.environ, OMP_NUM_THREADS=str(count)):
            call(frame)

    work: dict[str, Callable[[int], None]] = {
        "P": partial(threaded, one),
        "all results": partial(threaded, every),
        "64 numbers written": written,
    }
    calls = {f"{name}, {count}": partial(call, count) for name, call in work.items() for count in (1, 2)}
    held = os.sched_getaffinity(0) if hasattr(os, "sched_getaffinity") else None
    if held is not None:
        os.sched_setaffinity(0, range(os.cpu_count() or 1))
    try:
        seconds = least_each(calls, repeats, perf_counter)
    finally:
        if held is not None:
            os.sched_setaffinity(0, held)
    case = "in space" if space else "in plane"
    shares = {"P": machine_code_share(one, frame), "all results": machine_code_share(every, frame)}
    return [
        {"case": case, "work": name, "seconds": seconds[f"{name}, 1"], "two": seconds[f"{name}, 2"]}
        | {"times_one": seconds[f"{name}, 1"] / seconds[f"{name}, 2"]}
        | {"machine_code": shares.get(name, 1.0), "at_most": 1.0 / (1.0 - 0.5 * shares.get(name, 1.0))}
        for name in work
    ]


def machine_code_share(call: Callable[[Frame], object], frame: Frame) -> float:
    """Share of the time of a call by one thread that is machine code, the least of three calls."""
    plain, spent = Kernel.run, [0.0]

    def run(self: Kernel, *given: object, **named: object) -> None:
        start = process_time()
        plain(self, *given, **named)  # type: ignore[arg-type]
        spent[0] += process_time() - start

    shares = []
    with patch.object(Kernel, "run", run), patch.dict(os.environ, OMP_NUM_THREADS="1"):
        for _ in range(3):
            spent[0], start = 0.0, process_time()
            call(frame)
            shares.append(spent[0] / (process_time() - start))
    return min(shares)


def target(row: dict[str, object]) -> Target:
    """All results against one, with what bounds them."""
    case, times = row["case"], row["times_P"]
    told = f"{times:.1f} times: {row['us_all']:.2g} us, P alone {row['us_P']:.2g} us"
    bound = (
        f"{row['numbers']} numbers take {row['us_write_new']:.2g} us to be written to new memory "
        f"({row['us_write_again']:.2g} where it has been written to); there are {row['operations']} operations of "
        f"arithmetic on {row['numbers_read']} numbers, and what is written down beforehand, once for all samples"
    )
    name = f"paper's job {case}: status and all results within {WANTED:.0f} times P alone"
    return Target("1b all results", name, told, float(str(times)) <= WANTED, bound)


if __name__ == "__main__":
    main("all_results", run)
