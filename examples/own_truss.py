"""A truss bar as an element of one's own, by its section law.

    A       C              a bar resists its elongation alone: 1 / EA is its flexibility, its shape a straight line
     \\     /
      \\   /  a             under the load F the node B sinks by F L / (2 EA sin² a)
        B
        | F

Shape functions and section law are all that a frame needs: stiffness, mass, buckling and loads follow from them.
"""

from dataclasses import dataclass

import numpy as np
from linkframe.framework import Frame, LineElement, straight_shapes


@dataclass(frozen=True, eq=False)
class Truss(LineElement):
    """Bar with axial stiffness EA (...) and mass per length."""

    EA: np.ndarray
    mass: float = 0.0

    @property
    def shape(self):
        return np.shape(self.EA)

    def shape_functions(self, length, x):
        return straight_shapes(length, x)

    def section_flexibility(self, fraction):
        return np.multiply.outer(1.0 / np.asarray(self.EA), [1.0, 0.0, 0.0, 0.0, 0.0, 0.0])

    def mass_per_length(self, fraction):
        return np.asarray(self.mass)


LENGTH, SLOPE, FORCE = 2.0, np.radians(50.0), 1000.0
stiffness = np.array([1e6, 2e6, 4e6])
bar = Truss(stiffness)
frame = Frame()
frame.node("A", (-LENGTH * np.cos(SLOPE), LENGTH * np.sin(SLOPE), 0.0))
frame.node("B", (0.0, 0.0, 0.0))
frame.node("C", (LENGTH * np.cos(SLOPE), LENGTH * np.sin(SLOPE), 0.0))
frame.add("AB", bar, "A", "B")
frame.add("BC", bar, "B", "C")
frame.fix("A")
frame.fix("C")
frame.fix("B", "uz")
frame.load("B", fy=-FORCE)
sinking = -frame.solve().displacement("B")[:, 1]
expected = FORCE * LENGTH / (2.0 * stiffness * np.sin(SLOPE) ** 2)

if __name__ == "__main__":
    print("B sinks by", 1e3 * sinking, "mm; by the closed form", 1e3 * expected)
