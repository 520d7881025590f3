"""Clearance at a contact angle that is given: `linkframe run` does for the paper's four-bar what its own job does."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pytest
from linkframe.elements import Beam, Material, Rectangle
from linkframe.framework import FrameError
from linkframe.models import FourBar, Linkage, accuracy, monte_carlo, read_linkage, write_linkage
from linkframe.models.linkage.job.inputs import read_inputs
from linkframe.models.linkage.job.report import report
from linkframe.models.linkage.job.result import RunResult, compute
from linkframe.models.linkage.job.table import as_text
from linkframe.models.paper.inputs import Inputs
from linkframe.models.paper.result import Result as FourBarResult
from linkframe.models.paper.result import compute as compute_four_bar
from linkframe.models.paper.study import distributions, four_bar
from numpy.testing import assert_allclose, assert_array_equal

EXAMPLE = Path(__file__).parents[2] / "examples" / "four_bar.toml"
GAP = 1e-3
BAR = Beam(Rectangle(y=0.0127, z=0.00635), Material(E=2e11, nu=0.3))


@cache
def from_file() -> RunResult:
    return compute(read_inputs(EXAMPLE))


@cache
def from_job() -> FourBarResult:
    return compute_four_bar(Inputs(), large=False)


def drawn(contact: float | np.ndarray | None = None, **more: object) -> Linkage:
    """The paper's four-bar, drawn at 60 degrees, with clearance in all its passive joints."""
    height = 0.1 * np.sin(np.radians(60.0))
    linkage = Linkage(A=(0, 0), B=(0.05, height), P=(0.15, height), D=(0.25, height), E=(0.2, 0))
    for name, points in (("crank", "AB"), ("coupler", "BPD"), ("rocker", "DE")):
        linkage.link(name, *points, beam=BAR)
    linkage.revolute("A", "ground", "crank", drive=True, reference=np.radians(60.0))
    for point, *links in (("B", "crank", "coupler"), ("D", "coupler", "rocker"), ("E", "rocker", "ground")):
        linkage.revolute(point, *links, stiffness=(2e11,) * 5 + (0.0,), clearance=GAP, contact=contact, **more)  # type: ignore[arg-type]
    return linkage


# -- one job beside the other -----------------------------------------------------------------------------------------


def test_the_example_file_has_the_samples_of_the_four_bar_job() -> None:
    """The same inputs by the same names, hence the same draws: all samples agree, not only their mean and spread."""
    ours, theirs = from_file().spread["P"], from_job()
    regular = theirs.regular
    assert np.count_nonzero(regular) == 34
    assert_allclose(ours.samples[regular], theirs.samples[regular], rtol=0.0, atol=1e-12)
    assert_allclose(ours.mean[regular], theirs.study.mean[regular], rtol=0.0, atol=1e-13)
    assert_allclose(ours.std[regular], theirs.std[regular], rtol=0.0, atol=1e-13)
    assert np.isnan(ours.mean[~regular]).all()


def test_means_and_deviations_agree_for_other_draws(tmp_path: Path) -> None:
    """By another name and seed, within four standard errors."""
    text = EXAMPLE.read_text(encoding="utf-8").replace('tolerances."', 'tolerances."own ').replace("rng = 0", "rng = 7")
    (tmp_path / "other.toml").write_text(text, encoding="utf-8")
    ours = compute(read_inputs(tmp_path / "other.toml")).spread["P"]
    theirs, kept = from_job().study, from_job().regular
    for value, error in (("mean", "standard_error"), ("std", "std_standard_error")):
        off = np.abs(getattr(ours, value) - getattr(theirs, value))[kept, :2]
        doubt = np.hypot(getattr(ours, error), getattr(theirs, error))[kept, :2]
        assert np.all(off < 4.0 * doubt), value
        assert np.any(off > 0.01 * doubt), "the draws are others"


def test_the_report_and_the_table_tell_the_contact_and_the_means() -> None:
    result = from_file()
    told = report(result).text({}, [], {})
    assert "Contact angles of the clearances as the file gives them: B 180°, D 180°, E 180°." in told
    spread = result.spread["P"]
    row = next(line for line in as_text(result).splitlines() if line.strip().startswith("30 "))
    assert f"{spread.mean[3, 1]:.2e}"[:4] in row
    heading = as_text(result).splitlines()[0].split("  ")
    assert {"mean u_x", "mean u_y"} <= {word.strip() for word in heading}
    mean, error = 1e3 * spread.mean[3, 0], 1e3 * spread.standard_error[3, 0]
    assert f"| mean of samples | {mean:.4g} ± {error:.4g} |" in told


