"""Forces on the ends of members over long batches, by a program: the bits of the arrays that short ones take."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.elements import Beam, Joint, Material, Section
from linkframe.framework import Frame
from linkframe.framework.program import calculation, machine_code
from linkframe.framework.results import piece_program

POSES, SAMPLES = 3, 40
RNG = np.random.default_rng(5)
TURN = np.array([[0.8, -0.6, 0.0], [0.6, 0.8, 0.0], [0.0, 0.0, 1.0]])
THIN, THICK = Section(A=1e-3, Iy=1e-7, Iz=2e-7, J=1e-7), Section(A=2e-3, Iy=3e-7, Iz=5e-7, J=3e-7)


class Own(Beam):
    """A beam of a user: examined, and without formulas of its own number by number."""


def frame(*, plane: bool, singular: bool = False) -> Frame:
    """Three members at all poses, with whatever varies: modulus over the samples, places over the poses."""
    angle = np.linspace(0.2, 1.3, POSES)[:, None]
    modulus = 2e11 * np.exp(0.1 * RNG.normal(size=SAMPLES))
    steel = Material(E=modulus, nu=0.3)
    top = np.stack(np.broadcast_arrays(np.cos(angle), np.sin(angle), 0.0 if plane else 0.3), axis=-1)
    beside = top + np.array([1.0, 0.2, 0.0])
    found = Frame()
    found.body("beside", origin=(0.0, 0.0, 0.0), axes=TURN)
    for name, place in {"A": (0.0, 0.0, 0.0), "B": top, "C2": beside, "D": (2.5, 0.0, 0.0)}.items():
        found.node(name, place)
    found.node("C", beside @ TURN, body="beside")
    found.fix("A")
    found.fix("D", *(("ux", "uy", "uz", "rx", "ry") if plane else ()))
    found.add("AB", Beam(THIN, steel, end=THICK), "A", "B")
    found.add("BC", Beam(THIN, steel, segments=2, release=("start rz",)), "B", "C")
    found.add("CD", Own(THICK, steel), "C2", "D")
    stiffness = np.tile([1e8, 1e7, 1e8, 1e5, 1e5, 0.0], (POSES, 1, 1))
    if singular:
        stiffness[1] = 0.0
    found.add("C", Joint(stiffness), "C", "C2")
    found.load("B", fy=RNG.normal(size=SAMPLES), fx=3.0)
    found.line_load("AB", fy=-2.0)
    if not plane:
        found.load("C", fz=1.0, mx=0.2)
    return found


def read(one: Frame) -> dict[str, np.ndarray]:
    solution = one.solve()
    found = {name: solution.end_forces(name) for name in ("AB", "BC", "CD")}
    found |= {f"reaction {name}": solution.reaction(name) for name in "AD"}
    return found | {"inside": solution.forces("AB", [0.1, 0.5]), "joint": solution.joint_force("C")}


@pytest.mark.parametrize("plane", [True, False], ids=["in the plane", "in space"])
@pytest.mark.parametrize("compiled", [True, False], ids=["machine code", "NumPy"])
def test_long_batches_have_the_bits_of_short_ones(plane: bool, compiled: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    if compiled:
        pytest.importorskip("llvmlite")
        monkeypatch.setattr(calculation, "NUMPY", 1.0)  # so slow that compiling pays
    else:
        monkeypatch.setattr(machine_code, "available", lambda: False)
        monkeypatch.setattr(piece_program, "CHUNK", 32)
    one = frame(plane=plane)
    monkeypatch.setattr(piece_program, "LONG", 1)
    found = read(one)
    monkeypatch.setattr(piece_program, "LONG", POSES * SAMPLES + 1)
    for name, wanted in read(one).items():
        np.testing.assert_array_equal(found[name], wanted, err_msg=name)


@pytest.mark.filterwarnings("ignore::linkframe.framework.errors.MechanismWarning")
def test_what_is_lost_at_some_entries_is_so_in_what_is_read_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """Forces of a piece serve several results: those that are NaN there leave the others as they are."""
    one = frame(plane=True, singular=True)
    monkeypatch.setattr(piece_program, "LONG", 1)
    once = read(one)
    solution = one.solve()
    for name in ("AB", "reaction A"):
        again = solution.end_forces("AB") if name == "AB" else solution.reaction("A")
        np.testing.assert_array_equal(again, once[name])
    monkeypatch.setattr(piece_program, "LONG", POSES * SAMPLES + 1)
    for name, wanted in read(one).items():
        np.testing.assert_array_equal(once[name], wanted, err_msg=name)
