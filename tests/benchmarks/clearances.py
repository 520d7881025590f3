"""Benchmark 15: what clearances add where contact is statically indeterminate, and how far it is from equilibrium.

Three journals of two components each carry a frame of five beams; clearances and loads vary. Beside it stands the same
frame without clearances. With the displacement that linkframe found for each journal within its clearance imposed, the
frame is solved with 64 digits: at the minimum of energy the force in each joint has the direction of that
displacement, and the displacement of the loaded node is the one that linkframe returns.
"""

from __future__ import annotations

from functools import partial
from pathlib import Path

import numpy as np
from linkframe import Beam, Frame, Joint, Material, Rectangle
from numpy.typing import NDArray
from reference.mixed_method import solve
from reference.structure import Member, Spring, Structure

from .harness import COLOURS, Row, Target, figure, least_each, main, write
from .programs import backends, by

Array = NDArray[np.float64]
BAR, STEEL = Rectangle(y=0.02, z=0.01), Material(E=2e11, nu=0.3)
STIFFNESS = (2e8, 2e8, 2e8, 2e5, 2e5, 0.0)
JOURNALS, CHECKED = 3, 4
# Node that is loaded, and read; the clearance, in metres; times that the job with clearances may take of that without.
LOADED, GAP, WANTED = "b0", 1e-4, 3.0
ERROR = 1e-13
WHY = (
    "the minimum of energy takes three factorisations an entry, and the frame is solved for unit offsets and once more"
)


def run(out: Path, quick: bool) -> list[Target]:
    """Batches of 1 to 10^5 entries."""
    rows = measure((1, 100, 10_000) if quick else (1, 10, 100, 1000, 10_000, 100_000), 3 if quick else 12)
    write(out, "clearances", rows)
    draw(out, rows)
    return targets(rows)


def targets(rows: list[Row]) -> list[Target]:
    """At most three times the job without clearances; equilibrium and displacement to rounding."""
    name, longest = "15 clearances", rows[-1]["entries"]
    last = [row for row in rows if row["entries"] == longest]
    told = ", ".join(f"{row['back end']} {row['times']:.1f}" for row in last)
    best, error = min(row["times"] for row in last), max(max(row["across"], row["error"]) for row in rows)
    return [
        Target(name, f"{longest} entries: at most {WANTED:g} times without", told, best <= WANTED, WHY),
        Target(name, f"off equilibrium, and relative error, below {ERROR:g}", f"{error:.1e}", error < ERROR),
    ]


def drawn(count: int) -> tuple[Array, Array, Array]:
    """Clearances (journals, count), and the loads fx, fy, (count,) each."""
    rng = np.random.default_rng(0)
    return (
        GAP * rng.uniform(0.5, 1.5, (JOURNALS, count)),
        rng.uniform(-100.0, 100.0, count),
        rng.uniform(-150, -50, count),
    )


def places() -> dict[str, tuple[float, float, float]]:
    """Coordinates of the nodes: for each journal its bearing, the journal, and the tip of its beam."""
    out = {}
    for k in range(JOURNALS):
        out |= {f"{name}{k}": (0.0, 0.3 * k, 0.0) for name in "ca"} | {f"b{k}": (1.0, 0.3 * k + 0.1, 0.0)}
    return out


def beams() -> dict[str, tuple[str, str]]:
    """Ends of the beams."""
    own = {f"m{k}": (f"a{k}", f"b{k}") for k in range(JOURNALS)}
    return own | {f"r{k}": (f"b{k}", f"b{k + 1}") for k in range(JOURNALS - 1)}


def described(gaps: Array, fx: Array, fy: Array) -> Frame:
    """The frame with these clearances and loads."""
    frame, beam = Frame(), Beam(BAR, STEEL)
    for name, place in places().items():
        frame.node(name, place)
    for name, ends in beams().items():
        frame.add(name, beam, *ends)
    for k, gap in enumerate(gaps):
        frame.add(f"j{k}", Joint(STIFFNESS, clearance=gap), f"c{k}", f"a{k}")
        frame.fix(f"c{k}")
    frame.load(LOADED, fx=fx, fy=fy)
    return frame


