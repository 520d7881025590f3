"""Axes of bodies and joints are refused where one of them is no rotation, in a batch of any size."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.elements import Joint
from linkframe.framework import Frame
from linkframe.framework.batch import rotation
from linkframe.framework.errors import FrameError
from scipy.spatial.transform import Rotation

SIZES = (None, 2, 64, 65, 500)


def _rotations(size: int | None) -> np.ndarray:
    found = Rotation.random(size or 1, rng=4).as_matrix()
    return found[0] if size is None else found


@pytest.mark.parametrize("size", SIZES)
def test_rotations_are_taken_as_they_are(size: int | None) -> None:
    given = _rotations(size)
    assert np.array_equal(rotation(given, "axes"), given)


def test_a_batch_of_two_axes_and_an_empty_one() -> None:
    given = _rotations(500)
    assert rotation(given.reshape(20, 25, 3, 3), "axes").shape == (20, 25, 3, 3)
    assert rotation(given[:0], "axes").shape == (0, 3, 3)


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("row", range(3))
@pytest.mark.parametrize("column", range(3))
def test_one_wrong_number_among_many_is_found(size: int | None, row: int, column: int) -> None:
    """Of axes that lie along the global ones, so that every number matters by itself: by 2e-9 it is too far off."""
    given = np.eye(3) if size is None else np.tile(np.eye(3), (size, 1, 1))
    given[..., row, column] += 0.0 if size is None else 1e-12  # within what rounding may do
    wrong = given[-1] if size is not None else given
    wrong[row, column] += 2e-9
    with pytest.raises(FrameError, match=r"axes are not orthonormal \(off by (2e-09|4e-09)\)"):
        rotation(given, "axes")


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("column", range(3))
def test_one_column_the_other_way_round_is_found(size: int | None, column: int) -> None:
    given = _rotations(size)
    (given if size is None else given[-1])[:, column] *= -1.0
    with pytest.raises(FrameError, match="axes are left-handed"):
        rotation(given, "axes")


@pytest.mark.parametrize("factor", [0.0, 1e-6, 2.0])
def test_other_sizes_are_found(factor: float) -> None:
    with pytest.raises(FrameError, match="of body 'wheel' are not orthonormal"):
        Frame().body("wheel", axes=factor * _rotations(100))


@pytest.mark.parametrize("stretched", [0, 1])
def test_two_columns_of_other_lengths_are_found(stretched: int) -> None:
    """The third is then still the product of the first two, which stand at right angles."""
    given = _rotations(100)
    given[7][:, [stretched, 2]] *= 1.1
    with pytest.raises(FrameError, match=r"not orthonormal \(off by 0.21\)"):
        rotation(given, "axes")


def test_a_joint_along_other_axes_has_their_batch() -> None:
    """As a joint that was made with these axes; and what does not broadcast is refused as there."""
    pin = Joint(stiffness=np.ones((4, 1, 6)))
    axes = _rotations(3)
    placed, made = pin.along(axes), Joint(pin.stiffness, axes)
    assert placed.shape == made.shape == (4, 3)
    assert np.array_equal(placed.matrix(), made.matrix())
    with pytest.raises(FrameError, match=r"stiffness \(4, 1\), axes \(2, 3\)"):
        pin.along(np.broadcast_to(axes, (2, 3, 3, 3)))
