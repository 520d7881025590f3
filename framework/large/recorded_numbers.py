"""The numbers of a model that a recorded program takes, and the equations of one entry in which they are terms."""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..batch import Array
from ..program.recording import Recording
from .equations import EquilibriumEquations
from .model import Model
from .numbers import Numbers, Where
from .planar import PlanarEquations
from .planar_model import PlanarModel

# Numbers that stand in a program where a value is that for all entries.
_PLAIN = (0.0, 1.0, -1.0)
_HERE = (np.zeros(1, dtype=np.int64),)


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
        The model.
    stacks
        Names of the numbers of each stack of pieces.
    joints
        Numbers of links and loops, by name.

    Attributes
    ----------
    space
        The model as one in space.
    columns
        Number of each coordinate of the nodes, (3, nodes) or (6, nodes).
    """

    def __init__(
        self, model: Model | PlanarModel, stacks: Sequence[str], joints: list[dict[str, ProgramInput]]
    ) -> None:
        space = model if isinstance(model, Model) else model.model
        self.space, self.columns = space, model.columns
        self.loads = ProgramInput.of(space.loads.nodal if isinstance(model, Model) else model.loads, loaded=True)
        self.stacks = [_named(stack, stacks) for stack in model.stacks]
        self.joints = joints
        self.prescribed = [ProgramInput.of(space.prescribed_values[key], loaded=True) for key in space.prescribed]

    @property
    def all(self) -> list[ProgramInput]:
        """All of them, in order."""
        return [
            self.loads,
            *(each for part in (*self.stacks, *self.joints) for each in part.values()),
            *self.prescribed,
        ]

    @property
    def key(self) -> tuple[object, ...]:
        """What the program depends on beside the model's structure."""
        return tuple(each.key for each in self.all)

    def values(self, where: Where, factor: float) -> list[Array]:
        """What is given at some entries."""
        return [row for each in self.all for row in each.at(where, factor)]

    def equations(self, recording: Recording) -> PlanarEquations | EquilibriumEquations:
        """The equations of one entry, of which the numbers are terms."""
        out = self._equations(
            self.loads.terms(recording), _terms(self.stacks, recording), _terms(self.joints, recording)
        )
        values = [each.terms(recording).array.reshape(1, 1) for each in self.prescribed]
        out.prescribed_values = np.concatenate([np.zeros((0, 1), dtype=object), *values])
        return out

    def _equations(
        self, loads: Numbers, stacks: list[dict[str, Any]], joints: list[dict[str, Any]]
    ) -> PlanarEquations | EquilibriumEquations:
        raise RuntimeError(f"{type(self).__name__} has no equations")


class PlanarNumbers(GivenNumbers):
    """What a program takes of a model in the plane.

    Parameters
    ----------
    model
        The model.
    """

    def __init__(self, model: PlanarModel) -> None:
        self.model = model
        joints = [_named(each, ("axes", "sense", "arm", "stiffness", "offset")) for each in model.joints]
        joints += [_named(each.joint, ("stiffness", "clearance")) for each in model.joints]
        super().__init__(model, ("direction", "length", "stiffness"), joints)

    def _equations(self, loads: Numbers, stacks: list[dict[str, Any]], joints: list[dict[str, Any]]) -> PlanarEquations:
        model = copy(self.model)
        model.loads = loads
        model.stacks = [replace(stack, **terms) for stack, terms in zip(model.stacks, stacks, strict=True)]
        count = len(model.joints)
        model.joints = [
            replace(joint, joint=replace(joint.joint, **inside), **terms)
            for joint, terms, inside in zip(model.joints, joints[:count], joints[count:], strict=True)
        ]
        return PlanarEquations(model, _HERE, 1)


class SpatialNumbers(GivenNumbers):
    """What a program takes of a model in space.

    Parameters
    ----------
    model
        The model, without loads between nodes.
    """

    def __init__(self, model: Model) -> None:
        self.model = model
        names = ("axes", "arm", "stiffness", "lead", "offset", "clearance")
        joints = [_named(each, names) for each in model.edges]
        super().__init__(model, ("local_axes", "length", "stiffness", "bow"), joints)

    def _equations(
        self, loads: Numbers, stacks: list[dict[str, Any]], joints: list[dict[str, Any]]
    ) -> EquilibriumEquations:
        model = copy(self.model)
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
