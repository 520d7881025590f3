"""The sampler on the command line: of the four-bar's job, and in place of what a file says."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from linkframe.framework.errors import FrameError
from linkframe.models.command_line import main
from linkframe.models.linkage.job.inputs import read_inputs
from linkframe.models.paper.inputs import Inputs
from linkframe.models.paper.report import report
from linkframe.models.paper.result import compute
from linkframe.models.sampling import SAMPLERS, draw
from numpy.testing import assert_allclose, assert_array_equal
from scipy import stats

EXAMPLE = Path(__file__).parents[2] / "examples" / "four_bar.toml"
FEW = {"poses": (30.0, 30.0, 1.0), "samples": 16}


@pytest.mark.parametrize("sampler", SAMPLERS)
def test_the_four_bar_draws_as_it_is_told(sampler):
    result = compute(Inputs(**FEW, sampler=sampler), large=False)
    forces = result.study.inputs["fy"]
    assert len(forces) == 16
    if sampler in ("lhs", "sobol"):
        # One force in each of sixteen intervals of equal probability.
        assert_array_equal(np.sort(np.floor(16 * stats.norm(100.0, 5.0).cdf(forces))), np.arange(16))


def test_the_report_says_so():
    result = compute(Inputs(**FEW, sampler="sobol"))
    assert "16 samples (Sobol sequence), seed 0" in report(result).text({}, [], {})


def test_a_file_is_run_with_another_sampler():
    inputs = read_inputs(EXAMPLE)
    found = inputs.drawn_by("halton")
    assert found.sampler == "halton"
    (_, chosen), *_ = found.chosen(0, 50)
    assert chosen.sampler == "halton"
    drawn = draw(chosen.distributions, chosen.samples, chosen.rng, chosen.sampler)
    for name, law in chosen.distributions.items():
        assert_allclose(drawn[name].mean(), law.ppf(0.5), atol=0.5 * float(law.ppf(0.84) - law.ppf(0.16)))


def test_a_sampler_without_samples_is_refused(tmp_path):
    text = EXAMPLE.read_text(encoding="utf-8").partition("[tolerances")[0]
    lines = [line for line in text.splitlines() if not line.startswith(("samples", "rng", "sampler", "nan_policy"))]
    path = tmp_path / "plain.toml"
    path.write_text("\n".join(lines), encoding="utf-8")
    with pytest.raises(FrameError, match="--sampler sobol has no effect, as the file has no tolerances"):
        read_inputs(path).drawn_by("sobol")


def test_an_unknown_sampler_is_refused(capsys):
    for command in (["four-bar"], ["run", str(EXAMPLE)]):
        with pytest.raises(SystemExit):
            main([*command, "--sampler", "grid"])
        assert "invalid choice: 'grid'" in capsys.readouterr().err
