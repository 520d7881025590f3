"""Bending of a member in one plane, by the force method at its elastic centre.

The elastic centre lies at the distance `centre` from the start. A moment there only rotates the ends relative to each
other, and a shear force there only displaces them, so that the stiffness is the sum of two terms of rank one ::

    K = shear * b b^T + bend * a a^T,     b = (1, c, -1, L - c),  a = (0, -1, 0, 1)

on (v1, r1, v2, r2), with c the `centre`, ``1 / bend = f0`` and ``1 / shear = f2``,

    f0 = int 1 / EI dx,   f2 = int (x - c)^2 / EI + 1 / (k G A) dx,   c = int x / EI dx / f0.

A prismatic member has c = L / 2, bend = EI / L, shear = 12 EI / (L^3 (1 + phi)). Both flexibilities
are sums of positive terms, so no digits cancel. With a hinge at one end, the hinge is the centre. (The elastic centre
is that of the theory of arches, Timoshenko & Young, *Theory of Structures*; phi as in Przemieniecki, *Theory of Matrix
Structural Analysis*, ch. 5.)
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from ..framework.protocol import Array
from .parameters import Real

START_MOVED, START_TURNED, END_MOVED, END_TURNED = range(4)

Row = tuple[Real, Real, Real, Real]
# Factors `shear` and `bend` of a `Plane`.
PlaneSprings = tuple[Real, Real]


class Curve(NamedTuple):
    """Rotation and deflection at x of a member clamped at its start, per unit moment and per unit slope of the moment.

    The bending moment is ``moment + slope (x - centre)``, and the shear force is -slope. Each value is (...).
    """

    rotation_by_moment: Real
    rotation_by_slope: Real
    deflection_by_moment: Real
    deflection_by_slope: Real


class Plane(NamedTuple):
    """Bending stiffness of a member in one plane, each value (...).

    Attributes
    ----------
    fraction
        Distance of the elastic centre from the start over the length.
    centre, rest
        Distances of the elastic centre from the start and from the end.
    shear, bend
        Factors of the two terms of the stiffness, force per length and moment per radian.
    """

    fraction: Real
    centre: Real
    rest: Real
    shear: Real
    bend: Real

    @property
    def springs(self) -> PlaneSprings:
        """Factors of the two terms, `shear` and `bend`."""
        return self.shear, self.bend


def bending_plane(fractions: tuple[Real, Real], length: Real, whole: Sequence[Real], released: frozenset[int]) -> Plane:
    """Stiffness of a member in one plane of bending.

    Parameters
    ----------
    fractions
        Distances of the elastic centre from the start and from the end over the length, (...) each.
    length
        Length, (...).
    whole
        Rotation by a unit moment and deflection by a unit slope of the moment at the end, about the elastic centre, as
        in a `Curve`, (...) each.
    released
        Indices into (v1, r1, v2, r2) of end components that carry no force; a hinge takes the place of the centre.
    """
    fraction, centre, rest = fractions[0], fractions[0] * length, fractions[1] * length
    if not released:
        return Plane(fraction, centre, rest, 1.0 / -whole[1], 1.0 / whole[0])
    turning, moving = whole[0], -whole[1]
    none = 0.0 * turning
    if len(released) == 2:
        return Plane(0.0, none, none, none, none)
    if START_TURNED in released:
        return Plane(0.0, none, length + none, 1.0 / (moving + centre * centre * turning), none)
    if END_TURNED in released:
        return Plane(1.0, length + none, none, 1.0 / (moving + rest * rest * turning), none)
    return Plane(fraction, centre, rest, none, 1.0 / turning)


def stamp_stiffness(matrix: Array, plane: Plane, dofs: tuple[int, int, int, int], sign: float) -> None:
    """Write the stiffness of `plane` into `matrix` at `dofs`; `sign` is the sign of rotations in the plane."""
    v1, r1, v2, r2 = dofs
    shear, turn = plane.shear, plane.shear * plane.centre
    start, end = sign * turn, sign * plane.shear * plane.rest
    matrix[..., v1, v1] = matrix[..., v2, v2] = shear
    matrix[..., v1, v2] = matrix[..., v2, v1] = -shear
    matrix[..., v1, r1] = matrix[..., r1, v1] = start
    matrix[..., v2, r1] = matrix[..., r1, v2] = -start
    matrix[..., v1, r2] = matrix[..., r2, v1] = end
    matrix[..., v2, r2] = matrix[..., r2, v2] = -end
    matrix[..., r1, r1] = turn * plane.centre + plane.bend
    matrix[..., r1, r2] = matrix[..., r2, r1] = turn * plane.rest - plane.bend
    matrix[..., r2, r2] = plane.shear * plane.rest * plane.rest + plane.bend


def plane_forces(plane: Plane, v1: Array, r1: Array, v2: Array, r2: Array) -> tuple[Array, Array, Array, Array]:
    """End forces on (v1, r1, v2, r2), (...) each, computed from the deformations."""
    slope = plane.shear * ((v1 - v2) + (plane.centre * r1 + plane.rest * r2))
    moment = plane.bend * (r2 - r1)
    return slope, plane.centre * slope - moment, -slope, plane.rest * slope + moment


def start_rows(plane: Plane, length: Real, whole: Curve, released: frozenset[int]) -> tuple[Row, Row]:
    """Displacement and rotation of the member's own start per unit of (v1, r1, v2, r2) of the nodes.

    They are those of the first node, unless they are released: then they follow from the other constraints of the
    member. `whole` is the curve at the end of the member, about the centre of `plane`.
    """
    shear_ratio = plane.shear * whole.deflection_by_slope
    if START_TURNED not in released:
        turn: Row = (0.0, 1.0, 0.0, 0.0)
    elif START_MOVED in released or END_MOVED in released:
        turn = (0.0, 0.0, 0.0, 1.0)
    else:
        turn = (-(1.0 + shear_ratio) / length, 0.0, (1.0 + shear_ratio) / length, -shear_ratio * plane.rest / length)
    if START_MOVED not in released:
        return (1.0, 0.0, 0.0, 0.0), turn
    bending_ratio = plane.bend * whole.deflection_by_moment
    return (0.0, bending_ratio - length * turn[1], 1.0, -bending_ratio - length * turn[3]), turn


def plane_rows(plane: Plane, start: tuple[Row, Row], x: Real, curve: Curve) -> tuple[Row, Row]:
    """Deflection and rotation at x per unit of (v1, r1, v2, r2), with the `curve` at x about the plane's centre."""
    deflection, rotation = start
    by_shear = (1.0, plane.centre, -1.0, plane.rest)
    by_bend = (0.0, -1.0, 0.0, 1.0)

    def row(base: list[Real], slope: Real, moment: Real) -> Row:
        s, m = plane.shear * slope, plane.bend * moment
        v1, r1, v2, r2 = (b + s * p + m * q for b, p, q in zip(base, by_shear, by_bend, strict=True))
        return v1, r1, v2, r2

    rigid = [m + x * t for m, t in zip(deflection, rotation, strict=True)]
    return (
        row(rigid, curve.deflection_by_slope, curve.deflection_by_moment),
        row(list(rotation), curve.rotation_by_slope, curve.rotation_by_moment),
    )


def strain_rows(plane: Plane, x: Real, bending: Real, shearing: Real) -> tuple[Row, Row]:
    """Shear strain and curvature at x per unit of (v1, r1, v2, r2), with the section's flexibilities there."""
    s, m = plane.shear, plane.bend
    arm = s * (x - plane.centre)
    strain = -shearing * s
    c, d = plane.centre, plane.rest
    return (
        (strain, strain * c, -strain, strain * d),
        (bending * arm, bending * (arm * c - m), -bending * arm, bending * (arm * d + m)),
    )
