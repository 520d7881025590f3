"""A beam with a thermal gradient as an element of one's own: a Beam, and what it strains without any force.

    A=================B      warmer below by a gradient g: curvature α g, and free
    |                        B lifts by α g L² / 2;  clamped at both ends the beam carries the moment E I α g

What strains without a force loads the frame by itself: the loads follow from the section law.
"""

from dataclasses import dataclass

import numpy as np
from linkframe.elements import Beam, Material, Rectangle
from linkframe.framework import Frame


@dataclass(frozen=True, eq=False)
class Heated(Beam):
    """Beam that is warmer by `rise` (...) in its axis, and by `gradient` (...) per length along its local y."""

    rise: np.ndarray | float = 0.0
    gradient: np.ndarray | float = 0.0
    expansion: float = 1.2e-5

    @property
    def shape(self):
        return np.broadcast_shapes(super().shape, np.shape(self.rise), np.shape(self.gradient))

    @property
    def kind(self):
        return self

    def free_strain(self, fraction):
        axis, curvature = self.expansion * np.asarray(self.rise), -self.expansion * np.asarray(self.gradient)
        return np.stack(np.broadcast_arrays(axis, 0.0, 0.0, 0.0, 0.0, curvature), axis=-1)


LENGTH, HEIGHT, WIDTH, E = 2.0, 0.1, 0.05, 210e9
gradient = np.array([-100.0, -200.0, -400.0])  # warmer below: falling along y
beam = Heated(Rectangle(y=HEIGHT, z=WIDTH), Material(E=E, nu=0.3), rise=20.0, gradient=gradient)
frame = Frame()
frame.node("A", (0.0, 0.0, 0.0))
frame.node("B", (LENGTH, 0.0, 0.0))
frame.add("AB", beam, "A", "B")
frame.fix("A")
lift, growth = frame.solve().displacement("B")[:, 1], frame.solve().displacement("B")[:, 0]
frame.fix("B")
moment = frame.solve().forces("AB", [LENGTH / 2])[:, 0, 5]

if __name__ == "__main__":
    print("free, the end lifts by", 1e3 * lift, "mm; clamped, the beam carries", moment, "N m")
