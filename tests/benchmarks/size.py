"""Benchmark 4: time a (entry, link) of chains and ladders of 2 to 200 links.

chain    A--o--o--o--o          links in a zigzag, springs against turning in every joint
ladder   A--o--o--o             two such chains, a rung between them at every joint
            |  |  |
         A--o--o--o
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from linkframe.elements import Beam, Joint
from linkframe.framework import Frame, Solution
from numpy.typing import NDArray
from reference.four_bar import IY, IZ, LENGTH, A, E, G, J
from reference.structure import LOADS, Member, Spring, Structure, Vector

from .fifty_digits import displacements
from .harness import COLOURS, Row, Target, figure, least, main, operations, rate, slope, write
from .job import BAR, STEEL, error

Array = NDArray[np.float64]
CLAMPED = dict.fromkeys(("ux", "uy", "uz", "rx", "ry", "rz"), 0.0)
LOAD = (5.0, 10.0, 0.0, 0.0, 0.0, 0.0)
RISE = 0.3
SIZES = {"chain": (2, 5, 10, 20, 50, 100, 200), "ladder": (3, 6, 12, 21, 51, 102, 201)}


@dataclass(frozen=True)
class Mechanism:
    """Nodes, links by name, and joints by name, as pairs of nodes; the load is on `tip`."""

    nodes: dict[str, tuple[float, float, float]]
    links: dict[str, tuple[str, str]]
    joints: dict[str, tuple[str, str]]
    held: tuple[str, ...]
    tip: str

    def frame(self, stiffness: Array) -> Frame:
        """As linkframe's frame, the joints' stiffness (..., 6) a batch."""
        frame, beam = Frame(), Beam(BAR, STEEL)
        for name, place in self.nodes.items():
            frame.node(name, place)
        for name, ends in self.links.items():
            frame.add(name, beam, *ends)
        for name, ends in self.joints.items():
            frame.add(name, Joint(stiffness), *ends)
        for name in self.held:
            frame.fix(name)
        frame.load(self.tip, **{name: f for name, f in zip(LOADS, LOAD, strict=True) if f})
        return frame

    def truth(self, stiffness: Array) -> Array:
        """Displacement of the tip, (6,), in 50 digits, joints of stiffness (6,)."""
        places: dict[str, Vector] = dict(self.nodes)
        links = {name: Member(*ends, E=E, G=G, A=A, Iy=IY, Iz=IZ, J=J) for name, ends in self.links.items()}
        joints = {name: Spring(*ends, tuple(map(float, stiffness))) for name, ends in self.joints.items()}
        held = dict.fromkeys(self.held, CLAMPED)
        return displacements(Structure(places, links, joints, (), held, {self.tip: LOAD}))[self.tip]


def chain(count: int) -> Mechanism:
    """Links end to end."""
    nodes, links, joints = {}, {}, {}
    for k in range(count):
        for end in (0, 1):
            nodes[f"{k}.{end}"] = _place(k + end)
        links[f"link {k}"] = f"{k}.0", f"{k}.1"
        if k:
            joints[f"joint {k}"] = f"{k - 1}.1", f"{k}.0"
    return Mechanism(nodes, links, joints, ("0.0",), f"{count - 1}.1")


def ladder(count: int) -> Mechanism:
    """Two rails and the rungs between them; `count` links in all, about a third of them rungs."""
    nodes: dict[str, tuple[float, float, float]] = {}
    links, joints = {}, {}
    for name, kind, at, first in _ladder_links(count):
        x, y, _ = _place(at)
        far = {"low": _place(at + 1), "high": _place(at + 1, LENGTH), "rung": (x, y + LENGTH, 0.0)}[kind]
        nodes[f"{name}.0"], nodes[f"{name}.1"] = _place(at, LENGTH) if kind == "high" else (x, y, 0.0), far
        links[name] = f"{name}.0", f"{name}.1"
        joints |= {f"{name} on {other}": (other, mine) for other, mine in first.items()}
    return Mechanism(nodes, links, joints, ("low 0.0", "high 0.0"), f"{list(links)[-1]}.1")


def _ladder_links(count: int) -> Iterator[tuple[str, str, int, dict[str, str]]]:
    """Links along the ladder: name, kind, station, and by node of another link the own node that is joined to it."""
    for k in range(count):
        at, kind = divmod(k, 3)
        if kind < 2:
            rail = ("low", "high")[kind]
            before = {f"{rail} {at - 1}.1": f"{rail} {at}.0"} if at else {}
            yield f"{rail} {at}", rail, at, before
        else:
            yield f"rung {at}", "rung", at + 1, {f"low {at}.1": f"rung {at}.0", f"high {at}.1": f"rung {at}.1"}


def _place(station: int, above: float = 0.0) -> tuple[float, float, float]:
    return LENGTH * station, above + RISE * LENGTH * (station % 2), 0.0


def stiffnesses(samples: int) -> Array:
    """Springs of all joints, which vary over the batch, (samples, 6): stiff, and soft against turning about z."""
    rng = np.random.default_rng(0)
    return np.array([2e11] * 5 + [2e4]) * np.exp(0.1 * rng.normal(size=(samples, 6)))


def run(out: Path, quick: bool) -> list[Target]:
    """Chains and ladders of 2 to 200 links, 2000 samples of their joints' stiffness."""
    samples, repeats, patience = (200, 2, 1.0) if quick else (2000, 3, 3.0)
    rows = [row for kind in SIZES for row in measure(kind, SIZES[kind], samples, repeats, patience)]
    write(out, "size", rows)
    draw(out, rows)
    return [target(kind, [row for row in rows if row["kind"] == kind]) for kind in SIZES]


