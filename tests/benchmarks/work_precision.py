"""Benchmark 6, run time against error: meshes for frequencies, tapers and line loads; samples; stiff joints."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from itertools import pairwise
from math import log
from pathlib import Path
from time import process_time

import numpy as np
from linkframe.elements import Beam, Material, Rectangle, Section
from linkframe.framework import Frame
from linkframe.models import propagate
from numpy.typing import NDArray
from reference.compare import allowed
from reference.four_bar import JOINTS
from reference.stiffness_method import mp

from .harness import COLOURS, Row, Target, figure, least_each, main, slope, write
from .job import Job, error, job
from .monte_carlo import INPUTS, displacement, mean
from .stacked import Stacked

Array = NDArray[np.float64]

LENGTH, STEEL = 1.8, Material(E=210e9, nu=0.3, density=7800.0)
COUNTS = (1, 2, 4, 8, 16, 32, 64)
DEEP, SHALLOW, WIDE = 0.06, 0.024, 0.03
BAR = Section(A=8e-4, Iy=4e-8, Iz=6e-8, J=8e-8)
FIRST, LAST = 300.0, 900.0
# So thin that rotary inertia, which the closed form leaves out, is below 1e-10.
WIRE = Section(A=1e-4, Iy=1e-14, Iz=1e-14, J=1e-14)
PLANE = ("ux", "uz", "rx", "ry")
TIP, MIDDLE = "tip", LENGTH / 2.0


def run(out: Path, quick: bool) -> list[Target]:
    """Run time against error of meshes, samplers and assemblies."""
    meshes = mesh_rows(COUNTS[:5] if quick else COUNTS, 3 if quick else 9)
    samples = sample_rows(range(7, 12 if quick else 17, 1 if quick else 3), seeds=4 if quick else 8)
    joints = joint_rows(361, 3)
    for name, rows in (("meshes", meshes), ("samplers", samples), ("joints", joints)):
        write(out, f"work_precision_{name}", rows)
    draw_meshes(out, meshes)
    draw_samples(out, samples)
    draw_joints(out, joints)
    return [*mesh_targets(meshes), *sample_targets(samples), joint_target(joints)]


# -- meshes -----------------------------------------------------------------------------------------------------------


def beams(sections: list[tuple[Section | Rectangle, Section | Rectangle | None]], held: tuple[str, ...] = ()) -> Frame:
    """A cantilever of equal beams of given start and end sections; its nodes are 0, 1, ... and the tip."""
    frame, count = Frame(), len(sections)
    names = [*map(str, range(count)), TIP]
    for k, name in enumerate(names):
        frame.node(name, (LENGTH * k / count, 0.0, 0.0))
        if held and k:
            frame.fix(name, *held)
    for k, (start, end) in enumerate(sections):
        frame.add(f"beam {k}", Beam(start, STEEL, end=end), names[k], names[k + 1])
    frame.fix("0")
    return frame


def frequencies(count: int) -> float:
    """Worst relative error of the first three frequencies, from so many beams."""
    found = beams([(WIRE, None)] * count, PLANE).modes(min(3, 2 * count)).frequencies
    roots = np.array([mp.findroot(lambda x: mp.cos(x) + 1 / mp.cosh(x), (k + 0.5) * mp.pi) for k in range(len(found))])
    inertia = mp.sqrt(mp.mpf(STEEL.E) * mp.mpf(WIRE.Iz) / (mp.mpf(STEEL.density) * mp.mpf(WIRE.A)))
    exact = roots**2 * inertia / (2 * mp.pi * mp.mpf(LENGTH) ** 2)
    return float(np.abs(found / exact.astype(np.float64) - 1.0).max())


def tapered(count: int) -> float:
    """Error of the tip of a wedge, from beams that are wedges themselves."""
    depth = np.linspace(DEEP, SHALLOW, count + 1)
    return wedge_error([(Rectangle(y=a, z=WIDE), Rectangle(y=b, z=WIDE)) for a, b in pairwise(depth)])


def stepped(count: int) -> float:
    """Error of the tip of a wedge, from prismatic beams of its depth half-way, the usual way."""
    depth = DEEP + (SHALLOW - DEEP) * (np.arange(count) + 0.5) / count
    return wedge_error([(Rectangle(y=each, z=WIDE), None) for each in depth])


def wedge_error(sections: list[tuple[Rectangle, Rectangle | None]]) -> float:
    """Against 12 c^3 (-ln s - 3/2 + 2 s - s^2/2) F/(E b) with c = L/(h0 - h1), s = h1/h0: elementary integration."""
    frame = beams(list(sections))
    frame.load(TIP, fy=20.0)
    c, s = LENGTH / (DEEP - SHALLOW), SHALLOW / DEEP
    exact = 20.0 * 12.0 * c**3 * (-log(s) - 1.5 + 2.0 * s - s**2 / 2.0) / (STEEL.E * WIDE)
    return abs(float(frame.solve().displacement(TIP)[1]) / exact - 1.0)


def line_load(count: int) -> float:
    """Error under a line load, given as such to the beams: at the middle and at the tip."""
    frame = beams([(BAR, None)] * count)
    force = np.linspace(FIRST, LAST, count + 1).tolist()
    for k in range(count):
        frame.line_load(f"beam {k}", fy=(force[k], force[k + 1]))
    return deflection_error(frame, count)


def lumped(count: int) -> float:
    """Error under a line load, given as forces on the nodes, the usual way."""
    frame, step = beams([(BAR, None)] * count), LENGTH / count
    names = [*map(str, range(count)), TIP]
    force = np.linspace(FIRST, LAST, count + 1)
    for k in range(count):
        frame.load(names[k], fy=step * (2.0 * force[k] + force[k + 1]) / 6.0)
        frame.load(names[k + 1], fy=step * (force[k] + 2.0 * force[k + 1]) / 6.0)
    return deflection_error(frame, count)


def deflection_error(frame: Frame, count: int) -> float:
    """Against q x^2 (6 L^2 - 4 L x + x^2)/24EI and q x^2 (20 L^3 - 10 L^2 x + x^3)/120LEI, which one integrates."""

    def exact(x: float) -> float:
        even = FIRST * x**2 * (6 * LENGTH**2 - 4 * LENGTH * x + x**2) / 24
        rising = (LAST - FIRST) * x**2 * (20 * LENGTH**3 - 10 * LENGTH**2 * x + x**3) / (120 * LENGTH)
        return float((even + rising) / (STEEL.E * BAR.Iz))

    solution, at = frame.solve(), LENGTH / count
    beam = int(MIDDLE / at)
    middle = solution.displacement_along(f"beam {beam}", [MIDDLE - beam * at])[0, 1]
    pairs = ((float(middle), exact(MIDDLE)), (float(solution.displacement(TIP)[1]), exact(LENGTH)))
    return max(abs(found / wanted - 1.0) for found, wanted in pairs)


# Name of the problem and of the way.
MESHES: dict[tuple[str, str], Callable[[int], float]] = {
    ("frequencies", "consistent mass"): frequencies,
    ("taper", "tapered beams"): tapered,
    ("taper", "stepped beams (usual)"): stepped,
    ("line load", "line load"): line_load,
    ("line load", "forces on nodes (usual)"): lumped,
}


def mesh_rows(counts: tuple[int, ...], repeats: int) -> list[Row]:
    """A row for each problem, way and number of beams."""
    errors: dict[tuple[str, str, int], float] = {}

    def keep(key: tuple[str, str], count: int) -> None:
        errors[(*key, count)] = MESHES[key](count)

    each = [(key, count) for key in MESHES for count in counts]
    seconds = least_each({str(one): partial(keep, *one) for one in each}, repeats)
    return [
        {
            "problem": key[0],
            "way": key[1],
            "beams": count,
            "milliseconds": 1e3 * seconds[str((key, count))],
            "error": errors[(*key, count)],
        }
        for key, count in each
    ]


def mesh_targets(rows: list[Row]) -> list[Target]:
    """One element is exact for tapers and line loads; frequencies converge with the fourth power."""
    found = {(row["way"], row["beams"]): row["error"] for row in rows}
    several = [row for row in rows if row["problem"] == "frequencies" and row["beams"] >= 8]
    power = slope([row["beams"] for row in several], [row["error"] for row in several])
    targets = []
    for way, usual in (("tapered beams", "stepped beams (usual)"), ("line load", "forces on nodes (usual)")):
        most = max(row["beams"] for row in rows)
        told = f"{found[way, 1]:.1g} with one beam ({usual}: {found[usual, most]:.1g} with {most})"
        targets.append(Target("6 work-precision", f"{way}: one beam is exact", told, found[way, 1] < 1e-12))
    told = f"error ~ beams^{power:.2f}"
    return [*targets, Target("6 work-precision", "frequencies: error ~ beams^-4", told, abs(power + 4.0) < 0.3)]


def draw_meshes(out: Path, rows: list[Row]) -> None:
    """Error over beams and over time."""
    with figure(out, "work_precision_meshes", columns=2, width=4.2, height=3.4) as (left, right):
        for k, (key, colour) in enumerate(zip(MESHES, COLOURS, strict=False)):
            found = [row for row in rows if (row["problem"], row["way"]) == key]
            errors = [max(row["error"], 1e-17) for row in found]
            style = {"color": colour, "marker": "osD^v"[k], "label": ": ".join(key)}
            left.plot([row["beams"] for row in found], errors, **style)
            right.plot([row["milliseconds"] for row in found], errors, **style)
        counts = sorted({row["beams"] for row in rows})
        left.set(xlabel="beams", xscale="log", xticks=counts, xticklabels=counts, yscale="log")
        left.set_ylabel("relative error (1e-17 for none)")
        right.set(xlabel="time, from description to result / ms", xscale="log", yscale="log")
        left.minorticks_off()
        right.figure.legend(*left.get_legend_handles_labels(), loc="outside lower center", ncols=3, fontsize=8)


# -- samples ----------------------------------------------------------------------------------------------------------


def sample_rows(powers: range, seeds: int) -> list[Row]:
    """A row for each sampler and number of samples 2^p: root mean square, over seeds, of the error of the mean."""
    exact, rows = mean(), []
    for sampler in ("random", "lhs", "sobol"):
        for power in powers:
            n, errors, seconds = 2**power, [], float("inf")
            for seed in range(seeds):
                start = process_time()
                found = propagate(displacement, INPUTS, n=n, rng=seed, sampler=sampler, progress=False).mean
                seconds = min(seconds, process_time() - start)
                errors.append(np.abs(found / exact - 1.0).max())
            rms = float(np.sqrt(np.mean(np.square(errors))))
            rows.append({"sampler": sampler, "samples": n, "milliseconds": 1e3 * seconds, "rms_error": rms})
    return rows


def sample_targets(rows: list[Row]) -> list[Target]:
    """Random samples converge with the square root; the others are to beat them."""
    told, last = {}, {}
    for sampler in ("random", "lhs", "sobol"):
        found = [row for row in rows if row["sampler"] == sampler]
        power = slope([row["samples"] for row in found], [row["rms_error"] for row in found])
        told[sampler], last[sampler] = f"{sampler} ~ n^{power:.2f}", found[-1]["rms_error"]
    most = max(row["samples"] for row in rows)
    errors = ", ".join(f"{sampler} {value:.1g}" for sampler, value in last.items())
    met = max(last["lhs"], last["sobol"]) < last["random"]
    name = "Sobol and Latin samples beat random ones"
    return [Target("6 work-precision", name, f"{', '.join(told.values())}; at n = {most}: {errors}", met)]


def draw_samples(out: Path, rows: list[Row]) -> None:
    """Error over samples and over time."""
    with figure(out, "work_precision_samplers", columns=2, width=3.8, height=3.2) as (left, right):
        for k, sampler in enumerate(("random", "lhs", "sobol")):
            found = [row for row in rows if row["sampler"] == sampler]
            errors = [row["rms_error"] for row in found]
            style = {"color": COLOURS[k], "marker": "osD"[k], "label": sampler}
            left.plot([row["samples"] for row in found], errors, **style)
            right.plot([row["milliseconds"] for row in found], errors, **style)
        left.set(xlabel="samples", xscale="log", yscale="log", ylabel="relative error of the mean, rms over seeds")
        right.set(xlabel="time / ms", xscale="log", yscale="log")
        left.legend()


# -- joints -----------------------------------------------------------------------------------------------------------

STIFFNESSES = 10.0 ** np.arange(19)


def stiff_job(poses: int) -> Job:
    """The job in the plane with every spring of every joint at 1, 10, ... 10^18, without clearance."""
    work = job(poses, len(STIFFNESSES), space=False)
    springs = STIFFNESSES[:, None] * (1.0, 1.0, 1.0, 1.0, 1.0, 0.0)
    load = np.broadcast_to((10.0, 100.0, 0.0, 0.0, 0.0, 0.0), work.load.shape)
    none = np.zeros((len(STIFFNESSES), 2))
    return replace(work, stiffness=dict.fromkeys(JOINTS, springs), offset=dict.fromkeys(JOINTS, none), load=load)


def joint_rows(poses: int, repeats: int) -> list[Row]:
    """A row for each stiffness: worst errors at three poses of the usual assembly and of joint-relative coordinates."""
    work, checked = stiff_job(poses), [poses // 7, poses // 3, (5 * poses) // 6]
    exact = np.array([[work.truth(pose, k) for k in range(len(STIFFNESSES))] for pose in checked])
    results: dict[str, Array] = {}

    def usual() -> None:
        results["usual"] = Stacked(work).solve()

    def relative() -> None:
        results["relative"] = work.frame().solve().displacement("P")

    seconds = least_each({"usual": usual, "relative": relative}, repeats)
    errors = {name: error(found[checked], exact).max(axis=0) for name, found in results.items()}
    kappa = work.part(checked, len(STIFFNESSES)).frame().solve().scaled_condition_number().max(axis=0)
    return [
        {
            "stiffness": float(k),
            "error_usual": float(errors["usual"][i]),
            "error_joint_relative": float(errors["relative"][i]),
            "kappa_scaled": float(kappa[i]),
            "us_usual": 1e6 * seconds["usual"] / work.size,
            "us_joint_relative": 1e6 * seconds["relative"] / work.size,
        }
        for i, k in enumerate(STIFFNESSES)
    ]


def joint_target(rows: list[Row]) -> Target:
    """Joint-relative coordinates keep all digits, however stiff the joint; with soft ones the links' own are lost."""
    met = all(row["error_joint_relative"] <= allowed(row["kappa_scaled"]) for row in rows)
    stiff = [row for row in rows if row["stiffness"] >= 1e3]
    ours, theirs = (max(row[f"error_{way}"] for row in stiff) for way in ("joint_relative", "usual"))
    soft = rows[0]
    told = f"at most {ours:.1g} from 10^3 to 10^18 (usual: {theirs:.1g}); {soft['error_joint_relative']:.1g} at 1 "
    told += f"(usual: {soft['error_usual']:.1g}; kappa_scaled {soft['kappa_scaled']:.1g})"
    return Target("6 work-precision", "joint-relative: 1e-12, or 100 eps kappa_scaled above kappa = 10^4", told, met)


def draw_joints(out: Path, rows: list[Row]) -> None:
    """Error over stiffness."""
    k = [row["stiffness"] for row in rows]
    with figure(out, "work_precision_joints", width=4.6, height=3.4) as (ax,):
        for colour, way, told in zip(COLOURS, ("joint_relative", "usual"), ("joint-relative", "usual"), strict=False):
            unit = rows[0][f"us_{way}"]
            label = f"{told} assembly, {unit:.2g} µs per entry"
            ax.plot(k, [row[f"error_{way}"] for row in rows], "o-", color=colour, label=label)
        ax.set(xlabel="stiffness of the joints / (N/m, Nm)", xscale="log", yscale="log", ylim=(1e-17, 1e2))
        ax.set_ylabel("worst relative error against 50 digits")
        ax.legend(loc="upper left")


if __name__ == "__main__":
    main("work_precision", run)
