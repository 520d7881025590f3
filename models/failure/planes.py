"""Probability of failure where planes bound what is safe."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
Index = NDArray[np.int64]


def beyond_planes(normals: Array, beta: Array, pose: Index, rng: np.random.Generator) -> float:
    """Probability of failing at one pose or more.

    Where the median is safe, what lies beyond at least one plane of the pose fails. Where it fails, what lies beyond
    all of them does: each plane is then the edge of something safe.

    Parameters
    ----------
    normals
        Unit normals (n, k), into what fails.
    beta
        Distances of the planes from the median, (n,), negative where the median fails.
    pose
        Their poses, (n,), the nearest plane of each first.
    rng
        Source of the samples.
    """
    safe: list[tuple[Array, Array]] = []
    fails = np.zeros(len(beta), dtype=bool)
    for each in np.unique(pose):
        here = np.flatnonzero(pose == each)
        if beta[here[0]] < 0.0:
            # Planes of the other kind bound nothing that holds the median.
            here = here[beta[here] < 0.0]
            fails[here] = True
            safe.append((-normals[here], -beta[here]))
    others = ~fails & ~np.isin(pose, pose[fails])
    if not safe:
        return union_of_half_spaces(normals, beta, rng)
    from scipy.special import ndtr

    first = min(range(len(safe)), key=lambda k: float(ndtr(-safe[k][1]).sum()))

    def elsewhere(scores: Array) -> Mask:
        """Whether all other poses are safe."""
        out = np.all(scores @ normals[others].T < beta[others], axis=1)
        for k, (directions, distances) in enumerate(safe):
            if k != first:
                out &= np.any(scores @ directions.T >= distances, axis=1)
        return np.asarray(out)

    alone = len(safe) == 1 and not others.any()
    return 1.0 - union_of_half_spaces(*safe[first], rng, None if alone else elsewhere)


def union_of_half_spaces(
    normals: Array,
    beta: Array,
    rng: np.random.Generator,
    counts: Callable[[Array], Mask] | None = None,
    samples: int = 20_000,
) -> float:
    """Probability of being beyond at least one of several planes.

    Each sample lies beyond one plane, chosen by its probability, and counts for one over the number of planes that it
    lies beyond (A. B. Owen, Y. Maximov & M. Chertkov, Electronic J. of Statistics 13, 2019, doi:10.1214/18-EJS1507).

    Parameters
    ----------
    normals
        Unit normals (n, k), away from the median.
    beta
        Distances of the planes, (n,).
    rng
        Source of the samples.
    counts
        Which scores (m, k) count; all where it is left out.
    samples
        Their number.
    """
    from scipy.special import ndtr, ndtri

    single = ndtr(-beta)
    whole = float(single.sum())
    if whole == 0.0 or (len(beta) == 1 and counts is None):
        return whole
    chosen = rng.choice(len(beta), size=samples, p=single / whole)
    scores = rng.normal(size=(samples, normals.shape[1]))
    # The score along the chosen normal, drawn from what lies beyond its plane.
    along = -ndtri(np.maximum(rng.random(samples), 2.0**-54) * single[chosen])
    scores += (along - np.sum(scores * normals[chosen], axis=1))[:, None] * normals[chosen]
    beyond = (scores @ normals.T >= beta).sum(axis=1)
    share = 1.0 / np.maximum(beyond, 1)
    return min(1.0, whole * float(np.mean(share if counts is None else share * counts(scores))))
