"""What a refusal names: entries that a file has not, and shapes that do not fit."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from linkframe.framework import FrameError
from linkframe.models import Linkage
from linkframe.models.linkage.job.inputs import read_inputs

FOUR_BAR = Path(__file__).parents[2] / "examples" / "four_bar.toml"


@pytest.mark.parametrize(
    ("name", "told"),
    [
        ("nosuch", "there is no 'nosuch' in this file: the file has points, links, joints, loads"),
        ("joints.C.clearance", "there is no 'joints.C.clearance' in this file: joints has A, B, D, E"),
        ("joints.A.clearance", "in this file: joints.A has kind, point, links, drive, reference"),
        ("joints.B.clearance.x", "there is no 'joints.B.clearance.x' in this file: joints.B.clearance is 0.001"),
        ("run.samples", "'run.samples' is no part of the linkage"),
    ],
)
def test_a_tolerance_of_what_is_not_there(name: str, told: str) -> None:
    with pytest.raises(FrameError, match=re.escape(told)):
        read_inputs(FOUR_BAR, [(name, "± 5 %")])


def test_a_temperature_of_another_shape() -> None:
    linkage = Linkage(A=(0, 0), B=(1, 0))
    linkage.link("arm", "A", "B")
    linkage.revolute("A", "ground", "arm", drive=True)
    motion = linkage.move(A=np.zeros(3))
    with pytest.raises(FrameError, match=r"temperature of 'arm' has batch shape \(2,\), which does not broadcast"):
        motion.accuracy("B", temperature=np.ones(2), expansion=1e-5)
    with pytest.raises(FrameError, match=r"does not broadcast with \(2,\) of expansion of 'arm'"):
        motion.accuracy("B", temperature=np.ones(3), expansion={"arm": np.ones(2)})
