"""Contributors as ranked bars, and how an estimate settles with the number of samples."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from linkframe.framework import FrameError
from linkframe.models import Contributors, Propagation, propagate
from numpy.testing import assert_allclose
from scipy import stats


def bars(axes: Any) -> dict[str, list[tuple[str, float]]]:
    """By kind the name and length of each bar, from above."""
    names = [label.get_text() for label in axes.get_yticklabels()]
    return {
        each.get_label(): [(name, bar.get_width()) for name, bar in zip(names, each, strict=True)]
        for each in axes.containers
        if len(each) == len(names)
    }


def test_contributors_are_ranked_bars_of_both_shares() -> None:
    reach = np.array([[1.0, 1.0, 2.0, 1.0], [3e-4, 1e-4, 4e-4, 2e-4]]) * [[1e-4], [1.0]]
    found = Contributors(("a", "$b$", "c", "d"), reach, reach**2 / 3.0)
    axes = found.plot()
    assert axes.get_title(loc="left") == "pose 1: worst case 1 mm, σ = 316.2 µm"
    assert [name for name, _ in bars(axes)["worst case"]] == ["c", "a", "d", "$b$"]
    assert_allclose([share for _, share in bars(axes)["worst case"]], [40.0, 30.0, 20.0, 10.0])
    assert_allclose([share for _, share in bars(axes)["variance"]], np.array([16.0, 9.0, 4.0, 1.0]) / 0.3)
    few = bars(found.plot(entry=0, most=1))
    assert few["worst case"] == [("c", pytest.approx(40.0)), ("3 others", pytest.approx(60.0))]
    with pytest.raises(FrameError, match="pose"):
        Contributors(("a",), np.full((2, 1), np.nan), np.full((2, 1), np.nan)).plot(entry=0)


def result(**options: Any) -> Propagation:
    def fn(x: Any, y: Any) -> Any:
        return np.stack([x + 2.0 * y, np.where(x > 1.0, np.nan, x)], axis=-1)

    return propagate(fn, {"x": stats.norm(), "y": stats.norm()}, n=512, rng=0, nan_policy="omit", **options)


@pytest.mark.filterwarnings("ignore::linkframe.framework.errors.SampleWarning")
def test_an_estimate_settles_as_the_first_samples_have_it() -> None:
    found = result()
    axes: Any = found.plot("convergence", entry=0, label="u", unit="mm")
    line = next(each for each in axes.lines if each.get_label() == "mean")
    for count, value in line.get_xydata()[[5, 40, -1]]:
        assert value == pytest.approx(np.mean(found.samples[: int(count), 0]), rel=1e-12)
    assert line.get_xdata()[-1] == 512
    corners = axes.collections[0].get_paths()[0].vertices
    last = corners[corners[:, 0] == 512.0][:, 1]
    assert_allclose([last.min(), last.max()], found.mean[0] + found.standard_error[0] * np.array([-1.0, 1.0]))
    assert axes.get_ylabel() == "mean of u [mm]"
    quantile = found.plot("convergence", entry=0, of=0.9)
    value = next(each for each in quantile.lines if each.get_label() == "0.9 quantile").get_ydata()[-1]
    assert value == pytest.approx(found.quantile(0.9)[0])
    told = found.plot("convergence", entry=1, of="std").get_title(loc="left")
    assert f"{found.missing[1]} samples failed and are left out" in told


@pytest.mark.filterwarnings("ignore::linkframe.framework.errors.SampleWarning")
def test_a_result_draws_its_histogram_and_refuses_what_it_cannot() -> None:
    found = result()
    assert "σ = " in found.plot(entry=0, unit="m").get_title(loc="left")
    for wrong, told in (
        ({"what": "bars"}, "choose one of histogram, convergence"),
        ({}, r"the result has shape \(2,\): choose an entry"),
        ({"entry": 2}, "give one index"),
        ({"what": "convergence", "entry": 0, "of": "median"}, "choose 'mean', 'std' or the probability"),
    ):
        with pytest.raises(FrameError, match=told):
            found.plot(**wrong)
    with pytest.raises(FrameError, match="were not kept"):
        result(keep_samples=False).plot(entry=0)
    sequence = propagate(lambda x: x, {"x": stats.norm()}, n=256, rng=0, sampler="sobol").plot("convergence")
    assert "those of a sequence do better" in " ".join(sequence.get_title(loc="left").split())


def test_sobol_indices_are_bars_with_their_errors() -> None:
    found = propagate(lambda a, b: a + 2.0 * b, {"a": stats.norm(), "b": stats.norm()}, n=256, rng=0).sobol
    axes = found.plot()
    assert [name for name, _ in bars(axes)["total"]] == ["b", "a"]
    assert_allclose([share for _, share in bars(axes)["total"]], 100.0 * found.total[::-1])
