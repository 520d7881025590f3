"""The flat list: numbered values, and the operations that make them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from enum import IntEnum
from functools import cached_property
from typing import NamedTuple


class Operation(IntEnum):
    """What a step does with its operands."""

    ADD = 1
    SUBTRACT = 2
    MULTIPLY = 3
    DIVIDE = 4
    NEGATE = 5
    MINIMUM = 6
    MAXIMUM = 7
    # c + a b, rounded once or twice: of sums that NumPy's matrix product takes.
    MULTIPLY_ADD = 8
    SINE = 9
    COSINE = 10
    SQUARE_ROOT = 11
    ABSOLUTE = 12
    # a < b, a <= b; what holds is combined by the next three, and chooses: b where a holds, c elsewhere.
    LESS = 13
    LESS_EQUAL = 14
    AND = 15
    OR = 16
    NOT = 17
    CHOOSE = 18
    # Of a table, which is the first operand: how many of its rising numbers, of which the last is inf, are not above
    # b; and the number at the place b.
    SEARCH = 19
    LOOK_UP = 20
    # The value with which a round begins: in the first one that of a.
    CARRY = 21
    # a b - c and c - a b, rounded once or twice.
    MULTIPLY_SUBTRACT = 22
    SUBTRACT_PRODUCT = 23


# Operations whose values are true or false.
CONDITIONS = frozenset({Operation.LESS, Operation.LESS_EQUAL, Operation.AND, Operation.OR, Operation.NOT})
# Operations whose first operand is a table.
TABLES = frozenset({Operation.SEARCH, Operation.LOOK_UP})
# How many steps of plain arithmetic take as long; those not named take one.
WEIGHTS = {Operation.SINE: 12, Operation.COSINE: 12, Operation.SEARCH: 20, Operation.LOOK_UP: 6}


# Where a step has fewer operands.
NONE = -1


class ProgramStep(NamedTuple):
    """An operation on the values of these numbers. The step makes the value whose number follows that of the last."""

    operation: Operation
    a: int
    b: int = NONE
    c: int = NONE

    @property
    def operands(self) -> tuple[int, ...]:
        """Numbers of the values that it needs."""
        return (self.a,) if self.b == NONE else (self.a, self.b) if self.c == NONE else (self.a, self.b, self.c)


@dataclass(frozen=True)
class Products:
    """Steps that make sums of products whose factors do not vary along the last axis: a matrix product.

    Attributes
    ----------
    steps
        Range of the steps, as indices.
    outputs
        The sums.
    numbers
        What the factors multiply: the number of a value or, where it is a float, the number itself.
    factors
        By sum and place in `numbers`: the factor, likewise.
    """

    steps: tuple[int, int]
    outputs: tuple[int, ...]
    numbers: tuple[int | float, ...]
    factors: tuple[Mapping[int, int | float], ...]


@dataclass(frozen=True)
class Rounds:
    """Steps that are done over and over, for as many batch entries at a time as may be: Newton's method.

    Attributes
    ----------
    carried
        Values with which a round begins, which `CARRY` makes, each with what it is after a round. All steps that need
        one of them are part of the round.
    again
        Another round is done while this holds for one of the entries. An entry for which it no longer holds must stay
        as it is in rounds that others need.
    most
        Number of rounds at most.
    """

    carried: tuple[tuple[int, int], ...]
    again: int
    most: int


@dataclass(frozen=True)
class Program:
    """Operations on numbered values: first what is given, then constants, then what each step makes.

    Attributes
    ----------
    given
        How many values are given.
    constants
        Those that are part of the program.
    steps
        What makes the others, in order.
    masks
        By value: the batch axes over which it varies, as bits.
    outputs
        Values asked for.
    products
        Steps that make up matrix products.
    rounds
        What is done over and over; None where every step is done once.
    """

    given: int
    constants: tuple[float, ...]
    steps: tuple[ProgramStep, ...]
    masks: tuple[int, ...]
    outputs: tuple[int, ...]
    products: tuple[Products, ...] = ()
    rounds: Rounds | None = None

    def __hash__(self) -> int:
        """That of all its parts, found once: long programs are asked for by what they are, again and again."""
        return self._hash

    def __reduce__(self) -> tuple[type[Program], tuple[object, ...]]:
        # Hashes of enumerations differ from process to process.
        return type(self), self._parts

    @property
    def _parts(self) -> tuple[object, ...]:
        return tuple(getattr(self, each.name) for each in fields(self))

    @cached_property
    def _hash(self) -> int:
        return hash(self._parts)

    @property
    def first(self) -> int:
        """Number of the value that the first step makes."""
        return self.given + len(self.constants)

    @cached_property
    def bare(self) -> Program:
        """The same steps, none of them known to be matrix products: what stands for it as a key."""
        return replace(self, products=())

    @cached_property
    def widest(self) -> int:
        """All axes over which anything varies."""
        varying = 0
        for mask in self.masks:
            varying |= mask
        return varying

    @cached_property
    def weight(self) -> int:
        """Steps, each as many times as steps of plain arithmetic take as long."""
        return len(self.steps) + sum(WEIGHTS[s.operation] - 1 for s in self.steps if s.operation in WEIGHTS)

    @cached_property
    def tables(self) -> frozenset[int]:
        """Given values that are tables."""
        return frozenset(step.a for step in self.steps if step.operation in TABLES)

    @cached_property
    def again(self) -> frozenset[int]:
        """Values that differ from round to round."""
        if self.rounds is None:
            return frozenset()
        found = {begins for begins, _ in self.rounds.carried}
        for k, step in enumerate(self.steps, self.first):
            if step.operation != Operation.CARRY and not found.isdisjoint(step.operands):
                found.add(k)
        needed = {self.rounds.again, *(after for _, after in self.rounds.carried)}
        for k in range(self.first + len(self.steps) - 1, self.first - 1, -1):
            if k in needed and k in found:
                needed.update(self.steps[k - self.first].operands)
        return frozenset(found & (needed | {begins for begins, _ in self.rounds.carried}))

    def over(self, masks: Sequence[int]) -> Program:
        """The same steps on given values that vary over other axes: of each its axes, as bits."""
        found = [*masks, *(0 for _ in self.constants)]
        widest = 0
        for mask in masks:
            widest |= mask
        for step in self.steps:
            own = widest if step.operation == Operation.CARRY else 0
            for k in step.operands:
                own |= found[k]
            found.append(own)
        return replace(self, masks=tuple(found))

    def holds(self, number: int) -> bool:
        """Whether a value is true or false."""
        if number < self.first:
            return False
        step = self.steps[number - self.first]
        if step.operation == Operation.CHOOSE:
            return self.holds(step.b)
        return self.holds(step.a) if step.operation == Operation.CARRY else step.operation in CONDITIONS

    def made(self, mask: int) -> list[int]:
        """Indices of the steps whose values vary over exactly these axes."""
        first = self.first
        return [k for k in range(len(self.steps)) if self.masks[first + k] == mask]

    def describe(self, sizes: Sequence[int]) -> str:
        """How many operations there are, by number of batch entries."""
        counts: dict[int, int] = {}
        for k in range(len(self.steps)):
            size = sizes[self.masks[self.first + k]]
            counts[size] = counts.get(size, 0) + 1
        return ", ".join(f"{count} for each of {size}" for size, count in sorted(counts.items()))
