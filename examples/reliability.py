r"""Slider-crank: how likely the piston is out of place, which fits keep it in place, and what measurements say.

     B
    / `--._  rod l                x(θ) = r cos θ + √(l² − r² sin² θ)
 r /       `--._
  / θ           C ═ ═ ▷ x         Crank and rod vary by σ: where the piston may be off by t, it is so with the
A o - - - - - - |                 probability 2 Φ(−t / s), s² = σ² (∂x/∂r)² + σ² (∂x/∂l)², nearly (first order)
"""

import numpy as np
from linkframe.models import Linkage, Measured
from scipy import stats

CRANK, ROD, START = 0.05, 0.2, np.radians(60.0)
DEVIATION, ALLOWED, READING = 5e-6, 25e-6, 2e-6


def place(theta, crank=CRANK, rod=ROD):
    """Piston by the closed form."""
    return crank * np.cos(theta) + np.sqrt(rod**2 - (crank * np.sin(theta)) ** 2)


def machine(crank=CRANK, rod=ROD):
    """The linkage, of one crank and rod or of many."""
    piston, crank = np.broadcast_arrays(place(START, crank, rod), crank)
    pin = np.stack([crank * np.cos(START), crank * np.sin(START), 0.0 * crank], axis=-1)
    linkage = Linkage(A=(0, 0), B=pin, C=np.stack([piston, 0.0 * piston, 0.0 * piston], axis=-1))
    linkage.link("crank", "A", "B")
    linkage.link("rod", "B", "C")
    linkage.link("piston", "C")
    linkage.revolute("A", "ground", "crank", drive=True, reference=START)
    linkage.revolute("B", "crank", "rod")
    linkage.revolute("C", "rod", "piston")
    linkage.prismatic("C", "ground", "piston", axis=(1, 0, 0), name="slide")
    return linkage


theta = np.radians([10.0, 50.0, 90.0, 130.0, 170.0])
motion = machine().move(A=theta)

inputs = {"crank": stats.norm(CRANK, DEVIATION), "rod": stats.norm(ROD, DEVIATION)}
failing = motion.reliability("C", ALLOWED, machine, inputs, method="sorm")
lengths = {"crank": 3.0 * DEVIATION, "rod": 3.0 * DEVIATION}
fits = motion.allocate("C", 100e-6, diameters={"A": 0.012, "B": 0.012, "C": 0.008}, lengths=lengths)
fuzzy = motion.fuzzy("C", lengths={name: (-half, 0.0, half) for name, half in lengths.items()}).along((1, 0))

# A machine whose crank is 30 µm too long, as a gauge reads its piston to 2 µm.
rng = np.random.default_rng(0)
read = np.full((len(theta), 3), np.nan)
read[:, 0] = place(theta, CRANK + 30e-6) + READING * rng.normal(size=len(theta))
measured = Measured(read, READING, {"A": theta})
comparison = motion.compare("C", measured, deviation=[np.hypot(DEVIATION, DEVIATION), 0.0, 0.0])
calibration = motion.calibrate("C", measured, machine, {"crank": CRANK, "rod": ROD})

if __name__ == "__main__":
    print(failing)
    print(fits)
    print(fuzzy)
    print(comparison)
    print(calibration)

    import matplotlib.pyplot as plt

    failing.plot().set_ylabel(f"probability that C is off by {1e6 * ALLOWED:.0f} µm")
    plt.show()
