"""The cheapest tolerances that hold an accuracy, and what a fit costs as far as nothing better is known."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...framework.batch import numbers
from ...framework.errors import FrameError
from .iso286 import Fit, tolerance_grade

Array = NDArray[np.float64]

# Share of the limit by which a solution may pass it for rounding.
ROUNDING = 1e-9
# Greatest cost that the solver is given: it takes sums for the same that differ by less than 1e-6.
LARGEST_COST = 1e4


@dataclass(frozen=True, eq=False)
class Allocation:
    """The cheapest choice; made by `allocate`.

    Attributes
    ----------
    chosen
        Which of its choices each part takes, by name.
    cost
        Of all of them together.
    reached
        Greatest deviation with them.
    limit
        What was allowed.
    binding
        Numbers of the rows of the effects that leave the least room, (n,): within a thousandth of the greatest.
    """

    chosen: Mapping[str, str]
    cost: float
    reached: float
    limit: float
    binding: NDArray[np.int64]

    def __repr__(self) -> str:
        """What is chosen, what it costs, and how much room is left."""
        parts = ", ".join(f"{name} {choice}" for name, choice in self.chosen.items())
        return f"Allocation: {parts}; cost {self.cost:.6g}, {self.reached:.4g} of {self.limit:.4g} used"


def allocate(
    effects: Mapping[str, ArrayLike],
    choices: Mapping[str, Mapping[str, tuple[float, float]]],
    limit: float,
    *,
    combine: str = "worst case",
) -> Allocation:
    """Choose for every part the tolerance with which all together are cheapest and hold a limit.

    Parameters
    ----------
    effects
        By part, what a unit of its tolerance does, (rows,): a row is a pose and a direction, a component, or whatever
        else must hold.
    choices
        By part its choices by name: tolerance and cost of each.
    limit
        Greatest deviation allowed in every row.
    combine
        How the parts add up: ``"worst case"``, ``Σ tᵢ |aᵢ|``, or ``"statistical"``, ``sqrt(Σ tᵢ² aᵢ²)``.

    Returns
    -------
    Allocation
        The cheapest choice, proved so by integer programming (branch and bound: A. H. Land & A. G. Doig, 1960).

    Raises
    ------
    FrameError
        If parts or shapes do not fit, or no choice holds the limit.

    Examples
    --------
    >>> choices = {"H7/g6": (20e-6, 8.0), "H8/f7": (45e-6, 3.0)}
    >>> effects = {"B": [1.0, 0.2], "C": [0.1, 0.4]}
    >>> found = allocate(effects, {"B": choices, "C": choices}, 30e-6)
    >>> dict(found.chosen), found.cost
    ({'B': 'H7/g6', 'C': 'H8/f7'}, 11.0)
    """
    if combine not in ("worst case", "statistical"):
        raise FrameError(f"combine is {combine!r}: choose 'worst case' or 'statistical'")
    power = 1 if combine == "worst case" else 2
    if not (np.ndim(limit) == 0 and np.isfinite(limit) and limit > 0.0):
        raise FrameError(f"limit is {limit!r}: give a deviation above zero")
    table = _table(effects, choices)
    names = [(part, choice) for part, some in choices.items() for choice in some]
    sizes, costs = (np.array([choices[part][choice][k] for part, choice in names]) for k in (0, 1))
    part_of = np.array([list(choices).index(part) for part, _ in names])
    used = (table[:, part_of] * sizes) ** power
    taken = _cheapest(used / float(limit) ** power, costs, part_of)
    if taken is None:
        least = np.array([min(tolerance for tolerance, _ in some.values()) for some in choices.values()])
        best = float(np.max(np.sum((table * least) ** power, axis=1)) ** (1.0 / power))
        raise FrameError(
            f"no choice holds {limit:g}: the tightest of all parts come to {best:g}; allow as much or give tighter ones"
        )
    rows = np.sum(used[:, taken], axis=1) ** (1.0 / power)
    chosen = {names[k][0]: names[k][1] for k in np.flatnonzero(taken)}
    binding = np.flatnonzero(rows >= 0.999 * rows.max())
    return Allocation(chosen, float(costs[taken].sum()), float(rows.max()), float(limit), binding)


def _table(effects: Mapping[str, ArrayLike], choices: Mapping[str, Mapping[str, tuple[float, float]]]) -> Array:
    """Sizes of the effects, (rows, parts), checked."""
    if not choices or set(effects) != set(choices):
        raise FrameError(
            f"effects of {', '.join(effects) or 'nothing'} and choices of {', '.join(choices) or 'nothing'}"
        )
    for part, some in choices.items():
        pairs = np.array([*some.values()], dtype=np.float64).reshape(-1, 2)
        if not some or not np.isfinite(pairs).all() or np.any(pairs < 0.0):
            raise FrameError(f"choices of {part!r}: give by name a tolerance and a cost, finite and not negative")
    columns = [np.abs(numbers(effects[part], f"effects of {part!r}")) for part in choices]
    if any(each.ndim != 1 or each.shape != columns[0].shape for each in columns):
        raise FrameError(f"effects have the shapes {[each.shape for each in columns]}: give (rows,) of each part")
    return np.stack(columns, axis=1)


def _cheapest(used: Array, costs: Array, part_of: Sequence[int] | NDArray[np.int64]) -> NDArray[np.bool_] | None:
    """Which choices (n,) are cheapest with at most 1 used in every row of (rows, n); None where none holds."""
    from scipy.optimize import Bounds, LinearConstraint, milp

    mine = np.asarray(part_of) == np.arange(max(part_of) + 1)[:, None]
    one_each = mine.astype(np.float64)
    # What a choice costs more than the cheapest of its part, in numbers that the solver can tell apart.
    more = costs - np.where(mine, costs, np.inf).min(axis=1)[np.asarray(part_of)]
    if more.max() > 0.0:
        more = more / more.max() * LARGEST_COST
    kept = used[_undominated(used)]
    found = milp(
        more,
        integrality=np.ones(len(costs), dtype=np.int64),
        bounds=Bounds(0.0, 1.0),
        constraints=[LinearConstraint(kept, -np.inf, 1.0 + ROUNDING), LinearConstraint(one_each, 1.0, 1.0)],
        options={"mip_rel_gap": 0.0},
    )
    return None if found.x is None else np.asarray(found.x > 0.5)


def _undominated(used: Array) -> NDArray[np.int64]:
    """Rows that no other row is as large as in everything."""
    order = np.argsort(-used.sum(axis=1), kind="stable")
    kept: list[int] = []
    for row in order.tolist():
        if not kept or not np.any(np.all(used[kept] >= used[row], axis=1)):
            kept.append(row)
    return np.array(kept, dtype=np.int64)


def relative_cost(fit: Fit) -> float:
    """Cost of making hole and shaft of a fit, in units of that of one of them in grade IT7.

    The finer the tolerance, the dearer: the cost is taken as inverse to its width (the reciprocal model in
    K. W. Chase & W. H. Greenwood, *Design issues in mechanical tolerance analysis*, 1988), so that a grade finer costs
    some 1.6 times as much.

    Parameters
    ----------
    fit
        Tolerances of hole and shaft, as `linkframe.models.fit` looks them up.

    Returns
    -------
    float
        ``IT7 / hole's tolerance + IT7 / shaft's tolerance``.

    Examples
    --------
    >>> from linkframe.models import fit
    >>> round(relative_cost(fit(0.025, "H7/g6")), 3)  # 21/21 + 21/13
    2.615
    """
    standard = tolerance_grade(fit.hole.size, 7)
    return sum(standard / (part.upper - part.lower) for part in (fit.hole, fit.shaft))
