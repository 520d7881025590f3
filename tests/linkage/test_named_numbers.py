"""What a study says of numbers that the file of the linkage does not have: what it has in their stead."""

from __future__ import annotations

import re

import pytest
from linkframe import Beam, FrameError, Linkage, Material, Rectangle


@pytest.mark.parametrize(
    ("name", "told"),
    [
        ("materials.steel.E", "there is no 'materials.steel.E' in this file: materials has material1"),
        ("joints.A.clearanc", "in this file: joints.A has kind, point, links"),
        ("joint.A.clearance", "in this file: the file has points, links, joints, beams, sections, materials"),
        ("points.B.x.y", "in this file: points.B.0 is 0.2"),
    ],
)
def test_a_number_that_is_not_there(name: str, told: str) -> None:
    linkage = Linkage(A=(0, 0), B=(0.2, 0))
    linkage.link("arm", "A", "B", beam=Beam(Rectangle(y=0.02, z=0.01), Material(E=200e9, nu=0.3)))
    linkage.revolute("A", "ground", "arm", drive=True)
    with pytest.raises(FrameError, match=re.escape(told)):
        linkage.study({name: "± 3 %"}, "B", {"A": [0.0]})
