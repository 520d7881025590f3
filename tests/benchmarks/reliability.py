"""Benchmark 13, run time against error of mean, standard deviation, 99.9 % quantile, and a probability of 1e-6.

Each method is set beside plain Monte Carlo on the same frame and, where that is installed, beside the same method of
OpenTURNS on it. The problem is that of `monte_carlo`: a four-bar whose joint stiffness, load and clearance are
uncertain. The displacement is linear in load and clearance, which are normal, and so it is normal itself for given
compliances of the joints; over these three lognormal numbers one integrates by Gauss' rule. All four quantities are
thus known to ten digits.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np
from linkframe.models import polynomial_chaos, propagate, reliability, taylor_moments
from numpy.typing import NDArray
from scipy.optimize import brentq
from scipy.special import ndtr, ndtri
from scipy.stats import norm

from .harness import COLOURS, Row, Target, figure, importable, main, write
from .monte_carlo import FORCE, GAP, GAP_SPREAD, INPUTS, MEDIAN, SHAPE, SPREAD, displacement

Array = NDArray[np.float64]

QUANTITIES = ("mean", "standard deviation", "99.9 % quantile", "probability of 1e-6")
HIGH, RARE = 0.999, 1e-6
# Points by which a fitted polynomial tells a quantile, and nodes of Gauss' rule for each joint.
SURROGATE, NODES = 2**16, 50
# Steps from the first-order moments to a quantile.
SECANTS = 3
PLAIN, OTHERS, WANTED = "plain Monte Carlo", "OpenTURNS: ", 100.0


def run(out: Path, quick: bool) -> list[Target]:
    """Run time against error of the methods for each quantity."""
    rows = all_rows(range(8, 13, 2), 2, seeds=2) if quick else all_rows(range(8, 17, 4), 3, seeds=3)
    write(out, "reliability", rows)
    draw(out, rows)
    return [*targets(rows), six_sigma(2 if quick else 10)]


# -- the exact values -------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Exact:
    """What the displacement uy of P is, to ten digits."""

    mean: float
    std: float
    quantile: float
    limit: float

    def of(self, quantity: str) -> float:
        """The exact value of a quantity; the probability is that of passing the limit."""
        return dict(zip(QUANTITIES, (self.mean, self.std, self.quantile, RARE), strict=True))[quantity]


@cache
def exact() -> Exact:
    """Mean, standard deviation, 99.9 % quantile, and the limit that is passed once in a million."""
    own, joints, gap = coefficients()
    nodes, weights = np.polynomial.hermite_e.hermegauss(NODES)
    weights = weights / weights.sum()
    grid = np.meshgrid(nodes, nodes, nodes, indexing="ij")
    compliance = own + sum(c * np.exp(SHAPE * z) for c, z in zip(joints, grid, strict=True))
    weight = np.einsum("i,j,k->ijk", weights, weights, weights)
    mean, deviation = FORCE * compliance + gap * GAP, np.hypot(SPREAD * compliance, GAP_SPREAD * gap)

    def passed(limit: float) -> float:
        return float(np.sum(weight * ndtr((mean - limit) / deviation)))

    middle = float(np.sum(weight * mean))
    std = float(np.sqrt(np.sum(weight * (deviation**2 + (mean - middle) ** 2))))
    high, rare = (
        brentq(lambda y, p=p: np.log(passed(y) / p), middle, middle + 20.0 * std, rtol=1e-13, xtol=1e-20)
        for p in (1.0 - HIGH, RARE)
    )
    return Exact(middle, std, high, rare)


def coefficients() -> tuple[float, Array, float]:
    """By unit load: compliance of links, and of each joint at its median, (3,); by unit clearance: displacement."""
    soft = np.array([[1.0, 1.0, 1.0], [2.0, 1.0, 1.0], [1.0, 2.0, 1.0], [1.0, 1.0, 2.0], [1.0, 1.0, 1.0]])
    force, gap = np.array([1.0, 1.0, 1.0, 1.0, 0.0]), np.array([0.0, 0.0, 0.0, 0.0, 1e-3])
    found = displacement(*(MEDIAN / soft.T), force=force, gap=gap)[:, 1]
    joints = found[1:4] - found[0]
    return float(found[0] - joints.sum()), joints, float(found[4] / 1e-3)


# -- the methods ------------------------------------------------------------------------------------------------------

# By quantity what was found, and for how many samples the frame was solved.
Found = tuple[Mapping[str, float], int]


def height(**inputs: Array) -> Array:
    """Displacement uy of P, (n,)."""
    return displacement(**inputs)[:, 1]


def left(samples: Mapping[str, Array], limit: float) -> Array:
    """What is left to a limit, (n,)."""
    return limit - height(**samples)


def sampled(sampler: str, n: int, seed: int) -> Found:
    """Mean, standard deviation and quantile of samples; of random ones the probability as well."""
    found = propagate(height, INPUTS, n=n, rng=seed, sampler=sampler, progress=False)
    values = [float(found.mean), float(found.std), float(found.quantile(HIGH))]
    values.append(float(np.mean(found.samples >= exact().limit)))
    return dict(zip(QUANTITIES if sampler == "random" else QUANTITIES[:3], values, strict=False)), n


def fitted(degree: int, seed: int, of: str) -> Found:
    """Moments of a polynomial, or the quantile of its values at many points."""
    count = 0

    def counting(**inputs: Array) -> Array:
        nonlocal count
        count += len(inputs["force"])
        return height(**inputs)

    found = polynomial_chaos(counting, INPUTS, degree=degree, rng=seed)
    if of == "moments":
        return {QUANTITIES[0]: float(found.mean), QUANTITIES[1]: float(found.std)}, count
    rest = propagate(found, INPUTS, n=SURROGATE, rng=seed, sampler="sobol", progress=False).quantile(HIGH)
    return {QUANTITIES[2]: float(rest)}, count


def expanded(order: int, seed: int) -> Found:
    """Moments of a Taylor series; nothing is random."""
    count = 0

    def counting(**inputs: Array) -> Array:
        nonlocal count
        count += len(inputs["force"])
        return height(**inputs)

    found = taylor_moments(counting, INPUTS, order=order)
    return {QUANTITIES[0]: float(found.mean), QUANTITIES[1]: float(found.std)}, count


def inverted(index: Callable[[float], tuple[float, int]]) -> Found:
    """The quantile: the limit whose reliability index is the wanted one, by secants from the first-order moments.

    `index` tells it of a limit, and for how many samples the frame was solved.
    """
    moments = taylor_moments(height, INPUTS)
    wanted, limit, slope = float(ndtri(HIGH)), float(moments.mean), 1.0 / float(moments.std)
    count, beta, moved = 0, 0.0, 0.0
    for step in range(SECANTS):
        moved = (wanted - beta) / slope
        limit += moved
        found, evaluations = index(limit)
        slope = slope if step == 0 else (found - beta) / moved
        beta, count = found, count + evaluations
    return {QUANTITIES[2]: limit + (wanted - beta) / slope}, count


def index(method: str, limit: float) -> tuple[float, int]:
    """Reliability index by one of the methods of `reliability`, for `inverted`."""
    found = reliability(partial(left, limit=limit), INPUTS, method=method, rng=0)
    return float(found.beta), found.evaluations


def failing(method: str, seed: int, **options: Any) -> Found:
    """The probability, by one of the methods of `reliability`."""
    found = reliability(partial(left, limit=exact().limit), INPUTS, method=method, rng=seed, **options)
    return {QUANTITIES[3]: float(found.probability)}, found.evaluations


# Names of the methods, with how linkframe and OpenTURNS know them.
SAMPLERS = {PLAIN: "random", "Latin hypercube": "lhs", "Sobol'": "sobol"}
TAYLOR, CHAOS, ABOUT, SUBSET = "Taylor series", "polynomial chaos", "importance sampling", "subset simulation"
METHODS = (*SAMPLERS, TAYLOR, CHAOS, "FORM", "SORM", ABOUT, SUBSET)
ACCURACIES, LEVELS, DEGREES = (0.2, 0.05, 0.01), (300, 1000, 3000), (1, 2, 3, 4)


def ways(powers: range, most: int) -> Iterator[tuple[str, str, Callable[[int], Found]]]:
    """Each method with each effort, at most so many: its name, the effort, and what it finds with a seed."""
    for n in (2**power for power in powers):
        for name, sampler in SAMPLERS.items():
            yield name, f"n = {n}", partial(sampled, sampler, n)
    for order in (1, 2):
        yield TAYLOR, f"order {order}", partial(expanded, order)
    for degree in DEGREES[: most + 1]:
        for of in ("moments", "quantile"):
            yield CHAOS, f"degree {degree}", partial(fitted, degree, of=of)
    for method in ("form", "sorm"):
        yield method.upper(), "", partial(failing, method)
        yield method.upper(), "", lambda _, method=method: inverted(partial(index, method))
    for accuracy in ACCURACIES[:most]:
        yield ABOUT, f"accuracy {accuracy}", partial(failing, "importance", accuracy=accuracy)
    for samples in LEVELS[:most]:
        yield SUBSET, f"{samples} a level", partial(failing, "subset", samples=samples)


def other_ways(powers: range, most: int) -> Iterator[tuple[str, str, Callable[[int], Found]]]:
    """The same methods of OpenTURNS on the same frame; nothing where it is not installed."""
    if not importable("openturns"):
        return
    from . import reliability_openturns as other

    def told(found: other.Numbers, *which: int) -> Found:
        return {QUANTITIES[k]: found[0][k] for k in which}, found[1]

    def of_failure(seed: int, method: str, effort: float = 0.0) -> Found:
        event = other.Failure(partial(left, limit=exact().limit), exact().std)
        return {QUANTITIES[3]: event.probability(method, seed, effort)}, event.count

    def of_limit(limit: float, method: str) -> tuple[float, int]:
        event = other.Failure(partial(left, limit=limit), exact().std)
        return event.beta(method), event.count

    for n in (2**power for power in powers):
        for name, sampler in SAMPLERS.items():
            yield name, f"n = {n}", lambda seed, s=sampler, n=n: told(other.sampled(height, s, n, seed, HIGH), 0, 1, 2)
    for order in (1, 2):
        # Its deviation is of first order in both.
        kept = (0, 1)[: 3 - order]
        yield TAYLOR, f"order {order}", lambda _, order=order, kept=kept: told(other.expanded(height, order), *kept)
    for degree in DEGREES[: most + 1]:
        yield CHAOS, f"degree {degree}", lambda seed, d=degree: told(other.fitted(height, d, seed, HIGH, 0), 0, 1)
        yield CHAOS, f"degree {degree}", lambda seed, d=degree: told(other.fitted(height, d, seed, HIGH, SURROGATE), 2)
    for method in ("form", "sorm"):
        yield method.upper(), "", partial(of_failure, method=method)
        yield method.upper(), "", lambda _, method=method: inverted(partial(of_limit, method=method))
    for accuracy in ACCURACIES[:most]:
        yield ABOUT, f"accuracy {accuracy}", partial(of_failure, method="importance", effort=accuracy)
    for samples in LEVELS[:most]:
        yield SUBSET, f"{samples} a level", partial(of_failure, method="subset", effort=samples)


def all_rows(powers: range, most: int, seeds: int) -> list[Row]:
    """A row for each quantity, method and effort: root mean square, over seeds, of the relative error."""
    truth, rows = exact(), []
    others = ((OTHERS + name, effort, find) for name, effort, find in other_ways(powers, most))
    for name, effort, find in (*ways(powers, most), *others):
        squares: dict[str, list[float]] = {}
        seconds, evaluations = float("inf"), 0
        for seed in range(seeds):
            start = process_time()
            values, evaluations = find(seed)
            seconds = min(seconds, process_time() - start)
            for quantity, value in values.items():
                squares.setdefault(quantity, []).append((value / truth.of(quantity) - 1.0) ** 2)
        for quantity, each in squares.items():
            error = float(np.sqrt(np.mean(each)))
            if name == PLAIN and quantity == QUANTITIES[3]:
                # Of so few failures the samples themselves tell no error: that of the binomial distribution.
                error = float(np.sqrt((1.0 - RARE) / (RARE * evaluations)))
            rows.append(
                {
                    "quantity": quantity,
                    "method": name,
                    "effort": effort,
                    "evaluations": evaluations,
                    "milliseconds": 1e3 * seconds,
                    "rms_error": error,
                }
            )
    return sorted(rows, key=lambda row: QUANTITIES.index(row["quantity"]))


# -- what comes of it -------------------------------------------------------------------------------------------------


def gains(rows: list[Row], quantity: str) -> dict[str, float]:
    """By method how many times less time it takes than plain Monte Carlo for the error that it reaches, at best.

    Plain Monte Carlo is taken with its longest run, from which its time grows with the inverse square of the error.
    """
    own = [row for row in rows if row["quantity"] == quantity]
    plain = max((row for row in own if row["method"] == PLAIN), key=lambda row: row["evaluations"])
    out: dict[str, float] = {}
    for row in own:
        if row["method"] != PLAIN:
            time = plain["milliseconds"] * (plain["rms_error"] / max(row["rms_error"], 1e-15)) ** 2
            out[row["method"]] = max(out.get(row["method"], 0.0), time / row["milliseconds"])
    return out


def targets(rows: list[Row]) -> list[Target]:
    """The best method of each quantity takes a hundredth of the time of plain Monte Carlo, at equal error."""
    out = []
    for quantity in QUANTITIES:
        found = sorted(gains(rows, quantity).items(), key=lambda pair: -pair[1])
        told = ", ".join(f"{name} {value:.2g}" for name, value in found)
        best = max(value for name, value in found if not name.startswith(OTHERS))
        name = f"{quantity}: {WANTED:g} times less time than plain Monte Carlo at equal error"
        out.append(Target("13 reliability", name, told, best >= WANTED))
    return out


def six_sigma(seeds: int) -> Target:
    """Φ(-6) by importance sampling, to a coefficient of variation of 5 %: the longest time of all seeds."""
    exact, longest, errors = float(ndtr(-6.0)), 0.0, []
    for seed in range(seeds):
        start = process_time()
        found = reliability(
            lambda x: 6.0 - (x["a"] + x["b"]) / np.sqrt(2.0), {"a": norm(), "b": norm()}, rng=seed, accuracy=0.05
        )
        longest = max(longest, process_time() - start)
        errors.append(float(found.probability) / exact - 1.0)
    rms = float(np.sqrt(np.mean(np.square(errors))))
    told = f"{1e3 * longest:.0f} ms, rms error {100.0 * rms:.1f} %, {found.evaluations} evaluations"
    return Target("13 reliability", "probability of 9.9e-10, Φ(-6), to 5 % in under a second", told, longest < 1.0)


def draw(out: Path, rows: list[Row]) -> None:
    """Error over time, a panel for each quantity: our methods filled, those of OpenTURNS open."""
    from matplotlib.lines import Line2D

    looks = dict(zip(METHODS, zip((*COLOURS, "#882255"), "osDX^v<P*", strict=True), strict=True))
    with figure(out, "reliability", columns=4, width=3.2, height=4.2) as panels:
        for quantity, ax in zip(QUANTITIES, panels, strict=True):
            for method in dict.fromkeys(row["method"] for row in rows):
                found = [row for row in rows if (row["quantity"], row["method"]) == (quantity, method)]
                colour, marker = looks[method.removeprefix(OTHERS)]
                look = {"ls": ":", "mfc": "white", "lw": 1.0} if method.startswith(OTHERS) else {}
                times, errors = ([row[name] for row in found] for name in ("milliseconds", "rms_error"))
                ax.plot(times, np.maximum(errors, 1e-16), color=colour, marker=marker, **look)
            ax.set(xlabel="time / ms", xscale="log", yscale="log", title=quantity)
        panels[0].set_ylabel("relative error, rms over seeds")
        labels = [Line2D([], [], color=colour, marker=marker, label=name) for name, (colour, marker) in looks.items()]
        if any(row["method"].startswith(OTHERS) for row in rows):
            open_ = {"color": "#555555", "marker": "o", "ls": ":", "mfc": "white", "lw": 1.0}
            labels.append(Line2D([], [], label="OpenTURNS, same frame (open, dotted)", **open_))
        panels[0].figure.legend(handles=labels, loc="outside lower center", ncols=5, fontsize=8)


if __name__ == "__main__":
    main("reliability", run)
