"""Benchmark 10: frames of 20 to 3000 members in batches over which the modulus or the load varies, from one size and
batch to the next; beside linkframe the quickest of `middle_peers`.

Who does what counts as much as the numbers, so there are three ratios. In `ratio`, frames are described and peers have
arrays of members whose axes are known: linkframe has to find numbers, joints and coordinates, and tells mechanisms, and
they do not. In `ratio anew`, both begin with places and members, by name here and in arrays there. In `ratio again`,
one load more is solved for where the last factor is there.
"""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from linkframe.elements import Beam, Material, Section
from linkframe.framework import Frame
from numpy.typing import NDArray

from .harness import COLOURS, Row, Target, figure, least_each, main, write
from .large_ways import AREA, IY, IZ, LOAD, TORSION, E, G, Size, members, places, system, truth
from .middle_peers import Arrays, peers, substitution

Array = NDArray[Any]

# Nodes along x, y and z, for about 20, 60, 120, 300, 1000 and 3000 members.
SHAPES: dict[str, tuple[Size, ...]] = {
    "chain": ((1, 1, 21), (1, 1, 61), (1, 1, 121), (1, 1, 301), (1, 1, 1001), (1, 1, 3001)),
    "portal": ((3, 1, 5), (5, 1, 8), (7, 1, 10), (9, 1, 18), (13, 1, 41), (21, 1, 74)),
    "lattice": ((2, 2, 3), (3, 3, 3), (3, 3, 6), (5, 5, 5), (7, 7, 8), (10, 10, 11)),
}
BATCHES = (1, 3, 30, 300, 3000)
# Members times entries up to which a batch is run, and members up to which the truth is known.
MOST, QUICK, KNOWN = 300_000, 3000, 2000
# Seconds from which on one call tells enough: all but openseespy have been called once before.
LONG = 0.5
# Members of a chain, and entries, of the sweep.
SWEEP = (4, 8, 16, 20, 24, 32, 64, 128, 256, 512, 1024, 2000)
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


def run(out: Path, quick: bool) -> list[Target]:
    """Time and error beside the peers, and the steps from size to size and batch to batch."""
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
    """Seconds and errors of all."""
    scales = np.linspace(0.8, 1.25, entries) if varying == "modulus" else np.ones(1)
    shares = np.ones(1) if varying == "modulus" else np.linspace(0.5, 2.0, entries)
    frame = described(size, E * scales if varying == "modulus" else E, shares if varying == "load" else 1.0)
    tip = f"{tuple(n - 1 for n in size)}"
    ways = {"ours": lambda: ours(frame, tip), **peers(size, scales, shares)}
    found = {name: way()[:, -6:] for name, way in ways.items() if name != "openseespy"}
    repeats = 5 if count(size) * entries <= QUICK else 3
    seconds = least_each(ways, repeats, patience=LONG)
    least, best = min((spent, name) for name, spent in seconds.items() if name != "ours")
    row = {
        "kind": kind,
        "members": count(size),
        "entries": entries,
        "varying": varying,
        "way": frame.solve().plan.method.name,
        "ours / ms": 1e3 * seconds["ours"],
        "best / ms": 1e3 * least,
        "best": best,
        "ratio": seconds["ours"] / least,
        "ratio anew": from_names(size, scales, shares, varying, best, repeats),
        "ratio again": one_more(size) if entries == 1 and varying == "load" else np.nan,
    }
    exact = found["ours"]
    if count(size) <= KNOWN:
        exact = truth(size, *system(size))[-6:] * (shares / scales)[:, None]
    errors = {name: float(np.abs(each - exact).max() / np.abs(exact).max()) for name, each in found.items()}
    known = count(size) <= KNOWN
    return row | {"our error": errors["ours"] if known else np.nan, "error of LAPACK": errors["LAPACK"]}


def from_names(size: Size, scales: Array, shares: Array, varying: str, best: str, repeats: int) -> float:
    """Ratio to a peer where both begin with places and members."""
    tip = f"{tuple(n - 1 for n in size)}"
    modulus, share = (E * scales, 1.0) if varying == "modulus" else (E, shares)
    ways = {
        "ours": lambda: described(size, modulus, share).solve().displacement(tip),
        "best": peers(size, scales, shares, anew=True)[best],
    }
    seconds = least_each(ways, repeats, patience=LONG)
    return seconds["ours"] / seconds["best"]


