"""Newton's method as a program, for batches of which writing it down takes less time than it saves.

It is run as machine code or, where compiling would take longer, by NumPy, a step at a time. The others are left to
`Newton`, which does the same with arrays. All say the same to rounding.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ..cache import KERNELS
from ..program import machine_code
from ..program.calculation import COMPILING, LEAST, MOST, TWICE, Calculation
from .elimination import LARGE, ConstrainedFactor, SymbolicFactorisation
from .equations import EquilibriumEquations
from .limits import NOTHING
from .model import Model
from .numbers import Where
from .planar_model import PlanarModel
from .protocols import FoundEquilibria
from .recorded_newton import NewtonRecording, RecordedNewton, State
from .recorded_numbers import GivenNumbers, PlanarNumbers, SpatialNumbers
from .state import DisplacedState

# What is compiled is kept on disk, and is likely to be run again: so often it may take to pay for itself.
_TIMES = 4
# The same where compiling takes fewer seconds than this, and where there is only the program to be written down.
_SHORT, _OFTEN = 0.3, 25
# Entries that NumPy works through at a time; seconds of a step for these, by entry, and until it is written down.
CHUNK = 2048
_CALL, _EACH, _WRITING = 6e-6, 4e-9, 50e-6


@dataclass(frozen=True)
class _Costs:
    """Seconds that arrays take for a step of the program alone and by entry; steps at least of a piece, of a loop."""

    alone: float
    each: float
    steps: int
    loop: int

    def pay_by_numpy(self, steps: int, count: int) -> bool:
        """Whether writing so many steps down takes less time than NumPy saves with them."""
        saved = self.alone + self.each * count - _CALL * math.ceil(count / CHUNK) - _EACH * count
        return 0 < steps <= MOST and _TIMES * saved > _WRITING

    def pay_compiled(self, steps: int, count: int) -> bool:
        """Whether compiling so many steps takes less time than it saves."""
        saved = steps * (self.alone + self.each * count)
        compiling = COMPILING * steps * (1.0 + steps / TWICE)
        # of loops there is much to write down that drops out, and nothing of that is kept
        times = _OFTEN if compiling < _SHORT and not self.loop else _TIMES
        return count >= LEAST and 0 < steps <= MOST and times * saved > compiling


_PLANE, _SPACE, _LOOPS = _Costs(4e-6, 12e-9, 400, 0), _Costs(3e-6, 15e-9, 3000, 0), _Costs(3e-6, 15e-9, 3000, 700)


class NewtonProgram:
    """The program of a model, with its numbers.

    Parameters
    ----------
    numbers
        Numbers of the model.
    recorded
        The program.
    compiled
        Whether it is run as machine code, or by NumPy.
    """

    def __init__(self, numbers: GivenNumbers, recorded: RecordedNewton, *, compiled: bool) -> None:
        self.numbers, self.recorded, self.compiled = numbers, recorded, compiled

    @classmethod
    def of(cls, model: Model | PlanarModel, elimination: SymbolicFactorisation, zero: float) -> NewtonProgram | None:
        """Newton's method for a model as a program; None where that is not possible or does not pay."""
        if not choice(model).recorded:
            return None
        space, costs, steps = _size(model)
        numbers = PlanarNumbers(model) if isinstance(model, PlanarModel) else SpatialNumbers(model)
        key = "large displacement", isinstance(model, PlanarModel), zero, _structure(model), numbers.key
        recorded: RecordedNewton = KERNELS.found(
            key, lambda: NewtonRecording(numbers, elimination, zero).recorded(), steps
        )
        found = _way(costs, recorded.program.weight, space.present)
        return cls(numbers, recorded, compiled=found.compiled) if found.recorded else None

    def solve(self, where: Where, state: State, factor: float, *, loose: bool) -> FoundEquilibria:
        """Equilibria at a share `factor` of the loads; stable where the last tangent was clearly definite.

        Where `loose`, the first tangent is made without the stresses of members at `state`.
        """
        recorded = self.recorded
        count = state.displacements.shape[-1]
        lengths = self.numbers.space.lengths.at(where)
        rows = [*self.numbers.values(where, factor), 1.0 / lengths]
        rows += [NOTHING * np.minimum(1.0, lengths), np.full(1, 0.0 if loose else 1.0)]
        rows += [number.of(state) for number in (*recorded.moved, *recorded.constant)]
        given = [rows[place] for place in recorded.places]
        work = Calculation(recorded.program, given, (count,), compiled=self.compiled)
        outs = work.places()
        chunk = count if self.compiled else math.ceil(count / math.ceil(count / CHUNK))
        with np.errstate(all="ignore"):
            for start in range(0, count, chunk):
                part = slice(start, min(start + chunk, count))
                work.run(0, part, [out[part] if len(out) == count else out for out in outs])
        outs = [np.broadcast_to(out, (count,)) for out in outs]
        found = FoundEquilibria.nothing(recorded.state(outs[:-3], state), copied=False)
        found.converged[:] = outs[-3]
        found.stable[:] = found.converged & outs[-2].astype(bool)
        found.iterations[:] = outs[-1]
        return found


