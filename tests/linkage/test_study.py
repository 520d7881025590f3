"""A study of a linkage in one call: closed forms, the numbers of ``linkframe run``, workers, tables, and errors."""

from __future__ import annotations

import pickle
import sys
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from linkframe.elements import Beam, Material, Rectangle
from linkframe.framework import FrameError
from linkframe.models import AccuracyStudy, Linkage, read_linkage, write_linkage
from linkframe.models.linkage.job.inputs import read_inputs
from linkframe.models.linkage.job.result import compute
from numpy.testing import assert_allclose, assert_array_equal
from scipy import stats

BAR = Beam(Rectangle(y=0.02, z=0.01), Material(E=200e9, nu=0.3))
TOLERANCES = """
[tolerances.stiff]
of = ["joints.B.stiffness"]
distribution = "norm"
scale = "5 %"

[tolerances."points.C.x"]
of = ["points.C.x"]
distribution = "norm"
loc = 0.4
scale = 1e-5

[run]
points = ["C", "B"]
samples = 40
rng = 3

[run.drives.A]
values = [0.3, 0.9, 2.0]
"""


def arm(**clearance: float) -> Linkage:
    linkage = Linkage(A=(0, 0), B=(2, 0))
    linkage.link("arm", "A", "B")
    linkage.revolute("A", "ground", "arm", drive=True, **clearance)
    return linkage


def four_bar() -> Linkage:
    linkage = Linkage(A=(0, 0), B=(0.1, 0.05), C=(0.4, 0.2), D=(0.35, 0))
    for name, ends in {"crank": "AB", "coupler": "BC", "rocker": "CD"}.items():
        linkage.link(name, *ends, beam=BAR)
    linkage.revolute("A", "ground", "crank", drive=True)
    linkage.revolute("B", "crank", "coupler", stiffness=(2e9,) * 5 + (0.0,))
    linkage.revolute("C", "coupler", "rocker", clearance=2e-5, contact=0.4)
    linkage.revolute("D", "rocker", "ground")
    linkage.load("C", fy=-50.0)
    return linkage


def crank_rocker() -> Linkage:
    linkage = Linkage(A=(0, 0), B=(0.1, 0), C=(0.4, 0.2), D=(0.3, 0))
    for name, ends in {"crank": "AB", "coupler": "BC", "rocker": "CD"}.items():
        linkage.link(name, *ends)
    for pin, links in {"A": ("ground", "crank"), "B": ("crank", "coupler"), "C": ("coupler", "rocker")}.items():
        linkage.revolute(pin, *links, drive=pin == "A")
    linkage.revolute("D", "rocker", "ground")
    return linkage


def test_arm_in_closed_form() -> None:
    """Its end is off by clearance e along x and by a share of its length: mean, deviation, worst case, probability."""
    e, half, angle = 2e-4, 1e-4, np.array([0.0, 1.0])
    found = arm(clearance=e, contact=0.0).study(
        {"points.B.x": half}, "B", {"A": angle}, n=4096, rng=0, sampler="sobol", progress=False
    )
    way = np.stack([np.cos(angle), np.sin(angle), 0.0 * angle], axis=-1)
    assert_allclose(found.position[0], 2.0 * way, atol=1e-15)
    assert_allclose(found.clearance[0, :, 0], e, rtol=1e-12)
    assert_allclose(found.mean[0], [[e, 0, 0]] * 2, atol=1e-7 * half)
    assert_allclose(found.std[0], half / np.sqrt(3.0) * np.abs(way), rtol=1e-3, atol=1e-18)
    assert_allclose(found.greatest[0], e + half, rtol=1e-9)
    # Along the worst direction the segment has the variance h²/3, the disc e²/4.
    shares = found.contributors["B"]
    assert shares.names == ("joint A", "points.B.x")
    assert_allclose(shares.variance[:, 1], half**2 / 3.0, rtol=1e-6)
    assert_allclose(shares.variance[:, 0], e**2 / 4.0, rtol=1e-9)
    # |e x + t way| > r in the first pose where t > r - e: with t even in (-h, h) half of that beyond h / 2.
    assert_allclose(found.probability(e + 0.5 * half)[0, 0], 0.25, atol=1e-3)
    low, high = found.probability_interval(e + 0.5 * half)
    expected = stats.binomtest(round(4096 * float(found.probability(e + 0.5 * half)[0, 0])), 4096).proportion_ci(0.95)
    assert_allclose([low[0, 0], high[0, 0]], [expected.low, expected.high], rtol=1e-9)
    assert_array_equal(found.probability_interval(1.0).low[0], 0.0)
    assert "points.B.x" in repr(found)


