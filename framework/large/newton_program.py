"""Newton's method as a program, for batches of which writing it down takes less time than it saves.

It is run as machine code or, where compiling would take longer, by NumPy, a step at a time. The others are left to
`Newton`, which does the same with arrays. All say the same to rounding.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..batch import Array
from ..cache import KERNELS
from ..program import machine_code
from ..program.calculation import COMPILING, LEAST, MOST, TWICE, Calculation
from ..program.recording import Recording
from .elimination import LARGE, ConstrainedFactor, SymbolicFactorisation
from .equations import EquilibriumEquations
from .model import Model
from .numbers import Numbers, Where
from .planar_equations import PlanarEquations
from .planar_model import PlanarModel
from .recorded_newton import NOTHING, NewtonRecording, RecordedNewton
from .state import DisplacedState, FoundEquilibria, StateOfEntries

# What is compiled is kept on disk, and is likely to be run again: so often it may take to pay for itself.
_TIMES = 4
# The same where compiling takes fewer seconds than this, and where there is only the program to be written down.
_SHORT, _OFTEN = 0.3, 25
# Entries that NumPy works through at a time; seconds of a step for these, by entry, and until it is written down.
CHUNK = 2048
_CALL, _EACH, _WRITING = 6e-6, 4e-9, 50e-6
# Numbers that stand in a program where a value is that for all entries; the one entry that is written down.
_PLAIN = (0.0, 1.0, -1.0)
_HERE = (np.zeros(1, dtype=np.int64),)


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

    def by_arrays(self, steps: int, count: int) -> float:
        """Estimated seconds of all entries with arrays."""
        return steps * (self.alone + self.each * count)

    def pay_compiled(self, steps: int, count: int) -> bool:
        """Whether compiling so many steps takes less time than it saves."""
        saved, compiling = self.by_arrays(steps, count), _compiling(steps)
        # of loops there is much to write down that drops out, and nothing of that is kept
        times = _OFTEN if compiling < _SHORT and not self.loop else _TIMES
        return count >= LEAST and 0 < steps <= MOST and times * saved > compiling


def _compiling(steps: int) -> float:
    """Estimated seconds of compiling so many steps."""
    return COMPILING * steps * (1.0 + steps / TWICE)


_PLANE, _SPACE, _LOOPS = _Costs(4e-6, 12e-9, 400, 0), _Costs(3e-6, 15e-9, 3000, 0), _Costs(3e-6, 15e-9, 3000, 700)


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
    way = _way(costs, steps, int(space.present.sum()))
    if way.recorded and not _independent(space):
        return NewtonChoice(False, False, "by arrays, as some ideal components of loops forbid what others forbid")
    return way


def _way(costs: _Costs, steps: int, count: int) -> NewtonChoice:
    """How so many steps are done for so many entries."""
    arrays = f"arrays take about {1e3 * costs.by_arrays(steps, count):.2g} ms"
    compiling = f"compiling about {steps} steps takes {1e3 * _compiling(steps):.2g} ms once"
    if not machine_code.available():
        why = "llvmlite (extra 'fast'), which would compile it, is not installed"
    elif not costs.pay_compiled(steps, count):
        why = f"for so few entries compiling it would take longer: {arrays}, {compiling}"
    elif not machine_code.fused():
        why = "machine code takes a processor with fused operations for sines"
    else:
        return NewtonChoice(True, True, f"as machine code, all iterations of an entry at once: {arrays}, {compiling}")
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
    """Whether the program covers what a model has: forces on nodes, plain members, springs and contact in joints."""
    return model.plain_members and model.symmetric and not any(joint.own_law for joint in model.edges)


def _independent(model: Model) -> bool:
    """Whether no ideal component of a loop forbids what others forbid, at rest, at the first entry."""
    if not model.constraints or model.free > LARGE:
        return not model.constraints
    where = model.where(np.array([int(np.argmax(model.present))]))
    values = EquilibriumEquations(model, where, 1).linearised(DisplacedState.start(model, 1)).values
    factor = SymbolicFactorisation.of_model(model).factor(values)
    return isinstance(factor, ConstrainedFactor) and not factor.zero.any()


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


# -- what the program takes, and the program --------------------------------------------------------------------------


@dataclass(frozen=True)
class ProgramInput:
    """Numbers of a model that a program takes.

    Attributes
    ----------
    numbers
        The numbers.
    places
        Which of the components, flattened, are given.
    plain
        By component what it is where it is 0, 1 or -1 for all entries; else None.
    loaded
        Whether they are multiplied by the share of the loads.
    """

    numbers: Numbers
    places: tuple[int, ...]
    plain: tuple[float | None, ...]
    loaded: bool

    @classmethod
    def of(cls, numbers: Numbers, *, loaded: bool = False) -> ProgramInput:
        """What of some numbers has to be given."""
        shape = _components(numbers)
        rows = numbers.array.reshape(int(np.prod(shape, dtype=np.int64)), -1)
        alike = (rows == rows[:, :1]).all(axis=1) & np.isin(rows[:, 0], _PLAIN[:1] if loaded else _PLAIN)
        plain = [float(x) if known else None for x, known in zip(rows[:, 0], alike, strict=True)]
        return cls(numbers, tuple(np.flatnonzero(~alike).tolist()), tuple(plain), loaded)

    @property
    def varies(self) -> bool:
        """Whether they vary over the batch."""
        return max(self.numbers.array.shape[len(_components(self.numbers)) :], default=1) > 1

    @property
    def key(self) -> tuple[object, ...]:
        """What the program depends on."""
        return _components(self.numbers), self.plain, self.varies

    def terms(self, recording: Recording) -> Numbers:
        """The numbers as terms of a recording, of one batch axis."""
        out = np.array(self.plain, dtype=object)
        for place in self.places:
            out[place] = recording.later(int(self.varies))
        return Numbers(out.reshape(*_components(self.numbers), 1), 1)

    def at(self, where: Where, factor: float) -> list[Array]:
        """The given values at some entries, (m,) or (1,) each."""
        if not self.places:
            return []
        found = self.numbers.at(where)
        rows = found.reshape(-1, found.shape[-1])[list(self.places)]
        return list(factor * rows if self.loaded else rows)


def _components(numbers: Numbers) -> tuple[int, ...]:
    return numbers.array.shape[: numbers.array.ndim - numbers.ndim]


class GivenNumbers:
    """What a program takes of a model, in the order in which it takes it.

    Parameters
    ----------
    model
        The model, without loads between nodes.

    Attributes
    ----------
    space
        The model as one in space.
    """

    def __init__(self, model: Model | PlanarModel) -> None:
        self.model = model
        stacks: tuple[str, ...]
        if isinstance(model, PlanarModel):
            self.space, loads, stacks = model.model, model.loads, ("direction", "length", "stiffness")
            self.joints = [_named(each, ("axes", "sense", "arm", "stiffness", "offset")) for each in model.joints]
            self.joints += [_named(each.joint, ("stiffness", "clearance")) for each in model.joints]
        else:
            self.space, loads, stacks = model, model.loads.nodal, ("local_axes", "length", "stiffness", "bow")
            names = ("axes", "arm", "stiffness", "lead", "offset", "clearance")
            self.joints = [_named(each, names) for each in model.edges]
        self.loads = ProgramInput.of(loads, loaded=True)
        self.stacks = [_named(stack, stacks) for stack in model.stacks]
        space = self.space
        self.prescribed = [ProgramInput.of(space.prescribed_values[key], loaded=True) for key in space.prescribed]

    @property
    def all(self) -> list[ProgramInput]:
        """All of them, in order."""
        parts = [each for part in (*self.stacks, *self.joints) for each in part.values()]
        return [self.loads, *parts, *self.prescribed]

    @property
    def key(self) -> tuple[object, ...]:
        """What the program depends on beside the model's structure."""
        return tuple(each.key for each in self.all)

    def values(self, where: Where, factor: float) -> list[Array]:
        """What is given at some entries."""
        return [row for each in self.all for row in each.at(where, factor)]

    def equations(self, recording: Recording) -> PlanarEquations | EquilibriumEquations:
        """The equations of one entry, of which the numbers are terms."""
        loads, stacks, joints = (
            self.loads.terms(recording),
            _terms(self.stacks, recording),
            _terms(self.joints, recording),
        )
        out = (
            _planar(self.model, loads, stacks, joints)
            if isinstance(self.model, PlanarModel)
            else _spatial(self.model, loads, stacks, joints)
        )
        values = [each.terms(recording).array.reshape(1, 1) for each in self.prescribed]
        out.prescribed_values = np.concatenate([np.zeros((0, 1), dtype=object), *values])
        return out


