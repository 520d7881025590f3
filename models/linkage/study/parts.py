"""Tolerances of geometry, clearance, compliance, load and temperature, separately and together."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Protocol, TypeVar

import numpy as np

from ....framework.batch import Array
from ....framework.listing import text_table
from .heat import NAME
from .tolerances import Tolerance

KINDS = ("geometry", "clearance", "compliance", "load", "thermal")
TOGETHER = "together"
# Numbers of a joint that determine its clearance; the worst case covers all directions of contact already.
OF_CLEARANCE = ("clearance", "contact")
# Numbers of links, springs and materials that determine forces on the linkage, and not its compliance.
OF_LOAD = {"links": ("mass", "inertia", "centre"), "springs": ("length", "damping"), "materials": ("density",)}


def kind_of_tolerance(name: str, tolerance: Tolerance) -> str:
    """Kind of a tolerance, one of `KINDS`, by the first of its numbers."""
    if name.startswith(f"{NAME}.") and not tolerance.nominal:
        return "thermal"
    place = next(iter(tolerance.nominal))
    last = place[2] if len(place) > 2 else ""
    if place[0] == "joints" and last in OF_CLEARANCE:
        return "clearance"
    if place[0] in ("loads", "gravity") or last in OF_LOAD.get(str(place[0]), ()):
        return "load"
    if place[0] == "points" or last in ("axis", "second", "reference", "pitch", "length", "point"):
        return "geometry"
    return "compliance"


class StudyPart(Protocol):
    """The part of a study that the table needs."""

    @property
    def points(self) -> tuple[str, ...]:
        """Names of the points."""

    @property
    def mean(self) -> Array:
        """Mean displacement, (points, poses, 3)."""

    @property
    def std(self) -> Array:
        """Standard deviation, (points, poses, 3)."""

    @property
    def greatest(self) -> Array:
        """Largest displacement in the worst case, (points, poses)."""

    def probability(self, limit: float) -> Array:
        """Share of the samples farther than `limit` from the nominal position, (points, poses)."""


P = TypeVar("P", bound=StudyPart)


class AccuracyParts(Mapping[str, P]):
    """Studies of each kind of tolerance, and that of all ``"together"``; made by `AccuracyStudy.parts`.

    Parameters
    ----------
    parts
        Studies by kind.
    """

    def __init__(self, parts: Mapping[str, P]) -> None:
        self._parts = dict(parts)

    def __getitem__(self, kind: str) -> P:
        if kind not in self._parts:
            raise KeyError(f"there is no part {kind!r}: choose one of {', '.join(self._parts)}")
        return self._parts[kind]

    def __iter__(self) -> Iterator[str]:
        return iter(self._parts)

    def __len__(self) -> int:
        return len(self._parts)

    def probability(self, limit: float) -> dict[str, Array]:
        """Share of the samples in which a point is outside its zone, by kind.

        Parameters
        ----------
        limit
            Radius of the zone about the nominal position, a length.

        Returns
        -------
        dict
            By kind: probability, (points, poses); see `AccuracyStudy.probability`.
        """
        return {kind: part.probability(limit) for kind, part in self.items()}

    def __repr__(self) -> str:
        """Table with a line for each kind, at the pose with the largest worst case of the first point."""
        whole = self[TOGETHER]
        pose = int(np.argmax(np.nan_to_num(whole.greatest[0], nan=-1.0)))
        heads = ["part", *(f"{name}{axis}" for name in ("mean u_", "σ_") for axis in "xyz"), "worst"]
        rows = [
            [kind, *(f"{value:.4g}" for value in (*part.mean[0, pose], *part.std[0, pose], part.greatest[0, pose]))]
            for kind, part in self.items()
        ]
        return text_table(f"Displacement of {whole.points[0]} at pose {pose}, apart and together", heads, rows)
