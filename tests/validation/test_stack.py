"""A stack of seven dimensions as tolerance calculators print it: MITCalc's example, which dimstack's README repeats.

Gap of 208 ± 0.036, less 1.75 (+0.06, 0), less 23 (+0.12, 0), plus 20 ± 0.026, less 200 ± 0.145, plus 20 ± 0.026, less
23 (+0.12, 0), mm.
"""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.models import propagate, reliability, taylor_moments, tolerance
from linkframe.models.distributions import Normal

PARTS = {
    "housing": (1.0, 208.0, "± 0.036"),
    "ring": (-1.0, 1.75, "+0.06/-0"),
    "first bearing": (-1.0, 23.0, "+0.12/-0"),
    "first sleeve": (1.0, 20.0, "± 0.026"),
    "shaft": (-1.0, 200.0, "± 0.145"),
    "second sleeve": (1.0, 20.0, "± 0.026"),
    "second bearing": (-1.0, 23.0, "+0.12/-0"),
}


def gap(**parts):
    return sum(PARTS[name.replace("_", " ")][0] * value for name, value in parts.items())


def inputs(distribution):
    return {name.replace(" ", "_"): tolerance(size, text, distribution) for name, (_, size, text) in PARTS.items()}


def test_worst_case_is_that_of_the_intervals():
    """0.1 ± 0.383."""
    laws = [(sign, law) for (sign, *_), law in zip(PARTS.values(), inputs("uniform").values(), strict=True)]
    low = sum(law.low if sign > 0.0 else -law.high for sign, law in laws)
    high = sum(law.high if sign > 0.0 else -law.low for sign, law in laws)
    assert (low, high) == pytest.approx((0.1 - 0.383, 0.1 + 0.383), abs=1e-12)


def test_root_sum_of_squares():
    """0.1 ± 0.17825 at three standard deviations."""
    found = taylor_moments(gap, inputs("normal"), order=1)
    assert float(found.mean) == pytest.approx(0.1, abs=1e-9)
    assert 3.0 * float(found.std) == pytest.approx(0.17825, abs=5e-6)
    drawn = propagate(gap, inputs("normal"), n=4096, rng=0, sampler="sobol")
    assert abs(float(drawn.std) - float(found.std)) < 4.0 * float(drawn.std_standard_error)


@pytest.mark.parametrize("method", ["form", "importance"])
def test_yield(method):
    """80.644 % between 0.05 and 0.8 with the standard deviation 0.05781 of the gap."""
    gap_itself = {"gap": Normal(0.1, 0.05781)}
    found = reliability(
        lambda x: np.minimum(x["gap"] - 0.05, 0.8 - x["gap"]), gap_itself, method=method, rng=0, accuracy=0.01
    )
    off = 2e-5 if method == "form" else 4.0 * float(found.standard_error)
    assert 1.0 - float(found.probability) == pytest.approx(0.80644, abs=off)


def test_one_way_clutch():
    """Contact angle of Chase's one-way clutch (ADCATS): 7.0184°, by root sum of squares ± 0.31673°."""
    sizes = {"hub": (27.645, 0.0125), "roller": (11.43, 0.01), "ring": (50.8, 0.0125)}

    def angle(hub, roller, ring):
        return np.degrees(np.arccos((hub + roller) / (ring - roller)))

    assert float(angle(*(size for size, _ in sizes.values()))) == pytest.approx(7.01839, abs=5e-6)
    laws = {name: Normal(size, spread / 3.0) for name, (size, spread) in sizes.items()}
    first = taylor_moments(angle, laws, order=1)
    assert 3.0 * float(first.std) == pytest.approx(0.316733, abs=2e-6)
    # its curvature adds to the spread what samples show, too
    second, drawn = taylor_moments(angle, laws, order=2), propagate(angle, laws, n=2**14, rng=0, sampler="sobol")
    assert float(second.std) > float(first.std)
    assert abs(float(drawn.mean) - float(second.mean)) < abs(float(drawn.mean) - float(first.mean))
