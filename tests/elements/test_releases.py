"""End releases: static condensation of the unreleased beam, to exact zeros."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest
from linkframe.elements import Beam, Material, Rectangle
from linkframe.framework.errors import FrameError
from numpy.testing import assert_allclose
from numpy.typing import NDArray

Array = NDArray[np.float64]
STEEL = Material(E=200e9, nu=0.3, density=7850.0)
L = 1.3
NAMES = [f"{end} {component}" for end in ("start", "end") for component in ("ux", "uy", "uz", "rx", "ry", "rz")]
# what is left must hold the member: one of ux and of rx, and two independent of (v1, r1, v2, r2) in each plane
PLANES = [("uy", "rz"), ("uz", "ry")]


def holds(release: tuple[str, ...]) -> bool:
    """Whether the rest still holds the member, by the rank of the stiffness that the released components have."""
    K = Beam(Rectangle(y=0.1, z=0.06), STEEL).stiffness_matrix(L)
    index = [NAMES.index(name) for name in release]
    scale = 1 / np.sqrt(np.diag(K))
    return not index or float(np.linalg.eigvalsh((scale[:, None] * K * scale)[np.ix_(index, index)])[0]) > 1e-9


TWO = [release for count in (1, 2) for release in combinations(NAMES, count)]
HELD = [release for release in TWO if holds(release)]
MORE = [
    ("start ry", "end ry", "start rz", "end rz"),
    ("start ux", "start uy", "start uz", "start rx", "start ry", "start rz"),
    ("end ux", "end uy", "end uz", "end rx", "end ry", "end rz"),
    ("start uy", "end rz", "start ry", "end uz", "end rx"),
]


def condensed(beam: Beam) -> tuple[Array, Array]:
    """Matrix that gives all components of the unreleased member from the kept ones, and the released indices."""
    whole = Beam(beam.section, beam.material, end=beam.end, shear=beam.shear)
    K = whole.stiffness_matrix(L)
    released = np.array([6 * end + component for end, component in beam.releases], dtype=int)
    kept = np.setdiff1d(np.arange(12), released)
    G = np.zeros((12, 12))
    G[kept, kept] = 1.0
    scale = np.sqrt(np.diag(K))
    inner = np.linalg.solve(
        K[np.ix_(released, released)] / np.outer(scale[released], scale[released]),
        K[np.ix_(released, kept)] / scale[released, None],
    )
    G[np.ix_(released, kept)] = -inner / scale[released, None]
    return G, released


@pytest.mark.parametrize("end", [None, Rectangle(y=0.05, z=0.08)], ids=["prismatic", "taper"])
@pytest.mark.parametrize("shear", [False, True], ids=["bernoulli", "timoshenko"])
def test_all_releases_of_one_and_two_and_some_of_more(end: Rectangle | None, shear: bool) -> None:
    """Stiffness, mass, geometric stiffness, shape functions and end forces are those of the condensed member."""
    assert len(HELD) == 12 + 66 - 4
    whole = Beam(Rectangle(y=0.1, z=0.06), STEEL, end=end, shear=shear)
    K, x = whole.stiffness_matrix(L), np.linspace(0.0, L, 5)
    N, dN = whole.shape_functions(L, x), whole.shape_gradients(L, x)
    u = np.random.default_rng(3).normal(size=12)
    for release in [*HELD, *MORE]:
        beam = Beam(Rectangle(y=0.1, z=0.06), STEEL, end=end, shear=shear, release=release)
        G, released = condensed(beam)
        found = beam.stiffness_matrix(L)
        assert_allclose(found, G.T @ K @ G, atol=1e-13 * K.max())
        assert_allclose(beam.shape_functions(L, x), N @ G, atol=1e-13)
        assert_allclose(beam.shape_gradients(L, x), dN @ G, atol=1e-12)
        assert_allclose(beam.end_forces(L, u), found @ u, atol=1e-13 * K.max())
        assert not np.any(found[released])
        assert not np.any(found[:, released])
        assert not np.any(beam.end_forces(L, u)[released])
        assert not np.any(beam.shape_functions(L, x)[..., released])
        assert not np.any(beam.shape_gradients(L, x)[..., released])


@pytest.mark.parametrize("end", [None, Rectangle(y=0.05, z=0.08)], ids=["prismatic", "taper"])
@pytest.mark.parametrize("release", [HELD[0], HELD[5], HELD[20], HELD[45], *MORE], ids=" ".join)
def test_mass_and_geometric_stiffness_follow_the_member(end: Rectangle | None, release: tuple[str, ...]) -> None:
    whole = Beam(Rectangle(y=0.1, z=0.06), STEEL, end=end, shear=True)
    beam = Beam(Rectangle(y=0.1, z=0.06), STEEL, end=end, shear=True, release=release)
    G, released = condensed(beam)
    for found, full in (
        (beam.mass_matrix(L), whole.mass_matrix(L)),
        (beam.geometric_matrix(L, 5.0), whole.geometric_matrix(L, 5.0)),
    ):
        assert_allclose(found, G.T @ full @ G, atol=1e-12 * np.abs(full).max())
        assert np.array_equal(found, found.T)
        assert not np.any(found[released])


def test_hinges_leave_exact_zeros() -> None:
    """A bar hinged at both ends carries axial force and torsion, and nothing else at all."""
    for end in (None, Rectangle(y=0.05, z=0.08)):
        beam = Beam(Rectangle(y=0.1, z=0.06), STEEL, end=end, release=("start ry", "end ry", "start rz", "end rz"))
        K = beam.stiffness_matrix(np.linspace(1.0, 2.0, 5))
        bars = np.zeros((12, 12), dtype=bool)
        for i in (0, 3):
            bars[np.ix_((i, i + 6), (i, i + 6))] = True
        assert np.array_equal(K != 0.0, np.broadcast_to(bars, K.shape))


def test_propped_beam() -> None:
    """A hinge at one end: 3 E I / L (Ghali & Neville, Structural Analysis, 5th ed., appendix D)."""
    bar = Rectangle(y=0.1, z=0.06)
    K = Beam(bar, STEEL, release=("start rz",)).stiffness_matrix(L)
    assert K[11, 11] == pytest.approx(3 * 200e9 * bar.Iz / L, rel=1e-14)
    assert K[7, 7] == pytest.approx(3 * 200e9 * bar.Iz / L**3, rel=1e-14)


def test_one_text_is_one_release_and_order_does_not_matter() -> None:
    bar = Rectangle(y=0.1, z=0.06)
    assert Beam(bar, STEEL, release="end rz").releases == ((1, 5),)  # type: ignore[arg-type]
    both = Beam(bar, STEEL, release=("end rz", "start ry")).kind, Beam(bar, STEEL, release=["start ry", "end rz"]).kind
    assert both[0] == both[1]


@pytest.mark.parametrize("release", [release for release in TWO if release not in HELD], ids=" ".join)
def test_what_would_leave_the_member_free_is_refused(release: tuple[str, ...]) -> None:
    with pytest.raises(FrameError, match=f"{release[0]}, {release[1]} leave the member itself free"):
        Beam(Rectangle(y=1.0, z=1.0), STEEL, release=release)


def test_three_in_one_plane_are_refused() -> None:
    with pytest.raises(FrameError, match="start uy, start rz, end rz leave the member itself free"):
        Beam(Rectangle(y=1.0, z=1.0), STEEL, release=("start uy", "start rz", "end rz", "end ry"))


@pytest.mark.parametrize("release", ["rz", "start", "middle rz", "start rw", "start rz now", 5])
def test_what_is_no_release_is_refused(release: object) -> None:
    with pytest.raises(FrameError, match=f"release {release!r} must be an end and a component"):
        Beam(Rectangle(y=1.0, z=1.0), STEEL, release=(release,))  # type: ignore[arg-type]
