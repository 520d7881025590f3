"""What all benchmarks share: command line, clock, memory, tables, figures, and targets with what was measured."""

from __future__ import annotations

import argparse
import csv
import json
import os
import resource
import subprocess
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, nullcontext
from dataclasses import asdict, dataclass
from functools import cache
from importlib import import_module
from pathlib import Path
from statistics import median
from time import perf_counter, process_time
from typing import TYPE_CHECKING, Any
from unittest.mock import patch

import numpy as np

if TYPE_CHECKING:
    from linkframe.framework import Solution
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis

Row = Mapping[str, Any]

# Okabe & Ito's colours, which readers who do not see all colours tell apart.
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000", "#999999")
STYLE = {
    "font.size": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": "#e5e5e5",
    "grid.linewidth": 0.6,
    "axes.axisbelow": True,
    "legend.frameon": False,
    "lines.linewidth": 1.4,
    "lines.markersize": 4.5,
    "savefig.dpi": 200,
}


@dataclass(frozen=True)
class Target:
    """What was to be reached, what was measured in this run, and what bounds it where it was not reached."""

    benchmark: str
    target: str
    measured: str
    met: bool
    bound: str = ""


def main(name: str, run: Callable[[Path, bool], list[Target]], *, pinned: bool = True) -> None:
    """Command line of one benchmark: on one core if `pinned`, into ``--out``, with the targets in a file for run.py."""
    parser = argparse.ArgumentParser(description=run.__doc__)
    parser.add_argument("--out", type=Path, default=Path("benchmarks-results"), help="folder for CSV and PNG")
    parser.add_argument("--quick", action="store_true", help="small sizes, for a look")
    given = parser.parse_args()
    given.out.mkdir(parents=True, exist_ok=True)
    with one_core() if pinned else nullcontext():
        targets = run(given.out, given.quick)
    (given.out / f"{name}.targets.json").write_text(json.dumps([asdict(t) for t in targets]), encoding="utf-8")


@cache
def importable(module: str) -> bool:
    """Whether a peer is there; it is told of one that is not, or that fails as it is loaded, why it is left out."""
    try:
        # calfem puts a class of its own in place of NumPy's, with which SciPy cannot work
        with patch.object(np, "matrix", np.matrix):
            import_module(module)
    except Exception as error:  # such as that of a shared library that it does not find
        print(f"{module} is left out: {type(error).__name__}: {error}", flush=True)
        return False
    return True


# -- clock and memory -------------------------------------------------------------------------------------------------


# A call that takes longer than so many seconds is not repeated.
PATIENCE = 10.0


def least(call: Callable[[], object], repeats: int) -> float:
    """Seconds of the fastest of several calls, see `least_each`."""
    return least_each({"": call}, repeats)[""]


def least_each(
    calls: Mapping[str, Callable[[], object]],
    repeats: int,
    clock: Callable[[], float] = process_time,
    patience: float = PATIENCE,
) -> dict[str, float]:
    """Seconds of the fastest call of each, taken in turns; what takes longer than `patience` is called once.

    On one core, and without input and output, the processor's time is the time that passes on a quiet machine; on a
    busy one it does not favour short calls, which are more likely not to be interrupted.
    """
    seconds = dict.fromkeys(calls, float("inf"))
    for turn in range(repeats):
        for name, call in calls.items():
            if turn == 0 or seconds[name] < patience:
                start = clock()
                call()
                seconds[name] = min(seconds[name], clock() - start)
    return seconds


@contextmanager
def one_core() -> Iterator[None]:
    """Run on the last of the cores that are allowed, where the system can be told so."""
    if not hasattr(os, "sched_setaffinity"):
        yield
        return
    allowed = os.sched_getaffinity(0)
    os.sched_setaffinity(0, {max(allowed)})
    try:
        yield
    finally:
        os.sched_setaffinity(0, allowed)


def peak_memory() -> int:
    """Most bytes that this process has held. Not ru_maxrss on Linux: it begins at what the parent held."""
    status = Path("/proc/self/status")
    if status.exists():
        (line,) = (line for line in status.read_text(encoding="ascii").splitlines() if line.startswith("VmHWM"))
        return 1024 * int(line.split()[1])
    used = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return used if sys.platform == "darwin" else 1024 * used


