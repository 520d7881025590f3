"""Derivatives of positions by dimensions, drives and displacements in joints: closed forms, differences, frames."""

from __future__ import annotations

from collections.abc import Callable

import mpmath as mp
import numpy as np
import pytest
from linkframe.framework import FrameError
from linkframe.models import Linkage, Motion
from numpy.testing import assert_allclose

from ..reference.any_linkage import KINDS, Recipe


def coupler_point(crank, coupler, rocker, ground, theta, x, y, sqrt=np.sqrt, cos=np.cos, sin=np.sin):  # type: ignore[no-untyped-def]
    """P of a four-bar and cosine and sine of the coupler's angle, in closed form; analytic in all arguments."""
    bx, by = crank * cos(theta), crank * sin(theta)
    px, py = ground - bx, -by
    chord2 = px * px + py * py
    along = (coupler**2 - rocker**2 + chord2) / (2 * chord2)
    across = sqrt(coupler**2 / chord2 - along**2)
    c, s = (along * px - across * py) / coupler, (along * py + across * px) / coupler
    return bx + c * x - s * y, by + s * x + c * y, c, s


def four_bar(crank, coupler, rocker, ground, theta, x, y) -> Linkage:  # type: ignore[no-untyped-def]
    px, py, c, s = coupler_point(crank, coupler, rocker, ground, theta, x, y)
    b = crank * np.cos(theta), crank * np.sin(theta)

    def at(*xy: object) -> np.ndarray:
        return np.stack(np.broadcast_arrays(*xy), axis=-1)

    linkage = Linkage(A=(0, 0), B=at(*b), D=at(b[0] + coupler * c, b[1] + coupler * s), E=at(ground, 0.0), P=at(px, py))
    linkage.link("crank", "A", "B")
    linkage.link("coupler", "B", "P", "D")
    linkage.link("rocker", "D", "E")
    linkage.revolute("A", "ground", "crank", drive=True, reference=theta)
    linkage.revolute("B", "crank", "coupler")
    linkage.revolute("D", "coupler", "rocker")
    linkage.revolute("E", "rocker", "ground")
    return linkage


def derivatives(motion: Motion) -> np.ndarray:
    """By crank, coupler, rocker, ground and drive: ux uy rz, (5, ..., 3)."""
    by = motion.sensitivity("P")
    pairs = (("crank", "A", "B"), ("coupler", "B", "D"), ("rocker", "E", "D"), ("ground", "A", "E"))
    found = [by.length(*pair) for pair in pairs] + [by.drives["A"][..., 0]]
    return np.stack(found)[..., [0, 1, 5]]


def test_ten_thousand_four_bars_against_the_complex_step() -> None:
    """Each length changes on its own link alone, and the coupler keeps x and y of its point."""
    rng, n = np.random.default_rng(0), 10_000
    lengths = rng.uniform([0.5, 2.0, 2.0, 2.5], [1.0, 3.0, 3.0, 3.0], (n, 4))
    theta, x, y = rng.uniform(0.0, 6.0, n), rng.uniform(0.0, 2.0, n), rng.uniform(-1.0, 1.0, n)
    arguments = [*lengths.T, theta]
    drawn = theta + rng.uniform(-0.2, 0.2, n)
    motion = four_bar(*lengths.T, drawn, x, y).move(A=theta)
    assert motion.is_assembled.all()
    found = derivatives(motion)
    for k in range(5):
        stepped = [value + (1e-100j if j == k else 0.0) for j, value in enumerate(arguments)]
        px, py, c, s = coupler_point(*stepped, x, y)
        turn = s.imag * c.real - c.imag * s.real
        expected = 1e100 * np.stack([px.imag, py.imag, turn], axis=-1)
        # The nearer a dead point, the fewer digits a position has, and its derivatives.
        scale = np.abs(expected).max(axis=-1) / motion.conditioning
        assert (np.abs(found[k] - expected).max(axis=-1) < 1e-12 * (1.0 + scale)).all()


def test_fifty_digits() -> None:
    rng = np.random.default_rng(1)
    with mp.workdps(50):
        for _ in range(5):
            lengths = [float(v) for v in rng.uniform([0.5, 2.0, 2.0, 2.5], [1.0, 3.0, 3.0, 3.0])]
            arguments = [*lengths, float(rng.uniform(0.0, 6.0))]
            found = derivatives(four_bar(*arguments, 0.7, 0.4).move())

            def at(k: int, value: object, arguments: list[float] = arguments) -> list[object]:
                given = [mp.mpf(v) for v in arguments]
                given[k] = value
                return list(coupler_point(*given, mp.mpf(0.7), mp.mpf(0.4), mp.sqrt, mp.cos, mp.sin))

            for k in range(5):
                x, y = (mp.diff(lambda v, k=k, j=j: at(k, v)[j], arguments[k]) for j in (0, 1))
                assert_allclose(found[k][:2], [float(x), float(y)], rtol=0.0, atol=1e-13)


def moved(recipe: Recipe, change: Callable[[Linkage], Linkage] = lambda linkage: linkage) -> Motion:
    linkage = change(recipe.made())
    values = {}
    for name, reach in recipe.reach.items():
        pair = linkage.joint(name)
        chosen = [pair.kind.coordinates.index(own) for own in linkage.drives[name]]
        values[name] = np.squeeze(pair.reference[..., chosen]) + 0.2 * reach
    return linkage.move(values)


def difference(two: list[Motion], here: Motion, link: str, step: float) -> np.ndarray:
    """Displacement and rotation of P by a step, (6,)."""
    place = (two[0].position("P", link) - two[1].position("P", link)) / (2.0 * step)
    turn = (two[0].axes(link) - two[1].axes(link)) / (2.0 * step) @ here.axes(link).T
    return np.array([*place, turn[2, 1], turn[0, 2], turn[1, 0]])


