"""A line mesh as all sources give it: points, lines between them, and sets of both by name."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..batch import Array
from ..errors import FrameError
from ..joint_protocol import JointElement
from ..names import found
from ..protocol import LineElement

Index = NDArray[np.int64]


@dataclass(frozen=True)
class LineMesh:
    """Points and lines, with sets by name.

    Attributes
    ----------
    source
        What it was read from, for messages.
    points
        Positions (n, 3).
    lines
        Numbers of the points that each line connects, (m, 2).
    line_sets, point_sets
        Numbers of the lines and of the points in each set.
    tags
        Whole numbers of the lines by the name of the array, (m,): ``"material 2"`` is the set of those with a 2.
    point_labels, line_labels
        What the source calls its points and lines; their numbers where empty.
    """

    source: str
    points: Array
    lines: Index
    line_sets: dict[str, Index] = field(default_factory=dict)
    point_sets: dict[str, Index] = field(default_factory=dict)
    tags: dict[str, Array] = field(default_factory=dict)
    point_labels: list[str] = field(default_factory=list)
    line_labels: list[str] = field(default_factory=list)

    def lines_in(self, name: str) -> Index:
        """Numbers of the lines in a set, or with a number in an array of whole numbers."""
        if name in self.line_sets:
            return self.line_sets[name]
        array, _, value = name.rpartition(" ")
        if array in self.tags and value.lstrip("-").isdigit():
            there = np.flatnonzero(self.tags[array] == int(value))
            if there.size:
                return there
        tagged = [f"{array} {int(one)}" for array, values in self.tags.items() for one in np.unique(values)[:4]]
        found(f"{self.source}: set of lines", name, [*self.line_sets, *tagged])
        raise AssertionError

    def taken(self, keep: Index, drop_unconnected: bool) -> LineMesh:
        """The mesh with some of its lines, and no point that none of them touches.

        Raises
        ------
        FrameError
            If a point lies on none of the lines and may not be left out.
        """
        lines = self.lines[keep]
        touched = np.zeros(len(self.points), dtype=bool)
        touched[lines] = True
        loose = np.flatnonzero(~touched)
        if loose.size and not drop_unconnected:
            place = tuple(float(x) for x in self.points[loose[0]])
            more = f" and {loose.size - 1} more lie" if loose.size > 1 else " lies"
            raise FrameError(
                f"{self.source}: node {self._label(int(loose[0]))} at {place}{more} on no line that becomes a member "
                "or joint: connect it, or leave such nodes out with drop_unconnected=True"
            )
        return LineMesh(
            self.source,
            self.points[touched],
            (np.cumsum(touched) - 1)[lines],
            {name: _renumbered(at, keep, len(self.lines)) for name, at in self.line_sets.items()},
            {name: _renumbered(at, np.flatnonzero(touched), len(self.points)) for name, at in self.point_sets.items()},
            {},
            [self.point_labels[k] for k in np.flatnonzero(touched)] if self.point_labels else [],
            [self.line_labels[k] for k in keep] if self.line_labels else [],
        )

    def _label(self, point: int) -> str:
        return self.point_labels[point] if self.point_labels else str(point)

    def line_names(self) -> list[str]:
        """Names of the lines, after the smallest set that each is in: ``"mast"`` where the set holds one line,
        ``"mast 0"``, ``"mast 1"``, ... or the labels of the source where it holds more."""
        count = len(self.lines)
        labels = self.line_labels or [str(k) for k in range(count)]
        names = np.array(labels, dtype=object)
        # from the largest set to the smallest, so that the smallest has the last word; of equal ones the first
        for name, at in sorted(self.line_sets.items(), key=lambda item: len(item[1]))[::-1]:
            if len(at) == 1:
                names[at] = name
            elif self.line_labels:
                names[at] = [f"{name} {labels[k]}" for k in at]
            else:
                names[at] = [f"{name} {k}" for k in range(len(at))]
        return [str(name) for name in names]


def _renumbered(given: Index, kept: Index, count: int) -> Index:
    """Numbers, among those kept, of the ones given that are kept."""
    new = np.full(count, -1, dtype=np.int64)
    new[kept] = np.arange(len(kept))
    at = new[given]
    return at[at >= 0]


def in_space(points: Any, source: str) -> Array:
    """Points (n, 3), of which a source may give one or two coordinates.

    Raises
    ------
    FrameError
        If there are more coordinates, or one is not finite.
    """
    given = np.asarray(points, dtype=np.float64)
    if given.ndim != 2 or given.shape[1] > 3:
        raise FrameError(f"{source}: points have shape {given.shape}: give up to three coordinates each")
    bad = np.flatnonzero(~np.isfinite(given).all(axis=1))
    if bad.size:
        raise FrameError(f"{source}: point {bad[0]} lies at {given[bad[0]].tolist()}: give finite coordinates")
    return np.pad(given, ((0, 0), (0, 3 - given.shape[1])))


def lines_by_element(mesh: LineMesh, element: Any) -> list[tuple[Any, Index]]:
    """Elements, each with the numbers of the lines that it is for, in the order of the sets that name them.

    Parameters
    ----------
    mesh
        Lines and their sets.
    element
        One for all, or by the name of a set; lines of a set that has None are in none of them.

    Raises
    ------
    FrameError
        If a set is unknown, or a line has no element or more than one.
    """
    for one in element.values() if isinstance(element, Mapping) else [element]:
        if not isinstance(one, (LineElement, JointElement)) and not (one is None and one is not element):
            raise FrameError(f"{mesh.source} was given the element {one!r}: give a beam or a joint, such as Beam(...)")
    if not isinstance(element, Mapping):
        return [(element, np.arange(len(mesh.lines)))]
    if not any(one is not None for one in element.values()):
        raise FrameError(f"{mesh.source} was given no element: give one for all lines, or one by the name of a set")
    owner = np.full(len(mesh.lines), -1)
    given = list(element.items())
    for number, (name, one) in enumerate(given):
        at = mesh.lines_in(name)
        other = owner[at]
        clash = [k for k in np.unique(other[other >= 0]) if given[k][1] is not one]
        if clash:
            line = at[np.flatnonzero(other == clash[0])[0]]
            raise FrameError(
                f"{mesh.source}: line {line} is in the sets {given[clash[0]][0]!r} and {name!r}, which have different "
                "elements: give it one"
            )
        owner[at] = number
    if (without := np.flatnonzero(owner < 0)).size:
        sets = [name for name, at in mesh.line_sets.items() if np.isin(without[0], at)]
        where = f"it is in {', '.join(map(repr, sets[:6]))}" if sets else "it is in no set"
        raise FrameError(
            f"{mesh.source}: {without.size} of {len(mesh.lines)} lines have no element, line {without[0]} the first "
            f"({where}): give one to a set that holds it, or None to leave it out"
        )
    return [
        (one, at) for k, (_, one) in enumerate(given) if one is not None and (at := np.flatnonzero(owner == k)).size
    ]
