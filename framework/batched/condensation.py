"""Condensation of chains of members to their two end nodes, before anything else is eliminated.

A link may be described as many members in a row, with nodes between them that carry no joint, support or load.
Neighbouring members of a chain are joined in pairs, in all chains at once, by eliminating the node between them: n
members need log2 n such rounds, each a few operations of NumPy on stacked arrays in extended precision (cyclic
reduction: Golub & Van Loan, *Matrix Computations*, 4th ed., 2013, sec. 4.5.4). Only members whose stiffness is constant
over the batch are condensed here: for the others the time goes into the arrays, not into the number of steps.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..cache import KERNELS
from ..ldl import PivotStep, eliminated, sparse_steps
from ..structure.parts import Extended, Row, Value, add_row
from ..structure.topology import Index, Topology
from .order import Pattern, in_turn, link

Real = NDArray[np.floating[Any]]
# Numbers of the nodes of a chain, in order, and of the pieces of members between them.
Chain = tuple[list[int], list[int]]

# Chains are condensed if they have at least this many inner nodes in all.
FEW = 16
# A chain with a pivot ratio below this is not condensed: the later elimination watches rounding more closely.
_SOUND = 1e-10
# Positions of the unknowns of two neighbouring members when those of the node between them come first.
_FIRST, _SECOND = np.r_[6:12, 0:6], np.r_[0:6, 12:18]
_REVERSED = np.r_[6:12, 0:6]
# Entries above the diagonal in the block of the two outer nodes.
_ABOVE = tuple(each + 6 for each in np.triu_indices(12, 1))


def chains(topology: Topology, excluded: set[int]) -> list[Chain]:
    """Chains of members whose inner nodes connect two constant members and nothing else; none where they are few.

    Parameters
    ----------
    topology
        Nodes and members.
    excluded
        Numbers of the nodes with joints, supports or loads.

    Returns
    -------
    list
        For each chain its nodes and the pieces between them, none of which varies over the batch.
    """
    if len(topology.number) < FEW:
        return []
    fixed = np.zeros(len(topology.ends), dtype=bool)
    for group in topology.groups:
        fixed[group.pieces] = set(group.stiffness_shape) <= {1}
    if not fixed.any():
        return []
    inside = np.bincount(topology.ends.reshape(-1), minlength=len(topology.number)) == 2
    inside[topology.ends[~fixed]] = False
    inside[list(excluded)] = False
    if inside.sum() < FEW:
        return []
    found = _walked(topology.ends, inside)
    return found if sum(len(nodes) - 2 for nodes, _ in found) >= FEW else []


def loaded(topology: Topology) -> set[int]:
    """Numbers of the nodes with loads, those of loaded members included."""
    frame = topology.frame
    if frame.weight is not None:
        return set(range(len(topology.number)))
    pieces = [piece for member in frame.member_loads for piece in topology.pieces_of[member]]
    if topology.strained:
        pieces += [piece for group in topology.groups if group.strained for piece in group.pieces.tolist()]
    along = topology.ends[pieces].reshape(-1).tolist() if pieces else ()
    return {topology.number[name] for name in frame.loads}.union(along)


def _walked(ends: Index, inside: NDArray[np.bool_]) -> list[Chain]:
    """Chains from one node that is not `inside` along nodes that are, to the next that is not."""
    at: dict[int, list[int]] = {}
    pairs, within = ends.tolist(), inside[ends].tolist()
    for piece, (pair, are) in enumerate(zip(pairs, within, strict=True)):
        for node, is_inside in zip(pair, are, strict=True):
            if is_inside:
                at.setdefault(node, []).append(piece)
    found, taken = [], set()
    for first in np.flatnonzero(inside[ends].sum(axis=1) == 1).tolist():
        if first in taken:
            continue
        nodes, pieces = [pairs[first][within[first][0]]], [first]
        while True:
            here = sum(pairs[pieces[-1]]) - nodes[-1]
            nodes.append(here)
            if here not in at:
                break
            one, other = at[here]
            pieces.append(other if pieces[-1] == one else one)
        taken.update(pieces)
        if nodes[0] != nodes[-1]:
            found.append((nodes, pieces))
    return found


@dataclass(frozen=True)
class _Round:
    """One round of the condensation, in which p nodes are eliminated together.

    Attributes
    ----------
    first, between, last
        Places, among the nodes of all chains, of the eliminated nodes (`between`) and of their two neighbours, (p,).
    lower
        For each component of the eliminated node its column of L, over its own components and those of the two
        neighbours, (6, 18, p).
    """

    first: Index
    between: Index
    last: Index
    lower: Real

    @property
    def shares(self) -> Real:
        """Displacements of the eliminated node per unit displacement of its two neighbours, (6, 12, p)."""
        out: Real = np.zeros((6, 12, len(self.between)), dtype=Extended)
        for k in reversed(range(6)):
            out[k] = -self.lower[k, 6:] - (self.lower[k, :6, None] * out).sum(axis=0)
        return out


class Condensation:
    """Chains of members, each condensed to one stiffness matrix between its ends.

    Parameters
    ----------
    topology
        Nodes and members.
    chains
        The chains, see `chains`.

    Attributes
    ----------
    chains
        The chains that were condensed: without those that are almost singular, such as with hinges in a row.
    pieces
        Numbers of the pieces of members in them, (m,).
    coupled
        Pairs of DOF numbers that these pieces couple, (pairs, 2).
    stiffness
        Stiffness between the ends, in the axes of their nodes, (chains, 12, 12).
    scale
        Scale of its diagonal: the stiffness whose rounding it contains, (chains, 12).
    """

    pieces: Index
    coupled: Index
    stiffness: Real
    scale: Real
    _rounds: list[_Round]

    def __init__(self, topology: Topology, chains: list[Chain]) -> None:
        if not chains:
            self.chains, self._rounds = chains, []
            self.pieces, self.coupled = np.zeros(0, dtype=np.int64), np.zeros((0, 2), dtype=np.int64)
            self.stiffness, self.scale = np.zeros((0, 12, 12), dtype=Extended), np.zeros((0, 12), dtype=Extended)
            return
        self._take(topology, chains)
        sound = self._joined()
        if not sound.all():
            self._take(topology, [chain for chain, is_sound in zip(chains, sound, strict=True) if is_sound])
            self._joined()
        del self._each

    @property
    def dofs(self) -> Index:
        """DOF numbers of the ends, (chains, 12)."""
        ends = np.array([(nodes[0], nodes[-1]) for nodes, _ in self.chains], dtype=np.int64).reshape(-1, 2)
        return (6 * ends[:, :, None] + np.arange(6)).reshape(-1, 12)

    @cached_property
    def nodes(self) -> dict[int, tuple[int, int]]:
        """For each eliminated node its chain, and its place among the nodes of all chains."""
        starts = np.cumsum([0, *(len(nodes) for nodes, _ in self.chains)]).tolist()
        each = enumerate(zip(self.chains, starts, strict=False))
        return {
            node: (c, at + k) for c, ((nodes, _), at) in each for k, node in enumerate(nodes) if 0 < k < len(nodes) - 1
        }

    @cached_property
    def excess(self) -> dict[int, Value]:
        """By DOF number: `scale` less the diagonal of the stiffness, summed over the chains."""
        more = self.scale - self.stiffness[:, np.arange(12), np.arange(12)]
        out: dict[int, Value] = {}
        for dof, value in zip(self.dofs.reshape(-1).tolist(), more.reshape(-1), strict=True):
            out[dof] = out.get(dof, 0.0) + value
        return out

    @property
    def operations(self) -> int:
        """Number of multiplications and subtractions of the elimination."""
        return len(self.nodes) * sum(below * (below + 2) for below in range(12, 18))

    def spread(self, dof: int) -> Row:
        """The row of a displacement of an eliminated node, over the displacements of the ends of its chain."""
        node, k = divmod(dof, 6)
        chain, place = self.nodes[node]
        return {
            end: share for end, share in zip(self.dofs[chain].tolist(), self._shares[k, :, place], strict=True) if share
        }

    @cached_property
    def _shares(self) -> Real:
        """Displacements of all nodes of the chains per unit displacement of their ends, (6, 12, nodes)."""
        last = np.cumsum([len(nodes) for nodes, _ in self.chains], dtype=np.int64) - 1
        first = np.append(0, last[:-1] + 1)
        out: Real = np.zeros((6, 12, last[-1] + 1), dtype=Extended)
        out[:, :6, first] = out[:, 6:, last] = np.eye(6)[..., None]
        for each in reversed(self._rounds):
            shares = each.shares
            near = np.concatenate([out[..., each.first], out[..., each.last]])
            out[..., each.between] = sum(shares[:, j, None] * near[j] for j in range(12))
        return out

    def _take(self, topology: Topology, chains: list[Chain]) -> None:
        """Set `chains`, and compute the stiffness of their pieces, each directed along its chain."""
        self.chains = chains
        self.pieces = np.array([piece for _, pieces in chains for piece in pieces], dtype=np.int64)
        before = np.array([node for nodes, _ in chains for node in nodes[:-1]], dtype=np.int64)
        after = np.array([node for nodes, _ in chains for node in nodes[1:]], dtype=np.int64)
        place = np.full(len(topology.ends), -1)
        place[self.pieces] = np.arange(len(self.pieces))
        each: Real = np.zeros((12, 12, len(self.pieces)), dtype=Extended)
        for group in topology.groups:
            where = place[group.pieces]
            mine = np.flatnonzero(where >= 0)
            if len(mine):
                each[..., where[mine]] = np.moveaxis(group.part(mine).extended_stiffness().reshape(-1, 12, 12), 0, -1)
        back = topology.ends[self.pieces, 0] != before
        each[..., back] = each[..., back][_REVERSED][:, _REVERSED]
        i, j, piece = np.nonzero(each)
        dofs = np.stack([6 * before + k for k in range(6)] + [6 * after + k for k in range(6)])
        self.coupled = np.stack([dofs[i, piece], dofs[j, piece]], axis=-1)
        self._each = each

    def _joined(self) -> NDArray[np.bool_]:
        """Join neighbours until one matrix is left of each chain; whether its pivots are above rounding, (chains,)."""
        each = self._each
        chain = np.repeat(np.arange(len(self.chains)), [len(pieces) for _, pieces in self.chains])
        first = np.arange(len(chain)) + chain
        last = first + 1
        scale = each[np.arange(12), np.arange(12)]
        sound = np.ones(len(self.chains), dtype=bool)
        self._rounds = []
        while len(chain) > len(self.chains):
            even = (np.arange(len(chain)) - np.searchsorted(chain, chain)) % 2 == 0
            left = np.flatnonzero(even[:-1] & (chain[1:] == chain[:-1]))
            with np.errstate(all="ignore"):
                each[..., left], scale[..., left], lower, least = _condensed(
                    each[..., left], each[..., left + 1], scale[..., left], scale[..., left + 1]
                )
            sound[chain[left[~(least > _SOUND)]]] = False
            self._rounds.append(_Round(first[left], last[left], last[left + 1], lower))
            last[left] = last[left + 1]
            kept = np.delete(np.arange(len(chain)), left + 1)
            each, scale, chain, first, last = each[..., kept], scale[..., kept], chain[kept], first[kept], last[kept]
        self.stiffness = np.moveaxis(each, -1, 0)
        self.scale = scale.T
        return sound


def _condensed(left: Real, right: Real, scale: Real, other: Real) -> tuple[Real, Real, Real, Real]:
    """Two neighbours (12, 12, p) joined: their stiffness (12, 12, p), scale (12, p), columns of L (6, 18, p) and least
    pivot ratio (p,).
    """
    whole: Real = np.zeros((18, 18, left.shape[-1]), dtype=Extended)
    whole[np.ix_(_FIRST, _FIRST)] = left
    whole[np.ix_(_SECOND, _SECOND)] += right
    weight: Real = np.zeros((18, left.shape[-1]), dtype=Extended)
    weight[_FIRST] = scale
    weight[_SECOND] += other
    lower: Real = np.zeros((6, 18, left.shape[-1]), dtype=Extended)
    least = np.full(left.shape[-1], np.inf, dtype=Extended)
    coupled: NDArray[np.bool_] = (whole[:6] != 0.0).any(axis=-1)
    steps, work = _steps(coupled), whole.reshape(-1, left.shape[-1])
    for step, (low, _) in zip(steps, eliminated(work, steps), strict=True):
        k = step.unknown
        lower[k, step.below] = low
        least = np.minimum(least, work[step.pivot] / weight[k])
        weight[step.below] += low * low * weight[k]
    whole[_ABOVE] = whole[_ABOVE[::-1]]
    return whole[6:, 6:], weight[6:], lower, least


def _steps(coupled: NDArray[np.bool_]) -> tuple[PivotStep, ...]:
    """Steps that eliminate the node between two neighbours; `coupled` (6, 18) tells which entries are not zero."""

    def make() -> tuple[PivotStep, ...]:
        pattern: Pattern = {k: {k: 0} for k in range(18)}
        for k, i in np.argwhere(coupled).tolist():
            link(pattern, k, i, 0)
        pivots = in_turn(pattern, range(6)).below.items()
        return sparse_steps(pivots, {(i, j): 18 * i + j for i in range(18) for j in range(i + 1)})

    found: tuple[PivotStep, ...] = KERNELS.found(("neighbours", coupled.tobytes()), make, 18)
    return found


def retained(row: Row, condensed: Condensation, rows: dict[int, list[Row]]) -> Row:
    """`row` with the unknowns of condensed nodes replaced by those of the ends of their chains.

    Parameters
    ----------
    row
        Factors by unknown and right-hand-side parameter.
    condensed
        The condensed chains.
    rows
        By node on joints, the rows of its six displacements.
    """
    if not any(k // 6 in condensed.nodes for k in row if k >= 0):
        return row
    out: Row = {}
    for k, factor in row.items():
        if k < 0 or k // 6 not in condensed.nodes:
            add_row(out, {k: 1.0}, factor)
            continue
        for dof, share in condensed.spread(k).items():
            node, c = divmod(dof, 6)
            term: Value = factor * share
            add_row(out, rows[node][c] if node in rows else {dof: 1.0}, term)
    return out
