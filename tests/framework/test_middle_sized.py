"""Shortcuts of middle-sized frames: shares of springs and estimates that are kept, least pivots by halves."""

from __future__ import annotations

from itertools import product
from typing import Any

import numpy as np
import pytest
import scipy
from linkframe.elements import Beam, Joint, Material, Section
from linkframe.framework import Frame
from linkframe.framework.batch import all_of, any_of
from linkframe.framework.cache import PATTERNS, TERMS
from linkframe.framework.solvers import stacked_bands
from linkframe.framework.solvers.band_factors import SideBySide
from linkframe.framework.solvers.patterns import ProductPattern, diagonal_of
from linkframe.framework.solvers.sparse import SparseSolver
from linkframe.framework.structure.group import _widened

SECTION = Section(A=1e-4, Iy=1e-9, Iz=2e-9, J=2e-9)


def bent(count: int, modulus: np.ndarray, height: float = 0.3, *, joint: bool = False) -> Frame:
    """A clamped chain that leaves its line by a height, in space; each member of another modulus."""
    frame = Frame()
    for k in range(count + 1):
        place = (0.1 * k, height * np.sin(0.7 * k), 0.2 * height * np.cos(k))
        frame.node(f"{k}", place)
        if k:
            start = "joined" if joint and k == 2 else f"{k - 1}"
            frame.add(f"m{k}", Beam(SECTION, Material(E=modulus * (1.0 + 0.02 * k), nu=0.3)), start, f"{k}")
        if joint and k == 1:
            frame.node("joined", place)
            frame.add("joint", Joint(stiffness=(1e8, 1e8, 1e8, 1e5, 1e5, 1e3)), "1", "joined")
    frame.fix("0")
    frame.load(f"{count}", fx=5.0, fy=3.0, mz=0.5)
    return frame


@pytest.mark.parametrize("height", [0.0, 0.3, 0.7])
def test_stiffness_by_springs_is_that_of_the_elements(height: float) -> None:
    """In turns between two moduli and places: shares of one frame do not serve another; symmetric to the last bit."""
    for modulus in (2e11, 7e10):
        solution = bent(12, np.array([modulus]), height).solve("banded")
        assert isinstance(solution.solver, SparseSolver)
        matrix = solution.solver.matrix
        assert matrix.deformations is not None
        found = matrix.deformations.stiffness()
        assert found is not None
        expected = matrix.matrices.stiffness.toarray()
        np.testing.assert_allclose(found.toarray(), expected, rtol=0.0, atol=1e-15 * np.abs(expected).max())
        np.testing.assert_array_equal(found.toarray(), found.toarray().T)


@pytest.mark.parametrize("force", [2.0, [2.0], [2.0, 3.0, 5.0]])
def test_a_node_that_is_held_in_part(force: object) -> None:
    """Free, held and prescribed displacements of one node: ``ux = F L / E A``, no others beside that prescribed."""
    frame = Frame()
    for k in range(5):
        frame.node(f"{k}", (0.5 * k, 0.0, 0.0))
        if k:
            frame.add(f"m{k}", Beam(SECTION, Material(E=2e11, nu=0.3)), f"{k - 1}", f"{k}")
    frame.fix("0")
    frame.fix("4", "uy", "rz")
    frame.prescribe("4", rx=1e-3)
    frame.load("4", fx=force, fz=3.0)
    found = frame.solve("banded").displacement("4")
    bent = -3.0 * 2.0**2 / 2.0 / (2e11 * SECTION.Iy)
    exact = [0.0, 0.0, 3.0 * 2.0**3 / 3.0 / (2e11 * SECTION.Iy), 1e-3, bent, 0.0] * np.ones((*np.shape(force), 6))
    exact[..., 0] = np.multiply(force, 2.0 / (2e11 * SECTION.A))
    np.testing.assert_allclose(found, exact, rtol=1e-13, atol=1e-20)


def test_product_with_a_diagonal_between() -> None:
    """``A D B`` by what each number of D adds, beside SciPy's product; what cancels is left out."""
    rng = np.random.default_rng(3)
    first, second = (scipy.sparse.random(*shape, 0.3, "csr", rng=rng) for shape in ((7, 11), (11, 7)))
    pattern = ProductPattern(first, second)
    shares = pattern.shares(first.data, second.data)
    for diagonal in rng.uniform(-2.0, 2.0, (3, 11)):
        diagonal[4] = 0.0
        found = pattern.of(shares, diagonal)
        expected = (first @ scipy.sparse.diags(diagonal) @ second).toarray()
        np.testing.assert_allclose(found.toarray(), expected, rtol=1e-14, atol=1e-15)
        assert found.data.all()


