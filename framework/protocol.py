"""What the framework asks of an element; it knows nothing else about beams, joints or masses.

All arrays are stacks: batch axes first, components last. Forces and displacements of a line
element are in its local axes, start node before end node, each ``ux uy uz rx ry rz``.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Hashable, Iterable, Sequence
from dataclasses import fields, is_dataclass
from itertools import repeat
from typing import Any, Self, TypeVar

import numpy as np
from numpy.typing import NDArray

from .batch import aligned
from .clearances.contact import law
from .entries import Change
from .errors import FrameError
from .orientation import default_axes
from .shape_rules import gauss, gradients, section_springs, summed

Array = NDArray[np.float64]
_Element = TypeVar("_Element", bound=type)
_Stacked = TypeVar("_Stacked")
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


class LineElement(ABC):
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

    # -- what every element gives -----------------------------------------------------------------------------------

    @property
    @abstractmethod
    def shape(self) -> tuple[int, ...]:
        """Batch shape of the element's own parameters."""

    @abstractmethod
    def shape_functions(self, length: Array, x: Array) -> Array:
        """Displacement at a distance from the start for unit end displacements.

        At the ends the displacement, not always the rotation, is that of the nodes. Where the stiffness follows from a
        section law they come in the precision of `length`, and hold every rigid motion.

        Parameters
        ----------
        length
            Length of the member, (...).
        x
            Distance from the start, (...).

        Returns
        -------
        ndarray
            ``ux uy uz rx ry rz`` there by the twelve of the ends, in local axes, (..., 6, 12).
        """

    def section_flexibility(self, fraction: Array) -> Array:
        """Strain and curvature per unit ``N Vy Vz T My Mz`` at a fraction of the length.

        A component without flexibility deforms nothing. Of an element that gives `springs` zero by default, so that
        its displacement between the nodes follows its ends.

        Parameters
        ----------
        fraction
            Distance from the start over the length, 0 to 1, (...).

        Returns
        -------
        ndarray
            One over the stiffness of the section, such as ``1 / (E A)``, in each of the six, (..., 6).
        """
        if not self.has_springs:
            raise NotImplementedError
        return np.zeros((*np.broadcast_shapes(np.shape(fraction), self.shape), 6))

    def springs(self, length: Array) -> tuple[Array, Array]:
        """The stiffness as any number n of springs k on deformations b of the member.

        ``K = sum_i k_i b_i b_i^T``, as by natural modes (Argyris, *Recent Advances in Matrix Methods of Structural
        Analysis*, 1964). The deformations come in the precision of `length`, as do `axes` in that of the
        chord: error bounds rest on it that a rigid motion costs no energy. A beam has six; where something outside the
        frame holds the member, as a foundation does, springs resist its rigid motion. By default they are those of the
        section law at the points of the quadrature.

        Parameters
        ----------
        length
            Length of the member, (...).

        Returns
        -------
        tuple of ndarray
            Stiffnesses k, (..., n), and deformations b by the end displacements, (..., n, 12).
        """
        return section_springs(self, length)

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
    def has_springs(self) -> bool:
        """Whether `springs` is its own and not that of the section law."""
        return type(self).springs is not LineElement.springs

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
    def tension(self) -> Array:
        """Axial force at rest, (...), which turns with the member, and with which the frame is loaded at its nodes.

        Linear statics has it from the loads alone.
        """
        return np.zeros(())

    @property
    def quadrature(self) -> int:
        """Gauss points that integrate a linear load times the shape functions to rounding; by default for cubics."""
        return 4

    @property
    def integration_points(self) -> tuple[Array, Array]:
        """Fractions of the length and weights, (points, ...), by which matrices are integrated."""
        return gauss(max(self.quadrature, 4))

    @property
    def sections_shape(self) -> tuple[int, ...]:
        """Batch shape of what the section law varies with."""
        return self.shape

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

    def check(self, chord: Array) -> None:  # noqa: B027
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

    # -- along the member -------------------------------------------------------------------------------------------

    def shape_gradients(self, length: Array, x: Array) -> Array:
        """Derivative of `shape_functions` along the member.

        By default that of a polynomial up to the seventh degree.

        Parameters
        ----------
        length
            Length of the member, (...).
        x
            Distance from the start, (...).

        Returns
        -------
        ndarray
            ``ux' .. rz'`` there by the twelve end displacements, (..., 6, 12), per length.
        """
        return gradients(self, np.asarray(length), np.asarray(x) / length)

    def shape_rows(self, length: Array, fraction: Array) -> tuple[Array, Array]:
        """Both `shape_functions` and `shape_gradients`, at a fraction of the length.

        Parameters
        ----------
        length
            Length of the member, (...).
        fraction
            Distance from the start over the length, 0 to 1, (...).

        Returns
        -------
        tuple of ndarray
            Values and derivatives, (..., 6, 12) each.
        """
        return self.shape_functions(length, fraction * length), self.shape_gradients(length, fraction * length)

    def section_inertia(self, fraction: Array) -> Array:
        """Inertia per length that goes with each of ``ux .. rz``; by default of translation alone.

        Parameters
        ----------
        fraction
            Distance from the start over the length, 0 to 1, (...).

        Returns
        -------
        ndarray
            Mass per length three times, and its moments about x, y and z, (..., 6).
        """
        mass: Array = np.asarray(self.mass_per_length(fraction))[..., None] * np.array([1.0, 1.0, 1.0, 0.0, 0.0, 0.0])
        return mass

    def section_sway(self, fraction: Array) -> Array:
        """Weight of each of ``ux' .. rz'`` squared in twice the work of a unit axial force.

        Parameters
        ----------
        fraction
            Distance from the start over the length, 0 to 1, (...).

        Returns
        -------
        ndarray
            By default 1 for ``uy'`` and ``uz'`` and 0 for the others, (..., 6).
        """
        across = np.array([0.0, 1.0, 1.0, 0.0, 0.0, 0.0])
        return np.broadcast_to(across, (*np.broadcast_shapes(np.shape(fraction), self.shape), 6))

    def mass_per_length(self, fraction: Array) -> Array:
        """Mass per length at a fraction of the length; zero by default.

        Parameters
        ----------
        fraction
            Distance from the start over the length, 0 to 1, (...).

        Returns
        -------
        ndarray
            Mass over length there, (...).
        """
        return np.zeros(np.broadcast_shapes(np.shape(fraction), self.shape))

    def free_strain(self, fraction: Array) -> Array | None:
        """Strain and curvature without forces at a fraction of the length, such as by heat; None for none.

        They work with ``N Vy Vz T My Mz``, and strain the member beside what forces do: by `restrained_forces` they
        load the frame.

        Parameters
        ----------
        fraction
            Distance from the start over the length, 0 to 1, (...).

        Returns
        -------
        ndarray or None
            Of the six that work with ``N Vy Vz T My Mz``, (..., 6).
        """
        return None

    def restrained_forces(self, fraction: Array) -> Array | None:
        """Internal forces that undo the free strain, with their sign turned; None for none.

        By default the free strain divided by the section flexibility.

        Parameters
        ----------
        fraction
            Distance from the start over the length, 0 to 1, (...).

        Returns
        -------
        ndarray or None
            ``N Vy Vz T My Mz`` there, (..., 6).
        """
        strain = self.free_strain(fraction)
        if strain is None:
            return None
        flexibility = self.section_flexibility(fraction)
        strain, flexibility = np.broadcast_arrays(strain, flexibility)
        return np.divide(strain, flexibility, out=np.zeros(strain.shape), where=flexibility > 0.0)

    def stress(self, fraction: Array, forces: Array) -> Array:
        """Extreme stresses over the section at a fraction of the length.

        An element without a section, as by default, refuses.

        Parameters
        ----------
        fraction
            Distance from the start over the length, 0 to 1, (...).
        forces
            Internal forces ``N Vy Vz`` and moments ``T My Mz`` there, (..., 6).

        Returns
        -------
        ndarray
            Least and greatest normal stress and greatest von Mises stress, (..., 3), force per area.

        Raises
        ------
        FrameError
            If the element has no section.
        """
        raise FrameError(f"{type(self).__name__}: stress needs a section; ask for its forces")


