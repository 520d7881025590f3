"""Probability that a point leaves its zone: adjoint gradients beside differences, how often is solved, the figure."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import matplotlib as mpl
import numpy as np
import pytest
from linkframe.framework import FrameError
from linkframe.models import Linkage, Measured, calibrate, reliability
from linkframe.models.linkage.zone import _Margin
from numpy.testing import assert_allclose
from scipy import stats

mpl.use("agg")
Array = np.ndarray[Any, np.dtype[np.float64]]
LENGTHS = {"crank": 0.1, "coupler": 0.3, "rocker": 0.25, "ground": 0.28, "x": 0.15, "y": 0.08}


def at(*xyz: Array | float) -> Array:
    return np.stack(np.broadcast_arrays(*xyz), axis=-1)


def four_bar(crank: Array, coupler: Array, rocker: Array, ground: Array, x: Array, y: Array) -> Linkage:
    """Drawn with the crank along x; the coupler's angle by the law of cosines."""
    chord = ground - crank
    cosine = (chord**2 + coupler**2 - rocker**2) / (2.0 * chord * coupler)
    sine = np.sqrt(1.0 - cosine**2)
    linkage = Linkage(
        A=(0, 0),
        B=at(crank, 0.0),
        D=at(crank + coupler * cosine, coupler * sine),
        E=at(ground, 0.0),
        P=at(crank + x * cosine - y * sine, x * sine + y * cosine),
    )
    linkage.link("crank", "A", "B")
    linkage.link("coupler", "B", "P", "D")
    linkage.link("rocker", "D", "E")
    linkage.revolute("A", "ground", "crank", drive=True)
    for point, first, second in (("B", "crank", "coupler"), ("D", "coupler", "rocker"), ("E", "rocker", "ground")):
        linkage.revolute(point, first, second)
    return linkage


def screw(pitch: Array, start: Array, lean: Array, length: Array) -> Linkage:
    """A nut on a screw that leans, driven from an uncertain start, with an arm of a given length on it."""
    linkage = Linkage(A=(0, 0, 0), P=(0.3, 0.1, 0.0))
    linkage.link("arm", "A", "P", length=length)
    axis = at(np.sin(lean), 0.2, np.cos(lean))
    linkage.screw("A", "ground", "arm", axis=axis, pitch=pitch, drive=True, reference=start)
    return linkage


def spatial(height: Array, lean: Array, rod: Array) -> Linkage:
    """A crank about an axis that leans, a rod between balls, and a slider."""
    linkage = Linkage(A=(0, 0, 0), B=(0.1, 0, 0.02), C=at(0.4, 0.05, height), P=at(0.5, 0.05, height))
    linkage.link("crank", "A", "B")
    linkage.link("rod", "B", "C", length=rod)
    linkage.link("slider", "C", "P")
    linkage.revolute("A", "ground", "crank", axis=at(np.sin(lean), 0.0, np.cos(lean)), drive=True)
    linkage.spherical("B", "crank", "rod")
    linkage.universal("C", "rod", "slider", axis=(0, 1, 0), second=(0, 0, 1))
    linkage.prismatic("C", "ground", "slider", axis=at(1.0, 0.0, lean), name="slide")
    return linkage


BUILT: dict[str, tuple[Callable[..., Linkage], dict[str, float], str]] = {
    "four-bar": (four_bar, LENGTHS, "A"),
    "screw": (screw, {"pitch": 0.02, "start": 0.3, "lean": 0.2, "length": 0.35}, "A"),
    "spatial": (spatial, {"height": 0.03, "lean": 0.1, "rod": 0.3071}, "A"),
}


def laws(values: dict[str, float], share: float = 1e-3) -> dict[str, Any]:
    return {name: stats.norm(value, share * value) for name, value in values.items()}


