"""Benchmark 5: one large frame, a tower and a cube of 10^3 to 10^5 beams, beside openseespy and bare solvers.

Each way runs in a process of its own, on one core: processor's seconds by stage, the best of three runs where they are
short, peak memory, residual, and on the smallest the error against refinement in extended precision. Bare solvers are
given linkframe's matrix. A way gets the smaller sizes only where, going by the size before, the next would take longer
than a limit; the table says so.
"""

from __future__ import annotations

import subprocess
from math import inf
from pathlib import Path
from typing import Any

from .harness import COLOURS, Row, Target, child, figure, importable, main, write

SIZES = {
    "tower": ((4, 4, 28), (7, 7, 75), (13, 13, 205)),
    "cube": ((8, 8, 8), (15, 15, 15), (33, 33, 33)),
}
PROGRAM = "import json, sys\nfrom benchmarks.large_ways import measure\nprint(json.dumps(measure(*sys.argv[1:])))"
# By name: kind, arguments, what has to be installed, and the power of the number of beams with which its time grows.
WAYS = {
    "linkframe, plain install": ("plain", ("",), "linkframe", 1.5),
    "linkframe, with extra": ("extra", ("",), "cvxopt", 1.5),
    "linkframe banded": ("plain", ("banded",), "linkframe", 2.0),
    "linkframe sparse": ("plain", ("sparse",), "linkframe", 2.0),
    "linkframe cholesky": ("extra", ("cholesky",), "cvxopt", 2.0),
    "linkframe iterative": ("plain", ("iterative",), "linkframe", 1.5),
    "bare SuperLU, symmetric": ("raw", ("superlu",), "scipy", 2.0),
    "bare SuperLU, default": ("raw", ("superlu_default",), "scipy", 2.5),
    "bare banded Cholesky": ("raw", ("banded",), "scipy", 2.0),
    "bare CHOLMOD": ("raw", ("cholmod",), "cvxopt", 2.0),
    "bare PARDISO": ("raw", ("pardiso",), "pypardiso", 2.0),
    "bare CG, Jacobi": ("raw", ("gradients",), "scipy", 1.5),
    "openseespy BandSPD": ("opensees", ("RCM", "BandSPD"), "openseespy.opensees", 2.0),
    "openseespy UmfPack": ("opensees", ("RCM", "UmfPack"), "openseespy.opensees", 2.0),
    "openseespy SparseSYM": ("opensees", ("RCM", "SparseSYM"), "openseespy.opensees", 2.2),
    "openseespy Mumps": ("opensees", ("AMD", "Mumps"), "openseespy.opensees", 2.0),
}
STAGES = ("description", "numbering", "assembly", "solution", "rest", "total")
# Of these `quick` compares those that may be the fastest, at one size.
QUICK = (
    "linkframe, plain install",
    "linkframe, with extra",
    "bare banded Cholesky",
    "bare CHOLMOD",
    "bare CG, Jacobi",
    "openseespy BandSPD",
)
# Seconds that a way may be expected to take, and after which it is stopped.
PATIENCE, LIMIT = 16.0, 60.0


def run(out: Path, quick: bool) -> list[Target]:
    """Tower and cube, in every way that is installed."""
    names = QUICK if quick else tuple(WAYS)
    rows = [row for kind in SIZES for row in measure(kind, SIZES[kind][1:2] if quick else SIZES[kind], names)]
    write(out, "large_frames", rows)
    ran = [row for row in rows if row["total"] != ""]
    draw(out, ran)
    return [target for kind in SIZES for target in targets(kind, [row for row in ran if row["kind"] == kind])]


def measure(kind: str, sizes: tuple[tuple[int, int, int], ...], names: tuple[str, ...]) -> list[Row]:
    """A row for each size and way."""
    rows: list[Row] = []
    expected = {name: 0.0 for name in names if importable(WAYS[name][2])}
    before = _beams(sizes[0])
    for size in sizes:
        beams = _beams(size)
        for name in expected:
            expected[name] *= (beams / before) ** WAYS[name][3]
            one = _one(name, size, expected[name])
            expected[name] = one.get("total", inf)
            stages = {stage: one.get(stage, "") for stage in STAGES}
            last = {key: one.get(key, "") for key in ("MB", "residual", "error", "operations")}
            rows.append({"kind": kind, "beams": beams, "way": name, "solver": one["told"], **stages, **last})
        before = beams
    return rows


def _one(name: str, size: tuple[int, int, int], expected: float) -> dict[str, Any]:
    """What a way measures of itself, or why it was not run or did not come to its end."""
    way, arguments, *_ = WAYS[name]
    if expected == inf:
        return {"told": "left out, as it failed at a smaller size"}
    if expected > PATIENCE:
        return {"told": f"left out, as about {expected:.0f} s are expected"}
    try:
        done: dict[str, Any] = child(PROGRAM, way, f"{list(size)}", *arguments, limit=LIMIT)
    except subprocess.CalledProcessError:
        return {"told": "failed"}
    except subprocess.TimeoutExpired:
        return {"told": f"stopped after {LIMIT:.0f} s"}
    return done


