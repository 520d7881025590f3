"""What the four-bar job says of the paper and of its own samples, against small programs that share nothing with it."""

from __future__ import annotations

import csv
import re
from functools import cache

import numpy as np
import pytest
from linkframe.models import FourBar, Link
from linkframe.models.four_bar.clearance import clearance_map
from linkframe.models.job.figures import ENVELOPE, TracedPoint, _envelope, draw_histograms, draw_trajectories
from linkframe.models.job.large_table import passages
from linkframe.models.job.tables import with_error
from linkframe.models.paper import reactions
from linkframe.models.paper.against_paper import points
from linkframe.models.paper.inputs import Inputs
from linkframe.models.paper.printed import printed
from linkframe.models.paper.readings import AVERAGED, offset_covariance, readings, run_std
from linkframe.models.paper.report import report
from linkframe.models.paper.result import Result, compute
from linkframe.models.paper.table import as_csv, as_markdown, as_text
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.testing import assert_allclose
from numpy.typing import NDArray

Array = NDArray[np.float64]
LENGTH, FORCE = 0.1, 100.0
AREA, BENDING = 2e11 * 6.35e-3 * 12.7e-3, 2e11 * 6.35e-3 * 12.7e-3**3 / 12.0


@cache
def job() -> Result:
    return compute(Inputs())


@cache
def text() -> str:
    """The report, each paragraph a line."""
    return report(job()).text({}, [], {})


def table_rows(heading: str) -> list[list[str]]:
    """Cells of the rows of the table in the report whose heading begins so."""
    lines = text().splitlines()
    start = next(k for k, line in enumerate(lines) if line.startswith(f"| {heading} |"))
    rows = []
    for line in lines[start + 2 :]:
        if not line.startswith("|"):
            break
        rows.append([cell.strip() for cell in line.strip("|").split("|")])
    return rows


# -- the displacement at singular poses -------------------------------------------------------------------------------


class Corotational:
    """The paper's linkage as plane corotational beams on ideal pins, each link in equal elements."""

    def __init__(self, theta: float, pieces: int) -> None:
        crank = LENGTH * np.array([np.cos(theta), np.sin(theta)])
        base = np.array([2.0 * LENGTH, 0.0])
        ends = [(np.zeros(2), crank), (crank, crank + base), (crank + base, base)]
        self.pieces, self.theta = pieces, theta
        # The pins are shared, the rotations of each link are its own.
        self.places = np.array([ends[0][0], *(a + (b - a) * k / pieces for a, b in ends for k in range(1, pieces + 1))])
        self.elements = [
            ((link * pieces + k, link * (pieces + 1) + k), (link * pieces + k + 1, link * (pieces + 1) + k + 1))
            for link in range(3)
            for k in range(pieces)
        ]
        self.loaded = pieces + pieces // 2
        moves, turns = 2 * (3 * pieces + 1), 3 * (pieces + 1)
        held = {0, 1, moves - 2, moves - 1, moves}
        self.free = [k for k in range(moves + turns) if k not in held]
        self.moves = moves

    def forces(self, state: Array) -> Array:
        """Internal forces and moments minus the load on the free coordinates, of states (..., coordinates)."""
        moved, turned = state[..., : self.moves].reshape(*state.shape[:-1], -1, 2), state[..., self.moves :]
        out = np.zeros_like(state)
        for (i, r), (j, s) in self.elements:
            start, now = self.places[j] - self.places[i], self.places[j] - self.places[i]
            now = now + moved[..., j, :] - moved[..., i, :]
            length, reach = np.hypot(*start), np.hypot(now[..., 0], now[..., 1])
            chord = np.angle((now @ [1.0, 1.0j]) / (start @ [1.0, 1.0j]))
            first, second = turned[..., r] - chord, turned[..., s] - chord
            ends = BENDING / length * np.array([4.0 * first + 2.0 * second, 2.0 * first + 4.0 * second])
            along = now / reach[..., None]
            across = np.stack([-along[..., 1], along[..., 0]], axis=-1)
            pull = (AREA * (reach - length) / length)[..., None] * along - (ends.sum(axis=0) / reach)[
                ..., None
            ] * across
            out[..., 2 * j : 2 * j + 2] += pull
            out[..., 2 * i : 2 * i + 2] -= pull
            out[..., self.moves + r] += ends[0]
            out[..., self.moves + s] += ends[1]
        out[..., 2 * self.loaded + 1] -= FORCE
        return out[..., self.free]

    def displacement(self, turn: float) -> Array:
        """Displacement of P by Newton's method from a coupler that has turned, its rocker closing the loop."""
        n, state = self.pieces, np.zeros(self.moves + 3 * (self.pieces + 1))
        pin = LENGTH * np.exp(1j * self.theta)
        way = np.angle((pin + 2.0 * LENGTH * np.exp(1j * turn) - 2.0 * LENGTH) / (pin / LENGTH))
        for link, (centre, angle) in enumerate(((0.0, 0.0), (pin, turn), (2.0 * LENGTH, way))):
            for k in range(link * n + 1, link * n + n + 1):
                arm = self.places[k] @ [1.0, 1.0j] - centre
                gone = arm * (np.exp(1j * angle) - 1.0)
                state[2 * k : 2 * k + 2] = [gone.real, gone.imag]
            state[self.moves + link * (n + 1) : self.moves + (link + 1) * (n + 1)] = angle
        state[self.moves - 2 : self.moves] = 0.0
        for _ in range(60):
            off = self.forces(state)
            if np.abs(off).max() < 1e-7:
                return state[2 * self.loaded : 2 * self.loaded + 2]
            steps = 1e-8 * np.eye(len(state))[self.free]
            slope = (self.forces(state + steps) - self.forces(state - steps)).T / 2e-8
            change = np.linalg.solve(slope, -off)
            state[self.free] += change * min(1.0, 0.01 / np.abs(change).max())
        raise AssertionError("no equilibrium was found")


