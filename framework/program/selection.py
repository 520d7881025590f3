"""Selection of the recorded steps that some results need, renumbered as a program."""

from __future__ import annotations

from collections.abc import Sequence
from typing import cast

from .program import NONE, Operation, Products, Program, ProgramStep, Rounds

# A recorded step: the operation and its operands.
Written = tuple[Operation, int, int, int]
# The origin of a value: a step; for an input its index, for a constant the float.
Made = Written | int | float


def selected(
    asked: list[int], made: Sequence[Made], masks: Sequence[int], products: Sequence[Products], rounds: Rounds | None
) -> tuple[Program, list[int]]:
    """The program that computes some values, and the indices of its inputs.

    Parameters
    ----------
    asked
        Numbers of the values.
    made, masks
        For each value its origin, and the mask of the batch axes over which it varies.
    products
        Matrix products among the steps.
    rounds
        The round of steps that is repeated; None for none.
    """
    given, constants, steps = _needed(asked, made, rounds)
    # The last item maps NONE, which is -1, to itself.
    new = [NONE] * (len(made) + 1)
    for number, old in enumerate([*given, *constants, *steps]):
        new[old] = number
    written = cast(Sequence[Written], made)
    program = Program(
        given=len(given),
        constants=tuple(cast(float, made[k]) for k in constants),
        steps=tuple(ProgramStep(o, new[a], new[b], new[c]) for o, a, b, c in map(written.__getitem__, steps)),
        masks=tuple(map(masks.__getitem__, [*given, *constants, *steps])),
        outputs=tuple(new[k] for k in asked),
        products=tuple(_products(products, made, new, len(given) + len(constants))),
        rounds=None if rounds is None else _rounds(rounds, new),
    )
    return program, [cast(int, made[k]) for k in given]


def _needed(asked: list[int], made: Sequence[Made], rounds: Rounds | None) -> tuple[list[int], list[int], list[int]]:
    """Numbers of the values that those asked for depend on: inputs, constants, and results of steps, each in order."""
    needed = bytearray(len(made) + 1)
    found: tuple[list[int], list[int], list[int]] = [], [], []
    for k in asked:
        needed[k] = 1
    if rounds is not None:
        for k in (rounds.again, *(after for _, after in rounds.carried)):
            needed[k] = 1
    for k in range(len(made) - 1, -1, -1):
        if not needed[k]:
            continue
        own = made[k]
        if isinstance(own, tuple):
            _, a, b, c = own
            needed[a] = needed[b] = needed[c] = 1
        found[0 if isinstance(own, int) else 1 if isinstance(own, float) else 2].append(k)
    for each in found:
        each.reverse()
    return found


def _rounds(rounds: Rounds, new: Sequence[int]) -> Rounds:
    carried = tuple((new[k], new[after]) for k, after in rounds.carried if new[k] != NONE)
    return Rounds(carried, new[rounds.again], rounds.most)


def _products(products: Sequence[Products], made: Sequence[Made], new: Sequence[int], first: int) -> list[Products]:
    """The matrix products that are needed; `first` is the number of the result of the first step."""
    out = []
    for each in products:
        kept = [new[k] - first for k in range(*each.steps) if new[k] != NONE and isinstance(made[k], tuple)]
        rows = [(new[k], row) for k, row in zip(each.outputs, each.factors, strict=True) if new[k] != NONE]
        if not rows:
            continue
        used = sorted({place for _, row in rows for place in row})
        places = {place: index for index, place in enumerate(used)}
        out.append(
            Products(
                (kept[0], kept[-1] + 1),
                tuple(k for k, _ in rows),
                tuple(_renumbered(each.numbers[place], new) for place in used),
                tuple({places[p]: _renumbered(v, new) for p, v in row.items()} for _, row in rows),
            )
        )
    return out


def _renumbered(number: int | float, new: Sequence[int]) -> int | float:
    return new[number] if isinstance(number, int) else number