def _beams(size: tuple[int, int, int]) -> int:
    nx, ny, nz = size
    return 3 * nx * ny * nz - nx * ny - ny * nz - nx * nz


def targets(kind: str, rows: list[Row]) -> list[Target]:
    """What issue and README promise, at the sizes from 10^4 beams on."""
    out = []
    for beams in sorted({row["beams"] for row in rows if row["beams"] > 5000}):
        at = {row["way"]: row for row in rows if row["beams"] == beams}
        what = f"{kind} of {beams} beams"
        for name in ("linkframe, plain install", "linkframe, with extra"):
            if name in at:
                out += _targets(what, name, at)
    return out


def _targets(what: str, name: str, at: dict[str, Row]) -> list[Target]:
    mine, plain = at[name], name == "linkframe, plain install"
    told = f"{mine['solver']}, {mine['total']:.2f} s"
    share = mine["assembly"] / mine["solution"]
    spent = ", ".join(f"{stage} {mine[stage]:.3f} s" for stage in STAGES[1:-1])
    rate = mine["operations"] / mine["solution"]
    bound = f"{mine['solver']}: {mine['operations']:.2g} operations at {rate:.2g} a second; {spent}"
    out = [Target("5 large frames", f"{what}, {name}: assembly below a tenth of the solve",
                  f"{mine['assembly']:.3f} s of {mine['solution']:.2f} s: {share:.2f}", share < 0.1,
                  f"{1e6 * mine['assembly'] / _of(what):.1f} us a beam")]  # fmt: skip
    free = ("bare SuperLU, symmetric", "bare banded Cholesky", "bare SuperLU, default", "bare CG, Jacobi")
    bare = {way: row["total"] for way, row in at.items() if way.startswith("bare") and (not plain or way in free)}
    if bare:
        best = min(bare, key=lambda way: float(bare[way]))
        ratio = mine["total"] / bare[best]
        out.append(
            Target("5 large frames", f"{what}, {name}: within 1.3 of the fastest bare solver",
                   f"{told}; {best} {bare[best]:.2f} s: {ratio:.2f}", ratio <= 1.3,
                   bound)
        )  # fmt: skip
    others = {way: row["total"] for way, row in at.items() if way.startswith("openseespy")}
    if others:
        best, wanted = min(others, key=lambda way: float(others[way])), 1.0 if plain else 5.0
        ratio = others[best] / mine["total"]
        out.append(
            Target("5 large frames", f"{what}, {name}: {wanted:g} times as fast as openseespy",
                   f"{told}; {best} {others[best]:.2f} s: {ratio:.1f} times", ratio >= wanted,
                   bound)
        )  # fmt: skip
    return out


def _of(what: str) -> int:
    return int(what.split()[-2])


def draw(out: Path, rows: list[Row]) -> None:
    """Time and peak memory over beams, and residual over time."""
    names = [name for name in WAYS if any(row["way"] == name for row in rows)]
    with figure(out, "large_frames", columns=4, width=3.6, height=4.2) as axes:
        for k, name in enumerate(names):
            mine = name.startswith("linkframe,")
            style = "o-" if mine else "s--" if name.startswith("linkframe") else "^:" if "open" in name else "x-."
            colour = COLOURS[k % len(COLOURS)]
            for column, kind in enumerate(SIZES):
                of_way = [row for row in rows if row["way"] == name and row["kind"] == kind]
                beams = [row["beams"] for row in of_way]
                # the way with the extra is often that of the plain install, and lies below it
                width = 4.0 if name == "linkframe, with extra" else 2.0 if mine else 1.0
                axes[column].plot(beams, [row["total"] for row in of_way], style, color=colour, lw=width, label=name)
                if column:
                    axes[2].plot(beams, [row["MB"] for row in of_way], style, color=colour, lw=width)
                    axes[3].plot(
                        [row["total"] for row in of_way], [row["residual"] for row in of_way], style, color=colour
                    )
        for ax, title in zip(axes, ("tower: time", "cube: time", "cube: memory", "cube: error"), strict=True):
            ax.set(xscale="log", yscale="log", xlabel="beams", title=title)
        axes[0].set(ylabel="time from description to displacements / s")
        axes[2].set(ylabel="peak memory / MB")
        axes[3].set(xlabel="time / s", ylabel="backward error")
        axes[3].legend(*axes[0].get_legend_handles_labels(), fontsize=7, loc="upper left", bbox_to_anchor=(1.02, 1.0))


if __name__ == "__main__":
    main("large_frames", run)
