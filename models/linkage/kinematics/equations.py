"""The Newton step of the closing equations as a program."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np

from .linear import Linear
from .mechanism import Mechanism
from .tape import Program, Scalar, Value


class Equations:
    """Programs for the Newton step; where the equations fall into blocks of two at most, without a call in them.

    Parameters
    ----------
    mechanism
        The compiled linkage.
    linear
        Solver of its equations.
    """

    def __init__(self, mechanism: Mechanism, linear: Linear) -> None:
        self.mechanism, self.linear = mechanism, linear

    def __getstate__(self) -> dict[str, object]:
        """What another process needs; it composes its programs anew."""
        return {"mechanism": self.mechanism, "linear": self.linear}

    @cached_property
    def step(self) -> tuple[Program, Program]:
        """(state, parameters) to the step of each unknown, and for arrays the determinants of the blocks."""
        if not self.linear.compact:
            return self._composed(self.mechanism.newton, 0, signs=False)
        residual, jacobian, _ = self.mechanism.closing
        return self.mechanism.program([*self.linear.solve(jacobian, residual), *self.linear.determinants(jacobian)])

    @cached_property
    def pose(self) -> tuple[Program, Program]:
        """As `step`, with the velocity of each unknown per unit of each drive, drive by drive, in between."""
        count = len(self.mechanism.driven)
        if not self.linear.compact:
            return self._composed(self.mechanism.full, count, signs=True)
        residual, jacobian, drives = self.mechanism.closing
        follow: list[Scalar] = []
        for k in range(count):
            follow += [-1.0 * x for x in self.linear.solve(jacobian, drives[k::count])]
        step = self.linear.solve(jacobian, residual)
        return self.mechanism.program([*step, *follow, *self.linear.determinants(jacobian)])

    @cached_property
    def step_of_one(self) -> Program:
        """As `step` for floats, in the sums in which it is taken for arrays."""
        return self.step[0] if self.linear.compact else self._step_by_blocks

    def _step_by_blocks(self, state: Sequence[float], parameters: Sequence[float]) -> list[float]:
        m = self.linear.rows
        entries = self.mechanism.newton[0](state, parameters)
        return self.linear.solve_one(entries[m:], entries[:m])

    def _composed(self, programs: tuple[Program, Program], drives: int, *, signs: bool) -> tuple[Program, Program]:
        m, n = self.linear.rows, self.linear.columns

        def floats(state: Sequence[float], parameters: Sequence[float]) -> list[float]:
            entries = programs[0](state, parameters)
            behind = m + m * n
            jacobian = np.array(entries[m:behind]).reshape(m, n)
            right = np.empty((m, 1 + drives))
            right[:, 0] = entries[:m]
            right[:, 1:] = -np.array(entries[behind:]).reshape(m, drives)
            x = self.linear.solve_floats(jacobian, right)
            found: list[float] = x.T.ravel().tolist()
            return [*found, *self.linear.determinants_of_floats(jacobian)] if signs else found

        def arrays(state: Sequence[Value], parameters: Sequence[Value]) -> list[Value]:
            with np.errstate(all="ignore"):
                entries = programs[1](state, parameters)
                behind = m + m * n
                jacobian, right = entries[m:behind], [entries[:m]]
                right += [[-x for x in entries[behind + k :: drives]] for k in range(drives)]
                out = [x for side in self.linear.solve_all(jacobian, right) for x in side]
                return [*out, *self.linear.determinants(jacobian)]

        return floats, arrays
