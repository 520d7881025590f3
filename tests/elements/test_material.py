"""Material: elastic constants and what is refused."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from linkframe.elements import Material
from linkframe.framework.errors import FrameError


@given(E=st.floats(1e-3, 1e13), nu=st.floats(-0.99, 0.49))
def test_nu_and_G_give_the_same_material(E: float, nu: float) -> None:
    """E = 2 G (1 + nu)."""
    by_nu = Material(E=E, nu=nu)
    by_G = Material(E=E, G=by_nu.G)
    assert by_G.nu == pytest.approx(nu, abs=1e-14)
    assert pytest.approx(2 * by_nu.G * (1 + nu), rel=1e-15) == by_nu.E


def test_numbers_stay_numbers_and_arrays_are_owned() -> None:
    moduli = np.array([1.0, 2.0, 3.0])
    material = Material(E=moduli, nu=np.full((4, 1), 0.25), density=7)
    moduli[:] = -1.0
    assert material.shape == (4, 3)
    assert np.shape(material.G) == (4, 3)
    assert isinstance(material.density, float)
    np.testing.assert_array_equal(material.E, [1.0, 2.0, 3.0])
    with pytest.raises(ValueError, match="read-only"):
        material.E[0] = 5.0  # type: ignore[index]


def test_shear_modulus_of_timber_is_free() -> None:
    assert Material(E=11e9, G=0.69e9).G == 0.69e9


@pytest.mark.parametrize(
    ("given_", "told"),
    [
        ({"E": 0.0, "nu": 0.3}, "E = 0 must be above zero"),
        ({"E": [1.0, -2.0], "nu": 0.3}, "E = -2 must be above zero"),
        ({"E": 1.0, "nu": 0.5}, r"nu = 0.5 must be between -1 and 0.5"),
        ({"E": 1.0, "nu": -1.0}, r"nu = -1 must be between"),
        ({"E": 1.0, "nu": float("nan")}, "nu = nan must be finite"),
        ({"E": float("inf"), "nu": 0.3}, "E = inf must be finite"),
        ({"E": 1.0, "G": 0.0}, "G = 0 must be above zero"),
        ({"E": 1.0}, "give one of the two, nu or G"),
        ({"E": 1.0, "nu": 0.3, "G": 1.0}, "give one of the two, nu or G"),
        ({"E": 1.0, "nu": 0.3, "density": -1.0}, "density = -1 must be zero or above"),
        ({"E": "steel", "nu": 0.3}, "E is 'steel': give a number"),
        ({"E": np.ones(2), "nu": np.zeros(3)}, r"E \(2,\), nu \(3,\)"),
        ({"E": np.ones(2), "nu": 0.0, "density": np.ones(3)}, r"do not broadcast: .*density \(3,\)"),
    ],
)
def test_what_cannot_be_is_refused(given_: dict[str, Any], told: str) -> None:
    with pytest.raises(FrameError, match=told):
        Material(**given_)
