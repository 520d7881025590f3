"""Displacements, reactions and forces of a linear solution, by name of the node, member or joint."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from ..batch import Array
from ..batched.broadcast import BroadcastSolver
from ..clearances.contact import Contact
from ..results.force_numbers import ForceNumbers
from ..results.linear import OfRows
from ..results.parts import of_joint, of_member, of_node, of_part
from ..results.saved import SavedResults
from ..results.stacked_results import StackedResults
from ..structure.parts import Value
from ..structure.topology import Topology
from .states import FrameStates


class NamedResults(FrameStates):
    """Results of nodes, members, joints and supports, each from the connected part of the frame to which it belongs."""

    def part(self, node: str | None) -> Self:
        """The solution of the connected part of the frame that contains a node.

        Parts that no member, joint or tie connects are solved separately, each when it is first read.

        Parameters
        ----------
        node
            Name of the node.

        Returns
        -------
        Solution
            Solution of that part, which shares computed results with this one; this one where loads act on no other
            part.
        """
        if self.determinate is not None:
            return self  # loads reach no other part
        number = self.plan.topology.number.get(node or "")
        if number is None or self.plan.entry is not None or self.primary.solver.parts < 2:
            return self
        connected_component = int(self.plan.connected_components[number])
        if connected_component not in self._parts:
            primary = self.primary.part(number, lambda: self.movable)
            if primary is self.primary:
                return self
            part = type(self)(self.frame, primary.plan, self.clearances, primary)
            part._known, part._warned = self._known, self._warned
            self._parts[connected_component] = part
        return self._parts[connected_component]

    @of_part(of_node)
    def displacement(self, node: str) -> Array:
        """Displacement and rotation of a node in global axes.

        Parameters
        ----------
        node
            Name of the node.

        Returns
        -------
        ndarray
            ``ux uy uz rx ry rz``, (..., 6), length and radians.

        Examples
        --------
        The end of a rod under a tension of 1 kN, ``u = F L / E A`` (Timoshenko, *Strength of Materials* I).

        >>> from linkframe.elements import Beam, Rectangle, Material
        >>> from linkframe.framework import Frame
        >>> frame = Frame()
        >>> for name, x in {"A": 0.0, "B": 2.0}.items():
        ...     frame.node(name, (x, 0.0, 0.0))
        >>> frame.add("AB", Beam(Rectangle(y=0.01, z=0.01), Material(E=200e9, nu=0.3)), "A", "B")
        >>> frame.fix("A"); frame.load("B", fx=1000.0)
        >>> float(frame.solve().displacement("B")[0].round(12))
        0.0001
        """
        name = self._node(node)
        return self._read(("displacement", node), lambda: self._displacement(name))

    @of_part(of_joint)
    def joint_displacement(self, joint: str) -> Array:
        """Displacement of a joint's second node relative to its first, in the joint's axes.

        Parameters
        ----------
        joint
            Name of the joint.

        Returns
        -------
        ndarray
            ``ux uy uz rx ry rz``, (..., 6), length and radians; imposed offsets included.

        Examples
        --------
        A hinge with a rotational spring of 50 N m/rad under 1 N m.

        >>> from linkframe.elements import Joint
        >>> from linkframe.framework import Frame
        >>> frame = Frame()
        >>> frame.node("A", (0.0, 0.0, 0.0)); frame.node("B", (0.0, 0.0, 0.0))
        >>> frame.add("hinge", Joint(stiffness=(1e9, 1e9, 1e9, 1e6, 1e6, 50.0)), "A", "B")
        >>> frame.fix("A"); frame.load("B", mz=1.0)
        >>> solution = frame.solve()
        >>> float(solution.joint_displacement("hinge")[5].round(12)), float(solution.joint_force("hinge")[5].round(12))
        (0.02, 1.0)
        """
        self._joint(joint)
        return self._read(("joint", joint), lambda: self._settled(self._recovery.joint_rows(joint)))

    @of_part(of_member)
    def displacement_along(self, member: str, at: ArrayLike) -> Array:
        """Displacement and rotation along a member in global axes, with the deflection by loads between its nodes.

        Parameters
        ----------
        member
            Name of the member.
        at
            Distances from the member's start, (..., k), length; they may vary over the batch.

        Returns
        -------
        ndarray
            ``ux uy uz rx ry rz``, (..., k, 6), length and radians.

        Examples
        --------
        The middle of a beam on two supports, between its nodes: ``5 q L^4 / (384 E I)`` (Timoshenko, *Strength of
        Materials* I).

        >>> from linkframe.elements import Beam, Material, Section
        >>> from linkframe.framework import Frame
        >>> frame = Frame()
        >>> for name, x in {"A": 0.0, "B": 2.0}.items():
        ...     frame.node(name, (x, 0.0, 0.0))
        >>> frame.add("AB", Beam(Section(A=1.0, Iy=1.0, Iz=1.0, J=1.0), Material(E=1.0, nu=0.3)), "A", "B")
        >>> frame.fix("A", "ux", "uy", "uz", "rx"); frame.fix("B", "uy", "uz")
        >>> frame.line_load("AB", fy=-1.0)
        >>> bool(abs(frame.solve().displacement_along("AB", [1.0])[0, 1] + 5.0 * 2.0**4 / 384.0) < 1e-12)
        True
        """
        stations = np.atleast_1d(at)
        found = self._masked(self._recovery.displacement_along(self._member(member), stations))
        return (
            found
            if self.consistent_mechanisms is None
            else self._announced(found, self._recovery.moved_along(member, stations))
        )

    forces = of_part(of_member)(SavedResults.forces)
    stress = of_part(of_member)(SavedResults.stress)

    @of_part(of_member)
    def end_forces(self, member: str) -> Array:
        """Force and moment on each end of a member in its local axes.

        Parameters
        ----------
        member
            Name of the member.

        Returns
        -------
        ndarray
            ``fx fy fz mx my mz`` at the start and then at the end, (..., 12).

        Examples
        --------
        >>> from linkframe.elements import Beam, Circle, Material
        >>> from linkframe.framework import Frame
        >>> frame = Frame()
        >>> for name, x in {"A": 0.0, "B": 2.0}.items():
        ...     frame.node(name, (x, 0.0, 0.0))
        >>> frame.add("AB", Beam(Circle(diameter=0.02), Material(E=200e9, nu=0.3)), "A", "B")
        >>> frame.fix("A"); frame.load("B", fx=5.0, fy=10.0)
        >>> frame.solve().end_forces("AB")[[0, 1, 5, 6, 7]].round(9).tolist()
        [-5.0, -10.0, -20.0, 5.0, 10.0]
        """
        self._member(member)
        if (found := self.pressed) is not None:
            return found.without_clearance.end_forces(member)
        return self._read(("ends", member), lambda: self._recovery.end_forces(member))

    @of_part(of_node)
    def reaction(self, node: str) -> Array:
        """Force and moment of a support on its node in global axes.

        Parameters
        ----------
        node
            Name of the node.

        Returns
        -------
        ndarray
            Force ``fx fy fz`` and moment ``mx my mz``, (..., 6); zero in components without support. Redundant supports
            share it as ideal joints do, see `joint_force`.

        Raises
        ------
        FrameError
            If the node has no support.

        Examples
        --------
        >>> from linkframe.elements import Beam, Circle, Material
        >>> from linkframe.framework import Frame
        >>> frame = Frame()
        >>> for name, x in {"A": 0.0, "B": 1.0}.items():
        ...     frame.node(name, (x, 0.0, 0.0))
        >>> frame.add("AB", Beam(Circle(diameter=0.02), Material(E=200e9, nu=0.3)), "A", "B")
        >>> frame.fix("A"); frame.load("B", fy=-10.0)
        >>> frame.solve().reaction("A").round(9).tolist()
        [0.0, 10.0, 0.0, 0.0, 0.0, 10.0]
        """
        node = self._supported(node)
        if (found := self.pressed) is not None:
            return found.without_clearance.reaction(node)
        return self._read(("reaction", node), lambda: self._recovery.reaction(node))

    @of_part(of_joint)
    def joint_force(self, joint: str) -> Array:
        """Force and moment that a joint exerts on its first node, in the joint's axes.

        Parameters
        ----------
        joint
            Name of the joint.

        Returns
        -------
        ndarray
            ``fx fy fz mx my mz``, (..., 6): spring forces, and the constraint forces of ideal components. Where ideal
            joints and supports in a loop are redundant, equilibrium alone does not determine how they share the load;
            returned is then the equilibrium with the least sum of squares, moments being divided by the root mean
            square distance of the joints and supports of the loop from their centre. That is how joints and supports
            of equal stiffness share the load.

        Examples
        --------
        A ball joint passes a force on and no moment.

        >>> from linkframe.elements import Joint
        >>> from linkframe.framework import Frame
        >>> frame = Frame()
        >>> frame.node("A", (0.0, 0.0, 0.0)); frame.node("B", (0.0, 0.0, 0.0))
        >>> frame.add("ball", Joint(stiffness=(1e9, 1e9, 1e9, 0.0, 0.0, 0.0)), "A", "B")
        >>> frame.fix("A"); frame.fix("B", "rx", "ry", "rz"); frame.load("B", fx=3.0)
        >>> frame.solve().joint_force("ball").round(9).tolist()
        [3.0, 0.0, 0.0, 0.0, 0.0, 0.0]
        """
        self._joint(joint)
        if (found := self.pressed) is not None:
            return found.without_clearance.joint_force(joint)
        return self._read(("force", joint), lambda: self._recovery.joint_force(joint))

    def joint_components(self, pairs: Sequence[tuple[str, int]]) -> Array:
        """Find single components of joint forces in which offsets are possible, over a long batch in a single pass.

        Parameters
        ----------
        pairs
            Name of the joint, and component 0 to 5, for each of n components.

        Returns
        -------
        ndarray
            The components, (n, ...).
        """
        if self._in_one_pass:
            return np.moveaxis(self._masked(self._recovery.joint_components(pairs)), -1, 0)
        return np.stack([self.joint_force(name)[..., k] for name, k in pairs])

    def against_offsets(
        self,
        pairs: Sequence[tuple[str, int]],
        others: Sequence[OfRows],
        parameters: Sequence[int],
        *,
        loads: bool = False,
    ) -> list[Array] | None:
        """Find the stiffness against offsets in joints, and other numbers per unit offset, in one pass over the batch.

        Parameters
        ----------
        pairs
            Name of the joint, and component 0 to 5, for each of n offsets; () if no stiffness is asked for.
        others
            Functions that return m numbers, given a function that returns the values of rows; see `stacked`.
        parameters
            Index of the right-hand-side parameter that is the offset, for each of them.
        loads
            Whether the forces under the loads, without these offsets, are asked for as well.

        Returns
        -------
        list of ndarray or None
            Decrease of the force in each component per unit offset in each, (n, n, ...), which is symmetric; for each
            function its numbers, (n, ..., m); and, if asked for, the forces in the components, (n, ...). None where
            entries are singular, or forces follow from those on the ends of an element without `end_force_numbers`.
        """
        kinds = [_of_values(each) for each in others]
        return self._recovery.against_offsets(pairs, kinds, parameters, loads=loads)

    def contact(self, joint: str) -> Contact:
        """Contact of a joint with clearance: its state, side, force and gap.

        Parameters
        ----------
        joint
            Name of the joint.

        Returns
        -------
        Contact
            State, normal, force and gap, each of the batch shape.

        Raises
        ------
        FrameError
            If the joint has no clearance, or clearances were left out.

        Examples
        --------
        A stop with 1 mm of clearance is reached by the second force and not by the first.

        >>> from linkframe.elements import Beam, Joint, Material, Rectangle
        >>> from linkframe.framework import Frame
        >>> frame = Frame()
        >>> for name, x in {"A": 0.0, "B": 1.0, "C": 1.0}.items():
        ...     frame.node(name, (x, 0.0, 0.0))
        >>> frame.add("AB", Beam(Rectangle(y=0.02, z=0.01), Material(E=200e9, nu=0.3)), "A", "B")
        >>> frame.add("stop", Joint(stiffness=(0.0, 1e9, 0.0, 0.0, 0.0, 0.0), clearance=1e-3), "B", "C")
        >>> frame.fix("A"); frame.fix("C"); frame.load("B", fy=[1.0, 10.0])
        >>> frame.solve().contact("stop").status.tolist()
        ['open', 'closed']
        """
        name = self._with_clearance(joint, self.journals)
        assert self.clearances is not None
        return self.clearances.contact(name)

    # -- all at once ------------------------------------------------------------------------------------------------

    def section_axes_at(self, fractions: ArrayLike) -> Array:
        """Find the axes to which the components of `forces_at` refer: the local axes of the members.

        Parameters
        ----------
        fractions
            Fractions of the length from the start, (k,); the axes are the same at all of them.

        Returns
        -------
        ndarray
            Axes as rows in global components, (..., members, 1, 3, 3); batch axes only where they vary.
        """
        return _member_axes(self.plan.topology)

    @property
    def _stacked_results(self) -> StackedResults | None:
        # a mechanism in one part of the frame must not make the results of the other parts NaN
        apart = self.solver.parts > 1 and (isinstance(self.solver, BroadcastSolver) or bool(self.movable.any()))
        return None if apart or self.consistent_mechanisms is not None else StackedResults(self)

    @property
    def _in_one_pass(self) -> bool:
        """Whether one elimination has all results of a batch."""
        batch = bool(self.shape) or self.plan.entry is None
        one = self.determinate is None and batch and self.solver.parts < 2
        return one and isinstance(self.solver, BroadcastSolver)

    def _all_of(self, *kinds: str) -> list[Array]:
        if self._in_one_pass and self.consistent_mechanisms is None:
            found = self._recovery.all_of(kinds)
            if found is not None:
                return [self._masked(array) for array in found]
        return super()._all_of(*kinds)

    def _displacement(self, node: str) -> Array:
        if self.determinate is not None and (found := self.determinate.displacement(node)) is not None:
            return found
        number, entry = self.plan.topology.number[node], self.plan.entry
        if entry is not None:
            return entry.node(number) if entry.displacements is None else np.array(entry.displacements[number])
        return self._settled(self.plan.tree.global_rows(number))


def _member_axes(topology: Topology) -> Array:
    """Axes of all members as rows in global components, (..., members, 1, 3, 3); batch axes only where they vary."""
    first = [topology.pieces_of[name][0] for name in topology.frame.members]
    member = np.full(sum(len(group.pieces) for group in topology.groups), -1)
    member[first] = np.arange(len(first))
    found = []
    for group in topology.groups:
        own = member[group.pieces]
        found.append((own[own >= 0], np.moveaxis(group.local_axes[own >= 0], 0, -3)))
    batch = np.broadcast_shapes(*(rows.shape[:-3] for _, rows in found))
    out = np.zeros((*batch, len(first), 1, 3, 3))
    for own, rows in found:
        out[..., own, 0, :, :] = rows
    return out


def _of_values(result: OfRows) -> Callable[[ForceNumbers], Sequence[Value]]:
    return lambda numbers: result(numbers.values)
