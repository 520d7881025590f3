"""Measured positions: read, compared, and turned into dimensions."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from linkframe.framework import FrameError
from linkframe.models import Linkage, Measured, calibrate, compare, read_measured
from linkframe.models.job.measured import DriveValues, MeasuredOutcome, MeasuredPoint
from numpy.testing import assert_allclose
from scipy import stats

Array = np.ndarray[Any, np.dtype[np.float64]]

PLACES = np.linspace(0.0, 2.0, 15)
ANGLES = np.radians(np.arange(0.0, 360.0, 24.0))


def decay(a: Array, b: Array) -> Array:
    return np.asarray(a[:, None] * np.exp(-b[:, None] * PLACES))


def slider_crank(crank: Array | float, rod: Array | float, offset: Array | float = 0.0) -> Linkage:
    """Crank along x as drawn; the slider's line lies `offset` above the crank's pivot."""
    crank, rod, offset, none = np.broadcast_arrays(crank, rod, offset, 0.0)
    linkage = Linkage(
        A=(0, 0),
        B=np.stack([crank, none, none], axis=-1),
        C=np.stack([crank + np.sqrt(rod**2 - offset**2), offset, none], axis=-1),
    )
    linkage.link("crank", "A", "B")
    linkage.link("rod", "B", "C")
    linkage.link("slider", "C")
    linkage.revolute("A", "ground", "crank", drive=True)
    linkage.revolute("B", "crank", "rod")
    linkage.revolute("C", "rod", "slider")
    linkage.prismatic("C", "ground", "slider", axis=(1, 0), name="slide")
    return linkage


TRUE = {"crank": 0.1003, "rod": 0.2994, "offset": 0.0204}
NOMINAL = {"crank": 0.1, "rod": 0.3, "offset": 0.02}


def seen(spread: float, rng: np.random.Generator) -> Measured:
    """Where the slider with the true dimensions is, by closed form, as measured along its line."""
    across = TRUE["offset"] - TRUE["crank"] * np.sin(ANGLES)
    along = TRUE["crank"] * np.cos(ANGLES) + np.sqrt(TRUE["rod"] ** 2 - across**2)
    position = np.full((ANGLES.size, 3), np.nan)
    position[:, 0] = along + spread * rng.normal(size=ANGLES.size)
    return Measured(position, spread, {"A": ANGLES})


def test_dimensions_of_a_slider_crank() -> None:
    measured = seen(1e-9, np.random.default_rng(0))
    motion = slider_crank(**NOMINAL).move(measured.drives)
    found = motion.calibrate("C", measured, slider_crank, NOMINAL)
    for name, value in TRUE.items():
        assert abs(found.values[name] - value) < 5.0 * found.standard_error[name] < 1e-7
    better = slider_crank(**found.values).move(measured.drives).compare("C", measured)
    assert not better.outside.any()
    assert_allclose(better.chi_squared, found.chi_squared, rtol=1e-3)
    assert motion.compare("C", measured).outside.all()


@pytest.mark.parametrize("known", [True, False])
def test_estimates_lie_as_far_off_as_their_errors_say(known: bool) -> None:
    """Of 500 synthetic measurements: errors over standard errors are normal, or Student's where these are estimated."""
    rng, right = np.random.default_rng(7), {"a": 2.0, "b": 0.7}
    exact = decay(np.array([2.0]), np.array([0.7]))[0]
    off: dict[str, list[float]] = {"a": [], "b": []}
    held = 0
    for _ in range(500):
        found = calibrate(
            decay, {"a": 1.5, "b": 1.0}, exact + 0.01 * rng.normal(size=15), uncertainty=0.01 if known else None
        )
        for name, each in off.items():
            each.append((found.values[name] - right[name]) / found.standard_error[name])
        low, high = found.confidence_interval(0.9)["a"]
        held += bool(low <= 2.0 <= high)
    law = stats.norm() if known else stats.t(13)
    for each in off.values():
        assert stats.kstest(each, law.cdf).pvalue > 1e-3
    assert 425 <= held <= 475


