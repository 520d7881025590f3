"""Plan and factors of a frame's last solution, kept for the next one."""

from __future__ import annotations

from typing import Any

from .batched.block_factor import BlockFactor
from .batched.plan import Plan
from .batched.reuse import Differences
from .batched.unloaded import Chained, Former, Unloaded
from .cache import OFFSET, SOLVED
from .description import Description, alone
from .solvers.method import choose
from .solvers.stacked_bands import StackedFactor
from .solvers.stiffness import SparseStiffness


class Factors:
    """Factors of a frame's stiffness, valid under any loads; pickled or copied, they arrive empty.

    Attributes
    ----------
    light
        Factors of a batch by component, as far as they are small enough to be kept.
    stacked
        Banded factors, one for each matrix of a batch.
    resistance
        A `Resistance` to offsets in joints with clearance, which loads do not change either; None before it is known.
    """

    def __init__(self) -> None:
        self.light: dict[tuple[Chained, int], BlockFactor] = {}
        self.stacked: dict[tuple[int, bytes, int], StackedFactor] = {}
        self.resistance: Any = None
        self._sparse: SparseStiffness | None = None

    def __reduce__(self) -> tuple[type[Factors], tuple[()]]:
        return Factors, ()

    def sparse(self, unloaded: Unloaded, method: str) -> SparseStiffness:
        """The sparse stiffness of one large frame, with its factor by a method."""
        if self._sparse is None or self._sparse.method != method:
            self._sparse = SparseStiffness(unloaded, method)
        return self._sparse


def planned(
    frame: Description, described: Description, method: str | None, *, apart: bool = False
) -> tuple[Plan, Factors]:
    """The plan of a description: that of the last solution if only loads have changed.

    If only joints or supports have changed, its members are those of the last one.

    Parameters
    ----------
    frame
        The frame that is solved; its plan is kept as long as it lives.
    described
        A copy of it.
    method
        The requested method, checked.
    apart
        Whether the copy has unit offsets in its joints, each of them a right-hand-side parameter of its own. Its plan
        is kept beside that of the frame without them.

    Returns
    -------
    tuple
        The plan, and the factors that belong to it.
    """
    # the object from which a frame was made may refer to the frame, which would then never be released
    described = alone(described)
    solved = OFFSET if apart else SOLVED
    last: tuple[Plan, Factors] | None = solved.get(frame)
    differences = None if last is None else Differences(last[0].frame, described)
    if last is not None and differences is not None and differences.none and last[0].asked == method:
        found = last[0].reloaded(described), last[1]
    else:
        former = None if last is None or differences is None else _known(last[0].unloaded, differences)
        found = Plan(described, method=method, former=former, apart=apart), Factors()
        if method is not None:
            choose(found[0], method)  # refuses at once what does not suit the batch
    solved.put(frame, found)
    return found


def beside(plan: Plan, frame: Description) -> Former | None:
    """What is known of the members of a frame from the plan of another one; None if members connect other nodes."""
    return _known(plan.unloaded, Differences(plan.frame, frame))


def _known(last: Unloaded, differences: Differences) -> Former | None:
    """The last plan with what changed since, for reuse of its members; None if members connect other nodes."""
    if differences.connections:
        return None
    return Former(last, moved=differences.moved, elements=differences.elements, linked=not differences.links)


def share(frame: Description, other: Description) -> None:
    """Let a description, such as a copy under other loads, use the plan and factors kept for another."""
    last = SOLVED.get(frame)
    if last is not None:
        SOLVED.put(other, last)
