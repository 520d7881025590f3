"""Displacement between the held ends of steep tapers, from either end: by the force method with 40 digits."""

from __future__ import annotations

import mpmath as mp
import numpy as np
import pytest
from linkframe.elements import Beam, Circle, Material
from linkframe.framework import Frame
from numpy.typing import NDArray

THICK, E, LOAD = 0.1, 200e9, -1000.0  # a bar of 1 m, N/m
AT = np.array([0.05, 0.5, 0.95])


def held(first: float, last: float, start: float, end: float, **options: object) -> NDArray[np.float64]:
    """Deflection and slope at stations of a conical bar, clamped at both ends under a load over part of it."""
    frame = Frame()
    frame.node("A", (0.0, 0.0, 0.0))
    frame.node("B", (1.0, 0.0, 0.0))
    bar = Beam(Circle(diameter=first), Material(E=E, nu=0.3), end=Circle(diameter=last), **options)  # type: ignore[arg-type]
    frame.add("bar", bar, "A", "B")
    frame.fix("A")
    frame.fix("B")
    frame.line_load("bar", fy=LOAD, span=(start, end))
    return frame.solve().displacement_along("bar", AT)[:, [1, 5]]


def exact(thin: float, start: float, end: float) -> NDArray[np.float64]:
    """The same where the start is thin: ``v'' = M / E I``, and the end does not move under force and moment there."""
    with mp.workdps(40):
        first, slope = mp.mpf(thin), mp.mpf(THICK) - mp.mpf(thin)

        def ahead(s: mp.mpf) -> mp.mpf:
            """Moment at s of the load on what is ahead."""
            lower = max(s, mp.mpf(start))
            return LOAD * (end - lower) * ((end + lower) / 2 - s) if s < end else mp.mpf(0)

        def whole(moment: mp.mpf, to: mp.mpf) -> mp.mpf:
            """Integral of a moment over E I from the start to a station, over the logarithm of the diameter."""

            def density(y: mp.mpf) -> mp.mpf:
                d = mp.exp(y)
                return moment((d - first) / slope) * 64 / (mp.pi * E * d**4) * d / slope

            marks = sorted({mp.mpf(0), to} | {mp.mpf(m) for m in (start, end) if m < to})
            return mp.quad(density, [mp.log(first + slope * m) for m in marks], method="gauss-legendre")

        one, powers = mp.mpf(1), [whole(lambda s, k=k: (1 - s) ** k, mp.mpf(1)) for k in range(3)]
        loads = [whole(lambda s, k=k: ahead(s) * (1 - s) ** k, one) for k in range(2)]
        force, moment = mp.lu_solve(mp.matrix([[powers[1], powers[0]], [powers[2], powers[1]]]), -mp.matrix(loads))

        def carried(s: mp.mpf) -> mp.mpf:
            return force * (1 - s) + moment + ahead(s)

        places = [mp.mpf(float(x)) for x in AT]
        return np.array(
            [[float(whole(lambda s, x=x: carried(s) * (x - s), x)), float(whole(carried, x))] for x in places]
        )


@pytest.mark.parametrize(("start", "end"), [(0.0, 1.0), (0.3, 0.7)])
@pytest.mark.parametrize(("thin", "digits"), [(1e-4, 1e-9), (1e-6, 1e-7)])
def test_a_steep_taper_deflects_alike_from_either_end(start: float, end: float, thin: float, digits: float) -> None:
    """What the thin end has of rounding does not swing the bar."""
    wanted = exact(thin, start, end)
    largest = np.abs(wanted).max(axis=0)
    assert (np.abs(held(thin, THICK, start, end) - wanted) < digits * largest).all()
    turned = held(THICK, thin, 1.0 - end, 1.0 - start)[::-1] * (1.0, -1.0)
    assert (np.abs(turned - wanted) < digits * largest).all()


@pytest.mark.parametrize("component", ["uy", "rz"])
@pytest.mark.parametrize("side", ["start", "end"])
def test_releases_follow_the_bar_from_either_end(side: str, component: str) -> None:
    other = {"start": "end", "end": "start"}[side]
    found = held(0.5 * THICK, THICK, 0.2, 0.5, release=(f"{side} {component}",))
    turned = held(THICK, 0.5 * THICK, 0.5, 0.8, release=(f"{other} {component}",))[::-1] * (1.0, -1.0)
    np.testing.assert_allclose(found, turned, rtol=1e-10, atol=1e-18)
