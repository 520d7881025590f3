"""Benchmark 8: positions of linkages. A crank's turn beside other programs, and batches of poses and lengths."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from time import process_time
from typing import TYPE_CHECKING

import numpy as np
from linkframe.models import Linkage, Motion
from numpy.typing import NDArray
from reference.linkages import scissor
from scipy.spatial.transform import Rotation

from .harness import COLOURS, Row, Target, figure, least_each, main, write
from .linkage_peers import AT, LINKAGES, closure_error, described, ways
from .programs import COMPILED, NUMPY, backends, by

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Drives = dict[str, NDArray[np.float64]]
OURS, ANEW = "linkframe", "linkframe, description anew"
STEPPED = "pylinkage step"
ERROR = 1e-13
# Seconds that each batch may take.
ONE_POSE = {"four-bar": 0.1, "six-bar": 0.1, "delta robot": 1.0, "Stewart platform": 0.5}
# Power of the number of links with which dead points of a chain may take longer.
POWER = 1.5
# Microseconds that a pose of a long batch may take, by NumPy and as machine code.
LONG = {
    "four-bar": (0.6, 0.1),
    "six-bar": (1.0, 0.2),
    "four-bar, rates": (1.6, 0.5),
    "Stewart platform, a tenth": (10.0, 10.0),
    "Stewart platform": (10.0, 5.0),
}
LIMITS = {"four-bar, random lengths": 1.0, "delta robot": 1.0, "Stewart platform": 0.2}


def run(out: Path, quick: bool) -> list[Target]:
    """Sweeps of a four-bar and a six-bar; batches of a four-bar with random lengths, a delta and a Stewart platform."""
    sweeps = sweep_rows(360, 3 if quick else 15)
    write(out, "kinematics_sweeps", sweeps)
    batches = batch_rows(0.1 if quick else 1.0)
    write(out, "kinematics_batches", batches)
    long = long_rows(100_000 if quick else 1_000_000, 2 if quick else 5)
    write(out, "kinematics_long", long)
    ones = one_pose_rows(20 if quick else 200)
    write(out, "kinematics_one_pose", ones)
    chains = chain_rows((3, 6) if quick else (6, 11, 21, 41))
    write(out, "kinematics_chains", chains)
    draw(out, sweeps, batches)
    return [
        *sweep_targets(sweeps),
        *batch_targets(batches),
        *long_targets(long),
        *one_pose_targets(ones),
        *chain_targets(chains),
    ]


def sweep_rows(poses: int, repeats: int) -> list[Row]:
    """Time and closure error of each contender on each linkage; times of the first call, and of the fastest later."""
    angles = np.linspace(0.0, 2.0 * np.pi, poses + 1)[1:]
    rows = []
    for linkage, links in LINKAGES.items():
        sweeps = {name: way(links, angles) for name, way in ways().items()}
        first, error, apart = {}, {}, {}
        for name, sweep in sweeps.items():
            start = process_time()
            pins = sweep()
            first[name] = process_time() - start
            error[name] = closure_error(links, pins)
            exact = sweeps[OURS]()
            apart[name] = max(float(np.abs(pins[point] - exact[point]).max()) for point in exact) / abs(AT["G"])
        rows += [
            {
                "linkage": linkage,
                "contender": name,
                "ms": 1e3 * seconds,
                "first_ms": 1e3 * first[name],
                "closure_error": error[name],
                "apart_from_linkframe": apart[name],
            }
            for name, seconds in least_each(sweeps, repeats).items()
        ]
    return rows


def batch_rows(share: float) -> list[Row]:
    """Time and closure error of batches, `share` of their full size."""
    poses = max(int(10_000 * share), 50)
    cases = {
        "four-bar, random lengths": ("D", *random_lengths(100, max(int(1000 * share), 2))),
        "delta robot": ("P", *delta(poses)),
        "Stewart platform": ("P", *stewart(poses)),
    }
    rows = []
    for name, (point, linkage, drives) in cases.items():
        kept: list[Motion] = []

        def go(linkage: Linkage, drives: Drives, point: str, kept: list[Motion]) -> None:
            kept[:] = [linkage.move(drives)]
            kept[0].position(point)

        seconds = least_each({name: partial(go, linkage, drives, point, kept)}, 3)[name]
        (motion,) = kept
        assert (motion.closure_status == "regular").all()
        corners = np.concatenate([place.reshape(-1, 3) for place in linkage.points.values()])
        rows.append(
            {
                "linkage": name,
                "poses": motion.gap.size,
                "s": seconds,
                "us_per_pose": 1e6 * seconds / motion.gap.size,
                "closure_error": float(motion.gap.max() / np.ptp(corners, axis=0).max()),
            }
        )
    return rows


def long_rows(poses: int, repeats: int) -> list[Row]:
    """Time a pose of long batches with a point of it, by NumPy and as machine code, and how far these are apart."""
    cases = {name: ("D", described(links), {"A": np.linspace(-7.0, 9.0, poses)}) for name, links in LINKAGES.items()}
    cases["four-bar, rates"] = cases["four-bar"]
    cases |= {
        "Stewart platform, a tenth": ("P", *stewart(poses // 100)),
        "Stewart platform": ("P", *stewart(poses // 10)),
    }
    rows = []
    for name, (point, linkage, drives) in cases.items():
        rates = dict.fromkeys(drives, 1.0) if "rates" in name else None

        def go(
            backend: str, linkage: Linkage, drives: Drives, rates: dict[str, float] | None, point: str
        ) -> NDArray[np.float64]:
            with by(backend):
                motion = linkage.move(drives, rates=rates)
                return motion.position(point) if rates is None else motion.acceleration(point)

        calls = {each: partial(go, each, linkage, drives, rates, point) for each in backends()}
        found = {each: call() for each, call in calls.items()}
        apart = {each: float(np.abs(x - found[NUMPY]).max() / np.abs(x).max()) for each, x in found.items()}
        seconds, count = least_each(calls, repeats), len(found[NUMPY])
        rows += [
            {
                "linkage": name,
                "back end": each,
                "poses": count,
                "us_per_pose": 1e6 * seconds[each] / count,
                "difference": apart[each],
            }
            for each in calls
        ]
    return rows


def one_pose_rows(poses: int) -> list[Row]:
    """Time of a move to one pose with a point of it, of many in no order, and how far they are from a batch."""
    rng = np.random.default_rng(0)
    cases = {name: ("D", described(links), {"A": rng.uniform(0.0, 6.0, poses)}) for name, links in LINKAGES.items()}
    cases |= {"delta robot": ("P", *delta(poses)), "Stewart platform": ("P", *stewart(poses))}
    rows = []
    for name, (point, linkage, drives) in cases.items():
        order = rng.permutation(poses)
        given = [{drive: float(values[k]) for drive, values in drives.items()} for k in order]

        def go(linkage: Linkage, given: list[dict[str, float]], point: str) -> list[NDArray[np.float64]]:
            return [linkage.move(one).position(point) for one in given]

        seconds = least_each({name: partial(go, linkage, given, point)}, 5)[name]
        apart = np.abs(go(linkage, given, point) - linkage.move(drives).position(point)[order]).max()
        rows.append({"linkage": name, "ms": 1e3 * seconds / poses, "apart_from_batch": float(apart)})
    return rows


def chain_rows(stages: Sequence[int]) -> list[Row]:
    """Time of dead points and range of a scissor's foot, and their error: it is flat at -1.8, -0.8 and 0.2."""
    rows = []
    for count in stages:
        start = process_time()
        points = scissor(count).dead_points("slide")
        middle = process_time()
        reach = scissor(count).drive_range("slide")
        ends = [*(point.value for point in points), reach.lower, reach.upper]
        rows.append(
            {
                "links": 2 * count + 1,
                "dead_points_s": middle - start,
                "drive_range_s": process_time() - middle,
                "error": float(np.abs(np.subtract(ends, [-1.8, -0.8, 0.2, -1.8, 0.2])).max()),
            }
        )
    return rows


