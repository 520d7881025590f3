"""Stiffness of a linkage about its loaded pose: that of links and joints, and what turning does to the forces in them.

At rest a pose is held by its drives, under the forces of springs, loads and weights. The second derivative of the
potential along any small motion is then that of the strain energy plus, for each member, joint and rigid link, the
force in it times the second derivative of what it works on, kinematics of second order included (see
`linkframe.framework.results.geometric`): springs pull along their line. Loads keep their direction; of those
that turn with a link the turning is left out.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ....framework.batch import Array
from ....framework.batched.plan import Plan
from ....framework.errors import FrameError
from ....framework.results import dense
from ....framework.results.shapes import check_count
from ....framework.results.spectrum import inverse_pencil
from ....framework.results.under_load import geometric_stiffness
from ....framework.solution import Solution
from ....framework.solvers.rounding import zero_eigenvalue
from ....framework.states import SolutionState, among
from ..poses.classified import ClassifiedPoses
from .frame import Builder
from .loading import add_loads

# Share of a point's motion by unit forces that is none.
_STILL = 1e-10
# An unstable stiffness is raised by a share of the mass, which is narrowed down to the lowest frequencies sought in so
# many steps; squared frequencies below this share of it are zero.
_RAISES, _NARROWINGS, _NOISE = 12, 3, 1e-6


def is_loaded(motion: ClassifiedPoses) -> bool:
    """Whether anything acts on the linkage at rest."""
    linkage = motion.linkage
    return bool(linkage.loads or linkage.springs or np.any(linkage.weight))


class Tangent:
    """The stiffness at every pose under what acts on the linkage, in the frame's unknowns.

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
    stiffness
        (..., n, n).
    stable
        Poses that are assembled, and at which finite forces keep the linkage in equilibrium, (...).
    """

    def __init__(self, motion: ClassifiedPoses, *, cut: bool) -> None:
        self.plan = Plan(Builder(motion, clearance=False).frame, cut=cut)
        clamped = Builder(motion, clearance=False, clamped=True)
        clamped.slacken()
        add_loads(clamped.frame, motion, clamped.nodes)
        rest = Solution(clamped.frame, Plan(clamped.frame, cut=cut))
        self.stable: NDArray[np.bool_] = among(
            rest.own_state, SolutionState.REGULAR, SolutionState.STATICALLY_CONSISTENT_MECHANISM
        )
        with np.errstate(all="ignore"):  # of mechanisms
            loaded = geometric_stiffness(self.plan, rest.bounds.whole())
        loaded = np.where(self.stable[..., None, None], loaded, 0.0)
        self.stiffness = dense.stiffness(self.plan) + loaded

    def compliance_matrix(self, node: str) -> Array:
        """Displacement and rotation of a node by unit forces and moments, global, (..., 6, 6).

        NaN where the linkage is not locked, and in what is kinematically unstable.
        """
        at = self.plan.topology.number[self.plan.frame.aliases.get(node, node)]
        change = dense.global_substitution(self.plan, [at])
        matrix, root = dense.scaled(self.stiffness)
        values, vectors = np.linalg.eigh(matrix)
        moved = change @ (root[..., :, None] * vectors)
        free = np.abs(values) <= zero_eigenvalue(values.shape[-1])
        out = (moved / np.where(free, np.inf, values)[..., None, :]) @ np.swapaxes(moved, -1, -2)
        # what a free motion moves has no compliance
        size = np.abs(moved).max(axis=-1, keepdims=True)
        lost = (free[..., None, :] & (np.abs(moved) > _STILL * size)).any(axis=-1)
        lost = lost[..., :, None] | lost[..., None, :] | ~self.stable[..., None, None]
        return np.where(lost, np.nan, out)

    def frequencies(self, count: int) -> Array:
        """The lowest natural frequencies, Hz, (..., count); NaN where the linkage is not held or is unstable.

        Raises
        ------
        FrameError
            Where the linkage has no mass, or fewer modes than asked for.
        """
        check_count("frequencies", count, len(self.plan.unknowns))
        mass = dense.mass(self.plan)
        if not np.any(mass):
            raise FrameError("frequencies: the linkage has no mass: give its materials a density, or its links a mass")
        shape = np.broadcast_shapes(self.stiffness.shape[:-2], mass.shape[:-2])
        shift = np.zeros(shape)
        for _ in range(_NARROWINGS):
            shift = self._raised(mass, shift)
            squared = self._squared(mass, shift, count)
            if not shift.any():
                break
            # closer to what is sought, of which a large shift takes digits
            lowest = np.abs(squared).max(axis=-1)
            shift = np.where(shift > 0.0, np.minimum(shift, 2.0 * lowest), 0.0)
        squared = np.where(np.abs(squared) <= _NOISE * shift[..., None], 0.0, squared)
        found = np.sqrt(np.where(squared < 0.0, np.nan, squared)) / (2.0 * np.pi)
        return np.where(self.stable[..., None], found, np.nan)

    def _raised(self, mass: Array, shift: Array) -> Array:
        """The shift, or a larger one, at which ``stiffness + shift mass`` has no eigenvalue that is zero or less."""
        sizes = (np.abs(np.diagonal(each, axis1=-2, axis2=-1)).sum(axis=-1) for each in (self.stiffness, mass))
        ratio = np.divide(*sizes)
        for _ in range(_RAISES):
            raised = self.stiffness + shift[..., None, None] * mass
            low = np.linalg.eigvalsh(dense.scaled(raised)[0])[..., 0] <= zero_eigenvalue(raised.shape[-1])
            if not low.any():
                break
            shift = np.where(low, np.maximum(10.0 * shift, 1e-3 * ratio), shift)
        return shift

    def _squared(self, mass: Array, shift: Array, count: int) -> Array:
        """The lowest squared circular frequencies, (..., count), the most negative first."""
        matrix, root = dense.scaled(self.stiffness + shift[..., None, None] * mass)
        values, _ = inverse_pencil(np.asarray(np.linalg.cholesky(matrix)), root, mass, count)
        if np.any(values <= np.finfo(float).eps * np.abs(values[..., :1])):
            raise FrameError(f"frequencies({count}): the linkage has fewer modes with mass: ask for fewer")
        squared: Array = 1.0 / values - shift[..., None]
        return squared