def test_what_the_data_cannot_tell_is_named() -> None:
    def product(a: Array, b: Array, c: Array) -> Array:
        return np.asarray((a * b)[:, None] * np.exp(-c[:, None] * PLACES))

    target = 2.0 * np.exp(-0.7 * PLACES)
    found = calibrate(product, {"a": 1.0, "b": 1.5, "c": 1.0}, target, uncertainty=0.01)
    (combination,) = found.undetermined
    assert set(combination) == {"a", "b"}
    assert np.isinf([found.standard_error["a"], found.standard_error["b"]]).all()
    alone = calibrate(lambda a, c: product(a, np.full_like(a, 1.5), c), {"a": 1.0, "c": 1.0}, target, uncertainty=0.01)
    assert_allclose(found.standard_error["c"], alone.standard_error["c"], rtol=1e-5)
    assert_allclose(found.values["a"] * found.values["b"], 2.0, rtol=1e-9)
    assert "not told by the data: a with b" in repr(found)


def test_chi_squared_of_a_prediction_that_holds() -> None:
    """Sums of squares of 400 measurements are as chi squared has them, of the components that were measured."""
    rng = np.random.default_rng(3)
    right = rng.normal(size=(6, 3))
    sums, outside = [], 0
    for _ in range(400):
        place = right + 0.03 * rng.normal(size=(6, 3))
        place[:, 2] = np.nan
        found = compare(right + 0.04 * rng.normal(size=(6, 3)), Measured(place, 0.03, {}), deviation=0.04)
        sums.append(found.chi_squared)
        outside += int(found.outside.sum())
    assert found.count == 12
    assert stats.kstest(sums, stats.chi2(12).cdf).pvalue > 1e-3
    assert abs(outside - 0.05 * 2400) < 4.0 * np.sqrt(2400 * 0.05 * 0.95)
    assert np.isnan(found.root_mean_square[2])


@pytest.mark.parametrize("among_poses", [False, True])
def test_chi_squared_of_deviations_that_go_together(among_poses: bool) -> None:
    """Two tolerances that move the point along two lines, at each pose anew or at all alike, against scipy.stats."""
    rng = np.random.default_rng(5)
    right, maps = rng.normal(size=(6, 3)), rng.normal(size=(6, 3, 2))
    blocks = maps @ maps.mT
    covariance = np.einsum("pik,qjk->piqj", maps, maps) if among_poses else blocks
    sums, outside = [], 0
    for _ in range(400):
        deviations = np.broadcast_to(rng.normal(size=(1 if among_poses else 6, 2, 1)), (6, 2, 1))
        place = right + (maps @ deviations)[..., 0] + 0.05 * rng.normal(size=(6, 3))
        place[2, 1] = np.nan
        found = compare(right, Measured(place, 0.05, {}), covariance=covariance)
        sums.append(found.chi_squared)
        outside += int(found.outside.sum())
    assert found.count == 17
    assert stats.kstest(sums, stats.chi2(17).cdf).pvalue > 1e-3
    if not among_poses:
        assert abs(outside - 0.05 * 2400) < 4.0 * np.sqrt(2400 * 0.05 * 0.95)
    assert_allclose(found.uncertainty[0], np.sqrt(np.diag(blocks[0]) + 0.05**2), rtol=1e-14)


def test_without_covariances_chi_squared_is_that_of_the_deviations() -> None:
    seen_at, spread = Measured([[0.1, 0.2, np.nan], [0.3, 0.1, 0.0]], 1e-3, {}), np.array([1e-3, 3e-3, 0.0])
    one = compare(np.zeros((2, 3)), seen_at, deviation=spread)
    for covariance in (np.broadcast_to(np.diag(spread**2), (2, 3, 3)), np.zeros((2, 3, 2, 3))):
        whole = np.array(covariance)
        if whole.ndim == 4:
            for pose in range(2):
                whole[pose, :, pose] = np.diag(spread**2)
        other = compare(np.zeros((2, 3)), seen_at, covariance=whole)
        assert_allclose(other.chi_squared, one.chi_squared, rtol=1e-13)
        assert_allclose(other.uncertainty, one.uncertainty, rtol=1e-14)