def _planar(
    given: PlanarModel, loads: Numbers, stacks: list[dict[str, Any]], joints: list[dict[str, Any]]
) -> PlanarEquations:
    model = copy(given)
    model.loads = loads
    model.stacks = [replace(stack, **terms) for stack, terms in zip(model.stacks, stacks, strict=True)]
    count = len(model.joints)
    model.joints = [
        replace(joint, joint=replace(joint.joint, **inside), **terms)
        for joint, terms, inside in zip(model.joints, joints[:count], joints[count:], strict=True)
    ]
    return PlanarEquations(model, _HERE, 1)


def _spatial(
    given: Model, loads: Numbers, stacks: list[dict[str, Any]], joints: list[dict[str, Any]]
) -> EquilibriumEquations:
    model = copy(given)
    model.loads = replace(model.loads, nodal=loads)
    model.stacks = [replace(stack, **terms) for stack, terms in zip(model.stacks, stacks, strict=True)]
    model.edges = [replace(joint, **terms) for joint, terms in zip(model.edges, joints, strict=True)]
    count = len(model.joints)
    model.joints, model.loops = model.edges[:count], model.edges[count:]
    out = EquilibriumEquations(model, _HERE, 1)
    out.symmetric = True
    return out


def _named(part: object, names: Sequence[str]) -> dict[str, ProgramInput]:
    found = {name: getattr(part, name) for name in names}
    return {name: ProgramInput.of(each, loaded=name == "offset") for name, each in found.items() if each is not None}