def test_same_numbers_as_the_job(tmp_path: Path) -> None:
    """Tolerances by tables as in the file give the bits of ``linkframe run``."""
    linkage, path = four_bar(), tmp_path / "four.toml"
    write_linkage(linkage, path)
    path.write_text(path.read_text() + TOLERANCES)
    job = compute(read_inputs(path))
    given: dict[str, Any] = {
        "stiff": {"of": ["joints.B.stiffness"], "distribution": "norm", "scale": "5 %"},
        "points.C.x": stats.norm(0.4, 1e-5),
    }
    drives = {"A": np.array([0.3, 0.9, 2.0])}
    found = read_linkage(path).study(given, ["C", "B"], drives, n=40, rng=3, progress=False)
    assert job.displacement is not None
    assert_array_equal(found.propagation.samples, job.displacement)
    assert_array_equal(found.std[0], job.spread["C"].std)
    assert_array_equal(found.compliance[1], job.accuracy["B"].compliance[..., :3])


def test_samples_stay_within_the_worst_case() -> None:
    """Links of a four-bar by ±, to first order, and their corners reach what the worst case says."""
    given = {"points.C.x": "± 1e-6", "points.B.y": (-1e-6, 2e-6), "points.D.x": "+0.000001/-0.000001"}
    drives = {"A": np.linspace(0.2, 6.0, 5)}
    found = crank_rocker().study(given, "C", drives, n=512, rng=1, sampler="halton", progress=False)
    off = np.linalg.norm(found.propagation.samples[:, 0], axis=-1)
    assert (off < found.greatest[0] * 1.0001).all()
    assert (off.max(axis=0) > 0.8 * found.greatest[0]).all()
    # The greatest share of the deviations in one direction is their sum, as every corner has it.
    shares = found.contributors["C"]
    assert_allclose(shares.worst.sum(axis=-1), 100.0)
    along = np.sum(found.propagation.samples[:, 0] * found.worst_case["C"].direction, axis=-1)
    assert_allclose(np.sqrt(shares.variance.sum(axis=-1)), along.std(axis=0), rtol=0.05)


def pickled(task: Callable[[object], object], cuts: Iterable[object]) -> Iterable[object]:
    """What another process would compute, in another order."""
    return [pickle.loads(pickle.dumps(task))(cut) for cut in reversed(list(cuts))]


def test_workers_and_checkpoint_give_the_same_bits(tmp_path: Path) -> None:
    linkage, options = arm(), {"n": 5000, "rng": 7, "progress": False}
    first = linkage.study({"points.B.x": 1e-4}, "B", {"A": 0.3}, **options)
    again = linkage.study({"points.B.x": 1e-4}, "B", {"A": 0.3}, **options, workers=pickled)
    assert_array_equal(again.propagation.samples, first.propagation.samples)
    for _ in range(2):
        kept = linkage.study({"points.B.x": 1e-4}, "B", {"A": 0.3}, **options, checkpoint=tmp_path / "c")
        assert_array_equal(kept.std, first.std)


class Table(dict[str, Any]):
    """In place of a data frame."""


def test_tables_with_named_dimensions(monkeypatch: pytest.MonkeyPatch) -> None:
    found = four_bar().study({"loads.0.fy": "± 5 %"}, ["C", "B"], {"A": [0.3, 0.9, 2.0]}, n=8, rng=0, progress=False)
    monkeypatch.setitem(sys.modules, "pandas", SimpleNamespace(DataFrame=Table))
    monkeypatch.setitem(sys.modules, "xarray", SimpleNamespace(Dataset=lambda data, coords: (data, coords)))
    frame = found.to_dataframe()
    assert {len(column) for column in frame.values()} == {6}
    assert list(frame["point"]) == ["C"] * 3 + ["B"] * 3
    assert_array_equal(frame["A"], [0.3, 0.9, 2.0] * 2)
    assert_array_equal(frame["std_y"], found.std[..., 1].ravel())
    data, coords = found.to_xarray()
    sizes = {name: len(values) for name, values in coords.items() if not isinstance(values, tuple)}
    sizes["sample"] = 8
    for dims, values in data.values():
        assert np.shape(values) == tuple(sizes[dim] for dim in dims)
    assert set(data) >= {"mean", "std", "worst_case", "worst_case_share", "sample_displacement", "status"}