@pytest.mark.parametrize("kind", BUILT)
def test_gradient_of_the_zone_against_differences(kind: str) -> None:
    """By points, given lengths, axes of joints, pitches and references of drives, all at once."""
    build, values, drive = BUILT[kind]
    poses = np.array([0.2, 0.5, 1.0])
    motion = build(**values).move({drive: poses})
    margin = _Margin(motion, "P", 1e-3, build, laws(values))
    rng, n = np.random.default_rng(0), 12
    samples = {name: value * (1.0 + 2e-3 * rng.normal(size=n)) for name, value in values.items()}
    pose = np.arange(n) % 3
    found, slopes = margin.with_gradient(samples, pose)
    assert_allclose(found, margin(samples, pose), rtol=1e-12)
    for name, value in values.items():
        step = 1e-5 * value
        beside = [margin(samples | {name: samples[name] + s * step}, pose) for s in (-2.0, -1.0, 1.0, 2.0)]
        expected = (8.0 * (beside[2] - beside[1]) - (beside[3] - beside[0])) / (12.0 * step)
        size = np.abs(expected).max()
        assert size > 0.0, name
        assert_allclose(slopes[name], expected, rtol=1e-6, atol=1e-6 * size, err_msg=name)


class Counting:
    """Makes linkages, and counts how often they are moved and to how many poses in all."""

    def __init__(self) -> None:
        self.moves = self.poses = 0

    def __call__(self, **values: Array) -> Linkage:
        linkage = four_bar(**values)
        move = linkage.move

        def counted(drives: Any) -> Any:
            self.moves += 1
            motion = move(drives)
            self.poses += int(np.prod(motion.shape))
            return motion

        linkage.move = counted  # type: ignore[method-assign]
        return linkage


def test_one_batch_an_iteration_however_many_inputs() -> None:
    """All poses and starting points together: with six inputs as many solutions as with two, and the same answer."""
    motion = four_bar(**LENGTHS).move(A=np.radians([20.0, 60.0]))
    solved: dict[int, Counting] = {}
    for k in (2, 6):
        some = dict(list(laws(LENGTHS, 1e-4).items())[:k])
        rest = {name: value for name, value in LENGTHS.items() if name not in some}
        solved[k] = count = Counting()
        found = motion.reliability(
            "P", 1e-4, lambda c=count, r=rest, **given: c(**given, **r), some, method="form", starts=4
        )
        assert count.moves == found.batches
        assert count.poses == found.evaluations <= 2 * 4 * found.batches
    differences = motion.reliability("P", 1e-4, four_bar, laws(LENGTHS, 1e-4), method="form", starts=4, gradient=None)
    assert_allclose(found.beta, differences.beta, rtol=1e-7)
    assert differences.evaluations > 10 * found.evaluations
    assert_allclose(sum(found.importance.values()), 1.0, rtol=1e-9)


def test_first_order_of_a_four_bar_by_its_sensitivity() -> None:
    """Small deviations of one length: P = 2 Φ(-limit / |∂P/∂l| s) at each pose, to first order."""
    motion = four_bar(**LENGTHS).move(A=np.radians([20.0, 60.0, 100.0, 140.0]))
    deviation, limit = 1e-7, 4e-7
    build = lambda rocker: four_bar(**{**LENGTHS, "rocker": rocker})  # noqa: E731
    inputs = {"rocker": stats.norm(LENGTHS["rocker"], deviation)}
    slope = np.linalg.norm(motion.sensitivity("P").length("rocker", "E", "D")[..., :3], axis=-1)
    found = motion.reliability("P", limit, build, inputs, method="form")
    assert_allclose(found.probability, 2.0 * stats.norm.sf(limit / (slope * deviation)), rtol=1e-4)
    anywhere = motion.reliability("P", limit, build, inputs, method="form", anywhere=True)
    assert_allclose(anywhere.probability, found.probability.max(), rtol=1e-3)


def test_a_gradient_that_comes_with_the_values() -> None:
    """A limit state of many inputs is called once an iteration."""
    calls = []

    def limit(x: dict[str, Array]) -> Array:
        return 4.0 * np.sqrt(30.0) - np.sum(list(x.values()), axis=0)

    def both(x: dict[str, Array]) -> tuple[Array, dict[str, Array]]:
        calls.append(len(x["x0"]))
        return limit(x), {name: -np.ones_like(values) for name, values in x.items()}

    inputs = {f"x{k}": stats.norm() for k in range(30)}
    found = reliability(limit, inputs, method="form", gradient=both, starts=1)
    assert_allclose(found.beta, 4.0, rtol=1e-9)
    assert calls == [1] * found.batches
    assert found.evaluations == found.batches <= 3


