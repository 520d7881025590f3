"""Long chains: a stage is as far from its dead point as it is alone, and links are evaluated together."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.models import Linkage, Motion, PoseState
from reference.linkages import scissor


@pytest.mark.parametrize("stages", [8, 16])
def test_a_scissor_of_many_stages_is_as_good_as_one(stages: int) -> None:
    foot = np.array([-0.6, -0.4, 0.0, 0.1, 0.19, 0.19999])
    one, two, many = (scissor(count).move(slide=foot) for count in (1, 2, stages))
    assert one.state.tolist() == [PoseState.REGULAR] * 5 + [PoseState.NEAR_DEAD_POINT]
    np.testing.assert_array_equal(many.state, one.state)
    np.testing.assert_array_equal(two.state, one.state)
    np.testing.assert_allclose(many.conditioning, two.conditioning, rtol=1e-6)


def arm(links: int) -> Linkage:
    """Links one on the other, each with a mass at its end, and each with a drive of its own."""
    linkage = Linkage({f"P{k}": (0.1 * k, 0.02 * (k % 2)) for k in range(links + 1)})
    for k in range(links):
        linkage.link(f"L{k}", f"P{k}", f"P{k + 1}", mass=2.0, centre=(0.1 * (k + 1), 0.02 * ((k + 1) % 2)), inertia=0.0)
        linkage.revolute(f"P{k}", f"L{k - 1}" if k else "ground", f"L{k}", drive=True)
    linkage.gravity((0.0, -9.81))
    return linkage


@pytest.mark.parametrize("shape", [(), (40,)])
def test_links_of_a_chain_are_evaluated_together(shape: tuple[int, ...], monkeypatch: pytest.MonkeyPatch) -> None:
    """Not each with all those before it; the drives carry what hangs on them, by the lever of each mass."""
    count, run = 0, Motion._run

    def counted(motion: Motion, *given: object) -> object:
        nonlocal count
        count += 1
        return run(motion, *given)  # type: ignore[arg-type]

    monkeypatch.setattr(Motion, "_run", counted)
    angles = {f"P{k}": np.full(shape, 0.03 * k) for k in range(12)}
    motion = arm(12).move(angles)
    found = motion.reactions()
    motion.frame()
    assert count == 2  # poses, and their motions
    places = np.stack([motion.position(f"P{k}") for k in range(13)])
    for k in range(12):
        lever = (places[k + 1 :, ..., 0] - places[k, ..., 0]).sum(axis=0)
        np.testing.assert_allclose(found.drive(f"P{k}")[..., 0], 2.0 * 9.81 * lever, rtol=1e-12)
