"""The steps of a recording in the order in which they are run, with the place of each number.

Places are in the order: given numbers, constants, shared steps, loads, steps that depend on loads. Where a number in
double precision is combined with one in extended precision, it is first converted, once: the results are the same, and
operations on numbers of one type are five times as fast.
"""

from __future__ import annotations

from collections.abc import Sequence

from ..program.program import Operation, ProgramStep
from ..program.recording import Recording, Term
from ..structure.parts import Extended, Value, is_zero
from .entry_steps import OPERATIONS, Step, widen


class StepLayout:
    """The steps that compute some terms, divided into those that do not depend on the loads and the others.

    Parameters
    ----------
    recording
        The recording. Its first inputs are the given numbers, then come the loads; what was taken later is constant.
    asked
        The terms, or numbers that are zero.
    wide
        For each given number, whether it is in extended precision.
    loads
        Number of loads.
    mask
        Mask of what depends on the loads.

    Attributes
    ----------
    given, loads
        Which of the given numbers, and which of the loads, the steps need.
    wide
        For each of these given numbers, whether it is in extended precision.
    constants
        Constants of the steps.
    shared, loaded
        The steps.
    outputs
        Places of what was asked for.
    """

    def __init__(
        self, recording: Recording, asked: Sequence[Value], wide: Sequence[bool], loads: int, mask: int
    ) -> None:
        program, inputs = recording.program([value for value in asked if isinstance(value, Term)])
        count = len(wide)
        self.given = tuple(k for k in inputs if k < count)
        self.wide = tuple(wide[k] for k in self.given)
        self.loads = tuple(k - count for k in inputs if count <= k < count + loads)
        # new places of the numbers of the recorded program
        at = {given: number for number, given in enumerate(inputs)}
        self._place: dict[int, int] = {}
        self._wide: list[bool] = []
        self._widened: dict[int, int] = {}
        self._steps: list[Step] = []
        for k in self.given:
            self._put(at[k], wide=wide[k])
        # other constants, and all constants converted to extended precision
        own = [k for k in inputs if k >= count + loads]
        constants = [(at[k], float(recording.given[k])) for k in own]  # type: ignore[arg-type]
        constants += [(program.given + k, value) for k, value in enumerate(program.constants)]
        fixed: list[Value] = []
        for number, value in [*constants, (-1, 0.0)]:
            self._put(number, wide=False)
            fixed.append(value)
        for number, value in constants:
            self._widened[self._place[number]] = len(self._wide)
            self._wide.append(True)
            fixed.append(Extended(value))
        self.constants = tuple(fixed)
        for later in (False, True):
            if later:
                self.shared, self._steps = tuple(self._steps), []
                for k in self.loads:
                    self._put(at[count + k], wide=False)
            for number, step in enumerate(program.steps, program.first):
                if bool(program.masks[number] & mask) is later:
                    self._step(number, step)
        self.loaded = tuple(self._steps)
        outputs = iter(program.outputs)
        self.outputs = [self._of(next(outputs) if isinstance(value, Term) else value) for value in asked]

    @property
    def size(self) -> int:
        """Number of steps."""
        return len(self.shared) + len(self.loaded)

    def _of(self, output: int | Value) -> int:
        """Place of an output; an output that is not a term is zero."""
        if isinstance(output, int):
            return self._place[output]
        assert is_zero(output)
        return self._place[-1]

    def _put(self, number: int, *, wide: bool) -> None:
        self._place[number] = len(self._wide)
        self._wide.append(wide)

    def _step(self, number: int, step: ProgramStep) -> None:
        a = self._place[step.a]
        if step.operation is Operation.WIDEN:
            self._place[number] = self._as_wide(a)
            return
        b = self._place[step.b] if step.b >= 0 else a
        wide = self._wide[a] or self._wide[b]
        if wide:
            a, b = self._as_wide(a), self._as_wide(b)
        self._steps.append((OPERATIONS[step.operation], a, b))
        self._put(number, wide=wide)

    def _as_wide(self, place: int) -> int:
        if self._wide[place]:
            return place
        if place not in self._widened:
            self._widened[place] = len(self._wide)
            self._wide.append(True)
            self._steps.append((widen, place, place))
        return self._widened[place]
