"""A spring with a nonlinear law as an element of one's own: it hardens as it is stretched.

    A /\\/\\/\\/\\ B --> F         F = k e + c e³ at the elongation e

Linear solutions follow the springs, which are the law's stiffness at rest, and say how far that holds. Large
displacement follows the law: its energy, its force and its tangent.
"""

from dataclasses import dataclass

import numpy as np
from linkframe.framework import Frame, LineElement, straight_shapes


@dataclass(frozen=True, eq=False)
class Hardening(LineElement):
    """Spring of stiffness k (...) at rest, and of a force that grows by c (...) times the cube of the elongation."""

    k: np.ndarray
    c: np.ndarray

    @property
    def shape(self):
        return np.broadcast_shapes(np.shape(self.k), np.shape(self.c))

    def shape_functions(self, length, x):
        return straight_shapes(length, x)

    def springs(self, length):
        return np.asarray(self.k)[..., None], np.array([[-1.0, 0, 0, 0, 0, 0, 1.0, 0, 0, 0, 0, 0]])

    def resistance(self, length, deformation, pick):
        e, k, c = deformation[:, 0], pick(np.asarray(self.k), 0), pick(np.asarray(self.c), 0)
        force, tangent = np.zeros((len(e), 7)), np.zeros((len(e), 7, 7))
        force[:, 0], tangent[:, 0, 0] = k * e + c * e**3, k + 3.0 * c * e**2
        return 0.5 * k * e**2 + 0.25 * c * e**4, force, tangent


STIFFNESS, CUBE = 1000.0, 4e4
force = np.array([10.0, 100.0, 1000.0])
frame = Frame()
frame.node("A", (0.0, 0.0, 0.0))
frame.node("B", (0.5, 0.0, 0.0))
frame.add("AB", Hardening(STIFFNESS, CUBE), "A", "B")
frame.fix("A")
frame.fix("B", "uy", "uz")
frame.load("B", fx=force)
linear, elongation = frame.solve(), frame.solve(large=True).displacement("B")[:, 0]

if __name__ == "__main__":
    for row in zip(force, linear.displacement("B")[:, 0], linear.linear, elongation, strict=True):
        print("{:6.0f} N: linear {:.5f} m (holds: {}), by its law {:.5f} m".format(*row))
