r"""Planar 3-RRR robot: a triangular platform on three driven arms, placed and turned in the plane.

           A2 #--o B2             The drives for a wanted pose are three triangles A B C, in closed form.
                  \               The pose for given drives is a polynomial of degree six: Newton takes the root that
                   C2             hangs together with the drawing. (C. M. Gosselin and J. Angeles, The optimum
                  /  \            kinematic design of a planar three-degree-of-freedom parallel manipulator,
         B0     /  P  \           J. Mechanisms, Transmissions and Automation in Design 110 (1988) 35.)
          o---C0------C1--o B1
         /                 \
        # A0             A1 #
"""

import numpy as np
from linkframe.models import Linkage

BASE, PLATFORM, ARM, ROD = 0.4, 0.12, 0.25, 0.25  # radii of the triangles, lengths of the bars
CORNERS = np.radians([210.0, 330.0, 90.0])


def ring(radius, turn=0.0):
    """Three corners as complex numbers."""
    return radius * np.exp(1j * (CORNERS + np.asarray(turn)[..., None]))


def arm_angles(place, turn):
    """Angles of the three arms, (..., 3), for a wanted place x + i y and turn of the platform."""
    chord = place[..., None] + ring(PLATFORM, turn) - ring(BASE)
    reach = np.abs(chord)
    return np.angle(chord) + np.arccos((ARM**2 + reach**2 - ROD**2) / (2 * ARM * reach))


def plane(point):
    """A complex number as a pair."""
    return point.real, point.imag


home = arm_angles(np.asarray(0j), np.asarray(0.0))
linkage = Linkage(P=(0, 0))
for k in range(3):
    linkage.point(f"A{k}", plane(ring(BASE)[k]))
    linkage.point(f"B{k}", plane(ring(BASE)[k] + ARM * np.exp(1j * home[k])))
    linkage.point(f"C{k}", plane(ring(PLATFORM)[k]))
linkage.link("platform", "C0", "C1", "C2", "P")
for k in range(3):
    linkage.link(f"arm {k}", f"A{k}", f"B{k}")
    linkage.link(f"rod {k}", f"B{k}", f"C{k}")
    linkage.revolute(f"A{k}", "ground", f"arm {k}", drive=True, reference=home[k])
    linkage.revolute(f"B{k}", f"arm {k}", f"rod {k}")
    linkage.revolute(f"C{k}", f"rod {k}", "platform")

# The platform draws an eight and nods twice.
s = np.linspace(0.0, 2.0 * np.pi, 91)
place, turn = 0.06 * np.sin(s) + 0.04j * np.sin(2.0 * s), np.radians(12.0) * np.sin(2.0 * s)
drives = arm_angles(place, turn)
motion = linkage.move({f"A{k}": drives[:, k] for k in range(3)})
path, axes = motion.position("P"), motion.axes("platform")

if __name__ == "__main__":
    print(f"P is off the wanted path by {np.abs(path[:, 0] + 1j * path[:, 1] - place).max():.1e} m")
    print(f"the turn is off by {np.abs(np.arctan2(axes[:, 1, 0], axes[:, 0, 0]) - turn).max():.1e} rad")