def random_lengths(poses: int, samples: int) -> tuple[Linkage, Drives]:
    """A four-bar whose bars vary by one part in a thousand, at all poses of a turn."""
    rng = np.random.default_rng(0)
    linkage = Linkage({name: (AT[name].real, AT[name].imag) for name in "ABDE"})
    for name, (start, end) in {"crank": "AB", "coupler": "BD", "rocker": "DE"}.items():
        scatter = 1.0 + 1e-3 * rng.standard_normal(samples)
        linkage.link(name, start, end, length=abs(AT[start] - AT[end]) * scatter)
    linkage.revolute("A", "ground", "crank", drive=True)
    linkage.revolute("B", "crank", "coupler")
    linkage.revolute("D", "coupler", "rocker")
    linkage.revolute("E", "rocker", "ground")
    return linkage, {"A": np.linspace(0.0, 2.0 * np.pi, poses)[:, None]}


def delta(poses: int) -> tuple[Linkage, Drives]:
    """Delta robot with two rods an arm, balls at their ends, its arms swinging out of step."""
    base, platform, arm, rod, width = 0.2, 0.05, 0.2, 0.5, 0.06
    heading = np.radians([0.0, 120.0, 240.0])
    outward = np.stack([np.cos(heading), np.sin(heading), np.zeros(3)], axis=-1)
    tangent = np.stack([-np.sin(heading), np.cos(heading), np.zeros(3)], axis=-1)
    height = np.sqrt(rod**2 - (base + arm - platform) ** 2)
    linkage = Linkage(P=(0.0, 0.0, -height))
    for k in range(3):
        linkage.point(f"A{k}", base * outward[k])
        for side, shift in {"l": -0.5, "r": 0.5}.items():
            linkage.point(f"B{k}{side}", (base + arm) * outward[k] + shift * width * tangent[k])
            linkage.point(f"C{k}{side}", platform * outward[k] + shift * width * tangent[k] - (0.0, 0.0, height))
    linkage.link("platform", "P", *(f"C{k}{side}" for k in range(3) for side in "lr"))
    for k in range(3):
        linkage.link(f"arm {k}", f"A{k}", f"B{k}l", f"B{k}r")
        linkage.revolute(f"A{k}", "ground", f"arm {k}", axis=tangent[k], drive=True)
        for side in "lr":
            linkage.link(f"rod {k}{side}", f"B{k}{side}", f"C{k}{side}")
            linkage.spherical(f"B{k}{side}", f"arm {k}", f"rod {k}{side}")
            linkage.spherical(f"C{k}{side}", f"rod {k}{side}", "platform")
    turn = np.linspace(0.0, 4.0 * np.pi, poses)
    return linkage, {f"A{k}": 0.3 + 0.3 * np.sin(turn + heading[k]) for k in range(3)}


