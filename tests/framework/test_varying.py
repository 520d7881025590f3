"""Members that vary over a large batch: solved chunk by chunk, in memory that does not grow with their number."""

from __future__ import annotations

import tracemalloc
from collections.abc import Callable

import numpy as np
import pytest
from linkframe.elements import Beam, Joint, Material, Rectangle, Section
from linkframe.framework import Frame
from linkframe.framework.batched.block_factor import BlockFactor
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]
SAMPLES = 1500
RNG = np.random.default_rng(11)
ONE = RNG.uniform(0.9, 1.1, SAMPLES)
PLACES = np.array([[0.0, 0.0, 0.0], [1.0, 0.3, 0.2], [2.0, 0.1, 0.9], [3.0, 0.5, 1.0]])
# What may vary, each by a factor near one for every sample.
Described = Callable[[Array], Frame]


def described(
    r: Array,
    *,
    sizes: bool = False,
    places: bool = False,
    up: bool = False,
    turned: bool = False,
    across: bool = False,
    loaded: bool = False,
    **beam: object,
) -> Frame:
    """Three members, the last behind a joint whose axes may vary, in a body that may; and one from without into it."""
    section = Rectangle(y=0.02 * r, z=0.03) if sizes else Rectangle(y=0.02, z=0.03)
    end = Rectangle(y=0.03, z=0.02 * r) if beam.pop("taper", False) else None
    towards = np.stack([0.3 * r, 0.1 + 0.0 * r, 1.0 + 0.0 * r], axis=-1) if up else None
    modulus = 2e11 * r if beam.pop("modulus", False) else 2e11
    bar = Beam(section, Material(E=modulus, nu=0.3, density=7850.0), end=end, up=towards, **beam)  # type: ignore[arg-type]
    frame = Frame()
    axes = Rotation.from_rotvec(np.multiply.outer(r, [0.2, 0.3, 0.4])).as_matrix() if turned else np.eye(3)
    frame.body("arm", (2.0, 0.1, 0.9), axes)
    for k in range(3):
        frame.node(f"n{k}", PLACES[k] * np.stack([r, r * r, 1.0 / r], axis=-1) if places and k == 1 else PLACES[k])
    frame.node("hand", (0.0, 0.0, 0.0), "arm")
    frame.node("tip", PLACES[3] - PLACES[2], "arm")
    frame.add("a", bar, "n0", "n1")
    frame.add("b", bar, "n1", "n2")
    frame.add("c", bar, "hand", "tip")
    if across:
        frame.add("d", bar, "n1", "tip")
    frame.add("joint", Joint(stiffness=(1e6, 1e6, np.inf, 1e4, 1e4, 1e3), axes=axes), "n2", "hand")
    frame.fix("n0")
    frame.load("tip", fy=1.0, fz=2.0)
    if loaded:
        frame.gravity((0.0, 1.0, -9.81))
        frame.line_load("b", fz=(-3.0 * r, 0.0 * r), span=(0.1, 0.5))
        frame.point_load("a", at=0.3, fy=r, local=True)
    return frame


CASES: dict[str, Described] = {
    "modulus": lambda r: described(r, modulus=True),
    "sections": lambda r: described(r, sizes=True, shear=True),
    "taper": lambda r: described(r, taper=True, shear=True),
    "places": lambda r: described(r, places=True),
    "axes": lambda r: described(r, up=True),
    "bodies": lambda r: described(r, turned=True, across=True),
    "all, loaded": lambda r: described(r, modulus=True, sizes=True, places=True, up=True, turned=True, loaded=True),
    "loads": lambda r: described(r, loaded=True),
}


@pytest.mark.parametrize("case", CASES)
def test_as_entry_by_entry(case: str) -> None:
    """Displacements and forces are those of frames of a single entry, which are summed in extended precision.

    The scaled condition number is 6e5, and rounding of that 1e-10.
    """
    whole = CASES[case](ONE).solve()
    for k in (0, 700, SAMPLES - 1):
        single = CASES[case](ONE[k : k + 1]).solve()
        for node in ("n1", "tip"):
            mine, theirs = whole.displacement(node), single.displacement(node)[0]
            np.testing.assert_allclose(mine[k], theirs, rtol=0.0, atol=1e-10 * np.abs(theirs).max())
        mine, theirs = whole.end_forces("b"), single.end_forces("b")[0]
        np.testing.assert_allclose(mine[k], theirs, rtol=0.0, atol=1e-9 * np.abs(theirs).max())


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize(("chunk", "workers"), [(1, 1), (256, 2), (700, 1)])
def test_same_bits(case: str, chunk: int, workers: int) -> None:
    """However the batch is cut and whoever works."""
    plan = CASES[case](ONE).solve().plan
    blocks = [plan.block(name) for name in sorted(plan.excited)]
    for block in blocks:
        rows = [{k: 1.0} for order in block.orders for k in order.pivots]
        one, other = BlockFactor(block, 300, 1), BlockFactor(block, chunk, workers)
        for mine, theirs in zip(one.values(rows), other.values(rows), strict=True):
            np.testing.assert_array_equal(np.asarray(mine), np.asarray(theirs))
        np.testing.assert_array_equal(one.pivot_ratio(), other.pivot_ratio())


def chain(r: Array, *, planar: bool = False) -> Frame:
    """Three members with everything in them varying."""
    section = Section(A=1e-4 * r, Iy=1e-9 * r, Iz=2e-9, J=1e-9)
    bar = Beam(section, Material(E=2e11 * r, nu=0.3))
    frame = Frame()
    for k, place in enumerate(PLACES):
        at = place * [1.0, 1.0, 0.0] if planar else place
        frame.node(f"n{k}", at * r[:, None] if k in (1, 2) else at)
    for k in range(3):
        frame.add(f"m{k}", bar, f"n{k}", f"n{k + 1}")
    frame.fix("n0")
    frame.load("n3", fy=1.0)
    return frame


def test_memory_is_that_of_results_and_a_chunk() -> None:
    """A displacement of four times as many samples takes memory for itself and what is given."""
    peaks = {}
    for count in (50_000, 200_000):
        frame = chain(np.linspace(1.0, 1.1, count))
        tracemalloc.start()
        try:
            frame.solve().displacement("n3")
            peaks[count] = tracemalloc.get_traced_memory()[1]
        finally:
            tracemalloc.stop()
    # Chords, margins and the result, each of a few numbers a sample; the members' matrices would take 3500.
    assert peaks[200_000] - peaks[50_000] < 150_000 * 8 * 40


def test_what_is_zero_stays_out() -> None:
    """A plane frame loaded in its plane has half its unknowns, although its places and sections vary."""
    solution = chain(np.linspace(1.0, 1.1, 3000), planar=True).solve()
    assert "Skipped: 9 unknowns (uz rx ry)" in solution.explain()
    assert not solution.displacement("n3")[:, 2:5].any()
    assert solution.plan.varying.groups