def test_the_figure_of_a_motion() -> None:
    motion = four_bar(**LENGTHS).move(A=np.radians([20.0, 60.0, 100.0]))
    inputs = laws(LENGTHS, 1e-4)
    found = motion.reliability("P", 3e-5, four_bar, inputs, method="random", samples=1000, rng=0)
    axes = found.plot()
    line = axes.get_lines()[0]
    assert_allclose(line.get_xdata(), [20.0, 60.0, 100.0])
    assert_allclose(line.get_ydata(), found.probability)
    assert (axes.get_yscale(), axes.get_xlabel(), len(axes.collections)) == ("log", "A [°]", 1)
    first = motion.reliability("P", 3e-5, four_bar, inputs, method="form", starts=3).plot(axes)
    assert first is axes
    assert len(axes.get_lines()) == 2
    with pytest.raises(FrameError, match="leave anywhere out"):
        motion.reliability("P", 3e-5, four_bar, inputs, method="random", samples=100, anywhere=True).plot()


def test_calibration_takes_its_derivatives_from_the_adjoint() -> None:
    """As many motions with six dimensions as with one, and the covariance that differences have."""
    angles = np.radians(np.linspace(10.0, 170.0, 12))
    right = {name: value * (1.0 + 2e-3) for name, value in LENGTHS.items()} | {"ground": LENGTHS["ground"]}
    seen = four_bar(**right).move(A=angles).position("P")
    measured = Measured(seen + 1e-6 * np.random.default_rng(0).normal(size=seen.shape), 1e-6, {"A": angles})
    count, motion = Counting(), four_bar(**LENGTHS).move(A=angles)
    found = motion.calibrate("P", measured, count, LENGTHS)
    poses = len(angles)
    assert count.poses == count.moves * poses  # never a neighbour beside
    for name, value in right.items():
        assert abs(found.values[name] - value) < 5.0 * found.standard_error[name]

    def predict(**lengths: Array) -> Array:
        return four_bar(**{k: v[:, None] for k, v in lengths.items()}).move(A=angles).position("P")

    differences = calibrate(predict, LENGTHS, measured.position, uncertainty=1e-6)
    assert_allclose(list(found.values.values()), list(differences.values.values()), rtol=1e-8)
    assert_allclose(found.covariance, differences.covariance, rtol=1e-4, atol=1e-5 * np.abs(found.covariance).max())
    with pytest.raises(FrameError, match="the gradient has no derivative by 'b'"):
        calibrate(
            lambda a, b: a[:, None] + b[:, None] * angles,
            {"a": 1.0, "b": 1.0},
            angles,
            gradient=lambda a, b: {"a": 1.0},
        )


def test_no_linkage_is_made_of_what_its_dimensions_cannot_be() -> None:
    """Derivatives are taken within the distribution of a length, to whose ends the search for failures comes."""
    seen: list[float] = []

    def arm(length: Any = 0.2, off: Any = 0.0) -> Linkage:
        length, off = np.broadcast_arrays(length, off)
        seen.extend([float(length.min()), float(length.max())])
        linkage = Linkage(A=(0, 0), P=np.stack([length, off], axis=-1))
        linkage.link("arm", "A", "P")
        linkage.revolute("A", "ground", "arm", drive=True)
        return linkage

    inputs = {"length": stats.uniform(0.2 - 1e-5, 2e-5), "off": stats.norm(0.0, 1e-6)}
    for method in ("form", "sorm"):
        found = arm().move(A=0.3).reliability("P", 9e-6, arm, inputs, method=method)
        assert 0.0 < found.probability < 1.0
    assert min(seen) >= 0.2 - 1e-5 - 1e-16
    assert max(seen) <= 0.2 + 1e-5 + 1e-16
    assert max(seen) - min(seen) > 1.5e-5