@pytest.mark.parametrize("uncertainty", [None, 1e-9, 1e-4])
def test_a_job_with_a_single_tolerance(uncertainty: float | None) -> None:
    """It leaves no residual across its line beside a measurement that is much better: then the deviations count."""
    place, ways = (
        np.array([[1e-3, 2e-3, np.nan], [0.0, -1e-3, np.nan]]),
        1e-3 * np.array([[0.6, 0.8, 0.0], [0.8, 0.6, 0.0]]),
    )
    given = MeasuredPoint(Path("seen.csv"), "P", 0.95, Measured(place, uncertainty, {}))
    found = MeasuredOutcome.of(given, {}, np.zeros((2, 3)), ways[:, :, None] * ways[:, None]).comparison
    variances = ways[:, :2] ** 2 + (uncertainty or 0.0) ** 2
    wanted = float((place[:, :2] ** 2 / variances).sum())
    if uncertainty == 1e-4:
        both = ways[:, :2, None] * ways[:, None, :2] + 1e-8 * np.eye(2)
        wanted = float(np.einsum("pi,pij,pj->", place[:, :2], np.linalg.inv(both), place[:, :2]))
    assert_allclose(found.chi_squared, wanted, rtol=1e-9)


def test_a_table_is_read(tmp_path: Path) -> None:
    file = tmp_path / "seen.csv"
    file.write_text("A [deg], x, y, ux, uy\n0, 0.2, , 1e-5,\n\n90, , 0.2, , 2e-5\n", encoding="utf-8-sig")
    found = read_measured(file)
    assert found.uncertainty is not None
    assert_allclose(found.drives["A"], [0.0, 0.5 * np.pi])
    np.testing.assert_array_equal(np.isfinite(found.position), [[True, False, False], [False, True, False]])
    assert found.uncertainty[0, 0] == 1e-5
    assert found.uncertainty[1, 1] == 2e-5


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("a,b\n1,2\n", r"row 1: no column is a position, of a, b: name those x, y, z, in the linkage's unit"),
        ("x,x\n1,2\n", "row 1: there are 2 columns 'x': keep one"),
        ("A,A [deg],x\n1,2,3\n", "two columns give the drive 'A': keep one of them"),
        ("A,x,\n1,2,\n", "row 1: column 3 has no name"),
        ("A [deg];x\n1;2\n", "row 1: columns are separated by semicolons: separate them by commas"),
        ("A [deg]\tx\n1\t2\n", "row 1: columns are separated by tabs"),
        ("x\n", "has no rows"),
        ("x,y\n1\n", "row 2 has 1 cells for 2 columns"),
        ("x,y\n1,two\n", "row 2: y is 'two', which is no number"),
        ('x\n"0,5"\n', "row 2: x is '0,5', which is no number: write it with a point"),
        ("A,x\n1_0,2\n", "row 2: A is '1_0', which is no number"),
        ("A,x\n0,1\ninf,2\n", "row 3: A is 'inf': give a finite number"),
        ("A,x\n0,\n", "has no position in it: x, y and z are empty in all rows"),
        ("x,y,ux\n1,2,0.1\n", "row 2: y has no uncertainty: fill in uy, or leave ux, uy, uz out"),
        ("x,ux\n\n1,1\n\n1,-0.1\n", "row 5: ux is -0.1: give a standard uncertainty above zero"),
        ("x\n\n1,2\n", "row 3 has 2 cells for 1 columns"),
    ],
)
def test_tables_that_are_refused(tmp_path: Path, text: str, told: str) -> None:
    file = tmp_path / "seen.csv"
    file.write_text(text)
    with pytest.raises(FrameError, match=told):
        read_measured(file)


@pytest.mark.parametrize(
    ("content", "told"),
    [
        (None, "cannot be read: No such file or directory; give a table of measured positions, saved as CSV in UTF-8"),
        ("A [°],x\n0,1\n".encode("latin-1"), "cannot be read: it is not UTF-8 text; give a table"),
        (b"x\n" + 200_000 * b"9", "cannot be read: it is no text of rows and cells; give a table"),
    ],
)
def test_files_that_are_no_table(tmp_path: Path, content: bytes | None, told: str) -> None:
    file = tmp_path / "seen.csv"
    if content is not None:
        file.write_bytes(content)
    with pytest.raises(FrameError, match=told) as refused:
        read_measured(file)
    assert "Errno" not in str(refused.value)


def test_units_of_drives_in_a_table(tmp_path: Path) -> None:
    file = tmp_path / "seen.csv"
    file.write_text("A [deg],B [°],C [rad],D,x\n90,90,1.5,1.5,0.2\n", encoding="utf-8")
    assert_allclose([read_measured(file).drives[name][0] for name in "ABCD"], [0.5 * np.pi, 0.5 * np.pi, 1.5, 1.5])


