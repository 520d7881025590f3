r"""Scissor lift of n stages, pushed by the sliding foot.

        T ═══════ S ▷           Each stage is two bars of length L pinned at their middle. With the feet x apart the
         \       /              platform is at the height
           \   /
             o                        h = n √(L² − x²),    dh/dx = −n² x / h
           /   \
        L2o     o R2            so that a weight W on it asks for the push W n² x / h in the foot: out of all
           \   /                bounds where the lift lies flat, which is its dead point x = L.
             o
           /   \
        # L0    R0 ▷
"""

import numpy as np
from linkframe.models import Linkage

STAGES, LENGTH, START, WEIGHT = 5, 1.0, 0.6, 1000.0


def lift(stages):
    """The linkage."""
    rise = np.sqrt(LENGTH**2 - START**2)
    linkage = Linkage()
    for level in range(stages + 1):
        linkage.point(f"L{level}", (0.0, level * rise))
        linkage.point(f"R{level}", (START, level * rise))
    linkage.link("foot", "R0")
    linkage.link("platform", f"L{stages}", f"R{stages}")
    linkage.link("slider", f"R{stages}")
    for level in range(stages):
        linkage.point(f"M{level}", (START / 2, (level + 0.5) * rise))
        linkage.link(f"up {level}", f"L{level}", f"M{level}", f"R{level + 1}")
        linkage.link(f"down {level}", f"R{level}", f"M{level}", f"L{level + 1}")
        linkage.revolute(f"M{level}", f"up {level}", f"down {level}")
        if level:
            linkage.revolute(f"L{level}", f"down {level - 1}", f"up {level}")
            linkage.revolute(f"R{level}", f"up {level - 1}", f"down {level}")
    linkage.revolute("L0", "ground", "up 0")
    linkage.revolute("R0", "foot", "down 0")
    linkage.prismatic("R0", "ground", "foot", axis=(1, 0, 0), reference=START, drive=True, name="push")
    linkage.revolute(f"L{stages}", f"down {stages - 1}", "platform")
    linkage.revolute(f"R{stages}", f"up {stages - 1}", "slider")
    linkage.prismatic(f"R{stages}", "platform", "slider", axis=(1, 0, 0))
    return linkage


linkage = lift(STAGES)
linkage.load(f"L{STAGES}", fy=-WEIGHT, link="platform")
feet = np.linspace(0.98, 0.2, 40)
motion = linkage.move(push=feet, rates={"push": -0.1})
height = motion.position(f"L{STAGES}")[:, 1]
speed = motion.velocity(f"L{STAGES}")[:, 1]
push = motion.reactions().drive("push")[:, 0]
flat = linkage.dead_points("push")

if __name__ == "__main__":
    print(f"height from {height[0]:.3f} to {height[-1]:.3f} m, speed from {speed[0]:.3f} to {speed[-1]:.3f} m/s")
    print(f"push from {push[0]:.0f} to {push[-1]:.0f} N under {WEIGHT:.0f} N")
    for point in flat:
        print(f"dead point at {point.value:.12f} m: {point.status}")
