"""Static solution of a batch: nothing is computed before it is read."""

from __future__ import annotations

import copy
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
from .batched.reuse import same_structure
from .clearances.clearance import Clearances, loose_joints
from .clearances.contact import FREE, UNRESOLVED, Contact
from .description import Description
from .error_bounds.asked import checked as checked_kind
from .error_bounds.bounds import Bounds
from .error_bounds.resolved import MOST, Resolved, ResolvedLarge, Solved, resting
from .error_bounds.sensitivity import Sensitivity, sensitivity
from .errors import FrameError, MechanismWarning
from .examination import require_springs
from .explain import explain
from .provenance import regular_there, with_origin
from .results.conditioning import scaled, usual
from .results.idle import ConsistentMechanisms, idle
from .results.parts import of_joint, of_member, of_node, of_part
from .results.recovery import Recovery
from .results.saved import SavedResults
from .results.singular import FreeMotion, free_motion
from .results.status import describe
from .results.together import Together
from .results.validity import LINEAR, nonlinearity
from .solvers.method import BROADCAST, checked, choose
from .solvers.sparse import SparseSolver
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

    def __init__(self, frame: Description, plan: Plan, clearances: Clearances | None = None) -> None:
        require_springs((name, joint.element) for name, joint in frame.joints.items())
        self.frame, self.plan, self.clearances = frame, plan, clearances
        self._known: dict[object, Array] = {}
        self._parts: dict[Plan, Solution] = {}
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
        """
        described = frame.copy()
        kept = frame.kept
        if isinstance(kept, Plan) and kept.asked == checked(method) and same_structure(kept.frame, described):
            plan = kept.reloaded(described)
        else:
            plan = Plan(described, method=checked(method))
            if method is not None:
                choose(plan, method)  # refuses at once what does not suit the batch
        frame.kept = plan
        tight = cls(described, plan)
        if not (clearance and loose_joints(described)):
            return tight
        resting = Clearances(described, tight, cls.of)
        return cls(described, Plan(resting.offsets(), method=plan.asked), resting)

    def __getstate__(self) -> dict[str, object]:
        """What a copy or another process needs: description, plan, what has been read. The rest it computes again."""
        plan = copy.copy(self.plan)
        plan.solver = None
        kept = ("frame", "clearances", "_known", "_warned")
        return {name: getattr(self, name) for name in kept} | {"plan": plan, "_parts": {}}

    # -- displacements ----------------------------------------------------------------------------------------------

    @of_part(of_node)
    def displacement(self, node: str) -> Array:
        """Displacement and rotation of a node in global axes.

        Parameters
        ----------
        node
            The node.

        Returns
        -------
        ndarray
            ``ux uy uz rx ry rz``, (..., 6), length and radians.
        """
        number = self.plan.topology.number[self._node(node)]
        return self._read(("displacement", node), lambda: self._settled(self.plan.tree.global_rows(number)))

    @of_part(of_joint)
    def joint_displacement(self, joint: str) -> Array:
        """Displacement of a joint's second node relative to its first, in the joint's axes.

        Parameters
        ----------
        joint
            The joint.

        Returns
        -------
        ndarray
            ``ux uy uz rx ry rz``, (..., 6); imposed offsets included.
        """
        self._joint(joint)
        return self._read(("joint", joint), lambda: self._settled(self._recovery.joint_rows(joint)))

    @of_part(of_member)
    def displacement_along(self, member: str, at: ArrayLike) -> Array:
        """Displacement and rotation along a member in global axes, exact between its nodes.

        Parameters
        ----------
        member
            The member.
        at
            Distances from the member's start, (..., k); the batch may vary them.

        Returns
        -------
        ndarray
            ``ux uy uz rx ry rz``, (..., k, 6).
        """
        stations = np.atleast_1d(at)
        found = self._masked(self._recovery.displacement_along(self._member(member), stations))
        return found if self.idle is None else self._announced(found, self._recovery.moved_along(member, stations))

    # -- forces -----------------------------------------------------------------------------------------------------

    forces = of_part(of_member)(SavedResults.forces)
    stress = of_part(of_member)(SavedResults.stress)

    @of_part(of_member)
    def end_forces(self, member: str) -> Array:
        """Forces and moments on the ends of a member in its local axes.

        Parameters
        ----------
        member
            The member.

        Returns
        -------
        ndarray
            Start before end, (..., 12).
        """
        self._member(member)
        return self._read(("ends", member), lambda: self._recovery.end_forces(member))

    @of_part(of_node)
    def reaction(self, node: str) -> Array:
        """Force and moment of a support on its node in global axes.

        Parameters
        ----------
        node
            The node.

        Returns
        -------
        ndarray
            ``fx fy fz mx my mz``, (..., 6); zero in components that are not held.

        Raises
        ------
        FrameError
            If the node has no support.
        """
        node = self._supported(node)
        return self._read(("reaction", node), lambda: self._recovery.reaction(node))

    @of_part(of_joint)
    def joint_force(self, joint: str) -> Array:
        """Force and moment that a joint exerts on its first node, in the joint's axes.

        Parameters
        ----------
        joint
            The joint.

        Returns
        -------
        ndarray
            ``fx fy fz mx my mz``, (..., 6): of the springs, and of what holds ideal components.
        """
        self._joint(joint)
        return self._read(("force", joint), lambda: self._recovery.joint_force(joint))

    def contact(self, joint: str) -> Contact:
        """Where a joint with clearance is in contact, and how hard it is pressed.

        Parameters
        ----------
        joint
            The joint.

        Raises
        ------
        FrameError
            If the joint has no clearance, or clearances were left out.
        """
        name = self._played(joint, [] if self.clearances is None else self.clearances.names)
        assert self.clearances is not None
        return self.clearances.contact(name)

    # -- all at once ------------------------------------------------------------------------------------------------

    @property
    def _at_once(self) -> Together | None:
        apart = isinstance(self.solver, BroadcastSolver) and len(self.plan.excited) > 1
        return None if apart or self.idle is not None else Together(self)

    # -- trust ------------------------------------------------------------------------------------------------------

    @property
    def status(self) -> NDArray[np.str_]:
        """By batch entry: ``regular``; ``mechanism`` where it is kinematically unstable, as far as extended
        precision can tell (`distance_to_singularity` is rounding, 1e-15, where it is so); ``statically consistent
        mechanism`` where the load does no work on its free motion: forces hold, and displacements but those along that
        motion, which are NaN (a `MechanismWarning` tells so), while what no load reaches at all rests; ``free`` where
        joints can move within their clearances without any force, and the results are one choice of many;
        ``unresolved`` where rounding hides a contact; ``absent`` where it was left out. Where the frame was made from a
        motion, entries at which that is not regular carry its words, such as ``near dead point``."""
        return with_origin(words(self.own_state, SolutionState), self.frame.made_from, self.shape)

    @cached_property
    def state(self) -> States:
        """`status` as numbers, (...): see `linkframe.framework.SolutionState`."""
        special = (self.own_state == SolutionState.REGULAR) & ~regular_there(self.frame.made_from)
        return put(self.own_state, special, SolutionState.POSE_NOT_REGULAR)

    @cached_property
    def own_state(self) -> States:
        """State of the solution alone, whatever the frame was made from, (...)."""
        idle = self.solver.singular(excited=False)
        if isinstance(self.solver, BroadcastSolver):
            idle = idle & ~resting(self.plan, idle)
        state = put(states_of(self.shape, SolutionState.REGULAR), idle, SolutionState.STATICALLY_CONSISTENT_MECHANISM)
        if self.idle is not None:
            state = put(state, self.idle.mask, SolutionState.STATICALLY_CONSISTENT_MECHANISM)
        if self.clearances is not None:
            for contact, whole in ((FREE, SolutionState.FREE), (UNRESOLVED, SolutionState.UNRESOLVED)):
                state = put(state, (self.clearances.state == contact).any(axis=0), whole)
        state = put(state, self._singular, SolutionState.MECHANISM)
        return state if self.frame.absent is None else put(state, self.frame.absent, SolutionState.ABSENT)

    @property
    def movable(self) -> NDArray[np.bool_]:
        """Entries in which what the loads reach can move, (...)."""
        return self._singular if self.idle is None else self._singular | self.idle.mask

    @cached_property
    def _singular(self) -> NDArray[np.bool_]:
        """Entries that are kinematically unstable under the loads."""
        found = self.solver.singular(excited=True)
        if self.resolved is not None:
            found = found & ~self.resolved.mask
        if self.idle is not None:
            found = found & ~self.idle.mask
        return found if self.frame.absent is None else found & ~self.frame.absent

    def error_bound(self, name: str, of: str = "displacement") -> Array:
        """Bound on the error of results against the exact solution of the frame as it is described.

        All rounding is included: lengths and axes of members, their stiffnesses, assembly, elimination, recovery. The
        numbers of the description are taken as exact.

        Parameters
        ----------
        name
            The node; or the joint or member where `of` says so.
        of
            ``displacement``, ``reaction``, ``joint_displacement``, ``joint_force`` or ``end_forces``.

        Returns
        -------
        ndarray
            By component, of the shape of the result: (..., 6), or (..., 12) for ``end_forces``. inf where the loads
            reach what can move, and where it is too close to that for any digit to be certain.

        Raises
        ------
        FrameError
            Where the name or the kind of result is unknown.
        """
        name, computed = self._asked(name, of)
        return self._read(
            ("bound", of, name), lambda: self._unknown(self.bounds.bound(name, of, computed)), mask=np.inf
        )

    def refined(self, name: str, of: str = "displacement") -> tuple[Array, Array]:
        """Results after one step of iterative refinement in extended precision, and the bound on their error.

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
        """
        name, computed = self._asked(name, of)
        values, bounds = self.bounds.refined(name, of)
        return (values if self.idle is None else np.where(np.isinf(bounds), computed, values)), self._unknown(bounds)

    def sensitivity(self, name: str, component: str, of: str = "displacement") -> Sensitivity:
        """Derivatives of one component of a result by every load, joint stiffness, offset, support and member.

        Those by loads, offsets and supports do not depend on the load, and hold where there is none.

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
            By name, each (..., 6); NaN where what the result depends on is a mechanism, loaded or not.

        Raises
        ------
        FrameError
            Where the name, the component or the kind of result is unknown.
        """
        name, _ = self._asked(name, of)
        return sensitivity(self, name, component, of)

    def mechanism(self, *entry: int) -> str:
        """Which nodes move in which direction where nothing resists, in words; empty where none does.

        Parameters
        ----------
        *entry
            Indices of a batch entry, one for each batch axis.

        Raises
        ------
        FrameError
            If the batch has no such entry.
        """
        return describe(self.plan, one_entry(self.shape, entry, "mechanism"))

    def free_motion(self, *entry: int) -> FreeMotion:
        """Motions that nothing resists at a batch entry: shapes, turning joints, work of the loads on them.

        Parameters
        ----------
        *entry
            Indices of a batch entry, one for each batch axis.

        Raises
        ------
        FrameError
            If the batch has no such entry.
        """
        at = one_entry(self.shape, entry, "free_motion")
        return free_motion(self.plan, at, solvable=not self._singular[at])

    def distance_to_singularity(self) -> Array:
        """Least singular value of the deformations by the unknowns, their columns scaled to length one, (...).

        Of what the loads reach; of the whole frame where there are none.

        With the stiffness as springs k on deformations B q it is that of ``sqrt(k) B``, the square root of the least
        eigenvalue of the scaled stiffness: rounding (1e-15) where nothing resists some motion. For a four-bar it falls
        in proportion to the angle from a singular pose.
        """
        return self._read("distance", lambda: self.bounds.distance())

    def nonlinearity(self) -> Array:
        """Estimated relative error of the displacements by their being linear, (...).

        inf where the frame is a mechanism, and where its load exceeds a buckling load.

        From the forces out of balance in the displaced shape, that within clearances included, and its rotations; see
        `linkframe.framework.results.validity`. A contact that changes side on the way is not foreseen.
        """
        return self._read("nonlinearity", lambda: nonlinearity(self))

    @property
    def linear(self) -> NDArray[np.bool_]:
        """Whether linear mechanics holds, (...): where `nonlinearity` is below 0.05."""
        return self.nonlinearity() < LINEAR

    def condition_number(self) -> Array:
        """2-norm condition number of K, assembled in the usual way with joints as springs between nodes, (...)."""
        return self._read("condition", lambda: usual(self.plan))

    def scaled_condition_number(self) -> Array:
        """2-norm condition number of K in joint-relative coordinates after scaling its diagonal to one, (...)."""
        return self._read("scaled", lambda: scaled(self.plan))

    def explain(self) -> str:
        """What is built at which batch shapes, what is skipped, and why, in plain words."""
        return explain(self, self.clearances)

    # -- inside -----------------------------------------------------------------------------------------------------

    @cached_property
    def solver(self) -> BroadcastSolver | SparseSolver:
        """What solves this plan: by broadcasting, or, for one large frame, by a sparse factorisation."""
        plan = self.plan
        if plan.method.name == BROADCAST:
            # Not kept with the plan: it holds numbers of the whole batch.
            return BroadcastSolver(plan)
        if plan.solver is None:
            plan.solver = SparseSolver(plan)
        solver: SparseSolver = plan.solver
        return solver

    def part(self, node: str | None) -> Solution:
        """The solution of the part of the frame that a node is in; this one where loads reach no other part.

        Parameters
        ----------
        node
            The node.
        """
        number = self.plan.topology.number.get(node or "")
        if number is None or not isinstance(self.solver, BroadcastSolver):
            return self
        plan = self.plan.part(number)
        if plan is self.plan:
            return self
        if plan not in self._parts:
            part = self._parts[plan] = Solution(self.frame, plan, self.clearances)
            part._known, part.solver = self._known, self.solver.only(plan)
        return self._parts[plan]

    def reaching(self, unknowns: Iterable[int]) -> Solution:
        """The solution with what is coupled with these unknowns solved for too, though no load reaches it.

        Parameters
        ----------
        unknowns
            Numbers of unknowns.
        """
        solver = self.solver.reaching(unknowns)
        if solver is self.solver:
            return self
        plan = solver.plan if isinstance(solver, BroadcastSolver) else self.plan
        twin = type(self)(self.frame, plan, self.clearances)
        twin.solver = solver
        return twin

    def cut(self) -> Solution:
        """The solution of the frame with its members cut into their segments; this one where they are."""
        plan = self.plan
        counts = [member.element.segments for member in plan.frame.members.values()]
        if np.array_equal(plan.topology.counts, counts):
            return self
        return type(self)(self.frame, Plan(plan.frame, cut=True, method=plan.asked), self.clearances)

    def stacked(self, rows: Sequence[Row]) -> Array:
        """Values of combinations of unknowns and known numbers as one array of the batch shape.

        Parameters
        ----------
        rows
            n combinations.

        Returns
        -------
        ndarray
            (..., n).
        """
        out = np.zeros((*self.shape, len(rows)))
        for k, value in enumerate(self.solver.values(rows)):
            out[..., k] = value
        if self.resolved is not None:
            out[self.resolved.mask] = self.resolved.values(rows)
        if self.idle is not None:
            out[self.idle.mask] = self.idle.values(rows)
        return out

    def nodal(self) -> Array:
        """Displacements of all nodes in their own axes, those inside members included, (..., nodes, 6)."""
        count = len(self.plan.topology.number)
        if isinstance(self.solver, SparseSolver) and self.idle is None:
            better = self.resolved
            unknowns = better.whole(self.solver) if isinstance(better, ResolvedLarge) else self.solver.unknowns
            return self.solver.nodal(unknowns).reshape(*self.shape, count, 6)
        rows = [self.plan.tree.row(node, k) for node in range(count) for k in range(6)]
        return self.stacked(rows).reshape(*self.shape, count, 6)

    @cached_property
    def resolved(self) -> Solved | None:
        """Entries singular, or almost, to double precision only, solved in extended precision; None for none."""
        if self.clearances is not None:
            return None
        found: Solved
        if isinstance(self.solver, SparseSolver):
            if self.solver.adrift(self.solver.excited).size or not self.solver.singular(excited=True).any():
                return None
            found = ResolvedLarge(self.plan, self.solver)
        else:
            suspects = self.solver.suspects()
            if not suspects.any() or len(self.plan.unknowns) > MOST:
                return None
            found = Resolved(self.plan, suspects)
        return found if found.mask.any() else None

    @cached_property
    def idle(self) -> ConsistentMechanisms | None:
        """Entries that the loads reach and that can move, but on whose free motions they do no work; None for none."""
        found = self.solver.singular(excited=True)
        if self.resolved is not None:
            found = found & ~self.resolved.mask
        return idle(self.plan, self.solver, found) if found.any() else None

    @cached_property
    def bounds(self) -> Bounds:
        """Estimates of the error of results."""
        return Bounds(self)

    @cached_property
    def _recovery(self) -> Recovery:
        return Recovery(self)

    def _read(self, key: object, compute: Any, mask: float = np.nan) -> Array:
        if key not in self._known:
            array = compute()
            self._known[key] = self._present(array) if isinstance(key, str) else self._masked(array, mask)
        found = self._known[key]
        found.flags.writeable = False
        return found

    def _unknown(self, bound: Array) -> Array:
        """No bound is proved where it takes to be certain that nothing at all resists a motion."""
        if self.idle is not None:
            bound[self.idle.mask] = np.inf
        return bound

    def _settled(self, rows: Sequence[Row]) -> Array:
        """Six displacements, NaN where they depend on how far an idle frame has moved."""
        found = self.stacked(rows)
        return found if self.idle is None else self._announced(found, self.idle.motions(rows))

    def _announced(self, found: Array, moved: Array) -> Array:
        # Where there are mechanisms as well, their warning tells of both.
        if self.idle is not None and self.idle.masked(found, moved) and not (self._warned or self._singular.any()):
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
        idle = 0 if self.idle is None else int(self.idle.mask.sum())
        more = f", and {idle} more are statically consistent mechanisms, with displacements NaN along the free motion"
        return (
            f"{singular.sum()} of {singular.size} batch entries are kinematically unstable and their results are NaN"
            f"{more if idle else ''}; the first, {entry}: {self.mechanism(*entry)}"
        )

    def _loose(self) -> str:
        assert self.idle is not None
        entry = tuple(int(k) for k in np.argwhere(self.idle.mask)[0])
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
