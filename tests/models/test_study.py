"""Monte Carlo of the four-bar: exact moments through the linear map, same bits, poses left out with their status."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.elements import Beam, Material, Rectangle
from linkframe.framework.errors import FrameError, MechanismWarning
from linkframe.models import FourBar, accuracy, monte_carlo, propagate
from linkframe.models.moments import Moments
from numpy.testing import assert_allclose, assert_array_equal
from scipy import stats

THETA = np.radians([30.0, 60.0, 150.0, 230.0])
ROCKING = FourBar(0.3, 0.9, 0.8, 0.7, point=(0.5, 0.2), branch="open")
CLEARANCE = stats.norm(1e-3, 5e-5)
CONTACT = stats.norm(np.pi, 1.0)
PAIR = ("clearance", "contact")
STIFF = stats.norm(2e8, 1e6)
SINGULAR = "singular (direct-kinematic, type II): coupler and rocker in line"
PAPER = {"stiffness": stats.norm(2e11, 1e10), "clearance": CLEARANCE, "contact": CONTACT, "fy": stats.norm(100.0, 5.0)}


def contact_moments(mean, std, angle, spread):
    """Mean (2,) and covariance (2, 2) of eps (cos gamma, sin gamma), eps and gamma normal and independent."""
    fade = np.exp(-(spread**2) / 2)
    first = mean * fade * np.array([np.cos(angle), np.sin(angle)])
    double = fade**4 * np.array([np.cos(2 * angle), np.sin(2 * angle)])
    second = 0.5 * (mean**2 + std**2) * np.array([[1 + double[0], double[1]], [double[1], 1 - double[0]]])
    return first, second - np.outer(first, first)


def maps(motion):
    """Displacement of P per unit offset in each joint, {joint: (poses, 2, 2)}, from rigid-body velocities."""
    b, d, e, p = (motion.position(name)[..., 0] + 1j * motion.position(name)[..., 1] for name in "BDEP")
    u, w = d - b, d - e
    columns = {joint: [] for joint in "BDE"}
    for slide in (1.0, 1j):
        turn = -(slide * np.conj(w)).real / (1j * u * np.conj(w)).real
        for joint in "BDE":
            moved = (slide if joint == "B" else 0.0) + 1j * turn * (p - b)
            columns[joint].append(np.stack([moved.real, moved.imag], axis=-1))
    return {joint: np.stack(pair, axis=-1) for joint, pair in columns.items()}


def check_moments(study, each, mean, covariance):
    """Moments within four standard errors; each sample is the linear map of its own offsets."""
    found = study.clearance
    drawn = [[study.inputs.get(f"{name}.{joint}", study.inputs.get(name)) for joint in "BDE"] for name in PAIR]
    offsets = np.stack([drawn[0] * np.cos(drawn[1]), drawn[0] * np.sin(drawn[1])], axis=-1)
    assert_allclose(found.samples[..., :2], np.einsum("jpab,jnb->pna", [each[j] for j in "BDE"], offsets), atol=1e-12)
    spread = np.sqrt(np.diagonal(covariance, axis1=-2, axis2=-1))
    assert_allclose(found.standard_error[:, :2], spread / np.sqrt(study.n), rtol=0.1)
    assert np.all(np.abs(found.mean[:, :2] - mean) < 4 * spread / np.sqrt(study.n))
    assert np.all(np.abs(found.std[:, :2] - spread) < 4 * found.std_standard_error[:, :2])


# -- exact moments ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("four_bar", [FourBar(), ROCKING])
def test_clearance_shared_by_the_joints_has_its_exact_moments(four_bar):
    study = monte_carlo(four_bar, THETA, {"clearance": CLEARANCE, "contact": CONTACT}, n=1000, rng=0)
    each = maps(four_bar.move(THETA))
    total = sum(each.values())
    mean, covariance = contact_moments(1e-3, 5e-5, np.pi, 1.0)
    check_moments(study, each, total @ mean, total @ covariance @ np.swapaxes(total, -1, -2))


@pytest.mark.parametrize("four_bar", [FourBar(), ROCKING])
def test_clearance_of_each_joint_its_own_has_its_exact_moments(four_bar):
    own = {f"{name}.{joint}": law for name, law in (("clearance", CLEARANCE), ("contact", CONTACT)) for joint in "BDE"}
    study = monte_carlo(four_bar, THETA, own, n=1000, rng=1)
    each = maps(four_bar.move(THETA))
    mean, covariance = contact_moments(1e-3, 5e-5, np.pi, 1.0)
    spread = sum(a @ covariance @ np.swapaxes(a, -1, -2) for a in each.values())
    check_moments(study, each, sum(each.values()) @ mean, spread)


def test_compliance_is_linear_in_the_load():
    nominal = accuracy(ROCKING, THETA, load=(0.0, 1.0, 0.0)).compliance
    study = monte_carlo(ROCKING, THETA, {"fy": stats.norm(100.0, 5.0)}, n=300, rng=3)
    assert_allclose(study.samples, nominal[:, None] * study.inputs["fy"][:, None], rtol=1e-11, atol=1e-20)
    error = 5.0 * np.abs(nominal) / np.sqrt(study.n)
    assert np.all(np.abs(study.mean - 100.0 * nominal)[:, :2] < 4 * error[:, :2])
    assert_allclose(study.std[:, :2], 5.0 * np.abs(nominal)[:, :2], rtol=4 / np.sqrt(2 * study.n))
    assert_array_equal(study.clearance.samples, np.zeros((4, 300, 3)))


# -- every parameter --------------------------------------------------------------------------------------------------


LENGTHS = dict(zip(("crank", "coupler", "rocker", "ground"), ROCKING.lengths, strict=True))
OF_JOINTS = ("", ".B", ".D", ".E")
LAWS = {name: stats.uniform(value, 0.01 * value) for name, value in LENGTHS.items()}
LAWS |= {"drive": stats.norm(0.0, 1e-3), "fx": stats.norm(10.0, 1.0), "mz": stats.norm(1.0, 0.1)}
LAWS |= {f"E{link}": stats.norm(2e11, 1e10) for link in ("", ".crank", ".coupler", ".rocker")}
LAWS |= {f"{k}{joint}": stats.uniform(1e7, 1e7) for k in ("stiffness", "ktx", "kty") for joint in OF_JOINTS}
LAWS |= {f"{name}{joint}": stats.uniform(1e-4, 1e-4) for name in ("clearance", "contact") for joint in OF_JOINTS}


@pytest.mark.parametrize(("name", "law"), list(LAWS.items()))
def test_every_parameter_is_that_of_accuracy(name, law):
    """A sample of the study is `accuracy` of the linkage with just that number."""
    given = {"load": (5.0, 100.0, 0.5), "clearance": 1e-4, "contact": 0.4}
    study = monte_carlo(ROCKING, THETA, {name: law}, n=5, rng=2, **given)
    value = study.inputs[name][3]
    changed, theta = one(name, value, given)
    alone = accuracy(changed, theta, **given)
    samples = alone.total + alone.rigid - ROCKING.move(THETA).position("P")
    assert_allclose(study.samples[:, 3], samples, rtol=1e-9, atol=1e-15)
    assert np.all(study.std[:, :2].max(axis=-1) > 0.0)


def one(name, value, given):
    """The linkage and poses with one number changed, by hand; the load, clearance and contact in place."""
    kind, _, part = name.partition(".")
    lengths = dict(LENGTHS)
    beams = {link: ROCKING.link_beam(link) for link in ("crank", "coupler", "rocker")}
    springs = {joint: np.array(ROCKING.joint_stiffness(joint)) for joint in "BDE"}
    theta = THETA
    if kind in lengths:
        lengths[kind] = value
    elif kind == "drive":
        theta = THETA + value
    elif kind in ("fx", "fy", "mz"):
        load = list(given["load"])
        load[("fx", "fy", "mz").index(kind)] = value
        given["load"] = tuple(load)
    elif kind == "E":
        new = Beam(Rectangle(y=12.7e-3, z=6.35e-3), Material(E=value, nu=0.3))
        beams |= {link: new for link in beams if part in ("", link)}
    elif kind in ("clearance", "contact"):
        given[kind] = {joint: value if part in ("", joint) else given[kind] for joint in "BDE"}
    else:
        at = slice(0, 5) if kind == "stiffness" else ("ktx", "kty").index(kind)
        for joint in springs:
            if part in ("", joint):
                springs[joint][at] = value
    linkage = FourBar(**lengths, point=ROCKING.point, branch="open", beam=beams, stiffness=springs)
    return linkage, theta


def test_the_more_particular_name_rules():
    inputs = {"clearance": stats.uniform(1e-3, 1e-9), "clearance.D": stats.uniform(0.0, 1e-9)}
    study = monte_carlo(ROCKING, THETA, inputs, contact=0.4, n=3, rng=0)
    alone = accuracy(ROCKING, THETA, clearance={"B": 1e-3, "E": 1e-3}, contact=0.4)
    assert_allclose(study.mean, alone.clearance, atol=1e-8)


def test_free_and_ideal_springs_stay_so():
    springs = (2e8, 2e8, np.inf, np.inf, np.inf, 0.0)
    four_bar = FourBar(stiffness=springs)
    study = monte_carlo(four_bar, THETA, {"stiffness": stats.norm(1e8, 1e6)}, load=(0.0, 100.0, 0.0), n=4, rng=0)
    found = study.sampled.motion.four_bar.joint_stiffness("D")
    assert_array_equal(found[:, 2:], np.tile([np.inf, np.inf, np.inf, 0.0], (4, 1)))
    assert_array_equal(found[:, 0], study.inputs["stiffness"])


def test_an_uncertain_modulus_keeps_poisson_ratio_and_density():
    study = monte_carlo(FourBar(), THETA, {"E": stats.norm(1e11, 1e10)}, load=(0.0, 1.0, 0.0), n=4, rng=0)
    material = study.sampled.motion.four_bar.link_beam("rocker").material
    assert_array_equal(material.E, study.inputs["E"])
    assert_allclose(material.G, material.E / 2.6, rtol=1e-15)
    assert material.density == 7850.0


def test_an_uncertain_modulus_of_timber_takes_the_shear_modulus_with_it():
    """Whose Poisson's ratio by E / 2 G - 1 is 7."""
    timber = Beam(Rectangle(y=0.02, z=0.02), Material(E=11e9, G=690e6))
    study = monte_carlo(FourBar(beam=timber), THETA, {"E": stats.norm(11e9, 1e9)}, load=(0.0, 1.0, 0.0), n=4, rng=0)
    material = study.sampled.motion.four_bar.link_beam("rocker").material
    assert_allclose(material.G / material.E, 690e6 / 11e9, rtol=1e-15)


