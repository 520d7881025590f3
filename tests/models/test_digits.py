"""What the job says of its own numbers: certain digits, and poses beyond linear mechanics."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from linkframe.models.job.digits import as_markdown, certain_digits
from linkframe.models.paper.inputs import Inputs
from linkframe.models.paper.result import Result, compute
from linkframe.models.paper.table import as_text

pytestmark = pytest.mark.filterwarnings("ignore::linkframe.framework.MechanismWarning")


@cache
def near_singular() -> Result:
    return compute(Inputs(poses=(0.0, 10.0, 1.0), samples=20, clearance=0.0, clearance_sd=0.0))


def test_poses_beyond_linear_mechanics_are_marked() -> None:
    """At 0 degrees singular; at 1 degree under 100 N the linear displacement is twice the true one; at 10 it holds."""
    result = near_singular()
    marked = result.marked_status
    assert marked[0].startswith("singular")
    assert all(
        status.startswith("outside the linear range: estimated error") and status.endswith(" %")
        for status in marked[1:4]
    )
    assert all(status == "regular" or status.endswith("% of the spread") for status in marked[4:])
    assert marked[7] == "regular"
    lines = as_text(result).splitlines()
    assert "outside the linear range: estimated error 1.2e+02 %" in lines[2]
    assert lines[8].endswith("regular")


def test_the_mark_tells_how_far_the_large_displacement_is() -> None:
    """Within a factor of three of the difference between linear and large displacement where that is 1 to 200 %."""
    result = near_singular()
    frame = result.motion.frame()
    frame.load("P", fy=result.inputs.load)
    large = frame.solve(large=True).displacement("P")[1:6, :2]
    linear = result.compliance[1:6, :2]
    off = np.linalg.norm(linear - large, axis=-1) / np.linalg.norm(large, axis=-1)
    ratio = result.nonlinearity[1:6] / off
    assert np.all((ratio > 1 / 3) & (ratio < 3))


def test_digits_are_those_of_the_bounds() -> None:
    """Every regular pose has a bound; digits of the spread follow from it."""
    result = near_singular()
    assert np.isnan(result.error_bound[0]).all()
    assert np.all(result.error_bound[1:, :2] > 0.0)
    found = {name: (error, digits) for name, error, digits, _ in certain_digits(result)}
    assert list(found) == ["x", "y", "μ_x", "μ_y", "σ_x", "σ_y", "κ", "κ scaled"]
    error, digits = found["σ_y"]
    assert 1e-20 < error < 1e-12
    relative = (result.error_bound[1:, 1] / result.std[1:, 1]).max() * np.sqrt(20 / 19)
    assert digits == int(-np.log10(relative))
    assert 8 <= digits <= 15
    assert found["κ"][1] < found["κ scaled"][1]
    assert "| σ_y |" in as_markdown(result)


def test_a_singular_pose_has_no_certain_digit() -> None:
    result = near_singular()
    assert np.isinf(result.study.nominal.error_bound[0]).all()
    assert np.isinf(result.nonlinearity[0])
