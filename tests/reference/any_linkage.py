"""Linkages of several kinds, planar and spatial, of random dimensions; each may be described in any order."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from linkframe.elements import Beam, Circle, Material
from linkframe.models import Linkage

ROD = Beam(Circle(diameter=0.02), Material(E=200e9, nu=0.3))
Vector = Sequence[float] | np.ndarray
KINDS: dict[str, Callable[[np.random.Generator], Recipe]] = {}


@dataclass
class Recipe:
    """What a linkage is made of: points, links by their points, joints, and how far each drive may go.

    Links of one point are rigid, all others elastic; P is the point that is looked at.
    """

    points: dict[str, np.ndarray] = field(default_factory=dict)
    links: dict[str, list[str]] = field(default_factory=dict)
    joints: dict[str, tuple[str, str, str, str, dict]] = field(default_factory=dict)
    reach: dict[str, float] = field(default_factory=dict)

    def point(self, name: str, place: Vector) -> np.ndarray:
        """Add a point; its place in space."""
        self.points[name] = np.append(place, np.zeros(3 - len(place)))
        return self.points[name]

    def joint(self, kind: str, name: str, point: str, link: str, other: str, **more: object) -> None:
        """Add a joint."""
        self.joints[name] = kind, point, link, other, more

    def made(self, order: np.random.Generator | None = None) -> Linkage:
        """The linkage, described as listed or in another order."""

        def names(given: dict) -> list[str]:
            return list(given) if order is None else [list(given)[k] for k in order.permutation(len(given))]

        linkage = Linkage({name: self.points[name] for name in names(self.points)})
        for name in names(self.links):
            points = self.links[name]
            linkage.link(name, *points, beam=ROD if len(points) > 1 else None)
        for name in names(self.joints):
            kind, point, first, second, more = self.joints[name]
            getattr(linkage, kind)(point, first, second, name=name, drive=name in self.reach, **more)
        return linkage


def beside(place: Vector, far: float, rng: np.random.Generator) -> np.ndarray:
    """A place near another, no component farther off than `far`."""
    return np.add(place, rng.uniform(-far, far, len(place)))


def kind(function: Callable[[np.random.Generator], Recipe]) -> Callable[[np.random.Generator], Recipe]:
    """Enter a kind of linkage under the name of its function."""
    KINDS[function.__name__] = function
    return function


@kind
def six_bar(rng: np.random.Generator) -> Recipe:
    """A four-bar whose coupler carries a dyad, the second rocker on the ground (Stephenson III)."""
    out = Recipe(reach={"A": 3.0})
    places = {"A": (0, 0), "B": (0, 1), "C": (2.5, 2), "D": (2.5, 0), "E": (1, 2.5), "P": (3, 4), "F": (4.5, 1)}
    for name, place in places.items():
        out.point(name, place + rng.uniform(-0.3, 0.3, 2))
    out.links = {"a": ["A", "B"], "b": ["B", "E", "C"], "c": ["C", "D"], "d": ["E", "P"], "e": ["P", "F"]}
    pins = {"A": "_a", "B": "ab", "C": "bc", "D": "_c", "E": "bd", "P": "de", "F": "_e"}
    for name, (first, second) in pins.items():
        out.joint("revolute", name, name, "ground" if first == "_" else first, second)
    return out


@kind
def two_drives(rng: np.random.Generator) -> Recipe:
    """A five-bar, one of its arms on a slide."""
    out = Recipe(reach={"A": 2.0, "S": 0.6})
    places = {"A": (0, 0), "B": (-0.5, 1), "P": (1, 2.5), "S": (2.5, 0.5)}
    for name, place in places.items():
        out.point(name, place + rng.uniform(-0.2, 0.2, 2))
    out.links = {"a": ["A", "B"], "b": ["B", "P"], "c": ["P", "S"], "s": ["S"]}
    out.joint("revolute", "A", "A", "ground", "a")
    out.joint("revolute", "B", "B", "a", "b")
    out.joint("revolute", "P", "P", "b", "c")
    out.joint("revolute", "T", "S", "c", "s")
    out.joint("prismatic", "S", "S", "ground", "s", axis=np.append(rng.uniform(0.5, 1.0, 2), 0.0))
    return out


@kind
def rssr(rng: np.random.Generator) -> Recipe:
    """A crank and a rocker, a rod with balls between them."""
    out = Recipe(reach={"A": 0.7})
    out.point("A", rng.uniform(-0.2, 0.2, 3))
    out.point("B", beside((0.5, 0, 0), 0.2, rng))
    out.point("P", beside((1, 1.5, 1), 0.3, rng))
    out.point("D", beside((1, 0.5, 0), 0.3, rng))
    out.links = {"crank": ["A", "B"], "rod": ["B", "P"], "rocker": ["P", "D"]}
    out.joint("revolute", "A", "A", "ground", "crank", axis=beside((0.1, 0.2, 1), 0.3, rng))
    out.joint("spherical", "B", "B", "crank", "rod")
    out.joint("spherical", "P", "P", "rod", "rocker")
    out.joint("revolute", "D", "D", "ground", "rocker", axis=beside((1, 0, 0), 0.5, rng))
    return out


@kind
def rusp(rng: np.random.Generator) -> Recipe:
    """A crank and a slider, a rod with a cross and a ball between them."""
    out = Recipe(reach={"A": 1.5})
    a = out.point("A", rng.uniform(-0.2, 0.2, 3))
    b = out.point("B", a + beside((0.4, 0, 0), 0.1, rng))
    p = out.point("P", beside((0.3, 0.4, 1.5), 0.2, rng))
    out.links = {"crank": ["A", "B"], "rod": ["B", "P"], "slide": ["P"]}
    axis = beside((1.0, 0.2, 0.3), 0.3, rng)
    across = np.cross(p - b, rng.normal(size=3))
    out.joint("revolute", "A", "A", "ground", "crank", axis=np.cross(axis, b - a) + 0.3 * rng.normal(size=3))
    out.joint("universal", "B", "B", "crank", "rod", axis=across, second=np.cross(p - b, across))
    out.joint("spherical", "P", "P", "rod", "slide")
    out.joint("prismatic", "S", "P", "ground", "slide", axis=beside((0, 0, 1), 0.3, rng))
    return out


@kind
def spherical_four_bar(rng: np.random.Generator) -> Recipe:
    """Four hinges whose axes meet in a point."""
    out = Recipe(reach={"A": 0.3})
    ways = {"A": (1, 0, 0), "B": (0.9, 0.4, 0.3), "C": (0.3, 0.4, 1), "D": (0, 0.1, 1)}
    for name, way in ways.items():
        out.point(name, way + rng.uniform(-0.15, 0.15, 3))
    out.point("P", beside((0.7, 0.7, 0.7), 0.2, rng))
    out.links = {"a": ["A", "B"], "b": ["B", "P", "C"], "c": ["C", "D"]}
    for name, (first, second) in {"A": "_a", "B": "ab", "C": "bc", "D": "_c"}.items():
        out.joint("revolute", name, name, "ground" if first == "_" else first, second, axis=out.points[name])
    return out


def leg(out: Recipe, k: int, foot: np.ndarray, head: np.ndarray, rng: np.random.Generator) -> None:
    """A driven leg, its cylinder yet to be joined to the ground."""
    for name, place in {"F": foot, "M": 0.5 * (foot + head), "H": head}.items():
        out.point(f"{name}{k}", place)
    out.links |= {f"cylinder {k}": [f"F{k}", f"M{k}"], f"piston {k}": [f"M{k}", f"H{k}"]}
    out.joint("prismatic", f"M{k}", f"M{k}", f"cylinder {k}", f"piston {k}", axis=head - foot)
    out.joint("spherical", f"H{k}", f"H{k}", f"piston {k}", "top")
    out.reach[f"M{k}"] = 0.05


@kind
def three_rps(rng: np.random.Generator) -> Recipe:
    """A platform on three driven legs in hinges."""
    out = Recipe()
    out.point("P", (0, 0, 0.6))
    for k in range(3):
        angle = 2.0 * np.pi * k / 3.0 + rng.uniform(-0.2, 0.2)
        out_, side = np.array([np.cos(angle), np.sin(angle), 0]), (-np.sin(angle), np.cos(angle), 0.0)
        leg(
            out,
            k,
            0.4 * out_ + rng.uniform(-0.05, 0.05, 3),
            0.2 * out_ + beside((0, 0, 0.6), 0.05, rng),
            rng,
        )
        out.joint("revolute", f"F{k}", f"F{k}", "ground", f"cylinder {k}", axis=side)
    out.links["top"] = ["P", "H0", "H1", "H2"]
    return out
