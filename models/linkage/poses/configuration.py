"""Assembled positions of a linkage with its drives released: zeros of its closing equations, and its free motions."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ....framework import rotation
from ....framework.batch import Array, one_entry
from ..continuation.start import not_assembled
from ..description.linkage_description import LinkageDescription
from ..kinematics.extent import extent
from ..kinematics.loops import Loops
from ..kinematics.mechanism import compiled
from ..kinematics.nearest import nearest, widest
from ..kinematics.spindles import spindles, turning_units
from ..kinematics.terms import Value

# Ratio to the largest singular value below which one counts as zero. Closed positions are accurate to some 1e-15, and
# to 1e-8 near a singular one.
DEPENDENT = 1e-7
# Relative difference below which two equations may have been meant to be equal.
ALIKE = 1e-3
FEW_DIGITS = "if it is meant to move, its points have too few digits: give more, or give tolerance="
# Largest residual of a closed position, in units of the linkage's extent and radians.
CLOSED = 1e-12
ITERATIONS = 60
# Entry of a batch: one index an axis; None for the first entry.
Entry = int | tuple[int, ...] | None


class Configurations:
    """Assembled positions of one linkage as the zeros of its closing equations in all of its joint coordinates.

    Lengths are divided by the linkage's extent, so that results do not depend on the unit of length.

    Parameters
    ----------
    linkage
        The description.
    tolerance
        Largest gap of an assembled position, a length.
    entry
        Entry of the batch.
    by_travel
        Whether the angles of spindles count as the travel of their screws, where that is less.

    Attributes
    ----------
    spindles
        Names of the links whose angles count so.
    dependent
        Ratio to the largest singular value below which one counts as zero.
    size
        The mechanism's size at the entry.
    row_units, units
        Units of the equations and of the joint coordinates, in which lengths count in extents of the linkage.
    """

    def __init__(
        self, linkage: LinkageDescription, tolerance: float = 0.0, entry: Entry = None, *, by_travel: bool = False
    ) -> None:
        self.mechanism = compiled(linkage)
        first = (0,) * len(linkage.shape)
        self.entry = one_entry(linkage.shape, first if entry is None else entry, "the linkage")
        sizes = extent(linkage)
        size = float(sizes[self.entry])
        self.tolerance = tolerance / size
        self.dependent = max(DEPENDENT, 10.0 * self.tolerance)
        self.parameters = [float(self.of_entry(number)) for number in self.mechanism.parameters]
        self.size = float(self.of_entry(self.mechanism.size))
        self._share = self.size / size
        self.row_units: Array
        self.row_units, self.units = (
            np.array([self._share if component[0] == "u" else 1.0 for _, component in names])
            for names in (self.mechanism.rows, self.mechanism.columns)
        )
        self.spindles = tuple(
            link for link, each in spindles(linkage, sizes).items() if by_travel and each.lead[self.entry]
        )
        for place, unit in turning_units(linkage, self.mechanism.columns, sizes).items():
            if by_travel:
                self.units[place] = unit[self.entry]

    def of_entry(self, number: Value) -> Value:
        """Value of a number of the description at the entry."""
        return number if np.ndim(number) == 0 else np.broadcast_to(number, self.mechanism.linkage.shape)[self.entry]

    @cached_property
    def reference_state(self) -> Array:
        """State in the reference configuration, (s,)."""
        state = np.zeros(self.mechanism.entries)
        state[[start for start, _ in self._spherical]] = 1.0
        closed = self.closed(state)
        if closed is None:
            parameters = [np.array(number) for number in self.parameters]
            best, error = nearest(Loops(self.mechanism), [np.array(x) for x in state], parameters)
            row = widest(Loops(self.mechanism), best, parameters)
            raise not_assembled(self.mechanism.rows[int(row)][0], float(error) * self.size)
        return closed

    def jacobian(self, state: Array) -> Array:
        """Jacobian of the closing equations by the joint coordinates, dimensionless, (m, n)."""
        m, n = len(self.mechanism.rows), len(self.mechanism.columns)
        entries = self.mechanism.all_entries[0](state.tolist(), self.parameters)
        matrix: Array = np.array(entries, dtype=np.float64).reshape(m, n) * self.row_units[:, None] / self.units
        return matrix

    def gap(self, state: Array) -> Array:
        """Residuals of the closing equations, dimensionless, (m,)."""
        off = np.array(self.mechanism.residual[0](state.tolist(), self.parameters), dtype=np.float64)
        return np.asarray(off * self.row_units)

    def advanced(self, state: Array, step: Array) -> Array:
        """State after a step (n,) of the joint coordinates."""
        out, change = state.copy(), step / self.units
        out[self._single_states] += change[self._single_columns]
        for start, column in self._spherical:
            turn = rotation.exponential(change[column : column + 3])
            out[start : start + 4] = rotation.normalised(rotation.product(turn, state[start : start + 4]))
        return out

    def unit(self, state: Array) -> Array:
        """State with the Euler parameters of all spherical joints scaled to unit length."""
        out = state.copy()
        for start, _ in self._spherical:
            out[start : start + 4] /= np.linalg.norm(out[start : start + 4])
        return out

    def closed(self, state: Array, locked: tuple[int, ...] = (), tolerance: float = 0.0) -> Array | None:
        """The closed state nearest to `state`, by the Gauss-Newton method; None if there is none near.

        The columns `locked` do not move. `tolerance` is the largest residual, dimensionless, if above that of the
        space.
        """
        for _ in range(ITERATIONS):
            gap = self.gap(state)
            if not gap.size or np.abs(gap).max() < 1e-15:
                return state
            matrix, gap = self.locked_equations(state, locked), gap[self.mechanism.acting]
            inverse: Array = np.asarray(np.linalg.pinv(matrix, rcond=self.dependent), dtype=np.float64)
            step = -inverse @ np.append(gap, np.zeros(len(locked)))
            state = self.advanced(state, step)
            if np.abs(step).max() < 1e-14 or not np.abs(step).max() < 1.0:
                break
        return state if np.abs(self.gap(state)).max() < max(CLOSED, self.tolerance, tolerance) else None

    def free(self, state: Array, locked: tuple[int, ...] = ()) -> Array:
        """Orthonormal free motions (n, k), in which the columns `locked` do not move."""
        return null_space(self.locked_equations(state, locked), share=self.dependent)

    def locked_equations(self, state: Array, locked: tuple[int, ...]) -> Array:
        """Jacobian of the acting closing equations, and a unit row for each locked column, (m + l, n)."""
        jacobian = self.jacobian(state)[self.mechanism.acting]
        return np.vstack([jacobian, np.eye(jacobian.shape[1])[list(locked)]])

    def places(self, state: Array) -> Array:
        """Reference points and axes of all links, dimensionless, (links, 12)."""
        links = self.mechanism.linkage.links
        numbers = np.array(self.mechanism.poses[0](state.tolist(), self.parameters)).reshape(len(links), 12)
        numbers[:, :3] *= self._share
        return numbers

    def speeds(self, state: Array, motions: Array) -> Array:
        """Angular velocity and velocity of the reference point of each link in motions (n, k), (links, 6, k)."""
        links, still = self.mechanism.linkage.links, (0.0,) * len(self.units)
        out = np.zeros((len(links), 6, motions.shape[1]))
        for k, motion in enumerate(motions.T):
            rates = self.mechanism.rates[0](state.tolist(), self.parameters, (motion / self.units).tolist(), still)
            out[:, :, k] = np.array(rates).reshape(len(links), 12)[:, :6]
        out[:, 3:] *= self._share
        return out

    def idle(self, state: Array) -> tuple[str, ...]:
        """Links that can move while all others and the drives stand still."""
        free = self.free(state, tuple(self.mechanism.driven))
        speeds = self.speeds(state, free)
        found = []
        for k, link in enumerate(self.mechanism.linkage.links):
            alone = null_space(
                np.concatenate([*speeds[:k], *speeds[k + 1 :], np.zeros((0, free.shape[1]))]), 1.0, self.dependent
            )
            if np.abs(speeds[k] @ alone).max(initial=0.0) > self.dependent:
                found.append(link)
        return tuple(found)

    def in_joint_axes(self, state: Array) -> Array:
        """The Jacobian, (m, n), with the position components of each joint along the joint's own axes."""
        jacobian, rows = self.jacobian(state), self.mechanism.rows
        for pair in self.mechanism.tree.cuts:
            places = [k for k, (name, component) in enumerate(rows) if name == pair.name and component[0] == "u"]
            if len(places) == 3:
                axes = self.mechanism.joint_axes(pair)[0](state.tolist(), self.parameters)
                jacobian[places] = np.array(axes, dtype=np.float64).reshape(3, 3) @ jacobian[places]
        return jacobian

    @cached_property
    def _spherical(self) -> list[tuple[int, int]]:
        kinds = {name: self.mechanism.linkage.joint(name).kind.name for name in self.mechanism.states}
        return [
            (self.mechanism.states[name].start, self.mechanism.velocities[name].start)
            for name, kind in kinds.items()
            if kind == "spherical"
        ]

    @cached_property
    def _singles(self) -> list[tuple[int, int]]:
        balls = {start for start, _ in self._spherical}
        return [
            (state, column)
            for name, those in self.mechanism.states.items()
            if those.start not in balls or those.start == those.stop
            for state, column in zip(
                range(those.start, those.stop),
                range(self.mechanism.velocities[name].start, self.mechanism.velocities[name].stop),
                strict=True,
            )
        ]

    @property
    def _single_states(self) -> NDArray[np.intp]:
        return np.array([state for state, _ in self._singles], dtype=np.intp)

    @property
    def _single_columns(self) -> NDArray[np.intp]:
        return np.array([column for _, column in self._singles], dtype=np.intp)


def null_space(matrix: Array, size: float | None = None, share: float = DEPENDENT) -> Array:
    """Orthonormal right singular vectors (n, k) of a matrix (m, n) below a share of `size`, or of its norm."""
    if not matrix.size:
        return np.eye(matrix.shape[1])
    _, values, right = np.linalg.svd(matrix)
    rank = int(np.count_nonzero(values > share * (values[0] if size is None else size)))
    return np.asarray(right[rank:].T)
