"""Batch entries that are left out: no results, no warning, and the others as if they were alone."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.elements import Beam, Material, Rectangle
from linkframe.framework import Frame, FrameError
from linkframe.framework.paraview.scene import solved

BEAM = Beam(Rectangle(y=0.03, z=0.02), Material(E=200e9, nu=0.3, density=7850.0))


def cantilever(lengths: object) -> Frame:
    frame = Frame()
    frame.node("A", (0.0, 0.0, 0.0))
    frame.node("B", np.asarray(lengths)[..., None] * np.array([1.0, 0.0, 0.0]))
    frame.add("AB", BEAM, "A", "B")
    frame.fix("A")
    frame.load("B", fy=10.0)
    return frame


def test_left_out_entries_have_no_results_and_change_no_others() -> None:
    frame, whole = cantilever([1.0, 2.0, 3.0]), cantilever([1.0, 2.0, 3.0])
    frame.exclude([False, True, False])
    solution, reference = frame.solve(), whole.solve()
    assert solution.status.tolist() == ["regular", "absent", "regular"]
    for results in ("displacement", "end_forces", "reaction"):
        name = {"displacement": "B", "end_forces": "AB", "reaction": "A"}[results]
        found, wanted = getattr(solution, results)(name), getattr(reference, results)(name)
        assert np.isnan(found[1]).all()
        np.testing.assert_array_equal(found[[0, 2]], wanted[[0, 2]])
    np.testing.assert_array_equal(solved(solution, (slice(None),)), [True, False, True])
    frequencies = frame.modes(2).frequencies
    assert np.isnan(frequencies[1]).all()
    np.testing.assert_array_equal(frequencies[[0, 2]], whole.modes(2).frequencies[[0, 2]])


@pytest.mark.parametrize("what", ["condition_number", "distance_to_singularity", "nonlinearity"])
def test_left_out_entries_have_no_figures_of_merit(what: str) -> None:
    frame, whole = cantilever([1.0, 2.0, 3.0]), cantilever([1.0, 2.0, 3.0])
    frame.exclude([False, True, False])
    found = getattr(frame.solve(), what)()
    assert np.isnan(found[1])
    np.testing.assert_array_equal(found[[0, 2]], getattr(whole.solve(), what)()[[0, 2]])


def test_left_out_entries_do_not_buckle() -> None:
    frame, whole = cantilever([1.0, 2.0, 3.0]), cantilever([1.0, 2.0, 3.0])
    for each in (frame, whole):
        each.load("B", fx=-10.0)
    frame.exclude([False, True, False])
    factors = frame.buckling(2).factors
    assert np.isnan(factors[1]).all()
    np.testing.assert_array_equal(factors[[0, 2]], whole.buckling(2).factors[[0, 2]])


def test_what_is_left_out_is_no_mechanism() -> None:
    frame = cantilever([1.0, 2.0])
    frame.supports.clear()
    frame.fix("A", "ux", "uz", "rx", "ry", "rz")
    frame.exclude([True, True])
    assert frame.solve().status.tolist() == ["absent", "absent"]
    assert np.isnan(frame.solve().displacement("B")).all()
    assert np.isnan(frame.buckling(1).factors).all()


def test_more_is_left_out_bit_by_bit_and_numbers_are_refused() -> None:
    frame = cantilever([1.0, 2.0])
    frame.exclude([True, False])
    frame.exclude([False, True])
    assert frame.solve().status.tolist() == ["absent", "absent"]
    with pytest.raises(FrameError, match="give True for the entries to leave out"):
        frame.exclude([0, 1])
    with pytest.raises(FrameError, match="does not broadcast"):
        frame.exclude(np.array([True, False, True]))
