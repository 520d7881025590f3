"""What stays of the last solution of a frame for the next one: its plan and its factors."""

from __future__ import annotations

from .batched.block import BlockFactor
from .batched.plan import Plan
from .batched.reuse import Differences
from .batched.unloaded import Chained, Former, Unloaded
from .cache import SOLVED
from .description import Description, alone
from .solvers.method import choose
from .solvers.stacked_bands import StackedFactor
from .solvers.stiffness import SparseStiffness


class Factors:
    """What the solutions of a frame under any loads have in common; it arrives empty where it is sent.

    Attributes
    ----------
    light
        Factors of a batch by component, those that are light enough to be held.
    stacked
        Factors of the matrices of a batch, each its own.
    """

    def __init__(self) -> None:
        self.light: dict[tuple[Chained, int], BlockFactor] = {}
        self.stacked: dict[tuple[int, bytes, int], StackedFactor] = {}
        self._sparse: SparseStiffness | None = None

    def __reduce__(self) -> tuple[type[Factors], tuple[()]]:
        return Factors, ()

    def sparse(self, unloaded: Unloaded, method: str) -> SparseStiffness:
        """The matrix of one large frame, with its factors by a method."""
        if self._sparse is None or self._sparse.method != method:
            self._sparse = SparseStiffness(unloaded, method)
        return self._sparse


def planned(frame: Description, described: Description, method: str | None) -> tuple[Plan, Factors]:
    """The plan of a description: that of the last solution where nothing but loads has changed.

    Where joints or supports have, its members are those of the last one.

    Parameters
    ----------
    frame
        What is solved; as long as it lives its plan is kept.
    described
        A copy of it.
    method
        The method that is asked for, checked.

    Returns
    -------
    tuple
        The plan, and the factors that belong to it.
    """
    # what a frame was made from may hold the frame, which would then be kept for ever
    described = alone(described)
    last: tuple[Plan, Factors] | None = SOLVED.get(frame)
    differences = None if last is None else Differences(last[0].frame, described)
    if last is not None and differences is not None and differences.none and last[0].asked == method:
        found = last[0].reloaded(described), last[1]
    else:
        former = None if last is None or differences is None else _known(last[0].unloaded, differences)
        found = Plan(described, method=method, former=former), Factors()
        if method is not None:
            choose(found[0], method)  # refuses at once what does not suit the batch
    SOLVED.put(frame, found)
    return found


def _known(last: Unloaded, differences: Differences) -> Former | None:
    """What a last solution tells of the next one's members; None where these connect other nodes."""
    elements = differences.elements
    moved = differences.members and not elements
    if moved and differences.connections:
        return None
    return Former(last, moved=moved, elements=elements, linked=not differences.links)


def share(frame: Description, other: Description) -> None:
    """Let a description, such as a copy under other loads, take up what is kept of another."""
    last = SOLVED.get(frame)
    if last is not None:
        SOLVED.put(other, last)