@pytest.mark.parametrize(("pose", "angle", "turn"), [(0, 0.0, 0.024), (18, np.pi, 0.012)])
def test_displacement_at_singular_poses_is_that_of_all_links_and_joints(pose: int, angle: float, turn: float) -> None:
    """To the element's own error; crank and coupler bend, which the stretching of one line leaves out."""
    found = job().large_mean_inputs[pose, :2]
    assert_allclose(found, Corotational(angle, 4).displacement(turn), rtol=2e-3)
    shown = next(row for row in table_rows("θ | κ | displacement of P, mm") if row[0] == f"{np.degrees(angle):g}°")
    assert shown[2] == f"({1e3 * found[0]:+.4f}, {1e3 * found[1]:+.3f})"


# -- the envelope -----------------------------------------------------------------------------------------------------


def drawn_outlines(figure: object) -> list[Array]:
    axes = figure.axes[0]  # type: ignore[attr-defined]
    return [patch.get_xy() for patch in axes.patches if patch.get_gid() == ENVELOPE]


def outside(outlines: list[Array], places: Array) -> int:
    """How many places (..., 2) lie in none of the outlines, which are convex and run to the left."""
    flat = places.reshape(-1, 2)
    inside = np.zeros(len(flat), dtype=bool)
    for outline in outlines:
        edges, arms = np.diff(outline, axis=0), flat[:, None] - outline[:-1]
        inside |= np.all(edges[:, 0] * arms[..., 1] - edges[:, 1] * arms[..., 0] > -1e-9, axis=1)
    return int(np.count_nonzero(~inside))


def test_no_sample_is_drawn_outside_the_envelope() -> None:
    """At all poses and half way to the next one; 400 of 3400 were, 66 of 100 at 350 degrees."""
    result = job()
    flat = (each[..., :2] for each in (result.path, result.rigid, result.samples))
    figure = draw_trajectories([TracedPoint("P", "xy", *flat)], 10.0, 3, "θ = 30°")
    outlines = drawn_outlines(figure)
    drawn = 1e3 * (result.rigid[:, None, :2] + 10.0 * result.samples[..., :2])
    half = 0.5 * (drawn[:-1] + drawn[1:])
    for places in (drawn, half):
        there = places[np.isfinite(places).all(axis=(1, 2))]
        assert outside(outlines, there) == 0
    # It is no wider than the samples: scaled up by 2 % about the rigid path they do not fit.
    wider = 1e3 * (result.rigid[result.regular, None, :2] + 10.2 * result.samples[result.regular, :, :2])
    assert outside(outlines, wider) > 50


