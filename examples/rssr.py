r"""RSSR: two shafts in space, coupled by a rod with a ball at each end.

        crank r about z at O:    B = (r cos θ, r sin θ, 0)
        rocker s about x at Q:   D = Q + s (0, cos φ, sin φ)
        rod:                     |D − B|² = l²    gives    p cos φ + q sin φ = c

    with p = 2 s (Qy − r sin θ), q = 2 s Qz, c = l² − s² − |Q − B|², so that

        φ = atan2(q, p) ± arccos(c / √(p² + q²))

The rod can turn about itself: a freedom that moves nothing else. (R. S. Hartenberg and J. Denavit, Kinematic Synthesis
of Linkages, McGraw-Hill 1964, chapter 12.)
"""

import numpy as np
from linkframe.models import Linkage

CRANK, ROCKER, ROD = 0.1, 0.25, 0.4
PIVOT = np.array([0.15, 0.1, 0.3])


def pin(theta):
    """Where the crank's ball is, (..., 3)."""
    return CRANK * np.stack([np.cos(theta), np.sin(theta), np.zeros_like(theta)], axis=-1)


def rocker_angle(theta):
    """Angle of the rocker by the closed form."""
    p, q = 2 * ROCKER * (PIVOT[1] - CRANK * np.sin(theta)), 2 * ROCKER * PIVOT[2]
    c = ROD**2 - ROCKER**2 - np.sum((PIVOT - pin(theta)) ** 2, axis=-1)
    return np.arctan2(q, p) - np.arccos(c / np.hypot(p, q))


start = np.asarray(0.3)
phi = rocker_angle(start)
linkage = Linkage(O=(0, 0, 0), B=pin(start), Q=PIVOT, D=PIVOT + ROCKER * np.array([0, np.cos(phi), np.sin(phi)]))
linkage.link("crank", "O", "B")
linkage.link("rod", "B", "D")
linkage.link("rocker", "D", "Q")
linkage.revolute("O", "ground", "crank", drive=True, reference=start)
linkage.spherical("B", "crank", "rod")
linkage.spherical("D", "rod", "rocker")
linkage.revolute("Q", "ground", "rocker", axis=(1, 0, 0), reference=phi)

theta = np.linspace(0.0, 2.0 * np.pi, 73)
motion = linkage.move(O=theta, rates={"O": 1.0})
angle = motion.coordinate("Q")[:, 0]
mobility = linkage.mobility()

if __name__ == "__main__":
    print(mobility)
    print(f"rocker from {np.degrees(angle.min()):.3f}° to {np.degrees(angle.max()):.3f}°")
    print(f"off the closed form by {np.abs(angle - rocker_angle(theta)).max():.1e} rad")
