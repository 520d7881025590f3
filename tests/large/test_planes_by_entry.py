"""Each entry keeps to the plane in which it lies and is loaded, whatever its neighbours in the batch do."""

from __future__ import annotations

import numpy as np
from linkframe.elements import Beam, Joint, Material, Rectangle
from linkframe.framework import Frame

STEEL = Material(E=200e9, nu=0.3)
INF = float("inf")
# A column beyond the lower of its critical loads, 84 and 21 N: pushed along itself, across either way, and both ways.
PUSHED = {
    "fx": np.array([-30.0, -30.0, -30.0, -20.0, 0.0]),
    "fy": np.array([0.0, 1.0, 0.0, 2.0, 0.0]),
    "fz": np.array([0.0, 0.0, 1.0, 1.0, 0.0]),
}


def column(entry: int | None = None) -> Frame:
    """The column under all these loads, or under one of them."""
    frame = Frame()
    for name, x in {"A": 0.0, "B": 1.0}.items():
        frame.node(name, (x, 0.0, 0.0))
    frame.add("AB", Beam(Rectangle(y=8e-3, z=4e-3), STEEL, segments=2), "A", "B")
    frame.fix("A")
    frame.load("B", **{name: force if entry is None else force[entry] for name, force in PUSHED.items()})
    return frame


def test_an_entry_is_the_same_alone_and_in_a_batch() -> None:
    """All its results to the bit."""
    whole = column().solve(large=True)
    for entry in (0, 2):
        alone = column(entry).solve(large=True)
        assert alone.status == whole.status[entry]
        pairs = [
            [each.displacement("B"), each.error_bound("B"), each.end_forces("AB"), each.reactions(), each.residual]
            for each in (whole, alone)
        ]
        for each, ends in zip((whole, alone), pairs, strict=True):
            ends += [each.displacement_along("AB", [0.3]), each.forces("AB", [0.3]), each.stress("AB", [0.3])]
            ends += [each.section_axes_at([0.5]), each.strain_energy.T, each.work.T]
        for batch, single in zip(*pairs, strict=True):
            np.testing.assert_array_equal(batch[entry], single)
    # in the plane across z it would have to leave that for the way in which it is softer
    assert whole.status[:3].tolist() == ["unstable", "unstable", "stable"]
    np.testing.assert_allclose(whole.displaced.displacements[:, 1].T, whole.displacement("B")[:, :3])
    assert "plane by plane" in whole.explain()


def test_journals_in_several_planes() -> None:
    """Contacts and what is left out, by entry; each journal rests against its load."""
    frame = Frame()
    for name, x in {"O": 0.0, "A": 0.0, "B": 1.0}.items():
        frame.node(name, (x, 0.0, 0.0))
    frame.add("journal", Joint((1e9,) * 3 + (INF,) * 3, clearance=1e-3), "O", "A")
    frame.add("AB", Beam(Rectangle(y=0.02, z=0.02), STEEL), "A", "B")
    frame.fix("O")
    frame.load("B", fy=[10.0, 0.0, 10.0, 6.0], fz=[0.0, 10.0, 3.0, 8.0])
    frame.exclude([False, False, True, False])
    solution = frame.solve(large=True)
    contact = solution.contact("journal")
    assert contact.status.tolist() == ["closed", "closed", "absent", "closed"]
    expected = [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [np.nan] * 3, [0.0, 0.6, 0.8]]
    np.testing.assert_allclose(contact.normal, expected, atol=1e-9)
    assert solution.status.tolist() == ["stable", "stable", "absent", "stable"]


def test_paths_keep_to_their_planes() -> None:
    """Loads across both ways do not lead a path out of the plane in which a neighbour is loaded."""
    frame = column()
    frame.exclude([True, False, False, True, True])
    whole = frame.path("B", "ux", -1e-3)
    for entry in (1, 2):
        alone = column(entry).path("B", "ux", -1e-3)
        count = len(alone.factor)
        np.testing.assert_array_equal(whole.factor[:count, entry], alone.factor)
        np.testing.assert_array_equal(whole.displacement("B")[:count, entry], alone.displacement("B"))
        np.testing.assert_array_equal(whole.stable[:count, entry], alone.stable)
        assert np.isnan(whole.factor[count:, entry]).all()
        assert whole.reached[entry] == alone.reached
