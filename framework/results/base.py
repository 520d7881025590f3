"""Results that every solution of a frame has, of linear theory or at large displacement."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import ArrayLike

from ..batch import Array, finite
from ..dofs import DISPLACEMENTS
from ..errors import FrameError, expected_mechanisms
from ..listing import counted, html_table, number
from ..states import SolutionState
from .by_name import ResultsByName

# Up to this many nodal displacements (nodes times batch entries) are computed for the table in a notebook.
SHOWN_AT_ONCE = 100_000


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


class Results(ResultsByName):
    """Results of each node, member, joint and support by name, and of all of them at once."""

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


def checked_fractions(given: ArrayLike) -> Array:
    """Fractions of a length as an array (k,), each checked to lie between 0 and 1."""
    what = "fractions of the members' lengths"
    at = finite(np.atleast_1d(given), what)
    if at.ndim != 1 or not at.size or at.min() < 0.0 or at.max() > 1.0:
        raise FrameError(f"{what} are {at.tolist()}: give numbers from 0 to 1, (k,)")
    return at
