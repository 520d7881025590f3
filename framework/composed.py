"""Line elements that wrap another one, delegate to it and change some of its answers."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Hashable
from dataclasses import dataclass, replace
from functools import wraps
from typing import Any, Concatenate, ParamSpec, Self, TypeVar

from .batch import Array
from .entries import Change
from .protocol import LineElement

_P = ParamSpec("_P")
_R = TypeVar("_R")


class OfAnother(LineElement):
    """Base of elements that wrap another one: the properties that all of them take from it."""

    own: LineElement

    @abstractmethod
    def made_of(self, own: LineElement) -> Self:
        """The same wrapper of another element."""

    @property
    def innermost(self) -> LineElement:
        """The wrapped element that wraps no other."""
        return self.own.innermost if isinstance(self.own, OfAnother) else self.own

    def of_innermost(self, own: LineElement) -> Self:
        """The same wrappers of another innermost element."""
        return self.made_of(self.own.of_innermost(own) if isinstance(self.own, OfAnother) else own)

    def of_length(self, length: Array) -> Self:
        """The same in a member of another length, (...), where the element has something of that in itself."""
        return self.made_of(self.own.of_length(length)) if isinstance(self.own, OfAnother) else self

    @property
    def shape(self) -> tuple[int, ...]:
        return self.own.shape

    @property
    def exact(self) -> bool:
        return self.own.exact

    @property
    def roundings(self) -> float:
        return self.own.roundings

    @property
    def quadrature(self) -> int:
        return self.own.quadrature

    @property
    def integration_points(self) -> tuple[Array, Array]:
        return self.own.integration_points

    def rule_between(self, lower: Array, upper: Array) -> tuple[Array, Array]:
        return self.own.rule_between(lower, upper)

    @property
    def sections_shape(self) -> tuple[int, ...]:
        return self.own.sections_shape


def _as_own(method: Callable[Concatenate[Any, _P], _R]) -> Callable[Concatenate[Any, _P], _R]:
    """A method that delegates to the wrapped element."""
    name = method.__name__

    @wraps(method, updated=())  # not whether it is abstract
    def answer(self: Any, /, *given: _P.args, **named: _P.kwargs) -> _R:
        found: _R = getattr(self.own, name)(*given, **named)
        return found

    return answer


@dataclass(frozen=True, eq=False)
class Composed(OfAnother):
    """A wrapper that delegates everything to `own`; a subclass overrides what it changes, and `kind`."""

    own: LineElement

    def __post_init__(self) -> None:
        object.__setattr__(self, "segments", self.own.segments)
        object.__setattr__(self, "releases", self.own.releases)

    @property
    def kind(self) -> Hashable:
        """Kind of the wrapped element, with the classes of wrapper and element."""
        return type(self), type(self.own), self.own.kind

    @property
    def title(self) -> str:
        return self.own.title

    @property
    def has_springs(self) -> bool:
        return True

    @property
    def balanced(self) -> bool | None:
        return self.own.balanced

    @property
    def tension(self) -> Array:
        return self.own.tension

    def made_of(self, own: LineElement) -> Self:
        """The same of another element."""
        return replace(self, own=own)

    def part(self, index: int, count: int) -> LineElement:
        return self.made_of(self.own.part(index, count))

    def unreleased(self) -> LineElement | None:
        own = self.own.unreleased()
        return None if own is None else self.made_of(own)

    def cut(self, change: Change) -> Self:
        return replace(self, own=self.own.cut(change) if self.own.shape else self.own)

    @property
    def has_law(self) -> bool:
        return self.own.has_law

    @property
    def has_end_forces(self) -> bool:
        return self.own.has_end_forces

    check = _as_own(LineElement.check)
    axes = _as_own(LineElement.axes)
    stiffness_matrix = _as_own(LineElement.stiffness_matrix)
    springs = _as_own(LineElement.springs)
    mass_matrix = _as_own(LineElement.mass_matrix)
    geometric_matrix = _as_own(LineElement.geometric_matrix)
    consistent_loads = _as_own(LineElement.consistent_loads)
    end_forces = _as_own(LineElement.end_forces)
    resistance = _as_own(LineElement.resistance)
    shape_functions = _as_own(LineElement.shape_functions)
    shape_gradients = _as_own(LineElement.shape_gradients)
    shape_rows = _as_own(LineElement.shape_rows)
    section_flexibility = _as_own(LineElement.section_flexibility)
    section_inertia = _as_own(LineElement.section_inertia)
    section_sway = _as_own(LineElement.section_sway)
    mass_per_length = _as_own(LineElement.mass_per_length)
    free_strain = _as_own(LineElement.free_strain)
    restrained_forces = _as_own(LineElement.restrained_forces)
    stress = _as_own(LineElement.stress)


@dataclass(frozen=True, eq=False)
class Unstrained(Composed):
    """An element without free strain, such as that of heat."""

    end_force_numbers = _as_own(LineElement.end_force_numbers)

    def free_strain(self, fraction: Array) -> None:
        return None

    def restrained_forces(self, fraction: Array) -> None:
        return None
