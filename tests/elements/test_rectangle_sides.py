"""Von Mises stress between corners and mid-sides of rectangles, against a dense evaluation of its own."""

from __future__ import annotations

from functools import cache

import mpmath as mp
import numpy as np
import pytest
from linkframe.elements import Rectangle
from linkframe.elements.rectangle_sides import long_side, short_side
from numpy.testing import assert_allclose, assert_array_equal

Array = np.ndarray
ROOT3 = np.sqrt(3.0)


def torsion(ratio: float, s: Array) -> Array:
    """Torsional stress along a side `ratio` times as long as the other over that at mid-side, term by term."""
    if ratio >= 1.0:
        n = np.arange(1.0, 8001.0, 2.0)

        def sums(at: Array) -> Array:
            x = 0.5 * np.pi * ratio * np.maximum(1.0 - at, 1e-300)[:, None]
            far = 0.5 * np.pi * ratio * (1.0 + at)[:, None]
            fall = (np.exp(-n * x) + np.exp(-n * far)) / (1.0 + np.exp(-np.pi * ratio * n))
            return np.asarray(1.0 - 8.0 / np.pi**2 * (fall / n**2).sum(axis=1))

        return np.asarray(sums(s) / sums(np.zeros(1)))
    n = np.arange(1.0, 8001.0, 2.0)
    weights = np.where(n % 4 == 1, 1.0, -1.0) * np.tanh(0.5 * np.pi * n / ratio) / n**2
    return np.asarray((np.cos(0.5 * np.pi * np.outer(s, n)) @ weights) / weights.sum())


@cache
def dense(ratio: float) -> tuple[Array, Array]:
    """Places s from 0 to 1, even and close to the end, and the torsional stress there."""
    s = np.unique(np.concatenate([np.linspace(0.0, 1.0, 161), 1.0 - np.geomspace(1e-4, 1.0, 200)]))
    return s, np.concatenate([torsion(ratio, part) for part in np.array_split(s, 12)])


def greatest(section: Rectangle, forces: Array) -> Array:
    """Von Mises stress at all places of the four sides and in the centre, one by one, (k,)."""
    y, z = float(section.y), float(section.z)
    area, moduli = y * z, section.torsion_moduli
    N, Vy, Vz, T, My, Mz = (force[:, None] for force in forces.T)
    by_y, by_z = 6.0 * Mz / (z * y * y), 6.0 * My / (y * z * z)
    out = np.hypot(N / area, ROOT3 * 1.5 * np.hypot(Vy, Vz) / area).max(axis=1)
    for sign in (-1.0, 1.0):
        for end in (-1.0, 1.0):
            for ratio, along, across, shear, twist in (
                (z / y, by_z, -sign * by_y, Vz, sign * T / moduli[0]),
                (y / z, -by_y, sign * by_z, Vy, -sign * T / moduli[1]),
            ):
                s, g = dense(ratio)
                normal = N / area + across + end * s * along
                stress = np.hypot(normal, ROOT3 * (1.5 * shear / area * (1.0 - s * s) + twist * g))
                out = np.maximum(out, stress.max(axis=1))
    return np.asarray(out)


def mixtures(section: Rectangle, count: int) -> Array:
    """Forces whose stresses are of like sizes, any of them missing at times."""
    rng = np.random.default_rng(7)
    y, z = float(section.y), float(section.z)
    unit = np.array([y * z, y * z, y * z, float(min(section.torsion_moduli)), y * z * z / 6.0, z * y * y / 6.0])
    sizes = rng.normal(size=(count, 6)) * 10.0 ** rng.uniform(-1.5, 0.5, (count, 6))
    return np.asarray(np.where(rng.random((count, 6)) < 0.3, 0.0, sizes) * unit)


@pytest.mark.parametrize("ratio", [1.0, 2.0, 4.0, 20.0, 70.0, 1000.0])
@pytest.mark.parametrize("turned", [False, True])
def test_greatest_along_the_sides(ratio: float, turned: bool) -> None:
    """By 0.1 % exact, and from below."""
    section = Rectangle(y=ratio, z=1.0) if turned else Rectangle(y=1.0, z=ratio)
    forces = mixtures(section, 300)
    found, true = section.stress(forces)[:, 2], greatest(section, forces)
    # the dense evaluation itself is too low, between its places, by less than 1e-4
    assert np.all(found <= true * (1.0 + 1e-4))
    assert np.all(found >= true * (1.0 - 1e-3))


@pytest.mark.parametrize("ratio", [1.0, 1.3, 4.0, 60.0, 1e6])
def test_torsional_stress_in_twenty_digits(ratio: float) -> None:
    """Art. 109's two sums, the slow ones accelerated."""
    long, short = long_side(np.asarray(ratio)), short_side(np.asarray(ratio))
    with mp.workdps(20):
        u = mp.pi * mp.mpf(ratio) / 2

        def chi(x: mp.mpf) -> mp.mpf:
            return (mp.polylog(2, mp.exp(-x)) - mp.polylog(2, -mp.exp(-x))) / 2

        def along(s: mp.mpf) -> mp.mpf:
            images = ((-1) ** k * (chi(u * (2 * k + 1 - s)) + chi(u * (2 * k + 1 + s))) for k in range(16))
            return 1 - 8 / mp.pi**2 * mp.fsum(images)

        def across(s: mp.mpf) -> mp.mpf:
            endless = (
                mp.im(mp.polylog(2, mp.expj(mp.pi * (1 - s) / 2)) - mp.polylog(2, -mp.expj(mp.pi * (1 - s) / 2))) / 2
            )
            rest = (mp.sin(n * mp.pi * (1 - s) / 2) * (mp.tanh(n * u) - 1) / n**2 for n in range(1, 30, 2))
            return endless + mp.fsum(rest)

        some = slice(0, None, 9)
        for side, series in ((long, along), (short, across)):
            true = [float(series(mp.mpf(s)) / series(mp.mpf(0))) for s in side.place[some]]
            assert_allclose(side.torsion[some], true, rtol=1e-11)
    # what decides that a side need not be looked at
    for side, length in ((long, ratio), (short, 1.0 / ratio)):
        assert np.all(side.torsion**2 <= (1.42 + 0.78 * length) * (1.0 - side.place))


def test_nothing_is_taken_away_and_neighbours_do_not_matter() -> None:
    """Alone, among others, in a batch of sections and far from 1: the same stress."""
    sections = Rectangle(y=np.array([1.0, 4.0, 1.0]), z=np.array([1.0, 1.0, 30.0]))
    forces = mixtures(Rectangle(y=1.0, z=4.0), 60).reshape(20, 3, 6)
    together = sections.stress(forces)
    for at, (y, z) in enumerate([(1.0, 1.0), (4.0, 1.0), (1.0, 30.0)]):
        one = Rectangle(y=y, z=z)
        assert_array_equal(one.stress(forces[:, at]), together[:, at])
        assert_array_equal(np.stack([one.stress(force) for force in forces[:, at]]), together[:, at])
    assert_allclose(sections.stress(1e200 * forces), 1e200 * together, rtol=1e-13)
    assert_allclose(sections.stress(1e-200 * forces), 1e-200 * together, rtol=1e-13)
