"""Benchmark 3: time a (pose, sample) against the mesh of each link, whose interior is condensed once for all.

Two ways to refine a link: ``Beam(segments=n)``, of which statics needs no more than one piece, and n beams with nodes
between them, described one by one, of which every one is there.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
from linkframe.framework import Frame
from numpy.typing import NDArray
from reference.structure import COMPONENTS

from .harness import COLOURS, Row, Target, figure, least_each, main, write
from .job import Job, error, job

Array = NDArray[np.float64]
CHECKED = 3
COUNTS = (1, 2, 4, 8, 16, 32, 64)
SEGMENTS, BEAMS = "Beam(segments=n)", "n beams"


def run(out: Path, quick: bool) -> list[Target]:
    """Links of 1 to 64 segments, 361 poses x 1000 samples."""
    theta = np.radians(np.linspace(5.0, 175.0, 361))
    work = replace(job(len(theta), 100 if quick else 1000, space=False), theta=theta)
    rows = measure(work, COUNTS, 3 if quick else 7)
    write(out, "segments", rows)
    draw(out, rows)
    return [target(way, [row for row in rows if row["link"] == way]) for way in WAYS]


def target(way: str, rows: list[Row]) -> Target:
    """Nearly as fast with 64 segments as with one."""
    most = max(row["times_one_segment"] for row in rows)
    cost = 1e3 * (rows[-1]["seconds"] - rows[0]["seconds"])
    told = f"{way}: at most {most:.2f} times ({rows[0]['entries']} entries)"
    bound = f"describing and condensing {rows[-1]['segments']} pieces a link takes {cost:.0f} ms, shared by all samples"
    return Target("3 segments", "at most 1.2 times from 1 to 64 segments", told, most <= 1.2, bound)


def by_segments(work: Job, count: int) -> Frame:
    """The job, its beams told to have segments."""
    return work.frame(count)


def by_beams(work: Job, count: int) -> Frame:
    """The job, each member described as so many beams on the body of its link."""
    template, frame = work.frame(), Frame()
    for name, body in template.bodies.items():
        frame.body(name, body.origin, body.axes)
    for name, node in template.nodes.items():
        frame.node(name, node.coordinates, node.body)
    for name, member in template.members.items():
        start, end = template.nodes[member.start], template.nodes[member.end]
        inside = [f"{name} {k}" for k in range(1, count)]
        for k, node_name in enumerate(inside, start=1):
            between = start.coordinates + (end.coordinates - start.coordinates) * (k / count)
            frame.node(node_name, between, start.body)
        ends = [member.start, *inside, member.end]
        for k in range(count):
            frame.add(f"{name}.{k}", member.element, ends[k], ends[k + 1])
    for name, joint in template.joints.items():
        frame.add(name, joint.element, joint.first, joint.second)
    for name in template.supports:
        frame.fix(name)
    for name, offset in template.offsets.items():
        frame.offset(name, **{COMPONENTS[k]: value for k, value in offset.items()})
    for name, loads in template.loads.items():
        for k, value in loads:
            frame.load(name, **{f"{'fm'[k // 3]}{'xyz'[k % 3]}": value})
    return frame


WAYS: dict[str, Callable[[Job, int], Frame]] = {SEGMENTS: by_segments, BEAMS: by_beams}


def measure(work: Job, counts: tuple[int, ...], repeats: int) -> list[Row]:
    """A row for each way and number of segments."""
    poses = [0, work.shape[0] // 3, work.shape[0] // 2 + 1]
    exact = np.array([[work.truth(pose, sample) for sample in range(CHECKED)] for pose in poses])
    results: dict[tuple[str, int], Array] = {}

    def solve(way: str, count: int) -> None:
        results[way, count] = WAYS[way](work, count).solve().displacement("P")

    each = [(way, count) for way in WAYS for count in counts]
    seconds = least_each({str(key): partial(solve, *key) for key in each}, repeats)
    return [
        {
            "link": way,
            "segments": count,
            "entries": work.size,
            "seconds": seconds[str((way, count))],
            "us_per_entry": 1e6 * seconds[str((way, count))] / work.size,
            "times_one_segment": seconds[str((way, count))] / seconds[str((way, counts[0]))],
            "worst_error": float(error(results[way, count][poses, :CHECKED], exact).max()),
        }
        for way, count in each
    ]


def draw(out: Path, rows: list[Row]) -> None:
    """Time and error over segments."""
    with figure(out, "segments", columns=2, width=3.6, height=3.0) as (left, right):
        for colour, way in zip(COLOURS, WAYS, strict=False):
            found = [row for row in rows if row["link"] == way]
            n = [row["segments"] for row in found]
            left.plot(n, [row["us_per_entry"] for row in found], "o-", color=colour, label=way)
            right.plot(n, [row["worst_error"] for row in found], "o-", color=colour, label=way)
        left.axhline(1.2 * rows[0]["us_per_entry"], ls="--", color="#555555", label="1.2 times one segment")
        left.set(ylabel="time per (pose, sample) / µs", ylim=(0, None))
        right.set(ylabel="worst relative error against 50 digits", yscale="log", ylim=(1e-16, 1e-9))
        for ax in (left, right):
            ax.set(xlabel="n, segments per link", xscale="log", xticks=n, xticklabels=n)
            ax.minorticks_off()
            ax.legend()


if __name__ == "__main__":
    main("segments", run)
