"""Which way a frame is solved, and why."""

from __future__ import annotations

from dataclasses import dataclass
from importlib.util import find_spec
from typing import Protocol

import numpy as np

from ..batch import Same
from ..errors import FrameError
from ..structure.parts import mask_of
from ..structure.topology import Topology
from .coupling import Coupling
from .estimate import banded, broadcast, extended, few, one, recorded
from .graph import Graph
from .load_cases import Loaded, count

BROADCAST, BANDED, SPARSE, CHOLESKY, ITERATIVE = METHODS = ("broadcast", "banded", "sparse", "cholesky", "iterative")

# Unknowns above which a frame that does not vary goes a sparse way; and up to which one that does is broadcast, members
# in line condensed.
LARGE, FEW = 100, 48
# The same of a frame without joints that stands still.
_FEWEST = 24
# What was seen on one machine: operations a second of a factorisation; seconds that an iteration takes for an entry of
# the matrix; and iterations that a lattice needs. Only their ratios matter.
_RATE = {BANDED: 4e10, SPARSE: 5e9, CHOLESKY: 3e10}
# Nodes along a frame from which on bands may take longer than broadcasting, which nothing refines, and how many times.
_SLENDER, _PATIENCE = 18.0, 3.0
# Operations of a banded factor up to which it takes less time than to look for anything better.
_SMALL = 2e8
# Width up to which what is better saves no more than it takes to look for it, and operations of a band that is light.
_NARROW, _LIGHT = 300, 4e9
# Entries up to which a band is held.
_BAND = 4e8
_ITERATION = 0.4e-9
_ITERATIONS = 500


@dataclass(frozen=True)
class Method:
    """How a frame is solved.

    Attributes
    ----------
    name
        ``broadcast``, ``banded``, ``sparse``, ``cholesky`` or ``iterative``.
    reason
        Why so, in words.
    seconds
        What it is expected to take, about; NaN where it was asked for.
    """

    name: str
    reason: str
    seconds: float = np.nan


class Compiled(Loaded, Protocol):
    """What the choice depends on: a plan."""

    @property
    def constant(self) -> bool:
        """Whether the stiffness does not vary over the batch."""
        ...

    @property
    def unknowns(self) -> list[int]:
        """All unknowns."""
        ...

    @property
    def graph(self) -> Graph:
        """Nodes and their coupling."""
        ...

    @property
    def topology(self) -> Topology:
        """Nodes and members."""
        ...

    @property
    def chains(self) -> list[tuple[list[int], list[int]]]:
        """Nodes and pieces of members in line that are condensed to their ends."""
        ...

    @property
    def rough_coupling(self) -> Coupling:
        """What the equations are sums of, by the first entry of the batch."""
        ...


def available() -> bool:
    """Whether cvxopt, and with it CHOLMOD, is installed."""
    return find_spec("cvxopt") is not None


def checked(name: str | None) -> str | None:
    """A method that is known and installed.

    Raises
    ------
    FrameError
        Where it is not.
    """
    if name is not None and name not in METHODS:
        raise FrameError(f"method {name!r} is unknown: use one of {', '.join(METHODS)}, or None to let the plan choose")
    if name == CHOLESKY and not available():
        raise FrameError("method 'cholesky' needs cvxopt: install linkframe[fast], or use 'sparse' or 'iterative'")
    return name


def choose(plan: Compiled, asked: str | None) -> Method:
    """The way for a plan: the one asked for, or the one that promises to be fastest.

    Raises
    ------
    FrameError
        Where a sparse way is asked for and the stiffness varies over the batch.
    """
    if 0 in plan.frame.shape:
        return Method(BROADCAST, "broadcasting LDL^T, as the batch has no entries")
    if asked is not None:
        if asked not in (BROADCAST, BANDED) and not plan.constant:
            raise FrameError(
                f"method {asked!r} solves one matrix, but the stiffness varies over the batch {plan.frame.shape}: "
                "use 'broadcast' or 'banded', or give the entries frames of their own"
            )
        return Method(asked, f"{asked}, as asked for")
    if not plan.constant:
        return _fastest_batch(plan)
    unknowns = len(plan.unknowns)
    return _fastest(plan, unknowns) if unknowns > LARGE else _fastest_of_few(plan, unknowns)


