"""Newton's method as machine code, for all entries of a long batch that it finds a stable equilibrium of.

The others, and batches for which compiling would take longer than it saves, are left to `Newton`, which does the same
with arrays. Both say the same to rounding.
"""

from __future__ import annotations

import math

import numpy as np

from ..cache import KERNELS
from ..program import machine_code
from ..program.calculation import COMPILING, MOST, TWICE, Calculation
from .elimination import LARGE, SymbolicFactorisation
from .limits import NOTHING
from .numbers import Where
from .planar_model import PlanarModel
from .planar_state import PlanarState
from .protocols import FoundEquilibria
from .recorded_newton import PlanarNumbers, RecordedNewton

# Seconds, as order of magnitude, that arrays take: for each entry and step of the program, and for each step alone.
_EACH, _CALL = 4e-9, 2e-6
# Pieces and unknowns up to which a program may have a length that is compiled.
_PIECES = 64
# What is compiled is kept on disk, and is likely to be run again: so often it may take to pay for itself.
_TIMES = 4


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

    def __init__(self, numbers: PlanarNumbers, recorded: RecordedNewton, size: float) -> None:
        self.numbers, self.recorded, self.size = numbers, recorded, size

    @classmethod
    def of(
        cls, model: PlanarModel, elimination: SymbolicFactorisation, zero: float, size: float
    ) -> CompiledNewton | None:
        """Newton's method for a model as machine code; None where that is not possible or does not pay."""
        frame = model.model
        count = math.prod(frame.frame.shape)
        pieces = sum(len(stack.ends) for stack in model.stacks)
        able = machine_code.available() and machine_code.fused() and pieces <= _PIECES and 0 < frame.free <= LARGE
        if not able or not _pays(_LEAST_STEPS * pieces, count) or any(j.joint.law is not None for j in model.joints):
            return None
        numbers = PlanarNumbers(model)
        key = "large displacement", zero, _structure(model), numbers.key
        recorded: RecordedNewton = KERNELS.found(key, lambda: RecordedNewton(numbers, elimination, zero), 1000 * pieces)
        steps = recorded.program.weight
        return cls(numbers, recorded, size) if steps <= MOST and _pays(steps, count) else None

    def solve(self, where: Where, state: PlanarState, factor: float) -> FoundEquilibria:
        """Stable equilibria at a share `factor` of the loads; not converged where none was found."""
        recorded = self.recorded
        count = state.rotations.shape[-1]
        rows = [*self.numbers.values(where, factor), *self._limits()]
        rows += [coordinate.of(state) for coordinate in recorded.coordinates]
        given = [rows[place] for place in recorded.places]
        work = Calculation(
            recorded.program, [x if x.size > 1 or count == 1 else x.item() for x in given], (count,), compiled=True
        )
        with np.errstate(all="ignore"):
            outs = [np.broadcast_to(out, (count,)) for out in work.results()]
        found = FoundEquilibria.nothing(state)
        found.state = recorded.state(outs[:-2], state)
        found.converged[:] = found.stable[:] = outs[-2]
        found.iterations[:] = outs[-1]
        return found

    def _limits(self) -> list[np.ndarray]:
        return [np.full(1, 1.0 / self.size), np.full(1, NOTHING * min(1.0, self.size))]


# Steps that a piece takes at least.
_LEAST_STEPS = 300


def _pays(steps: int, count: int) -> bool:
    """Whether compiling so many steps takes less time than it saves."""
    saved = steps * (_CALL + _EACH * count)
    return _TIMES * saved > COMPILING * steps * (1.0 + steps / TWICE)


def _structure(model: PlanarModel) -> tuple[object, ...]:
    """All that the equations depend on beside numbers."""
    frame = model.model
    joints = tuple((j.joint.parent, j.joint.child, j.joint.forward, j.joint.edge.kind != "tie") for j in model.joints)
    stacks = tuple((s.ends.tobytes(), k.tobytes()) for s, k in zip(model.stacks, model.linked, strict=True))
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
