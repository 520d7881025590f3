"""Tangent stiffness of a linkage at a loaded pose: elastic stiffness of links and joints plus geometric stiffness.

At rest, locked drives hold a pose under the forces of springs, loads and weights. The second derivative of the
potential in any small motion is then that of the strain energy plus, for each member, joint and rigid link, the force
in it times the second derivative of the displacement on which it does work, with kinematics of second order (see
`linkframe.framework.results.geometric`). Springs act along their line. Loads keep their direction, even follower loads.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ....framework.batch import Array
from ....framework.batched.idle import released, released_masses, with_free
from ....framework.batched.plan import Plan
from ....framework.described.parts import IdleRotation
from ....framework.described.released_ends import with_hinges
from ....framework.results import dense
from ....framework.results.shapes import check_count
from ....framework.results.spectrum import AskedModes, above_rounding, found_anew, inverse_pencil, shifted
from ....framework.results.under_load import geometric_stiffness
from ....framework.solution import Solution
from ....framework.solvers.rounding import zero_eigenvalue
from ....framework.states import SolutionState, among
from ..poses.classified import ClassifiedPoses
from .frame import Builder
from .loading import add_loads

# Share of the largest motion of a point below which it counts as at rest.
_STILL = 1e-10
# A multiple of the mass matrix is added to an unstable stiffness until it is positive definite, in so many steps at
# most; this shift is then reduced to the size of the softest mode, in so many steps. Squared frequencies below the last
# share of the shift count as zero.
_RAISES, _NARROWINGS, _NOISE = 12, 3, 1e-6


OF_LINKAGE = AskedModes("frequencies", "the linkage", "give its materials a density, or its links a mass")


def is_loaded(motion: ClassifiedPoses) -> bool:
    """Whether loads, springs or gravity act on the linkage at rest."""
    linkage = motion.linkage
    return bool(linkage.loads or linkage.springs or np.any(linkage.weight))


class Tangent:
    """Tangent stiffness at every pose under the linkage's loads, springs and weights, in the frame's unknowns.

    Parameters
    ----------
    motion
        The motion.
    cut
        Whether members are cut into their segments.

    Attributes
    ----------
    plan
        The compiled frame.
    idle
        Number of rods that can spin between two spherical joints.
    stiffness
        Tangent stiffness matrix, (..., n, n).
    spins
        Values of the unknowns in a unit spin of each of these rods, (..., n, idle).
    stable
        Poses that are assembled, and at which finite forces keep the linkage in equilibrium, (...).
    """

    def __init__(self, motion: ClassifiedPoses, *, cut: bool) -> None:
        built = Builder(motion, clearance=False).frame
        free = released_masses(built) if cut else with_free(built, list(built.idle))
        freed = [idle for name, idle in built.idle.items() if name not in free.idle]
        self.idle = len(freed)
        self.plan = Plan(with_hinges(free), cut=cut)
        clamped = Builder(motion, clearance=False, clamped=True)
        clamped.slacken()
        add_loads(clamped.frame, motion, clamped.nodes)
        at_rest = with_hinges(released(clamped.frame))
        rest = Solution(at_rest, Plan(at_rest, cut=cut))
        self.stable: NDArray[np.bool_] = among(
            rest.own_state, SolutionState.REGULAR, SolutionState.STATICALLY_CONSISTENT_MECHANISM
        )
        with np.errstate(all="ignore"):  # of mechanisms
            loaded = geometric_stiffness(self.plan, rest.bounds.whole())
        self.spins, mean = _spins(self.plan, freed)
        loaded = _without_spin(np.where(self.stable[..., None, None], loaded, 0.0), self.spins, mean)
        self.stiffness = dense.stiffness(self.plan) + loaded

    def compliance_matrix(self, node: str) -> Array:
        """Displacement and rotation of a node by unit forces and moments, global, (..., 6, 6).

        NaN at poses that are not `stable`, and in directions in which the node is kinematically unstable.
        """
        at = self.plan.topology.number[self.plan.frame.aliases.get(node, node)]
        change = dense.global_substitution(self.plan, [at])
        constrained = _unknown_of_each(self.spins)
        matrix, root = dense.scaled(
            np.where(constrained[..., :, None] | constrained[..., None, :], 0.0, self.stiffness)
        )
        values, vectors = np.linalg.eigh(matrix + constrained[..., None] * np.eye(constrained.shape[-1]))
        moved = np.where(constrained[..., None, :], 0.0, change) @ (root[..., :, None] * vectors)
        free = np.abs(values) <= zero_eigenvalue(values.shape[-1])
        out = (moved / np.where(free, np.inf, values)[..., None, :]) @ np.swapaxes(moved, -1, -2)
        # components that a free motion moves have no finite compliance
        size = np.abs(moved).max(axis=-1, keepdims=True, initial=0.0)
        lost = (free[..., None, :] & (np.abs(moved) > _STILL * size)).any(axis=-1)
        reach = np.repeat([self.plan.frame.size, 1.0], 3)[:, None]
        lost = lost | (np.abs(change @ self.spins) > _STILL * reach).any(axis=-1)
        lost = lost[..., :, None] | lost[..., None, :] | ~self.stable[..., None, None]
        return np.where(lost, np.nan, out)

    def frequencies(self, count: int) -> Array:
        """The lowest natural frequencies, Hz, (..., count); NaN at poses that are not `stable`, and for unstable modes.

        Raises
        ------
        FrameError
            If the linkage has no mass, or fewer modes than asked for.
        """
        check_count("frequencies", count, len(self.plan.unknowns) - self.idle)
        return elastic(self._with_idle(count + self.idle), self.idle)

    def _with_idle(self, count: int) -> Array:
        """The lowest frequencies, Hz, (..., count), zeros of idle rotations included."""
        mass = dense.mass(self.plan)
        OF_LINKAGE.require_mass(np.any(mass, axis=(-2, -1)), None)
        shape = np.broadcast_shapes(self.stiffness.shape[:-2], mass.shape[:-2])
        shift = np.zeros(shape)
        for _ in range(_NARROWINGS):
            shift = self._raised(mass, shift)
            squared, vectors = self._squared(mass, shift, count)
            if not shift.any():
                break
            shift = np.minimum(shift, 2.0 * _softest(squared, _NOISE * shift))
        asked = OF_LINKAGE.number(count - self.idle)
        least = np.maximum(shift, squared[..., 0])
        squared, _ = found_anew(self.stiffness, mass, least, squared, vectors, asked)
        squared = np.where(np.abs(squared) <= _NOISE * shift[..., None], 0.0, squared)
        found = np.sqrt(np.where(squared < 0.0, np.nan, squared)) / (2.0 * np.pi)
        return np.where(self.stable[..., None], found, np.nan)

    def _raised(self, mass: Array, shift: Array) -> Array:
        """The shift, raised until ``stiffness + shift mass`` is positive in all motions with mass, (...)."""
        sizes = (np.abs(np.diagonal(each, axis1=-2, axis2=-1)).sum(axis=-1) for each in (self.stiffness, mass))
        ratio = np.divide(*sizes)
        for _ in range(_RAISES):
            matrix, root = dense.scaled(self.stiffness + shift[..., None, None] * mass)
            values, vectors = np.linalg.eigh(matrix)
            zero = zero_eigenvalue(values.shape[-1])
            moved = root[..., :, None] * vectors
            heavy = np.sum(moved * (mass @ moved), axis=-2)
            massless = (np.abs(values) <= zero) & (heavy <= zero * heavy.max(axis=-1, keepdims=True))
            low = ((values <= zero) & ~massless).any(axis=-1)
            if not low.any():
                break
            shift = np.where(low, np.maximum(10.0 * shift, 1e-3 * ratio), shift)
        return shift

    def _squared(self, mass: Array, shift: Array, count: int) -> tuple[Array, Array]:
        """The lowest squared angular frequencies, (..., count), the most negative first, and their modes."""
        matrix, root = dense.scaled(self.stiffness + shift[..., None, None] * mass)
        loose = (np.linalg.eigvalsh(matrix)[..., 0] <= zero_eigenvalue(matrix.shape[-1]))[..., None, None]
        half = np.linalg.cholesky(np.where(loose, np.eye(matrix.shape[-1]), matrix))
        if loose.any():  # some motions have neither stiffness nor mass, and are no modes
            half = np.where(loose, shifted(self.stiffness, mass, shift)[0], half)
        values, vectors = inverse_pencil(half, root, mass, count)
        values = above_rounding(values)
        return 1.0 / values - shift[..., None], vectors / np.sqrt(values)[..., None, :]


def _spins(plan: Plan, freed: list[IdleRotation]) -> tuple[Array, Array]:
    """Unknowns in a unit spin of each rod, and weights of the unknowns in its rotation, (..., n, idle) each.

    The rotation of a rod is the sum of its nodes' rotations about its axis.
    """
    if not freed:
        none = np.zeros((len(plan.unknowns), 0))
        return none, none
    count = len(plan.topology.number)
    change = dense.global_substitution(plan, list(range(count)))
    back = np.swapaxes(change, -1, -2)
    axes = np.stack(np.broadcast_arrays(*(idle.axis for idle in freed)), axis=-1)
    spins = np.zeros((*axes.shape[:-2], count, 6, len(freed)))
    for k, idle in enumerate(freed):
        for node in _nodes_of(plan, idle.body):
            spins[..., node, 3:, k] = idle.axis
    mean = back @ spins.reshape(*axes.shape[:-2], 6 * count, len(freed))
    return np.asarray(np.linalg.solve(back @ change, mean)), mean


def _without_spin(loaded: Array, spins: Array, mean: Array) -> Array:
    """Geometric stiffness, (..., n, n), without the spin of rods, as the mean of their nodes.

    A rod that its load bends stays bent in the same direction while it spins. That is not linear, and would otherwise
    appear as a stiffness against the spin.
    """
    if not spins.shape[-1]:
        return loaded
    mean = np.swapaxes(mean, -1, -2)
    away = loaded - (loaded @ spins) @ np.linalg.solve(mean @ spins, mean)
    back = np.swapaxes(away, -1, -2)
    return np.asarray(back - (back @ spins) @ np.linalg.solve(mean @ spins, mean))


def _unknown_of_each(spins: Array) -> NDArray[np.bool_]:
    """One unknown for each spin, such that locking them prevents all spins, (..., n).

    Locking them does not change the stiffness otherwise. The stiffness of an unknown that is a spin alone is rounding,
    which must not be scaled to the size of the others.
    """
    left, out = spins, np.zeros(spins.shape[:-1], dtype=bool)
    for k in range(spins.shape[-1]):
        row = np.abs(left[..., k]).argmax(axis=-1)[..., None]
        np.put_along_axis(out, row, True, axis=-1)
        pivot = np.take_along_axis(left, row[..., None], axis=-2)
        left = left - left[..., k : k + 1] * (pivot / pivot[..., k : k + 1])
    return out


def _nodes_of(plan: Plan, body: str) -> list[int]:
    """Numbers of the nodes of a body, interior nodes of its members included."""
    frame, number = plan.frame, plan.topology.number
    own = {number[name] for name, node in frame.nodes.items() if node.body == body}
    inside = (
        piece.nodes for piece in plan.topology.pieces if frame.nodes[frame.members[piece.member].start].body == body
    )
    return sorted(own.union(*inside))


def elastic(frequencies: Array, idle: int) -> Array:
    """The frequencies (..., n) without the zeros of idle rotations, (..., n - idle)."""
    zero = (frequencies == 0.0).sum(axis=-1, keepdims=True)
    first = np.minimum(zero, idle) + np.arange(frequencies.shape[-1] - idle)
    return np.take_along_axis(frequencies, first, axis=-1)


def _softest(squared: Array, noise: Array) -> Array:
    """Magnitude of the most negative squared frequency, (...), or else of the smallest one above `noise`."""
    least = np.where(squared > noise[..., None], squared, np.inf).min(axis=-1)
    size = np.where(squared[..., 0] < -noise, -squared[..., 0], least)
    return np.asarray(np.where(np.isfinite(size), size, noise))
