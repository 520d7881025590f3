"""Temperatures of links among the tolerances of a study."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ....framework.batch import Array
from ....framework.errors import FrameError
from ...distributions import Uncertain
from ...given_distributions import distribution_of
from ..derivatives.thermal import Expansion, expansions, per_strain
from ..motion import Motion
from .tolerances import Tolerance

NAME = "temperature"


def temperature_tolerances(given: Mapping[str, Uncertain]) -> dict[str, Tolerance]:
    """Rises of temperature by link as tolerances, nominally zero, which belong to no number of the file."""
    found = {}
    for link, each in given.items():
        name = f"{NAME}.{link}"
        found[name] = Tolerance((), {}, distribution_of(name, each), True, f"{each}")
    return found


def displacements_by_heat(
    motion: Motion, points: tuple[str, ...], given: Mapping[str, Uncertain], expansion: Expansion | None
) -> dict[str, Array]:
    """By name of the tolerance: displacement of the points per degree, (points, poses, 3)."""
    if not given:
        if expansion is not None:
            raise FrameError("expansion= has no effect without temperatures=: name the links that become warmer")
        return {}
    by_link = expansions(motion.linkage.links, given, expansion)
    poses = (int(np.prod(motion.shape)), 3)
    return {
        f"{NAME}.{link}": np.stack(
            [np.broadcast_to(per_strain(motion, point, None, link)[..., :3] * by_link[link], poses) for point in points]
        )
        for link in given
    }
