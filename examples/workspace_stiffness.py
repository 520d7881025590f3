r"""How stiff a planar 3-RRR robot is all over its workspace, with its drives locked.

           A2 #--o B2          Each leg is a spring along its rod: the rod stretches, its arm is a cantilever.
                  \
                   C2              c = l / E A + a / E A cos² β + a³ / 3 E I sin² β     β between arm and rod
                  /  \
         B0     /  P  \         The platform feels K = Σ s s^T / c, s = (direction of the rod, its moment about P);
          o---C0------C1--o B1  the stiffness of P in a direction n, free to turn, is 1 / n . K⁻¹ n.
         /                 \
        # A0             A1 #  (C. Gosselin, Stiffness mapping for parallel manipulators, IEEE Transactions on Robotics
                                and Automation 6 (1990) 377.)

`linkage.workspace` leads P over a grid, finds the drives, and tells what cannot be reached.
"""

import numpy as np
from linkframe.elements import Beam, Material, Tube
from linkframe.models import Linkage

BASE, PLATFORM, ARM, ROD = 0.4, 0.12, 0.25, 0.25  # radii of the triangles, lengths of the bars, m
CORNERS = np.radians([210.0, 330.0, 90.0])
section, aluminium = Tube(outer=0.03, thickness=0.003), Material(E=70e9, nu=0.33, density=2700.0)
bar = Beam(section, aluminium)

base, platform = (radius * np.stack([np.cos(CORNERS), np.sin(CORNERS)], axis=-1) for radius in (BASE, PLATFORM))
chord = platform - base
reach = np.linalg.norm(chord, axis=-1)
home = np.arctan2(chord[:, 1], chord[:, 0]) + np.arccos((ARM**2 + reach**2 - ROD**2) / (2 * ARM * reach))
elbow = base + ARM * np.stack([np.cos(home), np.sin(home)], axis=-1)

linkage = Linkage(P=(0, 0))
for k in range(3):
    for name, place in (("A", base), ("B", elbow), ("C", platform)):
        linkage.point(f"{name}{k}", place[k])
linkage.link("platform", "C0", "C1", "C2", "P")
for k in range(3):
    linkage.link(f"arm {k}", f"A{k}", f"B{k}", beam=bar)
    linkage.link(f"rod {k}", f"B{k}", f"C{k}", beam=bar)
    linkage.revolute(f"A{k}", "ground", f"arm {k}", drive=True, reference=home[k])
    linkage.revolute(f"B{k}", f"arm {k}", f"rod {k}")
    linkage.revolute(f"C{k}", f"rod {k}", "platform")

space = linkage.workspace("P", x=np.linspace(-0.24, 0.24, 21), y=np.linspace(-0.24, 0.24, 21))
stiffness, condition = space.stiffness(), space.condition()

if __name__ == "__main__":
    print(space)
    print(f"softest direction of P: {1e-3 * stiffness[10, 10]:.1f} N/mm in the middle,")
    print(f"from {1e-3 * np.nanmin(stiffness):.2f} to {1e-3 * np.nanmax(stiffness):.1f} N/mm where it can be")
    space.plot("stiffness").figure.savefig("workspace_stiffness.png")
