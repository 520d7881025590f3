"""Benchmark 1c, a four-bar of which everything is random, one pose a sample: E of each link, all four lengths, drive
angle, joint stiffness, clearance and load. Beside linkframe NumPy's stacked matrices and Numba's dense Cholesky.

All begin with the same numbers and end with the displacement of P. The peers place the points by the closed form and
add stiffness times clearance to the loads; linkframe describes the linkage, moves it, makes its frame and solves. In
place it has one frame, as in the loop of an optimiser: it places the points like the peers, changes the numbers of the
frame, and solves.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from itertools import cycle
from pathlib import Path
from unittest.mock import patch

import numpy as np
from linkframe.elements import Beam, Joint, Material
from linkframe.framework import Frame
from linkframe.framework.program import machine_code
from linkframe.models import FourBar
from numpy.typing import NDArray
from reference.four_bar import CLAMPED, ENDS, IY, IZ, JOINTS, NU, A, E, G, J
from reference.stiffness_method import mp
from reference.structure import LOADS, Member, Spring, Structure

from .fifty_digits import displacements
from .harness import COLOURS, Row, Target, figure, importable, least_each, main, write
from .job import BAR, NODES, PLANE, Job, error, job
from .stacked import Stacked, beam

Array = NDArray[np.float64]
LINKS = ("crank", "coupler", "rocker")
SAMPLES = (100, 3000, 100_000)
CHECKED = 8
# Samples of one number that are solved in turn.
TURNS = 3
# Samples whose matrices NumPy has at a time, so that they lie in the cache.
STACK = 250
OURS, WITHOUT = "linkframe, with the extra fast", "linkframe, without"
IN_PLACE, PLACED_WITHOUT = "linkframe in place, with the extra fast", "linkframe in place, without"
STACKED, DENSE = "numpy, stacked solve", "numba, dense Cholesky"


@dataclass(frozen=True)
class Drawn:
    """Samples of a four-bar.

    Attributes
    ----------
    lengths
        Of crank, coupler, rocker and ground, (4, samples); P lies in the middle of the coupler.
    theta
        Drive angle, radians, (samples,).
    modulus
        E of crank, coupler and rocker, (3, samples).
    stiffness, offset
        By joint: ``ktx kty ktz krx kry krz``, (samples, 6), and clearance ``ux uy``, (samples, 2).
    load
        ``fx fy fz mx my mz`` on P, (samples, 6).
    """

    lengths: Array
    theta: Array
    modulus: Array
    stiffness: dict[str, Array]
    offset: dict[str, Array]
    load: Array

    @property
    def plane(self) -> bool:
        """Whether the load lies in the plane."""
        return not self.load[:, 2:5].any()

    def frame(self) -> Frame:
        """The samples as they are put to linkframe: described in space."""
        crank, coupler, rocker, ground = self.lengths
        beams = {link: Beam(BAR, Material(E=young, nu=NU)) for link, young in zip(LINKS, self.modulus, strict=True)}
        four_bar = FourBar(crank, coupler, rocker, ground, (0.5 * coupler, 0.0), beam=beams, stiffness=self.stiffness)
        frame = four_bar.move(self.theta).frame()
        for joint, gap in self.offset.items():
            frame.offset(joint, ux=gap[:, 0], uy=gap[:, 1])
        frame.load("P", **{name: f for name, f in zip(LOADS, self.load.T, strict=True) if f.any()})
        return frame

    def places(self) -> Array:
        """Coordinates x, y of the nodes, (samples, nodes, 2), by the closed form."""
        a, b, c, d = self.lengths
        pin, pivot = a * np.exp(1j * self.theta), d + 0j
        diagonal = pivot - pin
        square = diagonal.real**2 + diagonal.imag**2
        along = 0.5 * (square + b**2 - c**2)
        coupler = diagonal * (along + 1j * np.sqrt(b**2 * square - along**2)) / square
        at = {"A": 0.0 * pin, "B": pin, "P": pin + 0.5 * coupler, "D": pin + coupler, "E": pivot}
        points = np.stack([at[node.split(".")[0]] for node in NODES], axis=-1)
        return np.stack([points.real, points.imag], axis=-1)

    def loads(self) -> Array:
        """Loads on the nodes, (samples, nodes, 6): that on P, and stiffness times clearance on both sides of joints."""
        loads = np.zeros((len(self.load), len(NODES), 6))
        loads[:, NODES.index("P")] = self.load
        for joint, ends in JOINTS.items():
            push = self.stiffness[joint][:, :2] * self.offset[joint]
            for node, sign in zip(ends, (-1.0, 1.0), strict=True):
                loads[:, NODES.index(node), :2] += sign * push
        return loads

    def moduli(self) -> Array:
        """E and G of each member, (samples, members, 2)."""
        young = self.modulus[[LINKS.index(member.split(".")[0]) for member in ENDS]].T
        return np.stack([young, young / (2.0 * (1.0 + NU))], axis=-1)

    def truth(self, k: int) -> Array:
        """Displacement of P of a sample, (6,), by 50 digits from the floats that were drawn."""
        a, b, c, d, theta = (mp.mpf(float(value)) for value in (*self.lengths[:, k], self.theta[k]))
        x, y = a * mp.cos(theta), a * mp.sin(theta)
        square = (d - x) ** 2 + y**2
        along = (square + b**2 - c**2) / 2
        across = mp.sqrt(b**2 * square - along**2)
        u, v = ((d - x) * along + y * across) / square, ((d - x) * across - y * along) / square
        points = {"A": (0, 0), "B": (x, y), "P": (x + u / 2, y + v / 2), "D": (x + u, y + v), "E": (d, 0)}
        nodes = {node: (*map(mp.mpf, points[node.split(".")[0]]), mp.mpf(0)) for node in NODES}
        members = {}
        for name, ends in ENDS.items():
            young = mp.mpf(float(self.modulus[LINKS.index(name.split(".")[0]), k]))
            members[name] = Member(*ends, E=young, G=young / (2 * (1 + mp.mpf(NU))), A=A, Iy=IY, Iz=IZ, J=J)
        loads: dict[str, tuple[object, ...]] = {"P": tuple(map(float, self.load[k]))}
        joints = {}
        for joint, (first, second) in JOINTS.items():
            springs = tuple(map(float, self.stiffness[joint][k]))
            push = [mp.mpf(springs[i]) * mp.mpf(float(self.offset[joint][k, i])) for i in range(2)]
            loads |= {first: (-push[0], -push[1], *(0,) * 4), second: (*push, *(0,) * 4)}
            joints[joint] = Spring(first, second, springs)
        return displacements(Structure(nodes, members, joints, (), {"A": CLAMPED, "E": CLAMPED}, loads))["P"]


def drawn(samples: int, *, space: bool, seed: int = 0) -> Drawn:
    """A crank-rocker: one hundredth of its lengths, a tenth of all else, and angles from the whole turn."""
    rng = np.random.default_rng(seed)
    lengths = np.array([[0.1], [0.25], [0.2], [0.25]]) * (1.0 + 0.01 * rng.normal(size=(4, samples)).clip(-4.0, 4.0))
    modulus = 2e11 * np.exp(0.1 * rng.normal(size=(3, samples)))
    stiffness = {joint: 2e11 * np.exp(0.1 * rng.normal(size=(samples, 6))) for joint in JOINTS}
    for each in stiffness.values():
        each[:, 5] = 0.0
    offset = {joint: 1e-4 * rng.normal(size=(samples, 2)) for joint in JOINTS}
    load = rng.normal((10.0, 100.0, 30.0, 1.0, 2.0, 0.5), (1.0, 5.0, 3.0, 0.1, 0.2, 0.05), size=(samples, 6))
    if not space:
        load[:, 2:5] = 0.0
    return Drawn(lengths, rng.uniform(0.0, 2.0 * np.pi, samples), modulus, stiffness, offset, load)


# -- who solves -------------------------------------------------------------------------------------------------------


def linkframe(samples: Drawn) -> Array:
    """From numbers to the displacement of P: description, motion, frame, plan, solution."""
    found: Array = samples.frame().solve().displacement("P")
    return found


@contextmanager
def without_extra() -> Iterator[None]:
    """As if llvmlite were not installed."""
    with patch.object(machine_code, "available", lambda: False):
        yield


def by_numpy_alone(samples: Drawn) -> Array:
    """The same without the extra."""
    with without_extra():
        return linkframe(samples)


class InPlace:
    """A frame for each number of samples, described once by hand, of which all numbers are changed."""

    def __init__(self) -> None:
        self._frames: dict[tuple[int, bool], Frame] = {}

    def solve(self, samples: Drawn) -> Array:
        """Displacement of P, (samples, 6); the first call for a number of samples describes the frame."""
        key = len(samples.theta), samples.plane
        if key not in self._frames:
            self._frames[key] = described(samples)
        else:
            change(self._frames[key], samples)
        found: Array = self._frames[key].solve().displacement("P")
        return found

    def without(self, samples: Drawn) -> Array:
        """The same without the extra."""
        with without_extra():
            return self.solve(samples)


def described(samples: Drawn) -> Frame:
    """The samples as a frame by hand, in global coordinates."""
    frame, places, beams = Frame(), in_space(samples), members(samples)
    for k, node in enumerate(NODES):
        frame.node(node, places[:, k])
    for member, ends in ENDS.items():
        frame.add(member, beams[member], *ends)
    for joint, ends in JOINTS.items():
        frame.add(joint, Joint(stiffness=samples.stiffness[joint]), *ends)
        frame.offset(joint, ux=samples.offset[joint][:, 0], uy=samples.offset[joint][:, 1])
    frame.fix(NODES[0])
    frame.fix(NODES[-1])
    frame.load("P", **forces(samples))
    return frame


def change(frame: Frame, samples: Drawn) -> None:
    """Give a frame other samples."""
    beams = members(samples)
    frame.change(NODES, in_space(samples))
    frame.change([*ENDS], [beams[member] for member in ENDS])
    frame.change([*JOINTS], [Joint(stiffness=samples.stiffness[joint]) for joint in JOINTS])
    for joint, gap in samples.offset.items():
        frame.offset(joint, ux=gap[:, 0], uy=gap[:, 1])
    frame.set_load("P", **forces(samples))


def in_space(samples: Drawn) -> Array:
    """Coordinates of the nodes, (samples, nodes, 3)."""
    places = samples.places()
    return np.concatenate([places, np.zeros((*places.shape[:-1], 1))], axis=-1)


def members(samples: Drawn) -> dict[str, Beam]:
    """The beam of each member."""
    beams = {link: Beam(BAR, Material(E=young, nu=NU)) for link, young in zip(LINKS, samples.modulus, strict=True)}
    return {member: beams[member.split(".")[0]] for member in ENDS}


def forces(samples: Drawn) -> dict[str, Array]:
    """The load on P by component, those that are there."""
    return {name: force for name, force in zip(LOADS, samples.load.T, strict=True) if force.any()}


def stacked(samples: Drawn) -> Array:
    """By `numpy.linalg.solve`, so many matrices at a time as lie in the cache."""
    components = list(PLANE if samples.plane else range(6))
    width, count = len(components), len(samples.theta)
    places, moduli, loads, found = samples.places(), samples.moduli(), samples.loads(), np.zeros((count, 6))
    for start in range(0, count, STACK):
        part = slice(start, start + STACK)
        length = len(places[part])
        whole = np.zeros((length, width * len(NODES), width * len(NODES)))

        def add(first: str, second: str, pair: Array, whole: Array = whole) -> None:
            at = np.concatenate([width * NODES.index(node) + np.arange(width) for node in (first, second)])
            whole[:, at[:, None], at] += pair

        both = np.concatenate([components, 6 + np.array(components)])
        for k, (first, second) in enumerate(ENDS.values()):
            chord = places[part, NODES.index(second)] - places[part, NODES.index(first)]
            add(first, second, beam(chord, *moduli[part, k].T)[:, both[:, None], both])
        for joint, (first, second) in JOINTS.items():
            springs = samples.stiffness[joint][part][:, components]
            pair, i = np.zeros((length, 2 * width, 2 * width)), np.arange(width)
            pair[:, i, i] = pair[:, i + width, i + width] = springs
            pair[:, i, i + width] = pair[:, i + width, i] = -springs
            add(first, second, pair)
        inner = slice(width, -width)
        right = loads[part, 1:-1][:, :, components].reshape(length, -1, 1)
        u = np.linalg.solve(whole[:, inner, inner], right)[..., 0].reshape(length, -1, width)
        found[part, components] = u[:, NODES.index("P") - 1]
    return found


def dense(samples: Drawn) -> Array:
    """By the loop that Numba compiles."""
    from . import dense_cholesky

    components = np.array(PLANE if samples.plane else range(6))
    ends, joints = numbered()
    stiffness = np.stack([samples.stiffness[joint] for joint in JOINTS], axis=1)
    section = np.array([A, IY, IZ, J])
    given = samples.places(), ends, joints, samples.moduli(), section, stiffness, samples.loads(), components
    found: Array = dense_cholesky.displacements(*given, NODES.index("P"))
    return found


def numbered() -> list[NDArray[np.int64]]:
    """Numbers of the nodes of members, and of joints, (n, 2) each."""
    return [np.array([[NODES.index(node) for node in pair] for pair in each.values()]) for each in (ENDS, JOINTS)]


def ways() -> dict[str, Callable[[Drawn], Array]]:
    """Everybody who is installed, by name."""
    found = {WITHOUT: by_numpy_alone, PLACED_WITHOUT: InPlace().without, STACKED: stacked}
    if machine_code.available():
        found = {OURS: linkframe, IN_PLACE: InPlace().solve, **found}
    if importable("numba"):
        found[DENSE] = dense
    return found


# -- what is measured -------------------------------------------------------------------------------------------------


def run(out: Path, quick: bool) -> list[Target]:
    """Time and error in the plane and in space, and the paper's job of 36 poses and 100 samples beside them."""
    counts = SAMPLES[:2] if quick else SAMPLES
    rows = [row for space in (False, True) for row in measured(counts, space, 0.5 if quick else 3.0)]
    write(out, "everything_random", rows)
    short = short_rows(5 if quick else 20)
    write(out, "paper_job_36_x_100", short)
    draw(out, rows)
    ours = [name for name in (OURS, IN_PLACE) if name in ways()] or [WITHOUT, PLACED_WITHOUT]
    return [target(row, rows) for row in rows if row["contender"] in ours] + short_targets(short)


