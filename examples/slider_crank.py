r"""Slider-crank with an offset: where the piston is, and where the crank is powerless against it.

     B
    / `--._  rod l                x(θ) = r cos θ + √(l² − (r sin θ − e)²)
 r /       `--._
  / θ           C ═ ═ ▷ x         Driven by the crank it turns for ever. Driven by the piston it has two dead
A o - - - - - - | e               points, crank and rod in line: x² = (l ± r)² − e²
"""

import numpy as np
from linkframe.models import Linkage

CRANK, ROD, OFFSET = 0.05, 0.2, 0.012


def place(theta):
    """Piston by the closed form."""
    return CRANK * np.cos(theta) + np.sqrt(ROD**2 - (CRANK * np.sin(theta) - OFFSET) ** 2)


def slope(theta):
    """Its derivative by the crank's angle."""
    high = CRANK * np.sin(theta) - OFFSET
    return -CRANK * np.sin(theta) - high * CRANK * np.cos(theta) / np.sqrt(ROD**2 - high**2)


START = np.radians(60.0)
linkage = Linkage(A=(0, 0), B=(CRANK * np.cos(START), CRANK * np.sin(START)), C=(place(START), OFFSET))
linkage.link("crank", "A", "B")
linkage.link("rod", "B", "C")
linkage.link("piston", "C")
linkage.revolute("A", "ground", "crank", drive=True, reference=START)  # angles are counted from x
linkage.revolute("B", "crank", "rod")
linkage.revolute("C", "rod", "piston")
linkage.prismatic("C", "ground", "piston", axis=(1, 0, 0), reference=place(START), name="slide")

theta = np.radians(np.arange(0.0, 361.0, 5.0))
motion = linkage.move(A=theta, rates={"A": 10.0})
piston, velocity = motion.position("C")[:, 0], motion.velocity("C")[:, 0]
transmission = motion.transmission_angle("C")

ends = linkage.dead_points("slide")

if __name__ == "__main__":
    print(f"piston from {1e3 * piston.min():.3f} to {1e3 * piston.max():.3f} mm in steps of 5°")
    print(f"least transmission angle {np.degrees(transmission.min()):.2f}°")
    for point in ends:
        print(f"dead point at {1e3 * point.value:.6f} mm: {point.status}")