# -- parts, bits, statistics ------------------------------------------------------------------------------------------


def test_the_total_is_the_sum_of_its_parts():
    inputs = PAPER | {"crank": stats.norm(0.1, 1e-5), "rocker": stats.norm(0.1, 1e-5)}
    study = monte_carlo(FourBar(), THETA, inputs, n=20, rng=0)
    parts = study.geometry.samples + study.compliance.samples + study.clearance.samples
    assert_allclose(study.samples, parts, rtol=1e-13, atol=1e-20)
    exact = monte_carlo(FourBar(), THETA, inputs, n=20, rng=0, exact=True)
    assert_allclose(exact.samples - study.samples, exact.clearance_exact.samples - study.clearance.samples, atol=1e-16)
    assert np.abs(exact.samples - study.samples).max() > 1e-6


def test_same_seed_same_bits_and_an_input_more_changes_no_other():
    first = monte_carlo(FourBar(), THETA, PAPER, n=50, rng=4)
    again = monte_carlo(FourBar(), THETA, dict(reversed(PAPER.items())), n=50, rng=4)
    assert_array_equal(first.samples, again.samples)
    more = monte_carlo(FourBar(), THETA, PAPER | {"E": stats.norm(2e11, 1e9)}, n=50, rng=4)
    for name in PAPER:
        assert_array_equal(more.inputs[name], first.inputs[name])
    assert_array_equal(more.clearance_exact.samples, first.clearance_exact.samples)


