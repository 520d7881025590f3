"""The choice of the method by which a frame is solved, by its expected time."""

from __future__ import annotations

from dataclasses import dataclass
from importlib.util import find_spec
from typing import Protocol

import numpy as np

from ..batch import Same
from ..errors import FrameError
from ..program import machine_code
from ..structure.parts import mask_of
from ..structure.topology import Topology
from .coupling import Coupling
from .estimate import banded, broadcast, few, one, recorded
from .graph import Graph
from .load_cases import Loaded, count

BROADCAST, BANDED, SPARSE, CHOLESKY, ITERATIVE = METHODS = ("broadcast", "banded", "sparse", "cholesky", "iterative")

# Above LARGE unknowns a frame of constant stiffness is solved by a sparse method; up to FEW, chains of members being
# condensed, one of varying stiffness is solved by broadcasting.
LARGE, FEW = 100, 48
# Measured on one machine: operations per second of a factorisation; below, seconds of an iteration for an entry of the
# matrix, and the number of iterations for a lattice. Only the ratios matter.
_RATE = {BANDED: 4e10, SPARSE: 5e9, CHOLESKY: 3e10}
# From _SLENDER nodes along a frame on, banded factors may take _PATIENCE times as long as broadcasting, which does not
# refine its solutions. On members alone they may at any size with machine code, which is quick, else _LITTLE times.
_SLENDER, _PATIENCE, _LITTLE = 18.0, 3.0, 1.6
# A banded factor of up to this many operations takes less time than searching for a better method.
_SMALL = 2e8
# Up to this width of the band, and this many operations, a better method saves less than searching for it takes.
_NARROW, _LIGHT = 300, 4e9
# Largest number of entries of a band.
_BAND = 4e8
_ITERATION = 0.4e-9
_ITERATIONS = 500


@dataclass(frozen=True)
class Method:
    """The method by which a frame is solved.

    Attributes
    ----------
    name
        ``broadcast``, ``banded``, ``sparse``, ``cholesky`` or ``iterative``.
    reason
        Method and reason of its choice in words.
    seconds
        Estimated time; NaN if the method was given by the user.
    """

    name: str
    reason: str
    seconds: float = np.nan


class Compiled(Loaded, Protocol):
    """The part of a plan that the choice of the method uses."""

    @property
    def constant(self) -> bool:
        """Whether the stiffness does not vary over the batch."""
        ...

    @property
    def unknowns(self) -> list[int]:
        """Numbers of all unknowns."""
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
        """Nodes and pieces of the chains of members that are condensed to their ends."""
        ...

    @property
    def rough_coupling(self) -> Coupling:
        """The terms of the equations at the first entry of the batch."""
        ...


def available() -> bool:
    """Whether cvxopt, and with it CHOLMOD, is installed."""
    return find_spec("cvxopt") is not None


def checked(name: str | None) -> str | None:
    """The name of a method, checked to be known and installed.

    Raises
    ------
    FrameError
        If it is not.
    """
    if name is not None and name not in METHODS:
        raise FrameError(f"method {name!r} is unknown: use one of {', '.join(METHODS)}, or None to let the plan choose")
    if name == CHOLESKY and not available():
        raise FrameError("method 'cholesky' needs cvxopt: install linkframe[fast], or use 'sparse' or 'iterative'")
    return name


def choose(plan: Compiled, asked: str | None) -> Method:
    """The method for a plan: the one `asked` for, or the one with the least estimated time.

    Raises
    ------
    FrameError
        If a method for a single matrix is asked for and the stiffness varies over the batch.
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
    """The method for a frame with few unknowns whose stiffness is constant."""
    pieces = len(plan.topology.ends)
    why = f"as {unknowns} unknowns are no more than {LARGE}"
    # for a single entry the elimination is recorded, and replayed for later frames of the topology, which is faster
    if plan.frame.shape and _refined_by_springs(plan):
        return Method(
            BANDED, f"banded Cholesky, {why}, all of members alone", one(pieces, unknowns, 1, 0.0, plan.grid.sizes[-1])
        )
    left = pieces - sum(len(inside) for _, inside in plan.chains)
    return Method(BROADCAST, f"broadcasting LDL^T, {why}", few(left))


def _refined_by_springs(plan: Compiled) -> bool:
    """Whether refinement by spring residuals, which takes next to no time, recovers the digits that a matrix loses.

    It does if the frame has only members, and loads at nodes alone; joints, ties and loads along members need residuals
    of equilibrium in extended precision.
    """
    frame = plan.frame
    if frame.weight is not None or any(frame.member_loads.values()) or plan.topology.plain_positions is None:
        return False
    return plan.graph.links.key is not None


def _fastest_batch(plan: Compiled) -> Method:
    """The method for a batch over which the stiffness varies."""
    why = "as the stiffness varies over the batch"
    left = len(plan.unknowns) - 6 * sum(len(nodes) - 2 for nodes, _ in plan.chains)
    condensed = [piece for _, pieces in plan.chains for piece in pieces]
    entries, pieces = plan.grid.sizes[-1], len(plan.topology.ends) - len(condensed)
    # with few unknowns broadcasting is fastest, except for members alone whose nodes do not move
    moved = plan.topology.plain_positions is None
    if left <= FEW and (moved or plan.frame.joints):
        return Method(BROADCAST, f"broadcasting LDL^T, {why}", recorded(pieces, entries, moved=moved))
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
    # The condition number of a slender frame grows with the fourth power of its length; banded solutions are refined.
    least = 1.0 if moved or plan.frame.joints else _PATIENCE if machine_code.available() else _LITTLE
    patience = min(max(left / max(1, graph.width - 6) / _SLENDER, least), _PATIENCE)
    if shared * patience <= apart:
        return Method(BROADCAST, f"broadcasting LDL^T, {text}", shared)
    return Method(BANDED, f"banded Cholesky of each entry, {text}", apart)


def _fastest(plan: Compiled, size: int) -> Method:
    """The method for one large frame."""
    graph, pieces, cases, entries = plan.graph, len(plan.topology.ends), count(plan), plan.grid.sizes[-1]
    in_bands = size * graph.width**2 / _RATE[BANDED] if size * graph.width <= _BAND else np.inf
    if size * graph.width**2 <= (_LIGHT if graph.width <= _NARROW else _SMALL):
        what = "slender" if size > _SLENDER * graph.width else "small"
        why = f"banded Cholesky, as the frame is {what}: a band of {graph.width} by {size}"
        return Method(BANDED, why, one(pieces, size, cases, in_bands, entries))
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
    return Method(name, reasons[name], one(pieces, size, cases, ways[name], entries))