def child(program: str, *arguments: str, limit: float | None = None) -> Any:
    """What a program, run in a process of its own, prints as JSON; it may import from benchmarks and reference.

    After `limit` seconds it is stopped, and TimeoutExpired raised.
    """
    command, path = [sys.executable, "-c", program, *arguments], str(Path(__file__).parents[1])
    environment = {**os.environ, "PYTHONPATH": path}
    done = subprocess.run(command, capture_output=True, text=True, check=True, env=environment, timeout=limit)
    return json.loads(done.stdout)


def wall(
    commands: Mapping[str, Sequence[str]], repeats: int, environment: Mapping[str, str] | None = None
) -> dict[str, float]:
    """Median seconds of each command, run in turns in processes of their own; the first turn is not counted."""
    spent: dict[str, list[float]] = {name: [] for name in commands}
    for turn in range(repeats + 1):
        for name, command in commands.items():
            start = perf_counter()
            subprocess.run(command, capture_output=True, check=True, env=environment)
            if turn:
                spent[name].append(perf_counter() - start)
    return {name: median(each) for name, each in spent.items()}


@cache
def rate() -> float:
    """Multiplications a second of NumPy on arrays that stay in the cache: what one core can do at best."""
    a, b, out = (np.full(2**13, 1.0 + k) for k in range(3))
    count = 50

    def work() -> None:
        for _ in range(count):
            np.multiply(a, b, out=out)

    return count * a.size / least(work, 200)


def operations(solution: Solution) -> int:
    """Operations of the factorisation over the whole batch, as the plan counts them."""
    plan = solution.plan
    return sum(order.operations(plan.grid) for name in plan.excited for order in plan.block(name).orders)


# -- tables and figures -----------------------------------------------------------------------------------------------


def write(out: Path, name: str, rows: Sequence[Row]) -> None:
    """Write rows to NAME.csv, and print them as a table."""
    with (out / f"{name}.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, list(rows[0]))
        writer.writeheader()
        writer.writerows({key: shown(value, 6) for key, value in row.items()} for row in rows)
    cells = [list(rows[0]), *([shown(value) for value in row.values()] for row in rows)]
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
    print(f"\n{name}")
    for line in cells:
        print("  " + "  ".join(cell.ljust(width) for cell, width in zip(line, widths, strict=True)).rstrip())


def shown(value: object, digits: int = 3) -> str:
    """A number with a few digits, anything else as it is."""
    return f"{value:.{digits}g}" if isinstance(value, float) else str(value)


@contextmanager
def figure(out: Path, name: str, columns: int = 1, width: float = 5.0, height: float = 3.6) -> Iterator[list[Axes]]:
    """Axes side by side, saved as NAME.png."""
    import matplotlib.pyplot as plt
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    with plt.rc_context(STYLE):
        drawn = plt.Figure(figsize=(width * columns, height), layout="constrained")
        FigureCanvasAgg(drawn)
        axes = list(np.atleast_1d(drawn.subplots(1, columns)))
        yield axes
        for ax in axes:
            _decades(ax.get_xlim, ax.set_xlim, ax.xaxis)
            _decades(ax.get_ylim, ax.set_ylim, ax.yaxis)
        drawn.savefig(out / f"{name}.png")


def _decades(limits: Callable[[], tuple[float, float]], limit: Callable[..., object], axis: Axis) -> None:
    """Number whole decades only on a logarithmic axis, two at least."""
    from matplotlib.ticker import FixedLocator, NullFormatter

    if axis.get_scale() != "log" or isinstance(axis.get_major_locator(), FixedLocator):
        return
    axis.set_minor_formatter(NullFormatter())
    low, high = np.log10(limits())
    if np.floor(high) - np.ceil(low) < 1:
        limit(10.0 ** np.floor(low), 10.0 ** np.ceil(high))


def slope(x: Sequence[float], y: Sequence[float]) -> float:
    """Exponent of the power law through points."""
    return float(np.polyfit(np.log(x), np.log(y), 1)[0])