def measured(counts: Sequence[int], space: bool, seconds: float) -> list[Row]:
    """A row for each contender and number of samples, each called for about so many seconds."""
    few = drawn(CHECKED, space=space)
    exact = np.array([few.truth(k) for k in range(CHECKED)])
    errors = errors_of(few, exact)
    rows: list[Row] = []
    for count in counts:
        turns = [drawn(count, space=space, seed=k) for k in range(TURNS)]
        calls = {name: partial(in_turn, way, cycle(turns)) for name, way in ways().items()}
        once = least_each(calls, 2)
        taken = least_each(calls, max(3, min(100, int(seconds / sum(once.values())))))
        rows += [
            {
                "case": "in space" if space else "in plane",
                "samples": count,
                "contender": name,
                "us_per_sample": 1e6 * taken[name] / count,
                "worst_error": errors[name],
            }
            for name in calls
        ]
    return rows


def errors_of(samples: Drawn, exact: Array) -> dict[str, float]:
    """The worst error of everybody, who has solved other samples before."""
    others, found = drawn(len(samples.theta), space=not samples.plane, seed=1), {}
    for name, way in ways().items():
        way(others)
        found[name] = float(error(way(samples), exact).max())
    return found


def in_turn(way: Callable[[Drawn], Array], turns: Iterator[Drawn]) -> Array:
    """The solution for the next samples: nobody is given the same twice in a row."""
    return way(next(turns))


