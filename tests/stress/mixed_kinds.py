"""Random models of every kind, by every method, beside the mixed method in 64-digit numbers.

Members of all lengths in one frame, tapers, releases, small shear areas and torsion constants, rigid links, ties,
prescribed displacements, misfits, several joints at one place, screws, loops, loads along members.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from math import inf
from typing import Any

import numpy as np
from linkframe.framework import FrameError, Solution
from reference.as_frame import as_frame, stacked
from reference.mixed_method import Exact, mp, solve
from reference.structure import COMPONENTS, LineLoad, Member, PointLoad, Spring, Structure

from .random_models import Tally, one_of

Array = np.ndarray[Any, np.dtype[Any]]
Rng = np.random.Generator

METHODS = ("broadcast", "banded", "sparse", "iterative")
KINDS = ("displacement", "reaction", "joint_displacement", "joint_force", "end_forces")
RELEASES = ((), (), (), ("start rz",), ("end ry",), ("start rz", "start ry"), ("end rx",), ("start uy",), ("end ux",))
# Share of the greatest result of its kind below which the reference is not sure of a number.
_SURE = 1e-45


@dataclass(frozen=True)
class Compared:
    """One result of the regular entries: value, true error and stated bound, plain and refined, (entries, n)."""

    kind: str
    name: str
    value: Array
    error: Array
    bound: Array
    refined: Array
    better: Array
    left: Array


def tally(rng: Rng, count: int, *, method: str = "broadcast", kinds: tuple[str, ...] = KINDS) -> Tally:
    """One random structure with a batch of so many, counted; none where the frame is refused."""
    structure = _Random(rng, count, only_loads=method != "broadcast").structure()
    try:
        solution = as_frame(structure).solve(method)
        status = np.broadcast_to(solution.status, (count,))
    except FrameError:  # ties and supports that contradict each other
        return Tally()
    exact = [_exact(structure, index) if status[index] == "regular" else None for index in range(count)]
    known = [index for index, each in enumerate(exact) if each is not None]
    numbers = lies = silent = 0
    unsure, ratios, least = np.zeros(len(known), dtype=bool), [], np.inf
    for found in compared(structure, solution, exact, kinds):
        for value, error, bound in ((found.value, found.error, found.bound), (found.refined, found.better, found.left)):
            numbers += value.size
            lies += int(np.sum(error > bound))
            silent += int(np.isnan(value).sum())
        unsure |= np.isinf(found.bound).any(axis=1)
        wrong = (found.error > 0.0) & np.isfinite(found.bound)
        if wrong.any():
            least = min(least, float(np.min(found.bound[wrong] / found.error[wrong])))
            ratios.append(float(np.median(found.bound[wrong] / found.error[wrong])))
    mechanisms = int((status == "mechanism").sum())
    return Tally(len(known), numbers, lies, silent, mechanisms, int(unsure.sum()), least, tuple(ratios))


def compared(
    structure: Structure, solution: Solution, exact: list[Exact | None], kinds: tuple[str, ...] = KINDS
) -> Iterator[Compared]:
    """Result by result of the entries whose exact results are known."""
    names: dict[str, list[str]] = {
        "displacement": list(structure.nodes),
        "reaction": list(structure.supports),
        "joint_displacement": list(structure.joints),
        "joint_force": list(structure.joints),
        "end_forces": list(structure.members),
    }
    known = [index for index, each in enumerate(exact) if each is not None]
    if not known:
        return
    for kind in kinds:
        truth = [getattr(exact[index], kind) for index in known]
        sure = np.array([max((abs(v) for six in each.values() for v in six), default=0) for each in truth], dtype=float)
        for name in names[kind]:
            bound, (refined, left) = solution.error_bound(name, kind), solution.refined(name, kind)
            value = getattr(solution, kind)(name)
            parts = [np.reshape(each, (-1, each.shape[-1]))[known] for each in (value, bound, refined, left)]
            value, bound, refined, left = parts
            off = partial(_off, exact=[each[name] for each in truth], floor=_SURE * sure[:, None])
            yield Compared(kind, name, value, off(value), bound, refined, off(refined), left)


def _exact(structure: Structure, index: int) -> Exact | None:
    """Results of one entry; None where the forces of redundant constraints are any that balance."""
    try:
        return solve(one_of(structure, index))
    except ZeroDivisionError:
        return None


def _off(found: Array, exact: list[Array], floor: Array) -> Array:
    """Errors, rounded down, less what the reference itself may be off."""
    pairs = [[abs(mp.mpf(float(a)) - b) for a, b in zip(*row, strict=True)] for row in zip(found, exact, strict=True)]
    return np.maximum(np.array(pairs, dtype=float) * (1.0 - 2.0**-52) - floor, 0.0)


class _Random:
    """One random structure in the making."""

    def __init__(self, rng: Rng, count: int, only_loads: bool) -> None:
        self.rng, self.count, self.only_loads = rng, count, only_loads
        self.nodes: dict[str, Any] = {}
        self.members: dict[str, Member] = {}
        self.joints: dict[str, Spring] = {}
        self.rigid: list[tuple[str, str]] = []
        self.loaded: set[str] = set()

    def structure(self) -> Structure:
        rng = self.rng
        points = int(rng.integers(2, 6))
        self.young = float(10 ** rng.uniform(6, 12))
        self.low = float(rng.choice([-3.0, -1.0, 0.0]))
        self.springs = float(10 ** rng.uniform(0, 10))
        self.nodes["n0"] = tuple(float(v) for v in rng.normal(size=3) * rng.choice([0.0, 1.0, 1e3]))
        for k in range(1, points):
            root = f"n{rng.integers(k)}"
            self.nodes[f"n{k}"] = self._beside(root)
            self._link(root, f"n{k}")
        for _ in range(int(rng.integers(0, 3))):
            a, b = rng.choice(points, size=2, replace=points < 2)
            self._link(f"n{a}", f"n{b}")
        places = [name for name in self.nodes if name[0] == "n"]
        for k in range(int(rng.choice([0, 0, 1, 2]))):
            master = str(rng.choice(places))
            self.nodes[f"s{k}"] = self._beside(master)
            self.rigid.append((master, f"s{k}"))
            if rng.random() < 0.5:
                self._link(f"s{k}", str(rng.choice([p for p in places if p != master])))
        supports = self._supports(places)
        ties = self._ties(places)
        offsets = {
            name: tuple(self._load(1e-6, 1e-2) if rng.random() < 0.5 else 0.0 for _ in range(6))
            for name in self.joints
            if rng.random() < 0.15
        }
        loads = {
            str(node): tuple(self._load(1e-2, 1e4) if rng.random() < 0.7 else 0.0 for _ in range(6))
            for node in rng.choice(list(self.nodes), size=min(2, len(self.nodes)), replace=False)
        }
        lines, forces = self._member_loads()
        return Structure(
            self.nodes, self.members, self.joints, tuple(self.rigid), supports, loads, ties, offsets, lines, forces
        )

    # -- parts ------------------------------------------------------------------------------------------------------

    def _beside(self, root: str) -> tuple[Any, ...]:
        """A place at a distance over decades."""
        rng = self.rng
        reach = self._number(10 ** rng.uniform(self.low, -self.low if self.low else 1.0))
        way = rng.normal(size=3)
        if rng.random() < 0.3:
            way = np.eye(3)[rng.integers(3)] * rng.choice([-1.0, 1.0])
        way = way / np.linalg.norm(way)
        wobble = 0.0 if rng.random() < 0.5 else 0.3
        return tuple(
            x + reach * (float(w) + self._number(wobble * rng.normal(size=self.count)) if wobble else float(w))
            for x, w in zip(self.nodes[root], way, strict=True)
        )

    def _link(self, start: str, end: str) -> None:
        """A member, each end of it on the node or on a joint beside it."""
        rng = self.rng
        chord = self._place(end) - self._place(start)
        if start == end or np.linalg.norm(chord, axis=-1).min() < 1e-6:
            return
        name = f"m{len(self.members)}"
        ends = [self._jointed(node, f"{name}.{side}") for side, node in enumerate((start, end))]
        length = np.linalg.norm(chord, axis=-1)
        y, z = (length.min() / 10 ** rng.uniform(0.3, 2.5) for _ in range(2))
        A, Iy, Iz = y * z, y * z**3 / 12, z * y**3 / 12
        J = min(y, z) ** 3 * max(y, z) / 4 * (10 ** rng.uniform(-9, 0) if rng.random() < 0.4 else 1.0)
        shear = rng.random() < 0.4
        ky, kz = (float(10 ** rng.uniform(-8, 0)) if rng.random() < 0.5 else 0.8 for _ in range(2))
        taper = None
        if rng.random() < 0.3:
            taper = tuple(float(v * 8 ** rng.uniform(-1, 1)) for v in (A, Iy, Iz, J))
        up = (0.0, 0.0, 1.0)
        if rng.random() < 0.5:
            across = np.cross(chord, rng.normal(size=3))
            up = tuple(across[:, k] if not self.only_loads else float(across[0, k]) for k in range(3))
        self.members[name] = Member(
            *ends,
            E=self._number(self.young * 10 ** rng.uniform(-1, 1)),
            G=self._number(self.young / 2.6),
            A=self._number(A),
            Iy=float(Iy),
            Iz=self._number(Iz),
            J=self._number(J),
            ky=ky if shear else inf,
            kz=kz if shear else inf,
            up=up,
            taper=taper,
            release=RELEASES[rng.integers(len(RELEASES))],
        )

    def _jointed(self, node: str, name: str) -> str:
        """The node, or a new one beside it, with a joint between them and perhaps another to one more."""
        rng = self.rng
        if rng.random() > 0.35:
            return node
        self.nodes[name] = self.nodes[node]
        self.joints[f"j{name}"] = self._spring(node, name)
        others = [other for other in self.nodes if other not in (node, name) and self.nodes[other] is self.nodes[node]]
        if others and rng.random() < 0.3:
            self.joints[f"k{name}"] = self._spring(str(rng.choice(others)), name, ideal=0.05)
        return name

    def _spring(self, first: str, second: str, ideal: float = 0.2) -> Spring:
        rng = self.rng
        kinds = rng.random(6)
        stiffness = tuple(
            inf if p < ideal else (0.0 if p > 0.97 else self._number(self.springs * 10 ** rng.uniform(-4, 4)))
            for p in kinds
        )
        q, _ = np.linalg.qr(rng.normal(size=(3, 3)))
        q = np.eye(3)[rng.permutation(3)] if rng.random() < 0.3 else q
        q = q * np.sign(np.linalg.det(q))
        axes = tuple(tuple(float(v) for v in row) for row in q)
        pitch = float(rng.normal()) if rng.random() < 0.1 else 0.0
        return Spring(first, second, stiffness, axes, pitch)

    def _supports(self, places: list[str]) -> dict[str, dict[str, Any]]:
        rng = self.rng
        out = {"n0": dict.fromkeys(COMPONENTS, 0.0)}
        if rng.random() < 0.3:
            out["n0"] = {name: self._load(1e-6, 1e-2) for name in COMPONENTS}
        for name in places[1:]:
            if rng.random() < 0.35:
                held = rng.choice(COMPONENTS, size=int(rng.integers(1, 5)), replace=False)
                out[name] = {str(k): self._load(1e-6, 1e-2) if rng.random() < 0.5 else 0.0 for k in held}
        return out

    def _ties(self, places: list[str]) -> tuple[tuple[str, str, tuple[str, ...]], ...]:
        rng = self.rng
        if len(places) < 3 or rng.random() < 0.7:
            return ()
        a, b = (str(name) for name in rng.choice(places[1:], size=2, replace=False))
        return ((a, b, tuple(str(k) for k in rng.choice(COMPONENTS, size=int(rng.integers(1, 3)), replace=False))),)

    def _member_loads(self) -> tuple[tuple[LineLoad, ...], tuple[PointLoad, ...]]:
        rng, lines, points = self.rng, [], []
        for name, member in self.members.items():
            length = float(np.linalg.norm(self._place(member.end) - self._place(member.start), axis=-1).min())
            if rng.random() < 0.2:
                first, last = (tuple(self._load(1e-2, 1e3) for _ in range(3)) for _ in range(2))
                span = None if rng.random() < 0.5 else (0.1 * length, 0.7 * length)
                lines.append(LineLoad(name, first, last, span, bool(rng.random() < 0.5)))
            if rng.random() < 0.1:
                force = tuple(self._load(1e-2, 1e3) for _ in range(6))
                points.append(PointLoad(name, 0.3 * length, force, bool(rng.random() < 0.5)))
        return tuple(lines), tuple(points)

    def _place(self, node: str) -> Array:
        """Position of a node in all entries, (count, 3)."""
        return np.broadcast_to(np.asarray(stacked(self.nodes[node])), (self.count, 3))

    # -- numbers ----------------------------------------------------------------------------------------------------

    def _number(self, value: Any) -> Any:
        """What is the same in all entries, or varies a little."""
        rng = self.rng
        if self.only_loads or rng.random() < 0.5:
            return float(np.ravel(value)[0])
        return np.broadcast_to(value, (self.count,)) * rng.uniform(0.8, 1.25, self.count)

    def _load(self, low: float, high: float) -> Any:
        rng = self.rng
        size = float(10 ** rng.uniform(np.log10(low), np.log10(high)))
        return rng.normal(size=self.count) * size if rng.random() < 0.6 else float(rng.normal() * size)