@pytest.mark.parametrize("kind", ["six_bar", "two_drives", "rssr", "rusp"])
def test_points_of_many_kinds_against_differences(kind: str) -> None:
    """What is not determined, the rotation of a rod that is free to spin, is NaN."""
    recipe, step = KINDS[kind](np.random.default_rng(2)), 1e-5
    here = moved(recipe)
    by = here.sensitivity("P")
    rows = slice(0, 3) if kind == "rssr" else slice(0, 6)
    assert np.isnan(by.points["P"][3:]).any() == (kind == "rssr")
    for name in list(recipe.points)[:4]:
        for k in range(3):
            base, two = recipe.points[name].copy(), []
            for sign in (1.0, -1.0):
                recipe.points[name] = base + sign * step * np.eye(3)[k]
                two.append(moved(recipe))
            recipe.points[name] = base
            expected = difference(two, here, by.link, step)
            assert_allclose(by.points[name][rows, k], expected[rows], rtol=0.0, atol=3e-8)


@pytest.mark.parametrize(("kind", "name"), [("two_drives", "S"), ("rusp", "A"), ("rusp", "S")])
def test_axes_against_differences(kind: str, name: str) -> None:
    """The axis of a joint in the drawing is that of both of its links."""
    recipe, step = KINDS[kind](np.random.default_rng(3)), 1e-5
    here = moved(recipe)
    pair, by = here.linkage.joint(name), here.sensitivity("P")
    found = by.axes[pair.first, name] + by.axes[pair.second, name]
    *rest, more = recipe.joints[name]
    z = pair.axes[:, 2]
    for across in pair.axes[:, :2].T:
        if kind == "two_drives" and abs(across[2]) < 0.5:
            continue
        two = []
        for sign in (1.0, -1.0):
            leaning = z * np.cos(step) + sign * np.sin(step) * np.cross(across, z)
            recipe.joints[name] = (*rest, {**more, "axis": leaning})
            two.append(moved(recipe))
        recipe.joints[name] = (*rest, more)
        assert_allclose(found @ across, difference(two, here, by.link, step), rtol=0.0, atol=3e-8)


def test_a_link_with_its_true_length() -> None:
    """Its points tell where it starts and in which direction it was drawn, and its length how long it is."""

    def linkage(length: float, b: float = 1.0) -> Linkage:
        out = Linkage(A=(0, 0), B=(0, b), C=(3, 1.5))
        out.link("crank", "A", "B")
        out.link("rod", "B", "C", length=length)
        out.link("slider", "C")
        out.revolute("A", "ground", "crank", drive=True)
        out.revolute("B", "crank", "rod")
        out.revolute("C", "rod", "slider")
        out.prismatic("C", "ground", "slider", axis=(1, 0), name="slide")
        return out

    by = linkage(3.1).move(A=0.3).sensitivity("C", "slider")
    up, down = (linkage(3.1 + h).move(A=0.3).position("C", "slider") for h in (1e-6, -1e-6))
    assert_allclose(by.lengths["rod"][:3], (up - down) / 2e-6, rtol=0.0, atol=1e-8)
    up, down = (linkage(3.1, 1.0 + h).move(A=0.3).position("C", "slider") for h in (1e-6, -1e-6))
    assert_allclose(by.points["B"][:3, 1], (up - down) / 2e-6, rtol=0.0, atol=1e-8)


def test_the_pitch_of_a_screw() -> None:
    def linkage(pitch: float) -> Linkage:
        out = Linkage(A=(0, 0))
        out.link("nut", "A")
        out.screw("A", "ground", "nut", axis=(0, 0, 1), pitch=pitch, drive=True)
        return out

    by = linkage(2e-3).move(A=5.0).sensitivity("A", "nut")
    assert_allclose(by.pitches["A"], [0, 0, 5.0 / (2.0 * np.pi), 0, 0, 0], rtol=1e-15)
    assert_allclose(by.drives["A"][:, 0], [0, 0, 2e-3 / (2.0 * np.pi), 0, 0, 1.0], rtol=1e-15)


def test_joints_are_the_offsets_of_the_frame() -> None:
    """The frame's own adjoint, of beams and springs, gives the same where equilibrium alone tells the forces."""
    linkage = KINDS["rusp"](np.random.default_rng(4)).made()
    motion = linkage.move()
    by, solution = motion.sensitivity("P"), motion.frame().solve()
    for k, what in enumerate(("ux", "uy", "uz")):
        offsets = solution.sensitivity("P", what).offsets
        for name in linkage.joints:
            assert_allclose(by.joints[name][k], offsets[name], rtol=0.0, atol=1e-9)


def test_dead_points_and_poses_that_are_not_there() -> None:
    linkage = four_bar(1.0, 3.0, 3.0, 5.5, 0.3, 1.0, 0.5)
    motion = linkage.move(A=[0.3, np.arccos((1.0 + 5.5**2 - 36.0) / 11.0), 3.0])
    found = motion.sensitivity("P").drives["A"]
    assert np.isfinite(found[0]).all()
    assert np.isnan(found[1:]).all()


def test_what_is_no_point_of_a_link() -> None:
    by = four_bar(1.0, 3.0, 3.0, 3.0, 0.3, 1.0, 0.5).move().sensitivity("P")
    with pytest.raises(FrameError, match="link 'crank' has no point 'D' here: choose of A, B"):
        by.length("crank", "A", "D")
    assert "P on coupler" in repr(by)
