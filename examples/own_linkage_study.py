r"""All about an own linkage in one call: beams, clearance and tolerances of a press with a toggle.

     C #                  The crank pulls the knee; both levers of the toggle bend and stretch, two pins have
       \                  clearance, and lengths, stiffness and clearance have tolerances. Where does the ram D go?
        \  upper
  rod    o K              `linkage.study` samples all of it at every pose, and tells to first order the worst case
B o-----'|                and the contributors. Tolerances go by the names of the linkage's file.
 /       | lower
# A      |
       [ D ]  ram, pressed up by 2 kN
"""

import numpy as np
from linkframe.elements import Beam, Material, Rectangle
from linkframe.models import Linkage

steel = Material(E=210e9, nu=0.3, density=7850.0)
thick, thin = Beam(Rectangle(y=0.04, z=0.02), steel), Beam(Rectangle(y=0.02, z=0.015), steel)
pin = (4e8, 4e8, 4e8, 4e5, 4e5, 0.0)

linkage = Linkage(A=(-0.3, 0.2), B=(-0.26, 0.26), K=(-0.05, 0.25), C=(0.0, 0.5), D=(0.0, 0.0))
linkage.link("ram", "D")  # first of those that have D: what is told of D, and what loads it, is of the ram
for name, points, beam in (("crank", "AB", thin), ("rod", "BK", thin), ("upper", "CK", thick), ("lower", "KD", thick)):
    linkage.link(name, *points, beam=beam)
linkage.revolute("A", "ground", "crank", drive=True)
linkage.revolute("B", "crank", "rod", stiffness=pin, clearance=20e-6)
linkage.revolute("C", "ground", "upper", stiffness=pin)
linkage.revolute("K", "rod", "upper", "lower", stiffness=pin)
linkage.revolute("D", "lower", "ram", stiffness=pin, clearance=30e-6)
linkage.prismatic("D", "ground", "ram", axis=(0, 1), name="guide")
linkage.load("D", fy=2000.0)

tolerances = {
    "points.A.x": "± 0.00005",
    "points.C.y": "± 0.00005",
    "joints.D.clearance": "± 50 %",
    "joints.D.stiffness": "± 10 %",
    "loads.0.fy": "± 5 %",
}
angle = np.radians([-20.0, 0.0, 20.0, 40.0])
found = linkage.study(tolerances, "D", {"A": angle}, n=500, rng=0, sampler="sobol", progress=False)
motion = found.motion

if __name__ == "__main__":
    print(found)
    print(f"farther than 0.15 mm from where it should be: {100.0 * found.probability(150e-6)[0].max():.1f} % at most")
    found.contributors["D"].plot().figure.savefig("own_linkage_study.png")
