"""Static solution of a batch: nothing is computed before it is read."""

from __future__ import annotations

import sys
import warnings
from collections.abc import Iterable, Sequence
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .batch import Array, one_entry
from .batched.broadcast import BroadcastSolver
from .batched.plan import Plan
from .clearances.clearance import Clearances, joints_with_clearance
from .clearances.contact import FREE, UNRESOLVED, Contact
from .description import Description
from .error_bounds.bounds import Bounds
from .error_bounds.requested import checked as checked_kind
from .error_bounds.requested import numbered
from .error_bounds.resolved import Solved, kinematically_stable
from .error_bounds.sensitivity import Sensitivity, sensitivity
from .errors import FrameError, MechanismWarning
from .examination import require_springs
from .explain import explain
from .factor_cache import Factors, planned
from .provenance import regular_there, with_origin
from .results.conditioning import scaled, usual
from .results.consistent_mechanisms import ConsistentMechanisms
from .results.directions import member_axes
from .results.parts import node_of, of_joint, of_member, of_node, of_part
from .results.primary import Primary
from .results.recovery import Recovery
from .results.saved import SavedResults
from .results.singular import FreeMotion, free_motion
from .results.stacked_results import StackedResults
from .results.status import describe
from .results.validity import LINEAR, nonlinearity
from .solvers.method import checked
from .solvers.sparse import SparseSolver
from .solvers.stacked import StackedSolver
from .states import SolutionState, States, put, states_of, words
from .structure.parts import Row


