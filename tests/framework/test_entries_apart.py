"""Entries that can move are looked at apart from the others, and are what they are alone."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from linkframe.elements import Beam, Material, Rectangle
from linkframe.framework import Frame, Solution
from linkframe.framework.entries import Selected
from linkframe.framework.error_bounds import equilibrium, resolved
from linkframe.framework.results import consistent_mechanisms, driven_mechanisms, reached
from linkframe.models import FourBar
from numpy.testing import assert_allclose, assert_array_equal
from numpy.typing import ArrayLike

BAR = Beam(Rectangle(y=12.7e-3, z=6.35e-3), Material(E=200e9, nu=0.3))
SAMPLES = 80
RNG = np.random.default_rng(7)
STIFFNESS, FORCE = 2e8 * RNG.uniform(0.5, 2.0, SAMPLES), RNG.uniform(50.0, 150.0, SAMPLES)
# Two of these are dead points, along which the load acts.
DEGREES = np.array([0.0, 35.0, 180.0, 290.0])

pytestmark = pytest.mark.filterwarnings("ignore::linkframe.framework.MechanismWarning")


def four_bar(
    degrees: ArrayLike, k: ArrayLike, along: ArrayLike, across: ArrayLike = 0.0, imposed: float = 0.0
) -> Frame:
    free = np.array([1.0, 1.0, 1.0, 1e-3, 1e-3, 0.0])
    motion = FourBar(beam=BAR, stiffness=dict.fromkeys("BDE", np.asarray(k)[..., None] * free)).move(
        np.radians(degrees)
    )
    frame = motion.frame()
    frame.load("P", fx=along, fy=across)
    if imposed:
        frame.prescribe("E", ux=imposed * np.asarray(along))
        frame.offset("D", ux=-imposed)
    return frame


def results(solution: Solution) -> list[np.ndarray]:
    forces = solution.joint_force("D"), solution.reaction("E"), solution.end_forces("rocker")
    return [solution.displacement("P"), solution.displacement("B.coupler"), *forces]


@pytest.mark.parametrize("imposed", [0.0, 1e-7])
def test_many_entries_held_by_springs_are_as_they_are_alone(imposed: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """At two dead points, where 160 entries are solved together and none takes extended precision of its own."""
    left = []
    one_by_one = consistent_mechanisms.small

    def counted(statics: equilibrium.Statics, suspects: np.ndarray, unknowns: list[int]) -> object:
        left.append(int(suspects.sum()))
        return one_by_one(statics, suspects, unknowns)

    monkeypatch.setattr(consistent_mechanisms, "small", counted)
    whole = four_bar(DEGREES[:, None], STIFFNESS, FORCE, imposed=imposed).solve()
    found = results(whole)
    assert left == [0]
    for pose, degrees in enumerate(DEGREES):
        for sample in (0, 41):
            alone = four_bar(degrees, STIFFNESS[sample], FORCE[sample], imposed=imposed).solve()
            assert alone.status == whole.status[pose, sample]
            for one, all_of_them in zip(results(alone), found, strict=True):
                assert_allclose(all_of_them[pose, sample], one, rtol=0.0, atol=1e-12 * np.nanmax(np.abs(all_of_them)))
    assert (whole.status[[0, 2]] == "statically consistent mechanism").all()


def test_a_load_that_does_a_little_work_drives_its_own_entry_alone() -> None:
    """A share of the load that is far below what is plain, and far above rounding."""
    across = np.where(np.arange(SAMPLES) == 17, 1e-10, 0.0)
    status = four_bar(DEGREES[:, None], STIFFNESS, FORCE, across).solve().status
    assert (status[[0, 2], 17] == "mechanism").all()
    assert (np.delete(status[[0, 2]], 17, axis=1) == "statically consistent mechanism").all()
    assert (status[[1, 3]] == "regular").all()


@pytest.mark.parametrize("load", [{"along": 100.0}, {"along": 0.0, "across": 100.0}])
def test_extended_precision_is_of_the_singular_entries_alone(
    load: dict[str, float], monkeypatch: pytest.MonkeyPatch
) -> None:
    """One pose of 300, whose load does work on its free motion or does none."""
    shapes = []

    class Noted(equilibrium.Statics):
        def __init__(self, *args: object, **named: object) -> None:
            super().__init__(*args, **named)  # type: ignore[arg-type]
            shapes.append(self.plan.frame.shape)

    for module in (resolved, consistent_mechanisms, driven_mechanisms, reached):
        monkeypatch.setattr(module, "Statics", Noted)
    degrees = np.linspace(10.0, 170.0, 300)
    degrees[111] = 180.0
    whole = four_bar(degrees, 2e8, **load).solve()
    results(whole)
    assert (whole.status == "regular").sum() == 299
    assert set(shapes) == {(1,)}


@settings(max_examples=40, deadline=None)
@given(st.data())
def test_selected_entries(data: st.DataObject) -> None:
    """They hold all of the mask, in order, whatever axes an array lacks or has besides."""
    shape = tuple(data.draw(st.lists(st.integers(1, 4), min_size=1, max_size=3)))
    mask = np.array(data.draw(st.lists(st.booleans(), min_size=int(np.prod(shape)), max_size=int(np.prod(shape)))))
    mask = mask.reshape(shape)
    entries = Selected.around(mask)
    own = entries.of_all(mask)
    assert own.shape == entries.shape
    assert_array_equal(np.stack(entries.among_all(np.nonzero(own))), np.stack(np.nonzero(mask)))
    some = data.draw(st.integers(0, len(shape)))
    array = np.arange(np.prod(shape[some:]) * 6.0).reshape(*shape[some:], 2, 3)
    taken = np.broadcast_to(entries(array, 2), (*entries.shape, 2, 3))
    assert_array_equal(taken[own], np.broadcast_to(array, (*shape, 2, 3))[mask])
