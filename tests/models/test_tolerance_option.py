"""Tolerances on the command line, in words or as distributions, in place of those of a file or of the four-bar."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import scipy
from linkframe.framework.errors import FrameError
from linkframe.models.command_line import main
from linkframe.models.distributions import Interval, Normal
from linkframe.models.given_deviations import Rescaled
from linkframe.models.given_distributions import called
from linkframe.models.linkage.job.inputs import RunInputs, read_inputs
from linkframe.models.linkage.job.report import report as report_of_file
from linkframe.models.linkage.job.result import compute as compute_file
from linkframe.models.paper.inputs import Inputs
from linkframe.models.paper.page import _limits
from linkframe.models.paper.report import _inputs, _summary
from linkframe.models.paper.result import compute
from linkframe.models.paper.study import distributions
from linkframe.models.quantiles import at_scores
from numpy.testing import assert_allclose, assert_array_equal

FILE = Path(__file__).parents[2] / "examples" / "four_bar.toml"
Q = np.array([0.01, 0.3, 0.5, 0.9])


def of_file(*given: tuple[str, str]):
    return read_inputs(FILE, given).tolerances


def few(inputs: RunInputs) -> RunInputs:
    """The same at few poses with few samples."""
    drives = {name: replace(drive, values=drive.values[2:5]) for name, drive in inputs.drives.items()}
    return replace(inputs, drives=drives, samples=6)


def test_words_for_a_tolerance_of_the_file():
    """It goes on to vary the same number, under the same name, so that its samples come from the same stream."""
    found = of_file(("fy", "± 4"))["fy"]
    assert found.of == (("loads", 0, "fy"),)
    assert found.distribution == Interval(96.0, 104.0)
    share = of_file(("stiffness.B", "± 5 % normal"))["stiffness.B"]
    assert share.relative
    assert share.distribution == Normal(0.0, 0.05 / 3.0)
    assert of_file(("fy", "+6/-3 normal"))["fy"].distribution == Normal(101.5, 1.5)
    assert list(of_file(("fy", "± 4"))) == list(of_file())


def test_normal_tolerances_do_not_load_all_distributions(monkeypatch):
    """To load `scipy.stats` takes longer than most jobs."""
    monkeypatch.delattr(scipy, "stats", raising=False)
    monkeypatch.setitem(sys.modules, "scipy.stats", None)
    assert isinstance(of_file(("fy", "norm(100, 3)"))["fy"].distribution, Normal)


def test_a_number_leaves_the_tolerance_that_it_was_in():
    before, after = of_file(), of_file(("joints.B.clearance", "5 %"))
    assert set(before) - set(after) == {"clearance.B"}
    assert set(after) - set(before) == {"joints.B.clearance"}
    found = after["joints.B.clearance"]
    assert (found.of, found.relative) == ((("joints", "B", "clearance"),), True)


def test_one_of_several_numbers_leaves_the_others(tmp_path):
    text = FILE.read_text(encoding="utf-8")
    shared = text.replace('of = ["joints.B.clearance"]', 'of = ["joints.B.clearance", "points.P.x"]')
    path = tmp_path / "shared.toml"
    path.write_text(shared.replace("loc = 1e-3\nscale = 5e-5", 'scale = "5 %"'), "utf-8")
    found = read_inputs(path, [("points.P.x", "± 1e-4")]).tolerances
    assert found["clearance.B"].of == (("joints", "B", "clearance"),)
    assert found["points.P.x"].of == (("points", "P", 0),)


def test_a_distribution_as_in_the_file_gives_its_bits():
    """And the report says so."""
    inputs = few(read_inputs(FILE))
    again = few(read_inputs(FILE, [("fy", "norm(100, scale=5)"), ("clearance.D", "norm(loc=1e-3,scale=5e-5)")]))
    wanted, found = (compute_file(each) for each in (inputs, again))
    assert_array_equal(found.displacement, wanted.displacement)
    other = few(read_inputs(FILE, [("fy", "5 %")]))
    assert "| fy | 5 % | of each number | loads.0.fy |" in report_of_file(compute_file(other)).text({}, [], {})


def test_a_file_may_have_words(tmp_path):
    text = FILE.read_text(encoding="utf-8").partition("[tolerances")[0]
    path = tmp_path / "words.toml"
    words = '[tolerances]\n"joints.B.clearance" = "± 5 %"\n"loads.0.fy" = 5.0\n'
    table = '[tolerances.springs]\nof = ["joints.B.stiffness", "joints.D.stiffness"]\ntolerance = "± 2 %"\n'
    path.write_text(text + words + table, encoding="utf-8")
    found = read_inputs(path).tolerances
    assert found["loads.0.fy"].distribution == Interval(95.0, 105.0)
    assert found["joints.B.clearance"].distribution == found["springs"].distribution.__class__(-0.05, 0.05)
    assert len(found["springs"].nominal) == 10
    words = '[tolerances]\n"loads.0.fy" = "norm(100, 5)"\n"joints.B.clearance" = "norm(scale=5 %)"\n'
    path.write_text(text + words, encoding="utf-8")
    found = read_inputs(path).tolerances
    assert found["loads.0.fy"].distribution == Normal(100.0, 5.0)
    assert found["joints.B.clearance"].distribution == Normal(0.0, 0.05)
    assert found["joints.B.clearance"].relative
    path.write_text(text + '[tolerances]\n"loads.0.fy" = "about 5"\n', encoding="utf-8")
    with pytest.raises(FrameError, match=r"words.toml, line \d+, tolerances.loads.0.fy: .*write it as"):
        read_inputs(path)
    path.write_text(text + '[tolerances]\n"loads.0.fy" = "norm(1, 2, 3)"\n', encoding="utf-8")
    with pytest.raises(FrameError, match=r"words.toml, line \d+, tolerances.loads.0.fy: .*one more number: 3"):
        read_inputs(path)


@pytest.mark.parametrize(
    ("given", "told"),
    [
        (("nothing", "± 1"), r"with --tolerance nothing=± 1: there is no 'nothing' in this file"),
        (("fy", "a bit"), r"with --tolerance fy=a bit: .* write it as"),
        (("fy", "norm(100, 5, 3)"), r"with --tolerance fy=.*norm takes loc, scale, and there is one more number: 3"),
        (("fy", "norm(100, wide)"), r"'wide' is no number"),
        (("fy", "nrom(100, 5)"), r"no distribution 'nrom': give a continuous one"),
        (("fy", "norm(200, 5)"), r"with --tolerance fy=norm\(200, 5\): .*has the mean 200"),
        (("joints.B.stiffness.ux", "5 %"), r"joints.B.stiffness.ux is in tolerance 'stiffness.B', too"),
    ],
)
def test_what_is_no_tolerance_of_the_file(given, told):
    with pytest.raises(FrameError, match=told):
        read_inputs(FILE, [given])


def test_calls():
    assert called("beta(2, 3, loc=1, scale=0.5)") == ("beta", {"a": 2.0, "b": 3.0, "loc": 1.0, "scale": 0.5})
    assert called("norm( scale = 5 % )") == ("norm", {"scale": "5 %"})
    assert called("± 5 %") is None


# -- the four-bar -----------------------------------------------------------------------------------------------------


def laws(*given: tuple[str, str], **more):
    inputs = Inputs(tolerance=given, **more)
    return distributions(inputs, inputs.to_radius)


def same(found, wanted, rtol=0.0):
    assert found.keys() == wanted.keys()
    for name, law in wanted.items():
        assert_allclose(found[name].ppf(Q), law.ppf(Q), rtol=rtol)


@pytest.mark.parametrize(
    ("name", "text", "more", "rtol"),
    [
        ("load", "norm(100, 5)", {}, 0.0),
        ("loads.0.fy", "± 15 normal", {}, 1e-15),
        ("clearance", "norm(scale=5 %)", {}, 1e-15),
        ("clearance", "norm(1e-3, 5e-5)", {"clearance_is": "diameter"}, 1e-15),
        ("clearance", "15 % normal", {"joints": "shared"}, 1e-15),
        ("joints.D.stiffness", "norm(2e11, 1e10)", {}, 0.0),
        ("contact", "norm(180, 180)", {}, 1e-12),
        ("contact.E", "norm(scale=100 %)", {}, 1e-12),
    ],
)
def test_words_for_what_options_give(name, text, more, rtol):
    """The same laws as by default."""
    same(laws((name, text), **more), laws(**more), rtol)


@pytest.mark.parametrize(
    "text", ["± 5", "5", "+/- 5", "5 normal", "± 5 %", "+/- 5 %", "5 % normal", "+6/-3", "+6/-3 normal", "100 ± 5",
             "norm(100, 5)", "norm(scale=5 %)", "norm(1 %, 5 %)", "uniform(95, 10)", "triang(0.5, -5 %, 10 %)"]
)  # fmt: skip
def test_the_file_and_the_four_bar_read_the_same(text):
    """The load of both is 100 N; a number alone is a half width."""
    of_load, of_job = of_file(("fy", text))["fy"], laws(("load", text))["fy"]
    draws = of_load.samples(("loads", 0, "fy"), of_load.distribution.ppf(Q))
    assert_allclose(of_job.ppf(Q), draws, rtol=1e-15)


@pytest.mark.parametrize("text", ["norm(1 %, 5 %)", "uniform(-2 %, 8 %)", "triang(0.3, -5 %, 10 %)"])
def test_a_share_of_a_negative_number_points_the_same_way_in_both_jobs(tmp_path, text):
    """1 % of -100 N is -1 N: the load is a hundredth longer. A quantile function rises all the same."""
    path = tmp_path / "down.toml"
    path.write_text(FILE.read_text(encoding="utf-8").replace("fy = 100.0", "fy = -100.0"), encoding="utf-8")
    of_load = read_inputs(path, [("fy", text)]).tolerances["fy"]
    of_job = laws(("load", text), load=-100.0)["fy"]
    draws = of_load.samples(("loads", 0, "fy"), of_load.distribution.ppf(1.0 - Q))
    assert_allclose(of_job.ppf(Q), draws, rtol=1e-13)
    assert np.all(np.diff(of_job.ppf(Q)) > 0.0)


@pytest.mark.parametrize("text", ["+6/-3 %", "+6 %/-3 %", "+6 % -3 %", "200 +6/-3 %", "200 +6 % / -3 %"])
def test_a_sign_of_percent_behind_two_limits_is_that_of_both(text):
    assert laws(("load", text), load=200.0)["fy"] == Interval(194.0, 212.0)


@pytest.mark.parametrize("order", [1, -1])
def test_a_tolerance_of_one_joint_rules_over_that_of_all(order):
    """In whatever order they stand on the command line."""
    found = laws(*(("clearance", "± 1e-4"), ("clearance.B", "± 2e-4"))[::order])
    assert found["clearance.B"].ppf(np.array(1.0)) == pytest.approx(1.2e-3, rel=1e-12)
    assert found["clearance.D"].ppf(np.array(1.0)) == pytest.approx(1.1e-3, rel=1e-12)


def test_the_nominal_value_may_lie_at_a_limit_of_a_distribution():
    """But not outside it, however near."""
    assert laws(("load", "uniform(100, 10)"))["fy"] == Interval(100.0, 110.0)
    rounded = float(np.nextafter(100.0, 101.0))  # a limit as arithmetic leaves it
    assert laws(("load", f"uniform({rounded!r}, 10)"))["fy"].low == rounded
    with pytest.raises(FrameError, match=r"has the mean 106 and spreads by 2\.88675, but load is 100"):
        laws(("load", "uniform(101, 10)"))


def test_what_has_no_tolerance_by_default():
    found = laws(("young", "± 5 %"), ("young.crank", "± 1e9"), ("fx", "± 3"), ("drive", "± 0.1"), ("ktx.B", "10 %"))
    assert found["E.rocker"] == Interval(1.9e11, 2.1e11)
    assert found["E.crank"] == Interval(1.99e11, 2.01e11)
    assert found["fx"] == Interval(-3.0, 3.0)
    assert_allclose(found["drive"].ppf(np.array([0.0, 1.0])), np.radians([-0.1, 0.1]), rtol=1e-15)
    assert_allclose(found["ktx.B"].ppf(np.array([0.0, 1.0])), [1.8e11, 2.2e11], rtol=1e-15)


def test_the_job_samples_them():
    """Uniform within the limits, and said in the report."""
    at = np.radians(60.0)
    inputs = Inputs(
        poses=(60.0, 60.0, 1.0), samples=400, sampler="lhs", clearance=0.0, clearance_sd=0.0, load_sd=0.0,
        stiffness_sd=0.0, tolerance=(("crank", "± 1e-4"),),
    )  # fmt: skip
    result = compute(inputs, large=False)
    lengths = result.draws["crank"]
    assert 0.0999 < lengths.min() < 0.09991 < 0.10009 < lengths.max() < 0.1001
    # P lies half way from B, which moves along the crank, to D, which moves across the rocker and as far along x.
    way = 0.5 * np.array([2 * np.cos(at), np.sin(at) - np.cos(at) ** 2 / np.sin(at)])
    assert_allclose(result.study.geometry.std[0, :2], way * 1e-4 / np.sqrt(3.0), rtol=0.01)
    assert "| tolerance | crank ± 1e-4 |" in _inputs(result)
    assert any("| geometry |" in paragraph for paragraph in _summary(result))
    other = compute(Inputs(poses=(60.0, 60.0, 1.0), samples=4), large=False)
    assert "| tolerance |" not in _inputs(other)
    assert not any("| geometry |" in paragraph for paragraph in _summary(other))


def test_the_page_goes_to_their_limits():
    clearances, lengths = _limits(Inputs(tolerance=(("clearance.B", "± 1e-4"), ("crank", "+2e-5/-1e-5"))))
    assert_allclose([clearances["B"], clearances["D"], lengths["crank"]], [1.1e-3, 1.15e-3, 2e-5], rtol=1e-9)
    assert list(lengths) == ["crank"]


def test_contact_that_follows_from_forces_has_none():
    inputs = Inputs(tolerance=(("contact", "± 5"), ("load", "± 5")))
    assert inputs.but(contact="reaction").tolerance == (("load", "± 5"),)
    with pytest.raises(FrameError, match="--tolerance contact beside --contact reaction: the angle follows"):
        laws(("contact", "± 5"), contact="reaction")


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["length=± 1"], "the four-bar has no number of that name; give one of crank"),
        (["clearance=a bit"], "--tolerance clearance=a bit: "),
        (["fx=5 %"], "of a nominal value of zero"),
        (["load=poisson(3)"], "there is no distribution 'poisson'"),
        (["load=norm(100, scale=5 %)"], "--tolerance load=norm(100, scale=5 %): loc is 100 beside scale in percent"),
        (["clearance.B=norm(1, 0.2)"], "but clearance.B is 0.001: give it the value about which it spreads"),
        (["clearance.B=norm(1, 2)"], "--tolerance clearance.B=norm(1, 2): samples would go below zero, one in a mill"),
        (["clearance=± 2e-3"], "below zero, one in a million to -0.000999996: give a narrower"),
        (["clearance=beta(2, 3)"], "beta has no scale: give one"),
        (["clearance=norm(± 5 %)"], "loc is '± 5 %': give a number"),
        (["load=norm(100, loc=90, scale=5)"], "loc is given twice"),
        (["load=norm(100, 5, wide=3)"], "norm does not take wide: it takes loc, scale"),
        (["load=norm(2 %, 5)"], "--tolerance load=norm(2 %, 5): scale is 5 beside loc in percent"),
        (["load=+5 %"], "tolerance '+5 %': write it as"),
        (["load=-5 %"], "tolerance '-5 %': write it as"),
        (["load=+6 %/-3"], "tolerance '+6 %/-3' has one limit in percent"),
        (["young=norm(scale=40 %)"], "samples would go below zero, one in a million"),
    ],
)
def test_what_is_no_tolerance_of_the_four_bar(words, told, tmp_path, capsys):
    assert main(["four-bar", "--samples", "4", "--out", str(tmp_path / "out"), "--tolerance", *words]) == 2
    assert told in capsys.readouterr().err
    with pytest.raises(SystemExit):
        main(["four-bar", "--tolerance", "clearance"])
    assert "is 'clearance': give NAME=VALUE" in capsys.readouterr().err


@pytest.mark.parametrize("factor", [2.0, -2.0])
def test_a_rescaled_distribution_keeps_both_tails(factor):
    """Gumbel's quantile in closed form, -log(-log(p)), out to probabilities of 2e-33 on either side."""
    p = scipy.stats.norm.cdf(-12.0)
    low, high = -np.log(-np.log(p)), -np.log(-np.log1p(-p))
    ends = sorted((1.0 + factor * low, 1.0 + factor * high))
    assert_allclose(at_scores(Rescaled(scipy.stats.gumbel_r(), factor, 1.0), np.array([-12.0, 12.0])), ends, rtol=1e-13)


def test_a_rescaled_distribution_without_an_upper_tail_has_none():
    class Quantiles:
        def ppf(self, q):
            return q**2

    assert not hasattr(Rescaled(Quantiles(), -2.0), "isf")
    assert_allclose(Rescaled(Quantiles(), -2.0, 1.0).ppf(Q), 1.0 - 2.0 * (1.0 - Q) ** 2, rtol=1e-15)