def test_degrees_for_a_slide_are_refused(tmp_path: Path) -> None:
    file = tmp_path / "seen.csv"
    file.write_text("S [deg],x,ux\n0.01,0.21,1e-4\n")
    slide = Linkage(A=(0, 0), P=(0.2, 0))
    slide.link("slider", "A", "P")
    slide.prismatic("A", "ground", "slider", axis=(1, 0, 0), drive=True, name="S")
    measured = read_measured(file)
    with pytest.raises(FrameError, match=r"a column 'S \[deg\]', and that drive is a length: leave the unit out"):
        slide.move(measured.drives).compare("P", measured)


def test_degrees_are_written_as_they_were_read(tmp_path: Path) -> None:
    """Radians in between leave 29.999999999999996 of 30 degrees."""
    degrees = [*range(-720, 721), 0.1, 12.34567890123, 1e-7]
    file = tmp_path / "seen.csv"
    file.write_text("A [deg],x\n" + "".join(f"{each},0.1\n" for each in degrees))
    given = MeasuredPoint(file, "P", 0.95, read_measured(file))
    assert given.drive_values({"A": DriveValues(np.zeros(2), "deg")})["A"].tolist() == degrees


def test_what_is_refused() -> None:
    measured = seen(1e-6, np.random.default_rng(0))
    with pytest.raises(FrameError, match=r"the motion has shape \(2,\) and 15 poses were measured"):
        slider_crank(**NOMINAL).move(A=[0.0, 1.0]).compare("C", measured)
    with pytest.raises(FrameError, match="drive 'A' of the motion is not at the values of the measurement"):
        slider_crank(**NOMINAL).move(A=ANGLES + 0.1).compare("C", measured)
    with pytest.raises(FrameError, match="an uncertainty is inf: give finite standard uncertainties above zero"):
        Measured([[0.0, 0.0, 0.0]], [1.0, np.inf, 1.0], {})
    with pytest.raises(FrameError, match="no position was measured, all are NaN"):
        Measured([[np.nan] * 3], None, {})
    with pytest.raises(FrameError, match="neither measurement nor prediction has an uncertainty"):
        compare([[0.0, 0.0, 0.0]], Measured([[0.0, 0.0, 0.0]], None, {}))
    line, place = np.broadcast_to(np.ones((3, 3)), (2, 3, 3)), np.zeros((2, 3))
    with pytest.raises(FrameError, match="the covariance leaves a direction without uncertainty"):
        compare(place, Measured(place, None, {}), covariance=line)
    with pytest.raises(FrameError, match="a deviation and a covariance: give one of them"):
        compare(place, Measured(place, 1.0, {}), covariance=line, deviation=1.0)
    with pytest.raises(FrameError, match=r"covariance has shape \(3, 3\): give \(2, 3, 3\) or \(2, 3, 2, 3\)"):
        compare(place, Measured(place, 1.0, {}), covariance=line[0])
    for entry, value in (((0, 0), -0.2), ((0, 1), 0.9), ((1, 1), np.nan), ((2, 2), np.inf)):
        wrong = np.array([np.eye(3), np.eye(3)])
        wrong[1][entry] = value
        with pytest.raises(FrameError, match=rf"the covariance holds {value}: give finite numbers, symmetric, with"):
            compare(place, Measured(place, 1.0, {}), covariance=wrong)
    with pytest.raises(FrameError, match=r"the covariance holds 1\.1: give finite numbers, .* between -1 and 1"):
        compare(place, Measured(place, 1.0, {}), covariance=np.eye(3) + 1.1 * (1.0 - np.eye(3)) + 0.0 * line)
    with pytest.raises(FrameError, match=r"parameter 'a' begins at 0\.0: give its scale"):
        calibrate(decay, {"a": 0.0, "b": 1.0}, PLACES)
    with pytest.raises(FrameError, match=r"the model returned shape \(1, 15\) for 1 sets of parameters and measured"):
        calibrate(decay, {"a": 1.0, "b": 1.0}, PLACES[:3])
    with pytest.raises(FrameError, match="predicts no value at the start"):
        calibrate(lambda a: np.full((len(a), 1), np.nan), {"a": 1.0}, [1.0])


