"""Benchmark 10: what a batch entry more takes, by NumPy and as machine code, and how far their results are apart."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from time import perf_counter
from unittest.mock import patch

import numpy as np
from linkframe.elements import Beam, Material
from linkframe.framework import Frame
from linkframe.framework.program import machine_code
from numpy.typing import NDArray

from . import straight_c
from .harness import COLOURS, Row, Target, figure, least_each, main, write
from .job import BAR, job

Array = NDArray[np.float64]
# Describes a frame of so many samples; the node whose displacement is read, and the entries of a sample.
Case = tuple[Callable[[int], Frame], str, int]

POSES = 361
# Samples whose differences are told in units of their bounds: as few as machine code takes, since a bound takes as long
# as a thousand results.
BOUNDED = 100
NUMPY, COMPILED = "NumPy", "machine code"
# Microseconds that an entry more may take, by NumPy and as machine code.
WANTED = {
    "paper's job in plane": (0.07, 0.01),
    "paper's job in space": (0.36, 0.03),
    "modulus varying": (1.5, 0.3),
    "coordinates varying": (1.5, 0.3),
}


def run(out: Path, quick: bool) -> list[Target]:
    """The paper's job, and a chain of three members whose modulus, or coordinates, vary."""
    few, many = (100, 300) if quick else (500, 2000)
    rows = [row for name, case in cases().items() for row in compared(name, case, few, many, 3 if quick else 7)]
    write(out, "programs", rows)
    if COMPILED in backends():
        write(out, "programs_threads", threads(1000 if quick else 8000, 5 if quick else 15))
    draw(out, rows)
    beside = [row for row in rows if row["back end"] == COMPILED and np.isfinite(row["us_in_c"])]
    return [*(target(row) for row in rows), *(target_beside_c(row) for row in beside)]


def cases() -> dict[str, Case]:
    """What is solved."""
    rng = np.random.default_rng(0)

    def chain(samples: int, *, coordinates: bool) -> Frame:
        count = POSES * samples
        places = np.array([[0.0, 0.0, 0.0], [1.0, 0.3, 0.2], [2.0, 0.1, 0.9], [3.0, 0.5, 1.0]])[:, None, :]
        spread = 0.01 * rng.normal(size=(4, count, 3)) if coordinates else np.zeros((4, 1, 3))
        beam = Beam(BAR, Material(E=2e11 if coordinates else 2e11 * np.exp(0.1 * rng.normal(size=count)), nu=0.3))
        frame = Frame()
        for k in range(4):
            frame.node(f"n{k}", (places + spread)[k] if 0 < k < 3 else places[k, 0])
        for k in range(3):
            frame.add(f"m{k}", beam, f"n{k}", f"n{k + 1}")
        frame.fix("n0")
        frame.load("n3", fy=1.0)
        return frame

    def paper(samples: int, *, space: bool) -> Frame:
        return job(POSES, samples, space=space).frame()

    return {
        "paper's job in plane": (partial(paper, space=False), "P", POSES),
        "paper's job in space": (partial(paper, space=True), "P", POSES),
        "modulus varying": (partial(chain, coordinates=False), "n3", POSES),
        "coordinates varying": (partial(chain, coordinates=True), "n3", POSES),
    }


@contextmanager
def by(backend: str) -> Iterator[None]:
    """As if llvmlite were not installed, where NumPy is to do it."""
    if backend == COMPILED:
        yield
        return
    with patch.object(machine_code, "available", lambda: False):
        yield


def backends() -> tuple[str, ...]:
    """Those that are installed."""
    return (NUMPY, COMPILED) if machine_code.available() else (NUMPY,)


def solved(frame: Frame, node: str, backend: str) -> Array:
    """The displacement of a frame, solved as if for the first time."""
    with by(backend):
        found: Array = frame.copy().solve().displacement(node)
    return found


def bound(frame: Frame, node: str, backend: str) -> Array:
    """The bound on the error of that displacement."""
    with by(backend):
        found: Array = frame.copy().solve().error_bound(node)
    return found


def of_bounds(difference: Array, bounds: Array) -> float:
    """The greatest difference over its bound, in which none counts as 0 where the bound is 0."""
    off = difference != 0.0
    with np.errstate(divide="ignore"):
        return float((np.abs(difference[off]) / np.broadcast_to(bounds, difference.shape)[off]).max(initial=0.0))


