"""Old spellings of public names work for one release, with a warning that names the new one."""

from __future__ import annotations

from pathlib import Path

import pytest
from linkframe.elements import Joint
from linkframe.framework import FrameError
from linkframe.framework.renamed import renamed_keywords
from linkframe.models import Linkage, read_linkage
from linkframe.models.linkage.files.old_keys import renew

SPRINGS = (1e8,) * 5 + (0.0,)


@renamed_keywords(old="new")
def function(first: int, *, new: int = 0) -> tuple[int, int]:
    return first, new


def test_a_keyword_by_its_old_name() -> None:
    with pytest.warns(DeprecationWarning, match="old= is now new=") as told:
        assert function(1, **{"old": 2}) == (1, 2)
    assert told[0].filename == __file__
    assert function(1, new=2) == (1, 2)
    with pytest.raises(TypeError, match="function was given old= and new=: give new= alone"):
        function(1, **{"old": 2, "new": 3})


def test_clearance_directions() -> None:
    with pytest.warns(DeprecationWarning, match="clearance_directions="):
        joint = Joint(SPRINGS, clearance=1e-3, **{"play": "uy"})  # type: ignore[arg-type]
    assert joint.clearance_directions == (1,)
    with pytest.warns(DeprecationWarning, match="Joint is now called clearance_directions"):
        assert joint.play == (1,)


def test_mobility() -> None:
    linkage = Linkage(A=(0, 0), B=(1, 0))
    linkage.link("AB", "A", "B")
    linkage.revolute("A", "ground", "AB")
    found = linkage.mobility()
    for old, new in {"true": "actual", "by_count": "kutzbach", "by_count_in_space": "kutzbach_spatial"}.items():
        with pytest.warns(DeprecationWarning, match=f"now called {new}") as told:
            assert getattr(found, old) == getattr(found, new) == 1
        assert told[0].filename == __file__


def test_joints_and_loads_of_a_linkage() -> None:
    linkage = Linkage(A=(0, 0), B=(1, 0))
    linkage.link("AB", "A", "B")
    with pytest.warns(DeprecationWarning, match="at= is now reference="):
        linkage.revolute("A", "ground", "AB", **{"at": 0.5})  # type: ignore[arg-type]
    with pytest.warns(DeprecationWarning, match="follows= is now follower="):
        linkage.load("B", fy=1.0, **{"follows": True})  # type: ignore[arg-type]
    assert (linkage.joint("A").reference[0], linkage.loads[0].follower) == (0.5, True)


OLD_FILE = """
[points]
A = [0.0, 0.0]
B = [1.0, 0.0]
[links.arm]
points = ["A", "B"]
[joints.A]
kind = "revolute"
point = "A"
links = ["ground", "arm"]
at = 0.5
[[loads]]
link = "arm"
mz = 2.0
follows = true
"""


def test_keys_of_a_file(tmp_path: Path) -> None:
    file = tmp_path / "arm.toml"
    file.write_text(OLD_FILE)
    with pytest.warns(FutureWarning) as told:
        linkage = read_linkage(file)
    assert [str(each.message).split(":")[0] for each in told] == [
        "joints.A.at is now called reference",
        "loads.0.follows is now called follower",
    ]
    assert (linkage.joint("A").reference[0], linkage.loads[0].follower) == (0.5, True)
    file.write_text(OLD_FILE.replace("at = 0.5", 'at = "x"'))
    with pytest.warns(FutureWarning), pytest.raises(FrameError, match=r"line 11, joints\.A\.at: is 'x'"):
        read_linkage(file)


def test_tolerances_of_a_file() -> None:
    data = {"tolerances": {"t": {"of": ["joints.A.at.rz", "loads.0.mz"], "law": "norm"}}}
    with pytest.warns(FutureWarning, match=r"tolerances\.t\.law is now called distribution"):
        written = renew(data)
    assert data == {"tolerances": {"t": {"of": ["joints.A.reference.rz", "loads.0.mz"], "distribution": "norm"}}}
    assert written == {("tolerances", "t", "distribution"): ("tolerances", "t", "law")}


def test_compliance_matrix_of_a_motion() -> None:
    linkage = Linkage(A=(0, 0), B=(1, 0))
    linkage.link("AB", "A", "B")
    linkage.revolute("A", "ground", "AB", drive=True)
    motion = linkage.move(A=0.3)
    with pytest.warns(DeprecationWarning, match="Motion is now called compliance_matrix"):
        assert not motion.flexibility("B").any()
