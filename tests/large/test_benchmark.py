"""What the benchmark of large displacement measures as error, at a tiny size; no time is asserted."""

from __future__ import annotations

import pytest
from benchmarks.large_displacement import OURS, SPACE, Cases, linkframe, targets, ways, worst


@pytest.mark.parametrize("name", [OURS, SPACE])
def test_error_with_one_piece_a_member(name: str) -> None:
    assert worst(ways()[name][0], 1) < 3e-6


def test_space_gives_what_the_plane_gives() -> None:
    cases = Cases.of(3, 2)
    assert linkframe(cases, 1).shape == (3, 2, 2)
    assert linkframe(cases, 1, across=1e-9) == pytest.approx(linkframe(cases, 1), rel=1e-8, abs=1e-12)


def test_targets_compare_at_equal_error() -> None:
    def row(contender: str, microseconds: float, error: float) -> dict[str, object]:
        return {"contender": contender, "microseconds": microseconds, "error": error}

    peer = "exudyn, planar cables, reused"
    found = targets([row(OURS, 10.0, 1e-6), row(peer, 50.0, 1e-3), row(peer, 200.0, 1e-6), row(peer, 900.0, 1e-9)])
    assert [target.met for target in found] == [True, True]
    assert "20 times" in found[1].measured