def short_rows(repeats: int) -> list[Row]:
    """The paper's job in the plane at 36 poses and 100 samples, P alone."""
    work = job(36, 100, space=False)
    calls: dict[str, Callable[[], object]] = {
        "linkframe": lambda: work.frame().solve().displacement("P"),
        STACKED: Stacked(work, plane=True).solve,
    }
    if importable("numba"):
        calls[DENSE] = partial(dense_job, work)
    for call in calls.values():
        call()
    taken = least_each(calls, repeats)
    return [{"contender": name, "us_per_entry": 1e6 * spent / work.size} for name, spent in taken.items()]


def dense_job(work: Job) -> Array:
    """The paper's job by Numba's loop, each pose and sample for itself."""
    from . import dense_cholesky

    poses, samples = work.shape
    coordinates = work.coordinates()
    places = np.stack([np.broadcast_to(coordinates[node], (poses, 3)) for node in NODES], axis=1)[..., :2]
    pushes = work.pushes()
    loads = np.stack([pushes.get(node, np.zeros((samples, 6))) for node in NODES], axis=1)
    stiffness = np.stack([work.stiffness[joint] for joint in JOINTS], axis=1)
    ends, joints = numbered()
    given = (
        np.repeat(places, samples, axis=0),
        ends,
        joints,
        np.broadcast_to([E, G], (work.size, len(ENDS), 2)),
        np.array([A, IY, IZ, J]),
        np.tile(stiffness, (poses, 1, 1)),
        np.tile(loads, (poses, 1, 1)),
        np.array(PLANE),
    )
    found: Array = dense_cholesky.displacements(*given, NODES.index("P"))
    return found.reshape(poses, samples, 6)


