"""What a study says of numbers that the file of the linkage does not have: what it has in their stead."""

from __future__ import annotations

import re

import pytest
from linkframe import Beam, FrameError, Linkage, Material, Rectangle


@pytest.mark.parametrize(
    ("name", "told"),
    [
        ("materials.steel.E", "materials has no 'steel': give one of material1"),
        ("joints.A.clearanc", "joints.A has no 'clearanc': give one of kind, point, links"),
        ("joint.A.clearance", "the file has no 'joint': give one of points, links, joints, beams, sections, materials"),
        ("points.B.x.y", "points.B.0 is 0.2, which has no parts"),
    ],
)
def test_a_number_that_is_not_there(name: str, told: str) -> None:
    linkage = Linkage(A=(0, 0), B=(0.2, 0))
    linkage.link("arm", "A", "B", beam=Beam(Rectangle(y=0.02, z=0.01), Material(E=200e9, nu=0.3)))
    linkage.revolute("A", "ground", "arm", drive=True)
    with pytest.raises(FrameError, match=re.escape(told)):
        linkage.study({name: "± 3 %"}, "B", {"A": [0.0]})