class Solution(SavedResults):
    """Displacements, reactions and forces of a solved frame, each of the frame's batch shape.

    Obtained from ``frame.solve()``. Entries that are kinematically unstable hold NaN and say so in `status`; a
    `MechanismWarning` tells so when they are first read. Where no load does work on a free motion, only displacements
    that it has a part in are NaN. A part of the frame that no member, joint or tie
    connects with what moves keeps its results.

    Attributes
    ----------
    frame
        The description as it was when solved; a `Frame` where that was solved.
    plan
        The compiled frame.
    clearances
        Where its joints with clearance rest; None where there are none, or they were left out.
    primary
        Its unknowns, and what solves for them.

    Examples
    --------
    >>> from linkframe.elements import Beam, Circle, Material
    >>> from linkframe.framework import Frame
    >>> frame = Frame()
    >>> for name, x in {"A": 0.0, "B": 1.0}.items():
    ...     frame.node(name, (x, 0.0, 0.0))
    >>> frame.add("AB", Beam(Circle(diameter=0.02), Material(E=200e9, nu=0.3)), "A", "B")
    >>> frame.fix("A"); frame.load("B", fy=-10.0)
    >>> solution = frame.solve()
    >>> solution.reaction("A").round(9).tolist()
    [0.0, 10.0, 0.0, 0.0, 0.0, 10.0]
    >>> solution.forces("AB", [0.0, 0.5])[:, 5].round(9).tolist()
    [-10.0, -5.0]
    >>> bool((abs(solution.error_bound("B")) < 1e-15).all()), str(solution.status), bool(solution.linear)
    (True, 'regular', True)
    """

    def __init__(
        self,
        frame: Description,
        plan: Plan,
        clearances: Clearances | None = None,
        primary: Primary | None = None,
    ) -> None:
        require_springs((name, joint.element) for name, joint in frame.joints.items())
        self.frame, self.plan, self.clearances = frame, plan, clearances
        self.primary = Primary(plan, Factors(), contact=clearances is not None) if primary is None else primary
        self._known: dict[object, Array] = {}
        self._parts: dict[int, Solution] = {}
        self._warned = False

    @classmethod
    def of(cls, frame: Description, method: str | None = None, *, clearance: bool = False) -> Solution:
        """Solution of a frame; later changes of the frame do not reach it.

        Parameters
        ----------
        frame
            The description.
        method
            The way in which it is solved, see `Frame.solve`.
        clearance
            Whether to find where joints with clearance are in contact, see `Frame.solve`.

        Returns
        -------
        Solution
            Nothing is solved yet: each result is computed when it is first read.

        Raises
        ------
        FrameError
            If the method is unknown, not installed, or not for this batch.
        """
        described = frame.copy()
        plan, factors = planned(frame, described, checked(method))
        without_clearance = cls(described, plan, primary=Primary(plan, factors, contact=False))
        if not (clearance and joints_with_clearance(described)):
            return without_clearance
        resting = Clearances(described, without_clearance, cls.of)
        return cls(described, Plan(resting.offsets(), method=plan.asked), resting)

    def __getstate__(self) -> dict[str, object]:
        """What a copy or another process needs: description, plan, what has been read. The rest it computes again."""
        primary = Primary(self.plan, Factors(), contact=self.clearances is not None)
        kept = ("frame", "plan", "clearances", "_known", "_warned")
        return {name: getattr(self, name) for name in kept} | {"primary": primary, "_parts": {}}

    # -- displacements ----------------------------------------------------------------------------------------------

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
        The end of a rod that is pulled by 1 kN, ``u = F L / E A`` (Timoshenko, *Strength of Materials* I).

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
        number = self.plan.topology.number[self._node(node)]
        return self._read(("displacement", node), lambda: self._displacement(number))

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
            ``ux uy uz rx ry rz``, (..., 6); imposed offsets included.

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
        """Displacement and rotation along a member in global axes, exact between its nodes.

        Parameters
        ----------
        member
            Name of the member.
        at
            Distances from the member's start, (..., k); the batch may vary them.

        Returns
        -------
        ndarray
            ``ux uy uz rx ry rz``, (..., k, 6).

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

    # -- forces -----------------------------------------------------------------------------------------------------

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
            Force ``fx fy fz`` and moment ``mx my mz``, (..., 6); zero in components that are not held.

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
            ``fx fy fz mx my mz``, (..., 6): of the springs, and of what holds ideal components.

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
        return self._read(("force", joint), lambda: self._recovery.joint_force(joint))

    def contact(self, joint: str) -> Contact:
        """Where a joint with clearance is in contact, and how hard it is pressed.

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
        >>> frame.solve().contact("stop").state.tolist()
        ['open', 'closed']
        """
        name = self._with_clearance(joint, self.journals)
        assert self.clearances is not None
        return self.clearances.contact(name)

    @property
    def journals(self) -> list[str]:
        """Names of the joints whose clearance is taken into account."""
        return [] if self.clearances is None else self.clearances.names

    # -- all at once ------------------------------------------------------------------------------------------------

    def section_axes_at(self, fractions: ArrayLike) -> Array:
        """Find the axes in which `forces_at` tells forces: those of the members, wherever along them.

        Parameters
        ----------
        fractions
            Shares of the length from the start, (k,); the axes are the same at all.

        Returns
        -------
        ndarray
            The axes as rows in global components, (..., members, 1, 3, 3), with the batch axes that they need.
        """
        return member_axes(self.plan.topology)

    @property
    def _stacked_results(self) -> StackedResults | None:
        # what moves in one part of the frame leaves the results of the others
        apart = self.solver.parts > 1 and (isinstance(self.solver, BroadcastSolver) or bool(self.movable.any()))
        return None if apart or self.consistent_mechanisms is not None else StackedResults(self)

    # -- trust ------------------------------------------------------------------------------------------------------

    @property
    def status(self) -> NDArray[np.str_]:
        """State of each batch entry in words, (...).

        ``regular``; ``mechanism`` where it is kinematically unstable, as far as extended precision can tell
        (`distance_to_singularity` is rounding, 1e-15, where it is so); ``statically consistent mechanism`` where the
        load does no work on its free motion: forces hold, and displacements but those along that motion, which are NaN
        (a `MechanismWarning` tells so), while what no load reaches at all rests; ``free`` where joints can move within
        their clearances without any force, and the results are one choice of many; ``unresolved`` where rounding hides
        a contact; ``absent`` where it was left out. Where the frame was made from a motion, entries at which that is
        not regular carry its words, such as ``near dead point``.
        """
        return with_origin(words(self.own_state, SolutionState), self.frame.made_from, self.shape)

    @cached_property
    def state(self) -> States:
        """`status` as numbers, (...): see `linkframe.framework.SolutionState`."""
        special = (self.own_state == SolutionState.REGULAR) & ~regular_there(self.frame.made_from)
        return put(self.own_state, special, SolutionState.POSE_NOT_REGULAR)

    @cached_property
    def own_state(self) -> States:
        """State of the solution alone, whatever the frame was made from, (...)."""
        moving = self.solver.singular(excited=False)
        if isinstance(self.solver, BroadcastSolver):
            moving = moving & ~kinematically_stable(self.plan, moving)
        state = put(states_of(self.shape, SolutionState.REGULAR), moving, SolutionState.STATICALLY_CONSISTENT_MECHANISM)
        if self.consistent_mechanisms is not None:
            state = put(state, self.consistent_mechanisms.mask, SolutionState.STATICALLY_CONSISTENT_MECHANISM)
        if self.clearances is not None:
            for contact, whole in ((FREE, SolutionState.FREE), (UNRESOLVED, SolutionState.UNRESOLVED)):
                state = put(state, (self.clearances.state == contact).any(axis=0), whole)
        state = put(state, self._singular, SolutionState.MECHANISM)
        return state if self.frame.absent is None else put(state, self.frame.absent, SolutionState.ABSENT)

    @property
    def movable(self) -> NDArray[np.bool_]:
        """Entries in which what the loads reach can move, (...)."""
        return (
            self._singular if self.consistent_mechanisms is None else self._singular | self.consistent_mechanisms.mask
        )

    @cached_property
    def _singular(self) -> NDArray[np.bool_]:
        """Entries that are kinematically unstable under the loads."""
        if self.plan.entry is not None:
            return np.zeros(self.shape, dtype=bool)
        found = self.solver.singular(excited=True)
        if self.resolved is not None:
            found = found & ~self.resolved.mask
        if self.consistent_mechanisms is not None:
            found = found & ~self.consistent_mechanisms.mask
        return found if self.frame.absent is None else found & ~self.frame.absent

    def error_bound(self, name: str, of: str = "displacement", components: Sequence[str] | None = None) -> Array:
        """Bound on the error of results against the exact solution of the frame as it is described.

        All rounding is included: lengths and axes of members, their stiffnesses, assembly, elimination, recovery. The
        numbers of the description are taken as exact.

        Parameters
        ----------
        name
            The node; or the joint or member where `of` says so.
        of
            ``displacement``, ``reaction``, ``joint_displacement``, ``joint_force`` or ``end_forces``.
        components
            Those that are asked for, such as ``("ux", "uy")``, each of which costs an adjoint solution; all where None.

        Returns
        -------
        ndarray
            By component, of the shape of the result: (..., 6), or (..., 12) for ``end_forces``, or (..., m) for the m
            `components`. inf where the loads
            reach what can move, and where it is too close to that for any digit to be certain.

        Raises
        ------
        FrameError
            Where the name, the kind of result or a component is unknown, or components of end forces are asked for.

        Examples
        --------
        The stated bound is above what differs from the exact 2.5 mm, and of the size of the last digit.

        >>> from linkframe.elements import Beam, Material, Rectangle
        >>> from linkframe.framework import Frame
        >>> frame = Frame()
        >>> for name, x in {"A": 0.0, "B": 1.0}.items():
        ...     frame.node(name, (x, 0.0, 0.0))
        >>> frame.add("AB", Beam(Rectangle(y=0.02, z=0.01), Material(E=200e9, nu=0.3)), "A", "B")
        >>> frame.fix("A"); frame.load("B", fy=10.0)
        >>> solution = frame.solve()
        >>> bound = solution.error_bound("B")[1]
        >>> bool(abs(solution.displacement("B")[1] - 2.5e-3) <= bound), bool(bound < 1e-15)
        (True, True)
        """
        if (own := self.part(node_of(self.frame, name, of))) is not self:
            return own.error_bound(name, of, components)
        name, computed = self._asked(name, of)
        some = None if components is None else numbered(of, components)
        chosen = computed if some is None else computed[..., list(some)]
        return self._read(
            ("bound", of, name, some),
            lambda: self._unknown(self.bounds.bound(name, of, chosen, some)),
            mask=np.inf,
        )

    def refined(self, name: str, of: str = "displacement") -> tuple[Array, Array]:
        """Result after one step of iterative refinement in extended precision, and the bound on its error.

        Worth it where `error_bound` is large: what is left is what rounding of the members' stiffnesses leaves open.

        Parameters
        ----------
        name
            The node; or the joint or member where `of` says so.
        of
            As for `error_bound`.

        Returns
        -------
        tuple of ndarray
            Results and bounds, (..., 6), or (..., 12) for ``end_forces``.

        Raises
        ------
        FrameError
            Where the name or the kind of result is unknown.

        Examples
        --------
        >>> from linkframe.elements import Beam, Material, Rectangle
        >>> from linkframe.framework import Frame
        >>> frame = Frame()
        >>> for name, x in {"A": 0.0, "B": 1.0}.items():
        ...     frame.node(name, (x, 0.0, 0.0))
        >>> frame.add("AB", Beam(Rectangle(y=0.02, z=0.01), Material(E=200e9, nu=0.3)), "A", "B")
        >>> frame.fix("A"); frame.load("B", fy=10.0)
        >>> value, bound = frame.solve().refined("B")
        >>> bool(abs(value[1] - 2.5e-3) <= bound[1])
        True
        """
        if (own := self.part(node_of(self.frame, name, of))) is not self:
            return own.refined(name, of)
        name, computed = self._asked(name, of)
        values, bounds = self.bounds.refined(name, of)
        return (
            values if self.consistent_mechanisms is None else np.where(np.isinf(bounds), computed, values)
        ), self._unknown(bounds)

    def sensitivity(self, name: str, component: str, of: str = "displacement") -> Sensitivity:
        """Derivative of one component of a result by every load, joint stiffness, offset, support, member and node.

        They come from one adjoint solve (Choi & Kim, *Structural Sensitivity Analysis and Optimization 1*, 2005, ch.
        2). Those by loads, offsets and supports do not depend on the load, and hold where there is none.

        Parameters
        ----------
        name
            The node or joint.
        component
            Such as ``uy``; such as ``fy`` where the result is a force.
        of
            ``displacement``, ``reaction``, ``joint_displacement`` or ``joint_force``.

        Returns
        -------
        Sensitivity
            By name, each (..., 6); NaN where what the result depends on is a mechanism, loaded or not. By coordinates
            of nodes, sizes of sections and Young's moduli when they are asked for.

        Raises
        ------
        FrameError
            Where the name, the component or the kind of result is unknown.

        Examples
        --------
        A deflection is in inverse proportion to Young's modulus: ``E du/dE = -u``, the sum over a member's stiffnesses.

        >>> from linkframe.elements import Beam, Material, Rectangle
        >>> from linkframe.framework import Frame
        >>> frame = Frame()
        >>> for name, x in {"A": 0.0, "B": 1.0}.items():
        ...     frame.node(name, (x, 0.0, 0.0))
        >>> frame.add("AB", Beam(Rectangle(y=0.02, z=0.01), Material(E=200e9, nu=0.3)), "A", "B")
        >>> frame.fix("A"); frame.load("B", fy=10.0)
        >>> found = frame.solve().sensitivity("B", "uy")
        >>> float(found.members["AB"].sum().round(12)), float(found.loads["B"][1].round(12))
        (-0.0025, 0.00025)
        >>> float(found.nodes["B"][0].round(12)), float(found.sections["AB"]["y"].round(9))
        (0.0075, -0.375)
        """
        if (own := self.part(node_of(self.frame, name, of))) is not self:
            return own.sensitivity(name, component, of)
        name, _ = self._asked(name, of)
        return sensitivity(self, name, component, of)

    def mechanism(self, *entry: int) -> str:
        """Which nodes move in which direction where nothing resists, in words; empty where none does.

        Parameters
        ----------
        *entry
            Indices of a batch entry, one for each batch axis.

        Returns
        -------
        str
            Such as ``free motion 1: B (+uy +rz), C (+uy)``, the nodes that move most first; empty where nothing moves.

        Raises
        ------
        FrameError
            If the batch has no such entry.
        """
        return describe(self.plan, one_entry(self.shape, entry, "mechanism"))

    def free_motion(self, *entry: int) -> FreeMotion:
        """Motion that nothing resists at a batch entry: its shapes, turning joints, and the work of the loads on it.

        Parameters
        ----------
        *entry
            Indices of a batch entry, one for each batch axis.

        Returns
        -------
        FreeMotion
            As many motions as are independent, (count, ...); count is 0 where everything is held.

        Raises
        ------
        FrameError
            If the batch has no such entry.

        Examples
        --------
        A rod on a hinge turns about it without resistance.

        >>> from linkframe.elements import Beam, Circle, Material
        >>> from linkframe.framework import Frame
        >>> frame = Frame()
        >>> for name, x in {"A": 0.0, "B": 1.0}.items():
        ...     frame.node(name, (x, 0.0, 0.0))
        >>> frame.add("AB", Beam(Circle(diameter=0.02), Material(E=200e9, nu=0.3)), "A", "B")
        >>> frame.fix("A", "ux", "uy", "uz", "rx", "ry"); frame.load("B", fy=1.0)
        >>> motion = frame.solve().free_motion()
        >>> motion.count, abs(motion.displacement("B")[0]).round(9).tolist()
        (1, [0.0, 1.0, 0.0, 0.0, 0.0, 1.0])
        """
        at = one_entry(self.shape, entry, "free_motion")
        return free_motion(self.plan, at, solvable=not self._singular[at])

    def distance_to_singularity(self) -> Array:
        """Least singular value of the deformations by the unknowns, their columns scaled to length one, (...).

        Of what the loads reach; of the whole frame where there are none.

        With the stiffness as springs k on deformations B q it is that of ``sqrt(k) B``, the square root of the least
        eigenvalue of the scaled stiffness: rounding (1e-15) where nothing resists some motion. For a four-bar it falls
        in proportion to the angle from a singular pose.

        Returns
        -------
        ndarray
            From 0 to about 1, (...), without unit.

        Examples
        --------
        A low arch of two pinned bars: in proportion to its height.

        >>> import numpy as np
        >>> from linkframe.elements import Beam, Circle, Joint, Material
        >>> from linkframe.framework import Frame
        >>> rod, pin = Beam(Circle(diameter=0.02), Material(E=200e9, nu=0.3)), Joint(stiffness=(np.inf,) * 5 + (0.0,))
        >>> height = np.array([1e-3, 1e-4, 1e-5])
        >>> frame = Frame()
        >>> for name, x in {"A": 0.0, "B": 1.0, "C": 1.0, "D": 2.0}.items():
        ...     frame.node(name, np.stack(np.broadcast_arrays(x, height if name in "BC" else 0.0, 0.0), axis=-1))
        >>> frame.add("AB", rod, "A", "B"); frame.add("CD", rod, "C", "D"); frame.add("pin", pin, "B", "C")
        >>> for foot in "AD":
        ...     frame.fix(foot, "ux", "uy", "uz", "rx", "ry")
        >>> frame.load("B", fy=-1.0)
        >>> distance = frame.solve().distance_to_singularity()
        >>> (distance / distance[0]).round(2).tolist()
        [1.0, 0.1, 0.01]
        """
        return self._read("distance", lambda: self.bounds.distance())

    def nonlinearity(self) -> Array:
        """Estimated relative error of the displacements by their being linear, (...).

        inf where the frame is a mechanism, and where its load exceeds a buckling load.

        From the forces out of balance in the displaced shape, that within clearances included, and its rotations; see
        `linkframe.framework.results.validity`. A contact that changes side on the way is not foreseen.

        Returns
        -------
        ndarray
            Zero or above, (...): 0.05 stands for displacements that are off by 5 %.

        Examples
        --------
        A cantilever bent by a twentieth of its length, and by half of it.

        >>> from linkframe.elements import Beam, Material, Rectangle
        >>> from linkframe.framework import Frame
        >>> frame = Frame()
        >>> for name, x in {"A": 0.0, "B": 1.0}.items():
        ...     frame.node(name, (x, 0.0, 0.0))
        >>> frame.add("AB", Beam(Rectangle(y=0.02, z=0.01), Material(E=200e9, nu=0.3)), "A", "B")
        >>> frame.fix("A"); frame.load("B", fy=[200.0, 2000.0])
        >>> frame.solve().linear.tolist()
        [True, False]
        """
        return self._read("nonlinearity", lambda: nonlinearity(self))

    @property
    def linear(self) -> NDArray[np.bool_]:
        """Whether linear mechanics holds, (...): where `nonlinearity` is below 0.05."""
        return self.nonlinearity() < LINEAR

    def condition_number(self) -> Array:
        """2-norm condition number of K, assembled in the usual way with joints as springs between nodes, (...).

        Returns
        -------
        ndarray
            Greatest over least singular value, (...); inf or huge where the frame is a mechanism.
        """
        return self._read("condition", lambda: usual(self.plan))

    def scaled_condition_number(self) -> Array:
        """2-norm condition number of K in joint-relative coordinates after scaling its diagonal to one, (...).

        Returns
        -------
        ndarray
            Greatest over least singular value, (...): about as many of 16 digits are at risk as it has.
        """
        return self._read("scaled", lambda: scaled(self.plan))

    def explain(self) -> str:
        """What is built at which batch shapes, what is skipped, and why, in plain words.

        Returns
        -------
        str
            Lines for a reader.
        """
        return explain(self, self.clearances)

    # -- inside -----------------------------------------------------------------------------------------------------

    @property
    def solver(self) -> BroadcastSolver | StackedSolver | SparseSolver:
        """What solves this plan: by broadcasting, by a band for each entry, or by one sparse factorisation for all."""
        return self.primary.solver

    @property
    def resolved(self) -> Solved | None:
        """Entries singular, or almost, to double precision only, solved in extended precision; None for none."""
        return self.primary.resolved

    @property
    def consistent_mechanisms(self) -> ConsistentMechanisms | None:
        """Entries that the loads reach and that can move, but on whose free motions they do no work; None for none."""
        return self.primary.consistent_mechanisms

    @property
    def known_consistent_mechanisms(self) -> ConsistentMechanisms | None:
        """`consistent_mechanisms`, once that has been asked for."""
        return self.primary.known_consistent_mechanisms

    def part(self, node: str | None) -> Solution:
        """The solution of the part of the frame that a node is in; this one where loads reach no other part.

        Parameters
        ----------
        node
            Name of the node.

        Returns
        -------
        Solution
            Solution that shares what is known already with this one.
        """
        number = self.plan.topology.number.get(node or "")
        if number is None or self.plan.entry is not None or self.solver.parts < 2:
            return self
        connected_component = int(self.plan.connected_components[number])
        if connected_component not in self._parts:
            primary = self.primary.part(number, lambda: self.movable)
            if primary is self.primary:
                return self
            part = Solution(self.frame, primary.plan, self.clearances, primary)
            part._known = self._known
            self._parts[connected_component] = part
        return self._parts[connected_component]

    def reaching(self, unknowns: Iterable[int]) -> Solution:
        """The solution with what is coupled with these unknowns solved for too, though no load reaches it.

        Parameters
        ----------
        unknowns
            Numbers of unknowns.

        Returns
        -------
        Solution
            This one where these unknowns were solved for.
        """
        solver = self.solver.reaching(unknowns)
        if solver is self.solver:
            return self
        plan = solver.plan if isinstance(solver, BroadcastSolver) else self.plan
        return type(self)(self.frame, plan, self.clearances, self.primary.under(plan, solver))

    def cut(self) -> Solution:
        """The solution of the frame with its members cut into their segments; this one where they are.

        Returns
        -------
        Solution
            Of the same frame, with a node between any two segments.
        """
        plan = self.plan
        counts = [member.element.segments for member in plan.frame.members.values()]
        if np.array_equal(plan.topology.counts, counts):
            return self
        return type(self)(self.frame, Plan(plan.frame, cut=True, method=plan.asked), self.clearances)

    def stacked(self, rows: Sequence[Row]) -> Array:
        """Value of each combination of unknowns and prescribed numbers, as one array of the batch shape.

        Parameters
        ----------
        rows
            The n combinations, coefficient by number of the unknown (below zero: of the prescribed number).

        Returns
        -------
        ndarray
            Their values, (..., n).
        """
        return self.primary.stacked(rows)

    def nodal(self) -> Array:
        """Displacement of every node in its own axes, those inside members included.

        Returns
        -------
        ndarray
            ``ux uy uz rx ry rz``, (..., nodes, 6), in the order of the plan's numbers.
        """
        return self.primary.nodal()

    @cached_property
    def bounds(self) -> Bounds:
        """Estimates of the error of results."""
        return Bounds(self)

    @cached_property
    def _recovery(self) -> Recovery:
        return Recovery(self.primary)

    def _read(self, key: object, compute: Any, mask: float = np.nan) -> Array:
        if key not in self._known:
            array = compute()
            self._known[key] = self._present(array) if isinstance(key, str) else self._masked(array, mask)
        found = self._known[key]
        found.flags.writeable = False
        return found

    def _unknown(self, bound: Array) -> Array:
        """No bound is proved where it takes to be certain that nothing at all resists a motion."""
        if self.consistent_mechanisms is not None:
            bound[self.consistent_mechanisms.mask] = np.inf
        return bound

    def _displacement(self, number: int) -> Array:
        entry = self.plan.entry
        if entry is not None:
            return np.array(entry.displacements[number])
        return self._settled(self.plan.tree.global_rows(number))

    def _settled(self, rows: Sequence[Row]) -> Array:
        """Six displacements, NaN where they depend on how far an idle frame has moved."""
        found = self.stacked(rows)
        return (
            found
            if self.consistent_mechanisms is None
            else self._announced(found, self.consistent_mechanisms.motions(rows))
        )

    def _announced(self, found: Array, moved: Array) -> Array:
        # Where there are mechanisms as well, their warning tells of both.
        if (
            self.consistent_mechanisms is not None
            and self.consistent_mechanisms.masked(found, moved)
            and not (self._warned or self._singular.any())
        ):
            self._warned = True
            warnings.warn(self._loose(), MechanismWarning, stacklevel=_reader())
        return found

    def _asked(self, name: str, of: str) -> tuple[str, Array]:
        """The name in the description of what is asked for, and the result."""
        if self.clearances is not None:
            raise FrameError(
                "bounds, refinement and sensitivities are those of a linear solution, and this one has contacts in its "
                "joints' clearances: ask frame.solve(clearance=False), with frame.offset for the contact"
            )
        result: Array = getattr(self, checked_kind(of))(name)
        return self.frame.aliases.get(name, name) if of in ("displacement", "reaction") else name, result

    def _present(self, array: Array, mask: float = np.nan) -> Array:
        if self.frame.absent is not None:
            array[np.broadcast_to(self.frame.absent, self.shape)] = mask
        return array

    def _masked(self, array: Array, mask: float = np.nan) -> Array:
        array = self._present(array, mask)
        if self.clearances is None and self.plan.entry is not None:
            return array  # of one entry, and regular
        singular = self._singular
        if self.clearances is not None and not (self._warned or singular.any()):
            self._told_free()
        if singular.any():
            if not self._warned:
                self._warned = True
                warnings.warn(self._warning(singular), MechanismWarning, stacklevel=_reader())
            array[singular] = mask
        return array

    def _told_free(self) -> None:
        """Warn where no force says where a journal rests: the results are one choice of many, and so are statistics."""
        free = self.state == SolutionState.FREE
        if free.any():
            self._warned = True
            warnings.warn(
                f"{free.sum()} of {free.size} batch entries are free: no force determines the contact of a journal in "
                "its clearance, so that their results are one choice of many, and statistics of them mean nothing",
                MechanismWarning,
                stacklevel=_reader(),
            )

    def _warning(self, singular: NDArray[np.bool_]) -> str:
        if not singular.ndim:
            return f"the frame is kinematically unstable and its results are NaN: {self.mechanism()}"
        entry = tuple(int(k) for k in np.argwhere(singular)[0])
        moving = 0 if self.consistent_mechanisms is None else int(self.consistent_mechanisms.mask.sum())
        more = f", and {moving} more are statically consistent mechanisms, with displacements NaN along the free motion"
        return (
            f"{singular.sum()} of {singular.size} batch entries are kinematically unstable and their results are NaN"
            f"{more if moving else ''}; the first, {entry}: {self.mechanism(*entry)}"
        )

    def _loose(self) -> str:
        assert self.consistent_mechanisms is not None
        entry = tuple(int(k) for k in np.argwhere(self.consistent_mechanisms.mask)[0])
        return (
            "the frame is a statically consistent mechanism: the load does no work on its free motion, and "
            f"displacements along that are NaN: {self.mechanism(*entry)}"
        )


def _reader() -> int:
    """Stack level, for a warning of who called this, of the first caller that is not part of linkframe."""
    frame, level = sys._getframe(1), 1
    # cached properties lie between
    while frame.f_back is not None and frame.f_globals.get("__name__", "").startswith(("linkframe.", "functools")):
        frame, level = frame.f_back, level + 1
    return level
