"""The symmetric four-bar of the accuracy paper: how far a force on its coupler bends it, at every pose.

             P ↑ F
      B o----+----o D        the drive is clamped at A; at 0° and 180° coupler and
       /         /           rocker lie in line and the linkage can move all the same:
    A #- - - - -o E          there the answer is a status, and no number

four_bar_picture.py draws it.
"""

import warnings

import numpy as np
from linkframe.framework import MechanismWarning
from linkframe.models import FourBar

theta = np.radians(np.arange(0.0, 361.0, 2.0))
motion = FourBar(crank=0.1, coupler=0.2, rocker=0.1, ground=0.2, point=(0.1, 0.0)).move(theta)
frame = motion.frame()
frame.load("P", fy=100.0)
solution = frame.solve()

with warnings.catch_warnings():
    warnings.simplefilter("ignore", MechanismWarning)  # the two change points are meant
    compliance = np.linalg.norm(solution.displacement("P")[:, :3], axis=-1)
singular = np.degrees(theta[motion.singular])

if __name__ == "__main__":
    print(f"singular at {', '.join(f'{angle:g}°' for angle in singular)}")
    print(f"compliance from {1e6 * np.nanmin(compliance):.2f} to {1e6 * np.nanmax(compliance):.0f} µm")