# -- what is told -----------------------------------------------------------------------------------------------------


def target(ours: Row, rows: list[Row]) -> Target:
    """Ahead of both peers at one number of samples."""
    others = {
        row["contender"]: row["us_per_sample"] / ours["us_per_sample"]
        for row in rows
        if (row["case"], row["samples"]) == (ours["case"], ours["samples"]) and "linkframe" not in row["contender"]
    }
    told = ", ".join(f"{name} {times:.2f} times" for name, times in others.items())
    placed = " in place" in str(ours["contender"])
    name = f"everything random{', changed in place,' * placed} {ours['case']}, {ours['samples']} samples: ahead of all"
    return Target("1c everything random", name, told, min(others.values()) > 1.0, BOUND_IN_PLACE if placed else BOUND)


def short_targets(rows: list[Row]) -> list[Target]:
    """Ahead of both peers at 36 poses and 100 samples."""
    ours, *others = rows
    times = {row["contender"]: row["us_per_entry"] / ours["us_per_entry"] for row in others}
    told = ", ".join(f"{name} {ratio:.1f} times" for name, ratio in times.items())
    return [Target("1c everything random", "paper's job, 36 x 100: ahead of all", told, min(times.values()) > 1.0)]


BOUND = (
    "describing the linkage, checks, numbering and order of elimination take Python 5 to 8 ms, whatever the samples; "
    "the peers have these written into their programs"
)

BOUND_IN_PLACE = (
    "the recorded program has 1620 operations a sample in the plane and 3160 in space, most of them in extended "
    "precision, at 2 ns each: a third of the time of Numba's loop in the plane, a quarter in space; elements and their "
    "checks take NumPy and Python 1.5 to 2 ms a batch, whatever the samples"
)


def draw(out: Path, rows: list[Row]) -> None:
    """Time of a sample over the number of samples."""
    with figure(out, "everything_random", columns=2) as axes:
        for ax, case in zip(axes, ("in plane", "in space"), strict=True):
            for colour, name in zip(COLOURS, dict.fromkeys(row["contender"] for row in rows), strict=False):
                mine = [row for row in rows if (row["case"], row["contender"]) == (case, name)]
                ax.plot(
                    [r["samples"] for r in mine], [r["us_per_sample"] for r in mine], "o-", color=colour, label=name
                )
            ax.set(xscale="log", yscale="log", title=case, xlabel="samples")
        axes[0].set_ylabel("processor time per sample / µs")
        axes[0].legend(fontsize=7)


if __name__ == "__main__":
    main("everything_random", run)
