"""Sentences about samples: ranges of condition numbers, and those that passed a singular configuration, by hand."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
from linkframe.models.job.choices import bounds
from linkframe.models.job.force_figures import Over
from linkframe.models.job.large_table import passages
from numpy.testing import assert_array_equal


def test_bounds_are_of_the_samples_that_have_a_value() -> None:
    assert bounds(np.array([np.nan, 3.0, 1.0])) == (1.0, 3.0)
    assert np.isnan(bounds(np.array([np.nan]))).all()


def test_samples_that_passed_are_left_out_of_the_spread() -> None:
    """In the plane of x and z; σ of 1, 3 mm and of 2, 6 mm without the one that passed and the one that was lost."""
    samples = 1e-3 * np.array([[[1.0, 9.0, 2.0], [3.0, 90.0, 6.0], [-30.0, 500.0, 40.0], [np.nan] * 3]])
    passed = np.array([[False, False, True, False]])
    large = SimpleNamespace(samples=np.repeat(samples, 2, axis=0), passed=np.stack([passed[0] & False, passed[0]]))
    outcome: Any = SimpleNamespace(
        large=large, axes=(0, 2), drives=["10°", "20°"], point="C", singular_place="its line"
    )
    (told,) = passages(outcome)
    assert told == (
        "At 20° 1 of 4 samples at large displacement has passed through its line and ends on the side of the other"
        " branch, C up to 50.0 mm from its rigid position (number 2 of samples.npz, counted from 0); without it σ_x and"
        " σ_z are 1.41e-03 and 2.83e-03 m."
    )


def test_forces_are_drawn_over_the_poses_where_a_drive_goes_to_and_fro() -> None:
    assert Over.drive(np.array([0.0, 10.0, 20.0]), "A [°]", True).turns
    over = Over.drive(np.array([0.0, 10.0, 5.0]), "A [°]", True)
    assert_array_equal(over.values, [0.0, 1.0, 2.0])
    assert (over.name, over.turns) == ("pose", False)