def test_without_contact_angles_the_file_is_the_contact_in_equilibrium(tmp_path: Path) -> None:
    lines = EXAMPLE.read_text(encoding="utf-8").split('\n[tolerances."contact.B"]')[0].splitlines()
    text = "\n".join(line for line in lines if not line.startswith("contact"))
    (tmp_path / "pressed.toml").write_text(text.replace("samples = 100", "samples = 5"), encoding="utf-8")
    result = compute(read_inputs(tmp_path / "pressed.toml"))
    inputs = Inputs(contact="equilibrium", samples=5)
    theirs = monte_carlo(
        four_bar(inputs),
        inputs.theta,
        distributions(inputs, 1.0),
        load=(0.0, 100.0, 0.0),
        clearance=GAP,
        contact="equilibrium",
        n=5,
        rng=0,
    )
    kept = theirs.status == "regular"
    assert_allclose(result.spread["P"].samples[kept], theirs.samples[kept], rtol=1e-6, atol=1e-12)
    told = report(result).text({}, [], {})
    assert "Contact of the clearances by equilibrium under the load: B, D, E." in told


# -- the description --------------------------------------------------------------------------------------------------


def test_a_contact_angle_is_an_offset_that_does_not_turn_with_the_linkage() -> None:
    """Against `accuracy` of the four-bar at all poses and angles, in a batch of both."""
    theta, contact = np.radians([30.0, 100.0, 200.0]), np.radians([0.0, 70.0, 250.0, 310.0])
    linkage = drawn(contact)
    linkage.load("P", fy=100.0)
    found = linkage.move(A=theta[:, None]).accuracy("P")
    wanted = accuracy(FourBar(), theta[:, None], load=(0.0, 100.0, 0.0), clearance=GAP, contact=contact)
    assert_allclose(found.clearance[..., :3], wanted.clearance, rtol=0.0, atol=1e-13)
    assert_allclose(found.compliance[..., :3], np.broadcast_to(wanted.compliance, (3, 4, 3)), rtol=0.0, atol=1e-13)


def test_what_holds_with_closed_clearances_knows_of_no_contact_angle() -> None:
    theta = np.radians([30.0, 100.0])
    given, ideal = (drawn(contact).move(A=theta) for contact in (0.7, None))
    assert_allclose(given.compliance_matrix("P"), ideal.compliance_matrix("P"), rtol=1e-12, atol=1e-20)
    for motion in (given, ideal):
        motion.linkage.load("P", fy=100.0)
    assert_allclose(given.stress("coupler").values, ideal.stress("coupler").values, rtol=1e-9, atol=1e-3)
    assert_allclose(given.accuracy("P").compliance, ideal.accuracy("P").compliance, rtol=1e-12, atol=1e-20)
    closed = given.frame(clearance=False).solve().displacement("P")
    assert_allclose(closed, given.accuracy("P").compliance, rtol=1e-12, atol=1e-20)
    assert_allclose(given.frame().solve().displacement("P"), given.accuracy("P").total, rtol=1e-12, atol=1e-20)


def test_contact_angles_are_written_and_read(tmp_path: Path) -> None:
    write_linkage(drawn(0.7), tmp_path / "drawn.toml")
    again = read_linkage(tmp_path / "drawn.toml")
    assert_array_equal(np.asarray(again.joints["D"].contact), 0.7)
    assert again.joints["A"].contact is None


def test_contact_angles_that_cannot_be_meant_are_refused(tmp_path: Path) -> None:
    linkage = Linkage(A=(0, 0), B=(1, 0))
    linkage.link("arm", "A", "B")
    with pytest.raises(FrameError, match="joint 'A' has a contact angle and no clearance: give its clearance"):
        linkage.revolute("A", "ground", "arm", contact=0.3)
    assert not linkage.joints
    text = EXAMPLE.read_text(encoding="utf-8").replace('kind = "revolute"\npoint = "E"', 'kind = "fixed"\npoint = "E"')
    (tmp_path / "fixed.toml").write_text(text, encoding="utf-8")
    with pytest.raises(FrameError, match=r"joints\.E\.contact: a fixed joint has no contact"):
        read_inputs(tmp_path / "fixed.toml")


def test_a_contact_angle_needs_an_axis_that_keeps_its_direction() -> None:
    """A pin that a turning post carries about another axis."""
    linkage = Linkage(A=(0, 0, 0), B=(0, 0, 0.3), C=(0.2, 0, 0.3))
    linkage.link("post", "A", "B", beam=BAR)
    linkage.link("arm", "B", "C", beam=BAR)
    linkage.revolute("A", "ground", "post", drive=True)
    linkage.revolute("B", "post", "arm", axis=(0, 1, 0), drive=True, clearance=1e-4, contact=0.2)
    linkage.load("C", fz=-1.0)
    assert np.isfinite(linkage.move(A=0.0, B=[0.0, 0.5]).accuracy("C").total).all()
    with pytest.raises(FrameError, match="joint 'B': a contact angle is measured about the joint's axis"):
        _ = linkage.move(A=0.5, B=0.0).accuracy("C").total
