r"""A punch at 600 rpm: a slider-crank with weight, inertia and a spring; what its motor has to give and its pins carry.

        /\/\/\  spring that pulls the ram back up
       C [##]                     Power of the drive = growth of kinetic energy + of potential energy:
          |  rod
          |                          T ω = d/dt (Σ ½ m v² + ½ J Ω²)  +  d/dt (Σ m g y + ½ k (s − s₀)²)
          o B
    crank/                        Over a turn the work of the drive is nothing: weight and spring give back what
        o A   ω                   they take.

Links weigh what their beams weigh; a mass of one's own stands in for the ram.
"""

import numpy as np
from linkframe.elements import Beam, Material, Rectangle
from linkframe.models import Linkage

CRANK, ROD, RAM, RATE, REST, SPEED = 0.04, 0.16, 3.0, 4000.0, 0.15, 600.0 * 2.0 * np.pi / 60.0
steel = Material(E=210e9, nu=0.3, density=7850.0)
bar = Beam(Rectangle(y=0.03, z=0.012), steel)

linkage = Linkage(A=(0, 0), B=(CRANK, 0), C=(0, np.sqrt(ROD**2 - CRANK**2)), F=(0, 0.35))
linkage.link("crank", "A", "B", beam=bar)
linkage.link("rod", "B", "C", beam=bar)
linkage.link("ram", "C", mass=RAM)
linkage.revolute("A", "ground", "crank", drive=True)
linkage.revolute("B", "crank", "rod")
linkage.revolute("C", "rod", "ram")
linkage.prismatic("C", "ground", "ram", axis=(0, 1), name="guide")
linkage.spring("C", ("ground", "F"), stiffness=RATE, length=REST)
linkage.gravity((0.0, -9.81, 0.0))

angle = np.radians(np.arange(0.0, 360.0, 5.0))
motion = linkage.move({"A": angle}, rates={"A": SPEED})
reactions = motion.reactions()
torque = reactions.drive("A")[:, 0]
force_in_pin = np.linalg.norm(reactions.force("B")[:, :3], axis=-1)
slow = linkage.move(A=angle).reactions().drive("A")[:, 0]

if __name__ == "__main__":
    print(f"torque {torque.min():.1f} to {torque.max():.1f} N m; if slow, {slow.min():.1f} to {slow.max():.1f} N m")
    print(f"mean power {np.mean(torque) * SPEED:.2e} W; force in B up to {force_in_pin.max():.0f} N")
    reactions.plot("drives").figure.savefig("gravity_spring_rpm.png")
