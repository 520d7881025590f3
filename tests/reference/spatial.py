"""Spatial linkages drawn for tests."""

from __future__ import annotations

import numpy as np
from linkframe.models import Linkage
from numpy.typing import NDArray

Array = NDArray[np.float64]


def stewart() -> tuple[Linkage, Array, Array]:
    """Six legs with universal, driven prismatic and spherical joints under a platform with the point O; their ends."""
    low, high = np.radians([0, 20, 120, 140, 240, 260]), np.radians([-40, 60, 80, 180, 200, 300])
    base = np.stack([np.cos(low), np.sin(low), 0 * low], axis=-1)
    top = np.stack([0.6 * np.cos(high), 0.6 * np.sin(high), 0 * high + 1.1], axis=-1)
    points = {"O": (0.0, 0.0, 1.1)}
    for k in range(6):
        points |= {f"B{k}": base[k], f"M{k}": 0.5 * (base[k] + top[k]), f"P{k}": top[k]}
    linkage = Linkage(points)
    linkage.link("platform", *(f"P{k}" for k in range(6)), "O")
    for k in range(6):
        leg = (top[k] - base[k]) / np.linalg.norm(top[k] - base[k])
        level = np.cross(leg, (0, 0, 1)) / np.linalg.norm(np.cross(leg, (0, 0, 1)))
        linkage.link(f"lower {k}", f"B{k}", f"M{k}")
        linkage.link(f"upper {k}", f"M{k}", f"P{k}")
        linkage.universal(f"B{k}", "ground", f"lower {k}", axis=level, second=np.cross(leg, level))
        linkage.prismatic(f"M{k}", f"lower {k}", f"upper {k}", axis=leg, drive=True)
        linkage.spherical(f"P{k}", f"upper {k}", "platform")
    return linkage, base, top


def spatial_slider_crank(both_balls: bool = False) -> Linkage:
    """Haug's spatial slider-crank, drawn at crank angle 0; with a ball at each end the rod can spin."""
    crank_pin = np.array([0.0, 0.1, 0.2])
    linkage = Linkage(A=(0.0, 0.1, 0.12), B=crank_pin, C=(0.2, 0.0, 0.0))
    linkage.link("crank", "A", "B")
    linkage.link("rod", "B", "C")
    linkage.link("slider", "C")
    linkage.revolute("A", "ground", "crank", axis=(1, 0, 0), drive=True)
    linkage.spherical("B", "crank", "rod")
    if both_balls:
        linkage.spherical("C", "rod", "slider")
    else:
        rod = np.array([0.2, 0.0, 0.0]) - crank_pin
        across = np.cross(rod, (0.0, 0.0, 1.0))
        linkage.universal("C", "rod", "slider", axis=across, second=np.cross(across, rod))
    linkage.prismatic("C", "ground", "slider", axis=(1, 0, 0))
    return linkage
