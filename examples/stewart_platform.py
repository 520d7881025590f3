r"""Stewart-Gough platform: six legs of variable length carry a platform in all its six freedoms.

  C ______ C            The legs for a wanted place p and turn R of the platform are
   /\\  /\ \                                   L = |p + R c − b|
  /  \/   \ \           for each leg from b on the base to c on the platform. The other way round has up to
 /___/\____\_\          forty answers: Newton takes the one of the reference configuration's mode.
B     B      B
                        (V. E. Gough and S. G. Whitehall 1962; D. Stewart, A platform with six degrees of
                        freedom, Proc. Instn Mech. Engrs 180 (1965) 371.)
"""

import numpy as np
from linkframe.models import Linkage
from scipy.spatial.transform import Rotation

BASE, PLATFORM, HEIGHT = 1.0, 0.6, 1.1  # radii and height at home, m


def corners(radius, spread):
    """Six points in pairs about 90°, 210° and 330°, (6, 3)."""
    angles = np.radians(np.repeat([90.0, 210.0, 330.0], 2) + np.tile([-spread, spread], 3))
    return radius * np.stack([np.cos(angles), np.sin(angles), np.zeros(6)], axis=-1)


feet = corners(BASE, 15.0)
heads = corners(PLATFORM, 45.0)
home = np.array([0.0, 0.0, HEIGHT])


def leg_lengths(place, turn):
    """Lengths (..., 6) for places (..., 3) and turns (rotations) of the platform."""
    tips = place[..., None, :] + np.einsum("...ij,kj->...ki", turn.as_matrix(), heads)
    return np.linalg.norm(tips - feet, axis=-1)


start = leg_lengths(home, Rotation.identity())
linkage = Linkage(P=home)
for k in range(6):
    linkage.point(f"B{k}", feet[k])
    linkage.point(f"M{k}", (feet[k] + home + heads[k]) / 2)
    linkage.point(f"C{k}", home + heads[k])
linkage.link("platform", "P", *(f"C{k}" for k in range(6)))
for k in range(6):
    leg = home + heads[k] - feet[k]
    across = np.cross(leg, (0.0, 0.0, 1.0))
    linkage.link(f"cylinder {k}", f"B{k}", f"M{k}")
    linkage.link(f"piston {k}", f"M{k}", f"C{k}")
    linkage.universal(f"B{k}", "ground", f"cylinder {k}", axis=across, second=np.cross(across, leg))
    linkage.prismatic(
        f"M{k}", f"cylinder {k}", f"piston {k}", axis=leg, drive=True, reference=start[k], name=f"leg {k}"
    )
    linkage.spherical(f"C{k}", f"piston {k}", "platform")

s = np.linspace(0.0, 2.0 * np.pi, 61)
wave = np.sin(np.outer(s, [1, 2, 3]))
place, turn = home + wave * (0.15, 0.1, 0.1), Rotation.from_rotvec(wave[:, ::-1] * (0.2, 0.15, 0.3))
lengths = leg_lengths(place, turn)
motion = linkage.move({f"leg {k}": lengths[:, k] for k in range(6)})
path, axes = motion.position("P"), motion.axes("platform")
mobility = linkage.mobility()

if __name__ == "__main__":
    print(mobility)
    print(f"the platform is off the wanted place by {np.abs(path - place).max():.1e} m")
    print(f"and off the wanted turn by {np.abs(axes - turn.as_matrix()).max():.1e} rad")
