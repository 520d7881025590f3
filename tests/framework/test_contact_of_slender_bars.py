"""Bars 2 cm thick and kilometres long: what joints bear is told by equilibrium, not by the rounding of stiffness."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.elements import Beam, Circle, Joint, Material
from linkframe.framework import Frame
from reference import stiffness_method
from reference.as_frame import as_frame
from reference.structure import COMPONENTS, Member, Spring, Structure

E, THICKNESS, GAP = 2e11, 0.02, 1e-4
MOMENTS = np.array([1.0, -2.0, 0.25])


@pytest.mark.parametrize("length", [1.0, 1e2, 1e4])
@pytest.mark.parametrize("angle", [0.3, 1.1, 2.0])
@pytest.mark.parametrize("moment", [MOMENTS, 1.0, -3.7e-3])
def test_a_moment_alone_presses_no_joint_of_a_cantilever(
    length: float, angle: float, moment: float | np.ndarray
) -> None:
    """It passes through a rigid joint without any force, alone as in a batch: nothing says where the journal is."""
    frame, way = Frame(), np.array([np.cos(angle), np.sin(angle), 0.0])
    for name, share in {"A": 0.0, "B": 1.0, "C": 1.0, "D": 1.7}.items():
        frame.node(name, share * length * way)
    bar = Beam(Circle(diameter=THICKNESS), Material(E=E, nu=0.3))
    frame.add("AB", bar, "A", "B")
    frame.add("joint", Joint((np.inf,) * 6, clearance=GAP, clearance_directions=("ux", "uy")), "B", "C")
    frame.add("CD", bar, "C", "D")
    frame.fix("A")
    frame.load("D", mz=moment)
    assert set(np.ravel(frame.solve().contact("joint").status)) == {"free"}


@pytest.mark.parametrize("angle", [0.3, 1.1, 2.0])
@pytest.mark.parametrize("moment", [MOMENTS, 1.0])
@pytest.mark.parametrize(("spring", "force"), [(False, 1e5), (True, 1e5), (True, 1e-4)])
def test_nor_beside_a_joint_that_stiffness_resists(
    angle: float, moment: float | np.ndarray, spring: bool, force: float
) -> None:
    """In the same frame a bar between two walls is pulled off its bearing, against another or a spring as stiff."""
    frame, way, length = Frame(), np.array([np.cos(angle), np.sin(angle), 0.0]), 1e4
    for name, share in {"A": 0.0, "B": 1.0, "C": 1.0, "D": 1.7}.items():
        frame.node(name, share * length * way)
    for name, x in {"P": 0.0, "Q": 0.0, "R": 1.0, "S": 2.0}.items():
        frame.node(name, (x, 5.0, 0.0))
    bar = Beam(Circle(diameter=THICKNESS), Material(E=E, nu=0.3))
    rigid = Joint((np.inf,) * 6, clearance=GAP, clearance_directions=("ux", "uy"))
    frame.add("joint", rigid, "B", "C")
    frame.add("wall", Joint((np.inf,) * 6, clearance=GAP, clearance_directions="ux"), "P", "Q")
    stiffness = E * np.pi / 4.0 * THICKNESS**2
    for pair in ("AB", "CD", "QR"):
        frame.add(pair, bar, *pair)
    if spring:
        frame.node("T", (1.0, 5.0, 0.0))
        frame.fix("T")
        frame.add("RT", Joint((stiffness, 0.0, 0.0, 0.0, 0.0, 0.0)), "R", "T")
    else:
        frame.add("RS", bar, "R", "S")
    for name in "APS":
        frame.fix(name)
    frame.load("D", mz=moment)
    frame.load("R", fx=force)
    solution = frame.solve()
    assert set(np.ravel(solution.contact("joint").status)) == {"free"}
    pulled = max(force - stiffness * GAP, 0.0) / 2.0
    np.testing.assert_allclose(solution.contact("wall").force, pulled, rtol=1e-9)


@pytest.mark.parametrize("moment", [0.3, MOMENTS])
def test_forces_of_a_clamped_triangle_of_long_bars(moment: float | np.ndarray) -> None:
    """Next to nothing resists offsets: joints are pressed along the force that 60 digits find without clearance."""
    inertia = np.pi / 64.0 * THICKNESS**4
    places = {"a": (0.0, 0.0, 0.0), "b": (7.1e4, 1.3e4, -2.2e4), "c": (1.9e4, 8.3e4, 3.1e4)}
    nodes = places | {"ab": places["b"], "ac": places["c"]}
    values = {"E": E, "G": E / 2.6, "A": np.pi / 4.0 * THICKNESS**2, "Iy": inertia, "Iz": inertia, "J": 2.0 * inertia}
    members = {
        f"{start}{end}": Member(start, end, **values, ky=np.inf, kz=np.inf, up=(0.1, -0.2, 0.9))
        for start, end in (("a", "ab"), ("a", "ac"), ("b", "c"))
    }
    axes = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    joints = {name: Spring(f"a{name}", name, (np.inf,) * 6, axes) for name in "bc"}
    clamped = {"a": dict.fromkeys(COMPONENTS, 0.0)}
    for one in np.atleast_1d(moment):
        load = {"b": (0.0, 0.0, 0.0, -0.7 * one, 0.1 * one, -0.3 * one)}
        structure = Structure(nodes, members, joints, supports=clamped, loads=load)
        exact = stiffness_method.solve(structure).force
        frame = as_frame(structure)
        if np.ndim(moment):
            frame.set_load("b", mx=-0.7 * MOMENTS, my=0.1 * MOMENTS, mz=-0.3 * MOMENTS)
        for name in "bc":
            frame.change(name, Joint((np.inf,) * 6, clearance=GAP, clearance_directions=("ux", "uy", "uz")))
        solution = frame.solve()
        for name in "bc":
            force = np.array([float(part) for part in exact[name][:3]])
            contact = solution.contact(name)
            which = np.flatnonzero(one == MOMENTS)[0] if np.ndim(moment) else ()
            found = (contact.force[..., None] * contact.normal)[which]
            np.testing.assert_allclose(found, force, rtol=0.0, atol=1e-6 * np.abs(force).max())
