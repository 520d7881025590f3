"""Old spellings of public names work for one release, with a warning that names the new one."""

from __future__ import annotations

import pytest
from linkframe.elements import Joint
from linkframe.framework.renamed import renamed_keywords
from linkframe.models import Linkage

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
