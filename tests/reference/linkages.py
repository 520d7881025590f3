"""Linkages drawn for tests, from their textbook dimensions."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from linkframe.models import Linkage
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]
PLANAR = Rotation.identity()


def four_bar(
    crank: float,
    coupler: float,
    rocker: float,
    ground: float,
    theta: float,
    crossed: bool = False,
    turn: Rotation = PLANAR,
    scale: float = 1.0,
) -> Linkage:
    """Four-bar A B D E, its crank drawn at `theta`; in another plane by `turn`."""
    b = crank * np.exp(1j * theta)
    chord = ground - b
    along = (coupler**2 - rocker**2 + abs(chord) ** 2) / (2.0 * abs(chord))
    height = np.sqrt(max(coupler**2 - along**2, 0.0))
    d = b + (along + (-1j if crossed else 1j) * height) * chord / abs(chord)
    places = {"A": 0j, "B": b, "D": d, "E": complex(ground)}
    linkage = Linkage({name: scale * turn.apply((z.real, z.imag, 0.0)) for name, z in places.items()})
    axis = turn.apply((0.0, 0.0, 1.0))
    linkage.link("crank", "A", "B")
    linkage.link("coupler", "B", "D")
    linkage.link("rocker", "D", "E")
    linkage.revolute("A", "ground", "crank", axis=axis, drive=True, reference=theta)
    linkage.revolute("B", "crank", "coupler", axis=axis)
    linkage.revolute("D", "coupler", "rocker", axis=axis)
    linkage.revolute("E", "ground", "rocker", axis=axis, reference=float(np.angle(d - ground)))
    return linkage


def n_four_bar(n: int, theta: float) -> Linkage:
    """IFToMM benchmark A02: n windows of rods of length 1, their uprights at `theta`; n parallelograms side by side."""
    linkage = Linkage()
    for k in range(n + 1):
        linkage.point(f"A{k}", (k, 0.0))
        linkage.point(f"B{k}", (k + np.cos(theta), np.sin(theta)))
        linkage.link(f"rod {k}", f"A{k}", f"B{k}")
        linkage.revolute(f"A{k}", "ground", f"rod {k}", drive=k == 0, reference=theta)
    for k in range(n):
        linkage.link(f"bar {k}", f"B{k}", f"B{k + 1}")
    for k in range(n + 1):
        bars = [f"bar {j}" for j in (k - 1, k) if 0 <= j < n]
        linkage.revolute(f"B{k}", f"rod {k}", *bars)
    return linkage


def loop(lengths: Sequence[float], twists: Sequence[float], angles: Sequence[float]) -> Linkage:
    """Closed chain of hinges by Denavit and Hartenberg: turn about the hinge, go along the link, lean to the next.

    The last link is the ground; hinges H0, H1, ..., of which the first is driven.
    """
    place, turn, linkage, axes = np.zeros(3), Rotation.identity(), Linkage(), []
    for k, (length, twist, angle) in enumerate(zip(lengths, twists, angles, strict=True)):
        linkage.point(f"H{k}", place)
        axes.append(turn.apply((0.0, 0.0, 1.0)))
        turn = turn * Rotation.from_euler("z", angle)
        place = place + turn.apply((length, 0.0, 0.0))
        turn = turn * Rotation.from_euler("x", twist)
    last = len(lengths) - 1
    names = ["ground", *(f"link {k}" for k in range(last)), "ground"]
    for k in range(last):
        linkage.link(names[k + 1], f"H{k}", f"H{k + 1}")
    for k, axis in enumerate(axes):
        linkage.revolute(f"H{k}", names[k], names[k + 1], axis=axis, reference=angles[k], drive=k == 0)
    return linkage


def bennett(alpha: float, beta: float, theta: float) -> Linkage:
    """Bennett's linkage with angles α and β between neighbouring hinges, the first at θ."""
    a, b = 1.0, np.sin(beta) / np.sin(alpha)
    phi = 2.0 * np.arctan(np.sin((beta + alpha) / 2) / np.sin((beta - alpha) / 2) / np.tan(theta / 2))
    return loop((a, b, a, b), (alpha, beta, alpha, beta), (theta, phi, -theta, -phi))


