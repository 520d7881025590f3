r"""Cardan shaft: two universal joints make one even turn of two uneven ones.

        input ════+
                   \ shaft, at the angle β          tan θ = cos β tan ψ      (input fork in the plane of the bend
                    \                                                         at θ = 0)
                     +════ output                   and again backwards, so that the output turns like the input

At constant speed of the input the shaft between runs between cos β and 1 / cos β of it (J. E. Shigley and J. J. Uicker,
Theory of Machines and Mechanisms, McGraw-Hill 1980, section 3-14). It slides in itself: else the two shafts would have
to lie exactly as far apart as drawn.
"""

import numpy as np
from linkframe.models import Linkage

BEND, LENGTH = np.radians(30.0), 0.6
along = np.array([np.cos(BEND), -np.sin(BEND), 0.0])
across = np.array([np.sin(BEND), np.cos(BEND), 0.0])
overhang, fork = np.array([0.2, 0.0, 0.0]), 0.05
first, second = overhang, overhang + LENGTH * along

linkage = Linkage(A=(0, 0, 0), U=first, M=(first + second) / 2, V=second, E=second + overhang)
linkage.point("I", np.add(first, (0.0, fork, 0.0)))  # tips of the forks of input and tube
linkage.point("T", np.add(first, (0.0, 0.0, fork)))
linkage.link("input", "A", "U", "I")
linkage.link("tube", "T", "U", "M")
linkage.link("rod", "M", "V")
linkage.link("output", "V", "E")
linkage.revolute("A", "ground", "input", axis=(1, 0, 0), drive=True)
linkage.universal("U", "input", "tube", axis=(0, 1, 0), second=(0, 0, 1))
linkage.prismatic("M", "tube", "rod", axis=along)
linkage.universal("V", "rod", "output", axis=(0, 0, 1), second=(0, 1, 0))
linkage.revolute("E", "ground", "output", axis=(1, 0, 0))

theta = np.linspace(0.0, 2.0 * np.pi, 121)
motion = linkage.move(A=theta, rates={"A": 1.0})
output = motion.coordinate("E")[:, 0]
shaft_speed = motion.angular_velocity("tube") @ along
cross = motion.axes("tube") @ (0.0, 0.0, 1.0)  # fork of the tube, which is square to its axis
shaft = np.unwrap(np.arctan2(-cross @ across, cross[:, 2]))

if __name__ == "__main__":
    print(f"shaft between {shaft_speed.min():.6f} and {shaft_speed.max():.6f} of the input's speed")
    print(f"output and input differ by {np.abs(output - theta).max():.1e} rad")
