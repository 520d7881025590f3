"""The solution at large displacement: what `Frame.solve(large=True)` returns, and what it explains of itself."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..batch import Array
from ..batched.plan import Plan
from ..clearances.joints import joints_with_clearance
from ..described.released_ends import with_hinges
from ..description import Description
from ..listing import Explanation
from ..provenance import with_origin
from ..results.saved import SavedResults
from ..states import SolutionState, States, put, states_of, words
from .accuracy import ErrorBounds, bounds_in_space, judged_in_space
from .clearances import touched
from .elimination import LARGE
from .equations import EquilibriumEquations, SpatialLinearisation
from .load_stepping import History, LoadStepping
from .model import Model
from .newton_program import choice
from .planar_model import PlanarModel
from .recovery import RecoveredResults, Stations
from .state import DisplacedState, FoundEquilibria, Index

# Largest unbalanced force over the largest force of an equilibrium that counts as certain.
_BALANCED = 1e-6
_PLANES = {5: "xy", 4: "xz", 3: "yz"}


class LargeSolution(RecoveredResults, SavedResults):
    """Displacements and forces in an equilibrium at finite displacement and rotation, each of the frame's batch shape.

    Obtained from ``frame.solve(large=True)``. Loads keep their direction, moments their axis in space; line loads and
    weights go with the material that carries them. Where a load step ends in a saddle of the energy, such as a column
    beyond its buckling load, the free mode is followed to a stable equilibrium, and `status` says so. Of its two sides
    that is the one to which the first little share of the loads moves the frame; where that is neither, as where the
    two are mirror images, the one at which the first of the largest displacements of the nodes, in the order of their
    description, is positive. So is a mechanism at rest whose loads do no work on its free motion. An entry in a
    coordinate plane under loads in it is kept to the plane, whatever its neighbours are; `stable` looks out of it.
    Journals whose contact stiffness is inf lie on their circles to rounding; screws advance through any number of
    turns.

    What is released at an end of a member is free in the section there, however far that turns: an ideal joint, the
    member's end its first node, its axes the member's, with these components free. Ends of a member of one segment
    that are released about the same axis are not: it stays a straight bar across that axis, and does not buckle.

    Rotations are rotation vectors (axis times angle, up to pi).

    Attributes
    ----------
    frame
        The description as it was when solved; a `Frame` where that was solved.
    steps
        Number of load steps.
    clearance
        Whether the joints' clearances are taken into account.
    """

    def __init__(self, frame: Description, steps: int, clearance: bool = True) -> None:
        self.frame = frame
        self.model = Model(Plan(with_hinges(frame), cut=True), clearance=clearance)
        self._steps = steps

    # -- displacements ----------------------------------------------------------------------------------------------

    def displacement(self, node: str) -> Array:
        """Displacement and rotation of a node in global axes.

        Parameters
        ----------
        node
            Name of the node.

        Returns
        -------
        ndarray
            ``ux uy uz`` and the rotation vector, (..., 6), length and radians.
        """
        number = self.model.topology.number[self._node(node)]
        return self._shaped(self.displaced.moved(number))

    def displacement_along(self, member: str, at: ArrayLike) -> Array:
        """Displacement and rotation along a member in global axes.

        Parameters
        ----------
        member
            Name of the member.
        at
            Distances from the member's start before loading, (..., k); the batch may vary them.

        Returns
        -------
        ndarray
            ``ux uy uz`` and the rotation vector, (..., k, 6).
        """
        return self._masked(self._recovery.displacement_along(self._member(member), np.atleast_1d(at)))

    # -- forces -----------------------------------------------------------------------------------------------------

    def end_forces(self, member: str) -> Array:
        """Force and moment on each end of a member.

        Parameters
        ----------
        member
            Name of the member.

        Returns
        -------
        ndarray
            ``fx fy fz mx my mz`` at the start and then at the end, (..., 12), in axes that follow the chord of the
            piece (of ``segments``) at that end.
        """
        return self._masked(self._recovery.end_forces(self._member(member)))

    def reaction(self, node: str) -> Array:
        """Force and moment of a support on its node in global axes.

        Parameters
        ----------
        node
            Name of the node.

        Returns
        -------
        ndarray
            ``fx fy fz mx my mz``, (..., 6), moments about the displaced node; zero where the node has no support.
        """
        node = self._supported(node)
        number = self.model.topology.number[node]
        loops = [k for k, loop in enumerate(self.model.loops) if (loop.edge.kind, loop.edge.name) == ("support", node)]
        if loops:
            return self._shaped(self.linear.own[:, len(self.model.joints) + loops[0]])
        force = self.linear.nodal[:, number].copy()
        force[[k for k in range(6) if k not in self.frame.supports[node]]] = 0.0
        return self._shaped(force)

    # -- trust ------------------------------------------------------------------------------------------------------

    @property
    def status(self) -> NDArray[np.str_]:
        """State of each batch entry in words, (...).

        ``stable``; ``stable beyond a saddle`` where a free mode had to be followed, to one of its two sides: another
        equilibrium may lie as near on the other; ``statically consistent mechanism`` where neither loads nor stiffness
        resist some motion, so that the place is one of many, see `neutral`; ``unstable``; ``not converged``, and the
        results are NaN; ``absent`` where the entry was left out. Where the frame was made from a motion, entries at
        which that is not regular carry its words as well.
        """
        return with_origin(words(self.state, SolutionState), self.frame.made_from, self.shape)

    @cached_property
    def state(self) -> States:
        """`status` as numbers, (...): see `linkframe.framework.SolutionState`."""
        left = np.asarray(self._found.left).reshape(self.shape)
        state = states_of(self.shape, SolutionState.STABLE)
        state = put(state, self.neutral, SolutionState.STATICALLY_CONSISTENT_MECHANISM)
        state = put(state, left, SolutionState.STABLE_BEYOND_A_SADDLE)
        state = put(state, ~self.stable, SolutionState.UNSTABLE)
        state = put(state, ~self.converged, SolutionState.NOT_CONVERGED)
        return state if self.frame.absent is None else put(state, self.frame.absent, SolutionState.ABSENT)

    @cached_property
    def stable(self) -> NDArray[np.bool_]:
        """Whether the energy has a minimum, (...), motion out of the plane included.

        That is so where the tangent has no negative eigenvalue beyond its rounding, and the same in all units and axes.
        Motions that neither load nor stiffness resists (an unheld plane) do not count. Moments in space keep their axis
        and have no energy; they count by the symmetric part of the tangent, as semitangential moments do: any motion
        then takes work, which is enough for stability (Hill, J. Mech. Phys. Solids 6 (1958) 236-249).
        """
        found = self._found
        out = self.converged.reshape(-1) & found.stable
        if self._in_space is not None:
            out &= self._in_space[0]
        return out.reshape(self.shape)

    @cached_property
    def neutral(self) -> NDArray[np.bool_]:
        """Whether neither loads nor stiffness resist some motion from there, (...): the place is one of many.

        Motion out of the plane is included, such as the turn of a bar between balls about itself.
        Not told where joints move in clearances, where it is the smallest of forces that holds a journal in place,
        where loops are closed by ideal joints, and under moments in space.
        """
        if self.model.has_clearance:
            return np.zeros(self.shape, dtype=bool)
        found = self._found.neutral
        if self._in_space is not None:
            found = found | self._in_space[1]
        return found.reshape(self.shape) & self.converged

    @cached_property
    def converged(self) -> NDArray[np.bool_]:
        """Whether an equilibrium was found, (...)."""
        found = self._found.converged
        if found.any() and self.model.has_clearance:
            found = found & ~self._unbalanced()
        return found.reshape(self.shape)

    @property
    def iterations(self) -> NDArray[np.int64]:
        """Newton steps, (...)."""
        return self._found.iterations.reshape(self.shape)

    @cached_property
    def residual(self) -> Array:
        """Largest unbalanced force over the largest force at a node, (...); moments are divided by the frame's size."""
        at = self.linear
        scale, lengths = self.equations.scale, self.equations.lengths
        turns = np.isin(np.arange(len(scale)), self.model.columns[3:])[:, None]
        rows = np.where(turns, scale / lengths, scale > 0.0)[: self.model.free]
        largest = np.abs(at.nodal[:3]).max(axis=(0, 1), initial=0.0)
        unbalanced = np.abs(rows * at.forces[: self.model.free]).max(axis=0, initial=0.0)
        share = (unbalanced / np.where(largest > 0.0, largest, 1.0)).reshape(self.shape)
        return share if self.frame.absent is None else np.where(self.frame.absent, np.nan, share)

    def error_bound(self, node: str) -> Array:
        """Bound on the numerical error of a displacement, of first order: Newton's residual through the tangent.

        Unbalanced forces, and the rounding that may be in them, act at their worst. How well the pieces of a member
        follow its curve is another matter: compare with more ``segments``.

        Parameters
        ----------
        node
            Name of the node.

        Returns
        -------
        ndarray
            By component of `displacement`, (..., 6); rotation as a spin; inf where a motion that nothing resists
            moves the node.
        """
        number = self.model.topology.number[self._node(node)]
        out = self.trust.bound(number)
        if self._trust_in_space is not None:
            index, trust = self._trust_in_space
            across = np.setdiff1d(np.arange(6), self.model.components)
            out[across[:, None], index] = trust.bound(number)[across]
        return self._shaped(out)

    @property
    def load_factor(self) -> Array:
        """Shares of the load in the steps, (steps,)."""
        return self._history.factors

    @property
    def strain_energy(self) -> Array:
        """Energy in members and joints after each load step, (steps, ...); NaN where the entry was left out."""
        return self._history.energy.reshape(self._steps, *self.shape)

    @property
    def work(self) -> Array:
        """Work of loads and given motions up to each load step, (steps, ...), by the trapezoidal rule over the steps.

        What it differs by from `strain_energy` falls with the square of the step.
        """
        return self._history.work.reshape(self._steps, *self.shape)

    def explain(self) -> str:
        """What is built and solved, in plain words; nothing is computed for it.

        Returns
        -------
        str
            Lines for a reader: unknowns, load steps, and which way the equations are solved.
        """
        return Explanation("\n".join(_explained(self.model, self.frame, self._steps)))

    # -- inside -----------------------------------------------------------------------------------------------------

    @cached_property
    def _load_stepping(self) -> LoadStepping:
        return LoadStepping(self.model, self._steps)

    @cached_property
    def _result(self) -> tuple[FoundEquilibria, History]:
        return self._load_stepping.run()

    @cached_property
    def _in_space(self) -> tuple[NDArray[np.bool_], NDArray[np.bool_]] | None:
        """Of frames kept to a plane, whether equilibria are stable and neutral in space, (entries,) each."""
        if len(self.model.components) == 6:
            return None
        return judged_in_space(self.model, self.displaced, self._load_stepping.pieces())

    @property
    def _found(self) -> FoundEquilibria:
        return self._result[0]

    @cached_property
    def _history(self) -> History:
        return self._result[1] if self._steps > 1 else self._load_stepping.single(self.displaced)

    @cached_property
    def displaced(self) -> DisplacedState:
        """Displacements and quaternions of all nodes, and of joints, batch flattened and behind."""
        return touched(self.equations, self._load_stepping.newton.space(self._found.state))

    @cached_property
    def equations(self) -> EquilibriumEquations:
        """Equations of the whole batch at the whole load."""
        index = np.arange(self._load_stepping.count)
        return EquilibriumEquations(self.model, self.model.where(index), len(index))

    @cached_property
    def linear(self) -> SpatialLinearisation:
        """Forces of the whole batch; without its tangents."""
        return self.equations.linearised(self.displaced, tangents=False)

    def _unbalanced(self) -> NDArray[np.bool_]:
        """Where forces are left that are not small, and more than rounding or with a journal not pressed, (entries,).

        Nothing resists such a journal, and forces below the rounding of others may still drive it.
        """
        out = np.asarray(self.residual > _BALANCED).reshape(-1)
        if not out.any():
            return out
        own = np.setdiff1d(np.arange(self.model.free), self.model.multipliers)
        # what is wrong is what is unbalanced, and the rounding in it
        more: NDArray[np.bool_] = (2.0 * np.abs(self.trust.at.forces) > self.trust.wrong)[own].any(axis=0)
        return out & (more | self._unpressed())

    @cached_property
    def trust(self) -> ErrorBounds:
        """Bounds on the numerical error of displacements."""
        found = self._found
        # with clearances convergence itself is judged by these bounds
        inside = (
            np.zeros_like(found.neutral) if self.model.has_clearance else found.neutral & self.converged.reshape(-1)
        )
        return ErrorBounds(self.equations, self.displaced, inside)

    @cached_property
    def _trust_in_space(self) -> tuple[Index, ErrorBounds] | None:
        """Entries of a frame kept to a plane in which something is free to leave it, and their bounds in space."""
        if self._in_space is None or not self.neutral.any():
            return None
        index = np.flatnonzero(self._in_space[1] & self.converged.reshape(-1))
        return (index, bounds_in_space(self.model, self.displaced, index)) if len(index) else None

    @cached_property
    def _recovery(self) -> Stations:
        return Stations(self.equations, self.displaced, self.linear)

    def _masked(self, array: Array) -> Array:
        nothing = ~self.converged if self.frame.absent is None else ~self.converged | self.frame.absent
        if not nothing.any():
            return array
        return np.where(nothing.reshape(*self.shape, *(1,) * (array.ndim - nothing.ndim)), np.nan, array)