@dataclass(frozen=True)
class NewtonChoice:
    """How Newton's method is done, and why, in words.

    Attributes
    ----------
    recorded
        Whether as a program, or with arrays.
    compiled
        Whether as machine code.
    """

    recorded: bool
    compiled: bool
    reason: str


def choice(model: Model | PlanarModel) -> NewtonChoice:
    """What promises to be fastest, by the frame and its batch alone."""
    space, costs, steps = _size(model)
    if not _suits(space):
        what = "own laws of joints, moments in space, and loads or strains of members"
        return NewtonChoice(False, False, f"by arrays, as all is where there are {what}")
    if not 0 < steps <= MOST or space.free > LARGE:
        return NewtonChoice(False, False, "by arrays; with so many pieces writing it down would take too long")
    way = _way(costs, steps, space.present)
    if way.recorded and not _independent(space):
        return NewtonChoice(False, False, "by arrays, as some ideal components of loops forbid what others forbid")
    return way


def _way(costs: _Costs, steps: int, count: int) -> NewtonChoice:
    """How so many steps are done for so many entries."""
    if not machine_code.available():
        why = "llvmlite (extra 'fast'), which would compile it, is not installed"
    elif not costs.pay_compiled(steps, count):
        why = "for so few entries compiling it would take longer"
    elif not machine_code.fused():
        why = "machine code takes a processor with fused operations for sines"
    else:
        return NewtonChoice(True, True, "as machine code, all iterations of an entry at once")
    if costs.pay_by_numpy(steps, count):
        return NewtonChoice(True, False, f"step by step by NumPy, {CHUNK} entries at a time; {why}")
    return NewtonChoice(False, False, f"by arrays; {why}")


def _size(model: Model | PlanarModel) -> tuple[Model, _Costs, int]:
    """The model in space, and how long its program is about."""
    if isinstance(model, PlanarModel):
        space, costs = model.model, _PLANE
    else:
        space, costs = model, _LOOPS if model.loops else _SPACE
    pieces = sum(len(stack.ends) for stack in space.stacks)
    return space, costs, costs.steps * pieces + costs.loop * len(space.loops)


def _suits(model: Model) -> bool:
    """Whether a model has nothing that is not written down: forces on nodes, members, joints of springs and contact."""
    plain = all(stack.work is None and stack.tension is None and stack.plain for stack in model.stacks)
    linked = not any(joint.own_law for joint in model.edges)
    return plain and linked and model.symmetric and not model.loads.offset_forces


def _independent(model: Model) -> bool:
    """Whether no ideal component of a loop forbids what others forbid, at rest, at the first entry."""
    constraints = int((model.multipliers >= 0).sum())
    if not constraints or model.free > LARGE:
        return not constraints
    absent = False if model.frame.absent is None else model.frame.absent
    entry = int(np.argmin(np.broadcast_to(absent, model.frame.shape).reshape(-1)))
    where = tuple(np.array([k]) for k in np.unravel_index(entry, model.frame.shape)) if model.frame.shape else ()
    values = EquilibriumEquations(model, where, 1).linearised(DisplacedState.start(model, 1)).values
    _, rows, columns = model.pattern
    whole = SymbolicFactorisation.of(rows, columns, model.free, constraints=constraints).dense(values)
    return not ConstrainedFactor(whole, constraints).zero.any()


def _structure(model: Model | PlanarModel) -> tuple[object, ...]:
    """All that the equations depend on beside numbers."""
    frame = model if isinstance(model, Model) else model.model
    joints = tuple(
        (j.parent, j.child, j.forward, j.edge.kind != "tie", j.movable.tobytes(), j.clearance_directions, j.rigid)
        for j in frame.edges
    )
    stacks = tuple((model.stacks[k].ends.tobytes(), linked.tobytes()) for k, linked in enumerate(model.linked))
    return (
        frame.count,
        frame.free,
        frame.size,
        frame.plain.tobytes(),
        frame.columns.tobytes(),
        model.columns.tobytes(),
        frame.multipliers.tobytes(),
        len(frame.loops),
        joints,
        stacks,
    )
