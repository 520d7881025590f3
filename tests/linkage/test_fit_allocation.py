"""The cheapest fits of a linkage's joints: beside every choice there is, on random four-bars."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import product

import numpy as np
import pytest
from linkframe.framework import FrameError
from linkframe.models import FitAllocation, Linkage, Motion, fit

FITS = ("H6/g5", "H7/g6", "H8/f7", "H9/d9")
COSTS = {"H6/g5": 9.0, "H7/g6": 5.0, "H8/f7": 3.0, "H9/d9": 1.5}
# Roughly from precise to loose; each joint takes one of them.
TWELVE = ("H6/g5", "H6/h6", "H7/h6", "H7/g6", "H7/f7", "H8/h7", "H8/f7", "H8/e8", "H9/e9", "H9/d9", "H10/d9", "H10/d10")
CHOICES = np.array(list(product(range(12), repeat=4)))
ANGLES = np.linspace(0.0, 2.0 * np.pi, 8, endpoint=False)
PINS = (("A", "ground", "crank"), ("B", "crank", "coupler"), ("D", "coupler", "rocker"), ("E", "rocker", "ground"))


def crank_rocker(rng: np.random.Generator, clearance: float | None = None, poses: np.ndarray = ANGLES) -> Motion:
    """A four-bar whose crank turns fully (Grashof), with a point on its coupler."""
    crank, ground, rocker = 0.1, rng.uniform(0.25, 0.3), rng.uniform(0.2, 0.25)
    coupler = rng.uniform(ground + crank - rocker + 0.03, ground + rocker - crank - 0.03)
    reach = ground - crank
    inner = np.arccos((rocker**2 + reach**2 - coupler**2) / (2.0 * rocker * reach))
    d = np.array([ground - rocker * np.cos(inner), rocker * np.sin(inner)])
    linkage = Linkage(A=(0, 0), B=(crank, 0), P=rng.uniform(0.0, 0.3, 2), D=d, E=(ground, 0))
    for name, ends in (("crank", "AB"), ("coupler", "BPD"), ("rocker", "DE")):
        linkage.link(name, *ends)
    for pin, first, second in PINS:
        given = clearance if pin == "A" else None
        linkage.revolute(pin, first, second, drive=pin == "A", clearance=given)
    return linkage.move(A=poses)


@dataclass(frozen=True)
class EveryChoice:
    """All choices of a fit for each joint: prices, and greatest displacements from derivatives along directions.

    `fixed` are vectors (poses, 2, m) of single deviations beside the clearances.
    """

    motion: Motion
    diameters: dict[str, float]
    fixed: np.ndarray
    power: int

    @cached_property
    def offsets(self) -> np.ndarray:
        sizes = np.array([[fit(size, name).offset for name in TWELVE] for size in self.diameters.values()])
        return sizes[np.arange(len(sizes))[:, None], CHOICES.T]

    @cached_property
    def joints(self) -> np.ndarray:
        by = self.motion.sensitivity("P").joints
        return np.stack([np.swapaxes(by[pin][:, :2, :2], 1, 2) for pin in self.diameters])

    def reached(self, which: np.ndarray, turns: int) -> np.ndarray:
        """Of some choices, the most over so many directions: a little less than over all directions there are."""
        turn = np.linspace(0.0, np.pi, turns, endpoint=False)
        circle = np.stack([np.cos(turn), np.sin(turn)])
        across = np.linalg.norm(self.joints @ circle, axis=2).reshape(len(self.joints), -1) ** self.power
        others = np.sum(np.abs(np.swapaxes(self.fixed, 1, 2) @ circle) ** self.power, axis=1).ravel()
        sums = (self.offsets[:, which] ** self.power).T @ across + others
        return np.asarray(np.max(sums, axis=1) ** (1.0 / self.power))


@pytest.mark.parametrize("combine", ["worst case", "statistical"])
def test_the_cheapest_of_all_choices(combine: str) -> None:
    """Fifty four-bars, all 12⁴ choices for their four pins: none that is cheaper holds."""
    rng = np.random.default_rng(4)
    mixed = 0
    for _ in range(50):
        motion = crank_rocker(rng, poses=rng.uniform(0.0, 2.0 * np.pi, 2))
        diameters = dict(zip("ABDE", rng.uniform(0.004, 0.04, 4).tolist(), strict=True))
        prices = dict(zip(TWELVE, (10.0 / np.arange(2, 14) + rng.uniform(0.0, 0.3, 12)).tolist(), strict=True))
        fixed = 1e-5 * motion.sensitivity("P").lengths["crank"][:, :2, None]
        every = EveryChoice(motion, diameters, fixed, 1 if combine == "worst case" else 2)
        price = np.array(list(prices.values()))[CHOICES].sum(axis=1)
        least = every.reached(np.zeros(1, dtype=np.int64), 720)[0]
        limit = float(least * rng.uniform(1.05, 4.0))
        found = motion.allocate(
            "P", limit, diameters=diameters, fits=TWELVE, costs=prices, combine=combine, lengths={"crank": 1e-5}
        )
        cheaper = np.flatnonzero(price < found.cost - 1e-9)
        left = cheaper[every.reached(cheaper, 8) <= limit]
        # What is within the steps of the circle of the limit may be judged either way.
        assert np.all(every.reached(left, 720) > limit * (1.0 - 1e-5))
        chosen = [TWELVE.index(found.fits[pin].name) for pin in diameters]
        own = np.flatnonzero(np.all(np.array(chosen) == CHOICES, axis=1))
        assert np.isclose(price[own[0]], found.cost, rtol=1e-12)
        assert every.reached(own, 720)[0] <= limit * (1.0 + 1e-5)
        assert found.greatest.max() <= limit * (1.0 + 1e-6)
        mixed += len(set(chosen)) > 1
    assert mixed >= 40


def test_all_that_deviates_counts() -> None:
    """Clearances of the description and uneven tolerances beside those that are chosen: the worst case says so."""
    motion = crank_rocker(np.random.default_rng(7), clearance=8e-6)
    others = {"lengths": {"crank": (-1e-5, 2e-5)}, "drives": {"A": 1e-4}}
    diameters = {"B": 0.01, "D": 0.01}
    found = motion.allocate("P", 1.6e-4, diameters=diameters, fits=FITS, costs=COSTS, **others)
    reached = {}
    for names in product(FITS, repeat=2):
        clearances = {pin: fit(0.01, name).offset for pin, name in zip("BD", names, strict=True)}
        reached[names] = float(motion.worst_case("P", clearances=clearances, **others).greatest.max())
    best = min(sum(COSTS[name] for name in names) for names, far in reached.items() if far <= 1.6e-4)
    assert found.cost == best
    assert found.clearances == {pin: fit(0.01, each.name).offset for pin, each in found.fits.items()}
    assert np.isclose(found.greatest.max(), reached[tuple(each.name for each in found.fits.values())], rtol=1e-12)


def test_what_binds_is_told() -> None:
    """An arm of three pins that are all as far from its end: no pose differs, and the largest pin is to blame."""
    linkage = Linkage(A=(0, 0), B=(1, 0), C=(2, 0))
    linkage.link("crank", "A", "B")
    linkage.link("arm", "B", "C")
    linkage.revolute("A", "ground", "crank", drive=True)
    linkage.revolute("B", "crank", "arm", drive=True)
    found = linkage.move().allocate("C", 6e-5, diameters={"A": 0.01, "B": 0.02}, fits=("H7/g6", "H8/f7"))
    assert isinstance(found, FitAllocation)
    assert found.binding == ((),)
    shares = {"joint A": 25.0 / 45.5, "joint B": 20.5 / 45.5}
    assert list(found.shares()) == list(shares)
    assert np.allclose(list(found.shares().values()), list(shares.values()), rtol=1e-12)
    assert "A H8/f7, B H7/g6" in repr(found)
    dear = linkage.move().allocate(
        "C", 6e-5, diameters={"A": 0.01, "B": 0.02}, fits=("H7/g6", "H8/f7"), costs=lambda each: each.hole.size
    )
    assert dear.cost == 0.03


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"limit": 1e-7}, "no fits hold 1e-07: with the tightest of all joints P goes"),
        ({"limit": -1.0}, "give the radius of its zone"),
        ({"fits": ("H7/k6",)}, "can have an interference of 1e-05 m"),
        ({"costs": {"H7/g6": 1.0}}, "costs have no fit"),
        ({"combine": "sum"}, "choose 'worst case' or 'statistical'"),
        ({"diameters": {}}, "no joints or no fits"),
        ({"clearances": {"B": 1e-5}}, "has a diameter and a clearance"),
        ({"combine": "statistical", "lengths": {"crank": (0.0, 1e-6)}}, "give half widths, not pairs"),
        ({"length": {"crank": 1e-6}}, "'length' are none of a worst case"),
    ],
)
def test_what_is_refused(changes: dict[str, object], told: str) -> None:
    given = {"limit": 1e-3, "diameters": {"B": 0.01}, **changes}
    with pytest.raises(FrameError, match=told):
        crank_rocker(np.random.default_rng(1)).allocate("P", **given)  # type: ignore[arg-type]


def test_dead_points_are_refused() -> None:
    """A parallelogram whose links lie in one line."""
    linkage = Linkage(A=(0, 0), B=(0, 1), C=(2, 1), D=(2, 0))
    for name in ("AB", "BC", "CD"):
        linkage.link(name, *name)
    linkage.revolute("A", "ground", "AB", drive=True)
    for pin, first, second in (("B", "AB", "BC"), ("C", "BC", "CD"), ("D", "CD", "ground")):
        linkage.revolute(pin, first, second)
    with pytest.raises(FrameError, match="at pose 1 nothing is known to first order"):
        linkage.move(A=np.radians([0.0, -90.0])).allocate("C", 1e-3, diameters={"B": 0.01})


@pytest.mark.parametrize("name", FITS)
def test_a_length_that_is_wider_to_one_side_leaves_the_joint_the_rest(name: str) -> None:
    """An arm that can only be too long, by 0.2 mm: at its end there is room for a pin of this fit and none looser."""
    arm = Linkage(A=(0, 0), P=(0.2, 0))
    arm.link("arm", "A", "P")
    arm.revolute("A", "ground", "arm", drive=True)
    limit = 2e-4 + fit(0.01, name).offset * (1.0 + 1e-6)
    costs = {each: -fit(0.01, each).offset + 1.0 for each in FITS}
    found = arm.move(A=[0.3]).allocate(
        "P", limit, diameters={"A": 0.01}, fits=FITS, costs=costs, lengths={"arm": (0.0, 2e-4)}
    )
    assert found.fits["A"].name == name
    assert np.allclose(found.greatest, limit, rtol=1e-5, atol=0.0)
