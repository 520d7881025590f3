"""Benchmark 2: time and peak memory against the number of samples, a process for each number."""

from __future__ import annotations

import json
from pathlib import Path
from time import process_time

import numpy as np
from linkframe.models import propagate

from .harness import COLOURS, Row, Target, child, figure, main, peak_memory, slope, write
from .monte_carlo import INPUTS, displacement, mean

PROGRAM = "import sys; from benchmarks.samples import one; one(int(sys.argv[1]), sys.argv[2] == 'kept')"
KEPT, FORGOTTEN = "kept", "statistics only"


def run(out: Path, quick: bool) -> list[Target]:
    """Monte Carlo of the four-bar at one pose with five uncertain inputs, from 100 samples to 10 million."""
    decades = range(2, 6 if quick else 8)
    most = {FORGOTTEN: 8, KEPT: 7}
    rows = [
        {"samples": 10**d, "memory": how} | child(PROGRAM, str(10**d), how)
        for how in most
        for d in decades
        if d < most[how]
    ]
    write(out, "samples", rows)
    draw(out, rows)
    return targets([row for row in rows if row["memory"] == FORGOTTEN])


def one(n: int, keep: bool) -> None:
    """Print what n samples take, as JSON."""
    propagate(displacement, INPUTS, n=1024, rng=1, keep_samples=keep, progress=False)
    start = process_time()
    result = propagate(displacement, INPUTS, n=n, rng=0, keep_samples=keep, progress=False)
    seconds = process_time() - start
    print(
        json.dumps(
            {
                "seconds": seconds,
                "us_per_sample": 1e6 * seconds / n,
                "peak_MB": peak_memory() / 1e6,
                "error_of_mean": float(np.abs(result.mean / mean() - 1.0).max()),
                "standard_error": float(np.abs(result.standard_error / mean()).max()),
            }
        )
    )


def targets(rows: list[Row]) -> list[Target]:
    """Flat memory and linear time, from ten thousand samples on."""
    large = [row for row in rows if row["samples"] >= 10_000]
    growth = max(r["peak_MB"] for r in large) / large[0]["peak_MB"]
    # What a plan costs is shared by 16 384 samples, and by less where there are fewer.
    full = [row for row in rows if row["samples"] > 16_384] if len(large) > 2 else large
    power = slope([row["samples"] for row in full], [row["seconds"] for row in full])
    span = f"from 10^4 to 10^{len(str(large[-1]['samples'])) - 1} samples"
    told = f"time ~ samples^{power:.2f}, {full[0]['us_per_sample']:.2f} to {full[-1]['us_per_sample']:.2f} us a sample"
    return [
        Target("2 samples", "memory flat with statistics only", f"grows {growth:.2f} times {span}", growth <= 1.1),
        Target("2 samples", "time linear", told, power <= 1.05),
    ]


def draw(out: Path, rows: list[Row]) -> None:
    """Time, memory and error over the number of samples."""
    curves = {how: [row for row in rows if row["memory"] == how] for how in (FORGOTTEN, KEPT)}
    with figure(out, "samples", columns=3, width=3.4, height=3.0) as axes:
        for colour, (how, found) in zip(COLOURS, curves.items(), strict=False):
            n = [row["samples"] for row in found]
            axes[0].plot(n, [row["seconds"] for row in found], "o-", color=colour, label=how)
            axes[1].plot(n, [row["peak_MB"] for row in found], "o-", color=colour, label=how)
        n = [row["samples"] for row in curves[FORGOTTEN]]
        axes[2].plot(n, [r["error_of_mean"] for r in curves[FORGOTTEN]], "o-", color=COLOURS[0], label="measured")
        axes[2].plot(n, [r["standard_error"] for r in curves[FORGOTTEN]], "--", color="#555555", label="standard error")
        for ax, what in zip(axes, ("time / s", "peak memory / MB", "relative error of the mean"), strict=True):
            ax.set(xscale="log", yscale="log", xlabel="samples", ylabel=what)
            ax.legend()
        axes[1].set(yscale="linear", ylim=(0, 1.1 * max(row["peak_MB"] for found in curves.values() for row in found)))


if __name__ == "__main__":
    main("samples", run)