def test_propagation_of_accuracy_draws_the_same_samples_in_flat_memory():
    def displacement(stiffness, clearance, contact, fy):
        springs = np.stack([stiffness] * 5 + [0 * stiffness], axis=-1)
        linkage = FourBar(stiffness=springs)
        return accuracy(linkage, THETA[:, None], load=(0.0, fy, 0.0), clearance=clearance, contact=contact).total

    study = monte_carlo(FourBar(), THETA, PAPER, n=300, rng=4)
    stream = propagate(displacement, PAPER, n=300, rng=4, axis=1, chunk=128, keep_samples=False)
    assert_allclose(stream.mean, study.mean, rtol=1e-11, atol=1e-18)
    assert_allclose(stream.std, study.std, rtol=1e-11, atol=1e-18)


def test_one_pose_of_many_is_the_pose_alone():
    many = monte_carlo(FourBar(), THETA, PAPER, n=30, rng=4)
    alone = monte_carlo(FourBar(), THETA[2], PAPER, n=30, rng=4)
    assert_allclose(many.samples[2], alone.samples[0], rtol=1e-12, atol=1e-20)


def test_statistics_are_those_of_the_samples():
    study = monte_carlo(FourBar(), THETA, PAPER, n=200, rng=0)
    assert study.samples.shape == (4, 200, 3)
    assert_allclose(study.mean, study.samples.mean(axis=1), rtol=1e-12, atol=1e-20)
    assert_allclose(study.std, study.samples.std(axis=1, ddof=1), rtol=1e-12)
    assert_allclose(study.standard_error, study.std / np.sqrt(200), rtol=1e-14)
    assert_allclose(study.std_standard_error, Moments.of(np.moveaxis(study.samples, 1, 0)).std_standard_error)
    low, high = study.envelope
    assert_array_equal(low, study.samples.min(axis=1))
    assert_array_equal(high, study.samples.max(axis=1))
    assert_allclose(study.quantile([0.0, 0.5, 1.0]), [low, np.median(study.samples, axis=1), high], rtol=1e-12)