def measure(kind: str, sizes: tuple[int, ...], samples: int, repeats: int, patience: float) -> list[Row]:
    """A row for each number of links, until one takes longer than `patience` seconds."""
    stiffness, rows = stiffnesses(samples), []
    for n in sizes:
        mechanism = KINDS[kind](n)
        last: list[Solution] = []

        def solve(mechanism: Mechanism = mechanism, last: list[Solution] = last) -> None:
            last[:] = [mechanism.frame(stiffness).solve()]
            last[0].displacement(mechanism.tip)

        seconds = least(solve, repeats)
        count = operations(last[0])
        rows.append(
            {
                "kind": kind,
                "links": n,
                "samples": samples,
                "seconds": seconds,
                "us_per_entry_and_link": 1e6 * seconds / samples / n,
                "operations_per_entry_and_link": count / samples / n,
                "floor_us": 1e6 * count / rate() / samples / n,
                "error": float(error(last[0].displacement(mechanism.tip)[0], mechanism.truth(stiffness[0]))),
            }
        )
        if seconds >= patience:
            break
    return rows


KINDS = {"chain": chain, "ladder": ladder}


def target(kind: str, rows: list[Row]) -> Target:
    """Linear in the number of links, from ten on."""
    large = [row for row in rows if row["links"] >= 10]
    power = slope([row["links"] for row in large], [row["seconds"] for row in large])
    first, last = large[0]["us_per_entry_and_link"], large[-1]["us_per_entry_and_link"]
    all_done = large[-1]["links"] == SIZES[kind][-1]
    told = f"time ~ links^{power:.2f} from {large[0]['links']} to {large[-1]['links']} links"
    told += f"; {first:.2f} to {last:.2f} us a (entry, link)" + ("" if all_done else "; longer ones take too long")
    bound = f"factorisation {large[-1]['operations_per_entry_and_link']:.0f} operations an (entry, link)"
    bound += f" = {large[-1]['floor_us']:.2g} us"
    return Target("4 size", f"{kind}: linear in links", told, all_done and power <= 1.1, bound)


def draw(out: Path, rows: list[Row]) -> None:
    """Time a link, and error, over the number of links."""
    with figure(out, "size", columns=2, width=3.6, height=3.0) as (left, right):
        for colour, kind in zip(COLOURS, SIZES, strict=False):
            of_kind = [row for row in rows if row["kind"] == kind]
            n = [row["links"] for row in of_kind]
            left.plot(n, [row["us_per_entry_and_link"] for row in of_kind], "o-", color=colour, label=kind)
            left.plot(n, [row["floor_us"] for row in of_kind], ":", color=colour, label=f"{kind}, factorisation alone")
            right.plot(n, [row["error"] for row in of_kind], "o-", color=colour, label=kind)
        left.set(ylabel="time per (entry, link) / µs", yscale="log")
        right.set(ylabel="relative error of the tip against 50 digits", yscale="log")
        for ax in (left, right):
            ax.set(xlabel="links", xscale="log", xticks=SIZES["chain"], xticklabels=SIZES["chain"])
            ax.minorticks_off()
            ax.legend()


if __name__ == "__main__":
    main("size", run)
