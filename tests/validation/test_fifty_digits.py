"""The paper's four-bar and random frames against the same frame solved with 50 digits.

"The same frame" to 1e-12 takes care with what is exact. The reference takes every float of the description
(coordinates, E, G, A, Iy, Iz, J, stiffnesses, loads) as the exact number that the float is, and derives from them
what the library derives: lengths, direction cosines, products such as E A. It never uses the ideal parallelogram from
which the coordinates were rounded, since that is a slightly different frame.

A linkage can be described in two ways, and they are two slightly different frames. With global coordinates the length
of a link is the rounded distance of rounded points and differs from pose to pose by an eps; with bodies it is the
same float at every pose, and the body's axes are orthonormal only to an eps. So each way has its own reference: in the
second the reference places the nodes at ``origin + axes @ local`` evaluated exactly from the floats. There the nodes
of a joint are apart by some 1e-17 m, and a link is longer by an eps than it is in its own axes; both change
the displacements by a few eps times the amplification of the linkage (some 10^2 at these poses), by 1e-14.

The third description is FourBar's own. Its reference is the ideal linkage at the float angle, cosine and sine with 50
digits: what is left of the difference is all the rounding that there is, from angle to displacement.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given
from linkframe.elements import Joint
from linkframe.framework import Frame
from linkframe.models import FourBar
from numpy.typing import NDArray
from reference.as_frame import as_beam, as_frame
from reference.compare import FORCES, allowed, apart, stacked
from reference.four_bar import CLAMPED, ENDS, JOINTS, LENGTH, STIFFNESS, coordinates, four_bar
from reference.random_structures import few, structures
from reference.stiffness_method import DOUBLE, mp, solve
from reference.structure import LOADS, Structure, Vector

Array = NDArray[np.float64]

POSES = (10, 30, 60, 90, 150, 230, 300, 350)
# In plane; out of plane; both.
CASES = {
    "Fy": (0.0, 100.0, 0.0, 0.0, 0.0, 0.0),
    "Fz": (0.0, 0.0, 100.0, 0.0, 0.0, 0.0),
    "all": (30.0, -70.0, 50.0, 3.0, -2.0, 1.0),
}


def by_coordinates(load: tuple[float, ...]) -> tuple[Frame, list[Structure]]:
    """All poses as one frame in global coordinates, and each as the structure with the same floats."""
    each = [four_bar(coordinates(theta), load) for theta in POSES]
    nodes = {name: np.array([structure.nodes[name] for structure in each]) for name in each[0].nodes}
    template = as_frame(each[0])
    frame = Frame()
    for name, place in nodes.items():
        frame.node(name, place)
    for name, member in template.members.items():
        frame.add(name, member.element, member.start, member.end)
    for name, joint in template.joints.items():
        frame.add(name, joint.element, joint.first, joint.second)
    supported(frame, load)
    return frame, each


def by_bodies(load: tuple[float, ...]) -> tuple[Frame, list[Structure]]:
    """All poses as one frame of moving bodies, and each as the structure with nodes placed exactly."""
    angle = np.radians(np.array(POSES, dtype=np.float64))
    c, s, o, i = np.cos(angle), np.sin(angle), np.zeros(len(POSES)), np.ones(len(POSES))
    turned = np.stack([np.stack([c, -s, o], -1), np.stack([s, c, o], -1), np.stack([o, o, i], -1)], -2)
    pin = LENGTH * np.stack([c, s, o], -1)
    bodies = {
        "crank": (np.zeros(3), turned),
        "coupler": (pin, np.eye(3)),
        "rocker": (np.array([2 * LENGTH, 0.0, 0.0]), turned),
    }
    local = {
        "A": ("crank", 0.0),
        "B.crank": ("crank", LENGTH),
        "B.coupler": ("coupler", 0.0),
        "P": ("coupler", LENGTH),
        "D.coupler": ("coupler", 2 * LENGTH),
        "D.rocker": ("rocker", LENGTH),
        "E.rocker": ("rocker", 0.0),
    }
    template = as_frame(four_bar(coordinates(10), load))
    frame = Frame()
    for name, (origin, axes) in bodies.items():
        frame.body(name, origin, axes)
    for name, (body, x) in local.items():
        frame.node(name, (x, 0.0, 0.0), body)
    frame.node("E", (2 * LENGTH, 0.0, 0.0))
    for name, (start, end) in ENDS.items():
        frame.add(name, template.members[name].element, start, end)
    for name, (first, second) in JOINTS.items():
        frame.add(name, Joint(stiffness=template.joints[name].element.stiffness), first, second)
    supported(frame, load)

    def exact(name: str, pose: int) -> Vector:
        if name not in local:
            return (2 * LENGTH, 0.0, 0.0)
        body, x = local[name]
        origin, axes = (
            np.broadcast_to(a, (len(POSES), *shape))[pose]
            for a, shape in zip(bodies[body], ((3,), (3, 3)), strict=True)
        )
        first, second, third = (mp.mpf(float(origin[k])) + mp.mpf(float(axes[k, 0])) * mp.mpf(x) for k in range(3))
        return first, second, third

    each = [four_bar({name: exact(name, pose) for name in coordinates(0)}, load) for pose in range(len(POSES))]
    return frame, each


def by_model(load: tuple[float, ...]) -> tuple[Frame, list[Structure]]:
    """FourBar's frame at all poses, and the ideal linkage at each of the same float angles."""
    beam = as_beam(four_bar(coordinates(10), load).members["crank"])
    angles = np.radians(np.array(POSES, dtype=np.float64))
    frame = FourBar(beam=beam, stiffness=STIFFNESS).move(angles).frame()
    frame.load("P", **dict(zip(LOADS, load, strict=True)))

    def ideal(theta: float) -> dict[str, Vector]:
        length, zero = mp.mpf(LENGTH), mp.mpf(0)
        x, y = length * mp.cos(mp.mpf(theta)), length * mp.sin(mp.mpf(theta))
        b, p, d = ((x + k * length, y, zero) for k in range(3))
        e = (2 * length, zero, zero)
        places = (("A", (zero, zero, zero)), ("B", b), ("P", p), ("D", d), ("E", e))
        return {node: place for name, place in places for node in coordinates(0) if node.split(".")[0] == name}

    return frame, [four_bar(ideal(float(theta)), load) for theta in angles]