@pytest.mark.parametrize("contact", ["reaction", "equilibrium"])
def test_contact_by_the_forces_follows_each_sample(contact):
    given = {"load": (0.0, 100.0, 0.0), "contact": contact}
    theta = np.radians([0.0, 60.0, 150.0, 180.0])
    study = monte_carlo(FourBar(), theta, {"clearance": CLEARANCE}, n=6, rng=0, **given)
    alone = accuracy(FourBar(), theta[1:3], clearance=study.inputs["clearance"][4], **given)
    assert_allclose(study.clearance.samples[1:3, 4], alone.clearance, rtol=1e-9, atol=1e-15)
    assert_array_equal(study.status, [SINGULAR, "regular", "regular", SINGULAR])
    assert study.kappa[0] > 1e14 > study.kappa[1]


def test_what_depends_on_the_pose_alone_is_not_repeated_over_samples():
    study = monte_carlo(FourBar(), THETA, PAPER, n=50, rng=0)
    frame = study.sampled.frame()
    assert frame.bodies["crank"].axes.shape == (4, 1, 3, 3)
    assert frame.nodes["D.coupler"].coordinates.shape == (3,)
    assert frame.shape == (4, 50)


# -- poses left out ---------------------------------------------------------------------------------------------------


def test_singular_poses_are_left_out_with_their_status():
    degrees = np.arange(0, 361, 30)
    study = monte_carlo(FourBar(), np.radians(degrees), PAPER, n=20, rng=0)
    singular = np.isin(degrees, [0, 180, 360])
    assert_array_equal(study.status, np.where(singular, SINGULAR, "regular"))
    for statistic in (study.mean, study.std, study.standard_error, study.quantile(0.9), *study.envelope):
        assert_array_equal(np.isnan(statistic).any(axis=-1), singular)
    assert not np.isnan(study.rigid).any()
    assert np.all(study.std[~singular, :2] < 0.1)


def test_samples_that_cannot_reach_a_pose_do_not_count_there():
    """Coupler and rocker reach 2.0; at 100° the diagonal of the nominal linkage is just short of it."""
    four_bar = FourBar(1.0, 1.0, 1.0, 1.5)
    theta = np.radians([60.0, 103.9])
    study = monte_carlo(four_bar, theta, {"ground": stats.norm(1.5, 0.01)}, n=40, rng=0)
    lost = np.count_nonzero(~FourBar(1.0, 1.0, 1.0, study.inputs["ground"]).assembles(theta[1]))
    assert 0 < lost < 40
    assert_array_equal(study.status, ["regular", f"not assembled in {lost} of 40 samples"])
    closes = FourBar(1.0, 1.0, 1.0, study.inputs["ground"]).assembles(theta[1])
    others = FourBar(1.0, 1.0, 1.0, study.inputs["ground"][closes]).move(theta[1]).position("P")
    nominal = four_bar.move(theta[1]).position("P")
    assert_allclose(study.mean[1], np.mean(others, axis=0) - nominal, rtol=1e-12, atol=1e-15)
    assert_array_equal(study.missing, [[0] * 3, [lost] * 3])
    strict = {"distributions": {"ground": stats.norm(1.5, 0.01)}, "n": 40, "rng": 0}
    assert_array_equal(
        np.isnan(monte_carlo(four_bar, theta, **strict, nan_policy="propagate").mean[:, 0]), [False, True]
    )
    with pytest.raises(
        FrameError, match=rf"at 103.9 deg: not assembled in {lost} of 40 samples: choose the nan_policy"
    ):
        monte_carlo(four_bar, theta, **strict, nan_policy="raise")


