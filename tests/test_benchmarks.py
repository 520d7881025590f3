"""Every benchmark at a tiny size: what it measures as error is asserted, and no time is."""

from __future__ import annotations

import csv
import json
import os
import subprocess
import sys
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from benchmarks import (
    clearances,
    everything_random,
    harness,
    kinematics,
    one_frame,
    paper_job,
    programs,
    reliability,
    run,
    samples,
    segments,
    size,
    start_up,
    straight_c,
    work_precision,
)
from benchmarks.fifty_digits import displacements
from benchmarks.job import error, job
from benchmarks.monte_carlo import INPUTS, displacement, mean
from benchmarks.stacked import Stacked
from numpy.testing import assert_allclose
from reference.four_bar import coordinates, four_bar
from reference.stiffness_method import solve

SAMPLES = 2


@pytest.mark.parametrize("load", [(3.0, 100.0, 0.0, 0.0, 0.0, 0.5), (3.0, 100.0, 20.0, 1.0, 2.0, 0.5)])
def test_sparse_fifty_digits_are_those_of_the_dense_reference(load: tuple[float, ...]) -> None:
    structure = four_bar(coordinates(40.0), load)
    exact = solve(structure).displacement
    for name, found in displacements(structure).items():
        assert_allclose(found, exact[name].astype(np.float64), rtol=1e-15, atol=1e-30)


@pytest.mark.parametrize("space", [False, True])
def test_everybody_solves_the_same_job(space: bool) -> None:
    """To the rounding of the usual assembly, which linkframe undercuts by four decades."""
    work = job(7, SAMPLES, space=space)
    exact = np.array([[work.truth(pose, sample) for sample in range(SAMPLES)] for pose in range(7)])
    ways = paper_job.ways(plane=not space)
    errors = {name: float(error(way(work)(), exact).max()) for name, way in ways.items()}
    assert errors[paper_job.OURS] < 1e-12
    assert all(
        errors[paper_job.OURS] < 1e-3 * value < 1e-3 * 1e-6 for name, value in errors.items() if "link" not in name
    )


@pytest.mark.parametrize("name", programs.WANTED)
def test_back_ends_agree(name: str) -> None:
    """NumPy and, where it is installed, machine code, on a batch that is long enough for it.

    They differ where the processor's matrix product adds in another order, and by more of a displacement where its
    terms cancel, which their bounds tell.
    """
    rows = programs.compared(name, programs.cases()[name], 2, 100, 1)
    assert {row["back end"] for row in rows} == set(programs.backends())
    assert all(row["of bounds"] <= 1.0 and row["difference"] < 1e-12 for row in rows)


def test_in_plane_matrix_is_part_of_the_whole() -> None:
    work = job(3, SAMPLES, space=False)
    assert_allclose(Stacked(work, plane=True).solve(), Stacked(work).solve(), rtol=1e-6, atol=1e-15)


def test_linkframe_alone_tells_of_the_singular_pose() -> None:
    answers = {row["contender"]: row["answer"] for row in paper_job.singular()}
    assert answers.pop(paper_job.OURS).startswith("mechanism: free motion 1: D.rocker")
    assert all(value.endswith(" m") for name, value in answers.items() if name.startswith("numpy"))