def supported(frame: Frame, load: tuple[float, ...]) -> None:
    """Clamp the ground nodes and load P."""
    for node in ("A", "E"):
        frame.prescribe(node, **CLAMPED)
    frame.load("P", **dict(zip(LOADS, load, strict=True)))


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("described", [by_coordinates, by_bodies, by_model], ids=["coordinates", "bodies", "model"])
def test_four_bar_agrees_with_fifty_digits_where_the_usual_assembly_does_not(
    described: Callable[[tuple[float, ...]], tuple[Frame, list[Structure]]],
    case: str,
    record_property: Callable[[str, object], None],
) -> None:
    """Displacements of all nodes, joint displacements and joint forces to 1e-12 at eight poses.

    The usual assembly is the same textbook method as the reference, in double precision: its errors are rounding alone.
    Its joint displacements are differences of equal numbers, so there they are compared with the nodes' own.
    """
    frame, each = described(CASES[case])
    solution = frame.solve()
    truth = [solve(structure) for structure in each]
    usual = [solve(structure, DOUBLE) for structure in each]

    exact = np.stack([stacked(result.displacement) for result in truth])
    ours = apart(stacked({name: solution.displacement(name) for name in frame.nodes}, truth[0].displacement), exact)
    theirs = apart(np.stack([stacked(result.displacement) for result in usual]), exact)
    record_property("ours", ours.tolist())
    record_property("usual", theirs.tolist())
    assert np.all(solution.status == "regular")
    assert np.all(ours < 1e-12)
    assert theirs.max() > 3e-11
    assert theirs.max() > 1000 * ours.max()

    gaps = np.stack([stacked(result.extension) for result in truth])
    forces = np.stack([stacked(result.force) for result in truth])
    assert np.all(apart(stacked({name: solution.joint_displacement(name) for name in "BDE"}), gaps) < 1e-12)
    assert np.all(apart(stacked({name: solution.joint_force(name) for name in "BDE"}), forces) < 1e-12)


@few
@given(structures)
def test_random_frames_agree_with_fifty_digits(structure: Structure) -> None:
    """Displacements to the numerical contract; forces and joint displacements to FORCES times it."""
    frame = as_frame(structure)
    solution = frame.solve()
    truth = solve(structure)
    bound = allowed(solution.scaled_condition_number())
    ours = stacked({name: solution.displacement(name) for name in structure.nodes})
    assert apart(ours, stacked(truth.displacement)) <= bound
    for found, exact in (
        ({name: solution.reaction(name) for name in structure.supports}, truth.reaction),
        ({name: solution.joint_displacement(name) for name in structure.joints}, truth.extension),
        ({name: solution.joint_force(name) for name in structure.joints}, truth.force),
    ):
        if exact:
            assert apart(stacked(found), stacked(exact)) <= FORCES * bound
