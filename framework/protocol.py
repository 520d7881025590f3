"""What the framework asks of an element; it knows nothing else about beams, joints or masses.

All arrays are stacks: batch axes first, components last. Forces and displacements of a line
element are in its local axes, start node before end node, each ``ux uy uz rx ry rz``.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Hashable, Sequence
from typing import Any, Self, TypeVar

import numpy as np
from numpy.typing import NDArray

from .entries import Change
from .orientation import default_axes, default_axis_numbers
from .section_law import SectionLaw
from .shape_rules import summed
from .stacking import changed

Array = NDArray[np.float64]
_Element = TypeVar("_Element", bound=type)
_PROVEN = "_proven"


def proven(kind: _Element) -> _Element:
    """Mark a class of elements whose answers its own tests prove, so that a frame need not examine them.

    A subclass is examined, as it may answer otherwise.
    """
    setattr(kind, _PROVEN, kind)
    return kind


def is_proven(element: object) -> bool:
    """Whether the class of an element is marked as `proven` itself."""
    return getattr(type(element), _PROVEN, None) is type(element)


class LineElement(SectionLaw):
    """A straight member between two nodes: stiffness, mass and recovery in its own axes.

    A subclass gives `shape`, `shape_functions` and what makes its stiffness: a section law, `section_flexibility`, or
    `springs`. All else follows by default: matrices, loads and forces by quadrature of the shape functions and the
    section law, as scikit-fem forms (`linkframe.elements.forms`) where they are assembled as a matrix. What has a
    closed form overrides them, and so does an element whose axes, kind, mass or stress are others. What does not vary
    along the member, or over the batch, may be returned without these axes. What an element returns is examined when it
    is added to a frame, see `linkframe.framework.examined`.

    Attributes
    ----------
    segments
        Number of equal parts into which the framework cuts the member; 1 by default.
    releases
        Released end components as ``(end, component)``, end 0 or 1, component 0 to 5; none by default.

    Examples
    --------
    A bar that carries nothing but its axial force, by its section law.

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
        """Equal for two elements that answer alike, so that one is asked for both; by default the element itself."""
        return self

    @property
    def title(self) -> str:
        """How messages name the element; its class by default."""
        return type(self).__name__

    @property
    def family(self) -> Hashable | None:
        """Equal for elements that differ in their numbers alone; None where each kind is evaluated by itself.

        Those are evaluated as one element whose parameters are arrays.
        """
        return None

    @property
    def exact(self) -> bool:
        """Whether in statics one piece is exact, so that segments change nothing; by default it is not."""
        return False

    @property
    def roundings(self) -> float:
        """Roundings, half a unit in the last place each, that the stiffnesses of `springs` may be off.

        What derives a section's properties from its sizes counts as well.
        """
        return 100.0

    @property
    def balanced(self) -> bool | None:
        """Whether a rigid motion costs nothing; None where a frame is to find out."""
        return None

    @property
    def elementwise(self) -> bool:
        """Whether `springs` of a stack of members are to the last bit those of each member alone."""
        return False

    @property
    def deforms_as(self) -> Hashable | None:
        """Equal for elements that have the same axes and deformations between the same ends, whatever their stiffness.

        None where numbers of theirs have a part in these, so that each is asked.
        """
        return None

    @property
    def tension(self) -> Array:
        """Axial force at rest, (...), which turns with the member, and with which the frame is loaded at its nodes.

        Linear statics has it from the loads alone.
        """
        return np.zeros(())

    def part(self, index: int, count: int) -> LineElement:
        """Part `index` of `count` equal parts, with the releases and taper that fall to it.

        By default a part is as the whole; where the section law varies along the member, give its own method.

        Parameters
        ----------
        index
            Which part, from 0.
        count
            Number of parts.

        Returns
        -------
        LineElement
            Of the length over `count`.
        """
        return self

    def unreleased(self) -> LineElement | None:
        """The same element without `releases`, which large displacement follows; None where it has none such.

        Returns
        -------
        LineElement or None
            By default itself where it has no releases.
        """
        return None if self.releases else self

    def cut(self, change: Change) -> Self:
        """The element at some entries of its batch: with every parameter that is an array changed.

        This is for dataclasses that hold nothing but their fields; metadata ``{"trailing": 1}`` tells of a field that
        its last axis is no batch axis. It is asked for only where `shape` has an axis.

        Parameters
        ----------
        change
            What takes the entries out of an array, given the array and the number of its axes that are no batch axes.

        Returns
        -------
        same type
            The element, its numbers changed and not checked again.

        Raises
        ------
        FrameError
            If it is no dataclass.
        """
        found: Self = changed(self, change)
        return found

    def check(self, chord: Array) -> None:
        """Refuse a direction in which the member cannot lie; by default it can lie anyhow.

        Parameters
        ----------
        chord
            From the first node to the second, (..., 3).

        Raises
        ------
        FrameError
            Where it cannot.
        """

    def axes(self, chord: Array) -> Array:
        """Local axes of a member as rows x, y, z.

        By default z is as near to global z as can be; a member along global z has its local y along global y.

        Parameters
        ----------
        chord
            From the first node to the second, (..., 3).

        Returns
        -------
        ndarray
            Unit vectors in global components, (..., 3, 3), in the precision of the chord.
        """
        return default_axes(chord)

    def axis_numbers(self, chord: Array) -> list[Array | float]:
        """The numbers of `axes` one by one, row by row.

        Parameters
        ----------
        chord
            From the first node to the second, (..., 3).

        Returns
        -------
        list of ndarray or float
            Nine, each (...); a float where it is the same for every member.
        """
        if type(self).axes is LineElement.axes:
            return default_axis_numbers(chord)
        axes = self.axes(chord)
        return [axes[..., row, column] for row in range(3) for column in range(3)]

    # -- matrices and forces ----------------------------------------------------------------------------------------

    def stiffness_matrix(self, length: Array) -> Array:
        """Stiffness in local axes: the sum of its own springs, or the scikit-fem form of the section law.

        Parameters
        ----------
        length
            Length of the member, (...).

        Returns
        -------
        ndarray
            Forces and moments at both ends by their displacements and rotations, (..., 12, 12).
        """
        if not self.has_springs:
            found: Array = _integrals().integrated_stiffness(self, length)
            return found
        stiffness, rows = self.springs(np.asarray(length, dtype=np.float64))
        return summed(stiffness, rows)

    def spring_stiffness(self, length: Array) -> Array:
        """Stiffness of the springs alone.

        Parameters
        ----------
        length
            Length of the member, (...).

        Returns
        -------
        ndarray
            The first of `springs`, (..., springs).
        """
        return self.springs(length)[0]

    def spring_numbers(self, length: Array) -> tuple[list[Array], dict[tuple[int, int], Array | float]]:
        """The numbers of `springs` one by one.

        Parameters
        ----------
        length
            Length of the member, (...).

        Returns
        -------
        tuple
            Stiffness of each spring, (...), and by spring and end displacement (0 to 11) how much it deforms: (...), or
            a float where that is the same for every member. What is left out is zero for every member.
        """
        stiffness, rows = self.springs(length)
        count = rows.shape[-2]
        deformed: dict[tuple[int, int], Array | float] = {
            (spring, dof): rows[..., spring, dof] for spring in range(count) for dof in range(12)
        }
        return [stiffness[..., spring] for spring in range(count)], deformed

    def mass_matrix(self, length: Array) -> Array:
        """Consistent mass in local axes, by the scikit-fem form of `section_inertia`.

        Parameters
        ----------
        length
            Length of the member, (...).

        Returns
        -------
        ndarray
            Inertia of both ends, (..., 12, 12).
        """
        found: Array = _integrals().integrated_mass(self, length)
        return found

    def geometric_matrix(self, length: Array, axial: Array) -> Array:
        """Geometric stiffness under an axial force in local axes, by the scikit-fem form of `section_sway`.

        Parameters
        ----------
        length
            Length of the member, (...).
        axial
            Axial force, (...), tension positive.

        Returns
        -------
        ndarray
            By the end displacements, (..., 12, 12).
        """
        found: Array = _integrals().integrated_geometric(self, length, axial)
        return found

    def end_forces(self, length: Array, displacement: Array) -> Array:
        """Force and moment on each end of the member, by way of its deformations.

        Parameters
        ----------
        length
            Length of the member, (...).
        displacement
            End displacements in local axes, (..., 12).

        Returns
        -------
        ndarray
            ``fx fy fz mx my mz`` at the start and then at the end, (..., 12), in local axes: the stiffness times the
            displacement.
        """
        stiffness, rows = self.springs(np.asarray(length, dtype=np.float64))
        pulls = stiffness * (rows @ np.asarray(displacement)[..., None])[..., 0]
        out: Array = (pulls[..., None, :] @ rows)[..., 0, :]
        return out

    def end_force_numbers(self, length: Array, displacement: Sequence[Any]) -> Sequence[Any] | None:
        """The numbers of `end_forces` one by one, by arithmetic alone, so that a program can be written of it.

        Parameters
        ----------
        length
            Length of the member, (...).
        displacement
            The twelve end displacements in local axes: each (...), a float, or a term of a program.

        Returns
        -------
        sequence or None
            Twelve of the kind that they were given as; None, as by default, where the element has no such formula.
        """
        return None

    def resistance(self, length: Array, deformation: Array, pick: Change) -> tuple[Array, Array, Array]:
        """Energy, force and tangent at a deformation, of an element with a law of its own.

        Large displacement follows it in place of the stiffness; linear solutions follow the springs, with which it must
        agree at rest, and `solution.linear` says how far. Forces must be the gradient of the energy, and the tangent
        its second derivative; it couples no other deformations than the stiffness does.

        Parameters
        ----------
        length
            Length of the member, (m,).
        deformation
            Elongation, and the rotation of the start and of the end, each about x, y and z, from the chord and the mean
            twist, (m, 7).
        pick
            ``pick(array, trailing)`` takes the m rows of a parameter that belong to the deformations.

        Returns
        -------
        energy, force, tangent
            (m,), (m, 7) and (m, 7, 7).
        """
        raise NotImplementedError

    @property
    def has_law(self) -> bool:
        """Whether it has a law of its own, `resistance`."""
        return type(self).resistance is not LineElement.resistance


class PointElement(ABC):
    """Inertia at one node.

    Examples
    --------
    A block that weighs 2 kg and has no inertia against rotation.

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
        """Inertia of the node in global axes.

        Returns
        -------
        ndarray
            By ``ux uy uz rx ry rz``, (..., 6, 6), symmetric.
        """


def _integrals() -> Any:
    """Quadrature in scikit-fem, which takes longer to load than all that describes a frame."""
    from .scikit_fem import integrals

    return integrals
