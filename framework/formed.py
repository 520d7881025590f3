"""A line element with scikit-fem forms added to it: springs, mass and strain of its own and of the forms."""

from __future__ import annotations

import math
from collections.abc import Hashable
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from .added_forms import LOAD, MASS, STIFFNESS, AddedForm
from .batch import Array
from .composed import Composed, OfAnother
from .entries import Change
from .errors import FrameError
from .protocol import LineElement
from .shape_rules import balanced_rows, summed

# Roundings in the stiffness of the springs that stand for a form, those of its own arithmetic included.
_ROUNDINGS = 100.0


@dataclass(frozen=True, eq=False)
class FormedElement(Composed):
    """An element and forms over its own shape functions.

    Attributes
    ----------
    own
        The element.
    forms
        The forms.
    length
        Length of its member, (...), if a form that strains it depends on the position; else None.
    index, count
        Number of this part, and number of equal parts of its member, if a form depends on the position.
    """

    forms: tuple[AddedForm, ...] = ()
    length: Array | None = None
    index: int = 0
    count: int = 1

    @classmethod
    def of(cls, element: LineElement, form: AddedForm, length: Array | None) -> LineElement:
        """An element with one more form; a load without strain leaves the element as it is."""
        if form.into == LOAD and not form.strains:
            return element
        if element.has_law and form.into == STIFFNESS:
            raise FrameError(
                f"add_form: {form.name} is a stiffness, and {element.title} has its own law: put it into resistance"
            )
        if isinstance(element, FormedElement):
            return replace(element, forms=(*element.forms, form), length=element.length if length is None else length)
        return cls(element, (form,), length)

    @property
    def shape(self) -> tuple[int, ...]:
        """Batch shape of the element's parameters and those of the forms."""
        along = () if self.length is None else self.length.shape
        return np.broadcast_shapes(self.own.shape, along, *(form.shape for form in self.forms))

    @property
    def kind(self) -> Hashable:
        """Equal for elements of one kind with the same forms."""
        along = None if self.length is None else self.length.tobytes()
        return type(self), type(self.own), self.own.kind, self.forms, along, self.index, self.count

    @property
    def title(self) -> str:
        """How messages name the element."""
        return f"{self.own.title} with {', '.join(form.name for form in self.forms)}"

    @property
    def exact(self) -> bool:
        """Whether one piece is exact in statics, which it is not with a stiffness form that shape functions ignore."""
        return self.own.exact and not self._into(STIFFNESS)

    @property
    def roundings(self) -> float:
        """Roundings that the stiffnesses of `springs` may be off."""
        return self.own.roundings + (_ROUNDINGS if self._into(STIFFNESS) else 0.0)

    @property
    def balanced(self) -> bool | None:
        """Whether a rigid motion needs no force; None, to be found by the frame, if forms add stiffness."""
        return None if self._into(STIFFNESS) else self.own.balanced

    @property
    def sections_shape(self) -> tuple[int, ...]:
        """Batch shape of the section law."""
        return self.shape

    def part(self, index: int, count: int) -> LineElement:
        """One of `count` equal parts."""
        own = self.own.part(index, count)
        if any(form.placed for form in self.forms):
            return replace(self, own=own, index=self.index * count + index, count=self.count * count)
        return self if own is self.own else replace(self, own=own)

    def of_length(self, length: Array) -> Self:
        """The element and its forms in a member of another length, (...)."""
        own = self.own.of_length(length) if isinstance(self.own, OfAnother) else self.own
        return replace(self, own=own, length=None if self.length is None else length)

    def cut(self, change: Change) -> Self:
        """The element and its forms at some entries of the batch."""
        own = self.own.cut(change) if math.prod(self.own.shape) != 1 else self.own
        along = None if self.length is None else change(self.length, 0)
        return replace(self, own=own, forms=tuple(form.cut(change) for form in self.forms), length=along)

    def springs(self, length: Array) -> tuple[Array, Array]:
        """Springs of the element and, after them, of the forms."""
        parts = [self.own.springs(length), *(self._springs(form, length) for form in self._into(STIFFNESS))]
        stiffness = _joined([k for k, _ in parts], 1)
        return stiffness, _joined([rows for _, rows in parts], 2)

    def stiffness_matrix(self, length: Array) -> Array:
        """Stiffness of the element and of the forms, (..., 12, 12)."""
        out = self.own.stiffness_matrix(length)
        for form in self._into(STIFFNESS):
            out = out + summed(*self._springs(form, np.asarray(length, dtype=np.float64)))
        return out

    @property
    def has_end_forces(self) -> bool:
        """False: those of the element leave out the forms."""
        return False

    def end_forces(self, length: Array, displacement: Array) -> Array:
        """Forces of the element and of the forms on the ends, (..., 12)."""
        return LineElement.end_forces(self, length, displacement)

    def mass_matrix(self, length: Array) -> Array:
        """Mass of the element and of the forms, (..., 12, 12)."""
        out = self.own.mass_matrix(length)
        for form in self._into(MASS):
            out = out + summed(*self._springs(form, np.asarray(length, dtype=np.float64)))
        return out

    def free_strain(self, fraction: Array) -> Array | None:
        """Strain without forces of the element and of the forms, (..., 6); None for none."""
        forces = self._constrained(fraction)
        own = self.own.free_strain(fraction)
        if forces is None:
            return own
        strain: Array = self.own.section_flexibility(fraction) * forces
        return strain if own is None else own + strain

    def restrained_forces(self, fraction: Array) -> Array | None:
        """Section forces that would cause the free strain, (..., 6); None for none."""
        forces, own = self._constrained(fraction), self.own.restrained_forces(fraction)
        return own if forces is None else forces if own is None else own + forces

    # -- inside -----------------------------------------------------------------------------------------------------

    def _into(self, kind: str) -> list[AddedForm]:
        return [form for form in self.forms if form.into == kind]

    def _places(self, length: Array, fractions: Array) -> Array:
        """Distances from the member's start, (..., points), of fractions (points, ...) of the piece."""
        at: Array = np.moveaxis((self.index + fractions) * length, 0, -1)
        return at

    def _constrained(self, fraction: Array) -> Array | None:
        """Section forces of the loads that strain it, (..., 6)."""
        found: Array | None = None
        for form in self._into(LOAD):
            length = np.ones(()) if self.length is None else self.length / self.count
            x = np.asarray((self.index + fraction) * length)
            given = form.load(x[..., None], length)[..., 0, 6:]
            found = given if found is None else found + given
        return found

    def _springs(self, form: AddedForm, length: Array) -> tuple[Array, Array]:
        """A form at the points of its quadrature as springs (..., n) on deformations (..., n, 12)."""
        fractions, weights = form.points(*self.own.integration_points)
        plain = np.asarray(length, dtype=np.float64)
        lead = (slice(None), *(None,) * max(0, plain.ndim + 1 - fractions.ndim))
        spread, shares = fractions[lead], np.moveaxis(weights[lead] * plain, 0, -1)
        k, acts = form.springs(form.matrices(self._places(plain, spread), plain))
        fields = np.concatenate(self.own.shape_rows(length, spread), axis=-2)
        rows = acts @ np.moveaxis(fields, 0, -3)
        stiffness, count = shares[..., None] * k, len(fractions) * len(form.acts)
        rows = balanced_rows(rows.reshape(*rows.shape[:-3], count, 12), length)
        return stiffness.reshape(*stiffness.shape[:-2], count), rows


def _joined(parts: list[Array], trailing: int) -> Array:
    """Arrays (..., n) or (..., n, 12), one after the other along n."""
    shape = np.broadcast_shapes(*(part.shape[: part.ndim - trailing] for part in parts))
    each = [np.broadcast_to(part, (*shape, *part.shape[part.ndim - trailing :])) for part in parts]
    return np.concatenate(each, axis=-trailing)
