r"""Measured positions beside the predicted ones: how a four-bar was built, told from where its coupler point went.

            P                Read at 24 angles of the crank, to 10 µm, from a four-bar whose coupler is 0.2 mm longer
           / \               than drawn. As drawn, the prediction does not hold: χ² is far above the number of readings;
      B o-+---+-o D          with the lengths that fit best it does, and they are told with their standard errors.
       /         \
    A #           # E        χ² = Σ (measured − predicted)² / σ²    (Guide to the expression of uncertainty, JCGM 100)

Here the readings are made up; `read_measured("file.csv")` takes those of a file.
"""

import numpy as np
from linkframe.models import Linkage, Measured, compare

LENGTHS = {"crank": 0.1, "coupler": 0.3}
ACCURACY = 10e-6


def four_bar(crank, coupler):
    """The linkage with these lengths, assembled with its crank upright; D by the cosine law."""
    pin, pivot = np.array([0.0, 1.0]) * np.asarray(crank)[..., None], np.array([0.25, 0.0])
    chord = pivot - pin
    far = np.linalg.norm(chord, axis=-1)
    along = (far**2 + coupler**2 - 0.25**2) / (2.0 * far)
    aside = np.stack([-chord[..., 1], chord[..., 0]], axis=-1)
    rocker_pin = pin + (along[..., None] * chord + np.sqrt(coupler**2 - along**2)[..., None] * aside) / far[..., None]
    way = (rocker_pin - pin) / np.asarray(coupler)[..., None]
    linkage = Linkage(A=(0, 0), B=pin, D=rocker_pin, E=pivot, P=pin + way @ [[0.15, 0.08], [-0.08, 0.15]])
    for name, points in {"crank": "AB", "coupler": "BDP", "rocker": "DE"}.items():
        linkage.link(name, *points)
    linkage.revolute("A", "ground", "crank", drive=True)
    linkage.revolute("B", "crank", "coupler")
    linkage.revolute("D", "coupler", "rocker")
    linkage.revolute("E", "rocker", "ground")
    return linkage


angle = np.radians(np.arange(0.0, 360.0, 15.0))
motion = four_bar(**LENGTHS).move(A=angle)
built = four_bar(0.1, 0.3002).move(A=angle).position("P")
read = built + [1.0, 1.0, np.nan] * np.random.default_rng(4).normal(0.0, ACCURACY, built.shape)

measured = Measured(read, ACCURACY, {"A": angle})
nominal = motion.compare("P", measured)
calibration = motion.calibrate("P", measured, four_bar, LENGTHS)
as_built = compare(four_bar(**calibration.values).move(A=angle).position("P"), measured)

if __name__ == "__main__":
    print("nominal:", nominal)
    print(calibration)
    print("as built:", as_built)
    nominal.plot().figure.savefig("measured_data.png")