def measure(counts: tuple[int, ...], repeats: int) -> list[Row]:
    """A row for each back end and number of entries."""
    return [row for count in counts for row in compared(count, repeats)]


def compared(count: int, repeats: int) -> list[Row]:
    """A row for each back end; frames are described anew each time, and others like them were solved before."""
    gaps, fx, fy = drawn(count)

    def solved(backend: str, with_clearance: float) -> None:
        with by(backend):
            described(with_clearance * gaps, fx, fy).solve().displacement(LOADED)

    calls = {f"{b} {share}": partial(solved, b, share) for b in backends() for share in (0.0, 1.0)}
    seconds = least_each(calls, repeats + 10 if count < 1000 else repeats)
    out = []
    for backend in backends():
        with by(backend):
            across, error = off(gaps, fx, fy)
        without, with_clearance = (1e6 * seconds[f"{backend} {share}"] / count for share in (0.0, 1.0))
        out.append(
            {
                "back end": backend,
                "entries": count,
                "us_without": without,
                "us_with": with_clearance,
                "times": with_clearance / without,
                "across": across,
                "error": error,
            }
        )
    return out


def off(gaps: Array, fx: Array, fy: Array) -> tuple[float, float]:
    """Share of a joint's force across its displacement, and relative error of the loaded node.

    Both by 64 digits, the worst of some entries.
    """
    solution = described(gaps, fx, fy).solve()
    offsets = np.stack([solution.contact(f"j{k}").offset for k in range(JOURNALS)])
    moved, worst = solution.displacement(LOADED), [0.0, 0.0]
    for entry in range(0, len(fx), -(-len(fx) // CHECKED)):
        offset = offsets[:, entry]
        exact = solve(structure(offset, (fx[entry], fy[entry])))
        for k in range(JOURNALS):
            force = np.array([float(x) for x in exact.joint_force[f"j{k}"][:2]])
            normal = offset[k, :2] / gaps[k, entry]
            worst[0] = max(worst[0], abs(force[0] * normal[1] - force[1] * normal[0]) / np.hypot(*force))
            worst[0] = max(worst[0], abs(np.hypot(*normal) - 1.0), float(force @ normal <= 0.0))
        truth = exact.displacement[LOADED].astype(np.float64)
        worst[1] = max(worst[1], np.abs(moved[entry] - truth).max() / np.abs(truth).max())
    return float(worst[0]), float(worst[1])


def structure(offsets: Array, load: tuple[float, float]) -> Structure:
    """The frame for the reference, its journals displaced in their bearings."""
    member = (STEEL.E, STEEL.G, BAR.A, BAR.Iy, BAR.Iz, BAR.J)
    section = tuple(float(np.asarray(each)) for each in member)
    return Structure(
        nodes=places(),
        members={name: Member(*ends, *section) for name, ends in beams().items()},
        joints={f"j{k}": Spring(f"c{k}", f"a{k}", STIFFNESS) for k in range(JOURNALS)},
        supports={f"c{k}": dict.fromkeys(("ux", "uy", "uz", "rx", "ry", "rz"), 0.0) for k in range(JOURNALS)},
        loads={LOADED: (float(load[0]), float(load[1]), 0.0, 0.0, 0.0, 0.0)},
        offsets={f"j{k}": (*map(float, offset[:2]), 0.0, 0.0, 0.0, 0.0) for k, offset in enumerate(offsets)},
    )


def draw(out: Path, rows: list[Row]) -> None:
    """Time an entry over entries, with and without clearances."""
    with figure(out, "clearances") as (ax,):
        for colour, backend in zip(COLOURS, backends(), strict=False):
            found = [row for row in rows if row["back end"] == backend]
            n = [row["entries"] for row in found]
            ax.plot(n, [row["us_with"] for row in found], "o-", color=colour, label=f"with clearances, {backend}")
            ax.plot(n, [row["us_without"] for row in found], "o--", color=colour, label=f"without, {backend}")
        ax.set(xlabel="entries", ylabel="time per entry / µs", xscale="log", yscale="log")
        ax.legend()


if __name__ == "__main__":
    main("clearances", run)
