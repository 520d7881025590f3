"""The interface between the framework and its elements: members (`LineElement`) and masses (`PointElement`).

All arrays have batch axes first and components last. Forces and displacements of a line element are in its local
axes, start node before end node, each ``ux uy uz rx ry rz``.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Hashable, Mapping, Sequence
from typing import Any, NamedTuple, Self, TypeVar

import numpy as np
from numpy.typing import NDArray

from .entries import Change
from .member_forms import MemberForms
from .orientation import default_axis_numbers
from .stacking import changed

Array = NDArray[np.float64]
_Element = TypeVar("_Element", bound=type)


class SpringFormulas(NamedTuple):
    """How the springs of an element follow from its numbers, by arithmetic on arrays or on terms of a recording.

    They give the bits of `LineElement.springs`.

    Attributes
    ----------
    inputs
        Numbers of the element, each (...) or a float.
    stiffness
        Function from the inputs and the length of the member to the stiffnesses of the springs, all of which vary with
        the batch of the element.
    deformations
        Function from the length to the deformations, see `LineElement.deformation_numbers`.
    """

    inputs: tuple[Array | float, ...]
    stiffness: Callable[[Sequence[Any], Any], list[Any]]
    deformations: Callable[[Any], Mapping[tuple[int, int], Any]]


_PROVEN = "_proven"


def proven(kind: _Element) -> _Element:
    """Mark a class of elements that has tests of its own, so that a frame need not check what it returns.

    A subclass is checked, as it may override methods.
    """
    setattr(kind, _PROVEN, kind)
    return kind


def is_proven(element: object) -> bool:
    """Whether the class of an element is marked as `proven`; a mark of a base class does not count."""
    return getattr(type(element), _PROVEN, None) is type(element)


class LineElement(MemberForms):
    """A straight member between two nodes: its stiffness, mass, loads and internal forces in local axes.

    A subclass defines `shape`, `shape_functions` and its stiffness, either by a section law, `section_flexibility`, or
    by `springs`. Everything else has a default: matrices, consistent loads and internal forces by the scikit-fem forms
    of `linkframe.elements.forms` over the shape functions and the section law. Override a method where there is a
    closed form, or where axes, mass or stress differ. Arrays that do not vary along the member,
    or over the batch, may be returned without those axes. What an element returns is checked when it is added to a
    frame, see `linkframe.framework.examined`.

    Attributes
    ----------
    segments
        Number of equal parts into which the framework divides the member; 1 by default.
    releases
        End components that carry no force, as pairs ``(end, component)``, end 0 or 1, component 0 to 5; none by
        default.

    Examples
    --------
    A truss bar, which carries an axial force only, by its section law.

    >>> from dataclasses import dataclass
    >>> import numpy as np
    >>> from linkframe.framework import Frame, LineElement, straight_shapes
    >>> @dataclass(frozen=True, eq=False)
    ... class Bar(LineElement):
    ...     EA: float
    ...     shape = ()
    ...
    ...     def section_flexibility(self, fraction):
    ...         return np.array([1.0 / self.EA, 0.0, 0.0, 0.0, 0.0, 0.0])
    ...
    ...     def shape_functions(self, length, x):
    ...         return straight_shapes(length, x)
    >>> frame = Frame()
    >>> for name, x in {"A": 0.0, "B": 2.0}.items():
    ...     frame.node(name, (x, 0.0, 0.0))
    >>> frame.add("AB", Bar(1e6), "A", "B")
    >>> frame.fix("A"); frame.load("B", fx=100.0)
    >>> float(frame.solve().displacement("B")[0].round(12))
    0.0002
    """

    segments: int = 1
    releases: tuple[tuple[int, int], ...] = ()

    # -- what it is -------------------------------------------------------------------------------------------------

    @property
    def kind(self) -> Hashable:
        """Key that is equal for elements with the same properties, evaluated once; by default the element itself."""
        return self

    @property
    def title(self) -> str:
        """Name of the element in error messages; the name of its class by default."""
        return type(self).__name__

    @property
    def family(self) -> Hashable | None:
        """Key that is equal for elements that differ in their numbers alone; None, as by default, for no such elements.

        Elements with equal keys are evaluated together, as one element whose parameters are arrays.
        """
        return None

    @property
    def exact(self) -> bool:
        """Whether one segment is exact in statics, so that dividing the member changes nothing; False by default."""
        return False

    @property
    def roundings(self) -> float:
        """Bound on the relative rounding error of the stiffnesses of `springs`, in units of 2^-53.

        It covers the computation of section properties from sizes as well.
        """
        return 100.0

    @property
    def balanced(self) -> bool | None:
        """Whether a rigid motion costs no energy; None, as by default, lets the frame find out."""
        return None

    @property
    def elementwise(self) -> bool:
        """Whether `springs` of many members together equal those of each member alone to the last bit."""
        return False

    @property
    def deforms_as(self) -> Hashable | None:
        """Key that is equal for elements with the same axes and deformations between the same ends, for any stiffness.

        None, as by default, where axes or deformations depend on the element's own numbers.
        """
        return None

    @property
    def formulas(self) -> SpringFormulas | None:
        """Formulas of the springs of an element with the default axes, for programs; None, as by default, for none."""
        return None

    @property
    def tension(self) -> Array:
        """Axial force in the unloaded shape that the loads on the nodes hold in equilibrium, (...); zero by default.

        It turns with the member, which matters in buckling and at large displacement. Linear statics takes account of
        it only through those loads.
        """
        return np.zeros(())

    def part(self, index: int, count: int) -> LineElement:
        """Part `index` of `count` equal parts of the member, with its share of releases and taper.

        By default the element itself; override it where the section law varies along the member.

        Parameters
        ----------
        index
            Which part, from 0.
        count
            Number of parts.

        Returns
        -------
        LineElement
            The element of a member of the length over `count`.
        """
        return self

    def unreleased(self) -> LineElement | None:
        """The same element without `releases`, as needed at large displacement; None where there is no such element.

        Returns
        -------
        LineElement or None
            By default the element itself if it has no releases, else None.
        """
        return None if self.releases else self

    def cut(self, change: Change) -> Self:
        """The element at some entries of its batch, by applying `change` to every parameter that is an array.

        The default is for dataclasses that hold nothing but their fields; metadata ``{"trailing": 1}`` marks a field
        whose last axis is no batch axis. It is called only if `shape` is not empty.

        Parameters
        ----------
        change
            ``change(array, trailing)`` takes the entries out of an array whose last `trailing` axes are no batch axes.

        Returns
        -------
        same type
            The element with the changed parameters, which are not checked again.

        Raises
        ------
        FrameError
            If the element is not a dataclass.
        """
        found: Self = changed(self, change)
        return found

    def check(self, chord: Array) -> None:
        """Refuse a direction that the member cannot have; by default every direction is allowed.

        Parameters
        ----------
        chord
            Vector from the first node to the second, (..., 3), length.

        Raises
        ------
        FrameError
            If the member cannot have that direction.
        """

    def axis_numbers(self, chord: Array) -> list[Array | float]:
        """The nine components of `axes` one by one, row by row.

        Parameters
        ----------
        chord
            Vector from the first node to the second, (..., 3), length.

        Returns
        -------
        list of ndarray or float
            Nine components, each (...); a float where it is the same for every member.
        """
        if type(self).axes is LineElement.axes:
            return default_axis_numbers(chord)
        axes = self.axes(chord)
        return [axes[..., row, column] for row in range(3) for column in range(3)]

    # -- springs and forces -----------------------------------------------------------------------------------------

    def spring_stiffness(self, length: Array) -> Array:
        """Stiffness of the springs alone.

        Parameters
        ----------
        length
            Length of the member, (...).

        Returns
        -------
        ndarray
            Stiffnesses as returned by `springs`, (..., n).
        """
        return self.springs(length)[0]

    def spring_numbers(self, length: Array) -> tuple[list[Array], dict[tuple[int, int], Array | float]]:
        """The values of `springs` one by one.

        Parameters
        ----------
        length
            Length of the member, (...).

        Returns
        -------
        tuple
            List of the stiffnesses of the springs, each (...); and a dict of their deformations per unit end
            displacement by pair (spring, end displacement 0 to 11), each (...), or a float where it is the same for
            every member. Pairs that are missing are zero for every member.
        """
        stiffness, rows = self.springs(length)
        count = rows.shape[-2]
        deformed: dict[tuple[int, int], Array | float] = {
            (spring, dof): rows[..., spring, dof] for spring in range(count) for dof in range(12)
        }
        return [stiffness[..., spring] for spring in range(count)], deformed

    def deformation_numbers(self, length: Array) -> dict[tuple[int, int], Array | float]:
        """The deformations of `spring_numbers` alone.

        Parameters
        ----------
        length
            Length of the member, (...).

        Returns
        -------
        dict
            By pair (spring, end displacement 0 to 11) its deformation, each (...), or a float where it is the same for
            every member.
        """
        return self.spring_numbers(length)[1]

    def end_force_numbers(self, length: Array, displacement: Sequence[Any]) -> Sequence[Any] | None:
        """The values of `end_forces` one by one, by arithmetic alone, so that it can be recorded as a program.

        Parameters
        ----------
        length
            Length of the member, (...).
        displacement
            The twelve end displacements in local axes: each an array (...), a float, or a term of a program.

        Returns
        -------
        sequence or None
            Twelve forces and moments of the same type as the displacements; None, as by default, where the element has
            no such formula.
        """
        return None

    def resistance(self, length: Array, deformation: Array, pick: Change) -> tuple[Array, Array, Array]:
        """Energy, forces and tangent stiffness at a deformation, of an element with a nonlinear law.

        Large displacement uses it in place of the stiffness. Linear solutions use the springs, with which its tangent
        at zero deformation must agree; `solution.linear` says whether they suffice. Forces must be the gradient of the
        energy, and the tangent its second derivative; the tangent must not couple deformations that the stiffness does
        not couple.

        Parameters
        ----------
        length
            Length of the member, (m,).
        deformation
            Elongation, then the rotations of the start and of the end about x, y and z, relative to the chord and the
            mean twist, (m, 7).
        pick
            ``pick(array, trailing)`` takes from a parameter, whose last `trailing` axes are no batch axes, the m rows
            that belong to the deformations.

        Returns
        -------
        energy, force, tangent
            Energy (m,), forces (m, 7) and tangent stiffness (m, 7, 7).
        """
        raise NotImplementedError

    @property
    def has_law(self) -> bool:
        """Whether the element defines a nonlinear law, `resistance`."""
        return type(self).resistance is not LineElement.resistance


class PointElement(ABC):
    """Mass and rotary inertia at one node.

    Examples
    --------
    A block of 2 kg without rotary inertia.

    >>> import numpy as np
    >>> from linkframe.framework import Frame, PointElement
    >>> class Block(PointElement):
    ...     shape = ()
    ...
    ...     def mass_matrix(self):
    ...         return np.diag([2.0, 2.0, 2.0, 0.0, 0.0, 0.0])
    >>> frame = Frame()
    >>> frame.node("A", (0.0, 0.0, 0.0)); frame.fix("A")
    >>> frame.add("block", Block(), "A")
    >>> frame.gravity((0.0, 0.0, -9.81))
    >>> float(frame.solve().reaction("A")[2].round(9))
    19.62
    """

    @property
    @abstractmethod
    def shape(self) -> tuple[int, ...]:
        """Batch shape of the element's own parameters."""

    @abstractmethod
    def mass_matrix(self) -> Array:
        """Mass matrix of the node in global axes.

        Returns
        -------
        ndarray
            Symmetric matrix by ``ux uy uz rx ry rz``, (..., 6, 6).
        """
