"""Clearance in the pins of a four-bar under load: the contact state of each journal, and where contact changes side.

             P ↑ F
            / \\
       B o-+---+-o D         pins B, D and E have a radial clearance; the load presses each journal
        /       /            against its bearing, along the force that the pin transmits: P moves
    A #- - - - o E           by  Σ ε |R| / F  beyond what links and pins deflect
"""

import numpy as np
from linkframe.models import FourBar

theta = np.radians(np.arange(0.0, 360.0, 1.0))
clearance = {"B": 20e-6, "D": 20e-6, "E": 50e-6}
motion = FourBar(crank=0.3, coupler=0.9, rocker=0.8, ground=0.7, point=(0.5, 0.2), branch="open").move(theta)
frame = motion.frame(clearance)
frame.load("P", fy=100.0)
solution, tight = frame.solve(), frame.solve(clearance=False)

by_clearance = solution.displacement("P")[:, 1] - tight.displacement("P")[:, 1]
contact = solution.contact("E")
changes = np.degrees(theta[:-1][contact.jumps()])

if __name__ == "__main__":
    print(f"clearance moves P by {1e6 * by_clearance.min():.0f} to {1e6 * by_clearance.max():.0f} µm")
    print(f"by compliance up to {1e6 * tight.displacement('P')[:, 1].max():.0f} µm")
    print(f"contact in joint E changes side after {', '.join(f'{angle:g}°' for angle in changes)}")
