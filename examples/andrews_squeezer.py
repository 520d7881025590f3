r"""Andrews' squeezer: seven bodies, four loops, one drive.

        C                   Crank K1 = O F and K2 = F E; three dyads meet at E with it:
       /spring              K3 = B E, which the spring pulls at D; K4 K5 = E G A; K6 K7 = E H A.
      D
B #--´-.                    Lengths: W. Schiehlen (ed.), Multibody Systems Handbook, Springer 1990, p. 10.
       `-o E---o F-# O      Start: E. Hairer and G. Wanner, Solving Ordinary Differential Equations II,
A #-- G-´               Springer 1996, p. 530.
   `- H-´
"""

import numpy as np
from linkframe.models import Linkage

D, E, RR, SS, ZF, ZT, U, SC, SD = 0.028, 0.02, 0.007, 0.035, 0.02, 0.04, 0.04, 0.018, 0.02
A, B, C = (-0.06934, -0.00227), (-0.03635, 0.03273), (0.014, 0.072)


def points(beta, theta, gamma, phi, delta, omega, epsilon):
    """Points from the seven angles of the handbook."""
    f = RR * np.array([np.cos(beta), np.sin(beta)])
    arm = np.array([np.sin(gamma), -np.cos(gamma)])
    return {
        "F": f,
        "E": f - D * np.array([np.cos(beta + theta), np.sin(beta + theta)]),
        "D": np.array(B) + SC * arm + SD * np.array([np.cos(gamma), np.sin(gamma)]),
        "G": np.array(A) + ZT * np.array([np.cos(delta), np.sin(delta)]),
        "H": np.array(A) + U * np.array([np.sin(epsilon), -np.cos(epsilon)]),
    }


START = (
    *(-0.06171389001427645, 0.0, 0.45527981916307037, 0.22266839016588588),
    *(0.48736497954384256, -0.22266839016588588, 1.2305474445498212),
)
linkage = Linkage(O=(0, 0), A=A, B=B, C=C, **points(*START))
linkage.link("K1", "O", "F")
linkage.link("K2", "F", "E")
linkage.link("K3", "B", "E", "D")
linkage.link("K4", "E", "G")
linkage.link("K5", "G", "A")
linkage.link("K6", "E", "H")
linkage.link("K7", "H", "A")
linkage.revolute("O", "ground", "K1", drive=True, reference=START[0])
linkage.revolute("F", "K1", "K2")
linkage.revolute("E", "K2", "K3", "K4", "K6")  # four links on one pin
linkage.revolute("B", "ground", "K3")
linkage.revolute("G", "K4", "K5")
linkage.revolute("H", "K6", "K7")
linkage.revolute("A", "ground", "K5", "K7")

motion = linkage.move(O=START[0] + np.radians(np.arange(0.0, 1081.0, 3.0)))
mobility = linkage.mobility()

if __name__ == "__main__":
    print(mobility)
    print(f"closure error {motion.gap.max():.1e} m over three turns")
