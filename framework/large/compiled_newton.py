"""Newton's method as machine code, for all entries of a long batch that it finds a stable equilibrium of.

The others, and batches for which compiling would take longer than it saves, are left to `Newton`, which does the same
with arrays. Both say the same to rounding.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ..cache import KERNELS
from ..program import machine_code
from ..program.calculation import COMPILING, LEAST, MOST, TWICE, Calculation
from .elimination import LARGE, SymbolicFactorisation
from .limits import NOTHING
from .model import Model
from .numbers import Where
from .planar_model import PlanarModel
from .protocols import FoundEquilibria
from .recorded_newton import NewtonRecording, RecordedNewton, State
from .recorded_numbers import GivenNumbers, PlanarNumbers, SpatialNumbers

# What is compiled is kept on disk, and is likely to be run again: so often it may take to pay for itself.
_TIMES = 4
# The same where compiling takes fewer seconds than this.
_SHORT, _OFTEN = 0.3, 25


@dataclass(frozen=True)
class _Costs:
    """Seconds that arrays take for a step of the program alone and by entry; steps that a piece has at least."""

    alone: float
    each: float
    steps: int

    def pay(self, steps: int, count: int) -> bool:
        """Whether compiling so many steps takes less time than it saves."""
        saved = steps * (self.alone + self.each * count)
        compiling = COMPILING * steps * (1.0 + steps / TWICE)
        return count >= LEAST and (_OFTEN if compiling < _SHORT else _TIMES) * saved > compiling


_PLANE, _SPACE = _Costs(2e-6, 4e-9, 600), _Costs(2e-6, 9e-9, 6000)


class CompiledNewton:
    """The program of a model, with its numbers.

    Parameters
    ----------
    numbers
        Numbers of the model.
    recorded
        The program.
    size
        Length that displacements are compared with.
    """

    def __init__(self, numbers: GivenNumbers, recorded: RecordedNewton, size: float) -> None:
        self.numbers, self.recorded, self.size = numbers, recorded, size

    @classmethod
    def of(
        cls, model: Model | PlanarModel, elimination: SymbolicFactorisation, zero: float, size: float
    ) -> CompiledNewton | None:
        """Newton's method for a model as machine code; None where that is not possible or does not pay."""
        planar = isinstance(model, PlanarModel)
        space, costs = (model.model, _PLANE) if isinstance(model, PlanarModel) else (model, _SPACE)
        count, pieces = math.prod(space.frame.shape), sum(len(stack.ends) for stack in model.stacks)
        steps = costs.steps * pieces
        if not (machine_code.available() and 0 < steps <= MOST and costs.pay(steps, count)):
            return None
        if not (machine_code.fused() and 0 < space.free <= LARGE and _suits(space)):
            return None
        numbers = PlanarNumbers(model) if isinstance(model, PlanarModel) else SpatialNumbers(model)
        key = "large displacement", planar, zero, _structure(model), numbers.key
        recorded: RecordedNewton = KERNELS.found(
            key, lambda: NewtonRecording(numbers, elimination, zero).recorded(), steps
        )
        steps = recorded.program.weight
        return cls(numbers, recorded, size) if steps <= MOST and costs.pay(steps, count) else None

    def solve(self, where: Where, state: State, factor: float) -> FoundEquilibria:
        """Stable equilibria at a share `factor` of the loads; not converged where none was found."""
        recorded = self.recorded
        count = state.displacements.shape[-1]
        rows = [*self.numbers.values(where, factor), np.full(1, 1.0 / self.size)]
        rows += [np.full(1, NOTHING * min(1.0, self.size)), *(number.of(state) for number in recorded.moved)]
        work = Calculation(recorded.program, [rows[place] for place in recorded.places], (count,), compiled=True)
        with np.errstate(all="ignore"):
            outs = [np.broadcast_to(out, (count,)) for out in work.results()]
        found = FoundEquilibria.nothing(recorded.state(outs[:-2], state), copied=False)
        found.converged[:] = found.stable[:] = outs[-2]
        found.iterations[:] = outs[-1]
        return found


def _suits(model: Model) -> bool:
    """Whether a model has nothing that is not written down: forces on nodes, members and joints of springs alone."""
    plain = all(stack.work is None and stack.tension is None and stack.plain for stack in model.stacks)
    linked = not model.loops and all(joint.law is None for joint in model.joints)
    return plain and linked and model.symmetric and not model.loads.offset_forces


def _structure(model: Model | PlanarModel) -> tuple[object, ...]:
    """All that the equations depend on beside numbers."""
    frame = model if isinstance(model, Model) else model.model
    joints = tuple((j.parent, j.child, j.forward, j.edge.kind != "tie", j.movable.tobytes()) for j in frame.joints)
    stacks = tuple((model.stacks[k].ends.tobytes(), linked.tobytes()) for k, linked in enumerate(model.linked))
    return (
        frame.count,
        frame.free,
        frame.size,
        frame.plain.tobytes(),
        frame.columns.tobytes(),
        model.columns.tobytes(),
        joints,
        stacks,
    )
