"""A program: numbered values, and the flat list of operations that compute them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from enum import IntEnum
from functools import cached_property
from typing import NamedTuple


class Operation(IntEnum):
    """The operation of a step on its operands a, b and c."""

    ADD = 1
    SUBTRACT = 2
    MULTIPLY = 3
    DIVIDE = 4
    NEGATE = 5
    MINIMUM = 6
    MAXIMUM = 7
    # c + a b, rounded once or twice, in sums that NumPy computes as a matrix product.
    MULTIPLY_ADD = 8
    SINE = 9
    COSINE = 10
    SQUARE_ROOT = 11
    ABSOLUTE = 12
    # Conditions a < b and a <= b, which the next three combine; CHOOSE gives b where the condition a holds, else c.
    LESS = 13
    LESS_EQUAL = 14
    AND = 15
    OR = 16
    NOT = 17
    CHOOSE = 18
    # In a table a of ascending numbers that ends with inf: how many are not above b; and the number at index b.
    SEARCH = 19
    LOOK_UP = 20
    # The value with which a round begins; in the first round it is a.
    CARRY = 21
    # a b - c and c - a b, rounded once or twice.
    MULTIPLY_SUBTRACT = 22
    SUBTRACT_PRODUCT = 23
    # Conversion to extended precision, in programs whose steps have either precision.
    WIDEN = 24


# Operations whose results NumPy and machine code may round differently.
_ROUNDED = frozenset({
    Operation.SINE,
    Operation.COSINE,
    Operation.MULTIPLY_ADD,
    Operation.MULTIPLY_SUBTRACT,
    Operation.SUBTRACT_PRODUCT,
})  # fmt: skip
# Operations whose values are true or false.
CONDITIONS = frozenset({Operation.LESS, Operation.LESS_EQUAL, Operation.AND, Operation.OR, Operation.NOT})
# Operations whose first operand is a table.
TABLES = frozenset({Operation.SEARCH, Operation.LOOK_UP})
# Time of some operations in units of plain arithmetic; that of the others is one.
WEIGHTS = {Operation.SINE: 12, Operation.COSINE: 12, Operation.SEARCH: 20, Operation.LOOK_UP: 6}


# Number of an operand that is missing.
NONE = -1


class ProgramStep(NamedTuple):
    """An operation on the values of given numbers; its result gets the number after that of the previous step."""

    operation: Operation
    a: int
    b: int = NONE
    c: int = NONE

    @property
    def operands(self) -> tuple[int, ...]:
        """Numbers of the operands."""
        return (self.a,) if self.b == NONE else (self.a, self.b) if self.c == NONE else (self.a, self.b, self.c)


@dataclass(frozen=True)
class Products:
    """Steps that compute linear combinations whose factors do not vary along the last axis: a matrix product.

    Attributes
    ----------
    steps
        Range of the steps, as indices.
    outputs
        Numbers of the values that are the combinations.
    numbers
        What the factors multiply: numbers of values, or constants as floats.
    factors
        For each combination, by index into `numbers`, its factors: numbers of values, or constants as floats.
    """

    steps: tuple[int, int]
    outputs: tuple[int, ...]
    numbers: tuple[int | float, ...]
    factors: tuple[Mapping[int, int | float], ...]


@dataclass(frozen=True)
class Rounds:
    """Steps that are repeated until all batch entries are done, as in Newton's method.

    Attributes
    ----------
    carried
        Pairs of the value with which a round begins, a `CARRY`, and the value that it has after the round. All steps
        that depend on one of the former belong to the round.
    again
        Number of the condition for another round, which is done while it holds for any entry. An entry for which it no
        longer holds must not change in further rounds.
    most
        Largest number of rounds.
    """

    carried: tuple[tuple[int, int], ...]
    again: int
    most: int


@dataclass(frozen=True)
class Program:
    """Operations on numbered values: first the inputs, then constants, then the result of each step.

    Attributes
    ----------
    given
        Number of inputs.
    constants
        Constants of the program.
    steps
        The operations, in order.
    masks
        For each value the mask of the batch axes over which it varies.
    outputs
        Numbers of the values that are the results.
    products
        Groups of steps that are matrix products.
    rounds
        Steps that are repeated; None if every step is done once.
    """

    given: int
    constants: tuple[float, ...]
    steps: tuple[ProgramStep, ...]
    masks: tuple[int, ...]
    outputs: tuple[int, ...]
    products: tuple[Products, ...] = ()
    rounds: Rounds | None = None

    def __hash__(self) -> int:
        """Hash of all fields, computed once, as long programs are looked up often."""
        return self._hash

    def __reduce__(self) -> tuple[type[Program], tuple[object, ...]]:
        # The hash must not be pickled: hashes of enumerations differ between processes.
        return type(self), self._parts

    @property
    def _parts(self) -> tuple[object, ...]:
        return tuple(getattr(self, each.name) for each in fields(self))

    @cached_property
    def _hash(self) -> int:
        return hash(self._parts)

    @property
    def first(self) -> int:
        """Number of the result of the first step."""
        return self.given + len(self.constants)

    @cached_property
    def bare(self) -> Program:
        """The program without the information on matrix products, for use as a key."""
        return replace(self, products=())

    @cached_property
    def widest(self) -> int:
        """Mask of all axes over which any value varies."""
        varying = 0
        for mask in self.masks:
            varying |= mask
        return varying

    @cached_property
    def exact(self) -> bool:
        """Whether results are the same to the last bit whatever runs the program, as each step is rounded once."""
        return not self.products and not {step.operation for step in self.steps} & _ROUNDED

    @cached_property
    def weight(self) -> int:
        """Time of all steps in units of plain arithmetic."""
        return len(self.steps) + sum(WEIGHTS[s.operation] - 1 for s in self.steps if s.operation in WEIGHTS)

    @cached_property
    def tables(self) -> frozenset[int]:
        """Numbers of the inputs that are tables."""
        return frozenset(step.a for step in self.steps if step.operation in TABLES)

    @cached_property
    def again(self) -> frozenset[int]:
        """Numbers of the values that change from round to round."""
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
        """The same steps for inputs that vary over other axes, given by their masks."""
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
        """Whether a value is a condition, true or false."""
        if number < self.first:
            return False
        step = self.steps[number - self.first]
        if step.operation == Operation.CHOOSE:
            return self.holds(step.b)
        return self.holds(step.a) if step.operation == Operation.CARRY else step.operation in CONDITIONS

    def made(self, mask: int) -> list[int]:
        """Indices of the steps whose results have exactly this mask."""
        first = self.first
        return [k for k in range(len(self.steps)) if self.masks[first + k] == mask]

    def describe(self, sizes: Sequence[int]) -> str:
        """Number of operations for each number of batch entries, in words."""
        counts: dict[int, int] = {}
        for k in range(len(self.steps)):
            size = sizes[self.masks[self.first + k]]
            counts[size] = counts.get(size, 0) + 1
        return ", ".join(f"{count} for each of {size}" for size, count in sorted(counts.items()))
