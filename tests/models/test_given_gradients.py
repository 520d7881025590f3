"""Gradients that are handed to `reliability`: what cannot be meant is told where it is given."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from linkframe.framework import FrameError
from linkframe.models import reliability
from scipy import stats

GIVEN = {"a": stats.norm(), "b": stats.norm()}


@pytest.mark.parametrize(
    ("gradient", "told"),
    [
        ("steep", "gradient is 'steep': give a function"),
        (lambda x: {"a": -1.0 + 0.0 * x["a"]}, "no derivative by 'b'"),
        (lambda x: None, "returned NoneType: return derivatives by the names"),
        (lambda x: (x["a"], {"a": -1.0, "b": -1.0}, 0), "returned tuple: return derivatives by the names"),
        (lambda x: (3.0, {"a": -x["a"], "b": x["b"]}), r"values of shape \(\) for \d+ samples"),
        (lambda x: {"a": np.ones(7), "b": x["b"]}, r"derivative by 'a' has shape \(7,\)"),
    ],
)
def test_gradients_that_are_refused(gradient: Any, told: str) -> None:
    with pytest.raises(FrameError, match=told):
        reliability(lambda x: 3.0 - x["a"] - x["b"], GIVEN, gradient=gradient, method="form", starts=1)


def test_constant_derivatives_are_numbers() -> None:
    found = reliability(
        lambda x: 3.0 - x["a"] - x["b"], GIVEN, gradient=lambda x: {"a": -1.0, "b": -1.0}, method="form"
    )
    assert np.isclose(found.beta, 3.0 / np.sqrt(2.0), rtol=1e-12)
