"""Planes and paraboloids that bound the safe domain, and the probability beyond at least one of several."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from .second_order import beyond_paraboloid

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
Index = NDArray[np.int64]

# Number of samples tested at once.
TOGETHER = 2000
# Number of standard errors from which on a difference of probabilities counts.
TOLD = 4.0


@dataclass(frozen=True, eq=False)
class Edges:
    """Surfaces in standard normal scores u; beyond one lie the scores with ``n.u - ½ Σ κᵢ (tᵢ.u)² >= β``.

    Attributes
    ----------
    normals
        Unit normals (n, k).
    beta
        Distances from the median, (n,), negative where the median is beyond.
    curvature, tangents
        Principal curvatures κ, (n, k - 1), and their directions t as columns, (n, k, k - 1); None for planes.
    """

    normals: Array
    beta: Array
    curvature: Array | None = None
    tangents: Array | None = None

    def __getitem__(self, which: Index | Mask) -> Edges:
        """Select surfaces."""
        parts = self.normals, self.beta, self.curvature, self.tangents
        return Edges(*(None if each is None else each[which] for each in parts))  # type: ignore[arg-type]

    @cached_property
    def probability(self) -> Array:
        """Probability beyond each surface, (n,)."""
        from scipy.special import ndtr

        if self.curvature is None:
            return np.asarray(ndtr(-self.beta))
        return beyond_paraboloid(self.beta, self.curvature)

    @property
    def turned(self) -> Edges:
        """The same surfaces with their sides exchanged."""
        bent = None if self.curvature is None else -self.curvature
        return replace(self, normals=-self.normals, beta=-self.beta, curvature=bent)

    def beyond(self, scores: Array) -> Mask:
        """Whether scores (m, k) are beyond each surface, (m, n)."""
        parts = [self._excess(scores[start : start + TOGETHER]) for start in range(0, len(scores), TOGETHER)]
        return np.concatenate(parts) >= self.beta

    def _excess(self, scores: Array) -> Array:
        along = scores @ self.normals.T
        if self.curvature is None or self.tangents is None:
            return np.asarray(along)
        across = np.einsum("mk,nkj->mnj", scores, self.tangents)
        return np.asarray(along - 0.5 * np.einsum("mnj,nj->mn", across**2, self.curvature))

    def draw(self, rng: np.random.Generator, chosen: Index) -> tuple[Array, Array | None]:
        """Random scores (m, k) beyond the chosen surfaces (m,), and weights (m,) if not from the normal density."""
        from scipy.special import ndtr, ndtri

        scores = rng.normal(size=(len(chosen), self.normals.shape[1]))
        normals, share = self.normals[chosen], np.maximum(rng.random(len(chosen)), 2.0**-54)
        if self.curvature is None or self.tangents is None:
            # The score along the normal has the normal distribution truncated at the plane.
            along = -ndtri(share * self.probability[chosen])
            return scores + (along - np.sum(scores * normals, axis=1))[:, None] * normals, None
        bent, tangents, beta = self.curvature[chosen], self.tangents[chosen], self.beta[chosen]
        # Spread across the normal: nearly that of the scores beyond the paraboloid if β is large.
        spread = (np.maximum(1.0 + np.maximum(beta, 0.0)[:, None] * bent, 0.0) + 0.5 * np.maximum(-bent, 0.0)) ** -0.5
        unit = np.einsum("mk,mkj->mj", scores, tangents)
        across = unit * spread
        left = ndtr(-(beta + 0.5 * np.sum(bent * across**2, axis=1)))
        weight = left * np.prod(spread, axis=1) * np.exp(0.5 * np.sum(unit**2 - across**2, axis=1))
        along = -ndtri(np.maximum(share * left, 1e-300))
        return along[:, None] * normals + np.einsum("mkj,mj->mk", tangents, across), weight


def beyond_edges(edges: Edges, pose: Index, rng: np.random.Generator) -> float:
    """Probability of failing at one pose or more.

    At a pose where the median is safe, scores beyond at least one surface fail. Where the median fails, scores beyond
    all surfaces fail: each surface then bounds a safe domain.

    Parameters
    ----------
    edges
        The n surfaces, with the failures beyond them.
    pose
        Numbers of their poses, (n,), the nearest surface of each pose first.
    rng
        Random number generator.

    Returns
    -------
    float
        The probability; 0 if the median fails and the probability of failure is less than four standard errors.
    """
    beta = edges.beta
    safe: list[Edges] = []
    fails = np.zeros(len(beta), dtype=bool)
    for each in np.unique(pose):
        here = np.flatnonzero(pose == each)
        if beta[here[0]] < 0.0:
            # The other surfaces do not bound the domain with the median.
            here = here[beta[here] < 0.0]
            fails[here] = True
            safe.append(edges[here].turned)
    if not safe:
        return union(edges, rng)[0]
    others = edges[~fails & ~np.isin(pose, pose[fails])]
    first = min(range(len(safe)), key=lambda k: float(safe[k].probability.sum()))

    def elsewhere(scores: Array) -> Mask:
        """Whether all other poses are safe."""
        out = ~others.beyond(scores).any(axis=1)
        for k, own in enumerate(safe):
            if k != first:
                out &= own.beyond(scores).any(axis=1)
        return np.asarray(out)

    alone = len(safe) == 1 and not len(others.beta)
    probability, error = union(safe[first], rng, None if alone else elsewhere)
    return 1.0 - probability if 1.0 - probability > TOLD * error else 0.0


def union(
    edges: Edges, rng: np.random.Generator, counts: Callable[[Array], Mask] | None = None, samples: int = 20_000
) -> tuple[float, float]:
    """Probability of being beyond at least one of several surfaces, and its standard error.

    Each sample lies beyond one surface, chosen by its probability, and counts for one over the number of surfaces that
    it lies beyond (A. B. Owen, Y. Maximov & M. Chertkov, Electronic J. of Statistics 13, 2019, doi:10.1214/18-EJS1507).
    So nothing counts twice where surfaces overlap.

    Parameters
    ----------
    edges
        The surfaces.
    rng
        Random number generator.
    counts
        Function that says which scores (m, k) count, (m,); all if None.
    samples
        Number of samples.
    """
    single = edges.probability
    whole = float(single.sum())
    if whole == 0.0 or (len(single) == 1 and counts is None):
        return whole, 0.0
    chosen = rng.choice(len(single), size=samples, p=single / whole)
    scores, weight = edges.draw(rng, chosen)
    share = 1.0 / np.maximum(edges.beyond(scores).sum(axis=1), 1)
    if counts is not None:
        share = share * counts(scores)
    if weight is None:
        weight = np.ones(samples)
    total = np.bincount(chosen, weight, len(single))
    total[total == 0.0] = 1.0
    mean = np.bincount(chosen, weight * share, len(single)) / total
    deviation = np.bincount(chosen, (weight * (share - mean[chosen])) ** 2, len(single))
    error = np.sqrt(np.sum(single**2 * deviation / total**2))
    return min(1.0, float(single @ mean)), float(error)