def test_an_open_loop_leaves_the_sample_out_of_the_exact_total_only():
    theta, inputs = np.radians([2.0, 60.0]), {"clearance": CLEARANCE, "contact": CONTACT}
    study = monte_carlo(FourBar(), theta, inputs, n=40, rng=0, exact=True)
    lost = np.count_nonzero(np.isnan(study.clearance_exact.samples[0, :, 0]))
    assert 0 < lost < 40
    assert_array_equal(study.status, [f"clearance leaves the loop open in {lost} of 40 samples", "regular"])
    assert_array_equal(study.missing[:, 0], [lost, 0])
    there = study.samples[0][np.isfinite(study.samples[0]).all(axis=-1)]
    assert_allclose(study.mean[0], there.mean(axis=0), rtol=1e-12)
    assert_allclose(study.std[0], there.std(axis=0, ddof=1), rtol=1e-12)
    for policy, told in (("propagate", [True, False]), ("omit", [False, False])):
        strict = monte_carlo(FourBar(), theta, inputs, n=40, rng=0, exact=True, nan_policy=policy)
        assert_array_equal(np.isnan(strict.mean[:, 0]), told)
    with pytest.raises(FrameError, match=f"{lost} of 40 samples are NaN"):
        _ = monte_carlo(FourBar(), theta, inputs, n=40, rng=0, exact=True, nan_policy="raise").mean
    assert np.all(monte_carlo(FourBar(), theta, inputs, n=40, rng=0).status == "regular")


def test_condition_numbers_are_those_of_the_nominal_linkage():
    study = monte_carlo(FourBar(), THETA, PAPER, load=(0.0, 100.0, 0.0), n=10, rng=0)
    assert study.kappa.shape == study.kappa_scaled.shape == (4,)
    assert np.all((study.kappa > 1e8) & (study.kappa < 1e10))
    assert np.all(study.kappa_scaled < 1e4)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"distributions": {"gamma": CONTACT}}, "'gamma' is no parameter of the four-bar: choose from crank"),
        ({"distributions": {"ktx.A": CONTACT}}, "'ktx.A' is no parameter"),
        ({"distributions": {"clearance": stats.norm(0.0, 1.0)}}, "clearance of joint 'B' is -"),
        ({"contact": "reaction", "load": (0.0, 1.0, 0.0)}, "give one of the two"),
        ({"contact": "equilibrium", "load": (0.0, 1.0, 0.0)}, "give one of the two"),
        ({"theta": np.zeros((2, 2)) + 0.5}, r"shape \(2, 2\): give one axis of poses"),
        ({"theta": [0.0, np.pi]}, "no pose is left"),
        ({"four_bar": FourBar(crank=[[0.1], [0.11]], rocker=0.15)}, r"batch shape \(2, 1\): give numbers"),
        ({"four_bar": FourBar(crank=[0.1, 0.11, 0.12, 0.13], rocker=0.15)}, r"batch shape \(4,\): give numbers"),
        ({"nan_policy": "drop"}, "nan_policy is 'drop': choose one of omit, propagate, raise"),
        (
            {"four_bar": FourBar(stiffness=(2e8, 2e8, 2e8, 2e2, 2e2, 0)), "distributions": {"stiffness": STIFF}},
            r"'stiffness': that of ktx.B is 2e\+08 and that of krx.B is 200, and one draw .* such as 'krx.B'",
        ),
        (
            {"clearance": {"B": 1e-3}, "distributions": {"clearance": CLEARANCE}},
            "that of B is 0.001 and that of D is 0",
        ),
        ({"theta": []}, r"shape \(0,\): give one axis of poses"),
        ({"load": 100.0}, r"load is 100\.0: give \(fx, fy, mz\)"),
    ],
)
def test_bad_input_is_refused(change, message):
    given = {"four_bar": FourBar(), "theta": THETA, "distributions": PAPER, "n": 10, "rng": 0} | change
    with pytest.raises(FrameError, match=message):
        monte_carlo(given.pop("four_bar"), given.pop("theta"), given.pop("distributions"), **given)


def test_a_linkage_without_springs_is_a_mechanism_at_every_pose():
    four_bar = FourBar(stiffness=(0.0, 0.0, 1e8, 1e8, 1e8, 0.0))
    study = monte_carlo(four_bar, THETA, {"fy": stats.norm(100.0, 5.0)}, n=5, rng=0)
    with pytest.warns(MechanismWarning, match="kinematically unstable"):
        status = study.status
    assert_array_equal(status, ["mechanism in 5 of 5 samples"] * 4)
    assert np.isnan(study.mean).all()
