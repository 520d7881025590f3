"""The steps of a program as calls of NumPy, those that only some results need apart."""

from __future__ import annotations

import operator
from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np

from ..structure.parts import Extended
from .entry_steps import Step, divided, kept_places, least, most, negative, widen

# A function, the places of its operands and of its result, and the places that are not read any more.
Call = tuple[Callable[[Any, Any], Any], int, int, int, tuple[int, ...]]


class NumpyCalls:
    """The steps of a program: the shared ones, those that the unknowns need, and those of the displacements of a node.

    Numbers are identified by their place in the order: given numbers and constants, results of the shared steps, loads,
    results of the loaded steps.

    Parameters
    ----------
    begin
        Place of the result of the first shared step.
    shared, loaded
        Steps that do not depend on the loads, and those that do.
    loads
        Number of loads.
    nodes, known, ratios
        Places of the displacements of all nodes, of the unknowns, and of the least pivot ratios.

    Attributes
    ----------
    first
        Place of the first load.
    shared, loaded
        Calls of the shared steps, and of those of the others that the unknowns need.
    """

    def __init__(
        self,
        begin: int,
        shared: Sequence[Step],
        loads: int,
        loaded: Sequence[Step],
        nodes: Sequence[int],
        known: Sequence[int],
        ratios: Sequence[int],
    ) -> None:
        self.first = begin + len(shared)
        self._nodes = nodes
        self._steps = dict(enumerate(loaded, self.first + loads))
        self.shared = _calls(dict(enumerate(shared, begin)), kept_places(ratios, loaded, known, nodes, self.first))
        self._done = self._needed(known)
        later = {k: step for k, step in self._steps.items() if k not in self._done}
        read = {k for _, a, b in later.values() for k in (a, b)}
        self.loaded = _calls({k: self._steps[k] for k in sorted(self._done)}, {*known, *read, *nodes})
        self._of_node: dict[int, list[Call]] = {}

    def of_node(self, node: int) -> list[Call]:
        """The calls that the displacements of a node need beyond the others."""
        if node not in self._of_node:
            asked = self._nodes[6 * node : 6 * node + 6]
            needed = sorted(self._needed(asked) - self._done)
            self._of_node[node] = _calls({k: self._steps[k] for k in needed}, asked)
        return self._of_node[node]

    def _needed(self, places: Iterable[int]) -> set[int]:
        """Places of the loaded steps that some results need, themselves included."""
        found: set[int] = set()
        left = [k for k in places if k in self._steps]
        while left:
            k = left.pop()
            if k not in found:
                found.add(k)
                _, a, b = self._steps[k]
                left += [j for j in (a, b) if j in self._steps]
        return found


def carry_out(calls: Sequence[Call], values: list[Any]) -> None:
    """Add the results of calls to a list of numbers by place."""
    for function, a, b, place, over in calls:
        values[place] = function(values[a], values[b])
        for k in over:
            values[k] = None


def _calls(steps: dict[int, Step], kept: Iterable[int]) -> list[Call]:
    """Steps by place as calls, in order; results that are not `kept` are dropped after they were read."""
    last = {k: place for place, (_, a, b) in steps.items() for k in (a, b)}
    keep = set(kept)
    over: dict[int, list[int]] = {}
    for k, place in last.items():
        if k in steps and k not in keep:
            over.setdefault(place, []).append(k)
    return [
        (_OF_ARRAYS.get(function, function), a, b, place, tuple(over.get(place, ())))
        for place, (function, a, b) in steps.items()
    ]


def _widen(a: Any, _: Any) -> Any:
    return np.asarray(a).astype(Extended)


def _negative(a: Any, _: Any) -> Any:
    return operator.neg(a)


# The functions of single numbers that have others for arrays.
_OF_ARRAYS: dict[Callable[[Any, Any], Any], Callable[[Any, Any], Any]] = {
    widen: _widen,
    divided: np.divide,
    negative: _negative,
    least: np.minimum,
    most: np.maximum,
}