class JointElement(ABC):
    """Six springs between two coincident nodes, in the joint's own axes, or a law of its own by `resistance`.

    Linear solutions follow the springs, and contact where there is clearance: a law must agree with them at rest, or it
    is refused there. What a joint returns is examined when it is added to a frame.

    Attributes
    ----------
    stiffness
        (..., 6), each 0 (free) to inf (ideal).
    axes
        (..., 3, 3), the joint's axes as columns in global components; None for the global axes.
    clearance
        (...), radius of the ball inside which the `clearance_directions` are free; 0 for none.
    clearance_directions
        Indices of these components, of equal stiffness; empty for none.
    pitch
        (...), advance along z per turn about z: the spring along z acts on what differs from it.
    """

    stiffness: Array
    axes: Array | None
    clearance: Array
    clearance_directions: tuple[int, ...]
    pitch: Array

    @property
    @abstractmethod
    def shape(self) -> tuple[int, ...]:
        """Batch shape of the element's own parameters."""

    @abstractmethod
    def matrix(self) -> Array:
        """Stiffness of the two nodes: what springs, axes and pitch make.

        Returns
        -------
        ndarray
            In global axes, first node before second, (..., 12, 12): force per length and moment per radian.
        """

    @abstractmethod
    def typical(self) -> JointElement:
        """The joint without clearance, each of its springs the stiffest in the batch.

        It has no batch of its own but that of its geometry.

        Returns
        -------
        JointElement
            Its stiffness (6,), its axes and pitch as they are.
        """

    def resistance(self, displacement: Array, pick: Change) -> tuple[Array, Array, Array]:
        """Energy, force and tangent at a displacement in the joint's axes: of springs, and of contact in clearances.

        A joint of another law overrides this; large displacement then follows it in place of the springs of all
        components that are not ideal. Forces must be the gradient of the energy, and the tangent its second derivative
        (where the force has a kink, that of either side).

        Parameters
        ----------
        displacement
            Displacement (m, 6) of the second node from the first, or from an imposed offset.
        pick
            ``pick(array, trailing)`` takes the m rows of a parameter that belong to the displacements.

        Returns
        -------
        energy, force, tangent
            (m,), (m, 6) and (m, 6, 6), see `linkframe.framework.clearances.contact.law`; nothing from ideal components.
        """
        springs = np.where(np.isinf(self.stiffness), 0.0, self.stiffness)
        free = list(self.clearance_directions)
        stiffness = pick(springs, 1) + 0.0 * displacement
        contact = stiffness[:, free[0]].copy() if free else np.zeros(len(displacement))
        stiffness[:, free] = 0.0
        energy, force = 0.5 * np.sum(stiffness * displacement**2, axis=-1), stiffness * displacement
        tangent = stiffness[:, :, None] * np.eye(6)
        if free:
            generalised_force, turning, stored = law(
                displacement[:, free], pick(self.clearance[..., None], 1)[:, 0], contact
            )
            force[:, free] = generalised_force
            tangent[np.ix_(range(len(force)), free, free)] = turning
            energy = energy + stored
        return energy, force, tangent

    @property
    def has_law(self) -> bool:
        """Whether `resistance` is its own and not that of springs and contact."""
        return type(self).resistance is not JointElement.resistance

    def springs_matrix(self) -> Array:
        """Stiffness that finite springs, axes and pitch make of the two nodes.

        Returns
        -------
        ndarray
            In global axes, first node before second, (..., 12, 12): force per length and moment per radian.
        """
        axes = np.eye(3) if self.axes is None else self.axes
        acts = np.zeros((*np.broadcast_shapes(axes.shape[:-2], self.pitch.shape), 6, 6))
        acts[..., :3, :3] = acts[..., 3:, 3:] = axes
        acts[..., 3:, 2] = -self.pitch[..., None] / (2.0 * np.pi) * axes[..., :, 2]
        # the products commute, so that the block is symmetric to the last bit
        dyads = acts[..., :, None, :] * acts[..., None, :, :]
        block = np.sum(self.stiffness[..., None, None, :] * dyads, axis=-1)
        near = np.concatenate([block, -block], axis=-1)
        return np.concatenate([near, -near], axis=-2)


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


