"""A wrapper that checks what a user's own element returns, and broadcasts it to full shape.

It takes the place of the element wherever a frame is computed. A wrong result raises an error when it is first read,
naming the element, what it returned and what is expected; a right one costs a check of shapes and finite numbers.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable
from dataclasses import fields, is_dataclass
from typing import Any, Self, cast

import numpy as np
from numpy.typing import NDArray

from .batch import Array, Shape, finite
from .composed import OfAnother
from .entries import Change
from .errors import FrameError
from .protocol import LineElement, is_proven

Real = NDArray[Any]
# Difference, for the size of what is compared, above which two elements of one kind are not the same.
_SAME = 1e-12


class Unanswered(FrameError):
    """An element returns nothing for what it must define."""


def examined(element: LineElement, name: str) -> LineElement:
    """The element itself if its class is proven, else wrapped for checks; `name` is that of its member."""
    return element if is_proven(element) or isinstance(element, Examined) else Examined(element, name)


class Examined(OfAnother):
    """An element whose returned arrays are checked at each call.

    Parameters
    ----------
    own
        The element.
    name
        Name of the first member that it is given for.
    """

    def __init__(self, own: LineElement, name: str) -> None:
        self.own, self.name = own, name
        self.segments, self.releases = (attribute_of(self.what, own, each) for each in ("segments", "releases"))

    def __repr__(self) -> str:
        return repr(self.own)

    def made_of(self, own: LineElement) -> Self:
        """The same of another element."""
        return cast(Self, Examined(own, self.name))

    @property
    def what(self) -> str:
        """How messages name it."""
        return f"{self.own.title} of member {self.name!r}"

    # -- description ------------------------------------------------------------------------------------------------

    @property
    def kind(self) -> Hashable:
        """Kind of the element and its class, as a subclass may inherit the kind and behave differently."""
        return type(self.own), self.own.kind

    @property
    def tension(self) -> Array:
        found = finite(self.own.tension, f"{self.what}: tension")
        if np.broadcast_shapes(found.shape, self.own.shape) != self.own.shape:
            raise FrameError(f"{self.what}: tension has shape {found.shape}, and the element {self.own.shape}")
        return found

    @property
    def has_springs(self) -> bool:
        return self.own.has_springs

    def part(self, index: int, count: int) -> LineElement:
        found = self.own.part(index, count)
        if not isinstance(found, LineElement):
            raise FrameError(f"{self.what}: part({index}, {count}) returned {found!r}: give a LineElement")
        return examined(found, self.name)

    def cut(self, change: Change) -> Self:
        shape = self.own.shape
        if math.prod(shape) == 1:
            return self
        found = self.own.cut(change)
        wanted = change(np.broadcast_to(np.zeros(()), shape), 0).shape
        if found.shape != wanted:
            raise FrameError(
                f"{self.what}: cut left shape {found.shape} of {shape} where {wanted} was wanted: hold each array of "
                'the batch in a field of a dataclass, with metadata {"trailing": 1} where its last axis is no batch '
                "axis, or give the element its own method cut(change)"
            )
        return cast(Self, Examined(found, self.name))

    def same_as(self, other: LineElement, length: Array) -> None:
        """Refuse an element of equal kind that behaves differently at some length.

        Raises
        ------
        FrameError
            Where springs, batch shape, releases or mass differ.
        """
        assert isinstance(other, Examined)
        if self.own is other.own or _same_fields(self.own, other.own):
            return
        here, there = ((e.shape, e.releases, e.exact, *e.springs(length), _mass(e)) for e in (self, other))
        if not all(_equal(a, b) for a, b in zip(here, there, strict=True)):
            raise FrameError(
                f"{self.what} and {other.what} are of equal kind and not the same: let kind tell them apart, by all "
                "that they are made of, or return self"
            )

    # -- answers ----------------------------------------------------------------------------------------------------

    def check(self, chord: Array) -> None:
        self.own.check(chord)

    def axes(self, chord: Array) -> Array:
        return self._asked("axes", chord.shape[:-1], (3, 3), chord)

    def stiffness_matrix(self, length: Array) -> Array:
        return self._square("stiffness_matrix", length, length)

    def mass_matrix(self, length: Array) -> Array:
        return self._square("mass_matrix", length, length)

    def geometric_matrix(self, length: Array, axial: Array) -> Array:
        shape = np.broadcast_shapes(np.shape(length), np.shape(axial))
        return self._square("geometric_matrix", np.broadcast_to(length, shape), length, axial)

    def springs(self, length: Array) -> tuple[Array, Array]:
        """Springs k (..., n) on deformations b (..., n, 12), the axis of pieces whole."""
        found = self._answer("springs", length)
        if not isinstance(found, tuple) or len(found) != 2:
            raise FrameError(
                f"{self.what}: springs returned {_shape_text(found)}: give stiffnesses and deformations, (k, b)"
            )
        rows = np.asarray(found[1])
        count = rows.shape[-2] if rows.ndim > 1 else 0
        if not count:
            text = f"{self.what}: springs returned deformations of shape {rows.shape}"
            raise FrameError(f"{text}: give (..., n, 12), n > 0")
        batch = self._batch(length)
        deformations = self._checked("springs (deformations)", rows, batch, (count, 12))
        stiffness = self._checked("springs (stiffnesses)", found[0], batch, (count,))
        return _whole(stiffness, length, 1), _whole(deformations, length, 2)

    def end_forces(self, length: Array, displacement: Array) -> Array:
        batch = np.broadcast_shapes(np.shape(length), np.shape(displacement)[:-1])
        return self._asked("end_forces", batch, (12,), length, displacement)

    @property
    def has_end_forces(self) -> bool:
        return self.own.has_end_forces

    def consistent_loads(self, length: Array, x: Array, forces: Array) -> Array:
        batch = np.broadcast_shapes(np.shape(length), np.shape(x)[1:], np.shape(forces)[1:-1])
        return self._asked("consistent_loads", batch, (12,), length, x, forces)

    def strain_loads(self, length: Array) -> Array:
        return self._asked("strain_loads", np.shape(length), (12,), length)

    def resistance(self, length: Array, deformation: Array, pick: Change) -> tuple[Array, Array, Array]:
        found = self._answer("resistance", length, deformation, pick)
        count = len(deformation)
        wanted = ((count,), (count, 7), (count, 7, 7))
        shapes = tuple(np.shape(part) for part in found) if isinstance(found, tuple) else ()
        if shapes != wanted:
            raise FrameError(f"{self.what}: resistance returned shapes {shapes} for {count} entries: give {wanted}")
        energy, force, tangent = (np.asarray(part, dtype=np.float64) for part in found)
        return energy, force, tangent

    @property
    def has_law(self) -> bool:
        return self.own.has_law

    def shape_functions(self, length: Array, x: Array) -> Array:
        return self._asked("shape_functions", np.broadcast_shapes(np.shape(length), np.shape(x)), (6, 12), length, x)

    def shape_gradients(self, length: Array, x: Array) -> Array:
        return self._asked("shape_gradients", np.broadcast_shapes(np.shape(length), np.shape(x)), (6, 12), length, x)

    def shape_rows(self, length: Array, fraction: Array) -> tuple[Array, Array]:
        return self.own.shape_rows(length, fraction)

    def section_flexibility(self, fraction: Array) -> Array:
        return self._asked("section_flexibility", np.shape(fraction), (6,), fraction)

    def section_inertia(self, fraction: Array) -> Array:
        return self._asked("section_inertia", np.shape(fraction), (6,), fraction)

    def section_sway(self, fraction: Array) -> Array:
        return self._asked("section_sway", np.shape(fraction), (6,), fraction)

    def free_strain(self, fraction: Array) -> Array | None:
        if self.own.free_strain(fraction) is None:
            return None
        return self._asked("free_strain", np.shape(fraction), (6,), fraction)

    def restrained_forces(self, fraction: Array) -> Array | None:
        if self.own.free_strain(fraction) is None:
            return None
        return self._asked("restrained_forces", np.shape(fraction), (6,), fraction)

    def mass_per_length(self, fraction: Array) -> Array:
        return self._asked("mass_per_length", np.shape(fraction), (), fraction)

    def stress(self, fraction: Array, forces: Array) -> Array:
        batch = np.broadcast_shapes(np.shape(fraction), np.shape(forces)[:-1])
        # without a solution the forces are NaN
        return self._asked("stress", batch, (3,), fraction, forces, finite=bool(np.isfinite(forces).all()))

    # -- inside -----------------------------------------------------------------------------------------------------

    def _answer(self, method: str, *given: Any) -> Any:
        answer: Callable[..., Any] = getattr(self.own, method)
        try:
            return answer(*given)
        except NotImplementedError:
            raise Unanswered(f"{self.what} has no {method}: give its class this method") from None
        except FrameError:
            raise
        except (TypeError, ValueError, LookupError, AttributeError, ArithmeticError) as error:
            shapes = ", ".join(str(np.shape(each)) for each in given if not callable(each))
            raise FrameError(f"{self.what}: {method} failed for arrays of shape {shapes}: {error}") from error

    def _asked(self, method: str, batch: Shape, trailing_shape: Shape, *given: Any, finite: bool = True) -> Array:
        finite = finite and all(np.isfinite(each).all() for each in given[1:])
        shape = np.broadcast_shapes(batch, self.own.shape)
        return self._checked(method, self._answer(method, *given), shape, trailing_shape, finite=finite)

    def _square(self, method: str, of: Array, *given: Any) -> Array:
        return _whole(self._asked(method, np.shape(of), (12, 12), *given), of, 2)

    def _batch(self, length: Array) -> Shape:
        return np.broadcast_shapes(np.shape(length), self.own.shape)

    def _checked(self, method: str, value: Any, batch: Shape, trailing_shape: Shape, *, finite: bool = True) -> Array:
        """`value` as numbers of shape (..., tail), whose leading axes broadcast to `batch`."""
        array = np.asarray(value)
        lead = array.shape[: array.ndim - len(trailing_shape)]
        text = f"{self.what}: {method} returned"
        if (
            array.dtype.kind not in "fiu"
            or array.ndim < len(trailing_shape)
            or array.shape[len(lead) :] != trailing_shape
        ):
            wanted = ", ".join(map(str, ("...", *trailing_shape)))
            raise FrameError(f"{text} {_shape_text(value)}: give numbers of shape ({wanted})")
        if not fits(lead, batch):
            raise FrameError(
                f"{text} batch axes {lead}, which do not broadcast to {batch}, those of what it was given and of its "
                f"shape {self.own.shape}"
            )
        if finite and not np.isfinite(array).all():
            raise FrameError(f"{text} {array[~np.isfinite(array)].flat[0]}: give finite numbers")
        return array if array.dtype.kind == "f" else array.astype(np.float64)


def attribute_of(what: str, element: object, attribute: str) -> Any:
    """An attribute that an element must have."""
    try:
        return getattr(element, attribute)
    except AttributeError:
        raise FrameError(f"{what} has no {attribute}: give it this attribute") from None


def _whole(array: Real, length: Array, trailing: int) -> Real:
    """`array` with all batch axes of `length`; the first has its size, one for each piece."""
    ndim = np.ndim(length)
    lead = array.shape[: array.ndim - trailing]
    if len(lead) < ndim:
        lead = (1,) * (ndim - len(lead)) + lead
        array = array.reshape(*lead, *array.shape[array.ndim - trailing :])
    if ndim and len(lead) == ndim and lead[0] != np.shape(length)[0]:
        array = np.broadcast_to(array, (np.shape(length)[0], *array.shape[1:]))
    return array


def fits(lead: Shape, batch: Shape) -> bool:
    """Whether batch axes broadcast to a batch without widening it."""
    return len(lead) <= len(batch) and all(n in (1, m) for n, m in zip(lead[::-1], batch[::-1], strict=False))


def _shape_text(value: Any) -> str:
    if isinstance(value, np.ndarray):
        return f"shape {value.shape} of {value.dtype}"
    return f"a {type(value).__name__}"


def _mass(element: Examined) -> Array:
    return element.mass_per_length(np.array([0.25]))


def _equal(one: Any, other: Any) -> bool:
    if not isinstance(one, np.ndarray):
        return bool(one == other)
    if one.shape != other.shape:
        return False
    return bool(np.all(np.abs(one - other) <= _SAME * np.maximum(np.abs(one), np.abs(other)).max(initial=0.0)))


def _same_fields(one: object, other: object) -> bool:
    """Whether all fields of two elements are the same object or equal numbers."""
    if type(one) is not type(other):
        return False
    pairs = [[vars(each)[f.name] for f in fields(each)] if is_dataclass(each) else list(vars(each).values())
             for each in (one, other)]  # fmt: skip
    return len(pairs[0]) == len(pairs[1]) and all(_same_value(a, b) for a, b in zip(*pairs, strict=True))


def _same_value(one: Any, other: Any) -> bool:
    if one is other:
        return True
    if isinstance(one, np.ndarray) and isinstance(other, np.ndarray):
        return one.shape == other.shape and bool(np.all(one == other))
    if isinstance(one, tuple) and isinstance(other, tuple):
        return len(one) == len(other) and all(map(_same_value, one, other))
    return isinstance(one, (bool, int, float, str)) and type(one) is type(other) and bool(one == other)