def compared(name: str, case: Case, few: int, many: int, repeats: int) -> list[Row]:
    """A row for each back end."""
    make, node, poses = case
    frames = {count: make(count) for count in (few, many)}
    calls = {(b, n): partial(solved, frame, node, b) for b in backends() for n, frame in frames.items()}
    results = {backend: calls[backend, many]() for backend in backends()}
    bounded = make(BOUNDED)
    parts = {backend: solved(bounded, node, backend) for backend in backends()}
    bounds = {backend: bound(bounded, node, backend) for backend in backends()}
    seconds = least_each({f"{b} {n}": call for (b, n), call in calls.items()}, repeats)
    size = np.abs(results[NUMPY]).max(axis=-1, keepdims=True)
    alone = {NUMPY: (np.nan, np.nan), COMPILED: (np.nan, np.nan)}
    if COMPILED in backends() and straight_c.available():
        alone[COMPILED] = straight_c.seconds(calls[COMPILED, many], repeats)
    return [
        {
            "case": name,
            "back end": backend,
            "entries": poses * many,
            "us_per_entry": 1e6 * seconds[f"{backend} {many}"] / (poses * many),
            "us_an_entry_more": 1e6
            * (seconds[f"{backend} {many}"] - seconds[f"{backend} {few}"])
            / (poses * (many - few)),
            "us_of_steps": 1e6 * alone[backend][0] / (poses * many),
            "us_in_c": 1e6 * alone[backend][1] / (poses * many),
            "difference": float((np.abs(results[backend] - results[NUMPY]) / size).max()),
            "of bounds": of_bounds(parts[backend] - parts[NUMPY], bounds[backend] + bounds[NUMPY]),
        }
        for backend in backends()
    ]


def threads(samples: int, repeats: int) -> list[Row]:
    """Seconds that pass for the paper's job in space with one thread and two, on all processors that there are."""
    frame = job(POSES, samples, space=True).frame()
    held = os.sched_getaffinity(0) if hasattr(os, "sched_getaffinity") else None
    if held is not None:
        os.sched_setaffinity(0, range(os.cpu_count() or 1))
    try:
        calls = {str(count): partial(with_threads, frame, count) for count in (1, 2)}
        seconds = least_each(calls, repeats, perf_counter)
    finally:
        if held is not None:
            os.sched_setaffinity(0, held)
    return [{"threads": n, "seconds": s, "times_one": seconds["1"] / s} for n, s in seconds.items()]


def with_threads(frame: Frame, count: int) -> None:
    """Solve with so many threads."""
    with patch.dict(os.environ, OMP_NUM_THREADS=str(count)):
        solved(frame, "P", COMPILED)


def target(row: Row) -> Target:
    """An entry more, against what is wanted of this back end."""
    wanted = WANTED[row["case"]][row["back end"] == COMPILED]
    told = f"{row['us_an_entry_more']:.2g} us, {row['us_per_entry']:.2g} with all that comes before"
    bound = "a step of the program is one operation on the numbers of an entry, and its results are written to memory"
    if np.isfinite(row["us_in_c"]):
        bound += (
            f"; on this processor the steps alone take {row['us_of_steps']:.2g} us, and as a loop in C, by its "
            f"compiler, {row['us_in_c']:.2g} us"
        )
    name = f"{row['case']}, {row['back end']}: an entry more in {wanted} us"
    return Target("10 programs", name, told, row["us_an_entry_more"] <= wanted, bound)


def target_beside_c(row: Row) -> Target:
    """An entry more, against the same steps as a loop in C that was measured in the same run."""
    more, in_c = row["us_an_entry_more"], row["us_in_c"]
    told = f"{more:.2g} us, in C {in_c:.2g}: {more / in_c:.2f}"
    bound = "beyond the steps, their numbers are gathered and results handed out by chunks"
    name = f"{row['case']}: an entry more within twice the same steps as a loop in C"
    return Target("10 programs", name, told, more <= 2.0 * in_c, bound)


def draw(out: Path, rows: list[Row]) -> None:
    """Time of an entry more, by case."""
    names = list(dict.fromkeys(row["case"] for row in rows))
    taken: Mapping[str, list[float]] = {
        backend: [row["us_an_entry_more"] for row in rows if row["back end"] == backend] for backend in backends()
    }
    with figure(out, "programs", width=6.0) as (ax,):
        for k, (backend, values) in enumerate(taken.items()):
            ax.barh(np.arange(len(names)) + 0.4 * k, values, 0.36, color=COLOURS[k], label=backend)
        ax.set_yticks(np.arange(len(names)) + 0.2, names)
        ax.set(xscale="log", xlabel="processor time of an entry more / µs")
        ax.legend()


if __name__ == "__main__":
    main("programs", run)
