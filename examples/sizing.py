r"""The lightest jib whose tip sinks by no more than a limit: sizes of its bars by scipy.optimize.

    B o-__                 With areas A_i, lengths L_i and forces N_i of pinned bars under W the tip sinks by
      |    ‾‾--__
      |  tie      ‾-o C        Σ N_i² L_i / (E A_i W)
      |       _,-'  |
      |  _,-'       v W    and the mass ρ Σ A_i L_i is least where all stresses are the same, with areas
    A o'  strut
                               A_i = |N_i| Σ |N_j| L_j / (E W limit)

(W. Prager and J. E. Taylor, Problems of optimal structural design, Journal of Applied Mechanics 35 (1968) 102.)
One frame is described once; the search changes its bars in place, and each solution pays for numbers alone.
"""

import numpy as np
from linkframe.elements import Beam, Circle, Material
from linkframe.framework import Frame
from scipy.optimize import minimize

HEIGHT, REACH, DROP, WEIGHT, LIMIT = 1.5, 2.0, 0.5, 20e3, 2e-3  # m, m, m, N, m
steel = Material(E=210e9, nu=0.3, density=7850.0)


def bar(diameter):
    """A round bar with pins at its ends."""
    return Beam(Circle(diameter=diameter), steel, release=("start rz", "end rz"))


frame = Frame()
for name, place in {"A": (0.0, 0.0), "B": (0.0, HEIGHT), "C": (REACH, DROP)}.items():
    frame.node(name, (*place, 0.0))
frame.add("strut", bar(0.03), "A", "C")
frame.add("tie", bar(0.03), "B", "C")
frame.fix("A")
frame.fix("B")
frame.fix("C", "uz", "rx", "ry", "rz")
frame.load("C", fy=-WEIGHT)
lengths = np.array([np.hypot(REACH, DROP), np.hypot(REACH, HEIGHT - DROP)])


def mass(millimetres):
    """Mass of the jib of bars of these diameters."""
    return steel.density * np.pi / 4.0 * np.sum((1e-3 * millimetres) ** 2 * lengths)


def room(millimetres):
    """What is left of the limit at the tip, as a share of it."""
    for name, diameter in zip(("strut", "tie"), 1e-3 * millimetres, strict=True):
        frame.change(name, bar(diameter))
    return 1.0 + frame.solve().displacement("C")[1] / LIMIT


found = minimize(mass, [40.0, 40.0], bounds=[(10.0, 100.0)] * 2, constraints={"type": "ineq", "fun": room}, tol=1e-10)
diameters = 1e-3 * found.x
sinking = LIMIT * (1.0 - room(found.x))
solution = frame.solve()

if __name__ == "__main__":
    print(f"strut {1e3 * diameters[0]:.2f} mm, tie {1e3 * diameters[1]:.2f} mm: {found.fun:.2f} kg")
    print(f"the tip sinks by {1e3 * sinking:.4f} mm of {1e3 * LIMIT:g} mm allowed")
    solution.plot("N").figure.savefig("sizing.png")
