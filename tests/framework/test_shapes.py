"""Surfaces enclose what they should: areas and volumes against closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.framework.batch import Array
from linkframe.framework.pictures.shapes import SIDES, Surface, arrow, block, cone, copies, sphere, tubes, upright

# Area of the regular polygon that stands for a circle of radius 1.
CIRCLE = 0.5 * SIDES * np.sin(2.0 * np.pi / SIDES)


def volume(surface: Surface) -> float:
    """By the divergence theorem; positive where the faces look outwards."""
    a, b, c, d = (surface.points[surface.faces[:, k]] for k in range(4))
    triangles = np.concatenate([np.stack([a, b, c]), np.stack([a, c, d])], axis=1)
    return float(np.einsum("ni,ni->", triangles[0], np.cross(triangles[1], triangles[2])) / 6.0)


def arc(radius: float) -> Array:
    angle = np.linspace(0.0, 1.0, 200)
    return radius * np.stack([np.cos(angle), np.sin(angle), 0.0 * angle], axis=-1)[None]


def test_a_straight_tube_is_a_cylinder_with_two_half_spheres() -> None:
    line = np.linspace((0.0, 0.0, 0.0), (1.0, 2.0, 2.0), 5)[None]
    assert volume(tubes(line, np.zeros((1, 5)), 0.1)) == pytest.approx(
        0.1**2 * CIRCLE * (3.0 + 4.0 / 3.0 * 0.1), rel=3e-3
    )


def test_a_bent_tube_holds_area_times_arc_length() -> None:
    # Pappus: the volume of a bent tube is its section times the length of its axis.
    surface = tubes(arc(2.0), np.zeros((1, 200)), 0.05)
    assert volume(surface) == pytest.approx(0.05**2 * CIRCLE * (2.0 + 4.0 / 3.0 * 0.05), rel=3e-3)


def test_a_tube_lies_at_its_radius_and_looks_outwards() -> None:
    curve = arc(2.0)
    surface = tubes(curve, np.zeros((1, 200)), 0.05)
    np.testing.assert_allclose(np.linalg.norm(surface.normals, axis=-1), 1.0, rtol=1e-12)
    inner = surface.points - 0.05 * surface.normals
    assert np.linalg.norm(inner[:, None] - curve[0], axis=-1).min(axis=1).max() < 1e-12


def test_values_follow_the_stations_of_every_curve() -> None:
    curves = np.stack([np.linspace((0.0, y, 0.0), (3.0, y, 0.0), 4) for y in (0.0, 1.0)])
    values = np.arange(8.0).reshape(2, 4)
    surface = tubes(curves, values, 0.01)
    nearest = np.round(surface.points[:, 0]) + 4.0 * np.round(surface.points[:, 1])
    np.testing.assert_array_equal(surface.values, nearest)


@pytest.mark.parametrize(
    ("template", "expected"),
    [
        (sphere(), 4.0 / 3.0 * CIRCLE),
        (block(), CIRCLE),
        (cone(), 2.0 / 3.0 * CIRCLE),
        (arrow(), CIRCLE * (0.025**2 * 0.72 + 0.07**2 * 0.28 / 3.0)),
    ],
)
def test_templates_enclose_their_volumes(template: Surface, expected: float) -> None:
    assert volume(template) == pytest.approx(expected, rel=1e-2)
    np.testing.assert_allclose(np.linalg.norm(template.normals, axis=-1), 1.0, rtol=1e-12)


def test_copies_are_placed_turned_and_enlarged() -> None:
    directions = np.array([[0.0, 3.0, 0.0], [1.0, 1.0, 1.0], [0.0, 0.0, -2.0]])
    places, sizes = np.array([[0.0, 0.0, 0.0], [9.0, 0.0, 0.0], [0.0, 9.0, 0.0]]), np.array([1.0, 2.0, 0.5])
    axes = upright(directions)
    np.testing.assert_allclose(np.linalg.det(axes), 1.0, rtol=1e-12)
    many = copies(cone(), places, sizes, axes)
    assert volume(many) == pytest.approx(volume(cone()) * (sizes**3).sum(), rel=1e-12)
    size = len(cone().points)
    for k, direction in enumerate(directions / np.linalg.norm(directions, axis=1, keepdims=True)):
        own = many.points[k * size : (k + 1) * size] - places[k]
        assert np.abs(own @ direction).max() == pytest.approx(2.0 * sizes[k], rel=1e-12)
        assert (own @ direction).max() == pytest.approx(0.0, abs=1e-12)
