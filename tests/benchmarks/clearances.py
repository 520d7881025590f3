"""Benchmark 15: what clearances add, for each thing that varies, and how far contact is from equilibrium.

Statically indeterminate contact: three journals of two components each carry a frame of five beams. Determinate: the
pins of a four-bar at 36 poses. Clearances and loads vary, or the moduli of members as well, or places. Beside it stands
the same frame without clearances. With the displacement that linkframe found for each journal within its clearance
imposed, the frame is solved with 64 digits: at the minimum of energy the force in each joint has the direction of that
displacement, and the displacement of the loaded node is the one that linkframe returns. The memory that clearances add
is compared with what contact returns: for each component an offset and a force, for each joint a force and a state.
"""

from __future__ import annotations

import gc
import tracemalloc
from functools import partial
from pathlib import Path

import numpy as np
from linkframe import Beam, FourBar, Frame, Joint, Material, Rectangle
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
VARIES = ("loads", "moduli", "places")
POSES = 36
# Entries between which memory is seen to grow; bytes an entry of offsets and forces, forces and states, and two masks.
LONG, RETURNED = (600_000, 1_200_000), 8 * (2 + 2 + 1) * JOURNALS + JOURNALS + 2
WHY = (
    "with the loads the frame is solved for a unit offset in each of six components, and once more with the offsets "
    "found, and the minimum of energy takes three factorisations of 6 x 6 an entry. Where moduli vary that is 7900 "
    "operations an entry to 2060 without, which machine code does in 0.44 and 0.08 us; where places vary 7600 to 2050, "
    "in 0.43 and 0.08; of pins whose lengths vary 5100 to 1400, in 0.34 and 0.11; where loads alone vary 2000 to 6, in "
    "0.13 and 0.002"
)


def run(out: Path, quick: bool) -> list[Target]:
    """Batches of 1 to 10^5 entries."""
    counts, repeats = (1, 100, 10_000) if quick else (1, 10, 100, 1000, 10_000, 100_000), 3 if quick else 12
    rows = [row for varies in VARIES for row in measure(counts if varies == "loads" else counts[-2:], repeats, varies)]
    write(out, "clearances", rows)
    determinate = [row for varies in VARIES for row in four_bars(10 if quick else 3000, repeats, varies)]
    write(out, "clearances_determinate", determinate)
    draw(out, [row for row in rows if row["varies"] == "loads"])
    found = targets(rows) + [target for varies in VARIES for target in ratio(determinate, varies, "determinate")]
    return found if quick else [*found, flat(out)]


def flat(out: Path) -> Target:
    """What clearances add to the memory at hand by entry, as the batch grows: little more than what contact returns."""
    rows: list[Row] = []
    for varies in VARIES:
        most = [[peak(count, varies, share) for count in LONG] for share in (0.0, 1.0)]
        without, added = (float(b - a) / (LONG[1] - LONG[0]) for a, b in (most[0], np.subtract(most[1], most[0])))
        rows.append({"varies": varies, "bytes without": without, "bytes added": added, "MB": most[1][1] / 1e6})
    write(out, "clearances_memory", rows)
    told = ", ".join(f"{row['varies']} {row['bytes added']:.0f} to {row['bytes without']:.0f} without" for row in rows)
    what = f"memory added by entry, at most 1.5 times the {RETURNED} bytes that contact returns"
    return Target("15 clearances", what, told, all(row["bytes added"] <= 1.5 * RETURNED for row in rows))


def peak(count: int, varies: str, share: float) -> int:
    """Largest memory at hand while a frame is solved and read, bytes."""
    gaps, fx, fy = drawn(count)
    frame = described(share * gaps, fx, fy, varies)
    gc.collect()
    tracemalloc.start()
    frame.solve().displacement(LOADED)
    most = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    return most


