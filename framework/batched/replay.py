"""The elimination of a single batch entry, recorded once for all frames of a topology and replayed for the later ones.

With single numbers most of the time goes into finding which numbers to combine. One of the first frames of a topology
records the operations, and later ones run the list: the same operations in the same order, so that results are the same
to the last bit.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from ..cache import PROGRAMS
from ..program.program import Operation
from ..program.recording import Recording, Term
from ..structure.parts import Matrix, Parts, Row, Value, is_zero
from .entry_steps import Step, carried_out
from .order import Masks, Order, Springs
from .partial_factorisation import PartialFactorisation
from .stage import Forces, Stage, mapped_forces

# Largest number of operations for which a list is recorded, by its memory.
MOST = 20_000
# The list is recorded after this many eliminations of a topology, since recording takes as long as some twenty of them.
_FEW = 3


def operations(orders: tuple[Order, Order]) -> int:
    """Approximate number of operations of both stages of an elimination."""
    return sum(len(order.below[k]) * (len(order.below[k]) + 2) for order in orders for k in order.pivots)


class RecordedElimination:
    """The numbers of a component that enter its elimination, with the key by which the recorded list is found.

    Parameters
    ----------
    orders
        Elimination order of both stages.
    matrix, forces, scale, rows, springs
        As of a `Block` of one entry.
    """

    def __init__(
        self,
        orders: tuple[Order, Order],
        matrix: Matrix,
        forces: Forces,
        scale: dict[int, Parts],
        rows: dict[int, Row],
        springs: Springs,
    ) -> None:
        self.orders, self.matrix, self.forces, self.scale = orders, matrix, forces, scale
        self.rows, self.springs = rows, springs

    def carried_out(self, masks: Masks, rhs_parameters: list[Value]) -> PartialFactorisation:
        """Both stages, eliminated and loaded; by a recorded list from the fourth frame of a topology on.

        Parameters
        ----------
        masks
            Masks of substitution and springs, all zero.
        rhs_parameters
            Values of the right-hand-side parameters.
        """
        count = operations(self.orders)
        if count > MOST:
            return self.plainly(masks, rhs_parameters)
        recorded: _Recorded = PROGRAMS.found(self._key(), _Recorded, count + 100)
        return recorded.replayed(self, masks, rhs_parameters)

    def plainly(self, masks: Masks, rhs_parameters: list[Value]) -> PartialFactorisation:
        """Both stages, eliminated and loaded without a list."""
        stage = Stage(self.matrix, self.forces, self.scale)
        return PartialFactorisation.begun(self.orders, stage, self.rows, self.springs, rhs_parameters, masks, [True])

    def _key(self) -> tuple[object, ...]:
        """Key of the list: which entries exist, and which factors are 1 or -1."""
        return (
            tuple((i, tuple(row)) for i, row in self.matrix.items()),
            tuple(bool(parts) for row in self.matrix.values() for parts in row.values()),
            tuple((i, tuple(by_source)) for i, by_source in self.forces.items()),
            tuple(i for i, parts in self.scale.items() if parts),
            tuple((a, tuple(row), tuple(map(_unit, row.values()))) for a, row in self.rows.items()),
            tuple((tuple(row), tuple(map(_unit, row.values()))) for row, _ in self.springs),
            tuple((tuple(order.pivots), tuple(map(tuple, order.below.values()))) for order in self.orders),
        )

    def numbers(self) -> Iterator[Value]:
        """All numbers in order, except factors 1 and -1."""
        for i, row in self.matrix.items():
            for j, parts in row.items():
                if j >= i:
                    yield from parts.values()
        for by_source in self.forces.values():
            for parts in by_source.values():
                yield from parts.values()
        for parts in self.scale.values():
            yield from parts.values()
        for factors in self.rows.values():
            yield from (value for value in factors.values() if not _unit(value))
        for factors, stiffness in self.springs:
            yield from (value for value in factors.values() if not _unit(value))
            yield stiffness

    def mapped(self, change: Callable[[Value], Value]) -> RecordedElimination:
        """A copy with `change` applied to each of the `numbers`, in order."""
        matrix: Matrix = {i: {} for i in self.matrix}
        for i, row in self.matrix.items():
            for j, parts in row.items():
                if j >= i:
                    matrix[i][j] = matrix[j][i] = {mask: change(value) for mask, value in parts.items()}
        forces = mapped_forces(self.forces, change)
        scale = {i: {m: change(v) for m, v in parts.items()} for i, parts in self.scale.items()}
        rows = {a: _row(row, change) for a, row in self.rows.items()}
        springs = [(_row(row, change), change(stiffness)) for row, stiffness in self.springs]
        return RecordedElimination(self.orders, matrix, forces, scale, rows, springs)


class _Recorded:
    """A topology in the cache: how often it was eliminated, and its list of operations once there is one."""

    def __init__(self) -> None:
        self.met = 0
        self.made: tuple[list[Step], list[Value], PartialFactorisation] | None = None

    def replayed(self, given: RecordedElimination, masks: Masks, rhs_parameters: list[Value]) -> PartialFactorisation:
        """Both stages of a component: without a list the first few times, later by the list."""
        self.met += 1
        if self.met <= _FEW:
            return given.plainly(masks, rhs_parameters)
        if self.made is None:
            self.made = self._record(given, masks)
        steps, constants, template = self.made
        values = carried_out(steps, [*map(_scalar, given.numbers()), *constants])

        def number(value: Value) -> Value:
            return values[value.number] if isinstance(value, Term) else value

        inner, outer = (stage.mapped_steps(number) for stage in (template.inner, template.outer))
        imposed = mapped_forces(template.imposed, number)
        return replace(
            template,
            inner=inner,
            outer=outer,
            imposed=imposed,
            rows=given.rows,
            springs=given.springs,
            rhs_parameters=rhs_parameters,
        )

    def _record(self, given: RecordedElimination, masks: Masks) -> tuple[list[Step], list[Value], PartialFactorisation]:
        recording = Recording()
        terms = given.mapped(lambda value: recording.later(0))
        progress = terms.plainly(masks, [])
        progress.forget()
        found: list[Term] = []
        note = _noting(found)
        progress.inner.mapped_steps(note)
        progress.outer.mapped_steps(note)
        mapped_forces(progress.imposed, note)
        program, places = recording.program(found)
        # new numbering: given numbers in their order, then constants, then steps
        count = len(recording.given)
        old = dict(enumerate(places))
        old |= {k: count + k - program.given for k in range(program.given, len(program.masks))}
        own = [_scalar(value) for value in recording.given if value is not None]  # constants in formulas, such as 2.0
        constants = own + [np.float64(constant) for constant in program.constants]
        steps = [(_OPERATIONS[s.operation], old[s.a], old[s.b] if s.b >= 0 else old[s.a]) for s in program.steps]
        numbers = {term.number: old[new] for term, new in zip(found, program.outputs, strict=True)}

        def renumbered(value: Value) -> Value:
            return Term(recording, numbers[value.number]) if isinstance(value, Term) else value  # type: ignore[return-value]

        template = replace(
            progress,
            inner=progress.inner.mapped_steps(renumbered),
            outer=progress.outer.mapped_steps(renumbered),
            imposed=mapped_forces(progress.imposed, renumbered),
        )
        return steps, constants, template


def _noting(found: list[Term]) -> Callable[[Value], Value]:
    def note(value: Value) -> Value:
        if isinstance(value, Term):
            found.append(value)
        return value

    return note


def _row(row: Row, change: Callable[[Value], Value]) -> Row:
    return {k: value if _unit(value) else change(value) for k, value in row.items()}


def _unit(value: Value) -> float:
    """The value if it is 1.0 or -1.0, factors that need no multiplication; else 0.0."""
    return value if isinstance(value, float) and value in (1.0, -1.0) else 0.0


def _scalar(value: Value) -> Value:
    return np.float64(value) if isinstance(value, float) else value


def _divided(a: Any, b: Any) -> Any:
    """a / b; inf where b is exactly zero, as in `reciprocal`."""
    return np.inf if is_zero(b) else a / b


_OPERATIONS: dict[Operation, Callable[[Any, Any], Any]] = {
    Operation.ADD: operator.add,
    Operation.SUBTRACT: operator.sub,
    Operation.MULTIPLY: operator.mul,
    Operation.DIVIDE: _divided,
    Operation.NEGATE: lambda a, _: -a,
    Operation.MINIMUM: np.minimum,
    Operation.MAXIMUM: np.maximum,
}
