"""Results at all nodes and members at once, with the pieces of a group evaluated as one stack."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from ..batch import Array, rotated
from ..errors import FrameError
from ..structure.topology import Group, Index
from .linear import LinearResults
from .member_field import deflection, end_loads, internal_forces

# A function that returns a field at stations (k, n, ...) of some pieces of a group, given the displacements of, and the
# forces on, their ends.
Field = Callable[[Group, Index, Array, Array, Array], Array]
# Size of a field that is computed at a time, which stays in the processor's cache and limits memory.
_CHUNK = 2**18


class StackedResults:
    """Results from the displacements of all nodes.

    Parameters
    ----------
    solution
        The solution with these displacements.
    """

    def __init__(self, solution: LinearResults) -> None:
        self.solution, self.topology = solution, solution.plan.topology
        self.nodal = solution.nodal()

    def displacements(self) -> Array:
        """Displacements of the described nodes in global axes, (..., nodes, 6)."""
        count = len(self.topology.frame.nodes)
        found = np.array(self.nodal[..., :count, :])
        for node in range(count):
            axes = self.topology.axes(node)
            if axes is not None:
                found[..., node, :] = rotated(axes, found[..., node, :])
        return found

    def end_forces(self) -> Array:
        """Forces on the ends of the members in their local axes, (..., members, 12)."""
        out = np.zeros((*self.solution.shape, len(self.topology.counts), 12))
        starts = np.concatenate([[0], np.cumsum(self.topology.counts)]).astype(np.int64)
        for group, at in self._chunks(12):
            forces = np.moveaxis(self._forces(group, at, self._ends(group, at)), 0, -2)
            member = self.topology.members[group.pieces[at]]
            first, last = (group.pieces[at] == starts[member + side] - side for side in (0, 1))
            out[..., member[first], :6] = forces[..., first, :6]
            out[..., member[last], 6:] = forces[..., last, 6:]
        return out

    def displacements_at(self, fraction: Array) -> Array:
        """Global displacements at fractions (k,) of all members, (..., members, k, 6)."""
        return self._along(fraction, 6, self._displacement)

    def forces_at(self, fraction: Array) -> Array:
        """Internal forces at fractions (k,) of all members, (..., members, k, 6)."""
        return self._along(fraction, 6, self._force)

    def stresses_at(self, fraction: Array) -> Array:
        """Extreme stresses at fractions (k,) of all members, (..., members, k, 3)."""
        return self._along(fraction, 3, self._stress)

    def _along(self, fraction: Array, size: int, field: Field) -> Array:
        """A field of `size` components at the same fractions (k,) of all members, (..., members, k, size).

        NaN for members without that field, such as stress for a section given by its properties alone.
        """
        out = np.zeros((*self.solution.shape, len(self.topology.counts), len(fraction), size))
        counts = self.topology.counts[self.topology.members]
        index = np.arange(len(counts)) - np.repeat(np.cumsum(self.topology.counts), self.topology.counts) + counts
        for group, at in self._chunks(12 * len(fraction)):
            pieces = group.pieces[at]
            # the stations on each piece; the end of the member belongs to its last piece
            on = np.minimum((fraction[:, None] * counts[pieces]).astype(int), counts[pieces] - 1) == index[pieces]
            inside = np.clip(fraction[:, None] * counts[pieces] - index[pieces], 0.0, 1.0)
            length = group.length[at]
            x = inside.reshape(*inside.shape, *(1,) * (length.ndim - 1)) * length
            ends = self._ends(group, at)
            shape = (*on.shape, *self.solution.shape, size)
            try:
                whole = np.broadcast_to(field(group, at, x, ends, self._forces(group, at, ends)), shape)
            except FrameError:  # by name it says why
                whole = np.full(shape, np.nan)
            if on.all():
                found = np.moveaxis(whole, (0, 1), (-2, -3))
                out[..., self.topology.members[pieces], :, :] = found
                continue
            k, n = np.nonzero(on)
            out[..., self.topology.members[pieces[n]], k, :] = np.moveaxis(whole[k, n], 0, -2)
        return out

    # -- fields -----------------------------------------------------------------------------------------------------

    def _displacement(self, group: Group, at: Index, x: Array, ends: Array, forces: Array) -> Array:
        """Global displacement (k, n, ..., 6)."""
        local = deflection(self.topology, group, at, x, ends)
        return rotated(np.swapaxes(group.local_axes[at], -1, -2), local)

    def _force(self, group: Group, at: Index, x: Array, ends: Array, forces: Array) -> Array:
        """Internal forces (k, n, ..., 6)."""
        return internal_forces(self.topology, group, at, x, forces)

    def _stress(self, group: Group, at: Index, x: Array, ends: Array, forces: Array) -> Array:
        """Extreme stresses (k, n, ..., 3)."""
        return group.of(at).stress(x / group.length[at], self._force(group, at, x, ends, forces))

    # -- pieces -----------------------------------------------------------------------------------------------------

    def _chunks(self, numbers: int) -> Iterator[tuple[Group, Index]]:
        """Groups and positions in them, so many pieces at a time that `numbers` for each stay within `_CHUNK`."""
        step = max(1, _CHUNK // (numbers * max(1, int(np.prod(self.solution.shape)))))
        for group in self.topology.groups:
            for start in range(0, len(group.pieces), step):
                yield group, np.arange(start, min(start + step, len(group.pieces)))

    def _ends(self, group: Group, at: Index) -> Array:
        """Displacements of the ends of pieces in their local axes, (n, ..., 12)."""
        both = np.moveaxis(self.nodal[..., group.nodes[at], :], -3, 0)
        with np.errstate(invalid="ignore"):  # of mechanisms, whose entries are masked
            start, end = (rotated(turn[at], both[..., side, :]) for side, turn in enumerate(group.end_axes))
        return np.concatenate([start, end], axis=-1)

    def _forces(self, group: Group, at: Index, ends: Array) -> Array:
        """Forces on the ends of pieces in their local axes, (n, ..., 12)."""
        with np.errstate(all="ignore"):  # of mechanisms, whose entries are masked
            return group.end_forces(at, ends) - end_loads(self.topology, group, at)
