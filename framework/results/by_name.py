"""Results of a frame by name: of one node, member, joint or support."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..batch import Array, Shape, rotated
from ..clearances.contact import Contact
from ..description import Description
from ..errors import FrameError
from ..listing import counted
from ..names import found
from ..provenance import regular_there
from ..states import SolutionState, States, among


class Recovered(Protocol):
    """Results at stations (..., k) along a member, distances from its start."""

    def forces(self, member: str, at: Array) -> Array:
        """Internal forces (..., k, 6)."""
        ...

    def stress(self, member: str, at: Array) -> Array:
        """Extreme stresses (..., k, 3)."""
        ...


class ResultsByName(ABC):
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