def changed(described: Any, change: Change) -> Any:
    """A dataclass with its arrays changed, and those of the dataclasses in it; its numbers are not checked again."""
    if not is_dataclass(described):
        kind = type(described).__name__
        text = "make it one, or give it its own method cut(change)"
        raise FrameError(f"{kind} holds a batch but is no dataclass: {text}")
    clone = object.__new__(type(described))
    for each in fields(described):
        value = getattr(described, each.name)
        if isinstance(value, np.ndarray):
            value = change(value, each.metadata.get("trailing", 0))
        elif hasattr(value, "cut"):
            value = value.cut(change)
        elif is_dataclass(value):
            value = changed(value, change)
        object.__setattr__(clone, each.name, value)
    return clone


def stacked(elements: Sequence[_Stacked], ndim: int) -> _Stacked:
    """Dataclasses of one family as one, each number that differs an array (n, ...) with `ndim` batch axes behind."""
    clone = object.__new__(type(elements[0]))
    for each in fields(elements[0]):  # type: ignore[arg-type]
        values = [getattr(element, each.name) for element in elements]
        object.__setattr__(clone, each.name, _together(values, ndim, each.metadata.get("trailing", 0)))
    return clone


def _together(values: list[Any], ndim: int, trailing: int) -> Any:
    one = values[0]
    if all(value is one for value in values):
        return one
    if is_dataclass(one):
        return stacked(values, ndim)
    if all(type(value) is float for value in values):
        return one if len(set(values)) == 1 else np.array(values).reshape(-1, *(1,) * ndim)
    if isinstance(one, (float, np.ndarray)):
        arrays = [aligned(np.asarray(value), ndim, trailing) for value in values]
        return np.stack(np.broadcast_arrays(*arrays))
    return one  # names, switches and counts, which a family has in common or does not look at


def unstacked(element: Any, count: int) -> list[Any]:
    """A dataclass whose arrays have so many entries, or one, along their last batch axis as that many, one for each."""
    names, columns = [], []
    for each in fields(element):
        names.append(each.name)
        columns.append(_apart(getattr(element, each.name), count, each.metadata.get("trailing", 0)))
    out = []
    for values in zip(*columns, strict=True):
        clone = object.__new__(type(element))
        vars(clone).update(zip(names, values, strict=True))
        out.append(clone)
    return out


def _apart(value: Any, count: int, trailing: int) -> Iterable[Any]:
    if is_dataclass(value):
        return unstacked(value, count) if getattr(value, "shape", ()) else repeat(value, count)
    if not isinstance(value, np.ndarray) or value.ndim <= trailing:
        return repeat(value, count)
    entries = np.moveaxis(value, value.ndim - trailing - 1, 0)
    if len(entries) == 1:
        return repeat(_plain(entries[0]), count)
    return entries.tolist() if entries.ndim == 1 else list(entries)


def _plain(value: Any) -> Any:
    return value if np.ndim(value) else float(value)
