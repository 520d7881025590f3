"""The worst that clearances and tolerances can do to the coupler point of a four-bar, and which joint contributes most.

         P              every pin has 20 µm of radial clearance, every length is good to ± 10 µm, the drive to 0.1 mrad:
        / \\             around each position lies the region that P can reach, a sum of ellipses and segments;
   B o-+---+-o D        h(n) = Σ ε |Jᵀ n| + Σ t |gᵀ n|  tells how far it reaches in a direction n
    /       /
A #- - - - o E
"""

import numpy as np
from linkframe.models import Linkage

linkage = Linkage(A=(0, 0), B=(0.0, 0.1), P=(0.12, 0.19), D=(0.24, 0.16), E=(0.22, 0))
linkage.link("crank", "A", "B")
linkage.link("coupler", "B", "P", "D")
linkage.link("rocker", "D", "E")
links = ("ground", "crank", "coupler", "rocker", "ground")
for pin, first, second in zip("ABDE", links[:-1], links[1:], strict=True):
    linkage.revolute(pin, first, second, drive=pin == "A", clearance=20e-6)
motion = linkage.move(A=np.radians(np.arange(0.0, 360.0)))

lengths = {"crank": 10e-6, ("coupler", "B", "D"): 10e-6, "rocker": 10e-6, ("ground", "A", "E"): 10e-6}
worst = motion.worst_case("P", lengths=lengths, drives={"A": 1e-4})
table = worst.contributors()
band = worst.envelope()

if __name__ == "__main__":
    print(worst)
    print(f"P stays within {1e6 * worst.greatest.min():.0f} to {1e6 * worst.greatest.max():.0f} µm of its path")
    print(f"the coupler turns by up to {1e3 * worst.angle.max():.2f} mrad")

    import matplotlib.pyplot as plt

    place = motion.position("P")
    for k in range(0, 360, 15):
        outline = place[k] + 200.0 * worst.position.boundary()[k]
        plt.fill(outline[:, 0], outline[:, 1], color="tab:orange", alpha=0.4)
    plt.plot(place[:, 0], place[:, 1])
    plt.axis("equal")
    plt.xlabel("x [m]")
    plt.ylabel("y [m]")
    plt.title("what P can reach, 200 times as large")
    plt.show()