def stewart(poses: int) -> tuple[Linkage, Drives]:
    """Stewart platform on six legs with universal joints below and balls above, led through places and turns."""
    ring = np.radians(np.repeat([90.0, 210.0, 330.0], 2) + np.array([[-15.0], [-45.0]]) * np.tile([1.0, -1.0], 3))
    corners = np.stack([np.cos(ring), np.sin(ring), np.zeros((2, 6))], axis=-1)
    feet, heads, home = corners[0], 0.6 * corners[1], np.array([0.0, 0.0, 1.1])
    linkage = Linkage(P=home)
    for k in range(6):
        for name, place in {"B": feet[k], "M": (feet[k] + home + heads[k]) / 2, "C": home + heads[k]}.items():
            linkage.point(f"{name}{k}", place)
    linkage.link("platform", "P", *(f"C{k}" for k in range(6)))
    for k in range(6):
        leg = home + heads[k] - feet[k]
        across = np.cross(leg, (0.0, 0.0, 1.0))
        linkage.link(f"cylinder {k}", f"B{k}", f"M{k}")
        linkage.link(f"piston {k}", f"M{k}", f"C{k}")
        linkage.universal(f"B{k}", "ground", f"cylinder {k}", axis=across, second=np.cross(across, leg))
        linkage.prismatic(f"M{k}", f"cylinder {k}", f"piston {k}", axis=leg, drive=True, reference=np.linalg.norm(leg))
        linkage.spherical(f"C{k}", f"piston {k}", "platform")
    wave = np.sin(np.outer(np.linspace(0.0, 2.0 * np.pi, poses), [1, 2, 3]))
    turn = Rotation.from_rotvec(wave[:, ::-1] * (0.2, 0.15, 0.3)).as_matrix()
    tips = (home + wave * (0.15, 0.1, 0.1))[:, None] + np.einsum("nij,kj->nki", turn, heads)
    lengths = np.linalg.norm(tips - feet, axis=-1)
    return linkage, {f"M{k}": lengths[:, k] for k in range(6)}


def sweep_targets(rows: Sequence[Row]) -> list[Target]:
    """Faster than the interpreted way of pylinkage, and closed to rounding."""
    found = []
    for linkage in LINKAGES:
        ms = {row["contender"]: row["ms"] for row in rows if row["linkage"] == linkage}
        if STEPPED in ms:
            told = f"{ms[OURS]:.2f} ms against {ms[STEPPED]:.2f} ms; described anew {ms[ANEW]:.1f} ms"
            met = ms[OURS] < ms[STEPPED]
            found.append(Target("8 kinematics", f"{linkage}, 360 poses: faster than {STEPPED}", told, met))
    worst = max(row["closure_error"] for row in rows if row["contender"] == OURS)
    found.append(Target("8 kinematics", "sweeps: closure error below 1e-13", f"{worst:.1e}", worst < ERROR))
    return found


