"""Benchmark 7, start-up: import, first solution and command line, each in a process of its own.

What is measured is what a user waits for: an installed package, whose compiled files Python has written in the first
turn, which is not counted, and all cores, as a job uses two. If ``PYTHONDONTWRITEBYTECODE`` is set, as it often is in
containers and for tests, each start compiles all source anew, which takes longer than the job itself does; so the
compiled files are written to a temporary folder whatever the environment says.
"""

from __future__ import annotations

import os
import subprocess
import sys
from collections import defaultdict
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

from .harness import COLOURS, Row, Target, figure, importable, main, wall, write

FIRST = """
from linkframe.elements import Beam, Material, Section
from linkframe.framework import Frame
frame = Frame()
frame.node("A", (0.0, 0.0, 0.0))
frame.node("B", (2.0, 0.0, 0.0))
frame.add("AB", Beam(Section(A=1e-3, Iy=1e-6, Iz=1e-6, J=2e-6), Material(E=200e9, nu=0.3)), "A", "B")
frame.fix("A")
frame.load("B", fy=600.0)
print(abs(frame.solve().displacement("B")[1] / 8e-3 - 1.0))
"""
COMMAND = "from linkframe.models.command_line import main; main()"
SKFEM, OURS = "import skfem", "import linkframe.framework"
IMPORTS = ("numpy", "scipy.sparse.linalg", "skfem", "linkframe.framework", "linkframe.elements", "linkframe.models")
# Jobs, start of Python included, and seconds that each may take.
JOBS = {"linkframe four-bar": 4.0, "linkframe four-bar --figures none": 1.5}
BOUND = (
    "some 400 linearisations of one to three samples that pass the line of coupler and rocker, 1.3 ms each, and eigh of"
    " the 300 at singular poses; imports of NumPy and SciPy; bounds of 3700 samples"
)
PEERS = ("openseespy.opensees", "Pynite", "calfem.core")


def run(out: Path, quick: bool) -> list[Target]:
    """Medians over processes that take turns."""
    with compiled() as environment:
        rows = measure(3 if quick else 5, 1 if quick else 3, environment)
        write(out, "start_up", rows)
        write(out, "start_up_imports", imports(environment))
    draw(out, rows)
    seconds = {row["what"]: row["seconds"] for row in rows}
    ratio = seconds[OURS] / seconds[SKFEM]
    told = f"{ratio:.2f} times ({1e3 * seconds[OURS]:.0f} against {1e3 * seconds[SKFEM]:.0f} ms)"
    found = [Target("7 start-up", "import linkframe.framework within 1.2 times import skfem", told, ratio <= 1.2)]
    for what, most in JOBS.items():
        told = f"{seconds[what]:.2f} s"
        found.append(Target("7 start-up", f"{what}: at most {most:g} s", told, seconds[what] <= most, BOUND))
    return found


@contextmanager
def compiled() -> Iterator[dict[str, str]]:
    """Environment in which Python writes and reads compiled files, in a temporary folder."""
    with TemporaryDirectory() as folder:
        kept = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
        yield kept | {"PYTHONPYCACHEPREFIX": folder}


def measure(repeats: int, jobs: int, environment: Mapping[str, str]) -> list[Row]:
    """A row for each start; the first solution tells its error against F L^3/3EI."""
    installed = [name for name in PEERS if importable(name)]
    programs = {"python alone": "pass"} | {f"import {name}": f"import {name}" for name in (*IMPORTS, *installed)}
    programs["first solution"] = FIRST
    commands = {name: [sys.executable, "-c", program] for name, program in programs.items()}
    commands["linkframe --help"] = [sys.executable, "-c", COMMAND, "--help"]
    seconds = wall(commands, repeats, environment)
    with TemporaryDirectory() as folder:
        whole = {name: [sys.executable, "-c", COMMAND, *name.split()[1:], "--out", folder] for name in JOBS}
        seconds |= wall(whole, jobs, environment)
    printed = subprocess.run(commands["first solution"], capture_output=True, text=True, check=True).stdout
    errors = dict.fromkeys(seconds, "") | {"first solution": float(printed)}
    return [{"what": name, "seconds": spent, "error": errors[name]} for name, spent in seconds.items()]


def imports(environment: Mapping[str, str]) -> list[Row]:
    """By package: modules that ``import linkframe.framework`` loads, and their own time, from ``-X importtime``."""
    command = [sys.executable, "-X", "importtime", "-c", OURS]
    told = subprocess.run(command, capture_output=True, text=True, check=True, env=environment).stderr
    lines = told.splitlines()
    spent: dict[str, list[float]] = defaultdict(list)
    for line in lines[1:]:
        own, _, name = line.removeprefix("import time:").split("|")
        spent[name.strip().split(".")[0]].append(1e-3 * float(own))
    largest = sorted(spent, key=lambda package: -sum(spent[package]))[:10]
    return [{"package": p, "modules": len(spent[p]), "milliseconds": float(sum(spent[p]))} for p in largest]


def draw(out: Path, rows: list[Row]) -> None:
    """Bars."""
    shown = [row for row in rows if row["what"] not in JOBS][::-1]
    with figure(out, "start_up", width=5.0, height=0.5 + 0.28 * len(shown)) as (ax,):
        ours = ["linkframe" in row["what"] or row["what"] == "first solution" for row in shown]
        colours = [COLOURS[0] if own else "#bbbbbb" for own in ours]
        bars = ax.barh([row["what"] for row in shown], [1e3 * row["seconds"] for row in shown], color=colours)
        ax.bar_label(bars, fmt="%.0f", padding=2, fontsize=7)
        ax.set(xlabel="median time of the whole process / ms")
        ax.grid(visible=False, axis="y")


if __name__ == "__main__":
    main("start_up", run, pinned=False)