def test_diagonal_with_gaps() -> None:
    """As SciPy tells it, of a matrix some of whose diagonal is not there."""
    matrix = scipy.sparse.random(9, 9, 0.4, "csr", rng=np.random.default_rng(1))
    assert 0 < np.count_nonzero(matrix.diagonal()) < 9
    np.testing.assert_array_equal(diagonal_of(matrix), matrix.diagonal())
    whole = scipy.sparse.csr_matrix(matrix + scipy.sparse.eye(9))
    np.testing.assert_array_equal(diagonal_of(whole), whole.diagonal())


def test_least_pivot_wherever_it_stands() -> None:
    """Of diagonal matrices the least root; none that is above zero where a number is below."""
    pytest.importorskip("llvmlite")
    for size in range(1, 40):
        numbers = np.random.default_rng(size).uniform(0.2, 0.9, (size, 11))
        numbers[np.arange(11) % size, np.arange(11)] = 0.1 + 0.001 * np.arange(11)
        numbers[size // 2, 5] = -1.0
        least = SideBySide(numbers, np.arange(size), size, 1).least
        assert not least[5] > 0.0
        expected = np.delete(np.sqrt(np.abs(numbers)).min(axis=0), 5)
        np.testing.assert_array_equal(np.delete(least, 5), expected)


def test_shapes_widen_as_numpy_has_it() -> None:
    """All pairs and triples of small shapes that go together."""
    shapes = [(), (1,), (3,), (1, 1), (1, 3), (4, 1), (4, 3)]
    for whole in ((), (1,), (3,), (1, 1), (4, 1), (4, 3)):
        for others in [*product(shapes), *product(shapes, shapes)]:
            try:
                expected = np.broadcast_shapes(whole, *others)
            except ValueError:
                continue
            assert _widened(whole, *others) == expected, (whole, others)


def test_whether_some_or_all() -> None:
    """As NumPy has it, of nothing, of what is not a number, and of numbers that do not lie in one piece."""
    for numbers in (np.zeros(0), np.array([np.nan]), np.array([0.0, -0.0]), np.eye(4)[:, 1], np.ones((2, 3), bool).T):
        assert any_of(numbers) == numbers.any()
        assert all_of(numbers) == numbers.all()


def test_a_way_is_chosen_by_its_own_batch() -> None:
    """What was estimated of the same terms for other batches tells nothing of this one: of another size, or of one over
    whose every entry the modulus varies."""
    moduli = [2e11 * np.linspace(0.8, 1.2, count) for count in (3, 40, 2000, 3)]
    moduli += [2e11 * np.linspace(0.8, 1.2, 3 * count).reshape(3, count) for count in (1, 500)]

    def reasons(*, anew: bool) -> list[str]:
        out = []
        for modulus in moduli:
            if anew:
                TERMS.clear()
                PATTERNS.clear()
            frame = bent(40, modulus)
            if modulus.ndim == 2:
                frame.load("40", fz=np.ones((3, 500)))
            out.append(frame.solve().plan.method.reason)
        return out

    alone = reasons(anew=True)
    assert reasons(anew=False) == alone
    assert len(set(alone)) == 5


def test_estimates_take_no_pattern_of_bands_away(monkeypatch: pytest.MonkeyPatch) -> None:
    """Frames with a joint, each described anew, share nothing but their terms: the band is looked for once."""
    made = []

    class Counted(stacked_bands.BandPattern):
        def __init__(self, *given: Any) -> None:
            made.append(self)
            super().__init__(*given)

    monkeypatch.setattr(stacked_bands, "BandPattern", Counted)
    TERMS.clear()
    modulus = 2e11 * np.linspace(0.8, 1.2, 30)
    for k in range(14):
        solution = bent(30, modulus * (1.0 + 0.1 * k), joint=True).solve()
        assert solution.plan.method.name == "banded"
        solution.displacement("30")
    assert len(made) == 1