@pytest.mark.parametrize("space", [False, True])
def test_everybody_solves_the_same_random_linkages(space: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """Numba's loop is run by Python, which takes less time than to compile it."""
    if harness.importable("numba"):
        monkeypatch.setattr("numba.config.DISABLE_JIT", True)
    samples = everything_random.drawn(3, space=space)
    exact = np.array([samples.truth(k) for k in range(3)])
    errors = everything_random.errors_of(samples, exact)
    assert all((value < 1e-13) == ("linkframe" in name) for name, value in errors.items())
    assert max(errors.values()) < 1e-6


def test_numba_solves_the_same_job(monkeypatch: pytest.MonkeyPatch) -> None:
    if not harness.importable("numba"):
        pytest.skip("numba, which is a peer, is not installed")
    monkeypatch.setattr("numba.config.DISABLE_JIT", True)
    work = job(2, SAMPLES, space=False)
    assert_allclose(everything_random.dense_job(work), Stacked(work, plane=True).solve(), rtol=1e-6, atol=1e-15)


def test_mean_of_the_monte_carlo_is_exact() -> None:
    """A Gauss rule over all five inputs: the displacement is linear in load, clearance and the compliances."""
    nodes, weights = np.polynomial.hermite_e.hermegauss(12)
    weights = weights / weights.sum()
    k = 2e8 * np.exp(0.3 * nodes)
    flat = {name: np.full(12, law.mean()) for name, law in INPUTS.items()}
    harmonic = np.full(12, 1.0 / np.sum(weights / k))
    flat |= dict.fromkeys("BDE", harmonic)
    centre = displacement(**flat)[0]
    total = centre.copy()
    for joint in "BDE":
        total += weights @ displacement(**{**flat, joint: k}) - centre
    assert_allclose(total, mean(), rtol=1e-12)


@pytest.mark.parametrize("memory", [samples.KEPT, samples.FORGOTTEN])
def test_samples(memory: str) -> None:
    row = harness.child(samples.PROGRAM, "4096", memory)
    assert row["error_of_mean"] < 5 * row["standard_error"] < 0.1
    assert row["peak_MB"] > 10


def test_segments() -> None:
    rows = segments.measure(job(4, 3, space=False), (1, 4), 1)
    assert len(rows) == 4
    assert all(row["worst_error"] < 1e-12 for row in rows)


@pytest.mark.parametrize("varies", clearances.VARIES)
def test_clearances(varies: str) -> None:
    counts = (3, 40) if varies == "loads" else (2,)
    rows = clearances.measure(counts, 1, varies)
    assert len(rows) == len(counts) * len(programs.backends())
    assert all(row["across"] < 1e-14 and row["error"] < 1e-14 for row in rows)
    assert len(clearances.four_bars(2, 1, varies)) == len(programs.backends())


@pytest.mark.parametrize("kind", size.KINDS)
def test_size(kind: str) -> None:
    rows = size.measure(kind, (3, 7), 3, 1, 100.0)
    assert [row["links"] for row in rows] == [3, 7]
    assert all(row["error"] < 1e-12 for row in rows)


def test_meshes() -> None:
    rows = work_precision.mesh_rows((1, 8, 16), 1)
    assert all(target.met for target in work_precision.mesh_targets(rows))
    usual = [row["error"] for row in rows if "usual" in row["way"] and row["beams"] == 16]
    assert len(usual) == 2
    assert min(usual) > 5e-4


def test_samplers() -> None:
    rows = work_precision.sample_rows(range(7, 9), seeds=2)
    assert all(row["rms_error"] < 0.1 for row in rows)
    assert all(target.met for target in work_precision.sample_targets(rows))


def test_probabilities_are_exact() -> None:
    """The mean of the integral is that of 50 digits, and each way comes near all that it tells."""
    truth = reliability.exact()
    assert_allclose(truth.mean, mean()[1], rtol=1e-12)
    ways = {
        "Sobol'": (reliability.sampled("sobol", 2048, 0), 0.05),
        "polynomial": (reliability.fitted(2, 0, "moments"), 1e-3),
        "sorm": (reliability.failing("sorm", 0), 2e-3),
        "Taylor": (reliability.expanded(2, 0), 1e-3),
        "inverted": (reliability.inverted(partial(reliability.index, "form")), 1e-3),
    }
    for name, ((found, _), near) in ways.items():
        for quantity, value in found.items():
            assert_allclose(value, truth.of(quantity), rtol=near, err_msg=f"{name}: {quantity}")


def test_stiff_joints() -> None:
    rows = work_precision.joint_rows(11, 1)
    assert work_precision.joint_target(rows).met
    assert max(row["error_usual"] for row in rows) > 1e-4


def test_first_solution_is_right() -> None:
    printed = subprocess.run([sys.executable, "-c", start_up.FIRST], capture_output=True, text=True, check=True).stdout
    assert float(printed) < 1e-14


def test_everybody_moves_the_same_linkages() -> None:
    rows = kinematics.sweep_rows(24, 1)
    assert {row["contender"] for row in rows} >= {kinematics.OURS, kinematics.ANEW}
    assert all(row["closure_error"] < (1e-14 if "linkframe" in row["contender"] else 1e-12) for row in rows)
    assert all(row["apart_from_linkframe"] < 1e-12 for row in rows)


def test_batches_of_linkages_close() -> None:
    ones = kinematics.one_pose_rows(5)
    assert all(row["apart_from_batch"] < 1e-14 for row in ones)
    assert all(row["error"] < 1e-9 for row in kinematics.chain_rows((2,)))
    rows = kinematics.batch_rows(0.005)
    assert [row["poses"] for row in rows] == [500, 50, 50]
    assert all(row["closure_error"] < kinematics.ERROR for row in rows)


def test_one_frame_is_right_however_it_comes_about() -> None:
    rows = one_frame.measure(1, many=5)
    assert {row["what"] for row in rows} >= {*one_frame.LIMITS, one_frame.MOVED}
    assert all(row["error"] < one_frame.ERROR for row in rows if row["what"] not in one_frame.RATIOS)


@pytest.mark.skipif(not straight_c.available(), reason="there is no C compiler")
def test_the_loop_in_c_does_what_the_machine_code_does() -> None:
    """To the rounding of fused operations; what was there before is overwritten."""
    pytest.importorskip("llvmlite")
    make, node, _ = programs.cases()["modulus varying"]
    (first, *_) = straight_c.runs(partial(programs.solved, make(500), node, programs.COMPILED))
    written = first.held[1 + first.kernel.read :]  # type: ignore[index]
    own = [array.copy() for array in written]
    for array in written:
        array[...] = np.nan
    first.in_c()
    assert len(own) > 6
    for array, before in zip(written, own, strict=True):
        assert np.any(before)
        assert_allclose(array, before, rtol=1e-6)
    assert any(np.any(array != before) for array, before in zip(written, own, strict=True))


def test_summary_and_figures(tmp_path: Path) -> None:
    """One benchmark by its command: table, picture, targets, and the summary of them."""
    path = str(Path(__file__).parent)
    command = [sys.executable, str(Path(run.__file__)), "--quick", "--out", str(tmp_path), "segments"]
    done = subprocess.run(command, capture_output=True, text=True, check=True, env={**os.environ, "PYTHONPATH": path})
    assert "| 3 segments | at most 1.2 times from 1 to 64 segments |" in done.stdout
    assert (tmp_path / "segments.png").read_bytes().startswith(b"\x89PNG")
    with (tmp_path / "segments.csv").open(encoding="utf-8") as file:
        assert len(list(csv.DictReader(file))) == len(segments.WAYS) * len(segments.COUNTS)
    targets = json.loads((tmp_path / "segments.targets.json").read_text(encoding="utf-8"))
    assert (tmp_path / "summary.md").read_text(encoding="utf-8").count("\n| 3 ") == len(targets) > 0


def test_peer_that_cannot_be_loaded_is_left_out(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """As one that is not installed, whatever it fails of; the reason is told once."""
    (tmp_path / "unlinked_peer.py").write_text("raise RuntimeError('libblas.so.3: no such file')", encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    for _ in range(2):
        found = [harness.importable(name) for name in ("numpy", "unlinked_peer", "missing_peer.solver")]
        assert found == [True, False, False]
    assert capsys.readouterr().out.splitlines() == [
        "unlinked_peer is left out: RuntimeError: libblas.so.3: no such file",
        "missing_peer.solver is left out: ModuleNotFoundError: No module named 'missing_peer'",
    ]


def test_benchmarks_go_on_without_a_peer(monkeypatch: pytest.MonkeyPatch) -> None:
    """No benchmark looks for a peer but by `importable`."""
    monkeypatch.setitem(sys.modules, "openseespy.opensees", None)
    harness.importable.cache_clear()
    try:
        assert not any("openseespy" in name for name in paper_job.ways(plane=True))
        assert one_frame.OPENSEES not in one_frame.peers([])
    finally:
        harness.importable.cache_clear()


def test_unknown_benchmark_is_refused() -> None:
    done = subprocess.run([sys.executable, run.__file__, "paper"], capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert "no benchmark is named paper: choose from paper_job" in done.stderr
