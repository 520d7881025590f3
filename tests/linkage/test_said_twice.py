"""What is said twice, as by a notebook cell that runs again, is refused or replaced; loads, and drives that hold."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from linkframe.elements import Beam, Circle, Material
from linkframe.framework import FrameError, MechanismWarning
from linkframe.models import Linkage, LoadsWarning
from numpy.testing import assert_allclose

ROD = Beam(Circle(diameter=0.02), Material(E=200e9, nu=0.3, density=7850.0))


def arm(stiffness: object = None, **joint: object) -> Linkage:
    linkage = Linkage(A=(0, 0), B=(1, 0))
    linkage.link("arm", "A", "B", beam=ROD)
    linkage.revolute("A", "ground", "arm", drive=True, stiffness=stiffness, **joint)  # type: ignore[arg-type]
    return linkage


CELLS: dict[str, Callable[..., None]] = {
    "joint": lambda k, **o: k.revolute("B", "arm", "hand", "third", stiffness=(1e6,) * 5 + (0.0,), **o),
    "slider": lambda k, **o: k.prismatic("B", "arm", "hand", axis=(1, 0), reference=0.1, **o),
    "spring": lambda k, **o: k.spring("A", "C", stiffness=3.0, length=0.1, **o),
    "load": lambda k, **o: k.load("C", fy=[1.0, 2.0], mz=3.0, **o),
    "torque": lambda k, **o: k.torque("arm", mz=3.0, follower=True, **o),
}


@pytest.mark.parametrize("cell", CELLS)
def test_a_cell_that_runs_twice(cell: str) -> None:
    linkage = Linkage(A=(0, 0), B=(1, 0), C=(1, 1))
    for name, points in {"arm": "AB", "hand": "BC", "third": "BC"}.items():
        linkage.link(name, *points)
    CELLS[cell](linkage)
    once = {name: repr(value) for name, value in vars(linkage).items()}
    with pytest.raises(FrameError, match="replace=True"):
        CELLS[cell](linkage)
    assert {name: repr(value) for name, value in vars(linkage).items()} == once
    CELLS[cell](linkage, replace=True)
    counts = [len(part) for part in (linkage.joints, linkage.springs, linkage.loads)]
    assert counts == {"joint": [2, 0, 0], "slider": [1, 0, 0], "spring": [0, 1, 0]}.get(cell, [0, 0, 1])


def test_a_joint_takes_the_place_of_another_or_stands_beside_it() -> None:
    linkage = arm()
    linkage.revolute("A", "ground", "arm", stiffness=(2e5,) * 5 + (7.0,), replace=True)
    assert list(linkage.joints) == ["A"]
    assert linkage.joints["A"].full_stiffness[5] == 7.0
    assert not linkage.drives
    linkage.revolute("A", "arm", "ground", name="second bearing", reference=[0.0, 0.1])
    linkage.prismatic(
        "A", "ground", "arm", axis=(1, 0), name="A", reference=np.zeros(3)[:, None], replace=True, drive=True
    )
    assert [pair.kind.name for pair in linkage.joints.values()] == ["prismatic", "revolute"]
    assert linkage.drives == {"A": ("uz",)}
    assert linkage.shape == (3, 2)
    linkage.prismatic("A", "ground", "arm", axis=(1, 0), replace=True)
    assert linkage.shape == (2,)


def test_loads_that_differ_add_up_and_replace_takes_all() -> None:
    linkage = arm()
    linkage.load("B", fy=1.0)
    linkage.load("B", fy=2.0)
    assert_allclose(linkage.move(A=0.0).reactions().drive("A"), [-3.0], rtol=1e-12)
    linkage.load("B", fy=5.0, replace=True)
    assert_allclose(linkage.move(A=0.0).reactions().drive("A"), [-5.0], rtol=1e-12)


def test_a_drive_is_as_stiff_as_it_was_given() -> None:
    """Tip deflection F L^2 / k and that of the rod, down to a drive that does not hold at all."""
    rod = 1.0 / (3 * 200e9 * np.pi * 0.02**4 / 64)
    for k in (1.0, 1e-3, 1e-9, np.inf):
        solution = arm((np.inf,) * 5 + (k,)).move(A=0.0).accuracy("B", fy=1.0)
        assert_allclose(solution.total[1], 1.0 / k + rod, rtol=1e-9)
    assert_allclose(arm().move(A=0.0).accuracy("B", fy=1.0).total[1], rod, rtol=1e-9)
    loose = arm((np.inf,) * 5 + (0.0,))
    loose.load("B", fy=1.0)
    motion = loose.move(A=0.0)
    solution = motion.frame().solve()
    with pytest.warns(MechanismWarning, match="kinematically unstable"):
        assert np.isnan(solution.displacement("B")).all()
    assert solution.status == "mechanism"
    assert_allclose(motion.reactions().drive("A"), [-1.0], rtol=1e-12)


FREE = {
    "revolute": ("rz",),
    "prismatic": ("uz",),
    "cylindrical": ("uz", "rz"),
    "spherical": ("rx", "ry", "rz"),
    "universal": ("rz", "rx"),
    "planar": ("ux", "uy", "rz"),
    "screw": ("rz",),
}


@pytest.mark.parametrize("kind", FREE)
def test_no_stiffness_locks_what_a_joint_leaves_free(kind: str) -> None:
    further = {"prismatic": {"axis": (0, 0, 1)}, "universal": {"axis": (0, 0, 1), "second": (1, 0)}}
    further["screw"] = {"axis": (0, 0, 1), "pitch": 0.1}  # type: ignore[dict-item]
    for name in FREE[kind]:
        linkage = arm()
        linkage.link("hand", "B")
        springs = np.zeros((2, 6))
        springs[1, ("ux", "uy", "uz", "rx", "ry", "rz").index(name)] = np.inf
        getattr(linkage, kind)("B", "arm", "hand", stiffness=springs, **further.get(kind, {}))
        with pytest.raises(
            FrameError, match=f"stiffness of joint 'B' is inf on {name}, which a {kind} joint leaves free"
        ):
            linkage.move(A=0.0)
        linkage.drive("B", name)
        linkage.check_free()


def test_loads_of_a_frame_are_not_those_of_the_motion() -> None:
    motion = arm().move(A=[0.0, 0.5])
    frame = motion.frame()
    assert not motion.reactions().drive("A").any()
    frame.load("B", fy=1.0)
    with pytest.warns(LoadsWarning, match=r"reactions\(\) does not contain.*linkage\.load"):
        assert not motion.reactions().drive("A").any()
    with pytest.warns(LoadsWarning, match=r"stress\(\) does not contain"):
        assert not motion.stress("arm").von_mises.any()
    del frame
    assert not motion.reactions().drive("A").any()
    motion.linkage.load("B", fy=1.0)
    assert_allclose(motion.reactions().drive("A")[0], [-1.0], rtol=1e-12)
    assert_allclose(motion.frame().solve().joint_force("A")[0, 5], 1.0, rtol=1e-9)
    assert motion.stress("arm").von_mises.all()
