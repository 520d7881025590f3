"""The pieces of a frame as a scikit-fem mesh, and its numbering of their displacements, which the framework has too."""

from __future__ import annotations

import numpy as np
from linkframe.elements import Beam, Joint, Material, Rectangle
from linkframe.framework import Frame
from linkframe.framework.structure.topology import Topology
from numpy.testing import assert_array_equal

BEAM = Beam(Rectangle(y=0.03, z=0.02), Material(E=200e9, nu=0.3), segments=3)


def topology() -> Topology:
    frame = Frame()
    for name, place in {"A": (0, 0, 0), "B": (1, 0, 0), "C": (1, 0, 0), "D": (1, 3, 0)}.items():
        frame.node(name, place)
    frame.add("AB", BEAM, "A", "B")
    frame.add("pin", Joint(stiffness=(1.0,) * 6), "B", "C")
    frame.add("CD", BEAM, "C", "D")
    return Topology.of(frame, cut=True)


def test_cells_are_pieces_and_joints() -> None:
    made = topology()
    mesh = made.mesh
    beams, joints = mesh.subdomains["beam"], mesh.subdomains["joint"]
    assert (len(beams), len(joints)) == (6, 1)
    assert_array_equal(mesh.t[:, beams].T, made.ends)
    assert_array_equal(mesh.t[:, joints].T, [[made.number["B"], made.number["C"]]])
    lengths = np.linalg.norm(mesh.p[:, mesh.t[1]] - mesh.p[:, mesh.t[0]], axis=0)
    np.testing.assert_allclose(lengths, [1 / 3] * 3 + [1.0] * 3 + [0.0], rtol=1e-14)


def test_numbers_of_displacements_are_those_of_scikit_fem() -> None:
    made = topology()
    numbering = made.numbering
    count = numbering.N
    assert count == 6 * len(made.names)
    for group in made.groups:
        assert_array_equal(numbering.element_dofs[:, group.pieces].T, group.dofs)
    for k, name in enumerate(("ux", "uy", "uz", "rx", "ry", "rz")):
        assert_array_equal(numbering.get_vertex_dofs([made.number["D"]]).all([name]), [6 * made.number["D"] + k])
