"""Random models by the thousand: a braced frame and a closed spatial linkage, every number over decades of its own."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, fields, is_dataclass, replace
from functools import cache
from typing import Any

import numpy as np
from linkframe.elements import Beam, Joint, Material, Section
from linkframe.framework import Frame, Solution
from reference import stiffness_method
from reference.structure import COMPONENTS, LOADS, Member, Spring, Structure

from .double_double import DoubleDouble
from .measure import off
from .stacked import solve

Array = np.ndarray[Any, np.dtype[Any]]
Rng = np.random.Generator

CLAMPED = dict.fromkeys(COMPONENTS, 0.0)
# Members by their ends; joints by their first and second node.
BRACED = (("g", "a"), ("a", "b"), ("j", "c"), ("c", "h"), ("a", "c")), {"joint": ("b", "j")}
LINKAGE = (("g", "a"), ("i", "p"), ("p", "b"), ("j", "k")), {"one": ("a", "i"), "two": ("b", "j"), "three": ("k", "h")}
TWINS = {"i": "a", "j": "b", "k": "h"}
PLACES = {"g": (0, 0, 0), "a": (0, 1, 0), "b": (1, 1, 0), "p": (0.5, 1.3, 0.4), "c": (2, 1, 0), "h": (2, 0, 0)}


KINDS = ("braced", "linkage")
# Statuses of entries whose displacements may be NaN.
ANNOUNCED = ("mechanism", "statically consistent mechanism")


@dataclass(frozen=True)
class Tally:
    """What random models showed.

    Attributes
    ----------
    models, numbers
        How many models, and displacement components, refined ones included.
    lies
        Numbers further off than their bound.
    silent
        NaN that no status announces.
    mechanisms, open
        Models called a mechanism, and others with a number without any certain digit.
    least, median
        Least and typical bound over true error.
    """

    models: int = 0
    numbers: int = 0
    lies: int = 0
    silent: int = 0
    mechanisms: int = 0
    open: int = 0
    least: float = np.inf
    ratios: tuple[float, ...] = ()

    def __add__(self, other: Tally) -> Tally:
        return Tally(
            self.models + other.models,
            self.numbers + other.numbers,
            self.lies + other.lies,
            self.silent + other.silent,
            self.mechanisms + other.mechanisms,
            self.open + other.open,
            min(self.least, other.least),
            self.ratios + other.ratios,
        )

    def __str__(self) -> str:
        return (
            f"{self.models} models, {self.numbers} numbers: {self.lies} beyond their bound, {self.silent} NaN not "
            f"announced; {self.mechanisms} called mechanisms, {self.open} more without a certain digit; "
            f"bound over error at least {self.least:.6f}, typically {np.median(self.ratios or np.nan):.3g}"
        )


def tally(rng: Rng, count: int, kind: str) -> Tally:
    """Random models of one kind, counted."""
    models = random_models(rng, count, kind)
    solution = models.frame().solve()
    announced = np.isin(solution.status, ANNOUNCED)[:, None]
    numbers = lies = silent = 0
    unsure = np.zeros(count, dtype=bool)
    ratios = []
    for found in compared(models, solution):
        for value, error, bound in ((found.value, found.error, found.bound), (found.refined, found.better, found.left)):
            numbers += value.size
            lies += int(np.sum(error > bound))
            silent += int(np.sum(np.isnan(value) & ~announced))
        unsure |= np.isinf(found.bound).any(axis=1)
        wrong = (found.error > 0.0) & np.isfinite(found.bound)
        ratios.append(found.bound[wrong] / found.error[wrong])
    each = np.concatenate(ratios)
    mechanisms = int((solution.status == "mechanism").sum())
    return Tally(
        count,
        numbers,
        lies,
        silent,
        mechanisms,
        int(unsure.sum()) - mechanisms,
        float(each.min()),
        (float(np.median(each)),),
    )


@dataclass(frozen=True)
class Compared:
    """Displacement of a node in all models, plain and refined: value, true error, stated bound, (count, 6)."""

    value: Array
    error: Array
    bound: Array
    refined: Array
    better: Array
    left: Array


@dataclass(frozen=True)
class Models:
    """`count` models of one topology.

    Attributes
    ----------
    nodes
        Coordinates (count, 3).
    members
        Ends, and E, G, A, Iy, Iz, J, ky, kz (count,) and up (count, 3).
    joints
        First and second node, stiffness (count, 6) and axes (count, 3, 3).
    loads
        Force and moment (count, 6).
    """

    nodes: dict[str, Array]
    members: dict[str, tuple[str, str, dict[str, Any]]]
    joints: dict[str, tuple[str, str, Array, Array]]
    loads: dict[str, Array]

    def frame(self) -> Frame:
        """The batch as a frame."""
        frame = Frame()
        for name, place in self.nodes.items():
            frame.node(name, place)
        for name, (start, end, given) in self.members.items():
            shear = {key: given[key] for key in ("ky", "kz") if given["shear"]}
            section = Section(**{key: given[key] for key in ("A", "Iy", "Iz", "J")}, **shear)
            material = Material(E=given["E"], G=given["G"])
            frame.add(name, Beam(section, material, up=given["up"], shear=given["shear"]), start, end)
        for name, (first, second, stiffness, axes) in self.joints.items():
            frame.add(name, Joint(stiffness=stiffness, axes=axes), first, second)
        for node in "gh":
            frame.fix(node)
        for node, load in self.loads.items():
            frame.load(node, **dict(zip(LOADS, load.T, strict=True)))
        return frame

    def structure(self) -> Structure:
        """The batch in double-double numbers."""

        def wide(array: Array) -> Any:
            return tuple(wide(part) for part in array) if array.ndim > 1 else DoubleDouble(array)

        members = {
            name: Member(
                start,
                end,
                **{key: DoubleDouble(given[key]) for key in ("E", "G", "A", "Iy", "Iz", "J")},
                **({key: given[key] for key in ("ky", "kz")} if given["shear"] else {}),
                up=wide(given["up"].T),
            )
            for name, (start, end, given) in self.members.items()
        }
        joints = {
            name: Spring(first, second, wide(stiffness.T), wide(np.moveaxis(axes, 0, -1)))
            for name, (first, second, stiffness, axes) in self.joints.items()
        }
        nodes = {name: wide(place.T) for name, place in self.nodes.items()}
        supports = {"g": CLAMPED, "h": CLAMPED}
        return Structure(
            nodes, members, joints, supports=supports, loads={node: wide(load.T) for node, load in self.loads.items()}
        )


def random_models(rng: Rng, count: int, kind: str) -> Models:
    """Models over many decades of size, slenderness, moduli, joint stiffness and load; some almost in line."""
    ends, joined = BRACED if kind == "braced" else LINKAGE
    names = sorted({node for pair in (*ends, *joined.values()) for node in pair})
    size = _decades(rng, count, -3, 3)
    flat = _decades(rng, count, -6, 0)[:, None]  # how far from a line
    wobble = {name: rng.uniform(-0.3, 0.3, (count, 3)) for name in PLACES}
    nodes = {}
    for name in names:
        twin = TWINS.get(name, name)
        place = np.array(PLACES[twin]) + wobble[twin]
        place = np.concatenate([place[:, :1], flat * place[:, 1:]], axis=1) if kind == "braced" else place
        nodes[name] = size[:, None] * place
    members = {f"{a}{b}": (a, b, _member(rng, count, nodes[b] - nodes[a])) for a, b in ends}
    joints = {name: (*pair, _decades(rng, (count, 6), -6, 20), _axes(rng, count)) for name, pair in joined.items()}
    free = [name for name in names if name not in ("g", "h")]
    force = _decades(rng, count, -6, 6)[:, None]
    lever = np.concatenate([np.ones((count, 3)), np.repeat(size[:, None], 3, axis=1)], axis=1)
    loads = {name: force * lever * rng.normal(size=(count, 6)) for name in free}
    return Models(nodes, members, joints, loads)


def compared(models: Models, solution: Solution) -> Iterator[Compared]:
    """Node by node; what is further off than its bound is held against 50 digits before it is believed."""
    structure = models.structure()
    truth = solve(structure)
    exactly = cache(lambda index: stiffness_method.solve(one_of(structure, index)).displacement)
    for node in models.loads:
        exact = [part if isinstance(part, DoubleDouble) else DoubleDouble(0.0) for part in truth[node]]
        high = np.stack(np.broadcast_arrays(*(part.high for part in exact)), axis=-1)
        low = np.stack(np.broadcast_arrays(*(part.low for part in exact)), axis=-1)
        value, (refined, left) = solution.displacement(node), solution.refined(node)
        error, better = (np.abs((found - high) - low) for found in (value, refined))
        bound = solution.error_bound(node)
        for index in np.flatnonzero(((error > bound) | (better > left)).any(axis=1)).tolist():
            exact = exactly(index)[node]
            error[index], better[index] = off(value[index], exact), off(refined[index], exact)
        yield Compared(value, error, bound, refined, better, left)


def one_of(thing: Any, index: int) -> Any:
    """The same with each double-double number, and each array, replaced by the float of one model."""
    if isinstance(thing, DoubleDouble):
        return float(thing.high[index])
    if isinstance(thing, np.ndarray):
        return float(thing[index])
    if isinstance(thing, dict):
        return {name: one_of(part, index) for name, part in thing.items()}
    if isinstance(thing, tuple):
        return tuple(one_of(part, index) for part in thing)
    if is_dataclass(thing):
        return replace(thing, **{field.name: one_of(getattr(thing, field.name), index) for field in fields(thing)})  # type: ignore[type-var]
    return thing


def _member(rng: Rng, count: int, chord: Array) -> dict[str, Any]:
    length = np.linalg.norm(chord, axis=-1)
    y, z = (length / _decades(rng, count, 0, 2.5) for _ in range(2))
    young = _decades(rng, count, 5, 12)
    shear = bool(rng.integers(2))
    return {
        "E": young,
        "G": young / 2.6,
        "A": y * z,
        "Iy": y * z**3 / 12,
        "Iz": z * y**3 / 12,
        "J": np.minimum(y, z) ** 3 * np.maximum(y, z) / 4,
        "ky": 0.8,
        "kz": 0.9,
        "shear": shear,
        "up": np.cross(chord, rng.normal(size=(count, 3))),
    }


def _axes(rng: Rng, count: int) -> Array:
    """Random axes; one in four are the global ones in another order."""
    q, _ = np.linalg.qr(rng.normal(size=(count, 3, 3)))
    exact = rng.permuted(np.tile(np.arange(3), (count, 1)), axis=1)[:, :, None] == np.arange(3)
    q = np.where(rng.random(count)[:, None, None] < 0.25, exact * np.sign(q.sum(axis=-1))[..., None], q)
    turn: Array = q * np.sign(np.linalg.det(q))[:, None, None]
    return turn


def _decades(rng: Rng, shape: Any, low: float, high: float) -> Array:
    found: Array = 10.0 ** rng.uniform(low, high, shape)
    return found
