"""The four-bar's samples at large displacement: finite where linear mechanics has no number, equal where it has one."""

from __future__ import annotations

import csv

import numpy as np
import pytest
from linkframe.models import FourBar
from linkframe.models.four_bar.displacement import Accuracy, accuracy
from linkframe.models.job.large_table import as_markdown, as_text
from linkframe.models.paper.inputs import Inputs
from linkframe.models.paper.remarks import remarks
from linkframe.models.paper.result import Result, compute
from linkframe.models.paper.table import as_csv
from linkframe.models.paper.table import as_text as table_text
from numpy.typing import NDArray


@pytest.fixture(scope="module")
def result() -> Result:
    return compute(Inputs(samples=40))


def test_all_poses_have_numbers(result: Result) -> None:
    """Millimetres at the singular poses, where the paper prints 1e6 to 1e8 m."""
    assert np.isfinite(result.large.samples).all()
    assert result.large.std[:, :2].max() < 8e-3
    singular = ~result.regular
    assert singular.sum() == 3
    assert result.large.std[singular, 1].min() > 2e-3


def test_equals_the_linear_samples_far_from_singular_poses(result: Result) -> None:
    """To second order in the clearance (1e-3 squared, over 0.1), whose exact displacement is known in closed form.

    The contact's direction turns with the link, in the closed form it does not.
    """
    study = result.study
    pose = int(np.flatnonzero(result.degrees == 90.0)[0])
    exact = study.geometry.samples[pose] + study.compliance.samples[pose] + study.clearance_exact.samples[pose]
    assert result.large.samples[pose] == pytest.approx(exact, abs=2e-5)


@pytest.mark.parametrize("contact", [0.7, "reaction"])
def test_small_clearances_give_the_first_order(contact: float | str) -> None:
    found = accuracy(FourBar(), np.radians([40.0, 100.0]), load=(0.0, 1.0, 0.0), clearance=1e-7, contact=contact)
    assert found.large == pytest.approx(found.total, abs=2e-11)


def test_table_lists_the_poses_that_need_it(result: Result) -> None:
    text = as_text(result)
    listed = [line.split("°")[0].strip() for line in text.splitlines()[1:]]
    assert (
        {"0", "180", "360"} <= set(listed) <= {"0", "10", "20", "160", "170", "180", "190", "200", "340", "350", "360"}
    )
    assert "1.000" not in text
    assert len(as_markdown(result).splitlines()) == len(listed) + 2


def test_every_table_marks_the_poses_that_need_it(result: Result) -> None:
    """No pose is printed as regular in one table and listed as beyond linear mechanics in another."""
    listed = [line.split("°")[0].strip() for line in as_text(result).splitlines()[1:]]
    table = {line.split()[0]: line for line in table_text(result).splitlines()[1:]}
    assert not any(table[pose].endswith("regular") for pose in listed)
    assert all(line.endswith("regular") for pose, line in table.items() if pose not in listed)
    for pose in np.flatnonzero(result.regular):
        true, linear = result.large.samples[pose, :, :2], result.samples[pose, :, :2]
        off = np.abs(linear.mean(axis=0) - true.mean(axis=0)) + np.abs(linear.std(axis=0) - true.std(axis=0))
        assert result.apart[pose] == pytest.approx((off / true.std(axis=0)).max(), rel=0.1)


def test_csv_holds_both_columns(result: Result) -> None:
    rows = list(csv.DictReader(as_csv(result).splitlines()))
    for row, mean, spread in zip(rows, result.rigid + result.large.mean, result.large.std, strict=True):
        assert float(row["large_mu_y_m"]) == mean[1]
        assert float(row["large_sigma_x_m"]) == spread[0]
    assert rows[0]["mu_x_m"] == ""
    assert abs(float(rows[9]["large_mu_y_m"]) - float(rows[9]["mu_y_m"])) < 1e-4


@pytest.mark.parametrize("policy", ["omit", "propagate"])
def test_samples_without_an_equilibrium_are_left_out_and_told(policy: str, monkeypatch: pytest.MonkeyPatch) -> None:
    inputs = Inputs(poses=(30.0, 60.0, 30.0), samples=8, nan_policy=policy)
    whole = compute(inputs)
    assert not any("no equilibrium" in note for note in remarks(whole))
    found = Accuracy.large

    def without_one(self: Accuracy) -> NDArray[np.float64]:
        out = np.array(found.fget(self))  # type: ignore[attr-defined]
        out[1, 3] = np.nan
        return out

    monkeypatch.setattr(Accuracy, "large", property(without_one))
    result = compute(inputs)
    notes = [note for note in remarks(result) if "no equilibrium" in note]
    assert len(notes) == 1
    assert "1 of 2 × 8 samples came to no equilibrium (at θ = 60°)" in notes[0]
    others = np.delete(whole.large.samples[1], 3, axis=0)
    expected = others.std(axis=0, ddof=1) if policy == "omit" else np.full(3, np.nan)
    np.testing.assert_allclose(result.large.std[1], expected, rtol=1e-9)
    np.testing.assert_allclose(result.large.std[0], whole.large.std[0], rtol=1e-9)
