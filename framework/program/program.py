"""The flat list: numbered values, and the operations that make them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
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
    outs
        The sums.
    numbers
        What the factors multiply: the number of a value or, where it is a float, the number itself.
    factors
        By sum and place in `numbers`: the factor, likewise.
    """

    steps: tuple[int, int]
    outs: tuple[int, ...]
    numbers: tuple[int | float, ...]
    factors: tuple[Mapping[int, int | float], ...]


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
    """

    given: int
    constants: tuple[float, ...]
    steps: tuple[ProgramStep, ...]
    masks: tuple[int, ...]
    outputs: tuple[int, ...]
    products: tuple[Products, ...] = ()

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
