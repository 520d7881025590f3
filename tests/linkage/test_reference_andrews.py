"""Andrews' squeezer against the published solution: closure, velocities, accelerations, joint forces and torque.

Data: W. Schiehlen (ed.), Multibody Systems Handbook, Springer 1990, p. 10; E. Hairer and G. Wanner, Solving Ordinary
Differential Equations II, Springer 1996, p. 530-542. Solution after 0.03 s: Test Set for IVP Solvers (Bari), problem
Andrews' squeezing mechanism; its accelerations, and forces with them, hold the pin E together to 1.5e-3 m/s², which is
0.06 rad/s² of a link. The multipliers are the forces in the pin E: of the constraints that hold K3, K4 and K6 to K2.
"""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.models import Linkage, Motion
from numpy.testing import assert_allclose
from numpy.typing import NDArray

D, DA, E, EA, FA = 0.028, 0.0115, 0.02, 0.01421, 0.01421
RR, RA, SS, SA, SB, SC, SD = 0.007, 0.00092, 0.035, 0.01874, 0.01043, 0.018, 0.02
TA, TB, U, UA, UB, ZF, ZT = 0.02308, 0.00916, 0.04, 0.01228, 0.00449, 0.02, 0.04
A, B, C = np.array([-0.06934, -0.00227]), np.array([-0.03635, 0.03273]), np.array([0.014, 0.072])
MASS = (0.04325, 0.00365, 0.02373, 0.00706, 0.0705, 0.00706, 0.05498)
INERTIA = (2.194e-6, 4.41e-7, 5.255e-6, 5.667e-7, 1.169e-5, 5.667e-7, 1.912e-5)
SPRING, FREE_LENGTH, TORQUE = 4530.0, 0.07785, 0.033

# Angles β Θ γ Φ δ Ω ε, their rates and accelerations, and the multipliers.
START = {
    "q": (
        *(-0.06171389001427645, 0.0, 0.45527981916307037, 0.22266839016588588),
        *(0.48736497954384256, -0.22266839016588588, 1.2305474445498212),
    ),
    "v": (0.0,) * 7,
    "a": (14222.443919954114, -10666.832939965585, 0.0, 0.0, 0.0, 0.0, 0.0),
    "force": (98.56687039624109, -6.122688344255662, 0.0, 0.0, 0.0, 0.0),
}
LATER = {
    "q": (
        *(15.81077119629904, -15.75637105984298, 0.04082224013073101, -0.5347301163226948),
        *(0.5244099658805303, 0.5347301163226948, 1.048080741042263),
    ),
    "v": (
        *(1139.920302151208, -1424.379294994111, 11.03291221937134, 19.29337464421385),
        *(0.5735699284790808, -19.29337464421385, 0.3231791658026955),
    ),
    "a": (
        *(-24631.76316945196, 51850.37701610329, 324102.5686413781, 566749.3645176213),
        *(16743.62929479361, -566749.3645176222, 9826.520791458423),
    ),
    "force": (
        *(199.175333373191, -29.75531228015052, 23.06654119098399),
        *(31.45271365475927, 22.64249232082739, 11.61740700019673),
    ),
}
# How far each angle q turns the links: β, β + Θ, γ, Φ + δ, δ, Ω + ε, ε.
TURNS = {"K1": (0,), "K2": (0, 1), "K3": (2,), "K4": (3, 4), "K5": (4,), "K6": (5, 6), "K7": (6,)}

Array = NDArray[np.float64]


def along(angle: float) -> Array:
    return np.array([np.cos(angle), np.sin(angle)])


def places(q: tuple[float, ...]) -> dict[str, Array]:
    """Points by the formulas of the book."""
    beta, theta, gamma, _, delta, _, epsilon = q
    f = RR * along(beta)
    arm = -1j * np.exp(1j * gamma)
    down = np.array([arm.real, arm.imag])
    side = np.array([np.sin(epsilon), -np.cos(epsilon)])
    return {
        "F": f,
        "E": f - D * along(beta + theta),
        "D": B + SC * down + SD * along(gamma),
        "G": A + ZT * along(delta),
        "H": A + U * side,
    }