def batch_targets(rows: Sequence[Row]) -> list[Target]:
    """Seconds and closure of the batches."""
    return [
        Target(
            "8 kinematics",
            f"{row['linkage']}, {row['poses']} poses: below {LIMITS[row['linkage']]:g} s, closure below 1e-13",
            f"{row['s']:.2f} s, {row['closure_error']:.1e}",
            row["s"] < LIMITS[row["linkage"]] and row["closure_error"] < ERROR,
        )
        for row in rows
    ]


def long_targets(rows: Sequence[Row]) -> list[Target]:
    """Microseconds of a pose of long batches; places and rates to rounding the same."""
    return [
        Target(
            "8 kinematics",
            f"{row['linkage']}, {row['back end']}, {row['poses']} poses: below "
            f"{LONG[row['linkage']][row['back end'] == COMPILED]:g} us, as by NumPy to 1e-13",
            f"{row['us_per_pose']:.3f} us, {row['difference']:.1e}",
            row["us_per_pose"] < LONG[row["linkage"]][row["back end"] == COMPILED] and row["difference"] < 1e-13,
        )
        for row in rows
    ]


def one_pose_targets(rows: Sequence[Row]) -> list[Target]:
    """Milliseconds of one pose, of which a control loop has 1 in all."""
    return [
        Target(
            "8 kinematics",
            f"{row['linkage']}, one pose with a point: below {ONE_POSE[row['linkage']]:g} ms, as in a batch to 1e-14",
            f"{row['ms']:.3f} ms, {row['apart_from_batch']:.1e}",
            row["ms"] < ONE_POSE[row["linkage"]] and row["apart_from_batch"] < 1e-14,
        )
        for row in rows
    ]


def chain_targets(rows: Sequence[Row]) -> list[Target]:
    """Time grows with the links."""
    first, last = rows[0], rows[-1]
    grown = last["links"] / first["links"]
    found = []
    for what in ("dead_points", "drive_range"):
        power = float(np.log(last[f"{what}_s"] / first[f"{what}_s"]) / np.log(grown))
        told = f"{last[f'{what}_s']:.2f} s at {last['links']} links, links^{power:.2f}, {last['error']:.1e}"
        met = power < POWER and last["error"] < 1e-9
        bound = "each stage adds to the length of the way too: its steps grow as the root of the links"
        found.append(Target("8 kinematics", f"{what} of a scissor: time below links^{POWER:g}", told, met, bound))
    return found


def draw(out: Path, sweeps: Sequence[Row], batches: Sequence[Row]) -> None:
    """Time of the sweeps by contender, and the batches' time a pose, each with its closure error."""
    names = list(dict.fromkeys(row["contender"] for row in sweeps))
    with figure(out, "kinematics", columns=2, width=5.0, height=3.0) as (left, right):
        for colour, (shift, linkage) in zip(COLOURS, ((-0.2, "four-bar"), (0.2, "six-bar")), strict=False):
            rows = {row["contender"]: row for row in sweeps if row["linkage"] == linkage}
            times = [rows[name]["ms"] for name in names]
            told = [f"{rows[name]['ms']:.2g} ms, {rows[name]['closure_error']:.0e}" for name in names]
            bars(left, np.arange(len(names)) + shift, times, told, height=0.38, color=colour, label=linkage)
        left.set_yticks(range(len(names)), names)
        left.set(xscale="log", xlim=(0.03, 400.0), xlabel="ms", title="a turn of the crank, 360 poses; closure error")
        left.legend(loc="lower right", bbox_to_anchor=(1.0, 0.22))
        told = [f"{row['us_per_pose']:.2g} µs, {row['closure_error']:.0e}" for row in batches]
        bars(
            right, np.arange(len(batches)), [row["us_per_pose"] for row in batches], told, height=0.5, color=COLOURS[2]
        )
        right.set_yticks(range(len(batches)), [f"{row['linkage']}\n{row['poses']} poses" for row in batches])
        right.set(xscale="log", xlim=(0.03, 2000.0), xlabel="µs a pose", title="batches in linkframe; closure error")
        for axes in (left, right):
            axes.invert_yaxis()


def bars(axes: Axes, at: NDArray[np.float64], widths: Sequence[float], told: Sequence[str], **style: object) -> None:
    """Horizontal bars, each with what it tells behind it."""
    axes.barh(at, widths, **style)
    for height, width, text in zip(at, widths, told, strict=True):
        axes.annotate(text, (width, height), (3, 0), textcoords="offset points", va="center", fontsize=8)


if __name__ == "__main__":
    main("kinematics", run)