def test_limits_of_the_axes_hold_the_envelope(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its corners are taken together: add_patch would look for extrema along each edge of each outline."""
    patches: list[object] = []
    kept = Axes.add_patch
    monkeypatch.setattr(Axes, "add_patch", lambda axes, patch: (patches.append(patch), kept(axes, patch))[1])
    places = np.linspace(0.0, 1.0, 20)[:, None, None] + np.zeros((20, 5, 2)) + 1e-2 * np.eye(5, 2)
    figure = Figure()
    axes = figure.add_subplot()
    _envelope(axes, places)
    outlines = np.concatenate(drawn_outlines(figure))
    assert not patches
    assert_allclose(axes.dataLim.get_points(), [outlines.min(axis=0), outlines.max(axis=0)])
    low, high = zip(axes.get_xlim(), axes.get_ylim(), strict=True)
    assert (np.array(low) < outlines.min(axis=0)).all()
    assert (np.array(high) > outlines.max(axis=0)).all()


@pytest.mark.parametrize("count", [2, 3])
def test_few_samples_in_one_line_have_an_envelope(count: int) -> None:
    rigid = np.array([[0.0, 0.0], [0.1, 0.0], [0.2, np.nan], [0.3, 0.0]])
    samples = np.linspace(-1e-3, 1e-3, count)[:, None] * np.array([1.0, 2.0]) * np.ones((4, 1, 1))
    samples[2] = np.nan
    samples = np.concatenate([samples, np.full((4, 1, 2), np.nan)], axis=1)
    outlines = drawn_outlines(draw_trajectories([TracedPoint("P", "xy", rigid, rigid, samples)], 1.0, 0, "there"))
    assert len(outlines) == 2, "one for the step from the first pose to the second, one for the last alone"
    places = 1e3 * (rigid[[0, 1, 3], None] + samples[[0, 1, 3], :count])
    assert outside(outlines, places) == 0


# -- standard errors --------------------------------------------------------------------------------------------------


def test_sampled_numbers_are_printed_with_their_standard_errors() -> None:
    """The errors of mean and deviation by the bootstrap, to its own; the cells by their definition."""
    result = job()
    draws = np.random.default_rng(1).integers(100, size=(2000, 100))
    again = result.samples[3, :, :2][draws]
    assert_allclose(result.standard_error[3, :2], again.mean(axis=1).std(axis=0), rtol=0.1)
    assert_allclose(result.std_standard_error[3, :2], again.std(axis=1, ddof=1).std(axis=0), rtol=0.15)
    for shown in (as_text(result), as_markdown(result)):
        line = next(line for line in shown.splitlines() if re.match(r"\|? *30 ", line))
        for value, error in zip(result.mean[3, :2], result.standard_error[3, :2], strict=True):
            assert f"{value:.6f}({error * 1e6:.0f})" in line
        assert "7.62(24)e-04" in line
    rows = list(csv.DictReader(as_csv(result).splitlines()))
    assert float(rows[3]["se_sigma_x_m"]) == result.std_standard_error[3, 0]
    assert float(rows[3]["se_large_mu_y_m"]) == result.large.standard_error[3, 1]
    for row in table_rows("part"):
        assert row[0].endswith("whole population") or all("±" in cell for cell in row[1:])
    for row in table_rows("choice"):
        assert "±" in row[2]
        assert "±" in row[3]
    title = draw_histograms([(result.samples[3], ("P", "xy"))], "θ = 30°").axes[0].get_title(loc="left")
    assert f"σ = {1e3 * result.std[3, 0]:.3f} ± {1e3 * result.std_standard_error[3, 0]:.3f} mm" in title
    assert "All poses share the same 100 draws" in text()
    assert "certain digits" not in text()
    assert all("…" in row[-1] for row in table_rows("column") if row[0][0] in "μσ")


@pytest.mark.parametrize(
    ("value", "error", "form", "wanted"),
    [
        (0.1865371, 7.6e-5, "z.6f", "0.186537(76)"),
        (1.1905e-3, 7.24e-5, ".2e", "1.19(7)e-03"),
        (-0.0, 0.0, "z.3f", "0.000(0)"),
        (1.0, 1e-9, ".3f", "1.000(<1)"),
        (1.0, np.nan, ".1f", "1.0"),
        (np.nan, 1.0, ".1f", "–"),
        (1.83e-6, 7.626e-5, ".2e", "0.18(763)e-05"),
        (0.0, 2e3, ".1e", "0.0(20)e+03"),
    ],
)
def test_a_number_with_its_error(value: float, error: float, form: str, wanted: str) -> None:
    assert with_error(value, error, form) == wanted


def test_the_population_has_another_spread_than_its_samples() -> None:
    """0.708 mm where 100 samples of this seed say 0.762: by quadrature over ε and γ."""
    nodes, weights = np.polynomial.hermite_e.hermegauss(120)
    weights = weights / weights.sum()
    turned = np.exp(1j * (np.pi + 1.3 * nodes))
    mean, square = (1e-3 * weights @ turned), (1e-6 + 25e-10) * weights @ (turned**2)
    wanted = np.zeros((2, 2))
    wanted[0, 0] = 0.5 * (1e-6 + 25e-10 + square.real) - mean.real**2
    wanted[1, 1] = 0.5 * (1e-6 + 25e-10 - square.real) - mean.imag**2
    wanted[0, 1] = wanted[1, 0] = 0.5 * square.imag - mean.real * mean.imag
    assert_allclose(offset_covariance(1e-3, 5e-5, np.pi, 1.3), wanted, atol=1e-18)
    many = compute(Inputs(samples=20000, poses=(30.0, 30.0, 1.0)), large=False)
    found = run_std(many.inputs, many.motion)
    assert found is not None
    spread = many.study.clearance
    assert np.all(np.abs(found - spread.std[:, :2]) < 4.0 * spread.std_standard_error[:, :2])
    assert_allclose(1e3 * found[0, 0], 0.708, atol=5e-4)


# -- condition numbers ------------------------------------------------------------------------------------------------


def plane_matrix(theta: float) -> Array:
    """The plane's 18 x 18 as the paper assembles it: four beams, three springs between twin nodes."""
    pin, over = LENGTH * np.array([np.cos(theta), np.sin(theta)]), np.array([LENGTH, 0.0])
    places = [np.zeros(2), pin, pin, pin + over, pin + 2 * over, pin + 2 * over, 2 * over, 2 * over]
    matrix = np.zeros((24, 24))
    for i, j in ((0, 1), (2, 3), (3, 4), (5, 6)):
        length = np.hypot(*(places[j] - places[i]))
        x, y = (places[j] - places[i]) / length
        turn = np.kron(np.eye(2), np.array([[x, y, 0.0], [-y, x, 0.0], [0.0, 0.0, 1.0]]))
        a, b, c = AREA / length, 12.0 * BENDING / length**3, 6.0 * BENDING / length**2
        d = BENDING / length
        near = np.array([[a, 0.0, 0.0], [0.0, b, c], [0.0, c, 4.0 * d]])
        far = np.array([[-a, 0.0, 0.0], [0.0, -b, c], [0.0, -c, 2.0 * d]])
        end = near * np.array([[1, 1, 1], [1, 1, -1], [1, -1, 1]])
        at = np.r_[3 * i : 3 * i + 3, 3 * j : 3 * j + 3]
        matrix[np.ix_(at, at)] += turn.T @ np.block([[near, far], [far.T, end]]) @ turn
    for i, j in ((1, 2), (4, 5), (6, 7)):
        springs, at = np.diag([2e11, 2e11, 0.0]), np.r_[3 * i : 3 * i + 3, 3 * j : 3 * j + 3]
        matrix[np.ix_(at, at)] += np.block([[springs, -springs], [-springs, springs]])
    return matrix[3:21, 3:21]


def test_condition_numbers_in_the_plane_stand_beside_the_printed_ones() -> None:
    rows = {row[0]: row[1:] for row in table_rows("θ | κ | κ in the plane")}
    assert list(rows) == [f"{angle:g}°" for angle in printed().theta[printed().regular]]
    for angle in (30.0, 90.0, 350.0):
        wanted = np.linalg.cond(plane_matrix(np.radians(angle)))
        assert_allclose(job().planar_kappa[int(angle) // 10], wanted, rtol=1e-6)
        assert float(rows[f"{angle:g}°"][1]) == pytest.approx(wanted, rel=1e-3)
    assert "random sample" not in text()
    assert "reaches none of them" in text()
    assert "the whole matrix's rises to" in text()
    assert "in the plane falls to" in text()
    assert "the printed one falls to 0.52" in text()


# -- readings of the clearances ---------------------------------------------------------------------------------------


def test_the_reading_that_fits_best_is_found_and_told() -> None:
    """Two chains averaged without closing the loop, ε on the diameter, by drawing clearances."""
    rng = np.random.default_rng(0)
    gap = 0.5 * (1e-3 + 5e-5 * rng.standard_normal((3, 200_000)))
    offsets = gap * np.exp(1j * (np.pi + np.pi * rng.standard_normal((3, 200_000))))
    point = 0.5 * (offsets[0] - (offsets[1] + offsets[2]))
    table = printed()
    theirs = np.stack([table.std_x, table.std_y], axis=-1)[table.regular]
    found = readings(table)
    best = max(found, key=lambda each: each.equal(theirs))
    assert best.name == f"{AVERAGED}; a draw for each joint; ε on the diameter"
    assert_allclose(best.std, np.broadcast_to([point.real.std(), point.imag.std()], best.std.shape), rtol=0.01)
    assert best.equal(theirs) == 9
    rows = {row[0]: row[1:] for row in table_rows("reading")}
    assert rows[best.name] == ["0.307", "0.307", "9"]
    assert sum(row[-1] == "9" for row in rows.values()) == 1
    assert f"best is *{best.name}*: σ_x is 0.307 mm and σ_y 0.307 mm, and 9 of the 14" in text()


def test_no_closed_loop_gives_the_row_at_350_degrees() -> None:
    """One clearance on the diameter alone gives σ_y 1.02 mm: P moves by half of what the pin D does across its link."""
    least = min(each.std[6, 1] for each in readings(printed()) if each.closed)
    one = 0.5e-3 * np.sqrt(0.5 * (1.0 + 0.05**2))  # of the offset along the rocker
    assert least == pytest.approx(0.5 * one / np.sin(np.radians(10.0)), rel=1e-4)
    assert f"the least σ_y there is {1e3 * least:.2f} mm, and 0.4 mm are printed" in text()


def test_the_map_of_clearances_is_that_of_the_loop_closed_anew() -> None:
    """By differences of the exact closure, on a linkage without symmetry."""
    motion = FourBar(0.3, 0.9, 0.8, 0.7, point=(0.5, 0.2), branch="open").move(np.radians([40.0, 110.0]))
    from linkframe.models.four_bar.clearance import clearance_displacement

    for joint, columns in clearance_map(motion).items():
        for k, step in enumerate((1e-6, 1e-6j)):
            ways = [
                clearance_displacement(motion, {name: sign * step * (name == joint) * np.ones(2) for name in "BDE"})
                for sign in (1.0, -1.0)
            ]
            assert_allclose(columns[..., k], (ways[0] - ways[1])[:, :2] / 2e-6, atol=1e-8)


def test_the_map_of_clearances_is_what_the_joints_carry_of_unit_loads() -> None:
    """Virtual work: a unit load works on the displacement of P as the force in the joint does on its offset."""
    point = (0.5, 0.2)
    motion = FourBar(0.3, 0.9, 0.8, 0.7, point=point, branch="crossed").move(np.radians([[40.0], [110.0]]))
    unit = motion.reactions(coupler=Link(force=(np.array([1.0, 0.0]), np.array([0.0, 1.0])), at=point))
    for joint, columns in clearance_map(motion).items():
        assert_allclose(columns[:, 0], unit.reaction(joint)[..., :2], rtol=1e-12, atol=1e-13)


# -- what the paper prints ---------------------------------------------------------------------------------------------


def test_printed_offsets_are_told_as_a_turn_of_the_crank() -> None:
    table = printed()
    place = table.mean_x - LENGTH + 1j * table.mean_y
    turn = np.degrees(np.angle(place / np.exp(1j * np.radians(table.theta))))
    rows = {row[0]: row for row in table_rows("θ | printed, x")}
    for angle, each, radius in zip(table.theta, turn, np.abs(place), strict=True):
        if angle % 180.0:
            assert float(rows[f"{angle:g}°"][5].rstrip("°")) == pytest.approx(each, abs=0.051)
            assert float(rows[f"{angle:g}°"][6]) == pytest.approx(1e3 * (radius - LENGTH), abs=0.051)
    assert "At 60°, 90°, 150° the printed offsets are a turn of P by −2.1 to −2.3°" in text()
    # With the crank held and the coupler along x, the pin B alone moves P along x.
    assert "move P along x by 1.00 mm at most at these poses, and 4.0 mm are printed" in text()


def test_all_x_in_a_row_are_measured_from_a() -> None:
    rows = list(csv.DictReader(as_csv(job()).splitlines()))
    for row in rows:
        if row["printed_mu_x"] and row["mu_x_m"]:
            assert abs(float(row["printed_mu_x"]) - float(row["mu_x_m"])) < 5e-3
    assert "− l |" not in as_markdown(job())
    assert float(rows[9]["printed_mu_x"]) == 0.104


def test_the_distance_of_first_order_from_the_closed_loop_is_a_distance() -> None:
    study = job().study
    off = study.clearance_exact.samples[3] - study.clearance.samples[3]
    assert f"within {1e3 * np.sqrt((off**2).sum(axis=-1)).max():.4f} mm" in text()


# -- large displacement, reactions ------------------------------------------------------------------------------------


def test_samples_that_end_on_the_other_side_are_named() -> None:
    """Those at 350 degrees by the position of P: the coupler has turned beyond the line from B to E."""
    result = job()
    passed = result.large.passed
    pin = LENGTH * np.exp(1j * np.radians(350.0))
    moved = result.large.samples[35]
    turned = np.angle((LENGTH + moved[:, 0] + 1j * moved[:, 1]) / LENGTH)
    beyond = turned > np.angle(2.0 * LENGTH - pin)
    assert_allclose(np.flatnonzero(beyond), [31])
    assert_allclose(np.flatnonzero(passed[35]), [31])
    assert not passed[~result.singular][:, :].all(axis=1).any()
    assert not passed[result.singular].any()
    assert not passed[3:16].any()
    told = [sentence for sentence in passages(result) if sentence.startswith("At 350°")]
    assert len(told) == 1
    assert "number 31 of samples.npz" in told[0]
    rest = np.delete(moved[:, :2], 31, axis=0).std(axis=0, ddof=1)
    assert f"{rest[0]:.2e} and {rest[1]:.2e} m" in told[0]
    assert told[0] in text()


def test_reactions_are_those_of_statics() -> None:
    """Of the free bodies: rocker and coupler carry forces that balance the load, the crank's moment is the drive's."""
    result = job()
    rows = list(csv.DictReader(reactions.as_csv(result).splitlines()))
    assert list(rows[0]) == list(reactions.COLUMNS)
    for angle, row in zip(result.degrees, rows, strict=True):
        values = [row[name] for name in reactions.COLUMNS[1:-1]]
        if angle % 180.0 == 0.0:
            assert set(values) == {""}
            assert row["status"].startswith("singular")
            continue
        theta = np.radians(angle)
        # The rocker has two forces; the load in the middle of the coupler is shared by its ends.
        along = np.array([np.cos(theta), np.sin(theta)]) * (-0.5 * FORCE / np.sin(theta))
        pin = np.array([0.0, -FORCE]) - along
        torque = LENGTH * (np.cos(theta) * pin[1] - np.sin(theta) * pin[0])
        wanted = [*pin, *(-pin), *along, *along, torque]
        assert_allclose([float(value) for value in values], wanted, rtol=1e-11, atol=1e-10)
    shown = {row[0]: row[1:] for row in table_rows("θ | Ax | Ay")}
    assert shown["30"][-2] == "-8.6603"
    assert reactions.summary(result) in text()
    figure = reactions.draw(result)
    assert figure.axes[0].get_legend().get_texts()[0].get_text() == "A, B, D, E"  # type: ignore[union-attr]
    assert_allclose(figure.axes[1].lines[-1].get_ydata()[3], -8.6602540378, rtol=1e-9)  # type: ignore[index]


# -- a run that is not the paper's ------------------------------------------------------------------------------------


def test_other_runs_are_told_without_the_numbers_that_they_lack() -> None:
    inputs = Inputs(samples=4, poses=(20.0, 60.0, 40.0), rocker=0.12, stiffness=np.inf, stiffness_sd=0.0)
    result = compute(inputs.but(contact="reaction"))
    told = report(result).text({}, [], {})
    assert "nan" not in told
    assert "κ in the plane | printed κ" not in told
    assert len(points(result)) > 8