def test_a_search_that_comes_to_where_nothing_is_predicted_is_told() -> None:
    """Such as dimensions with which the linkage cannot be assembled."""
    with pytest.raises(FrameError, match="predicts no value"):
        calibrate(lambda a: np.where(a < 0.5, np.nan, a)[:, None] * PLACES, {"a": 1.0}, 0.1 * PLACES)


def test_poses_that_are_not_assembled_are_not_compared() -> None:
    """Nor are they taken for poses at other values of the drive: here the crank cannot follow the slider to 0.5."""
    linkage = Linkage(A=(0, 0), B=(0, 0.1), C=(0.08**0.5, 0))
    linkage.link("crank", "A", "B")
    linkage.link("rod", "B", "C")
    linkage.link("slider", "C")
    linkage.revolute("A", "ground", "crank")
    linkage.revolute("B", "crank", "rod")
    linkage.revolute("C", "rod", "slider")
    linkage.prismatic("C", "ground", "slider", axis=(1, 0), reference=0.08**0.5, name="slide", drive=True)
    slides = np.array([0.35, 0.5, 0.25])
    motion = linkage.move(slide=slides)
    assert motion.is_assembled.tolist() == [True, False, True]
    read = np.stack([slides + 2e-4, 0.0 * slides, 0.0 * slides], axis=-1)
    found = motion.compare("C", Measured(read, 1e-4, {"slide": slides}))
    assert_allclose(found.residual, [[2e-4, 0.0, 0.0], [np.nan] * 3, [2e-4, 0.0, 0.0]], atol=1e-12)
    assert found.count == 6
    assert found.chi_squared == pytest.approx(8.0)
    with pytest.raises(FrameError, match="drive 'slide' of the motion is not at the values"):
        motion.compare("C", Measured(read, 1e-4, {"slide": slides + 0.01}))


def test_a_comparison_of_nothing_is_refused() -> None:
    """As where degrees were taken for radians, and no pose is assembled: it would lie within every band."""
    with pytest.raises(FrameError, match="no pose that was measured"):
        compare(np.full((2, 3), np.nan), Measured(np.ones((2, 3)), 1e-3, {}))


@pytest.mark.parametrize("begin", [{"a": 1e-9, "b": 1.0}, {"a": 1.0, "b": 1e-9}, {"a": 1e9, "b": 1e-9}])
@pytest.mark.parametrize("exact", [False, True])
def test_what_the_data_tells_does_not_depend_on_where_the_search_begins(begin: dict[str, float], exact: bool) -> None:
    def line(a: Array, b: Array) -> Array:
        return np.asarray(a[:, None] + b[:, None] * PLACES)

    columns = np.stack([np.ones_like(PLACES), PLACES], axis=1)
    target = columns @ [0.5, 3.0]
    given = (lambda a, b: {"a": columns[:, 0], "b": columns[:, 1]}) if exact else None
    found = calibrate(line, begin, target, uncertainty=0.01, gradient=given)
    assert not found.undetermined
    assert_allclose([found.values["a"], found.values["b"]], [0.5, 3.0], rtol=1e-6)
    assert_allclose(found.covariance, 1e-4 * np.linalg.inv(columns.T @ columns), rtol=1e-6)


def test_units_do_not_decide_what_the_data_tells() -> None:
    """A stiffness known to a fifth is told, and what it is taken together with is as uncertain as that makes it."""

    def stretched(k: Array, length: Array) -> Array:
        return np.asarray(length[:, None] + PLACES / k[:, None])

    found = calibrate(stretched, {"k": 1e8, "length": 1.0}, 1.01 + PLACES / 2e8, uncertainty=1e-9)
    slopes = np.stack([-PLACES / 2e8**2, np.ones_like(PLACES)], axis=1) / [1e-16, 1.0]
    error = 1e-9 * np.sqrt(np.diag(np.linalg.inv(slopes.T @ slopes))) / [1e-16, 1.0]
    assert_allclose(found.values["k"], 2e8, rtol=1e-3)
    assert_allclose(list(found.standard_error.values()), error, rtol=1e-2)
    together = calibrate(lambda a, b: (a + b)[:, None] + 0.0 * PLACES, {"a": 1.0, "b": 100.0}, 3.0 + PLACES)
    assert [set(each) for each in together.undetermined] == [{"a", "b"}]
    assert np.isinf(list(together.standard_error.values())).all()
