"""Benchmark 10: frames of 20 to 3000 members in batches over which the modulus or the load varies, from one size and
batch to the next.

Beside linkframe stands LAPACK in a loop: the matrix of one entry, its order known, is scaled to each entry's modulus
and given to ``dpbsv``. Such a loop assembles nothing, tells no mechanism, and leaves what rounding leaves.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from linkframe.elements import Beam, Material, Section
from linkframe.framework import Frame
from numpy.typing import NDArray
from scipy.linalg.lapack import dpbsv
from scipy.sparse import tril
from scipy.sparse.csgraph import reverse_cuthill_mckee

from .harness import COLOURS, Row, Target, figure, least_each, main, write
from .large_ways import AREA, IY, IZ, LOAD, TORSION, E, G, Size, members, places, system, truth

Array = NDArray[Any]

# Nodes along x, y and z.
SHAPES: dict[str, tuple[Size, ...]] = {
    "chain": ((1, 1, 21), (1, 1, 61), (1, 1, 301), (1, 1, 1001), (1, 1, 3001)),
    "portal": ((3, 1, 5), (5, 1, 8), (9, 1, 19), (11, 1, 48)),
    "lattice": ((2, 2, 3), (3, 3, 3), (4, 4, 4), (5, 5, 5)),
}
BATCHES = (3, 30, 300, 3000)
# Members times entries up to which a batch is run.
MOST, QUICK = 300_000, 3000
# Members of a chain, and entries, of the sweep.
SWEEP = (4, 8, 16, 32, 64, 128, 256, 512, 1024, 2000)
ENTRIES = (1, 3, 10, 30, 100, 300, 1000, 3000, 10_000, 30_000, 100_000)


def described(size: Size, modulus: Array | float, share: Array | float = 1.0) -> Frame:
    """The frame of `large_ways`, its modulus and the size of its load a batch."""
    section = Section(A=AREA, Iy=IY, Iz=IZ, J=TORSION)
    beam = Beam(section, Material(E=modulus, G=modulus * (G / E)))
    frame = Frame()
    for place in places(size):
        frame.node(f"{place}", place)
        if place[2] == 0:
            frame.fix(f"{place}")
        if place[2] == size[2] - 1:
            frame.load(f"{place}", fx=LOAD[0] * share, fy=LOAD[1] * share, fz=LOAD[2] * share)
    for axis, start, end in members(size):
        frame.add(f"{start}{'xyz'[axis]}", beam, f"{start}", f"{end}")
    return frame


def ours(frame: Frame, tip: str) -> Array:
    """Displacement of the top by a frame that was never solved."""
    return frame.copy().solve().displacement(tip)


def looped(size: Size, scales: Array, shares: Array) -> Callable[[], Array]:
    """What solves for each entry in turn with ``dpbsv``, (entries, n)."""
    matrix, load = system(size)
    order = reverse_cuthill_mckee(matrix, symmetric_mode=True)
    entries = tril(matrix[order][:, order], format="coo")
    below = entries.row - entries.col
    band = np.zeros((below.max() + 1, len(load)), order="F")
    band[below, entries.col] = entries.data

    def run() -> Array:
        found = np.empty((len(scales), len(load)))
        for k, (scale, share) in enumerate(zip(scales, shares, strict=True)):
            _, solved, _ = dpbsv(np.asfortranarray(scale * band), (share * load[order])[:, None], lower=1)
            found[k, order] = solved[:, 0]
        return found

    return run


def run(out: Path, quick: bool) -> list[Target]:
    """Time and error beside a loop of LAPACK, and the steps from size to size and batch to batch."""
    most = QUICK if quick else MOST
    rows = [
        measure(kind, size, entries, varying)
        for kind, sizes in SHAPES.items()
        for size in sizes
        for entries in BATCHES
        for varying in ("modulus", "load")
        if count(size) * entries <= most
    ]
    write(out, "middle", rows)
    swept = sweep(most)
    write(out, "middle_sweep", swept)
    draw(out, rows)
    return [*targets(rows), *steps(swept)]


def count(size: Size) -> int:
    """Members."""
    return sum(1 for _ in members(size))


def measure(kind: str, size: Size, entries: int, varying: str) -> Row:
    """Seconds and errors of both."""
    scales = np.linspace(0.8, 1.25, entries) if varying == "modulus" else np.ones(entries)
    shares = np.ones(entries) if varying == "modulus" else np.linspace(0.5, 2.0, entries)
    load = shares if varying == "load" else 1.0
    frame = described(size, E * scales if varying == "modulus" else E, load)
    tip, peer = f"{tuple(n - 1 for n in size)}", looped(size, scales, shares)
    exact = truth(size, *system(size))[-6:] * (shares / scales)[:, None]
    found = {"ours": ours(frame, tip), "dpbsv": peer()[:, -6:]}
    seconds = least_each({"ours": lambda: ours(frame, tip), "dpbsv": peer}, 3)
    errors = {name: float(np.abs(each - exact).max() / np.abs(exact).max()) for name, each in found.items()}
    return {
        "kind": kind,
        "members": count(size),
        "entries": entries,
        "varying": varying,
        "way": frame.solve().plan.method.name,
        "ours / ms": 1e3 * seconds["ours"],
        "dpbsv / ms": 1e3 * seconds["dpbsv"],
        "ratio": seconds["ours"] / seconds["dpbsv"],
        "our error": errors["ours"],
        "error of dpbsv": errors["dpbsv"],
    }


def targets(rows: list[Row]) -> list[Target]:
    """Within two of the loop, and no worse an error, where there is work for a hundredth of a second at least."""
    out = []
    for kind in SHAPES:
        mine = [row for row in rows if row["kind"] == kind and row["dpbsv / ms"] > 10.0]
        if mine:
            worst = max(mine, key=lambda row: float(row["ratio"]))
            told = f"{worst['members']} members x {worst['entries']}, {worst['varying']} varying"
            out.append(
                Target("10 middle", f"{kind}: within 2 of dpbsv in a loop", f"{worst['ratio']:.2f} at {told}",
                       worst["ratio"] <= 2.0, "the loop assembles nothing; few unknowns a member of a narrow band")
            )  # fmt: skip
        # Of long chains the truth, a matrix in extended precision, leaves as much itself.
        error = max(float(row["our error"]) for row in rows if row["kind"] == kind and row["members"] < 1000)
        out.append(Target("10 middle", f"{kind} below 1000 members: relative error", f"{error:.1e}", error < 1e-12))
    return out


# -- steps ------------------------------------------------------------------------------------------------------------


def sweep(most: int) -> list[Row]:
    """Seconds of chains from size to size and batch to batch."""
    rows = []
    for varying in ("modulus", "load"):
        for number in SWEEP:
            for entries in ENTRIES:
                if number * entries > most:
                    continue
                values = np.linspace(0.8, 1.25, entries)
                size = (1, 1, number + 1)
                frame = described(size, E * values) if varying == "modulus" else described(size, E, values)
                tip = f"{(0, 0, number)}"
                ours(frame, tip)
                seconds = least_each({"": lambda frame=frame, tip=tip: ours(frame, tip)}, 3)[""]
                rows.append({"varying": varying, "members": number, "entries": entries, "ms": 1e3 * seconds})
    return rows


def steps(rows: list[Row]) -> list[Target]:
    """The greatest rise between neighbours beyond that of the work, and the greatest fall."""
    out = []
    for varying in ("modulus", "load"):
        at = {(row["members"], row["entries"]): float(row["ms"]) for row in rows if row["varying"] == varying}
        jumps = [(at[b, k] / at[a, k] / (b / a), f"{a} to {b} members x {k}")
                 for a, b in pairwise(SWEEP) for k in ENTRIES if (b, k) in at]  # fmt: skip
        jumps += [(at[n, b] / at[n, a] / (b / a), f"{n} members x {a} to {b}")
                  for n in SWEEP for a, b in pairwise(ENTRIES) if (n, b) in at]  # fmt: skip
        worst, where = max(jumps)
        told = f"{worst:.2f} times the work at {where}"
        out.append(Target("10 middle", f"{varying} varying: no step above 2", told, worst <= 2.0))
    return out


def draw(out: Path, rows: list[Row]) -> None:
    """Ratio over members."""
    with figure(out, "middle", columns=2) as axes:
        for ax, varying in zip(axes, ("modulus", "load"), strict=True):
            for k, kind in enumerate(SHAPES):
                for style, entries in zip(("o-", "s--", "^-.", "v:"), BATCHES, strict=True):
                    mine = [r for r in rows if (r["kind"], r["entries"], r["varying"]) == (kind, entries, varying)]
                    label = f"{kind} x {entries}"
                    ax.plot(
                        [r["members"] for r in mine], [r["ratio"] for r in mine], style, color=COLOURS[k], label=label
                    )
            ax.set(xscale="log", yscale="log", xlabel="members", title=f"{varying} varying")
        axes[0].set(ylabel="time over that of dpbsv in a loop")
        axes[1].legend(fontsize=6)


if __name__ == "__main__":
    main("middle", run)
