"""Newton's method step by step by NumPy against the same with arrays, and what its program is made of."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.elements import Beam, Material, Rectangle
from linkframe.framework import Frame, rotation
from linkframe.framework.large import corotation, newton_program
from linkframe.framework.large.corotation import Pieces
from linkframe.framework.large.response import Response
from linkframe.framework.large.solution import LargeSolution
from linkframe.framework.program import machine_code
from linkframe.framework.program.arranging import arranged
from linkframe.framework.program.calculation import Calculation
from linkframe.framework.program.program import Operation
from linkframe.framework.program.recording import Recording
from linkframe.models import FourBar
from numpy.typing import NDArray

Array = NDArray[np.float64]


def four_bar() -> Frame:
    """The four-bar with stiff pins at seven poses."""
    rng = np.random.default_rng(4)
    stiffness = np.append(np.ones(5), 0.0) * 10.0 ** rng.uniform(7.0, 11.0, 7)[:, None]
    beam = Beam(Rectangle(y=4e-3, z=6e-3), Material(E=200e9, nu=0.3))
    frame = FourBar(beam=beam, stiffness=stiffness).move(np.radians(np.linspace(3.0, 160.0, 7))).frame()
    frame.load("P", fy=rng.uniform(-40.0, 40.0, 7))
    return frame


def cantilever() -> Frame:
    """A cantilever, pushed in all directions."""
    frame, rng = Frame(), np.random.default_rng(5)
    for name, x in (("A", 0.0), ("B", 1.0)):
        frame.node(name, (x, 0.0, 0.0))
    frame.add("AB", Beam(Rectangle(y=4e-3, z=6e-3), Material(E=200e9, nu=0.3)), "A", "B")
    frame.fix("A")
    frame.load("B", **{k: rng.uniform(-9.0, 9.0, 7) for k in ("fx", "fy", "fz")})
    return frame


def solved(frame: Frame, entries: int | None) -> LargeSolution:
    """Solution without machine code: by NumPy, some entries at a time, or by arrays where None."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(machine_code, "available", lambda: False)
        for name in ("_CALL", "_EACH", "_WRITING"):
            patch.setattr(newton_program, name, np.inf if entries is None else 0.0)
        patch.setattr(newton_program, "CHUNK", entries or 1)
        solution = frame.solve(large=True)
        assert (solution._load_stepping.newton.program is not None) == (entries is not None)
        told = "by arrays" if entries is None else "step by step by NumPy"
        assert told in str(solution.explain())
        assert solution.status.shape == frame.shape
    return solution


@pytest.mark.parametrize(("frame", "node"), [(four_bar(), "P"), (cantilever(), "B")])
def test_the_same_as_by_arrays(frame: Frame, node: str) -> None:
    arrays, whole, parts = (solved(frame, entries) for entries in (None, 100, 3))
    assert (whole.status == arrays.status).all()
    assert (whole.iterations == arrays.iterations).all()
    wanted, found = arrays.displacement(node), whole.displacement(node)
    assert (np.abs(found - wanted).max(axis=-1) < 1e-12 * np.abs(wanted).max(axis=-1)).all()
    assert (parts.displacement(node) == found).all()


def test_arranged_programs_calculate_the_same_in_fewer_steps() -> None:
    """Sums of products, differences of them both ways, and several numbers over one."""
    recording = Recording(fixed=True, signless=True)
    a, b, c, d = (recording.later(1) for _ in range(4))
    one = 1.0 / (a + 3.0)
    outputs = [a * b + c * d, a * d - (b + c), (b + d) - b * c, a / d, b / d, c / d + a * c, one, a * one]
    program, places = recording.program(outputs)
    found = arranged(program)
    rng = np.random.default_rng(2)
    numbers = [rng.uniform(0.5, 2.0, 9) for _ in range(4)]
    given = [numbers[k] for k in places]
    both = [Calculation(each, given, (9,), compiled=False).results() for each in (program, found)]
    for one, other in zip(*both, strict=True):
        assert np.abs(one - other).max() <= 4.0 * np.finfo(float).eps * (1.0 + np.abs(one).max())
    kinds = [step.operation for step in found.steps]
    assert len(found.steps) < len(program.steps)
    assert kinds.count(Operation.DIVIDE) == 2
    assert {Operation.MULTIPLY_ADD, Operation.MULTIPLY_SUBTRACT, Operation.SUBTRACT_PRODUCT} <= set(kinds)


def test_response_of_members() -> None:
    """Forces change as the tangent says, and do the work of the deformations."""
    rng = np.random.default_rng(6)

    def turned(size: float) -> Array:
        return rotation.exponential(size * rng.standard_normal((3, 2, 1)))

    k, bow = (0.1 * rng.standard_normal((n, n, 2, 1)) for n in (7, 6))
    k, bow = k + k.swapaxes(0, 1), bow + bow.swapaxes(0, 1)
    pieces = Pieces(rotation.matrix(turned(1.0)), np.full((2, 1), 1.3), k, bow, None)
    start = [0.2 * rng.standard_normal((3, 2, 1)) for _ in range(2)]
    turns = [turned(0.5) for _ in range(2)]

    def at(ends: Array) -> Response:
        moved = start[0] + ends[:3], start[1] + ends[6:9]
        spun = [rotation.product(rotation.exponential(v), q) for v, q in zip((ends[3:6], ends[9:]), turns, strict=True)]
        return Response(pieces, corotation.motion(pieces, moved, (spun[0], spun[1])))

    def force(ends: Array) -> Array:
        response = at(ends)
        return response.forces(corotation.stress(pieces, response.at.deformation))

    here, v, h = at(np.zeros((12, 2, 1))), rng.standard_normal((12, 2, 1)), 1e-5
    stress = corotation.stress(pieces, here.at.deformation)
    tangent = here.tangent(stress)
    slope = (force(h * v) - force(-h * v)) / (2.0 * h)
    np.testing.assert_allclose(rotation.times(tangent, v), slope, rtol=0.0, atol=1e-8 * np.abs(slope).max())
    change = here.deformed(v)
    np.testing.assert_allclose(change, rotation.times(here.global_change(), v), atol=1e-13)
    strained = (at(h * v).at.deformation - at(-h * v).at.deformation) / (2.0 * h)
    np.testing.assert_allclose(change, strained, atol=1e-8)
    np.testing.assert_allclose(rotation.dot(here.forces(stress), v), rotation.dot(stress, change), rtol=1e-12)
    even = here.tangent(stress, symmetric=True)
    np.testing.assert_allclose(even, 0.5 * (tangent + tangent.swapaxes(0, 1)), atol=1e-13)
    by_force = corotation.stiffness(pieces, here.at.deformation, stress[0])
    given = corotation.stress_change(pieces, here.at.deformation, stress[0], change)
    np.testing.assert_allclose(given, rotation.times(by_force, change), atol=1e-13)
