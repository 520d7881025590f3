r"""Stephenson III six-bar driven through its dyad: no link can be placed before the others.

       P o-------o F
       / \        \          A B D E is a four-bar with the coupler point P; the dyad P F G hangs on it.
      /   \        \         Driven at A, one link is found after the other. Driven at G, none of the four
B o--+-----o D      \        bars has a known end: coupler, crank and rocker hold each other (a triad, or
 /          \        #       Assur group of class III), and dyads give no formula. Newton does not mind.
#            #       G
A            E
"""

import numpy as np
from linkframe.models import Linkage

linkage = Linkage(A=(0, 0), B=(0, 0.2), P=(0.12, 0.32), D=(0.25, 0.2), E=(0.3, 0), F=(0.4, 0.4), G=(0.6, 0))
linkage.link("crank", "A", "B")
linkage.link("coupler", "B", "P", "D")
linkage.link("rocker", "D", "E")
linkage.link("rod", "P", "F")
linkage.link("arm", "F", "G")
linkage.revolute("A", "ground", "crank")
linkage.revolute("B", "crank", "coupler")
linkage.revolute("D", "coupler", "rocker")
linkage.revolute("E", "rocker", "ground")
linkage.revolute("P", "coupler", "rod")
linkage.revolute("F", "rod", "arm")
linkage.revolute("G", "ground", "arm", drive=True)

reach = linkage.drive_range("G")
swing = np.linspace(reach.lower + 0.01, reach.upper - 0.01, 81)
motion = linkage.move(G=swing)
crank = motion.coordinate("A")[:, 0]
path = motion.position("P")

if __name__ == "__main__":
    print(f"the arm can go from {np.degrees(reach.lower):.6f}°, where joint {reach.lower_joint} is stretched,")
    print(f"to {np.degrees(reach.upper):.6f}°, where joint {reach.upper_joint} is")
    print(f"the crank goes from {np.degrees(crank[0]):.2f}° to {np.degrees(crank[-1]):.2f}° meanwhile")
