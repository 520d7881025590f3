"""The steps of a program as calls of NumPy, those that only some results need apart."""

from __future__ import annotations

import operator
from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np

from ..structure.parts import Extended
from .entry_steps import Step, divided, least, most, negative, widen

# A function, the places of its operands and of its result, and the places that are not read any more.
Call = tuple[Callable[[Any, Any], Any], int, int, int, tuple[int, ...]]


class NumpyCalls:
    """The steps of a program: those that all results need, and the others, which only some results need.

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
    needed
        Places of what all results need.
    groups
        Places of each group of numbers that are asked for together.

    Attributes
    ----------
    first
        Place of the first load.
    shared, loaded
        Calls of the steps that all results need, those that do not depend on the loads and those that do.
    """

    def __init__(
        self,
        begin: int,
        shared: Sequence[Step],
        loads: int,
        loaded: Sequence[Step],
        needed: Sequence[int],
        groups: Sequence[Sequence[int]],
    ) -> None:
        self.first = begin + len(shared)
        self._groups = groups
        self._steps = dict(enumerate(shared, begin)) | dict(enumerate(loaded, self.first + loads))
        self._done = self._needed(needed)
        read = {k for place, (_, a, b) in self._steps.items() if place not in self._done for k in (a, b)}
        kept = read.union(needed, *groups)
        done = {k: self._steps[k] for k in sorted(self._done)}
        before = {k: step for k, step in done.items() if k < self.first}
        after = {k: step for k, step in done.items() if k >= self.first}
        self.shared = _calls(before, kept.union(k for _, a, b in after.values() for k in (a, b)))
        self.loaded = _calls(after, kept)
        self._of_group: dict[int, list[Call]] = {}

    def of_group(self, index: int) -> list[Call]:
        """The calls that a group of numbers needs beyond those that all results need."""
        if index not in self._of_group:
            asked = self._groups[index]
            needed = sorted(self._needed(asked) - self._done)
            self._of_group[index] = _calls({k: self._steps[k] for k in needed}, asked)
        return self._of_group[index]

    def _needed(self, places: Iterable[int]) -> set[int]:
        """Places of the steps that some results need, themselves included."""
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
