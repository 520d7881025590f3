"""Programs of the Newton step of the closing equations, with and without the derivatives by the drives."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property, partial
from typing import Any, cast

import numpy as np

from ....framework.program.source import Function, Functions
from .blocks import members_of, shape_of
from .elimination import Eliminated
from .formulas import Formulas
from .linear import Linear
from .mechanism import Mechanism
from .terms import Scalar, Value

# Least ratio of a pivot to its size in the pose from which the order was chosen, for the elimination to be accepted.
LEAST_PIVOT_RATIO = 1e-3


class Equations:
    """Programs of the Newton step.

    Equations in blocks of one or two are solved within the program, larger ones by a recorded elimination or by
    matrices.

    Parameters
    ----------
    mechanism
        The compiled linkage.
    linear
        Solver of its equations.
    """

    def __init__(self, mechanism: Mechanism, linear: Linear) -> None:
        self.mechanism, self.linear = mechanism, linear
        self._programs: dict[int, tuple[Functions, int]] = {}

    def __getstate__(self) -> dict[str, object]:
        """State for another process, without programs: they are made there again."""
        return {"mechanism": self.mechanism, "linear": self.linear, "_programs": {}}

    @cached_property
    def followers(self) -> list[tuple[int, int]]:
        """Of the unknowns that follow each drive, the number of the drive and their own: drive by drive.

        The other derivatives of unknowns by drives are zero at every pose, as between loops that do not meet.
        """
        mechanism = self.mechanism
        order, (places, columns) = {i: k for k, i in enumerate(mechanism.acting)}, mechanism.acting_places
        acts = np.zeros((len(mechanism.acting), len(mechanism.columns)), dtype=bool)
        acts[places, columns] = True
        sides = acts[[order[i] for i in mechanism.active]][:, mechanism.driven]
        drives, unknowns = np.nonzero(self.linear.reached(sides).T)
        return list(zip(drives.tolist(), unknowns.tolist(), strict=True))

    @cached_property
    def driven_together(self) -> list[tuple[int, int]]:
        """Numbers of two drives that some unknown follows both, the second at most the first; each goes with itself."""
        by_unknown: dict[int, list[int]] = {}
        for drive, unknown in self.followers:
            by_unknown.setdefault(unknown, []).append(drive)
        pairs = {(i, j) for drives in by_unknown.values() for i in drives for j in drives if j <= i}
        return sorted(pairs | {(k, k) for k in range(len(self.mechanism.driven))})

    @cached_property
    def step(self) -> tuple[Function, Function]:
        """(state, parameters) to the step of each unknown; for arrays, followed by the determinants of the blocks."""
        if self.linear.compact:
            return self.mechanism.program("step", self._step)
        return partial(self._of_floats, 0, determinants=False), self._of_arrays(self.mechanism.newton, 0)

    def _step(self, formulas: Formulas) -> list[Scalar]:
        residual, jacobian, _ = formulas.closing
        return [*self.linear.solve(jacobian, residual), *self.linear.determinants(jacobian)]

    @cached_property
    def pose(self) -> tuple[Function, Function]:
        """As `step`; between steps and determinants, the velocities of the `followers` per unit of their drives."""
        if self.linear.compact:
            return self.mechanism.program("closed pose", self._pose)
        drives = len(self.mechanism.driven)
        return partial(self._of_floats, drives), self._of_arrays(self.mechanism.full, drives)

    @cached_property
    def of_one(self) -> tuple[Function, Function, int]:
        """`step` and `pose` for the floats of one pose, and the number of `followers`."""
        return self.step[0], self.pose[0], len(self.followers)

    def _pose(self, formulas: Formulas) -> list[Scalar]:
        residual, jacobian, drives = formulas.closing
        count = len(formulas.driven)
        by_drives = [self.linear.solve(jacobian, drives[k::count]) for k in range(count)]
        step = self.linear.solve(jacobian, residual)
        follow = [-1.0 * by_drives[drive][unknown] for drive, unknown in self.followers]
        return [*step, *follow, *self.linear.determinants(jacobian)]

    def _following(self, solutions: Sequence[Sequence[Any]]) -> list[Any]:
        """The step, and where there are any, the velocities of the `followers` of those of all unknowns by drives."""
        step, *by_drives = solutions
        return [*step, *(by_drives[drive][unknown] for drive, unknown in self.followers if by_drives)]

    def written(self, drives: int) -> tuple[Functions, int] | None:
        """`step`, or `pose` with so many drives, as one program, and the number of pivots after its results.

        None if the equations need pivoting, or if there are none.
        """
        if not self.linear.columns:
            return None
        if self.linear.compact:
            return cast(Functions, self.pose if drives else self.step), 0
        return None if self.linear.order is None else self._eliminated(drives)

    def step_of_one(self, state: Sequence[float], parameters: Sequence[float]) -> list[float]:
        """As `step` for floats, with the determinants, and with the bits that arrays give."""
        if self.linear.compact:
            return list(self.step[0](state, parameters))
        return self._of_floats(0, state, parameters)

    # -- equations in blocks of more than two ------------------------------------------------------------------------

    def _of_floats(
        self, drives: int, state: Sequence[float], parameters: Sequence[float], *, determinants: bool = True
    ) -> list[float]:
        """What `_of_arrays` finds, for one pose, by the same operations; by matrices also without the determinants."""
        linear = self.linear
        if linear.order is not None:
            program, pivots = self._eliminated(drives)
            numbers = program[0](state, parameters)
            if all(abs(x * p) >= LEAST_PIVOT_RATIO for x, p in zip(self.shares, numbers[-pivots:], strict=True)):
                return list(numbers[:-pivots])
        m, behind = linear.rows, linear.rows * (1 + linear.columns)
        entries = (self.mechanism.full if drives else self.mechanism.newton)[0](state, parameters)
        rights = [entries[:m], *([-x for x in entries[behind + k :: drives]] for k in range(drives))]
        found = self._following(linear.solve_floats(entries[m:behind], rights))
        return [*found, *linear.determinants_of_floats(entries[m:behind])] if determinants else found

    def _of_arrays(self, programs: tuple[Function, Function], drives: int) -> Function:
        m, n = self.linear.rows, self.linear.columns

        def by_matrices(state: Sequence[Value], parameters: Sequence[Value]) -> list[Value]:
            entries = programs[1](state, parameters)
            behind = m + m * n
            jacobian, right = entries[m:behind], [entries[:m]]
            right += [[-x for x in entries[behind + k :: drives]] for k in range(drives)]
            out = self._following(self.linear.solve_all(jacobian, right))
            return [*out, *self.linear.determinants(jacobian)]

        def arrays(state: Sequence[Value], parameters: Sequence[Value]) -> list[Value]:
            with np.errstate(all="ignore"):
                if self.linear.order is None:
                    return by_matrices(state, parameters)
                program, pivots = self._eliminated(drives)
                numbers = program[1](state, parameters)
                found = list(numbers[:-pivots])
                return self._mended(found, numbers[-pivots:], by_matrices, state, parameters)

        return arrays

    def _eliminated(self, drives: int) -> tuple[Functions, int]:
        """The recorded elimination of `step`, or of `pose` with so many drives, pivots last; and their number."""
        if drives not in self._programs:
            pivots = self.linear.order.pivots
            key = "eliminated", drives, tuple(map(tuple, pivots))
            program = self.mechanism.program(key, lambda formulas: self._written(formulas, drives))
            self._programs[drives] = program, sum(map(len, pivots))
        return self._programs[drives]

    def _written(self, formulas: Formulas, drives: int) -> list[Scalar]:
        residual, jacobian, by_drives = formulas.closing
        rights = [residual, *([-1.0 * x for x in by_drives[k::drives]] for k in range(drives))]
        found = Eliminated(self.linear, self.linear.order, jacobian, rights)
        return [*self._following(found.solutions), *found.determinants, *found.pivots]

    @cached_property
    def shares(self) -> list[float]:
        """Inverse size of each pivot in the pose from which the order was chosen."""
        return [1.0 / size for sizes in self.linear.order.sizes for size in sizes]

    def _mended(
        self,
        found: list[Value],
        pivots: Sequence[Value],
        anew: Function,
        state: Sequence[Value],
        parameters: Sequence[Value],
    ) -> list[Value]:
        """Results of an elimination; where a pivot is too small, those of `anew`."""
        least = np.abs(self.shares[0] * pivots[0])
        for share, pivot in zip(self.shares[1:], pivots[1:], strict=True):
            # NaN counts as small
            least = np.minimum(least, np.abs(share * pivot))
        bad = ~(least >= LEAST_PIVOT_RATIO)
        if not np.any(bad):
            return found
        shape = shape_of(state, parameters)
        bad = np.broadcast_to(bad, shape)
        again = anew(members_of(state, bad), members_of(parameters, bad))
        out: list[Value] = []
        for old, new in zip(found, again, strict=True):
            whole = np.array(np.broadcast_to(old, shape))
            whole[bad] = new
            out.append(whole)
        return out