def targets(rows: list[Row]) -> list[Target]:
    """At most three times the job without clearances; equilibrium and displacement to rounding."""
    found = [target for varies in VARIES for target in ratio(rows, varies, "indeterminate")]
    alone = [row for row in rows if row["varies"] == "loads"]
    error = max(max(row["across"], row["error"]) for row in alone)
    more = max(row["error"] / max(row["error_without"], ERROR) for row in rows)
    told = f"off equilibrium, and relative error, below {ERROR:g} where loads vary"
    return [
        *found,
        Target("15 clearances", told, f"{error:.1e}", error < ERROR),
        Target("15 clearances", "error at most 1.5 times that without clearances", f"{more:.2f} times", more <= 1.5),
    ]


def ratio(rows: list[Row], varies: str, kind: str) -> list[Target]:
    """At most three times the job without clearances, where something varies; none if it was not measured."""
    mine = [row for row in rows if row["varies"] == varies]
    longest = max((row["entries"] for row in mine), default=0)
    last = [row for row in mine if row["entries"] == longest]
    told = ", ".join(f"{row['back end']} {row['times']:.1f} ({row['us_with']:.2g} us)" for row in last)
    what = f"{kind} contact, {varies} varying, {longest} entries: at most {WANTED:g} times without"
    return [Target("15 clearances", what, told, min(row["times"] for row in last) <= WANTED, WHY)] if last else []


def drawn(count: int) -> tuple[Array, Array, Array]:
    """Clearances (journals, count), and the loads fx, fy, (count,) each."""
    rng = np.random.default_rng(0)
    return (
        GAP * rng.uniform(0.5, 1.5, (JOURNALS, count)),
        rng.uniform(-100.0, 100.0, count),
        rng.uniform(-150, -50, count),
    )


def moduli(count: int, members: int) -> Array:
    """E of each member, (members, count)."""
    spread: Array = 2e11 * np.exp(0.1 * np.random.default_rng(1).normal(size=(members, count)))
    return spread


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


def described(gaps: Array, fx: Array, fy: Array, varies: str = "loads") -> Frame:
    """The frame with these clearances and loads, of which something else varies as well."""
    frame, count = Frame(), len(fx)
    moved = 0.01 * np.random.default_rng(2).normal(size=(JOURNALS, count, 2)) if varies == "places" else None
    for name, place in places().items():
        at = np.array(place)
        if moved is not None and name[0] == "b":
            at = at + np.pad(moved[int(name[1])], ((0, 0), (0, 1)))
        frame.node(name, at)
    each = moduli(count, len(beams())) if varies == "moduli" else [STEEL.E] * len(beams())
    for (name, ends), modulus in zip(beams().items(), each, strict=True):
        frame.add(name, Beam(BAR, Material(E=modulus, nu=0.3)), *ends)
    for k, gap in enumerate(gaps):
        frame.add(f"j{k}", Joint(STIFFNESS, clearance=gap), f"c{k}", f"a{k}")
        frame.fix(f"c{k}")
    frame.load(LOADED, fx=fx, fy=fy)
    return frame


def four_bars(samples: int, repeats: int, varies: str) -> list[Row]:
    """A row for each back end: a four-bar at some poses with pins of some clearance, whose contact is determinate."""
    rng, turn = np.random.default_rng(0), np.linspace(0.1, 6.0, POSES)[:, None]
    gaps = GAP * rng.uniform(0.5, 1.5, (JOURNALS, 1, samples))
    fy, coupler = rng.uniform(-150.0, -50.0, (1, samples)), 0.25 * (1.0 + 0.01 * rng.uniform(-1.0, 1.0, (1, samples)))
    each = moduli(samples, 3)[:, None]

    def solved(backend: str, share: float) -> None:
        young = each if varies == "moduli" else [STEEL.E] * 3
        beam = {
            name: Beam(BAR, Material(E=E, nu=0.3))
            for name, E in zip(("crank", "coupler", "rocker"), young, strict=True)
        }
        length = coupler if varies == "places" else 0.25
        with by(backend):
            frame = FourBar(0.1, length, 0.2, 0.25, (0.125, 0.0), beam=beam).move(turn).frame()
            for name, gap in zip("BDE", gaps, strict=True):
                frame.change(name, Joint(STIFFNESS, clearance=share * gap))
            frame.load("P", fx=10.0, fy=fy)
            frame.solve().displacement("P")

    calls = {f"{b} {share}": partial(solved, b, share) for b in backends() for share in (0.0, 1.0)}
    seconds = least_each(calls, repeats)
    return [row(seconds, backend, POSES * samples, varies) for backend in backends()]


