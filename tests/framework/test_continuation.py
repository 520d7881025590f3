"""Paths followed by predictor and corrector: a circle by its arc length, roots that end, many at once as alone."""

from __future__ import annotations

import numpy as np
from linkframe.framework.continuation import Index, Mask, PathBatch, follow
from numpy.testing import assert_allclose
from numpy.typing import NDArray

Array = NDArray[np.float64]


def test_a_circle_is_followed_by_its_arc_length_past_its_extreme_points() -> None:
    """Predicted along the tangent, corrected along the radius; each step of length h turns by atan(h)."""
    places, steps = [np.array([1.0, 0.0])], []

    def attempt(step: float) -> Array | None:
        x, y = places[-1]
        found = places[-1] + step * np.array([-y, x])
        return found / np.hypot(*found) if step <= 0.3 else None

    def accept(found: Array, step: float) -> float | None:
        places.append(found)
        steps.append(step)
        return None if len(places) == 40 else 1.5 * step

    assert follow(attempt, accept, 1.0, 1e-3)
    assert max(steps) <= 0.3
    assert_allclose(np.hypot(*np.transpose(places)), 1.0)
    turned = np.unwrap(np.arctan2(*np.transpose(places)[::-1]))
    assert_allclose(np.diff(turned), np.arctan(steps))
    assert turned[-1] > np.pi


class Roots(PathBatch[Array]):
    """``x**2 = end - s`` on paths that lead from s = 0 to s = 1 at most, and stall at the end of the real roots."""

    def __init__(self, end: Array, step: float) -> None:
        super().__init__(np.full(end.shape, step), 1e-9)
        self.end, self.s, self.halved = end, np.zeros(end.shape), 0

    def wanted(self) -> Index:
        return np.flatnonzero((self.s < 1.0) & ~self.stalled)

    def attempt(self, paths: Index) -> tuple[Array, Mask]:
        ahead = self.s[paths] + self.step[paths]
        return ahead, ahead <= self.end[paths]

    def accept(self, paths: Index, points: Array, good: Mask) -> None:
        self.s[paths] = points[good]
        self.step[paths] *= 1.2

    def shortened(self, paths: Index) -> None:
        self.halved += len(paths)


def test_paths_stall_where_they_end_and_others_go_on() -> None:
    """Each as it does alone, to the last bit."""
    ends = np.array([0.3, 2.0, 0.77, 5.0])
    paths = Roots(ends, 0.25)
    paths.run()
    assert paths.stalled.tolist() == [True, False, True, False]
    assert_allclose(paths.s[[0, 2]], ends[[0, 2]], rtol=1e-8)
    alone = [Roots(ends[k : k + 1], 0.25) for k in range(len(ends))]
    for each in alone:
        each.run()
    assert np.array_equal(paths.s, [each.s[0] for each in alone])
    assert paths.halved == sum(each.halved for each in alone)
    reached = [0.0]
    arrived = follow(
        lambda step: reached[-1] + step if reached[-1] + step <= 0.3 else None,
        lambda found, step: reached.append(found) or 1.2 * step,  # type: ignore[func-returns-value]
        0.25,
        1e-9,
    )
    assert not arrived
    assert reached[-1] == paths.s[0]


def test_what_has_no_length_has_stalled() -> None:
    paths = Roots(np.array([0.5, 2.0]), np.nan)
    paths.run()
    assert paths.stalled.all()
    assert not follow(lambda _: None, lambda _, step: step, np.inf, np.inf)
