"""What cannot be meant in a study or a calibration is refused by its name, with what would be right."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.framework.errors import FrameError
from linkframe.models import Linkage, Measured

ANGLES = np.radians([-20.0, 20.0])
START = {"length": 0.2}


def arm(length=0.2):
    length = np.asarray(length)
    linkage = Linkage(A=(0, 0), P=np.stack([length, 0.0 * length], axis=-1))
    linkage.link("arm", "A", "P")
    linkage.revolute("A", "ground", "arm", drive=True)
    return linkage


@pytest.mark.parametrize(
    ("given", "told"),
    [
        (0.0, "0.0 .* half width above zero"),
        (-1e-5, "-1e-05 .* half width above zero"),
        (float("nan"), "nan .* half width above zero"),
        (float("inf"), "inf .* half width above zero"),
        ("± 0", "leaves no room"),
        ("± 1 mm", "± 1 mm.*write it as"),
        ((0.3, 0.1), "two finite bounds"),
    ],
)
def test_tolerances_are_refused_by_their_name(given, told):
    with pytest.raises(FrameError, match=rf"tolerances\.points\.P\.x: .*{told}"):
        arm().study({"points.P.x": given}, "P", {"A": ANGLES}, n=16, rng=0)


def test_a_part_that_is_not_there():
    parts = arm().study({"points.P.x": 1e-5}, "P", {"A": ANGLES}, n=16, rng=0).parts
    assert "clearance" not in parts
    with pytest.raises(KeyError, match="no part 'clearance': choose one of geometry, together"):
        parts["clearance"]


@pytest.mark.parametrize(
    ("build", "start", "told"),
    [
        (arm, {"lenght": 0.2}, r"build takes \(length=0.2\), but is called with lenght by name"),
        (arm, {}, "name the parameters"),
        (arm, ["length"], "name the parameters"),
        (arm, {"length": "0.2"}, "'length' begins at '0.2': give one finite number"),
        (arm, {"length": np.array([0.2, 0.3])}, "'length' begins at .* give one finite number"),
        (arm, {"length": None}, "'length' begins at None: give one finite number"),
        (arm, {"length": float("nan")}, "'length' begins at nan: give one finite number"),
        (arm(), START, "build is .*: give a function of length"),
        (lambda length: 3.0, START, "build returned 3.0: return the linkage"),
    ],
)
def test_calibrations_are_refused_at_the_call(build, start, told):
    motion = arm().move(A=ANGLES)
    with pytest.raises(FrameError, match=told):
        motion.calibrate("P", Measured(motion.position("P"), 1e-6, {"A": ANGLES}), build, start)


@pytest.mark.parametrize(
    ("scales", "told"),
    [
        ({"length": "a"}, "scale of parameter 'length' is 'a': give one number"),
        ({"length": 0.0}, "scale of parameter 'length' is 0.0: give one number, and not zero"),
        ({"lenght": 1.0}, "scales names 'lenght', which is not among the parameters length"),
        ([0.1], r"scales is \[0.1\]: give sizes by the names"),
    ],
)
def test_scales_are_refused_by_their_name(scales, told):
    motion = arm().move(A=ANGLES)
    with pytest.raises(FrameError, match=told):
        motion.calibrate("P", Measured(motion.position("P"), 1e-6, {"A": ANGLES}), arm, START, scales=scales)


@pytest.mark.parametrize("width", [np.float32(1e-5), np.float64(1e-5)])
def test_half_widths_may_be_numbers_of_arrays(width):
    given = arm().study({"points.P.x": width}, "P", {"A": ANGLES}, n=16, rng=0).tolerances["points.P.x"]
    assert given.distribution.ppf(1.0) == pytest.approx(0.2 + 1e-5, rel=1e-12)


def test_a_zone_is_asked_of_a_linkage_of_its_dimensions():
    with pytest.raises(FrameError, match="but is called with lenght by name"):
        arm().move(A=ANGLES).reliability("P", 1e-5, arm, {"lenght": "0.2 ± 0.1 %"})
