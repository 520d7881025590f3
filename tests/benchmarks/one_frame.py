"""Benchmark 11: one small frame, the paper's four-bar at one pose and one sample, described, solved and read.

The first of its topology, later ones, each another `Frame`, and one that is changed in place, as an optimiser or a
controller does in its loop: its load, a joint, two lengths. Beside it stand others that build their model and solve it
once. What is changed in place is measured in a loop of its own, and once more in turn with all others, which leave
little of it in the processor's cache.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np
from linkframe.elements import Beam, Joint, Section
from linkframe.framework import Frame
from linkframe.framework.cache import KERNELS, ORDERS, PROGRAMS
from linkframe.models import Linkage
from numpy.typing import NDArray
from reference.four_bar import ENDS, JOINTS, LENGTH
from reference.structure import LOADS

from .harness import Row, Target, importable, least_each, main, write
from .job import BAR, NODES, STEEL, Job, error, job

Array = NDArray[Any]
# What solves for the next of some jobs, by its number.
Solve = Callable[[int], Array]

FIRST, LATER = "first of its topology", "later, another Frame"
LENGTHS, STIFFNESS, LOAD = "lengths changed in place", "stiffness changed in place", "load changed in place"
SECTION = "section changed in place"
IN_PLACE = (LENGTHS, STIFFNESS, SECTION, LOAD)
MOVED = "moved, framed, loaded"
OPENSEES, PYNITE = "openseespy, rebuilt", "PyNite, built"
# Milliseconds that each may take; and how many times what others take.
LIMITS = {FIRST: 2.5, LATER: 1.0, LENGTHS: 0.25, STIFFNESS: 0.25, SECTION: 0.25, LOAD: 0.08}
RATIOS = {OPENSEES: 5.0, PYNITE: 1.0}
# Jobs in turn, so that no two in a row have the same numbers; and solutions after which a topology is known well.
TURNS, MANY = 16, 1200
ERROR = 1e-12
SPRINGS = (2e11, 2e11, 2e11, 2e11, 2e11, 0.0)


@dataclass(frozen=True)
class Way:
    """How a job is solved, and how the same numbers are found otherwise."""

    solve: Solve
    truth: Solve


def run(out: Path, quick: bool) -> list[Target]:
    """Milliseconds of each way, and the error of what was read."""
    rows = measure(100 if quick else 400)
    write(out, "one_frame", rows)
    return targets(rows)


def measure(repeats: int, many: int = MANY) -> list[Row]:
    """The fastest of so many of each, taken in turns."""
    jobs = [part(k) for k in range(TURNS)]
    ways = ours(jobs) | peers(jobs)
    errors = {name: max(float(error(way.solve(k), way.truth(k))) for k in range(3)) for name, way in ways.items()}
    calls = {name: turns(way.solve) for name, way in ways.items()}
    # It drops what is known of topologies, which all others are to find.
    seconds = least_each({FIRST: calls.pop(FIRST)}, max(repeats // 10, 3))
    for name, call in calls.items():
        for _ in range(many if name != PYNITE else 1):
            call()
    seconds |= least_each(calls, repeats)
    looped = [name for name in IN_PLACE if name in ways]
    rows = [{"what": among(name), "ms": 1e3 * seconds[name], "error": errors[name]} for name in looped]
    for name in looped:
        seconds |= least_each({name: calls[name]}, repeats)
    return [{"what": name, "ms": 1e3 * seconds[name], "error": errors[name]} for name in ways] + rows


def among(name: str) -> str:
    """Name of a way that is measured in turn with the others."""
    return f"{name}, in turn with others"


def turns(solve: Solve) -> Callable[[], Array]:
    """The jobs one after the other."""
    numbers = count()
    return lambda: solve(next(numbers) % TURNS)


def part(number: int) -> Job:
    """One pose and one sample, each of another crank angle, stiffness, clearance and load."""
    # of the half turn before the pose in line, past which a linkage takes another way
    return job(2 * TURNS + 4, 1, space=False, seed=number).part([number + 1], 1)


def ours(jobs: list[Job]) -> dict[str, Way]:
    """linkframe, described by hand, changed in place, and by way of a motion."""

    def exact(k: int) -> Array:
        return jobs[k].truth(0, 0).astype(float)

    frame, joint = described(jobs[0]), next(iter(JOINTS))
    # what the loop that changes a frame works out itself is no part of its solution
    places = [one.coordinates()["P"][0] for one in jobs]
    springs = [one.stiffness[joint][0] for one in jobs]
    loads = [load_of(one) for one in jobs]
    beams = [Beam(Section(A=BAR.A, Iy=BAR.Iy, Iz=(1.0 + 0.01 * k) * BAR.Iz, J=BAR.J), STEEL) for k in range(len(jobs))]

    def changed(change: Callable[[int], None]) -> Way:
        def solve(k: int) -> Array:
            change(k)
            return frame.solve().displacement("P")

        return Way(solve, lambda k: anew(frame))

    bar = linkage()
    return {
        FIRST: Way(lambda k: anew(described(jobs[k])), exact),
        LATER: Way(lambda k: described(jobs[k]).solve().displacement("P"), exact),
        LENGTHS: changed(lambda k: frame.change("P", places[k])),
        STIFFNESS: changed(lambda k: frame.change(joint, Joint(springs[k]))),
        SECTION: changed(lambda k: frame.change(next(iter(ENDS)), beams[k])),
        LOAD: changed(lambda k: frame.set_load("P", **loads[k])),
        MOVED: Way(lambda k: moved(bar, jobs[k]), lambda k: alike(jobs[k]).truth(0, 0).astype(float)),
    }


def described(one: Job) -> Frame:
    """The frame by hand."""
    beam, frame = Beam(BAR, STEEL), Frame()
    places = one.coordinates()
    for node in NODES:
        frame.node(node, places[node][0])
    for name, ends in ENDS.items():
        frame.add(name, beam, *ends)
    for name, ends in JOINTS.items():
        frame.add(name, Joint(one.stiffness[name][0]), *ends)
        frame.offset(name, ux=one.offset[name][0, 0], uy=one.offset[name][0, 1])
    frame.fix("A")
    frame.fix("E")
    frame.load("P", **load_of(one))
    return frame


def load_of(one: Job) -> dict[str, float]:
    """The load on P, without what is zero."""
    return {name: float(force) for name, force in zip(LOADS, one.load[0], strict=True) if force}


def anew(frame: Frame) -> Array:
    """A frame of whose topology nothing is known."""
    for known in (ORDERS, PROGRAMS, KERNELS):
        known.clear()
    return frame.copy().solve().displacement("P")


def linkage() -> Linkage:
    """The four-bar as a linkage, all joints of one stiffness and without clearance."""
    bar, beam = (
        Linkage(A=(0, 0), B=(0, LENGTH), P=(LENGTH, LENGTH), D=(2 * LENGTH, LENGTH), E=(2 * LENGTH, 0)),
        Beam(BAR, STEEL),
    )
    for name, points in {"crank": "AB", "coupler": "BPD", "rocker": "DE"}.items():
        bar.link(name, *points, beam=beam)
    bar.revolute("A", "ground", "crank", drive=True)
    for name, pair in {"B": ("crank", "coupler"), "D": ("coupler", "rocker"), "E": ("rocker", "ground")}.items():
        bar.revolute(name, *pair, stiffness=SPRINGS)
    return bar


def alike(one: Job) -> Job:
    """The same pose and load with the joints of `linkage`."""
    offset = {name: np.zeros_like(gap) for name, gap in one.offset.items()}
    return replace(one, stiffness={name: np.array([SPRINGS]) for name in one.stiffness}, offset=offset)


def moved(bar: Linkage, one: Job) -> Array:
    """A pose of it, from the crank upright, its frame under the load, and the displacement of P."""
    frame = bar.move(A=float(one.theta[0]) - np.pi / 2.0).frame()
    frame.load("P", **load_of(one))
    return frame.solve().displacement("P")


def peers(jobs: list[Job]) -> dict[str, Way]:
    """Those that are installed; their numbers are those of the same job."""
    found: dict[str, Way] = {}

    def exact(k: int) -> Array:
        return jobs[k].truth(0, 0).astype(float)

    if importable("openseespy.opensees"):
        from .opensees import Opensees

        models = [Opensees(one) for one in jobs]
        found[OPENSEES] = Way(lambda k: models[k].rebuilt()[0, 0], exact)
    if importable("Pynite"):
        from . import pynite

        found[PYNITE] = Way(lambda k: pynite.solve(jobs[k])[0, 0], exact)
    return found


def targets(rows: list[Row]) -> list[Target]:
    """Limits in milliseconds, and what others take in the same run."""
    ms, errors = ({row["what"]: row[key] for row in rows} for key in ("ms", "error"))
    found = [
        Target("11 one frame", f"{what}: below {most:g} ms", f"{ms[what]:.3f} ms, {errors[what]:.1e}", ms[what] < most)
        for what, most in LIMITS.items()
    ]
    for peer, most in RATIOS.items():
        if peer in ms:
            told = f"{ms[MOVED]:.2f} ms against {ms[peer]:.2f}"
            met = ms[MOVED] < most * ms[peer]
            found.append(Target("11 one frame", f"{MOVED}: at most {most:g} times {peer}", told, met))
    worst = max(errors[what] for what in (*LIMITS, MOVED))
    found.append(Target("11 one frame", f"relative error below {ERROR:g}", f"{worst:.1e}", worst < ERROR))
    return found


if __name__ == "__main__":
    main("one_frame", run)