def _explained(model: Model, frame: Description, steps: int) -> list[str]:
    """What is built and solved, line by line; nothing is computed for it."""
    count = len(model.present)
    absent = count - int(model.present.sum())
    inside = f"is kept to the {_PLANES[model.components[-1]]} plane" if len(model.components) == 3 else "moves in space"
    factors = "one factorisation for all" if model.free <= LARGE else "sparse factors of one entry after another"
    return [
        f"Large displacement: batch shape {frame.shape}, {count} entries"
        + (f", of which {absent} are left out." if absent else "."),
        f"Members are cut into {len(model.topology.pieces)} corotational pieces; the frame {inside}.",
        f"Coordinates: {model.free} unknown, {len(model.prescribed)} given; {len(model.joints)} joints, links and "
        f"supports carry nodes along, {len(model.loops)} close loops.",
        _clearances(model, joints_with_clearance(frame) if model.clearance else []),
        f"Load steps: {steps}. In each, Newton's method ({factors}) for the entries that it has not yet solved; "
        "where it fails, smaller steps, the way out of a saddle along its mode, and the descent of the energy.",
        f"Newton's method is done {choice(PlanarModel(model) if PlanarModel.suits(model) else model).reason}.",
    ]


def _clearances(model: Model, names: list[str]) -> str:
    if not names:
        return "No joint moves in a clearance."
    rigid = [str(model.edges[number].edge.name) for number in model.contacts]
    exact = f"; rigid contact in {', '.join(rigid)}: its force is found, with no stiffness" if rigid else ""
    return f"Clearances: {', '.join(names)}, by the law of each joint{exact}."