def row(seconds: dict[str, float], backend: str, count: int, varies: str) -> Row:
    """Time of a back end without and with clearances."""
    without, with_clearance = (1e6 * seconds[f"{backend} {share}"] / count for share in (0.0, 1.0))
    return {
        "varies": varies,
        "back end": backend,
        "entries": count,
        "us_without": without,
        "us_with": with_clearance,
        "times": with_clearance / without,
    }


def measure(counts: tuple[int, ...], repeats: int, varies: str = "loads") -> list[Row]:
    """A row for each back end and number of entries."""
    return [row for count in counts for row in compared(count, repeats, varies)]


def compared(count: int, repeats: int, varies: str) -> list[Row]:
    """A row for each back end; frames are described anew each time, and others like them were solved before."""
    gaps, fx, fy = drawn(count)

    def solved(backend: str, with_clearance: float) -> None:
        with by(backend):
            described(with_clearance * gaps, fx, fy, varies).solve().displacement(LOADED)

    calls = {f"{b} {share}": partial(solved, b, share) for b in backends() for share in (0.0, 1.0)}
    seconds = least_each(calls, repeats + 10 if count < 1000 else repeats)
    out = []
    for backend in backends():
        with by(backend):
            across, error = off(gaps, fx, fy, varies)
            _, without = off(0.0 * gaps, fx, fy, varies)
        out.append(row(seconds, backend, count, varies) | {"across": across, "error": error, "error_without": without})
    return out


def off(gaps: Array, fx: Array, fy: Array, varies: str) -> tuple[float, float]:
    """Share of a joint's force across its displacement, and relative error of the loaded node.

    Both by 64 digits, the worst of some entries.
    """
    frame = described(gaps, fx, fy, varies)
    solution = frame.solve()
    journals = [name for name, joint in frame.joints.items() if joint.element.clearance.any()]
    offsets = np.zeros((JOURNALS, len(fx), 3))
    for name in journals:
        offsets[int(name[1])] = solution.contact(name).offset
    moved, worst = solution.displacement(LOADED), [0.0, 0.0]
    for entry in range(0, len(fx), -(-len(fx) // CHECKED)):
        offset = offsets[:, entry]
        exact = solve(structure(frame, entry, offset, (fx[entry], fy[entry])))
        for k in range(len(journals)):
            force = np.array([float(x) for x in exact.joint_force[f"j{k}"][:2]])
            normal = offset[k, :2] / gaps[k, entry]
            worst[0] = max(worst[0], abs(force[0] * normal[1] - force[1] * normal[0]) / np.hypot(*force))
            worst[0] = max(worst[0], abs(np.hypot(*normal) - 1.0), float(force @ normal <= 0.0))
        truth = exact.displacement[LOADED].astype(np.float64)
        worst[1] = max(worst[1], np.abs(moved[entry] - truth).max() / np.abs(truth).max())
    return float(worst[0]), float(worst[1])


def structure(frame: Frame, entry: int, offsets: Array, load: tuple[float, float]) -> Structure:
    """The frame at an entry for the reference, its journals displaced in their bearings."""
    count = frame.shape[0]
    nodes = {name: tuple(map(float, np.broadcast_to(frame.position(name), (count, 3))[entry])) for name in frame.nodes}
    members = {}
    for name, (element, *ends) in frame.members.items():
        E = float(np.broadcast_to(element.material.E, count)[entry])
        section = tuple(float(np.asarray(each)) for each in (BAR.A, BAR.Iy, BAR.Iz, BAR.J))
        members[name] = Member(*ends, E, E / (2.0 * (1.0 + 0.3)), *section)
    return Structure(
        nodes=nodes,
        members=members,
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