def _fastest_of_few(plan: Compiled, unknowns: int) -> Method:
    """The way of a frame of few unknowns that does not vary over the batch."""
    pieces = len(plan.topology.ends)
    why = f"as {unknowns} unknowns are no more than {LARGE}"
    # of a single entry the elimination is recorded, and done again in Python's numbers for the next of its topology
    if plan.frame.shape and _refined_by_springs(plan):
        return Method(BANDED, f"banded Cholesky, {why}, all of members alone", one(pieces, unknowns, 1, 0.0))
    left = pieces - sum(len(inside) for _, inside in plan.chains)
    return Method(BROADCAST, f"broadcasting LDL^T, {why}", few(left))


def _refined_by_springs(plan: Compiled) -> bool:
    """Whether what a matrix of the whole frame loses comes back by refinement that takes next to no time.

    This is so where nothing but members carries loads at nodes; what joints and ties lose, and what acts along members,
    takes equilibrium in extended precision.
    """
    frame = plan.frame
    if frame.weight is not None or any(frame.member_loads.values()) or plan.topology.plain_positions is None:
        return False
    return plan.graph.links.key is not None


def _fastest_batch(plan: Compiled) -> Method:
    """The way of a batch over which the stiffness varies."""
    why = "as the stiffness varies over the batch"
    left = len(plan.unknowns) - 6 * sum(len(nodes) - 2 for nodes, _ in plan.chains)
    condensed = [piece for _, pieces in plan.chains for piece in pieces]
    entries, pieces = plan.grid.sizes[-1], len(plan.topology.ends) - len(condensed)
    # of few unknowns nothing else pays, but where members stand still and what is broadcast is so in extended precision
    still = plan.topology.plain_positions is not None and not plan.frame.joints
    if left <= (_FEWEST if still else FEW) and not (still and extended(entries, pieces)):
        return Method(BROADCAST, f"broadcasting LDL^T, {why}", recorded(pieces, entries))
    coupling, graph = plan.rough_coupling, plan.graph

    def estimates() -> tuple[float, float]:
        apart = banded(coupling, graph)
        return apart, broadcast(coupling, graph, condensed, apart)

    if graph.links.key is None:  # no other frame has these links: what is kept would but take the place of something
        apart, shared = estimates()
    else:
        # what these depend on, beside the terms
        blocks = tuple([(block.mask, block.rows is None) for block in coupling.blocks])
        factors = tuple(map(mask_of, coupling.factors))
        key = "estimates", Same(graph.links), plan.grid.sizes, blocks, factors, tuple(condensed)
        apart, shared = coupling.pattern.known(key, estimates)
    text = f"{why}: about {shared:.2g} s or more by broadcasting, {apart:.2g} s by a band for each entry"
    # The condition number of a slender frame grows with the fourth power of its length, and bands are refined.
    patience = min(max(left / max(1, graph.width - 6) / _SLENDER, 1.0), _PATIENCE)
    if shared * patience <= apart:
        return Method(BROADCAST, f"broadcasting LDL^T, {text}", shared)
    return Method(BANDED, f"banded Cholesky of each entry, {text}", apart)


def _fastest(plan: Compiled, size: int) -> Method:
    """The way of one large frame: a sparse one."""
    graph, pieces, cases = plan.graph, len(plan.topology.ends), count(plan)
    in_bands = size * graph.width**2 / _RATE[BANDED] if size * graph.width <= _BAND else np.inf
    if size * graph.width**2 <= (_LIGHT if graph.width <= _NARROW else _SMALL):
        what = "slender" if size > _SLENDER * graph.width else "small"
        why = f"banded Cholesky, as the frame is {what}: a band of {graph.width} by {size}"
        return Method(BANDED, why, one(pieces, size, cases, in_bands))
    factor = graph.dissection
    direct = CHOLESKY if available() else SPARSE
    ways = {
        direct: factor.operations / _RATE[direct],
        # The test for mechanisms costs about half a load case.
        ITERATIVE: (cases + 0.5) * _ITERATIONS * _ITERATION * graph.entries,
        BANDED: in_bands,
    }
    name = min(ways, key=lambda name: ways[name])
    dear = f"a factor in nested dissection order takes {factor.operations:.2g} operations"
    reasons = {
        ITERATIVE: f"conjugate gradients on {cases} load case(s), as {dear}",
        BANDED: f"banded Cholesky, as the frame is slender: a band of {graph.width} by {size}, while {dear}",
        SPARSE: f"SuperLU in minimum degree order, as {dear}",
        CHOLESKY: f"CHOLMOD in nested dissection order, as {dear}",
    }
    return Method(name, reasons[name], one(pieces, size, cases, ways[name]))
