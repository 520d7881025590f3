"""Point mass: kinetic energy of a rigid body, Steiner, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from linkframe.elements import PointMass
from linkframe.framework.errors import FrameError
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

vectors = st.tuples(*[st.floats(-3.0, 3.0)] * 3).map(np.array)


@given(mass=st.floats(0.0, 10.0), offset=vectors, velocity=vectors, spin=vectors)
def test_kinetic_energy_of_a_rigid_body(
    mass: float, offset: np.ndarray, velocity: np.ndarray, spin: np.ndarray
) -> None:
    """Half of m |v + w x o|^2 + w I w."""
    inertia = np.array([[3.0, 0.5, -0.2], [0.5, 2.0, 0.1], [-0.2, 0.1, 1.0]])
    M = PointMass(mass, inertia=inertia, offset=offset).mass_matrix()
    motion = np.concatenate([velocity, spin])
    centre = velocity + np.cross(spin, offset)
    assert motion @ M @ motion == pytest.approx(mass * centre @ centre + spin @ inertia @ spin, abs=1e-11)
    assert np.array_equal(M, M.T)


def test_eight_points_are_a_body() -> None:
    """A cube's corners, summed, have the mass and tensor of the whole: m, and m a^2 / 2 about each axis (side a)."""
    corners = np.stack(np.meshgrid(*[[-0.5, 0.5]] * 3), axis=-1).reshape(-1, 3)
    M = PointMass(1.0, offset=corners).mass_matrix()
    assert M.shape == (8, 6, 6)
    assert_allclose(M.sum(axis=0), np.diag([8.0] * 3 + [4.0] * 3), atol=1e-15)


def test_shapes() -> None:
    batch = PointMass(np.arange(4.0)[:, None], inertia=np.ones((5, 3)), offset=(1.0, 0.0, 0.0))
    assert batch.shape == (4, 5)
    assert batch.mass_matrix().shape == (4, 5, 6, 6)
    assert_allclose(batch.mass_matrix()[3, 2], PointMass(3.0, inertia=(1, 1, 1), offset=(1, 0, 0)).mass_matrix())
    assert PointMass(1.0, inertia=np.eye(3)).shape == ()


@pytest.mark.parametrize("scale", [1.0, 1e150, 1e-150])
def test_a_tensor_that_was_turned_is_symmetric_to_rounding(scale: float) -> None:
    rng = np.random.default_rng(0)
    turn = Rotation.from_rotvec(rng.normal(size=(50, 3))).as_matrix()
    inertia = turn @ np.diag([1.0, 2e-3, 3e-9]) @ np.swapaxes(turn, -1, -2) * scale
    assert (inertia != np.swapaxes(inertia, -1, -2)).any()
    M = PointMass(scale, inertia=inertia).mass_matrix()
    assert np.array_equal(M, np.swapaxes(M, -1, -2))
    assert_allclose(M[:, 3:, 3:], inertia, rtol=0.0, atol=1e-15 * scale)
    inertia[7, 0, 1] += 1e-9 * scale
    with pytest.raises(FrameError, match="not symmetric"):
        PointMass(scale, inertia=inertia)


@pytest.mark.parametrize(
    ("given_", "told"),
    [
        ({"mass": -1.0}, "mass = -1 must be zero or above"),
        ({"mass": float("nan")}, "mass = nan must be finite"),
        ({"mass": 1.0, "inertia": (1.0, -1.0, 1.0)}, "inertia = -1 must be zero or above"),
        ({"mass": 1.0, "inertia": (1.0, float("inf"), 1.0)}, "inertia = inf must be finite"),
        ({"mass": 1.0, "inertia": 1.0}, r"inertia has shape \(\)"),
        ({"mass": 1.0, "inertia": np.triu(np.ones((3, 3)))}, "inertia is not symmetric"),
        ({"mass": 1.0, "inertia": np.diag([1.0, 1.0, -1.0])}, r"least principal moment\) = -1 must be zero or above"),
        ({"mass": 1.0, "offset": (1.0, 2.0)}, r"offset has shape \(2,\)"),
        ({"mass": 1.0, "offset": (1.0, 2.0, float("nan"))}, "offset = nan must be finite"),
        ({"mass": np.ones(2), "offset": np.ones((3, 3))}, r"mass \(2,\), offset \(3,\)"),
    ],
)
def test_what_cannot_be_is_refused(given_: dict[str, object], told: str) -> None:
    with pytest.raises(FrameError, match=told):
        PointMass(**given_)  # type: ignore[arg-type]