def one_more(size: Size) -> float:
    """Ratio to LAPACK of one load more on a frame that is solved."""
    frame, tip, turn = described(size, E), f"{tuple(n - 1 for n in size)}", iter(range(1, 10**6))
    substitute = substitution(Arrays(size))

    def ours() -> Array:
        frame.set_load(tip, fx=float(next(turn)))
        return frame.solve().displacement(tip)

    ours()
    seconds = least_each({"ours": ours, "LAPACK": lambda: substitute(float(next(turn)))}, 10)
    return seconds["ours"] / seconds["LAPACK"]


def targets(rows: list[Row]) -> list[Target]:
    """Within two of the best peer, and hardly an error."""
    out = []
    for kind in SHAPES:
        mine = [row for row in rows if row["kind"] == kind]
        worst = max(mine, key=lambda row: float(row["ratio"]))
        told = f"{worst['members']} members x {worst['entries']}, {worst['varying']} varying"
        middle = float(np.median([row["ratio"] for row in mine]))
        out.append(
            Target("10 middle", f"{kind}: within 2 of the quickest of LAPACK, CHOLMOD, openseespy",
                   f"{worst['ratio']:.2f} at {told}; median {middle:.2f}", worst["ratio"] <= 2.0,
                   "plan and checks in Python, half a millisecond to two, where the peers get arrays; of many loads "
                   "refinement, which substitutes once more")
        )  # fmt: skip
        anew, again = (np.nanmedian([float(row[name]) for row in mine]) for name in ("ratio anew", "ratio again"))
        told = f"{anew:.2f}; {again:.2f}"
        out.append(Target("10 middle", f"{kind}: median where both begin with names; of one load more", told, True))
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
                repeats = min(max(10**5 // (number * entries), 3), 30)  # more of what a busy machine disturbs more
                seconds = least_each({"": lambda frame=frame, tip=tip: ours(frame, tip)}, repeats)[""]
                method = frame.copy().solve().plan.method
                row = {"varying": varying, "members": number, "entries": entries, "ms": 1e3 * seconds}
                rows.append(row | {"way": method.name, "expected / ms": 1e3 * method.seconds})
    return rows


def steps(rows: list[Row]) -> list[Target]:
    """The greatest rise between neighbours beyond that of the work, and the greatest fall of the time itself."""
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
        # more members that take less time tell of a slow way below
        falls = [(at[a, k] / at[b, k], f"{a} to {b} members x {k}")
                 for a, b in pairwise(SWEEP) for k in ENTRIES if (b, k) in at]  # fmt: skip
        falls += [(at[n, a] / at[n, b], f"{n} members x {a} to {b}")
                  for n in SWEEP for a, b in pairwise(ENTRIES) if (n, b) in at]  # fmt: skip
        worst, where = max(falls)
        told = f"{worst:.2f} times as long before at {where}"
        out.append(Target("10 middle", f"{varying} varying: no fall above 1.5", told, worst <= 1.5))
        out.append(expected([row for row in rows if row["varying"] == varying], varying))
    return out


def expected(rows: list[Row], varying: str) -> Target:
    """The times that the choice of the way expects, which `tests/framework/test_no_steps.py` holds to have no step."""
    shares = {float(row["expected / ms"]) / float(row["ms"]): row for row in rows}
    middle, worst = float(np.median([*shares])), max(shares, key=lambda share: max(share, 1.0 / share))
    at = shares[worst]
    told = f"expected {worst:.2f} of measured at {at['members']} members x {at['entries']}; median {middle:.2f}"
    return Target("10 middle", f"{varying} varying: expected within 2 of measured", told, 0.5 <= worst <= 2.0)


def draw(out: Path, rows: list[Row]) -> None:
    """Ratio over members."""
    with figure(out, "middle", columns=2) as axes:
        for ax, varying in zip(axes, ("modulus", "load"), strict=True):
            for k, kind in enumerate(SHAPES):
                for style, entries in zip(("x-", "o-", "s--", "^-.", "v:"), BATCHES, strict=True):
                    mine = [r for r in rows if (r["kind"], r["entries"], r["varying"]) == (kind, entries, varying)]
                    label = f"{kind} x {entries}"
                    ax.plot(
                        [r["members"] for r in mine], [r["ratio"] for r in mine], style, color=COLOURS[k], label=label
                    )
            ax.set(xscale="log", yscale="log", xlabel="members", title=f"{varying} varying")
        axes[0].set(ylabel="time over that of the quickest peer")
        axes[1].legend(fontsize=6)


if __name__ == "__main__":
    main("middle", run)
