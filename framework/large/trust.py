"""What is left of the error of an equilibrium: unbalanced forces, and the rounding in them, through the tangent."""

from __future__ import annotations

import numpy as np

from .. import rotation
from ..batch import Array
from ..elementwise import contracted
from .elimination import LARGE, ConstrainedFactor, StackFactor, SymbolicFactorisation
from .equations import EquilibriumEquations
from .model import Model
from .newton import Newton
from .protocols import Index, Mask
from .rounding import ForceRounding
from .state import DisplacedState

# Share of a free motion below which a displacement takes no part in it.
_STILL = 1e-6
_EPS = float(np.finfo(np.float64).eps)


class SingularTangents:
    """Tangents of which some eigenvalues are rounding.

    Parameters
    ----------
    elimination
        Their pattern.
    values
        The tangents (entries, m).
    zero
        Eigenvalue that is rounding.
    """

    def __init__(self, elimination: SymbolicFactorisation, values: Array, zero: float) -> None:
        self.root, self.values, self.vectors = elimination.spectrum(values)
        # the least is, as no factor told it from rounding
        self.free = np.abs(self.values) <= np.maximum(zero, np.abs(self.values).min(axis=1, keepdims=True))

    def solve(self, load: Array) -> Array:
        """Solution for loads (n, m), free motions left out."""
        share = np.where(self.free, 0.0, self._share(load) / np.where(self.free, 1.0, self.values))
        return np.asarray(np.einsum("mij,mj,mi->im", self.vectors, share, self.root))

    def moves(self, load: Array) -> Mask:
        """Whether a load does work on a free motion (m,)."""
        share = np.abs(self._share(load))
        size = np.sqrt((share * share).sum(axis=1, keepdims=True))
        return np.asarray((self.free & (share > _STILL * size)).any(axis=1))

    def _share(self, load: Array) -> Array:
        out: Array = np.einsum("mji,mj,jm->mi", self.vectors, self.root, load)
        return out


class Trust:
    """Bounds on the numerical error, of first order, at all entries.

    Parameters
    ----------
    newton
        Iterations on the model.
    equations, state
        The whole batch and where it is, in space.
    neutral
        Entries at which some motion is free (m,).
    """

    def __init__(
        self, newton: Newton, equations: EquilibriumEquations, state: DisplacedState, neutral: Mask | None = None
    ) -> None:
        self.model: Model = equations.model
        self.equations, self.state = equations, state
        self.at = equations.linearised(state)
        _, rows, columns = self.model.pattern
        elimination = SymbolicFactorisation(rows, columns, self.model.free)
        if newton.multiplier_count:
            self.factor: StackFactor = ConstrainedFactor(elimination.dense(self.at.values), newton.multiplier_count)
        else:
            self.factor = elimination.factor(self.at.values, symmetric=self.model.symmetric)
        self.wrong = np.abs(self.at.forces) + ForceRounding(equations, state, self.at).forces()
        some = np.zeros(0, dtype=np.int64) if neutral is None else np.flatnonzero(neutral)
        self.neutral: Index = some
        if len(some) and self.model.free <= LARGE and not newton.multiplier_count:
            self.free_motion: SingularTangents | None = SingularTangents(
                elimination, self.at.values[:, some], newton.free
            )
        else:
            self.free_motion = None

    def bound(self, node: int) -> Array:
        """Bound on displacement and spin of a node (6, m): what the wrong forces do at their worst."""
        chain = np.array(self.model.chains[node])
        jacobian = self.at.jacobians.get(node)
        rows = np.broadcast_to(np.eye(6)[..., None], (6, 6, self.equations.count)) if jacobian is None else jacobian
        out = np.zeros((6, self.equations.count))
        inside = np.flatnonzero((chain >= 0) & (chain < self.model.free))
        for k in range(6):
            load = np.zeros((self.model.free, self.equations.count))
            load[chain[inside]] = rows[k, inside]
            worst = contracted("im,im->m", np.abs(self.factor.solve(load)), self.wrong[: self.model.free])
            out[k] = np.where(np.isnan(worst), np.inf, worst)  # nothing is known where something moves freely
            if len(self.neutral):
                out[k, self.neutral] = self._beside(load[:, self.neutral])
        size = np.concatenate([self.state.displacements[:, node], rotation.logarithm(self.state.rotations[:, node])])
        return np.asarray(out + 2.0 * _EPS * np.abs(size))

    def _beside(self, load: Array) -> Array:
        """The same for a displacement of neutral entries that is the work of `load` (free, n): inf where it is free."""
        if self.free_motion is None:
            return np.where(load.any(axis=0), np.inf, 0.0)
        wrong = self.wrong[: self.model.free, self.neutral]
        worst = contracted("im,im->m", np.abs(self.free_motion.solve(load)), wrong)
        return np.where(self.free_motion.moves(load), np.inf, worst)
