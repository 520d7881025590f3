"""Benchmark 3: time a (pose, sample) against the number of segments of each link, which are condensed once."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from .harness import COLOURS, Row, Target, figure, least_each, main, write
from .job import Job, error, job

Array = NDArray[np.float64]
CHECKED = 3


def run(out: Path, quick: bool) -> list[Target]:
    """Links of 1 to 64 segments, 361 poses x 1000 samples."""
    rows = measure(job(361, 100 if quick else 1000, space=False), [1, 2, 4, 8, 16, 32, 64], 3 if quick else 7)
    write(out, "segments", rows)
    draw(out, rows)
    most = max(row["times_one_segment"] for row in rows)
    cost = 1e3 * (rows[-1]["seconds"] - rows[0]["seconds"])
    bound = f"plan and condensation of 64 segments a link: {cost:.0f} ms in all, however many samples share it"
    told = f"at most {most:.2f} times ({rows[0]['entries']} entries)"
    return [Target("3 segments", "at most 1.2 times from 1 to 64 segments", told, most <= 1.2, bound)]


def measure(work: Job, counts: list[int], repeats: int) -> list[Row]:
    """A row for each number of segments."""
    poses = [0, work.shape[0] // 3, work.shape[0] // 2 + 1]
    exact = np.array([[work.truth(pose, sample) for sample in range(CHECKED)] for pose in poses])
    results: dict[str, Array] = {}

    def solve(name: str, segments: int) -> None:
        results[name] = work.frame(segments).solve().displacement("P")

    seconds = least_each({str(n): partial(solve, str(n), n) for n in counts}, repeats)
    one = seconds[str(counts[0])]
    return [
        {
            "segments": n,
            "entries": work.size,
            "seconds": seconds[str(n)],
            "us_per_entry": 1e6 * seconds[str(n)] / work.size,
            "times_one_segment": seconds[str(n)] / one,
            "worst_error": float(error(results[str(n)][poses, :CHECKED], exact).max()),
        }
        for n in counts
    ]


def draw(out: Path, rows: list[Row]) -> None:
    """Time and error over segments."""
    n = [row["segments"] for row in rows]
    with figure(out, "segments", columns=2, width=3.6, height=3.0) as (left, right):
        left.plot(n, [row["us_per_entry"] for row in rows], "o-", color=COLOURS[0], label="measured")
        left.axhline(1.2 * rows[0]["us_per_entry"], ls="--", color="#555555", label="1.2 times one segment")
        left.set(ylabel="time per (pose, sample) / µs", ylim=(0, None))
        right.plot(n, [row["worst_error"] for row in rows], "o-", color=COLOURS[0])
        right.set(ylabel="worst relative error against 50 digits", yscale="log", ylim=(1e-16, 1e-10))
        left.legend()
        for ax in (left, right):
            ax.set(xlabel="segments per link", xscale="log", xticks=n, xticklabels=n)
            ax.minorticks_off()


if __name__ == "__main__":
    main("segments", run)
