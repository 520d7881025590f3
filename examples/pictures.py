"""Pictures by one call: a linkage, its motion, its reactions and what its links carry, each on axes of matplotlib.

    linkage.plot()      motion.plot()      reactions.plot()      solution.plot("M")

Each takes axes and gives them back, so that they stand side by side in a figure of one's own; without axes each makes
its own figure.
"""

from pathlib import Path

import numpy as np
from linkframe.models import read_linkage

linkage = read_linkage(Path(__file__).with_name("four_bar.toml"))
motion = linkage.move(A=np.radians(np.arange(10.0, 171.0, 5.0)))
pose = 10  # 60 degrees
reactions = motion.reactions()
solution = motion.frame().solve(clearance=False)


def draw(path):
    """All of them in one figure."""
    import matplotlib.pyplot as plt

    figure, ((at_rest, moving), (forces, bending)) = plt.subplots(2, 2, figsize=(11.0, 7.0), layout="constrained")
    linkage.plot(at_rest)
    motion.plot(moving, pose=pose, trace="P", names=False)
    reactions.plot(ax=forces)
    solution.plot("M", ax=bending, entry=pose)
    figure.savefig(path)
    plt.close(figure)
    return figure


if __name__ == "__main__":
    draw("pictures.png")
    print("pictures.png")
