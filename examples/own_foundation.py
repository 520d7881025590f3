"""A beam on an elastic foundation as an element of one's own: the springs of its section law, and those below it.

    F
    v
    A===============B        deflection below F (Hetényi, Beams on Elastic Foundation, 1946, sec. 21):
    : : : : : : : : :        2 F λ / k (sh ch - s c) / (sh² - s²) at λL,  λ⁴ = k / 4 E I

A spring is a stiffness, and how the twelve end displacements deform it: here the deflection at a point of quadrature.
(`frame.add_form` does the same to any member, without a new element.)
"""

from dataclasses import dataclass

import numpy as np
from linkframe.framework import Frame, LineElement, cubic_shapes


@dataclass(frozen=True, eq=False)
class Footing(LineElement):
    """Slender beam with stiffnesses EA, GJ, EI on a foundation of modulus k (...), which acts in its local y."""

    EA: float
    GJ: float
    EI: float
    k: np.ndarray
    mass: float = 0.0
    segments: int = 1

    @property
    def shape(self):
        return np.shape(self.k)

    def shape_functions(self, length, x):
        return cubic_shapes(length, x)

    def section_flexibility(self, fraction):
        return np.array([1.0 / self.EA, 0.0, 0.0, 1.0 / self.GJ, 1.0 / self.EI, 1.0 / self.EI])

    def springs(self, length):
        stiffness, rows = super().springs(length)
        points, weights = self.integration_points
        below = np.stack([self.shape_functions(length, s * length)[..., 1, :] for s in points], axis=-2)
        resist = (self.k * np.asarray(length, dtype=float))[..., None] * weights
        stiffness = np.broadcast_to(stiffness, (*resist.shape[:-1], stiffness.shape[-1]))
        return np.concatenate([stiffness, resist], axis=-1), np.concatenate([rows, below], axis=-2)

    def mass_per_length(self, fraction):
        return np.asarray(self.mass)


LENGTH, FORCE, EI = 4.0, 1000.0, 8e5
modulus = np.array([1e5, 2e5, 4e5])
frame = Frame()
frame.node("A", (0.0, 0.0, 0.0))
frame.node("B", (LENGTH, 0.0, 0.0))
frame.add("AB", Footing(4e8, 4e5, EI, modulus, segments=16), "A", "B")
frame.fix("A", "ux", "uz", "rx", "ry")
frame.load("A", fy=-FORCE)
deflection = -frame.solve().displacement("A")[:, 1]

rate = (modulus / (4.0 * EI)) ** 0.25
s, c, sh, ch = (f(rate * LENGTH) for f in (np.sin, np.cos, np.sinh, np.cosh))
expected = 2.0 * FORCE * rate / modulus * (sh * ch - s * c) / (sh**2 - s**2)

if __name__ == "__main__":
    print("deflection below the load", 1e3 * deflection, "mm; by the closed form", 1e3 * expected)