def rssr(
    crank: float, rod: float, rocker: float, pivot: Sequence[float], theta: float, universal: bool = False
) -> Linkage:
    """Crank about z at O, rocker about x at Q, a rod with balls at B and D between them; or a universal joint at B."""
    b = crank * np.array([np.cos(theta), np.sin(theta), 0.0])
    q = np.asarray(pivot, dtype=np.float64)
    p, r = 2 * rocker * (q[1] - b[1]), 2 * rocker * q[2]
    c = rod**2 - rocker**2 - np.sum((q - b) ** 2)
    phi = float(np.arctan2(r, p) - np.arccos(c / np.hypot(p, r)))
    d = q + rocker * np.array([0.0, np.cos(phi), np.sin(phi)])
    linkage = Linkage(O=(0, 0, 0), B=b, Q=q, D=d)
    linkage.link("crank", "O", "B")
    linkage.link("rod", "B", "D")
    linkage.link("rocker", "D", "Q")
    linkage.revolute("O", "ground", "crank", drive=True, reference=theta)
    if universal:
        across = np.cross(d - b, (0.0, 0.0, 1.0))
        linkage.universal("B", "crank", "rod", axis=across, second=np.cross(across, d - b))
    else:
        linkage.spherical("B", "crank", "rod")
    linkage.spherical("D", "rod", "rocker")
    linkage.revolute("Q", "ground", "rocker", axis=(1, 0, 0), reference=phi)
    return linkage


def limited_four_bar() -> Linkage:
    """A four-bar A B C D whose crank cannot turn fully."""
    linkage = Linkage(A=(0, 0), B=(0, 0.6), C=(0.7, 0.8), D=(1, 0))
    for link in ("AB", "BC", "CD"):
        linkage.link(link, *link)
    linkage.revolute("A", "ground", "AB", drive=True)
    for joint, first, second in (("B", "AB", "BC"), ("C", "BC", "CD"), ("D", "CD", "ground")):
        linkage.revolute(joint, first, second)
    return linkage


def parallel_cranks() -> Linkage:
    """Three parallel cranks on one coupler: one more than its motion takes."""
    linkage = Linkage(A=(0, 0), B=(0.3, 1), C=(2, 0), D=(2.3, 1), E=(4, 0), F=(4.3, 1))
    for name, on in {"one": "AB", "two": "CD", "three": "EF", "coupler": "BDF"}.items():
        linkage.link(name, *on)
    linkage.revolute("A", "ground", "one", drive=True)
    for point, first, second in (("B", "one", "coupler"), ("D", "coupler", "two"), ("F", "coupler", "three")):
        linkage.revolute(point, first, second)
    linkage.revolute("C", "two", "ground")
    linkage.revolute("E", "three", "ground")
    return linkage


def scissor(stages: int) -> Linkage:
    """Pairs of bars of length 1 crossed in their middles, one on the other, drawn apart by the foot of the first."""
    rise = {f"{side}{k}": (x, 0.6 * k) for k in range(stages + 1) for side, x in (("L", 0.0), ("R", 0.8))}
    linkage = Linkage(rise | {f"M{k}": (0.4, 0.6 * k + 0.3) for k in range(stages)})
    for k in range(stages):
        linkage.link(f"a{k}", f"L{k}", f"M{k}", f"R{k + 1}")
        linkage.link(f"b{k}", f"R{k}", f"M{k}", f"L{k + 1}")
    linkage.link("foot", "R0")
    linkage.revolute("L0", "ground", "a0")
    linkage.prismatic("R0", "ground", "foot", name="slide", axis=(1, 0), drive=True)
    linkage.revolute("R0", "foot", "b0")
    for k in range(stages):
        linkage.revolute(f"M{k}", f"a{k}", f"b{k}")
        if k:
            linkage.revolute(f"L{k}", f"b{k - 1}", f"a{k}")
            linkage.revolute(f"R{k}", f"a{k - 1}", f"b{k}")
    return linkage


def rockers(loops: int) -> Linkage:
    """Rockers on the ground in a row, each pulled by the one before it, all about as far."""
    linkage = Linkage({f"D{k}": (3.0 * k, 0.0) for k in range(loops + 1)})
    for k in range(loops + 1):
        linkage.point(f"C{k}", (3.0 * k + 0.01 * (k % 3), 1.0 + 0.3 * (k % 2)))
        linkage.point(f"B{k}", (3.0 * k, 1.3 - 0.3 * (k % 2)))
        linkage.link(f"l{k}", f"D{k}", f"C{k}", f"B{k}", mass=1.0 + 0.1 * k)
        linkage.revolute(f"D{k}", "ground", f"l{k}", drive=k == 0)
    for k in range(loops):
        linkage.link(f"b{k}", f"B{k}", f"C{k + 1}", mass=0.5)
        linkage.revolute(f"B{k}", f"l{k}", f"b{k}")
        linkage.revolute(f"C{k + 1}", f"b{k}", f"l{k + 1}")
    linkage.gravity((0.0, -9.81))
    return linkage
