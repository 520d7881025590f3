"""Cables as elements of one's own: they pull and do not push, and where they would push they are slack.

        B --> F        a mast, hinged at its foot, that two stays hold: against F only the one behind it pulls,
       /|\\             with F / cos a
      / | \\ a
     C  A  D

Linear solutions follow the cable as it is at rest. What is slack is found by going through them again: a cable that is
pressed is slack, one that is slack and whose ends move apart is taut, until nothing changes any more. Each batch entry
has its own, and its status. Large displacement follows the law, and needs no more.
"""

from dataclasses import dataclass

import numpy as np
from linkframe.elements import Beam, Circle, Material
from linkframe.framework import Frame, LineElement, straight_shapes


@dataclass(frozen=True, eq=False)
class Cable(LineElement):
    """Cable of stiffness EA (...), which resists where it is taut, (...)."""

    EA: np.ndarray
    taut: np.ndarray | bool = True
    mass: float = 0.0

    @property
    def shape(self):
        return np.broadcast_shapes(np.shape(self.EA), np.shape(self.taut))

    def shape_functions(self, length, x):
        return straight_shapes(length, x)

    def springs(self, length):
        pull = np.array([[-1.0, 0, 0, 0, 0, 0, 1.0, 0, 0, 0, 0, 0]])
        return (self.EA * self.taut / np.asarray(length, dtype=float))[..., None], pull

    def resistance(self, length, deformation, pick):
        stretch = np.maximum(deformation[:, 0], 0.0)
        k = pick(np.asarray(self.EA * self.taut, dtype=float), 0) / length
        force, tangent = np.zeros((len(k), 7)), np.zeros((len(k), 7, 7))
        force[:, 0], tangent[:, 0, 0] = k * stretch, np.where(deformation[:, 0] < 0.0, 0.0, k)
        return 0.5 * k * stretch**2, force, tangent

    def mass_per_length(self, fraction):
        return np.asarray(self.mass)


def settled(build, cables, most=20):
    """Solution of ``build(taut)`` whose cables pull or are slack, and the status of each, (...), by name."""
    taut = dict.fromkeys(cables, np.array(True))
    for _ in range(most):
        solution, before = build(taut).solve(), taut
        taut = {name: stretch(solution, name) > 0.0 for name in cables}
        if all(np.all(taut[name] == before[name]) for name in cables):
            return solution, {name: np.where(taut[name], "taut", "slack") for name in cables}
    raise ValueError(f"the cables did not settle in {most} rounds")


def stretch(solution, name):
    """How far the ends of a member move apart, (...)."""
    member = solution.frame.members[name]
    apart = (solution.displacement(member.end) - solution.displacement(member.start))[..., :3]
    return np.sum(apart * solution.frame.chord(name), axis=-1)


HEIGHT, WIDTH, EA = 3.0, 2.0, 1e6
force = np.array([-1000.0, 500.0, 2000.0])


def mast(taut):
    """The mast with its stays, as each is taut or slack."""
    frame = Frame()
    for name, place in {"A": (0, 0, 0), "B": (0, HEIGHT, 0), "C": (-WIDTH, 0, 0), "D": (WIDTH, 0, 0)}.items():
        frame.node(name, place)
    frame.add("mast", Beam(Circle(diameter=0.1), Material(E=210e9, nu=0.3)), "A", "B")
    for name, foot in {"left": "C", "right": "D"}.items():
        frame.add(name, Cable(EA, taut[name]), foot, "B")
        frame.fix(foot)
    frame.fix("A", "ux", "uy", "uz", "rx", "ry")
    frame.load("B", fx=force)
    return frame


solution, status = settled(mast, ("left", "right"))
by_law = mast({"left": True, "right": True}).solve(large=True)
pull = {name: solution.forces(name, [0.0])[:, 0, 0] for name in status}

if __name__ == "__main__":
    for name in status:
        print(f"{name} stay:", *(f"{word} {value:.1f} N" for word, value in zip(status[name], pull[name], strict=True)))
