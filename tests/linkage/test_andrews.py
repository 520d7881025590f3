"""Andrews' squeezer: seven bodies, three loops (Schiehlen 1990; Hairer and Wanner, Solving ODEs II, VII.7).

Test Set for IVP Solvers, its six closing equations, and the published coordinates at both times.
"""

from __future__ import annotations

import numpy as np
from linkframe.models import Linkage
from numpy.testing import assert_allclose

D, E, RR, SS = 0.028, 0.02, 0.007, 0.035
U, ZF, ZT = 0.04, 0.02, 0.04
A, B, C = np.array([-0.06934, -0.00227]), np.array([-0.03635, 0.03273]), np.array([0.014, 0.072])
# β, Θ, γ, Φ, δ, Ω, ε
START = np.array(
    [
        -0.06171389001427645,
        0.0,
        0.45527981916307037,
        0.22266839016588588,
        0.48736497954384256,
        -0.22266839016588588,
        1.2305474445498212,
    ]
)
LATER = np.array(
    [
        15.81077119629904,
        -15.75637105984298,
        0.04082224013073101,
        -0.5347301163226948,
        0.5244099658805303,
        0.5347301163226948,
        1.048080741042263,
    ]
)
LATER_RATES = np.array(
    [
        1139.920302151208,
        -1424.379294994111,
        11.03291221937134,
        19.29337464421385,
        0.5735699284790808,
        -19.29337464421385,
        0.3231791658026955,
    ]
)
LATER_ACCELERATION = np.array(
    [
        -24631.76316945196,
        51850.37701610329,
        324102.5686413781,
        566749.3645176213,
        16743.62929479361,
        -566749.3645176222,
        9826.520791458423,
    ]
)


COORDINATES = ("O", "K", "B", "G", "A", "H", "A.7")


def squeezer(q) -> Linkage:
    """The mechanism drawn at the coordinates q: M is the pin of links 2, 3, 4 and 6."""
    beta, theta, gamma, phi, delta, omega, epsilon = q
    crank = RR * direction(beta)
    linkage = Linkage(O=(0, 0), K=crank, M=crank - D * direction(beta + theta), A=A, B=B)
    linkage.point("G", A + ZT * direction(delta))
    linkage.point("H", A + U * direction(epsilon - 0.5 * np.pi))
    for name, ends in zip("1234567", ("OK", "KM", "BM", "GM", "AG", "HM", "AH"), strict=True):
        linkage.link(name, *ends)
    linkage.revolute("O", "ground", "1", drive=True, reference=beta)
    linkage.revolute("K", "1", "2", reference=theta)
    linkage.revolute("M", "2", "3", "4", "6")
    linkage.revolute("B", "ground", "3", reference=gamma)
    linkage.revolute("A", "ground", "5", reference=delta)
    linkage.revolute("A", "ground", "7", reference=epsilon, name="A.7")
    linkage.revolute("G", "5", "4", reference=phi)
    linkage.revolute("H", "7", "6", reference=omega)
    return linkage


def direction(angle):
    return np.array([np.cos(angle), np.sin(angle)])


def together(values):
    return np.concatenate([values(joint) for joint in COORDINATES], axis=-1)


def closing(q):
    """The six published equations."""
    b, t, g, p, d, o, e = q
    x = RR * np.cos(b) - D * np.cos(b + t)
    y = RR * np.sin(b) - D * np.sin(b + t)
    return np.array(
        [
            x - SS * np.sin(g) - B[0],
            y + SS * np.cos(g) - B[1],
            x - E * np.sin(p + d) - ZT * np.cos(d) - A[0],
            y + E * np.cos(p + d) - ZT * np.sin(d) - A[1],
            x - ZF * np.cos(o + e) - U * np.sin(e) - A[0],
            y - ZF * np.sin(o + e) + U * np.cos(e) - A[1],
        ]
    )


def test_turned_from_the_start_it_comes_to_the_published_coordinates():
    motion = squeezer(START).move(O=np.linspace(START[0], LATER[0], 50))
    found = together(motion.coordinate)
    assert_allclose(found[0], START, atol=1e-14)
    assert_allclose(found[-1], LATER, atol=1e-13)
    assert np.abs([closing(q) for q in found]).max() < 1e-15
    assert motion.gap.max() < 1e-13 * 0.1
    assert np.all(motion.closure_status == "regular")


def test_rates_and_accelerations_are_the_published_ones():
    drive = {"O": LATER[0]}
    motion = squeezer(START).move(drive, rates={"O": LATER_RATES[0]}, accelerations={"O": LATER_ACCELERATION[0]})
    assert_allclose(together(motion.coordinate_rate), LATER_RATES, rtol=3e-8)
    assert_allclose(together(motion.coordinate_acceleration), LATER_ACCELERATION, rtol=2e-6)


def test_start_does_not_follow_a_second_order_motion_of_the_crank():
    """At the start six accelerations are published for β'' = 14222: only links 1 and 2 move then."""
    motion = squeezer(START).move(O=START[0], accelerations={"O": 14222.443919954114})
    found = together(motion.coordinate_acceleration)
    assert_allclose(found, [14222.443919954114, -10666.832939965585, 0, 0, 0, 0, 0], atol=1e-8)
