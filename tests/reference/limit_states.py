"""Problems of structural reliability with their exact probabilities of failure, by closed form or quadrature.

R - S, the numbered ones of the TNO collection that OpenTURNS' otbenchmark and RPRepo have as well, and the four
branches of Waarts (2000). Several of the printed probabilities are off; all are computed here.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import pairwise
from math import erfc, sqrt
from typing import Any

import numpy as np
from linkframe.elements import Beam, Material, Section
from linkframe.framework import Frame
from scipy import stats

Array = np.ndarray[Any, np.dtype[np.float64]]

ROOT = sqrt(2.0)


@dataclass(frozen=True)
class Problem:
    """A limit state of inputs x1, x2, ... and the probability that it is zero or less."""

    limit: Callable[..., Array]
    laws: Mapping[str, Any]
    probability: float

    def __call__(self, samples: Mapping[str, Array]) -> Array:
        return self.limit(*samples.values())


def normal(*parameters: tuple[float, float]) -> dict[str, Any]:
    return {f"x{k}": stats.norm(*each) for k, each in enumerate(parameters, 1)}


def mean(of: Callable[[float], float], *edges: float, law: Any = None) -> float:
    """Mean of a function of a standard normal variable, or of one of another law, smooth between edges.

    Gauss' rule of ten points on two hundred panels between the edges.
    """
    found = law or stats.norm()
    ends = [float(found.ppf(1e-18)), *edges, float(found.isf(1e-18))]
    nodes, weights = np.polynomial.legendre.leggauss(10)
    total = 0.0
    for low, high in pairwise(ends):
        width = (high - low) / 200.0
        x = low + width * (np.arange(200)[:, None] + 0.5 + 0.5 * nodes)
        values = np.array([of(each) for each in x.ravel().tolist()]).reshape(x.shape)
        total += float(np.sum(0.5 * width * weights * found.pdf(x) * values))
    return total


def beyond(x: float) -> float:
    return 0.5 * erfc(x / ROOT)


def between(low: float, high: float) -> float:
    return beyond(low) - beyond(high) if low > 0.0 else beyond(-high) - beyond(-low)


def _rp25(x: float) -> float:
    low, high = (x * x + 16.0) / 8.0, np.sqrt(max(16.0 * x - 32.0, 0.0))
    return between(low, high) if high > low else 0.0


def _rp35(x: float) -> float:
    first = 2.0 + np.exp(-0.1 * x * x) + (0.2 * x) ** 4
    if x > 0.0:
        return beyond(min(first, 4.5 / x))
    return beyond(first) + (beyond(-4.5 / x) if x < 0.0 else 0.0)


def _rp57(x: float) -> float:
    low, high = (2.0 - x) / 8.0, float(np.cbrt(x * x - 3.0))
    found = between(low, high) if high > low else 0.0
    if abs(x + 3.0) < 2.0:
        half = np.sqrt(4.0 - (x + 3.0) ** 2)
        disc = -3.0 - half, -3.0 + half
        found += between(*disc)
        both = max(low, disc[0]), min(high, disc[1])
        found -= between(*both) if both[1] > both[0] else 0.0
    return found


def _min(*each: Array) -> Array:
    return np.minimum.reduce(each)


STANDARD = (0.0, 1.0)
RHO = 1.0 / sqrt(3.0)

PROBLEMS = {
    "R-S": Problem(lambda r, s: r - s, normal((4.0, 1.0), (2.0, 1.0)), beyond(ROOT)),
    "RP22": Problem(
        lambda x, y: 2.5 - (x + y) / ROOT + 0.1 * (x - y) ** 2,
        normal(STANDARD, STANDARD),
        mean(lambda b: beyond(2.5 + 0.2 * b * b)),
    ),
    "RP24": Problem(
        lambda x, y: 2.5 - 0.2357 * (x - y) + 0.00463 * (x + y - 20.0) ** 4,
        normal((10.0, 3.0), (10.0, 3.0)),
        mean(lambda b: beyond((2.5 + 0.00463 * (3.0 * ROOT * b) ** 4) / (0.2357 * 3.0 * ROOT))),
    ),
    "RP25": Problem(
        lambda x, y: np.maximum(x * x - 8.0 * y + 16.0, -16.0 * x + y * y + 32.0),
        normal(STANDARD, STANDARD),
        mean(_rp25, 2.0, 4.0),
    ),
    "RP31": Problem(
        lambda x, y: 2.0 - y + 256.0 * x**4, normal(STANDARD, STANDARD), mean(lambda x: beyond(2.0 + 256.0 * x**4))
    ),
    "RP33": Problem(
        lambda x, y, z: np.minimum(3.0 * np.sqrt(3.0) - x - y - z, 3.0 - z),
        normal(STANDARD, STANDARD, STANDARD),
        2.0 * beyond(3.0) - mean(lambda z: beyond((3.0 - RHO * z) / np.sqrt(1.0 - RHO**2)) if z > 3.0 else 0.0, 3.0),
    ),
    "RP35": Problem(
        lambda x, y: np.minimum(2.0 - y + np.exp(-0.1 * x * x) + (0.2 * x) ** 4, 4.5 - x * y),
        normal(STANDARD, STANDARD),
        mean(_rp35, 0.0),
    ),
    "RP53": Problem(
        lambda x, y: np.sin(2.5 * x) + 2.0 - (x * x + 4.0) * (y - 1.0) / 20.0,
        normal((1.5, 1.0), (2.5, 1.0)),
        mean(lambda x: beyond(20.0 * (np.sin(2.5 * x) + 2.0) / (x * x + 4.0) - 1.5), law=stats.norm(1.5, 1.0)),
    ),
    "RP54": Problem(
        lambda *x: np.sum(x, axis=0) - 8.951,
        {f"x{k}": stats.expon() for k in range(20)},
        float(stats.gamma(20.0).cdf(8.951)),
    ),
    "RP57": Problem(
        lambda x, y: np.minimum(
            np.maximum(-x * x + y**3 + 3.0, 2.0 - x - 8.0 * y), (x + 3.0) ** 2 + (y + 3.0) ** 2 - 4.0
        ),
        normal(STANDARD, STANDARD),
        mean(_rp57, -5.0, -3.0, -1.0, 2.0),
    ),
    "RP75": Problem(
        lambda x, y: 3.0 - x * y,
        normal(STANDARD, STANDARD),
        2.0 * mean(lambda x: beyond(3.0 / x) if x > 0.0 else 0.0, 0.0),
    ),
    "RP77": Problem(
        lambda x, y, z: np.where(z <= 5.0, x - y - z, z - y),
        normal((10.0, 0.5), STANDARD, (4.0, 1.0)),
        mean(lambda z: beyond((10.0 - z) / np.sqrt(1.25)) if z <= 5.0 else beyond(z), 5.0, law=stats.norm(4.0, 1.0)),
    ),
    "RP89": Problem(
        lambda x, y: np.minimum(-x * x - y + 8.0, -x / 5.0 - y + 6.0),
        normal(STANDARD, STANDARD),
        mean(lambda x: beyond(min(8.0 - x * x, 6.0 - x / 5.0)), -2.0, 2.0),
    ),
    "RP107": Problem(lambda *x: 5.0 * np.sqrt(10.0) - np.sum(x, axis=0), normal(*[STANDARD] * 10), beyond(5.0)),
    "RP110": Problem(
        lambda x, y: np.minimum(
            np.where(x <= 3.5, 0.85 - 0.1 * x, 4.0 - x), np.where(y <= 2.0, 2.3 - y, 0.5 - 0.1 * y)
        ),
        normal(STANDARD, STANDARD),
        beyond(4.0) + beyond(5.0) - beyond(4.0) * beyond(5.0),
    ),
    "RP111": Problem(
        lambda x, y: 12.5 - np.abs(x * y),
        normal(STANDARD, STANDARD),
        4.0 * mean(lambda x: beyond(12.5 / x) if x > 0.0 else 0.0, 0.0),
    ),
    "four branches": Problem(
        lambda x, y: _min(
            3.0 + 0.1 * (x - y) ** 2 - (x + y) / ROOT,
            3.0 + 0.1 * (x - y) ** 2 + (x + y) / ROOT,
            x - y + 7.0 / ROOT,
            y - x + 7.0 / ROOT,
        ),
        normal(STANDARD, STANDARD),
        mean(lambda b: 1.0 if abs(b) > 3.5 else 2.0 * beyond(3.0 + 0.2 * b * b), -3.5, 3.5),
    ),
}


# -- problems of handbooks ---------------------------------------------------------------------------------------------


def lognormal(average: float, deviation: float) -> Any:
    variance = np.log1p((deviation / average) ** 2)
    return stats.lognorm(np.sqrt(variance), scale=average * np.exp(-0.5 * variance))


def interaction(x: Mapping[str, Array]) -> Array:
    """Manual of CalRel, example 2."""
    return 1.0 - x["x2"] / (1000.0 * x["x3"]) - (x["x1"] / (200.0 * x["x3"])) ** 2


def interaction_slopes(x: Mapping[str, Array]) -> dict[str, Array]:
    a, b, c = x["x1"], x["x2"], x["x3"]
    return {
        "x1": -2.0 * a / (200.0 * c) ** 2,
        "x2": -1.0 / (1000.0 * c),
        "x3": b / (1000.0 * c * c) + 2.0 * a * a / (200.0**2 * c**3),
    }


def sway(x: Mapping[str, Array]) -> Array:
    """What is left of the sway of the portal frame of the OpenSees manual's example of reliability."""
    frame, none = Frame(), np.zeros_like(x["x"])
    frame.node("1", np.stack([x["x"], none, none], axis=-1))
    for name, place in {"2": (0.0, 144.0, 0.0), "3": (240.0, 144.0, 0.0), "4": (240.0, 0.0, 0.0)}.items():
        frame.node(name, place)
    column = Beam(Section(A=29.0, Iy=2e3, Iz=2e3, J=4e3), Material(E=x["E"], G=x["E"] / 2.6), shear=False)
    girder = Beam(Section(A=25.0, Iy=1.5e3, Iz=1.5e3, J=3e3), Material(E=3e4, G=11500.0), shear=False)
    for name, beam, ends in (("12", column, "12"), ("43", column, "43"), ("23", girder, "23")):
        frame.add(name, beam, *ends)
    frame.fix("1")
    frame.fix("4")
    frame.load("2", fx=x["P"])
    frame.line_load("23", fy=x["w"])
    return 0.15 - np.asarray(frame.solve().displacement("2")[..., 0])


CALREL = {
    "x1": lognormal(500.0, 100.0),
    "x2": lognormal(2000.0, 400.0),
    "x3": stats.uniform(5.0 - 0.5 * np.sqrt(3.0), np.sqrt(3.0)),
}
TIED = {("x1", "x2"): 0.3, ("x1", "x3"): 0.2, ("x2", "x3"): 0.2}
PORTAL = {"E": lognormal(3e4, 3e3), "P": stats.norm(25, 5), "x": stats.norm(), "w": stats.norm(-0.1, 0.02)}
