"""Axes of joints are named in files and studies as they were given, whatever their length and their last bits."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from linkframe.models import Linkage, read_linkage, write_linkage
from numpy.testing import assert_allclose, assert_array_equal


def arm(axis: tuple[float, ...], second: tuple[float, ...] | None = None) -> Linkage:
    linkage = Linkage(A=(0, 0, 0), P=(0.3, 0.1, 0.2))
    linkage.link("arm", "A", "P")
    if second is None:
        linkage.revolute("A", "ground", "arm", axis=axis, drive=True)
    else:
        linkage.universal("A", "ground", "arm", axis=axis, second=second, drive=True)
    return linkage


@pytest.mark.parametrize(
    "axis", [(1.0, 0.2, 0.0), (0.0, 0.0, 3.0), (0.3, -0.7, 0.9), (7.0, 11.0, 13.0), (0.1, 0.2, 0.3)]
)
def test_files_have_the_axes_that_were_given(axis: tuple[float, ...], tmp_path: Path) -> None:
    """And give those of the joint back to the last bit."""
    second = (-axis[1], axis[0], 0.0) if axis[0] else (2.0, 0.0, 0.0)
    for given in (None, second):
        linkage = arm(axis, given)
        write_linkage(linkage, tmp_path / "arm.toml")
        text = (tmp_path / "arm.toml").read_text(encoding="utf-8")
        assert f"axis = {list(axis)}" in text
        assert (f"second = {list(second)}" in text) is (given is not None)
        assert_array_equal(read_linkage(tmp_path / "arm.toml").joints["A"].axes, linkage.joints["A"].axes)


def test_axes_that_were_changed_since_are_written_as_they_are(tmp_path: Path) -> None:
    turned = arm((1.0, 0.2, 0.0))
    write_linkage(turned, tmp_path / "one.toml")
    turned.revolute("A", "ground", "arm", axis=(0.0, 1.0, 0.5), drive=True, replace=True)
    write_linkage(turned, tmp_path / "other.toml")
    assert "axis = [0.0, 1.0, 0.5]" in (tmp_path / "other.toml").read_text(encoding="utf-8")


def test_a_tolerance_of_a_number_of_an_axis() -> None:
    """The worst case of an arm whose skew hinge leans, against arms with other axes."""
    axis, half, angle = np.array([1.0, 0.2, 0.0]), np.array([1e-4, 2e-4, 3e-4]), 0.8
    tolerances = {f"joints.A.axis.{name}": value for name, value in zip("xyz", half, strict=True)}
    found = arm(tuple(axis)).study(tolerances, "P", {"A": [angle]}, n=64, rng=0, progress=False)
    worst = found.worst_case["P"]
    by = []
    for step in 1e-6 * np.eye(3):
        ahead, behind = (arm(tuple(axis + sign * step)).move(A=[angle]).position("P")[0] for sign in (1.0, -1.0))
        by.append((ahead - behind) / 2e-6)
    for along in np.eye(3):
        reach = np.sum(half * np.abs(np.array(by) @ along))
        assert worst.support(along)[0] == pytest.approx(reach, rel=1e-6)


def test_a_cross_given_with_few_digits_keeps_links_rigid() -> None:
    """Its axes are at a right angle to nine digits; those of the joint are so to the last, the first as given."""
    axis, second = np.array([0.6, 0.8, 0.0]), np.array([0.8, -0.6, 0.0]) + 9e-10 * np.array([0.6, 0.8, 0.0])
    linkage = arm(tuple(axis), tuple(second))
    turned = linkage.move(A=(0.7, -0.4)).axes("arm")
    for axes in (linkage.joint("A").axes, turned):
        assert_allclose(axes.T @ axes, np.eye(3), atol=1e-15)
    assert_array_equal(linkage.joint("A").axes[:, 2], axis)
    assert linkage.move(A=(0.7, -0.4)).frame().solve().status == "regular"


def test_joint_axes_depend_on_the_direction_alone() -> None:
    """Also along global z, which most joints have: their axes are the global ones to the last bit."""
    for axis in ((0.0, 0.0, 1.0), (0.0, 0.0, 2.0), (0.0, -0.0, 1.0)):
        assert_array_equal(arm(axis).joints["A"].axes, np.eye(3))
    assert_array_equal(arm((0.0, 0.0, -1.0)).joints["A"].axes, np.diag([1.0, -1.0, -1.0]))
