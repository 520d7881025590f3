"""Forces and motions along an arm, and finite rotations, against SciPy and against each other."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from linkframe.framework import rotation
from linkframe.framework.arm import carried, carrying, cross_matrix, crossed, transferred
from numpy.testing import assert_allclose, assert_array_equal
from scipy.spatial.transform import Rotation

number = st.floats(-3.0, 3.0)
vectors = st.tuples(number, number, number).map(np.array)
sixes = st.tuples(*(number,) * 6).map(np.array)


@given(vectors, vectors)
@settings(max_examples=25, deadline=None)
def test_cross_products_are_those_of_numpy(a: np.ndarray, b: np.ndarray) -> None:
    assert_array_equal(crossed(a, b), np.cross(a, b))
    assert_allclose(cross_matrix(a) @ b, np.cross(a, b), atol=1e-14)


@given(sixes, sixes, vectors)
@settings(max_examples=25, deadline=None)
def test_a_force_does_the_same_work_at_both_ends_of_an_arm(
    force: np.ndarray, motion: np.ndarray, arm: np.ndarray
) -> None:
    assert_allclose(transferred(force, arm) @ motion, force @ carried(motion, arm), atol=1e-12)
    assert_allclose(carrying(arm) @ motion, carried(motion, arm), atol=1e-13)


@given(sixes, vectors)
@settings(max_examples=25, deadline=None)
def test_forces_in_a_plane_are_those_of_space(force: np.ndarray, arm: np.ndarray) -> None:
    plane, flat = [0, 1, 5], np.array([1.0, 1.0, 0.0])
    full = transferred(force * np.array([1.0, 1.0, 0.0, 0.0, 0.0, 1.0]), arm * flat)
    assert_array_equal(transferred(force[plane], arm[:2]), full[plane])
    assert_array_equal(crossed(force[:2], arm[:2]), np.cross(force[:3] * flat, arm * flat)[2:])


def test_an_arm_takes_batches_and_keeps_extended_precision() -> None:
    force, arm = np.ones((4, 1, 6), np.longdouble), np.arange(9.0).reshape(3, 3)
    assert transferred(force, arm).shape == carried(force, arm).shape == (4, 3, 6)
    assert transferred(force, arm).dtype == carried(force, arm).dtype == np.longdouble


@given(vectors, vectors)
@settings(max_examples=25, deadline=None)
def test_rotations_are_those_of_scipy(a: np.ndarray, b: np.ndarray) -> None:
    one, other = (Rotation.from_rotvec(each) for each in (a, b))
    both = rotation.product(rotation.exponential(a), rotation.exponential(b))
    assert_allclose(rotation.matrix(both), (one * other).as_matrix(), atol=1e-14)
    assert_allclose(b + rotation.rotated(rotation.exponential(a), b), one.apply(b), atol=1e-14)


@pytest.mark.parametrize("angle", [0.0, 1e-12, 1e-4, 2.0, np.pi - 1e-9, np.pi])
def test_matrices_give_their_rotation_back(angle: float) -> None:
    """All axes at once, with a matrix among them that is of no assembled position."""
    axes = np.random.default_rng(0).normal(size=(3, 40))
    given = angle * axes / np.linalg.norm(axes, axis=0)
    matrices = np.moveaxis(Rotation.from_rotvec(given.T).as_matrix(), 0, -1)
    matrices[..., 7] = np.nan
    quaternions = rotation.of_matrix(matrices)
    found = rotation.logarithm(quaternions)
    assert np.isnan(found[:, 7]).all()
    there = np.delete(np.arange(40), 7)
    assert_allclose(rotation.matrix(quaternions)[..., there], matrices[..., there], atol=1e-14)
    off = np.minimum(*(np.abs(found - sign * given).max(axis=0) for sign in (1.0, -1.0)))
    assert_allclose(off[there] if angle > 3.0 else np.abs(found - given).max(axis=0)[there], 0.0, atol=1e-14)
