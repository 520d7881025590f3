r"""Planar 5R robot: two drives, one point.

             P                 Where P is wanted, each arm is a triangle by itself: that gives the drives.
           /   \ rod           Where the drives are given, P is where two circles about B and D meet.
         /      \
      B o        o D           Where both rods lie in line the drives are locked and P moves all the same
         \      /              (a singularity of the output); where an arm and its rod do, P is at the
        A #    # E  arm        edge of its field (of the input).
"""

import numpy as np
from linkframe.models import Linkage

BASE, ARM, ROD = 0.2, 0.3, 0.4


def arm_angle(x, y, side):
    """Angle of an arm, elbow outside, for a wanted place of P; side -1 is A's, +1 is E's."""
    x = x - side * BASE / 2
    reach = np.hypot(x, y)
    return np.arctan2(y, x) - side * np.arccos((ARM**2 + reach**2 - ROD**2) / (2 * ARM * reach))


def elbow(angle, side):
    """Where the arm ends."""
    return side * BASE / 2 + ARM * np.cos(angle), ARM * np.sin(angle)


home = (0.0, 0.5)
left, right = arm_angle(*home, -1), arm_angle(*home, 1)
linkage = Linkage(A=(-BASE / 2, 0), B=elbow(left, -1), P=home, D=elbow(right, 1), E=(BASE / 2, 0))
linkage.link("left arm", "A", "B")
linkage.link("left rod", "B", "P")
linkage.link("right rod", "D", "P")
linkage.link("right arm", "E", "D")
linkage.revolute("A", "ground", "left arm", drive=True, reference=left)
linkage.revolute("B", "left arm", "left rod")
linkage.revolute("P", "left rod", "right rod")
linkage.revolute("D", "right rod", "right arm")
linkage.revolute("E", "ground", "right arm", drive=True, reference=right)

# A circle of 100 mm radius about the home position, begun from its lowest point.
turn = np.linspace(0.0, 2.0 * np.pi, 121)
wanted = np.stack([0.1 * np.sin(turn), 0.5 - 0.1 * np.cos(turn)])
motion = linkage.move(A=arm_angle(*wanted, -1), E=arm_angle(*wanted, 1))
path = motion.position("P")[:, :2].T
mobility = linkage.mobility()

if __name__ == "__main__":
    print(mobility)
    print(f"P is off the wanted circle by {np.abs(path - wanted).max():.1e} m")
