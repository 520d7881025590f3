"""Options of the four-bar's job that would be passed over in silence: refused, or told."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.framework.errors import FrameError
from linkframe.models.command_line import main
from linkframe.models.job.remarks import beyond_size, named
from linkframe.models.paper.inputs import Inputs
from linkframe.models.paper.remarks import beforehand, lost, remarks
from linkframe.models.paper.result import begin, compute

FEW = {"poses": (80.0, 80.0, 1.0), "samples": 2}


@pytest.mark.parametrize("contact", ["reaction", "equilibrium"])
def test_an_angle_that_follows_from_forces_has_no_deviation(contact: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["four-bar", "--contact", contact, "--contact-sd", "10"]) == 2
    told = f"--contact-sd is 10 beside --contact {contact}: the angle follows from the forces"
    assert told in capsys.readouterr().err
    Inputs(contact=contact)
    Inputs(contact=contact, contact_sd=0.0)


def test_a_clearance_is_less_than_its_links() -> None:
    with pytest.raises(FrameError, match=r"--clearance is 0\.5, .* --crank 0\.1: check its unit"):
        Inputs(clearance=0.5)
    with pytest.raises(FrameError, match=r"--rocker 0\.05"):
        Inputs(clearance=0.1, rocker=0.05, clearance_is="diameter")
    Inputs(clearance=0.15, clearance_is="diameter")


@pytest.mark.parametrize(
    ("given", "told"),
    [
        (
            {"clearance": 0.0, "clearance_sd": 0.0, "closure": "exact"},
            "--closure exact has no effect: --clearance is 0.",
        ),
        ({"clearance": 0.0, "clearance_sd": 0.0, "contact": 90.0}, "--contact 90.0 has no effect: --clearance is 0."),
        (
            {"clearance": 0.0, "clearance_sd": 0.0, "clearance_is": "diameter"},
            "--clearance-is diameter has no effect: --clearance is 0.",
        ),
        (
            {"stiffness_sd": 0.0, "clearance_sd": 0.0, "contact_sd": 0.0, "joints": "shared"},
            "--joints shared has no effect: no number of the joints has a deviation.",
        ),
        ({"section": (0.01, 0.01), "in_plane": "short"}, "--in-plane short has no effect: the section is a square."),
        ({}, ""),
    ],
)
def test_options_that_change_nothing_are_told(given: dict[str, object], told: str) -> None:
    """What is told to have no effect has none: the samples are those of the defaults."""
    inputs = Inputs(**FEW, **given)  # type: ignore[arg-type]
    result = compute(inputs)
    assert [note for note in remarks(result) if "no effect" in note] == ([told] if told else [])
    if told:
        (name,) = inputs.without_effect
        plain = compute(inputs.but(**{name: getattr(Inputs, name)}))
        np.testing.assert_allclose(plain.samples, result.samples, rtol=0.0, atol=1e-15)


def test_samples_without_a_result_are_counted_by_reason() -> None:
    result = compute(Inputs(closure="exact", poses=(2.0, 62.0, 60.0), samples=30))
    count = int(result.study.missing[0, 0])
    assert 0 < count < 30
    assert lost(result.study) == {"clearance leaves the loop open": count}
    told = f"{count} of 2 × 30 samples have no result (clearance leaves the loop open {count} times)"
    assert any(note.startswith(told) for note in remarks(result))
    assert np.isfinite(result.mean).all()
    strict = compute(Inputs(closure="exact", poses=(2.0, 62.0, 60.0), samples=30, nan_policy="propagate"))
    np.testing.assert_array_equal(np.isnan(strict.mean[:, 0]), [True, False])
    with pytest.raises(FrameError, match=f"{count} of 30 samples are NaN"):
        compute(Inputs(closure="exact", poses=(2.0, 62.0, 60.0), samples=30, nan_policy="raise"))
    with pytest.raises(FrameError, match="no pose has a result for every sample"):
        compute(Inputs(closure="exact", poses=(2.0, 3.0, 1.0), samples=30))


def test_a_modulus_in_the_wrong_unit_is_told_before_it_is_computed() -> None:
    (told,) = beforehand(begin(Inputs(young=200.0)))
    assert "further than the linkage is large (0.4 m)" in told
    assert "and 30 more poses" in told
    assert beforehand(begin(Inputs())) == []


def test_displacements_beyond_the_size_are_told_by_pose() -> None:
    moved = np.array([[0.1, 0.0, 0.0], [3.0, 4.0, 0.0], [np.nan, 0.0, 0.0]])
    (told,) = beyond_size("P", moved, 1.0, ["a", "b", "c"])
    assert told.startswith("P is displaced by up to 5 m at b, further than the linkage is large (1 m)")
    assert beyond_size("P", moved, 5.0, ["a", "b", "c"]) == []
    assert named(list("abcdef")) == "a, b, c, d and 2 more poses"