def _terms(parts: list[dict[str, ProgramInput]], recording: Recording) -> list[dict[str, Any]]:
    return [{name: each.terms(recording) for name, each in part.items()} for part in parts]


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
    def of(cls, model: Model | PlanarModel, elimination: SymbolicFactorisation) -> NewtonProgram | None:
        """Newton's method for a model as a program; None where that is not possible or does not pay."""
        if not choice(model).recorded:
            return None
        space, costs, steps = _size(model)
        numbers = GivenNumbers(model)

        def make() -> RecordedNewton:
            recording = Recording(fixed=True, signless=True)
            return NewtonRecording(recording, numbers.equations(recording), elimination).recorded()

        key = "large displacement", isinstance(model, PlanarModel), elimination.free, _structure(model), numbers.key
        recorded: RecordedNewton = KERNELS.found(key, make, steps)
        found = _way(costs, recorded.program.weight, int(space.present.sum()))
        return cls(numbers, recorded, compiled=found.compiled) if found.recorded else None

    def solve(self, where: Where, state: StateOfEntries, factor: float, *, unstressed: bool) -> FoundEquilibria:
        """Equilibria at a share `factor` of the loads; stable where the last tangent was clearly definite.

        Where `unstressed`, the first tangent leaves out the stresses of the members at `state`.
        """
        recorded = self.recorded
        count = state.displacements.shape[-1]
        lengths = self.numbers.space.lengths.at(where)
        rows = [*self.numbers.values(where, factor), 1.0 / lengths]
        rows += [NOTHING * np.minimum(1.0, lengths), np.full(1, 0.0 if unstressed else 1.0)]
        numbers = state.flat()
        rows += [numbers[place] for place in recorded.given]
        given = [rows[place] for place in recorded.places]
        work = Calculation(recorded.program, given, (count,), compiled=self.compiled)
        outs = work.places()
        chunk = count if self.compiled else math.ceil(count / math.ceil(count / CHUNK))
        with np.errstate(all="ignore"):
            for start in range(0, count, chunk):
                part = slice(start, min(start + chunk, count))
                work.run(0, part, [out[part] if len(out) == count else out for out in outs])
        outs = [np.broadcast_to(out, (count,)) for out in outs]
        for place, out in zip(recorded.made, outs, strict=False):
            numbers[place] = out
        found = FoundEquilibria.nothing(state.like(numbers), copied=False)
        found.converged[:] = outs[-3]
        found.stable[:] = found.converged & outs[-2].astype(bool)
        found.iterations[:] = outs[-1]
        return found
