"""Benchmark 9, large displacement: a batch of nonlinear equilibria of the four-bar, and the programs that do one each.

Error of the displacement of P is that against rods met by shooting (reference.rod_four_bar), at a few of the entries.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from pathlib import Path
from unittest.mock import patch

import numpy as np
from linkframe.elements import Beam, Material, Rectangle
from linkframe.framework import Frame
from linkframe.framework.large.solution import LargeSolution
from linkframe.framework.program import machine_code
from linkframe.models import FourBar
from numpy.typing import NDArray
from reference.rod_four_bar import FORCE, PIN, E, L, Y, Z, shot

from .harness import COLOURS, Row, Target, figure, importable, least_each, main, write

Array = NDArray[np.float64]
OURS, SPACE, FEW = "linkframe, plane", "linkframe, space", "linkframe, plane, few"
ARRAYS, ARRAYS_IN_SPACE = "linkframe, plane, without machine code", "linkframe, space, without machine code"
EXUDYN, OPENSEES = "exudyn, planar cables, reused", "openseespy, corotational, plane"


@dataclass(frozen=True)
class Cases:
    """Poses in degrees (poses,), and for every sample force and stiffness of the pins (samples,)."""

    theta: Array
    force: Array
    pin: Array

    @classmethod
    def of(cls, poses: int, samples: int) -> Cases:
        """Poses from 1 to 170 degrees; force and stiffness as in the accuracy paper."""
        rng = np.random.default_rng(5)
        force = FORCE * (1.0 + 0.05 * rng.standard_normal(samples))
        pin = PIN * (1.0 + 0.05 * rng.standard_normal(samples))
        return cls(np.geomspace(1.0, 170.0, poses), force, pin)

    def frame(self, segments: int, across: float = 0.0) -> Frame:
        """The linkage at all poses and samples; a force `across` makes it one in space."""
        beam = Beam(Rectangle(y=Y, z=Z), Material(E=E, nu=0.3), segments=segments)
        stiffness = np.append(np.ones(5), 0.0) * self.pin[:, None]
        frame = FourBar(beam=beam, stiffness=stiffness).move(np.radians(self.theta)[:, None]).frame()
        frame.load("P", fy=self.force)
        if across:
            frame.load("P", fz=across)
        return frame


def linkframe(cases: Cases, segments: int, across: float = 0.0) -> Array:
    """Displacement of P (poses, samples, 2)."""
    return cases.frame(segments, across).solve(large=True).displacement("P")[..., :2]


def by_arrays(cases: Cases, segments: int, across: float = 0.0) -> Array:
    """The same where llvmlite is not installed."""
    with patch.object(machine_code, "available", lambda: False):
        return linkframe(cases, segments, across)


def opensees(cases: Cases, segments: int) -> Array:
    """OpenSees, corotational, in the plane, a model for every entry."""
    import openseespy.opensees as ops

    found = np.zeros((len(cases.theta), len(cases.force), 2))
    for pose, sample in np.ndindex(*found.shape[:2]):
        ops.wipe()
        ops.logFile(os.devnull, "-noEcho")
        ops.model("basic", "-ndm", 2, "-ndf", 3)
        ops.geomTransf("Corotational", 1)
        tag = iter(range(1, 10_000))
        ends = [
            [_opensees_node(ops, place, next(tag)) for place in np.linspace(a, b, n * segments + 1)]
            for a, b, n in _links(cases.theta[pose])
        ]
        ground = _opensees_node(ops, np.array([2.0 * L, 0.0]), next(tag))
        for node in (ends[0][0], ground):
            ops.fix(node, 1, 1, 1)
        for chain in ends:
            for a, b in pairwise(chain):
                ops.element("elasticBeamColumn", next(tag), a, b, Y * Z, E, Z * Y**3 / 12.0, 1)
        ops.uniaxialMaterial("Elastic", 1, float(cases.pin[sample]))
        for a, b in ((ends[0][-1], ends[1][0]), (ends[1][-1], ends[2][0]), (ends[2][-1], ground)):
            ops.element("zeroLength", next(tag), a, b, "-mat", 1, 1, "-dir", 1, 2)
        ops.timeSeries("Linear", 1)
        ops.pattern("Plain", 1, 1)
        middle = ends[1][segments]
        ops.load(middle, 0.0, float(cases.force[sample]), 0.0)
        ops.constraints("Plain")
        ops.numberer("RCM")
        ops.system("BandGeneral")
        ops.test("NormDispIncr", 1e-10, 50)
        ops.algorithm("Newton")
        ops.integrator("LoadControl", 1.0)
        ops.analysis("Static", "-noWarnings")
        found[pose, sample] = _opensees_solved(ops, middle)
    ops.wipe()
    return found


def _opensees_node(ops: object, place: Array, tag: int) -> int:
    ops.node(tag, *place.tolist())  # type: ignore[attr-defined]
    return tag


def _opensees_solved(ops: object, node: int) -> list[float]:
    if ops.analyze(1):  # type: ignore[attr-defined]
        return [np.nan, np.nan]
    moved: list[float] = ops.nodeDisp(node)  # type: ignore[attr-defined]
    return moved[:2]


def exudyn(cases: Cases, segments: int) -> Array:
    """Exudyn, planar cable elements (ANCF): a model for every pose, in which force and pins change by sample."""
    import exudyn as exu

    found = np.zeros((len(cases.theta), len(cases.force), 2))
    settings = exu.SimulationSettings()
    settings.staticSolver.numberOfLoadSteps = 1
    settings.staticSolver.verboseMode = 0
    settings.staticSolver.newton.relativeTolerance = 1e-6
    settings.solution.file.write = False
    for pose, theta in enumerate(cases.theta):
        model = _Exudyn(float(theta), segments)
        for sample, (force, pin) in enumerate(zip(cases.force, cases.pin, strict=True)):
            found[pose, sample] = model.solve(settings, float(force), float(pin))
    return found


class _Exudyn:
    """The linkage, turned so that the crank lies along x and its clamp can be told exactly."""

    def __init__(self, theta: float, segments: int) -> None:
        import exudyn as exu
        import exudyn.itemInterface as items
        from exudyn.beams import GenerateStraightLineANCFCable2D

        self.container = exu.SystemContainer()
        self.system = self.container.AddSystem()
        angle = np.radians(theta)
        c, s = np.cos(angle), np.sin(angle)
        self.turn = np.array([[c, s], [-s, c]])
        cable = items.Cable2D(
            physicsMassPerLength=1.0,
            physicsBendingStiffness=E * Z * Y**3 / 12.0,
            physicsAxialStiffness=E * Y * Z,
            useReducedOrderIntegration=0,
        )
        nodes = []
        for k, (a, b, n) in enumerate(_links(theta)):
            clamp = [1, 1, 0, 1] if k == 0 else [0, 0, 0, 0]
            ends = [[*(self.turn @ p), 0.0] for p in (a, b)]
            made = GenerateStraightLineANCFCable2D(
                self.system, *ends, n * segments, cable, [0, 0, 0], clamp, [0, 0, 0, 0]
            )
            nodes.append(made[0])
        ground = self.system.AddObject(items.ObjectGround())
        place = [*(self.turn @ np.array([2.0 * L, 0.0])), 0.0]
        fixed = self.system.AddMarker(items.MarkerBodyPosition(bodyNumber=ground, localPosition=place))
        first = [self._marker(chain[-1]) for chain in nodes]
        second = [self._marker(nodes[1][0]), self._marker(nodes[2][0]), fixed]
        self.pins = [
            self.system.AddObject(items.CartesianSpringDamper(markerNumbers=[a, b], stiffness=[1, 1, 0]))
            for a, b in zip(first, second, strict=True)
        ]
        self.middle = nodes[1][segments]
        self.load = self.system.AddLoad(items.Force(markerNumber=self._marker(self.middle), loadVector=[0, 1, 0]))
        self.system.Assemble()

    def _marker(self, node: int) -> int:
        import exudyn.itemInterface as items

        return int(self.system.AddMarker(items.MarkerNodePosition(nodeNumber=node)))

    def solve(self, settings: object, force: float, pin: float) -> Array:
        """Displacement of P from rest, NaN where the solver gives up."""
        import exudyn as exu

        for each in self.pins:
            self.system.SetObjectParameter(each, "stiffness", [pin, pin, 0.0])
        self.system.SetLoadParameter(self.load, "loadVector", [*(self.turn @ np.array([0.0, force])), 0.0])
        try:
            self.system.SolveStatic(settings)
        except exu.SolverError:
            return np.full(2, np.nan)
        moved = self.system.GetNodeOutput(self.middle, exu.OutputVariableType.Displacement)
        return np.asarray(self.turn.T @ moved[:2])


def _links(theta: float) -> list[tuple[Array, Array, int]]:
    """Ends of crank, coupler and rocker, and how many lengths L each has."""
    angle = np.radians(theta)
    tip = L * np.array([np.cos(angle), np.sin(angle)])
    far, ground = np.array([2.0 * L, 0.0]) + tip, np.array([2.0 * L, 0.0])
    return [(np.zeros(2), tip, 1), (tip, far, 2), (far, ground, 1)]


Way = Callable[[Cases, int], Array]


def ways() -> dict[str, tuple[Way, tuple[int, ...], tuple[int, int]]]:
    """By contender: how, pieces a length L, and how many poses and samples it is given."""
    found: dict[str, tuple[Way, tuple[int, ...], tuple[int, int]]] = {
        OURS: (linkframe, (1, 2), (181, 200)),
        FEW: (linkframe, (1, 2), (7, 10)),
        SPACE: (partial(linkframe, across=1e-3), (1,), (181, 200)),
        ARRAYS: (by_arrays, (1, 2), (37, 40)),
        ARRAYS_IN_SPACE: (partial(by_arrays, across=1e-3), (1, 2), (37, 40)),
    }
    if not machine_code.available():
        found[SPACE] = (*found[SPACE][:2], (37, 40))
    if importable("exudyn"):
        found[EXUDYN] = (exudyn, (1, 2, 4), (7, 10))
    if importable("openseespy.opensees"):
        found[OPENSEES] = (opensees, (1, 4, 16), (7, 3))
    return found


def worst(way: Way, segments: int) -> float:
    """Largest relative error at three poses."""
    cases = Cases(np.array([1.0, 5.0, 60.0]), np.array([FORCE]), np.array([PIN]))
    found = way(cases, segments)[:, 0]
    near = cases.frame(2).solve(large=True)
    return max(
        float(np.abs(moved - exact).max() / np.abs(exact).max())
        for moved, exact in zip(found, (truth(near, k, theta) for k, theta in enumerate(cases.theta)), strict=True)
    )


def truth(near: LargeSolution, entry: int, theta: float) -> Array:
    """Displacement of P by shooting from a first guess."""
    reaction = -near.reaction("A")[entry, 0]
    turns = (near.displacement(node)[entry, 0, 5] for node in ("B.coupler", "D.rocker"))
    return shot(theta, np.array([*reaction[:2], reaction[5], *turns]))


def rows(quick: bool) -> list[Row]:
    """A row for each contender and number of pieces."""
    found: list[Row] = []
    for name, (way, counts, (poses, samples)) in ways().items():
        cases = Cases.of(3 if quick else poses, 2 if quick else samples)
        size = len(cases.theta) * len(cases.force)
        for segments in counts[:1] if quick else counts:
            seconds = least_each({name: lambda way=way, cases=cases, n=segments: way(cases, n)}, 1 if quick else 3)
            steps = float("nan")
            if name.startswith("linkframe"):
                frame = cases.frame(segments, across=1e-3 * (name in (SPACE, ARRAYS_IN_SPACE)))
                steps = float(frame.solve(large=True).iterations.mean())
            each = 1e6 * seconds[name] / size
            error = worst(way, segments)
            found.append(
                {
                    "contender": name,
                    "pieces": segments,
                    "microseconds": each,
                    "newton steps": steps,
                    "microseconds a step": each / steps,
                    "error": error,
                }
            )
    return found


def run(out: Path, quick: bool) -> list[Target]:
    """Time and error of a batch of nonlinear equilibria."""
    found = rows(quick)
    write(out, "large_displacement", found)
    draw(out, found)
    return targets(found)


def targets(found: list[Row]) -> list[Target]:
    """Twenty times faster than exudyn at equal error, with one piece a member and with two, and ahead of it for few."""
    ours = [row for row in found if row["contender"] == OURS]
    told = f"{ours[0]['microseconds']:.3g} us, error {ours[0]['error']:.1g}"
    out = [Target("9 large displacement", "one piece a member: error below 1e-5", told, ours[0]["error"] < 1e-5)]
    for space in [row for row in found if row["contender"] == SPACE][:1]:
        ratio = space["microseconds"] / ours[0]["microseconds"]
        told = f"{ratio:.3g} times ({space['microseconds']:.3g} us)"
        out.append(
            Target("9 large displacement", "in space at most three times the time in the plane", told, ratio <= 3.0)
        )
    for mine, peer, wanted in ((OURS, EXUDYN, 20.0), (FEW, EXUDYN, 1.0), (OURS, OPENSEES, 10.0)):
        rivals, own = ([row for row in found if row["contender"] == name] for name in (peer, mine))
        if rivals and own:
            out.append(_faster(own, rivals, wanted))
    return out


def _faster(ours: list[Row], rivals: list[Row], wanted: float) -> Target:
    """How many times faster we are than the rivals at equal error."""
    pairs = [(row, _rival(row, rivals)) for row in ours]
    times = [rival["microseconds"] / row["microseconds"] for row, rival in pairs]
    each = [
        f"{t:.3g} times ({row['microseconds']:.3g} against {rival['microseconds']:.3g} us, "
        f"errors {row['error']:.1g} and {rival['error']:.1g})"
        for t, (row, rival) in zip(times, pairs, strict=True)
    ]
    what = f"{ours[0]['contender']}: {wanted:g} times faster than {rivals[0]['contender']}"
    return Target("9 large displacement", what, "; ".join(each), min(times) >= wanted)


def _rival(ours: Row, rivals: list[Row]) -> Row:
    """The fastest that is as exact as we are, or the most exact."""
    equal = [row for row in rivals if row["error"] <= 1.5 * ours["error"]]
    return min(equal, key=lambda row: row["microseconds"]) if equal else min(rivals, key=lambda row: row["error"])


def draw(out: Path, found: list[Row]) -> None:
    """Error over time."""
    with figure(out, "large_displacement") as (axes,):
        for colour, name in zip(COLOURS, dict.fromkeys(row["contender"] for row in found), strict=False):
            mine = [row for row in found if row["contender"] == name]
            axes.plot([r["microseconds"] for r in mine], [r["error"] for r in mine], "o-", color=colour, label=name)
        axes.set(xlabel="µs per pose and sample", xscale="log", ylabel="relative error", yscale="log", xlim=(0.5, 3e4))
        axes.xaxis.set_minor_formatter("")
        axes.legend(fontsize=8)


if __name__ == "__main__":
    main("large_displacement", run)