def test_missing_table_library_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    found = arm().study({"points.B.x": 1e-4}, "B", n=8, rng=0, progress=False)
    for name, method in (("pandas", found.to_dataframe), ("xarray", found.to_xarray)):
        monkeypatch.setitem(sys.modules, name, None)
        with pytest.raises(FrameError, match=f"{name}, which is not installed"):
            method()


def study_of(given: Mapping[str, Any]) -> AccuracyStudy:
    return arm(clearance=1e-4).study(given, "B", n=8, rng=0, progress=False)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({}, r"for tolerances: give a mapping"),
        ({"joints.A.gap": 1.0}, r"study, tolerances\.joints\.A\.gap: there is no 'joints\.A\.gap' in this file"),
        ({"points.B.x": "much"}, r"'points\.B\.x' is 'much': write it as"),
        ({"points.B.x": (5.0, 6.0)}, r"study, tolerances\.points\.B\.x: .* has the mean 5\.5"),
        ({"points.B.x": 1e-4, "t": {"of": ["points.B.x"], "distribution": "norm", "scale": "1 %"}}, r"too: let one"),
        ({"t": {"of": ["points.B.x"]}}, r"study, tolerances\.t: give a table with of, distribution"),
    ],
)
def test_wrong_tolerances_are_named(given: Mapping[str, Any], message: str) -> None:
    with pytest.raises(FrameError, match=message):
        study_of(given)


def test_what_cannot_be_studied_is_refused() -> None:
    many = Linkage(A=(0, 0), B=np.array([[2.0, 0.0], [3.0, 0.0]]))
    many.link("arm", "A", "B")
    many.revolute("A", "ground", "arm", drive=True)
    with pytest.raises(FrameError, match=r"list of shape \(2,\) stands where one number is needed"):
        many.study({"points.A.x": 1e-4}, "B", n=8)
    with pytest.raises(FrameError, match=r"motion of shape \(2, 1\): give"):
        arm().study({"points.B.x": 1e-4}, "B", {"A": [[0.1], [0.2]]}, n=8)
    with pytest.raises(FrameError, match="no point: give"):
        arm().study({"points.B.x": 1e-4}, [], n=8)
    with pytest.raises(FrameError, match="radius of the zone"):
        study_of({"joints.A.clearance": "± 5 %"}).probability(0.0)


def test_a_clearance_counts_once_beside_the_load_that_turns_its_contact() -> None:
    """A stiff arm whose pin lies where the load presses it: in any direction it lies within its clearance."""
    linkage = Linkage(A=(0, 0), P=(0.2, 0))
    linkage.link("arm", "A", "P", beam=Beam(Rectangle(y=0.05, z=0.05), Material(E=200e9, nu=0.3)))
    linkage.revolute("A", "ground", "arm", drive=True, stiffness=(*[1e12] * 5, np.inf), clearance=1e-4)
    linkage.load("P", fx=1.0, fy=100.0)
    found = linkage.study({"loads.0.fx": 50.0}, "P", {"A": [0.0]}, n=256, rng=0, progress=False)
    assert_allclose(found.greatest, 1e-4, rtol=2e-3)
    assert found.contributors["P"].ranked[0] == "joint A"
    off = np.linalg.norm(found.propagation.samples - found.compliance, axis=-1)
    assert off.max() < float(found.greatest[0, 0]) * (1.0 + 1e-9)
    # The load by itself turns the contact, which is where it is at nominal clearance.
    assert_allclose(found.parts["load"].greatest, 5e-5, rtol=2e-3)


@pytest.mark.parametrize("number", ["springs.0.length", "springs.0.damping", "materials.material1.density"])
def test_what_decides_a_force_is_load(number: str) -> None:
    """A spring's free length, a damper and the density of what weighs: none is a dimension or resists."""
    linkage = Linkage(A=(0, 0), B=(2, 0), C=(1.5, 1))
    linkage.link("arm", "A", "B", beam=Beam(BAR.section, Material(E=200e9, nu=0.3, density=7850.0)))
    linkage.revolute("A", "ground", "arm", drive=True)
    linkage.spring("B", ("ground", "C"), stiffness=50.0, length=0.3, damping=2.0)
    linkage.gravity((0, -9.81))
    found = linkage.study({number: "± 1 %"}, "B", {"A": [0.2]}, rates={"A": [1.0]}, n=8, rng=0, progress=False)
    assert list(found.parts) == ["load", "together"]
