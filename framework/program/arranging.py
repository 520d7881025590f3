"""Rearrangement of a program for machine code: fewer divisions, fused products and sums, and a better order of steps.

A division takes as long as ten products; a product and a sum are one fused operation, rounded once. In a long program
most values wait in memory for their use; the fewer there are at a time, the more stay in registers.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace

from .program import NONE, Operation, Program, ProgramStep, Rounds

# For a sum or difference, the fused operations that replace it if its first, or its second, operand is a product.
_WITH_PRODUCT = {
    Operation.ADD: (Operation.MULTIPLY_ADD, Operation.MULTIPLY_ADD),
    Operation.SUBTRACT: (Operation.MULTIPLY_SUBTRACT, Operation.SUBTRACT_PRODUCT),
}


def arranged(program: Program) -> Program:
    """An equivalent program, to rounding, that takes less time; `program` must have no matrix products."""
    return in_order_of_need(_with_products(_with_inverses(program)))


def _with_inverses(program: Program) -> Program:
    """Several divisions by the same number are replaced by products with its inverse."""
    first, made, masks = program.first, list(program.steps), list(program.masks)
    times = Counter(step.b for step in made if step.operation == Operation.DIVIDE)
    shared = sorted(k for k, count in times.items() if count > 1)
    constants = dict(zip(program.constants, range(program.given, first), strict=True))
    if not shared or 1.0 not in constants:
        return program
    one = constants[1.0]
    # Inverses are appended at the end; the steps are ordered later.
    inverses = {k: first + len(made) + place for place, k in enumerate(shared)}
    for at, step in enumerate(program.steps):
        if step.operation == Operation.DIVIDE and step.b in inverses:
            made[at] = ProgramStep(Operation.MULTIPLY, step.a, inverses[step.b])
    made += [ProgramStep(Operation.DIVIDE, one, k) for k in shared]
    masks += [masks[k] for k in shared]
    return in_order_of_need(replace(program, steps=tuple(made), masks=tuple(masks)))


def _with_products(program: Program) -> Program:
    """Sums are fused with a product among their operands if nothing else needs that product."""
    first, masks, again = program.first, program.masks, program.again
    uses = Counter(k for step in program.steps for k in step.operands)
    uses.update(_asked(program))
    steps = list(program.steps)
    for at, step in enumerate(program.steps):
        if step.operation not in _WITH_PRODUCT:
            continue
        number = first + at
        for place, k in reversed(list(enumerate(step.operands))):
            alone = k >= first and uses[k] == 1 and program.steps[k - first].operation == Operation.MULTIPLY
            if alone and masks[k] == masks[number] and (k in again) == (number in again):
                product, other = program.steps[k - first], step.operands[1 - place]
                steps[at] = ProgramStep(_WITH_PRODUCT[step.operation][place], product.a, product.b, other)
                break
    return replace(program, steps=tuple(steps))


def in_order_of_need(program: Program) -> Program:
    """The same steps, each as late as possible before the first one that needs it; unneeded steps are dropped."""
    first = program.first
    found, order = [False] * (first + len(program.steps)), []
    for goal in _asked(program):
        waiting = [goal]
        while waiting:
            k = waiting[-1]
            missing = [] if k < first or found[k] else [x for x in program.steps[k - first].operands if not found[x]]
            missing = [x for x in missing if x >= first]
            if missing:
                waiting.append(missing[0])
                continue
            waiting.pop()
            if k >= first and not found[k]:
                found[k] = True
                order.append(k)
    return _renumbered(program, order)


def _asked(program: Program) -> list[int]:
    """Numbers of the values that results or further rounds need."""
    rounds = program.rounds
    if rounds is None:
        return list(program.outputs)
    carried = [*(begins for begins, _ in rounds.carried), rounds.again, *(after for _, after in rounds.carried)]
    return [*carried, *program.outputs]


def _renumbered(program: Program, order: Sequence[int]) -> Program:
    """The program with only the steps that make the given values, in the given order."""
    first, rounds = program.first, program.rounds
    # The last item maps NONE, which is -1, to itself.
    new = [*range(first), *(NONE,) * (len(program.steps) + 1)]
    for number, k in enumerate(order, first):
        new[k] = number
    steps = [program.steps[k - first] for k in order]
    if rounds is not None:
        carried = tuple((new[begins], new[after]) for begins, after in rounds.carried)
        rounds = Rounds(carried, new[rounds.again], rounds.most)
    return replace(
        program,
        steps=tuple(ProgramStep(step.operation, new[step.a], new[step.b], new[step.c]) for step in steps),
        masks=(*program.masks[:first], *(program.masks[k] for k in order)),
        outputs=tuple(new[k] for k in program.outputs),
        rounds=rounds,
    )
