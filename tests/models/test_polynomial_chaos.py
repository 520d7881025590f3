"""Polynomial chaos and Taylor expansions against closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.framework.errors import FrameError, SampleWarning
from linkframe.models import polynomial_chaos, propagate, taylor_moments
from linkframe.models.propagation.orthogonal import Orthonormal
from numpy.testing import assert_allclose, assert_array_equal
from scipy import special, stats

GAP = {"eps": stats.norm(1e-3, 5e-5), "gamma": stats.norm(0.7, 0.3)}


def contact(eps, gamma):
    return np.stack([eps * np.cos(gamma), eps * np.sin(gamma)], axis=-1)


def contact_moments():
    once, twice = (np.exp(1j * k * 0.7 - (k * 0.3) ** 2 / 2) for k in (1, 2))
    mean = 1e-3 * np.array([once.real, once.imag])
    square = 0.5 * (1e-6 + 25e-10) * np.array([1 + twice.real, 1 - twice.real])
    return mean, np.sqrt(square - mean**2)


@pytest.mark.parametrize(
    ("law", "rule"),
    [
        (stats.norm(2.0, 3.0), lambda n: special.roots_hermitenorm(n)),
        (stats.uniform(-1.0, 2.0), lambda n: special.roots_legendre(n)),
        (stats.expon(), lambda n: special.roots_laguerre(n)),
    ],
)
def test_polynomials_and_gauss_rules_of_known_distributions(law, rule):
    basis = Orthonormal.of("x", law, 6)
    nodes, weights = rule(7)
    scaled = 2.0 + 3.0 * nodes if law.dist.name == "norm" else nodes
    found = basis.gauss()
    assert_allclose(found[0], scaled, rtol=1e-8, atol=1e-12)
    assert_allclose(found[1], weights / weights.sum(), rtol=1e-7)
    values = basis(scaled)
    assert_allclose((values * (weights / weights.sum())[:, None]).T @ values, np.eye(7), atol=1e-7)


@pytest.mark.parametrize("method", ["regression", "quadrature"])
def test_moments_of_the_clearance_converge(method):
    mean, std = contact_moments()
    errors = []
    for degree in (2, 4, 6):
        found = polynomial_chaos(contact, GAP, degree=degree, method=method, rng=0)
        errors.append(np.max(np.abs([found.mean / mean - 1, found.std / std - 1])))
    assert errors[1] < 0.1 * errors[0]
    assert errors[2] < 0.1 * errors[1]
    assert errors[2] < 1e-5
    assert np.all(found.unexplained < 1e-8)


@pytest.mark.parametrize("method", ["regression", "quadrature"])
def test_a_polynomial_is_found_exactly(method):
    """Also its Sobol indices: of a + 2 b + a b with standard normal inputs 1/6, 4/6 alone and 2/6, 5/6 in all."""
    inputs = {"a": stats.norm(), "b": stats.norm(), "c": stats.lognorm(0.4)}
    found = polynomial_chaos(lambda a, b, c: a + 2 * b + a * b, inputs, degree=2, method=method, rng=1)
    assert_allclose([found.mean, found.variance], [0.0, 6.0], atol=1e-10)
    assert_allclose(found.sobol.first, [1 / 6, 4 / 6, 0.0], atol=1e-10)
    assert_allclose(found.sobol.total, [2 / 6, 5 / 6, 0.0], atol=1e-10)
    x = np.linspace(-2.0, 2.0, 5)
    assert_allclose(found(a=x, b=x[::-1], c=np.exp(x)), x - 2 * x - x * x, atol=1e-9)
    assert found.unexplained < 1e-12


def test_indices_of_the_ishigami_function():
    inputs = dict.fromkeys(("x1", "x2", "x3"), (-np.pi, np.pi))
    found = polynomial_chaos(
        lambda x1, x2, x3: np.sin(x1) + 7 * np.sin(x2) ** 2 + 0.1 * x3**4 * np.sin(x1), inputs, degree=10, rng=0
    )
    one, two, both = 0.5 * (1 + 0.1 * np.pi**4 / 5) ** 2, 49 / 8, 0.01 * np.pi**8 * (1 / 18 - 1 / 50)
    assert_allclose(found.sobol.first, np.array([one, two, 0.0]) / (one + two + both), atol=2e-3)
    assert_allclose(found.sobol.total, np.array([one + both, two, both]) / (one + two + both), atol=2e-3)
    assert found.unexplained < 1e-3
    assert np.all(found.sobol.first_standard_error < 0.01)


def test_intervals_of_the_regression_hold_the_truth():
    """A fit that leaves something, to random samples: 90 % intervals of the mean hold it in about that share."""
    inside = 0
    for seed in range(200):
        found = polynomial_chaos(lambda x: np.exp(x), {"x": (0.0, 2.0)}, degree=1, n=40, rng=seed, sampler="random")
        low, high = found.confidence_interval(0.9)
        inside += bool(low <= (np.exp(2) - 1) / 2 <= high)
    assert 160 <= inside <= 195
    low, high = found.confidence_interval(0.9, "std")
    assert low < found.std < high


def test_correlated_inputs_are_expanded_in_their_scores():
    laws = {"a": stats.lognorm(0.2), "b": stats.uniform()}
    found = polynomial_chaos(lambda a, b: a * b, laws, degree=6, method="quadrature", correlation={("a", "b"): 0.5})
    a, b = laws.values()
    assert_allclose(found.mean, a.mean() * b.mean() + 0.5 * a.std() * b.std(), rtol=1e-5)
    points = {"a": np.array([0.9, 1.2]), "b": np.array([0.4, 0.7])}
    assert_allclose(found(**points), points["a"] * points["b"], rtol=2e-2)
    with pytest.raises(FrameError, match="Sobol indices need independent inputs"):
        _ = found.sobol


def test_a_polynomial_is_propagated_as_the_function_is():
    found = polynomial_chaos(contact, GAP, degree=5, rng=0)
    exact, quick = (propagate(fn, GAP, n=4096, rng=0, progress=False) for fn in (contact, found))
    assert_allclose(quick.samples, exact.samples, atol=3e-3 * 1e-3)
    assert_allclose(quick.quantile(0.99), exact.quantile(0.99), rtol=1e-3)


def test_samples_without_result_are_left_out():
    with pytest.warns(SampleWarning, match=r"\d+ of 400 samples are NaN or infinite and left out"):
        found = polynomial_chaos(lambda x: np.where(x > 1.5, np.nan, x**2), {"x": stats.norm()}, degree=2, n=400, rng=0)
    assert_allclose([found.mean, found.variance], [1.0, 2.0], rtol=1e-9)
    with pytest.raises(FrameError, match="too few are left for 3 coefficients"):
        polynomial_chaos(lambda x: np.where(x > -2.0, np.nan, x), {"x": stats.norm()}, degree=2, n=50, rng=0)


@pytest.mark.parametrize(
    ("more", "told"),
    [
        ({"degree": 0}, "degree is 0"),
        ({"degree": 21}, "give at most 20"),
        ({"method": "kriging"}, "choose one of regression, quadrature"),
        ({"n": 5}, "5 samples for 10 coefficients"),
        ({"distributions": {}}, "no input"),
        ({"distributions": {"eps": (0.0, 1.0), "gamma": stats.bernoulli(0.5)}}, "has too few values for degree 3"),
    ],
)
def test_bad_input_is_refused(more, told):
    with pytest.raises(FrameError, match=told):
        polynomial_chaos(contact, **({"distributions": GAP} | more))


def test_too_many_nodes_and_terms_are_refused():
    many = dict.fromkeys("abcdefghijkl", (0.0, 1.0))
    with pytest.raises(FrameError, match="the quadrature has 16777216 nodes"):
        polynomial_chaos(lambda **x: x["a"], many, degree=3, method="quadrature")
    with pytest.raises(FrameError, match="coefficients for 12 inputs"):
        polynomial_chaos(lambda **x: x["a"], many, degree=12)


# -- by derivatives ---------------------------------------------------------------------------------------------------


def test_first_order_moments_of_the_clearance():
    found = taylor_moments(contact, GAP)
    c, s = np.cos(0.7), np.sin(0.7)
    assert_allclose(found.mean, [1e-3 * c, 1e-3 * s], rtol=1e-14)
    assert_allclose(found.gradient, [[c, -1e-3 * s], [s, 1e-3 * c]], rtol=1e-5)
    assert_allclose(found.std, np.hypot([c * 5e-5, s * 5e-5], [1e-3 * s * 0.3, 1e-3 * c * 0.3]), rtol=1e-5)
    assert_allclose(found.shares.sum(axis=-1), 1.0)


def test_second_order_moments_of_a_quadratic_are_exact():
    """Of x² + x y + 3 y with skew, flat and peaked inputs, by E of its powers."""
    laws = {"x": stats.gamma(2.0), "y": stats.uniform(1.0, 2.0)}
    found = taylor_moments(lambda x, y: x**2 + x * y + 3 * y, laws, order=2)
    x, y = ([law.moment(k) for k in range(5)] for law in laws.values())
    mean = x[2] + x[1] * y[1] + 3 * y[1]
    square = x[4] + x[2] * y[2] + 9 * y[2] + 2 * x[3] * y[1] + 6 * x[2] * y[1] + 6 * x[1] * y[2]
    assert_allclose(found.mean, mean, rtol=1e-9)
    assert_allclose(found.std**2, square - mean**2, rtol=1e-7)
    assert_allclose(found.hessian, [[2, 1], [1, 0]], atol=1e-8)


def test_correlated_normal_inputs_to_second_order():
    """The product of two normal variables: mean r s t + m n, variance m² t² + n² s² + 2 m n r s t + s² t² (1 + r²)."""
    laws = {"a": stats.norm(2.0, 0.3), "b": stats.norm(-1.0, 0.5)}
    found = taylor_moments(lambda a, b: a * b, laws, order=2, correlation={("a", "b"): 0.6})
    shared = 0.6 * 0.3 * 0.5
    assert_allclose(found.mean, -2.0 + shared, rtol=1e-9)
    variance = 4 * 0.25 + 0.09 - 4 * shared + 0.09 * 0.25 * (1 + 0.36)
    assert_allclose(found.std**2, variance, rtol=1e-7)
    with pytest.raises(FrameError, match="need normal ones: take polynomial_chaos"):
        taylor_moments(lambda a, b: a * b, laws | {"a": (0.0, 1.0)}, order=2, correlation={("a", "b"): 0.6})
    first = taylor_moments(lambda a, b: a + b, {"a": (0.0, 1.0), "b": stats.expon()}, correlation={("a", "b"): 0.6})
    assert_allclose(first.std**2, 1 / 12 + 1 + 1.2 * np.sqrt(1 / 12), rtol=1e-9)


def test_derivatives_that_are_given():
    """By name or as an array; then the function is called at the mean alone."""
    calls = []

    def fn(eps, gamma):
        calls.append(len(eps))
        return contact(eps, gamma)

    def by_name(eps, gamma):
        turn = np.array([np.cos(gamma), np.sin(gamma)])
        return {"gamma": eps * np.array([-turn[1], turn[0]]), "eps": turn}

    wanted = taylor_moments(contact, GAP)
    found = taylor_moments(fn, GAP, gradient=by_name)
    assert calls == [2]
    assert_allclose(found.std, wanted.std, rtol=1e-5)
    as_array = taylor_moments(fn, GAP, gradient=lambda **at: np.stack([by_name(**at)[k] for k in GAP], axis=-1))
    assert_array_equal(as_array.std, found.std)
    second = taylor_moments(fn, GAP, order=2, gradient=by_name, hessian=lambda **at: np.zeros((2, 2, 2)))
    assert_allclose(second.std, found.std, rtol=1e-14)
    with pytest.raises(FrameError, match="no derivative by 'gamma'"):
        taylor_moments(fn, GAP, gradient=lambda **at: {"eps": np.zeros(2)})
    with pytest.raises(FrameError, match=r"the derivatives have shape \(2,\): give \(2, 2\)"):
        taylor_moments(fn, GAP, gradient=lambda **at: np.zeros(2))


def test_an_order_that_is_not_there():
    with pytest.raises(FrameError, match="order is 3: give 1 or 2"):
        taylor_moments(contact, GAP, order=3)


def test_tables():
    lines = repr(taylor_moments(lambda a, b: a + 2 * b, {"a": stats.norm(), "b": stats.norm()})).splitlines()
    assert [line.split() for line in lines[1:]] == [["a", "20.0", "%"], ["b", "80.0", "%"]]
    chaos = polynomial_chaos(contact, GAP, degree=2, method="quadrature")
    assert repr(chaos).startswith("PolynomialChaos of eps, gamma: 6 terms up to degree 2, 265 calls, left ")
    with pytest.raises(FrameError, match="draws no samples"):
        chaos.confidence_interval()
