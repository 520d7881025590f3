"""A six-bar made stiffer with all of its dimensions at once: 30 parameters, and one solution for each gradient.

              P              a load on P deflects links and pins. Of the places of all joints, the sections of all
             / \\             links and the stiffness of all pins those are sought that let P deflect least, while it
        E   /   \\            keeps its path and the links their weight. Gradients come from adjoints: of the position
       / \\_/     \\           through the loop closure, of the deflection through frame and loop closure. Differences
    B o---o C     \\          would take 31 solutions where this takes one.
     /    |        \\
    A     D         F
"""

from itertools import pairwise

import numpy as np
from linkframe.elements import Beam, Material, Rectangle
from linkframe.models import Linkage
from scipy.optimize import minimize

PLACES = {"A": (0, 0), "B": (0, 1), "C": (2.5, 2), "D": (2.5, 0), "E": (1, 2.5), "P": (3, 4), "F": (4.5, 1)}
LINKS = {"a": "AB", "b": "BEC", "c": "CD", "d": "EP", "e": "PF"}
PINS = {"B": "ab", "C": "bc", "D": "cg", "E": "bd", "P": "de", "F": "eg"}
STEEL = Material(E=200e9, nu=0.3, density=7800.0)
THETA = np.linspace(0.0, -0.8, 5)
FORCE = np.array([2e3, -3e3])


def six_bar(x):
    """The linkage of 30 parameters: 14 coordinates, 10 sizes of sections by their logarithm, 6 stiffnesses likewise."""
    places = {
        name: np.array(place) + step for (name, place), step in zip(PLACES.items(), x[:14].reshape(7, 2), strict=True)
    }
    linkage = Linkage(places)
    for (name, points), (y, z) in zip(LINKS.items(), 0.04 * np.exp(x[14:24].reshape(5, 2)), strict=True):
        linkage.link(name, *points, beam=Beam(Rectangle(y=y, z=z), STEEL))
    linkage.revolute("A", "ground", "a", drive=True)
    for (name, (first, second)), k in zip(PINS.items(), 1e8 * np.exp(x[24:]), strict=True):
        ends = [{"g": "ground"}.get(link, link) for link in (first, second)]
        linkage.revolute(name, *ends, stiffness=(k, k, k, 1e6, 1e6, 0.0))
    return linkage


def weight(linkage):
    """Volume of the links, by 14 coordinates and 10 logarithms of sizes."""
    total, slope, by_size = 0.0, {name: np.zeros(2) for name in PLACES}, []
    for name, points in LINKS.items():
        section, own = linkage.links[name].beams[tuple(points[:2])].section, 0.0
        for start, end in pairwise(points):
            chord = (linkage.points[end] - linkage.points[start])[:2]
            length = np.hypot(*chord)
            own += section.A * length
            slope[end] += section.A * chord / length
            slope[start] -= section.A * chord / length
        total += own
        by_size += [own, own]
    return total, np.concatenate([*slope.values(), by_size])


def cost(x):
    """Work of the load on the deflection, deviation from the path, weight and cost of stiff pins; and its gradient."""
    global solutions
    solutions += 1
    linkage = six_bar(x)
    motion = linkage.move(A=THETA)
    accuracy = motion.accuracy("P", fx=FORCE[0], fy=FORCE[1])
    work = accuracy.compliance[:, :2] @ FORCE
    off = motion.position("P")[:, :2] - path
    volume, by_volume = weight(linkage)
    value = 1e2 * work.mean() + 20.0 * np.mean(off**2) + 20.0 * (volume / 0.02 - 1.0) ** 2 + 0.5 * np.mean(x[24:] ** 2)

    by, at = accuracy.sensitivity("ux", "uy"), motion.sensitivity("P")
    slope = np.zeros(30)
    for k, name in enumerate(PLACES):
        slope[2 * k : 2 * k + 2] = 1e2 * np.mean(FORCE @ by.points[name][..., :2], axis=0)
        slope[2 * k : 2 * k + 2] += 40.0 * np.mean(np.sum(off[:, :, None] * at.points[name][:, :2, :2], axis=1), axis=0)
    for component, force in zip(("ux", "uy"), FORCE, strict=True):
        frame = by.frame[component]
        for k, (name, points) in enumerate(LINKS.items()):
            section = linkage.links[name].beams[tuple(points[:2])].section
            members = [name] if len(points) == 2 else [f"{name}.{part}" for part in range(1, len(points))]
            for j, size in enumerate(("y", "z")):
                each = sum(frame.sections[member][size] for member in members)
                slope[14 + 2 * k + j] += 1e2 * force * np.mean(each) * getattr(section, size)
        for k, name in enumerate(PINS):
            stiffness = linkage.joint(name).full_stiffness[0]
            slope[24 + k] += 1e2 * force * np.mean(frame.joints[name][..., :3].sum(axis=-1)) * stiffness
    slope[:24] += 40.0 * (volume / 0.02 - 1.0) / 0.02 * by_volume
    slope[24:] += x[24:] / 6.0
    return value, slope


solutions = 0
path = six_bar(np.zeros(30)).move(A=THETA).position("P")[:, :2]
start = np.zeros(30)
first, gradient = cost(start)
solutions = 0
found = minimize(
    cost, start, jac=True, method="L-BFGS-B", bounds=[(-0.3, 0.3)] * 14 + [(-1.0, 1.0)] * 16, options={"maxiter": 4}
)
by_differences = solutions * 31

if __name__ == "__main__":
    print(
        f"from {first:.4g} to {found.fun:.4g} in {solutions} solutions; by differences it would take {by_differences}"
    )
    for k, name in enumerate(LINKS):
        y, z = 40.0 * np.exp(found.x[14 + 2 * k : 16 + 2 * k])
        print(f"link {name}: {y:.0f} x {z:.0f} mm")
