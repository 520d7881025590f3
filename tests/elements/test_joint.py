"""Joint: Eq. (5) in its own axes, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from linkframe.elements import Joint
from linkframe.framework.errors import FrameError
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

springs = st.tuples(*[st.floats(0.0, 1e12)] * 6)
angles = st.tuples(*[st.floats(-3.0, 3.0)] * 3)


def test_equation_5() -> None:
    k = np.arange(1.0, 7.0)
    K = Joint(stiffness=k).matrix()
    assert np.array_equal(K, np.block([[np.diag(k), -np.diag(k)], [-np.diag(k), np.diag(k)]]))


@given(stiffness=springs, turn=angles)
def test_energy_is_that_of_six_springs_along_the_joint_axes(
    stiffness: tuple[float, ...], turn: tuple[float, float, float]
) -> None:
    R = Rotation.from_rotvec(turn).as_matrix()
    K = Joint(stiffness=stiffness, axes=R).matrix()
    u = np.random.default_rng(6).normal(size=12)
    gap = u[6:] - u[:6]
    own = np.concatenate([R.T @ gap[:3], R.T @ gap[3:]])
    assert u @ K @ u == pytest.approx(np.sum(np.array(stiffness) * own**2), rel=1e-9)
    assert np.array_equal(K, K.T)
    assert_allclose(K[:6] @ u, -(K[6:] @ u))
    # what both nodes do together costs nothing
    assert_allclose(K @ np.tile(np.arange(6.0), 2), 0.0, atol=1e-15 * max(stiffness) * 100)


def test_a_turned_axis_is_a_column() -> None:
    """A spring along the joint's x, which points along global y."""
    R = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    K = Joint(stiffness=(5.0, 0, 0, 7.0, 0, 0), axes=R).matrix()
    assert (K[1, 1], K[0, 0], K[4, 4], K[3, 3]) == (5.0, 0.0, 7.0, 0.0)
    assert K[1, 7] == -5.0


def test_a_batch_is_its_members() -> None:
    k = np.random.default_rng(7).uniform(0.0, 1.0, (4, 1, 6))
    R = Rotation.from_rotvec(np.random.default_rng(8).normal(size=(3, 3))).as_matrix()
    batch = Joint(stiffness=k, axes=R)
    K = batch.matrix()
    assert batch.shape == (4, 3)
    assert K.shape == (4, 3, 12, 12)
    for i, j in np.ndindex(4, 3):
        assert_allclose(K[i, j], Joint(stiffness=k[i, 0], axes=R[j]).matrix(), rtol=1e-15, atol=1e-15)


def test_ideal_and_free_are_welcome_but_have_no_matrix() -> None:
    joint = Joint(stiffness=(np.inf, np.inf, 1.0, 0.0, 0.0, 0.0))
    assert joint.shape == ()
    with pytest.raises(FrameError, match="ktx = inf has no stiffness matrix"):
        joint.matrix()
    with pytest.raises(FrameError, match="krz = inf"):
        Joint(stiffness=np.array([[1.0] * 6, [1.0] * 5 + [np.inf]])).matrix()


@pytest.mark.parametrize(
    ("stiffness", "axes", "told"),
    [
        ((1.0, -2.0, 0, 0, 0, 0), None, r"stiffness = -2 must be 0 \(free\) to inf \(ideal\)"),
        ((1.0, float("nan"), 0, 0, 0, 0), None, "stiffness = nan must be 0"),
        ((1.0, 2.0), None, r"stiffness has shape \(2,\); give six springs"),
        (1.0, None, r"stiffness has shape \(\)"),
        (("a",) * 6, None, "give a number or an array of numbers"),
        ((1.0,) * 6, np.eye(3) * 2, r"not orthonormal \(off by 3\)"),
        ((1.0,) * 6, np.full((3, 3), np.nan), "axes contains nan"),
        ((1.0,) * 6, np.diag([1.0, 1.0, -1.0]), "left-handed"),
        ((1.0,) * 6, np.eye(2), r"axes have shape \(2, 2\)"),
        (np.ones((2, 6)), np.stack([np.eye(3)] * 3), r"stiffness \(2,\), axes \(3,\)"),
    ],
)
def test_what_cannot_be_is_refused(stiffness: object, axes: object, told: str) -> None:
    with pytest.raises(FrameError, match=told):
        Joint(stiffness=stiffness, axes=axes)  # type: ignore[arg-type]


def test_play_in_one_component_needs_no_tuple() -> None:
    assert Joint(stiffness=(1e8,) * 6, clearance=1e-3, clearance_directions="uy").clearance_directions == (1,)