def centres(q: tuple[float, ...]) -> dict[str, Array]:
    """Centres of mass by the formulas of the book."""
    beta, theta, gamma, phi, delta, omega, epsilon = q
    square = np.pi / 2
    return {
        "K1": RA * along(beta),
        "K2": RR * along(beta) - DA * along(beta + theta),
        "K3": B + SA * along(gamma - square) + SB * along(gamma),
        "K4": A + ZT * along(delta) + (E - EA) * along(phi + delta - square),
        "K5": A + TA * along(delta) + TB * along(delta + square),
        "K6": A + U * along(epsilon - square) + (ZF - FA) * along(omega + epsilon),
        "K7": A + UA * along(epsilon - square) - UB * along(epsilon),
    }


def squeezer() -> Linkage:
    q = START["q"]
    linkage = Linkage(O=(0, 0), A=A, B=B, C=C, **places(q))
    ends = {"K1": "OF", "K2": "FE", "K3": "BED", "K4": "EG", "K5": "GA", "K6": "EH", "K7": "HA"}
    for (name, points), mass, inertia in zip(ends.items(), MASS, INERTIA, strict=True):
        linkage.link(name, *points, mass=mass, centre=centres(q)[name], inertia=inertia)
    linkage.revolute("O", "ground", "K1", drive=True, reference=q[0])
    linkage.revolute("F", "K1", "K2")
    linkage.revolute("E", "K2", "K3", "K4", "K6")
    linkage.revolute("B", "ground", "K3")
    linkage.revolute("G", "K4", "K5")
    linkage.revolute("H", "K6", "K7")
    linkage.revolute("A", "ground", "K5", "K7")
    linkage.spring("D", "C", stiffness=SPRING, length=FREE_LENGTH)
    return linkage


def moved(at: dict[str, tuple[float, ...]]) -> Motion:
    """The squeezer at an instant of the published motion; several turns of the crank after the drawing."""
    return squeezer().move(O=at["q"][0], rates={"O": at["v"][0]}, accelerations={"O": at["a"][0]})


@pytest.mark.parametrize("at", [START, LATER], ids=["0 s", "0.03 s"])
def test_closure(at: dict[str, tuple[float, ...]]) -> None:
    motion = moved(at)
    assert motion.gap < 1e-15
    # At the beginning crank and rod lie in line, so that the crank does not move E.
    assert motion.status == (
        "singular (inverse-kinematic, type I; joint E is stationary)" if at is START else "regular"
    )
    for name, place in places(at["q"]).items():
        assert_allclose(motion.position(name)[:2], place, rtol=0.0, atol=2e-15)


@pytest.mark.parametrize("at", [START, LATER], ids=["0 s", "0.03 s"])
def test_rates(at: dict[str, tuple[float, ...]]) -> None:
    motion = moved(at)
    for link, parts in TURNS.items():
        assert_allclose(motion.angular_velocity(link)[2], sum(at["v"][k] for k in parts), rtol=0.0, atol=1e-7)
        assert_allclose(motion.angular_acceleration(link)[2], sum(at["a"][k] for k in parts), rtol=0.0, atol=0.1)


@pytest.mark.parametrize("at", [START, LATER], ids=["0 s", "0.03 s"])
def test_torque_and_forces(at: dict[str, tuple[float, ...]]) -> None:
    """What the drive needs is the motor's torque of the book, and the pin E carries the multipliers."""
    reactions = moved(at).reactions()
    assert_allclose(reactions.drive("O"), TORQUE, rtol=1e-7)
    forces = [reactions.force(joint)[:2] for joint in ("E", "E.K4", "E.K6")]
    assert_allclose(np.concatenate(forces), at["force"], rtol=2e-6, atol=1e-7)


def test_free_acceleration() -> None:
    """Let go with the motor's torque, the crank accelerates as published."""
    found = moved(START).free_accelerations({"O": TORQUE})["O"]
    assert_allclose(found, START["a"][0], rtol=1e-9)
    found = moved(LATER).free_accelerations({"O": TORQUE})["O"]
    assert_allclose(found, LATER["a"][0], rtol=1e-6)
