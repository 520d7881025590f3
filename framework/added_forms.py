"""scikit-fem forms on members (`Frame.add_form`), evaluated point by point as matrices and vectors.

A form is bilinear or linear in the six components of the displacement and their six derivatives along the member, all
in its own axes. At each point of the quadrature it is therefore a matrix (12, 12), or a vector (12,). A stiffness,
factorised as ``C = L D L^T``, gives springs D on deformations, the form in which frames take all members, so that batch
axes and error bounds apply to it. A load is a force and moment per length, and section forces that strain the member.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from importlib import import_module
from itertools import product
from typing import Any, Self

import numpy as np

from .batch import Array
from .entries import Change
from .errors import FrameError
from .ldl import factorised
from .shape_rules import gauss

STIFFNESS, MASS, LOAD = "stiffness", "mass", "load"
# Fraction of a form's largest coefficient, in matching units, below which a coefficient counts as rounding.
_ROUNDED = 1e-10
# Number of places along a member at which a form is evaluated to find its non-zero terms.
_LOOKED = 16


class _FormFields(dict[str, Any]):
    """The fields ``w`` of a form in scikit-fem; `placed` tells whether the form used its position."""

    placed = False

    def __getitem__(self, name: str) -> Any:
        if name in ("x", "h"):
            self.placed = True
        return super().__getitem__(name)

    def __getattr__(self, name: str) -> Any:
        if name in self:
            return self[name]
        raise AttributeError(f"the form asks for w.{name}: give it as a parameter; there are {', '.join(sorted(self))}")


@dataclass(frozen=True, eq=False)
class AddedForm:
    """A form with its parameters.

    Attributes
    ----------
    form
        ``BilinearForm`` or ``LinearForm``.
    into
        ``stiffness``, ``mass`` or ``load``.
    names, values
        Its parameters, (...) each.
    used
        Numbers of the fields on which it depends, of the six displacements and their six derivatives.
    terms
        Pairs of positions in `used` with non-zero coefficients; for a load single positions.
    acts
        Positions in `used` that have a spring.
    placed
        Whether it depends on the position along the member.
    intorder
        Order of integration; None for that of the element.
    """

    form: Any
    into: str
    names: tuple[str, ...]
    values: tuple[Array, ...]
    used: tuple[int, ...] = tuple(range(12))
    terms: tuple[tuple[int, ...], ...] = ()
    acts: tuple[int, ...] = ()
    placed: bool = False
    intorder: int | None = None

    @classmethod
    def of(
        cls, form: object, into: str | None, length: Array, parameters: Mapping[str, Array], intorder: int | None
    ) -> Self:
        """A form, tested on members of some lengths (...) for its terms, symmetry and sign."""
        kind = _kind(form, into)
        if intorder is not None and (not isinstance(intorder, (int, np.integer)) or intorder < 0):
            raise FrameError(f"add_form was given intorder={intorder!r}: give a whole number, or None")
        out = cls(form, kind, tuple(parameters), tuple(parameters.values()), intorder=intorder)
        every = [(i,) for i in range(12)] if kind == LOAD else list(product(range(12), repeat=2))
        out = replace(out, placed=out._asks(every, length))
        places = np.linspace(0.0, 1.0, _LOOKED) * np.asarray(length)[..., None]
        found = {term: value for term, value in out._values(places, length, every) if np.any(value)}
        if not all(np.isfinite(value).all() for value in found.values()):
            raise FrameError(f"add_form: {out.name} returned numbers that are not finite: give finite numbers")
        used = tuple(sorted({i for term in found for i in term}))
        terms = tuple(tuple(used.index(i) for i in term) for term in found)
        out = replace(out, used=used, terms=terms)
        return out if kind == LOAD else out._examined(_matrix(found.values(), terms, len(used)), length)

    def _asks(self, terms: Sequence[tuple[int, ...]], length: Array) -> bool:
        """Whether the form uses the position along the member."""
        text = _FormFields()
        one = replace(self, values=tuple(value.reshape(-1)[:1].reshape(()) for value in self.values), placed=True)
        first = np.asarray(length).reshape(-1)[:1].reshape(())
        for _ in one._values(first[None], first, terms, text):
            pass
        return text.placed

    def _examined(self, matrices: Array, length: Array) -> Self:
        """The form with its springs, if it is symmetric and not negative.

        Raises
        ------
        FrameError
            If it is not.
        """
        size = np.max(length, initial=0.0) ** np.repeat([0.0, 1.0, 1.0, 2.0], 3)[list(self.used)]
        weighted = matrices / (size[:, None] * size)
        most = np.abs(weighted).max(axis=(-2, -1), initial=0.0, keepdims=True)
        if np.any(np.abs(weighted - np.swapaxes(weighted, -1, -2)) > _ROUNDED * most):
            raise FrameError(f"add_form: {self.name} is not symmetric in u and v: frames take symmetric forms")
        pivots, _, left = _factored(weighted)
        if np.any(left > _ROUNDED * most[..., 0, 0]):
            made = "springs that push" if self.into == STIFFNESS else "a mass below zero"
            raise FrameError(
                f"add_form: {self.name} is not positive semidefinite at each point, as of {made}: give one with "
                "form(u, u) not below zero anywhere"
            )
        acts = np.flatnonzero((pivots != 0.0).reshape(-1, len(self.used)).any(axis=0)).tolist()
        return replace(self, terms=tuple(pair for pair in self.terms if pair[0] <= pair[1]), acts=tuple(acts))

    @property
    def name(self) -> str:
        """Name of the form's function."""
        return f"form {getattr(self.form.form, '__name__', 'without a name')!r}"

    @property
    def shape(self) -> tuple[int, ...]:
        """Batch shape of the parameters."""
        return np.broadcast_shapes(*(value.shape for value in self.values)) if self.values else ()

    @property
    def strains(self) -> bool:
        """Whether it is a load on derivatives, which strains the member as heat does."""
        return self.into == LOAD and any(i >= 6 for i in self.used)

    @property
    def pushes(self) -> bool:
        """Whether it is a load with a force or moment per length."""
        return self.into == LOAD and any(i < 6 or i in (7, 8) for i in self.used)

    def __getstate__(self) -> dict[str, Any]:
        """State for pickling; a form made by scikit-fem's decorator is stored by the name of its function."""
        function, state = self.form.form, dict(vars(self))
        module, name = getattr(function, "__module__", ""), getattr(function, "__qualname__", "")
        if getattr(sys.modules.get(module), name, None) is self.form:
            state["form"] = module, name
        return state

    def __setstate__(self, state: dict[str, Any]) -> None:
        form = state["form"]
        found = getattr(import_module(form[0]), form[1]) if isinstance(form, tuple) else form
        vars(self).update(state | {"form": found})

    def cut(self, change: Change) -> Self:
        """The form at some entries of the batch."""
        return replace(self, values=tuple(change(value, 0) for value in self.values))

    def load(self, x: Array, length: Array) -> Array:
        """The coefficients of a load at some points: of displacement, then of its derivative, (..., points, 12).

        Parameters
        ----------
        x
            Distances from the member's start, (..., points).
        length
            Length of the piece, (...).
        """
        found = self._values(x, length, [(self.used[i],) for (i,) in self.terms])
        parts = {term[0]: value for term, value in found}
        shape = np.broadcast_shapes(*(part.shape for part in parts.values())) if parts else (1,)
        out = np.zeros((*shape, 12))
        for i, part in parts.items():
            out[..., i] = part
        return out

    def matrices(self, x: Array, length: Array) -> Array:
        """The coefficients of a bilinear form at some points, (..., points, n, n), over `used`; see `load`."""
        pairs = [(self.used[i], self.used[j]) for i, j in self.terms]
        upper = [value for _, value in self._values(x, length, pairs)]
        return _matrix([*upper, *upper], [*self.terms, *((j, i) for i, j in self.terms)], len(self.used))

    def _values(
        self, x: Array, length: Array, terms: Sequence[tuple[int, ...]], fields_by_name: _FormFields | None = None
    ) -> Iterator[tuple[tuple[int, ...], Array]]:
        """Values of the form for unit fields of some terms, (..., points); one point if all are alike."""
        from skfem.element import DiscreteField

        fields_by_name = _FormFields() if fields_by_name is None else fields_by_name
        x = x if self.placed else x.reshape(-1)[:1]
        lead = x.shape[:-1]
        ndim = max(len(lead), len(self.shape))
        shape = (*np.broadcast_shapes((1,) * ndim, lead, self.shape), x.shape[-1])
        flat = (int(np.prod(shape[:-1], dtype=np.int64)), shape[-1])
        along = np.broadcast_to(x, shape).reshape(flat)
        fields_by_name["x"] = np.stack([along, 0.0 * along, 0.0 * along])
        fields_by_name["h"] = np.broadcast_to(np.asarray(length)[..., None] if self.placed else 0.0, shape).reshape(
            flat
        )
        for name, value in zip(self.names, self.values, strict=True):
            fields_by_name[name] = (
                float(value) if value.ndim == 0 else np.broadcast_to(value[..., None], shape).reshape(flat)
            )
        units = [_unit(DiscreteField, i, flat) for i in range(12)]
        for term in terms:
            value = self._value([units[i] for i in term], fields_by_name)
            yield term, np.broadcast_to(value, flat).reshape(shape)

    def _value(self, fields: list[Any], fields_by_name: _FormFields) -> Array:
        try:
            return np.asarray(self.form.form(*fields, fields_by_name), dtype=np.float64)
        except (TypeError, ValueError, LookupError, AttributeError, ArithmeticError) as error:
            raise FrameError(
                f"add_form: {self.name} failed: {error}. It is given the displacement in the members' axes, "
                "u[0] to u[5] for ux uy uz rx ry rz and u.grad[0] to u.grad[5] along the member, and w"
            ) from error

    def points(self, fractions: Array, weights: Array) -> tuple[Array, Array]:
        """Fractions and weights of its quadrature; those given, of the element, without an order of its own."""
        if self.intorder is None:
            return fractions, weights
        return gauss(self.intorder // 2 + 1)

    def springs(self, matrices: Array) -> tuple[Array, Array]:
        """Springs (..., points, k), and their rows by displacements and derivatives, (..., points or 1, k, 12)."""
        acts, wide = list(self.acts), np.eye(12)[list(self.used)]
        if all(i == j for i, j in self.terms):
            return matrices[..., acts, acts], wide[acts][None]
        pivots, rows, _ = _factored(matrices)
        return pivots[..., acts], rows[..., acts, :] @ wide


def _kind(form: object, into: str | None) -> str:
    from skfem import BilinearForm, LinearForm

    bilinear = isinstance(form, BilinearForm)
    if not bilinear and not isinstance(form, LinearForm):
        raise FrameError(f"add_form was given {form!r}: give a skfem.BilinearForm or a skfem.LinearForm")
    kinds = (STIFFNESS, MASS) if bilinear else (LOAD,)
    if into is not None and into not in kinds:
        text = " or ".join(repr(kind) for kind in kinds)
        raise FrameError(f"add_form was given into={into!r} for a {type(form).__name__}: give {text}")
    return kinds[0] if into is None else into


def _unit(field: Any, i: int, flat: tuple[int, int]) -> Any:
    """A field that is one in one of the twelve and zero in the others."""
    both = np.eye(12)[i][:, None, None]
    return field(*(np.broadcast_to(part, (6, *flat)) for part in (both[:6], both[6:])))


def _matrix(values: Iterable[Array], terms: Iterable[tuple[int, ...]], size: int) -> Array:
    """Matrices (..., n, n) from their entries (...)."""
    pairs = list(zip(values, terms, strict=True))
    out = np.zeros((*np.broadcast_shapes((1,), *(value.shape for value, _ in pairs)), size, size))
    for value, (i, j) in pairs:
        out[..., i, j] = value
    return out


def _factored(matrices: Array) -> tuple[Array, Array, Array]:
    """``C = sum_i d_i l_i l_i^T`` of matrices (..., n, n): d (..., n), rows l (..., n, n), and what is left (...)."""
    columns = factorised(np.array(np.moveaxis(matrices, (-2, -1), (0, 1)), order="C"), _ROUNDED, raised=False)
    inverse = np.stack([over for _, over in columns], axis=-1)
    pivots = np.divide(1.0, inverse, out=np.zeros(inverse.shape), where=inverse > 0.0)
    rows = np.zeros(matrices.shape) + np.eye(len(columns))
    for k, (lower, _) in enumerate(columns):
        rows[..., k, k + 1 :] = np.moveaxis(lower, 0, -1)
    made = np.swapaxes(rows, -1, -2) @ (pivots[..., None] * rows)
    return pivots, rows, np.abs(matrices - made).max(axis=(-2, -1), initial=0.0)


@dataclass(frozen=True, eq=False)
class FormLoad:
    """Force and moment per length on a member, by a form, in the member's own axes."""

    added: AddedForm
    local: bool = True

    @property
    def forces(self) -> tuple[Array, ...]:
        """What may vary over the batch, (..., 1) each."""
        return tuple(value[..., None] for value in self.added.values)

    @property
    def places(self) -> tuple[float, ...]:
        """No distances: it acts on the whole member."""
        return ()

    def in_axes(self, local_axes: Array) -> FormLoad:
        """Itself: it is written in the member's own axes."""
        return self

    def points(
        self, lower: Array, upper: Array, length: Array, rule: Callable[[Array, Array], tuple[Array, Array]]
    ) -> list[tuple[Array, Array]]:
        """Distances from the member's start and forces (..., 6) that stand for the load between `lower` and `upper`."""
        stretch = np.clip(upper, 0.0, length) - lower
        order = self.added.intorder
        out = []
        by = rule(lower, lower + stretch) if order is None else gauss(order // 2 + 1)
        for point, weight in zip(*by, strict=True):
            x = np.asarray(lower + stretch * point)
            given = self.added.load(x[..., None], length)[..., 0, :]
            force = given[..., :6].copy()
            # a force conjugate to the slope of the axis is one on the shear strain and a moment on the rotation
            force[..., 4] -= given[..., 8]
            force[..., 5] += given[..., 7]
            out.append((x, (weight * stretch)[..., None] * force))
        return out
