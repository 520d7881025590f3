r"""Bennett's linkage: four hinges in space, skew to each other, that move although counting says they cannot.

Opposite links are alike: lengths a and b, angles α and β between the axes at their ends. With

        a / sin α = b / sin β      the hinges turn by θ, φ, −θ, −φ where
                                   tan(θ/2) tan(φ/2) = sin((β + α)/2) / sin((β − α)/2)

(G. T. Bennett, A new mechanism, Engineering 76 (1903) 777.) The loop has six equations for three unknown angles: the
mobility is −2 by the Grübler-Kutzbach count; the actual one is 1, with three redundant constraints.
"""

import numpy as np
from linkframe.models import Linkage
from scipy.spatial.transform import Rotation

ALPHA, BETA, A = np.radians(30.0), np.radians(60.0), 1.0
B = A * np.sin(BETA) / np.sin(ALPHA)
RATIO = np.sin((BETA + ALPHA) / 2) / np.sin((BETA - ALPHA) / 2)


def other(theta):
    """The angle at the next hinge."""
    return 2.0 * np.arctan(RATIO / np.tan(theta / 2.0))


START = np.radians(70.0)
angles = (START, other(START), -START, -other(START))
place, turn = np.zeros(3), Rotation.identity()
linkage, axes = Linkage(), []
for k, angle in enumerate(angles):  # turn about the hinge, go along the link, lean to the next hinge
    linkage.point(f"H{k}", place)
    axes.append(turn.apply((0.0, 0.0, 1.0)))
    length, skew = ((A, ALPHA), (B, BETA))[k % 2]
    turn = turn * Rotation.from_euler("z", angle)
    place = place + turn.apply((length, 0.0, 0.0))
    turn = turn * Rotation.from_euler("x", skew)

for k in range(3):
    linkage.link(f"link {k}", f"H{k}", f"H{k + 1}")
linkage.revolute("H0", "ground", "link 0", axis=axes[0], reference=angles[0], drive=True)
linkage.revolute("H1", "link 0", "link 1", axis=axes[1], reference=angles[1])
linkage.revolute("H2", "link 1", "link 2", axis=axes[2], reference=angles[2])
linkage.revolute("H3", "link 2", "ground", axis=axes[3], reference=angles[3])

theta = np.radians(np.arange(10.0, 351.0, 5.0))
motion = linkage.move(H0=theta)
turns = np.stack([motion.coordinate(f"H{k}")[:, 0] for k in range(4)])
mobility = linkage.mobility()

if __name__ == "__main__":
    print(mobility)
    print(f"off the closed form by {np.abs(np.sin((turns[1] - other(theta)) / 2)).max():.1e}")
