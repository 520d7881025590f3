"""Results that every solution of a frame has, of linear theory or at large displacement."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Sequence
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..batch import Array, Shape, finite, rotated
from ..clearances.contact import Contact
from ..description import Description
from ..dofs import DISPLACEMENTS
from ..errors import FrameError, expected_mechanisms
from ..listing import counted, html_table, number
from ..names import found
from ..provenance import regular_there
from ..states import SolutionState, States, among

# Up to this many nodal displacements (nodes times batch entries) are computed for the table in a notebook.
SHOWN_AT_ONCE = 100_000


class Recovered(Protocol):
    """Results at stations (..., k) along a member, distances from its start."""

    def forces(self, member: str, at: Array) -> Array:
        """Internal forces (..., k, 6)."""
        ...

    def stress(self, member: str, at: Array) -> Array:
        """Extreme stresses (..., k, 3)."""
        ...


class HasStackedResults(Protocol):
    """Results of all nodes or members at once, as stacked arrays."""

    def displacements(self) -> Array:
        """Displacements of all nodes, (..., nodes, 6)."""
        ...

    def end_forces(self) -> Array:
        """End forces of all members, (..., members, 12)."""
        ...

    def displacements_at(self, fraction: Array) -> Array:
        """Displacements at fractions (k,) of the lengths of all members, (..., members, k, 6)."""
        ...

    def forces_at(self, fraction: Array) -> Array:
        """Internal forces at fractions (k,) of the lengths of all members, (..., members, k, 6)."""
        ...

    def stresses_at(self, fraction: Array) -> Array:
        """Extreme stresses at fractions (k,) of the lengths of all members, (..., members, k, 3)."""
        ...


class AllResults(NamedTuple):
    """Results of all nodes, supports, joints and members of a frame, in the order of its description.

    Attributes
    ----------
    displacements
        Displacements and rotations of the nodes, ``ux uy uz rx ry rz`` in global axes, (..., nodes, 6).
    reactions
        Forces and moments of the supports on their nodes, ``fx fy fz mx my mz`` in global axes, (..., supports, 6).
    joint_displacements
        Displacements of the second nodes of joints relative to the first, in the joints' axes, (..., joints, 6).
    joint_forces
        Forces and moments of the joints on their first nodes, in the joints' axes, (..., joints, 6).
    end_forces
        Forces and moments on the start and the end of each member, in its local axes, (..., members, 12).
    """

    displacements: Array
    reactions: Array
    joint_displacements: Array
    joint_forces: Array
    end_forces: Array


class Results(ABC):
    """Results by name, each of the frame's batch shape.

    Attributes
    ----------
    frame
        The description as it was when solved.
    """

    frame: Description

    @property
    def shape(self) -> Shape:
        """Batch shape."""
        return self.frame.shape

    def __repr__(self) -> str:
        # Printing must not solve anything: states are counted only if they are known already.
        known = {"state", "own_state"} & vars(self).keys()
        text = f": {counted(self.state, SolutionState)}" if known else ""
        return f"<{type(self).__name__} of {self.frame!r}{text}>"

    def _repr_html_(self) -> str:
        """Table for a notebook: the greatest displacement of each node over the batch, and how many entries have each
        state.
        """
        nodes = list(self.frame.nodes)
        if len(nodes) * int(np.prod(self.shape)) > SHOWN_AT_ONCE:
            return html_table(repr(self), ["node"], [[name] for name in nodes])
        with expected_mechanisms():
            size = np.abs(np.broadcast_to(self.displacements(), (*self.shape, len(nodes), 6)))
            text = f"{type(self).__name__} of shape {self.shape}: {counted(self.state, SolutionState)}"
        most = size.max(axis=tuple(range(size.ndim - 2)), initial=0.0, where=np.isfinite(size))
        rows = [[name, *map(number, row)] for name, row in zip(nodes, most.tolist(), strict=True)]
        title = f"{text}. Greatest displacement and rotation (rad) of each node, without sign:"
        return html_table(title, ["node", *DISPLACEMENTS], rows)

    # -- what each kind of solution defines --------------------------------------------------------------------------

    @property
    @abstractmethod
    def status(self) -> NDArray[np.str_]:
        """State of each batch entry in words, (...)."""

    @property
    @abstractmethod
    def state(self) -> States:
        """`status` as numbers, (...): see `linkframe.framework.SolutionState`."""

    @property
    def is_regular(self) -> NDArray[np.bool_]:
        """Whether all results hold, (...): the entry is regular, or at large displacement stable."""
        stable = SolutionState.STABLE, SolutionState.STABLE_BEYOND_A_SADDLE
        return among(self.state, SolutionState.REGULAR, *stable) & regular_there(self.frame.made_from)

    @property
    def is_singular(self) -> NDArray[np.bool_]:
        """Whether the frame is a mechanism, statically consistent or kinematically unstable, (...)."""
        return among(self.state, SolutionState.MECHANISM, SolutionState.STATICALLY_CONSISTENT_MECHANISM)

    @abstractmethod
    def displacement(self, node: str) -> Array:
        """Displacement and rotation of a node in global axes, (..., 6)."""

    @abstractmethod
    def displacement_along(self, member: str, at: ArrayLike) -> Array:
        """Displacement and rotation along a member in global axes, (..., k, 6)."""

    @abstractmethod
    def joint_displacement(self, joint: str) -> Array:
        """Displacement of a joint's second node relative to its first, (..., 6)."""

    @abstractmethod
    def joint_force(self, joint: str) -> Array:
        """Force and moment that a joint exerts on its first node, (..., 6)."""

    @abstractmethod
    def end_forces(self, member: str) -> Array:
        """Forces and moments on the ends of a member in its local axes, (..., 12)."""

    @abstractmethod
    def reaction(self, node: str) -> Array:
        """Force and moment of a support on its node in global axes, (..., 6)."""

    @property
    @abstractmethod
    def _recovery(self) -> Recovered: ...

    @abstractmethod
    def _masked(self, array: Array) -> Array: ...

    # -- what all solutions share ------------------------------------------------------------------------------------

    def forces(self, member: str, at: ArrayLike) -> Array:
        """Internal forces along a member: those that the part towards its end exerts on the part towards its start.

        A tension N is positive.

        Parameters
        ----------
        member
            Name of the member.
        at
            Distances from the start of the undeformed member, (..., k), length; they may vary over the batch.

        Returns
        -------
        ndarray
            Normal force, shear forces, torque and bending moments ``N Vy Vz T My Mz``, (..., k, 6), in local axes; at
            large displacement in axes that follow the chord of the segment.

        Examples
        --------
        A cantilever of 1 m under 10 N across and 5 N along: N and Mz at the clamp and in the middle.

        >>> from linkframe.elements import Beam, Circle, Material
        >>> from linkframe.framework import Frame
        >>> frame = Frame()
        >>> for name, x in {"A": 0.0, "B": 1.0}.items():
        ...     frame.node(name, (x, 0.0, 0.0))
        >>> frame.add("AB", Beam(Circle(diameter=0.02), Material(E=200e9, nu=0.3)), "A", "B")
        >>> frame.fix("A"); frame.load("B", fx=5.0, fy=10.0)
        >>> frame.solve().forces("AB", [0.0, 0.5])[:, [0, 5]].round(9).tolist()
        [[5.0, 10.0], [5.0, 5.0]]
        """
        return self._masked(self._recovery.forces(self._member(member), np.atleast_1d(at)))

    def stress(self, member: str, at: ArrayLike) -> Array:
        """Extreme stresses of the section along a member.

        Parameters
        ----------
        member
            Name of the member.
        at
            Distances from the start of the undeformed member, (..., k), length; they may vary over the batch.

        Returns
        -------
        ndarray
            Least and greatest normal stress and greatest von Mises stress, (..., k, 3), force per area.

        Examples
        --------
        The clamp of a cantilever, ``s = M / W`` with ``W = b h^2 / 6`` (Timoshenko, *Strength of Materials* I).

        >>> from linkframe.elements import Beam, Material, Rectangle
        >>> from linkframe.framework import Frame
        >>> frame = Frame()
        >>> for name, x in {"A": 0.0, "B": 1.0}.items():
        ...     frame.node(name, (x, 0.0, 0.0))
        >>> frame.add("AB", Beam(Rectangle(y=0.02, z=0.015), Material(E=200e9, nu=0.3)), "A", "B")
        >>> frame.fix("A"); frame.load("B", fy=10.0)
        >>> (frame.solve().stress("AB", [0.0])[0] / 1e6).round(6).tolist()
        [-10.0, 10.0, 10.0]
        """
        return self._masked(self._recovery.stress(self._member(member), np.atleast_1d(at)))

    # -- all at once ------------------------------------------------------------------------------------------------

    def all_results(self) -> AllResults:
        """Compute the results of all nodes, supports, joints and members, over a long batch in a single pass.

        Returns
        -------
        AllResults
            Displacements, reactions, displacements and forces of joints, and forces on the ends of members.

        Examples
        --------
        A cantilever under 10 N at its end: the reaction, and the force on the start of the member.

        >>> from linkframe.elements import Beam, Circle, Material
        >>> from linkframe.framework import Frame
        >>> frame = Frame()
        >>> for name, x in {"A": 0.0, "B": 1.0}.items():
        ...     frame.node(name, (x, 0.0, 0.0))
        >>> frame.add("AB", Beam(Circle(diameter=0.02), Material(E=200e9, nu=0.3)), "A", "B")
        >>> frame.fix("A"); frame.load("B", fy=-10.0)
        >>> found = frame.solve().all_results()
        >>> found.reactions[0].round(9).tolist(), found.end_forces[0, [1, 5]].round(9).tolist()
        ([0.0, 10.0, 0.0, 0.0, 0.0, 10.0], [10.0, 10.0])
        """
        return AllResults(*self._all_of(*AllResults._fields))

    def displacements(self) -> Array:
        """Displacement and rotation of every node in global axes, in the order of ``frame.nodes``.

        Returns
        -------
        ndarray
            ``ux uy uz rx ry rz``, (..., nodes, 6), length and radians.
        """
        return self._all_of("displacements")[0]

    def reactions(self) -> Array:
        """Force and moment of every support on its node in global axes, in the order of ``frame.supports``.

        Returns
        -------
        ndarray
            ``fx fy fz mx my mz``, (..., supports, 6); zero in components that are not supported.
        """
        return self._all_of("reactions")[0]

    def all_end_forces(self) -> Array:
        """Force and moment on each end of every member in its local axes, in the order of ``frame.members``.

        Returns
        -------
        ndarray
            ``fx fy fz mx my mz`` at the start and then at the end, (..., members, 12).
        """
        return self._all_of("end_forces")[0]

    def displacements_at(self, fractions: ArrayLike) -> Array:
        """Displacement and rotation along every member in global axes, in the order of ``frame.members``.

        Parameters
        ----------
        fractions
            Distances from the start as fractions of the length, 0 to 1, (k,).

        Returns
        -------
        ndarray
            ``ux uy uz rx ry rz``, (..., members, k, 6), length and radians.
        """
        return self._along_all("displacements_at", self.displacement_along, fractions, 6)

    def forces_at(self, fractions: ArrayLike) -> Array:
        """Internal forces along all members, in the order of ``frame.members``; see `forces` for a single one.

        Parameters
        ----------
        fractions
            Distances from the start as fractions of the length, 0 to 1, (k,).

        Returns
        -------
        ndarray
            ``N Vy Vz T My Mz``, (..., members, k, 6); NaN for members whose element has no internal forces.
        """
        return self._along_all("forces_at", self.forces, fractions, 6)

    def stresses_at(self, fractions: ArrayLike) -> Array:
        """Extreme stresses along all members, in the order of ``frame.members``.

        Parameters
        ----------
        fractions
            Distances from the start as fractions of the length, 0 to 1, (k,).

        Returns
        -------
        ndarray
            Least and greatest normal stress and greatest von Mises stress, (..., members, k, 3), force per area; NaN
            for members without stresses, such as those whose section is given by its properties alone.
        """
        return self._along_all("stresses_at", self.stress, fractions, 3)

    @property
    @abstractmethod
    def journals(self) -> list[str]:
        """Names of the joints whose clearance is taken into account."""

    @abstractmethod
    def contact(self, joint: str) -> Contact:
        """Contact of a joint with clearance: its state, side, force and gap."""

    @abstractmethod
    def section_axes_at(self, fractions: ArrayLike) -> Array:
        """Axes to which `forces_at` refers, as rows in global components, (..., members, k or 1, 3, 3)."""

    def joint_global(self, joint: str, vectors: Array) -> Array:
        """Transform vectors from a joint's axes to global axes.

        Parameters
        ----------
        joint
            Name of the joint.
        vectors
            Vectors (..., 3) in the joint's axes, or pairs of vectors (..., 6).

        Returns
        -------
        ndarray
            The same in global axes, (..., 3) or (..., 6).
        """
        axes = self.frame.joints[joint].element.axes
        return vectors if axes is None else rotated(axes, vectors)

    @property
    def _stacked_results(self) -> HasStackedResults | None:
        """Results of all nodes and members as stacked arrays; None where they are computed one by one."""
        return None

    def _all_of(self, *kinds: str) -> list[Array]:
        """The named fields of `AllResults`, from stacked arrays where there are, else one by one."""
        frame = self.frame
        one_by_one: dict[str, tuple[Iterable[str], Callable[[str], Array], int]] = {
            "displacements": (frame.nodes, self.displacement, 6),
            "reactions": (frame.supports, self.reaction, 6),
            "joint_displacements": (frame.joints, self.joint_displacement, 6),
            "joint_forces": (frame.joints, self.joint_force, 6),
            "end_forces": (frame.members, self.end_forces, 12),
        }
        by_stacks = {"displacements", "end_forces"}.intersection(kinds)
        # stacked arrays need the displacements of all nodes, which a few supports and joints do not
        stacks = self._stacked_results if by_stacks else None
        found = []
        for kind in kinds:
            if stacks is not None and kind in by_stacks:
                found.append(self._masked(getattr(stacks, kind)()))
            else:
                names, result, size = one_by_one[kind]
                found.append(self._stacked([result(name) for name in names], size))
        return found

    def _along_all(self, name: str, result: Callable[[str, Array], Array], fractions: ArrayLike, size: int) -> Array:
        """A result along all members, from stacked arrays or else one by one, (..., members, k, size)."""
        at = checked_fractions(fractions)
        if (whole := self._stacked_results) is not None:
            return self._masked(getattr(whole, name)(at))
        return self._each(result, at, size)

    def _each(self, result: Callable[[str, Array], Array], at: Array, size: int) -> Array:
        """A result along each member at the same fractions (k,) of its length, (..., members, k, size)."""
        found = []
        for name in self.frame.members:
            try:
                found.append(result(name, self.frame.length(name)[..., None] * at))
            except FrameError:  # asking for the member alone raises it with the reason
                found.append(np.full((len(at), size), np.nan))
        return self._stacked(found, len(at), size)

    def _stacked(self, arrays: Sequence[Array], *trailing: int) -> Array:
        """Broadcast n arrays (..., *trailing) over the batch and stack them, (..., n, *trailing)."""
        if not arrays:
            return np.zeros((*self.shape, 0, *trailing))
        full = [np.broadcast_to(array, (*self.shape, *trailing)) for array in arrays]
        return np.stack(full, axis=len(self.shape))

    # -- names ------------------------------------------------------------------------------------------------------

    def _node(self, node: str) -> str:
        """The name by which a node is described, from that name or an alias."""
        return self.frame._node(node)

    def _supported(self, node: str) -> str:
        node = self._node(node)
        if node not in self.frame.supports:
            supported = ", ".join(self.frame.supports) or "none"
            raise FrameError(f"node {node!r} has no support: reactions are at {supported}")
        return node

    def _member(self, member: str) -> str:
        return found("member", member, self.frame.members)

    def _joint(self, joint: str) -> str:
        return found("joint", joint, self.frame.joints)

    def _with_clearance(self, joint: str, known: Sequence[str]) -> str:
        """The name of a joint, which must be among those whose clearance is taken into account."""
        name = self._joint(joint)
        if name not in known:
            text = ", ".join(known) or "none, or they were left out"
            raise FrameError(f"contact in joint {name!r}, which has no clearance: those with one are {text}")
        return name


def checked_fractions(given: ArrayLike) -> Array:
    """Fractions of a length as an array (k,), each checked to lie between 0 and 1."""
    what = "fractions of the members' lengths"
    at = finite(np.atleast_1d(given), what)
    if at.ndim != 1 or not at.size or at.min() < 0.0 or at.max() > 1.0:
        raise FrameError(f"{what} are {at.tolist()}: give numbers from 0 to 1, (k,)")
    return at
