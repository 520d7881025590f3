"""Axes, lengths and places of large batches, which are examined component by component, against those of one entry."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from linkframe.elements import Beam, Circle, Material
from linkframe.framework import Frame, FrameError
from linkframe.framework.batch import norms, placed, rotation
from numpy.testing import assert_allclose, assert_array_equal
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]

MANY = 20_000


def about_z(count: int) -> Array:
    """Axes turned in the plane, (count, 3, 3)."""
    return Rotation.from_rotvec(np.multiply.outer(np.linspace(0.0, 6.0, count), [0.0, 0.0, 1.0])).as_matrix()


def in_space(count: int) -> Array:
    """Axes turned in space, (count, 3, 3)."""
    return Rotation.random(count, rng=np.random.default_rng(0)).as_matrix()


@pytest.mark.parametrize("axes", [about_z, in_space])
def test_axes_of_many_entries_are_accepted(axes: Callable[[int], Array]) -> None:
    assert_array_equal(rotation(axes(MANY), "axes"), axes(MANY))
    assert rotation(axes(MANY).reshape(100, -1, 3, 3), "axes").shape == (100, MANY // 100, 3, 3)


@pytest.mark.parametrize("count", [3, MANY])
@pytest.mark.parametrize("axes", [about_z, in_space])
@pytest.mark.parametrize(("row", "column"), [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0)])
def test_one_entry_that_is_not_orthonormal_is_found(
    count: int, axes: Callable[[int], Array], row: int, column: int
) -> None:
    given = axes(count)
    given[-1, row, column] += 1e-8
    with pytest.raises(FrameError, match=r"axes are not orthonormal \(off by .*e-0[89]\): give three unit vectors"):
        rotation(given, "axes")


@pytest.mark.parametrize("count", [3, MANY])
@pytest.mark.parametrize("axes", [about_z, in_space])
@pytest.mark.parametrize("column", range(3))
def test_one_entry_that_is_left_handed_is_found(count: int, axes: Callable[[int], Array], column: int) -> None:
    given = axes(count)
    given[-1, :, column] *= -1.0
    with pytest.raises(FrameError, match="axes are left-handed: turn one of the columns round"):
        rotation(given, "axes")


@pytest.mark.parametrize("used", [(), (0,), (2,), (0, 1), (0, 1, 2)])
def test_lengths_and_places_leave_out_what_is_zero(used: tuple[int, ...]) -> None:
    rng = np.random.default_rng(1)
    local, origin, axes = np.zeros((MANY, 3)), rng.normal(size=(MANY, 3)), in_space(MANY)
    local[:, used] = rng.normal(size=(MANY, len(used)))
    assert_array_equal(norms(local), np.linalg.norm(local, axis=-1))
    expected = origin + (axes @ local[..., None])[..., 0]
    np.testing.assert_allclose(placed(origin, axes, local), expected, rtol=0.0, atol=1e-14)
    assert placed(origin[:1], axes[:1], local).shape == (MANY, 3)


def test_lengths_of_one_vector() -> None:
    assert norms(np.array([3.0, 0.0, 4.0])) == 5.0
    assert norms(np.zeros(3)) == 0.0


def test_members_that_leave_the_x_axis_late_in_the_batch() -> None:
    """A cantilever along x for all but the last of many entries, in which it stands upright: u = F L^3 / 3 E I."""
    rod = Beam(Circle(diameter=0.02), Material(E=200e9 * np.linspace(1.0, 2.0, 2 * MANY), nu=0.3))
    ends = np.zeros((2 * MANY, 3))
    ends[:, 0] = np.linspace(0.5, 1.0, 2 * MANY)
    ends[-1] = (0.0, 1.0, 0.0)
    frame = Frame()
    frame.node("A", (0.0, 0.0, 0.0))
    frame.node("B", ends)
    frame.add("AB", rod, "A", "B")
    frame.fix("A")
    frame.load("B", fx=10.0, fy=10.0)
    found = frame.solve().displacement("B")
    bent = 10.0 * ends[:, 0] ** 3 / (3.0 * 200e9 * np.linspace(1.0, 2.0, 2 * MANY) * np.pi * 0.02**4 / 64.0)
    np.testing.assert_allclose(found[:-1, 1], bent[:-1], rtol=1e-12)
    np.testing.assert_allclose(found[-1, 0], 10.0 / (3.0 * 400e9 * np.pi * 0.02**4 / 64.0), rtol=1e-12)


@pytest.mark.parametrize("away", [0, MANY, 2 * MANY - 1])
def test_a_member_that_leaves_its_plane_at_one_entry(away: int) -> None:
    """Axes in a plane of constant z are computed otherwise, which a part of a batch must not tell of the whole."""
    rng = np.random.default_rng(1)
    places = rng.uniform(0.5, 1.0, (2 * MANY, 3)) * (1.0, 1.0, 0.0)
    places[away, 2] = 0.3
    modulus, forces = rng.uniform(1e11, 2e11, 2 * MANY), rng.normal(size=(3, 2 * MANY))

    def tip(entries: list[int] | slice) -> Array:
        frame = Frame()
        frame.node("A", (0.0, 0.0, 0.0))
        frame.node("B", places[entries])
        frame.add("AB", Beam(Circle(diameter=0.02), Material(E=modulus[entries], nu=0.3)), "A", "B")
        frame.fix("A")
        frame.load("B", **dict(zip(("fx", "fy", "fz"), forces[:, entries], strict=True)))
        return frame.solve("broadcast").displacement("B")

    whole = tip(slice(None))
    for k in (0, 1, away, 2 * MANY - 1):
        assert_allclose(whole[k], tip([k, k])[0], rtol=1e-10, atol=1e-18)
