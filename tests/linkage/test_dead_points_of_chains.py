"""Dead points and ranges of long chains: those that the whole equations tell, found at a cost that grows with them."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from linkframe.models import Linkage
from linkframe.models.linkage.poses.motion_path import MotionPath

from .test_long_chains import scissor


def four_bars(stages: int, seed: int) -> Linkage:
    """Four-bars one after the other, each driven by the rocker of the one before; their bars differ."""
    rng = np.random.default_rng(seed)
    points, links = {}, []
    for k in range(stages):
        shift = 10.0 * k
        points |= {f"A{k}": (shift, 0.0), f"D{k}": (shift + 6.0, 0.0)}
        points |= {f"B{k}": (shift + rng.uniform(-1.0, 1.0), rng.uniform(1.5, 2.5))}
        points |= {f"C{k}": (shift + 6.0 + rng.uniform(-1.0, 1.0), rng.uniform(3.0, 4.0))}
        links += [(f"b{k}", f"B{k}", f"C{k}")]
    linkage = Linkage(points)
    linkage.link("l0", "A0", "B0")
    for k in range(stages):
        # The rocker of one and the crank of the next are one link, which turns at D of the one.
        onward = (f"A{k + 1}", f"B{k + 1}") if k + 1 < stages else ()
        linkage.link(f"l{k + 1}", f"C{k}", f"D{k}", *onward[1:])
    for k in range(stages):
        linkage.link(*links[k])
        linkage.revolute(f"B{k}", f"l{k}", f"b{k}")
        linkage.revolute(f"C{k}", f"b{k}", f"l{k + 1}")
        linkage.revolute(f"D{k}", f"l{k + 1}", "ground")
    linkage.revolute("A0", "ground", "l0", drive=True)
    return linkage


CASES: dict[str, tuple[Callable[[], Linkage], str]] = {
    "scissor": (lambda: scissor(2), "slide"),
    "four-bars 0": (lambda: four_bars(2, 10), "A0"),
    "four-bars 2": (lambda: four_bars(2, 2), "D1"),
}


@pytest.mark.parametrize("name", CASES)
def test_sparse_steps_find_what_the_whole_equations_tell(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    make, joint = CASES[name]
    points, reach = make().dead_points(joint), make().drive_range(joint)
    monkeypatch.setattr(MotionPath, "sparse", None)
    whole, far = make().dead_points(joint), make().drive_range(joint)
    assert [(x.joint, x.change_point) for x in points] == [(x.joint, x.change_point) for x in whole]
    np.testing.assert_allclose([x.value for x in points], [x.value for x in whole], rtol=0.0, atol=1e-9)
    np.testing.assert_allclose([reach.lower, reach.upper], [far.lower, far.upper], rtol=0.0, atol=1e-9)
    assert (reach.lower_joint, reach.upper_joint) == (far.lower_joint, far.upper_joint)


def test_the_whole_equations_are_looked_at_in_few_places(monkeypatch: pytest.MonkeyPatch) -> None:
    large, svd = [], np.linalg.svd

    def counted(matrix: np.ndarray, *args: object, **options: object) -> object:
        large.append(matrix.shape[-1] > 10)
        return svd(matrix, *args, **options)

    monkeypatch.setattr(np.linalg, "svd", counted)
    points = scissor(5).dead_points("slide")
    assert [round(x.value, 9) for x in points] == [-1.8, -0.8, 0.2]
    assert sum(large) < 500
