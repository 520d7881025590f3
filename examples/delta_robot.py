r"""Delta robot: three driven arms and three parallelograms keep a platform level.

        base   #----.                    An arm turns by q about a tangent of the base circle (positive downwards); two
               arm   \                   rods with balls at their ends lead from it to the platform. The platform
                      o o                only moves along, so each parallelogram counts as one rod, and the wanted
               rods  // /                place gives each arm by itself:
                    // /                      e cos q + f sin q = g
          platform o-o
                                         (R. Clavel, DELTA, a fast robot with parallel geometry, 18th Int. Symp. on
                                         Industrial Robots, 1988, p. 91.)

Each rod can spin about itself: six freedoms that move nothing else.
"""

import numpy as np
from linkframe.models import Linkage

BASE, PLATFORM, ARM, ROD, WIDTH = 0.2, 0.05, 0.2, 0.5, 0.06
DOWN = np.array([0.0, 0.0, -1.0])
HEADINGS = np.radians([0.0, 120.0, 240.0])
outward = np.stack([np.cos(HEADINGS), np.sin(HEADINGS), np.zeros(3)], axis=-1)
tangent = np.stack([-np.sin(HEADINGS), np.cos(HEADINGS), np.zeros(3)], axis=-1)


def arm_angles(place):
    """Angles of the three arms below the horizontal, (..., 3), for a wanted place of the platform (..., 3).

    With w = place + (PLATFORM − BASE) outward, the vector from the arm's pivot to where the rod ends, the rod's length
    gives |w|² + ARM² − ROD² = 2 ARM w·(outward cos q + DOWN sin q).
    """
    reach = place[..., None, :] + (PLATFORM - BASE) * outward
    e, f = 2 * ARM * np.sum(reach * outward, axis=-1), 2 * ARM * (reach @ DOWN)
    g = np.sum(reach**2, axis=-1) + ARM**2 - ROD**2
    return np.arctan2(f, e) - np.arccos(g / np.hypot(e, f))


home = np.array([0.0, 0.0, -0.45])
start = arm_angles(home)
linkage = Linkage(P=home)
for k in range(3):
    pivot = BASE * outward[k]
    linkage.point(f"A{k}", pivot)
    for side in "lr":
        shift = {"l": -0.5, "r": 0.5}[side] * WIDTH * tangent[k]
        linkage.point(f"B{k}{side}", pivot + ARM * (outward[k] * np.cos(start[k]) + DOWN * np.sin(start[k])) + shift)
        linkage.point(f"C{k}{side}", home + PLATFORM * outward[k] + shift)

linkage.link("platform", "P", *(f"C{k}{side}" for k in range(3) for side in "lr"))
for k in range(3):
    linkage.link(f"arm {k}", f"A{k}", f"B{k}l", f"B{k}r")
    linkage.revolute(f"A{k}", "ground", f"arm {k}", axis=tangent[k], drive=True, reference=start[k])
    for side in "lr":
        linkage.link(f"rod {k}{side}", f"B{k}{side}", f"C{k}{side}")
        linkage.spherical(f"B{k}{side}", f"arm {k}", f"rod {k}{side}")
        linkage.spherical(f"C{k}{side}", f"rod {k}{side}", "platform")

# A helix of three turns.
s = np.linspace(0.0, 3.0, 91)
wanted = home + np.stack([0.1 * np.sin(2 * np.pi * s), 0.1 * np.cos(2 * np.pi * s) - 0.1, -0.03 * s], axis=-1)
drives = arm_angles(wanted)
motion = linkage.move({f"A{k}": drives[:, k] for k in range(3)})
path, axes = motion.position("P"), motion.axes("platform")

if __name__ == "__main__":
    print(f"the platform is off the wanted path by {np.abs(path - wanted).max():.1e} m")
    print(f"and off level by {np.abs(axes - np.eye(3)).max():.1e} rad")
