"""The cheapest tolerances that meet a required accuracy, and a relative cost of fits."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...framework.batch import numbers
from ...framework.errors import FrameError
from .iso286 import Fit, tolerance_grade

Array = NDArray[np.float64]

# Share of the limit by which a solution may exceed it because of rounding.
ROUNDING = 1e-9
# Largest cost given to the solver, which treats sums that differ by less than 1e-6 as equal.
LARGEST_COST = 1e4


@dataclass(frozen=True, eq=False)
class Allocation:
    """The cheapest allocation of tolerances; made by `allocate`.

    Attributes
    ----------
    chosen
        Name of the tolerance chosen for each part, by the name of the part.
    cost
        Total cost, in the unit of the given costs.
    reached
        Largest deviation with these tolerances, in the unit of `limit`.
    limit
        Largest deviation allowed.
    binding
        Numbers of the rows of the effects whose deviation is within a thousandth of the largest, (n,).
    """

    chosen: Mapping[str, str]
    cost: float
    reached: float
    limit: float
    binding: NDArray[np.int64]

    def __repr__(self) -> str:
        """The choices, the cost, and how much of the limit is used."""
        parts = ", ".join(f"{name} {choice}" for name, choice in self.chosen.items())
        return f"Allocation: {parts}; cost {self.cost:.6g}, {self.reached:.4g} of {self.limit:.4g} used"


def allocate(
    effects: Mapping[str, ArrayLike],
    choices: Mapping[str, Mapping[str, tuple[float, float]]],
    limit: float,
    *,
    combine: str = "worst case",
) -> Allocation:
    """Choose a tolerance for every part so that the deviations stay within a limit at the lowest total cost.

    Parameters
    ----------
    effects
        Deviation per unit of the tolerance of each part, by part, (rows,). A row is one requirement, such as a pose and
        a direction.
    choices
        Possible tolerances of each part: by part and name, the tolerance and its cost.
    limit
        Largest deviation allowed in every row.
    combine
        How the deviations aᵢ tᵢ of the parts combine: ``"worst case"``, ``Σ tᵢ |aᵢ|``, or ``"statistical"``,
        ``sqrt(Σ tᵢ² aᵢ²)``.

    Returns
    -------
    Allocation
        The cheapest choice, found by integer programming (branch and bound: A. H. Land & A. G. Doig, 1960).

    Raises
    ------
    FrameError
        If the parts or shapes do not match, or no choice stays within the limit.

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
    """Absolute values of the effects, (rows, parts), after checks of both arguments."""
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
    """The cheapest choices, (n,), whose `used` (rows, n) add up to at most 1 in every row; None if there are none."""
    from scipy.optimize import Bounds, LinearConstraint, milp

    mine = np.asarray(part_of) == np.arange(max(part_of) + 1)[:, None]
    one_each = mine.astype(np.float64)
    # Cost above that of the cheapest choice of the same part, scaled so that the solver can tell the sums apart.
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
    """Numbers of the rows without those that another row equals or exceeds in every column."""
    order = np.argsort(-used.sum(axis=1), kind="stable")
    kept: list[int] = []
    for row in order.tolist():
        if not kept or not np.any(np.all(used[kept] >= used[row], axis=1)):
            kept.append(row)
    return np.array(kept, dtype=np.int64)


def relative_cost(fit: Fit) -> float:
    """Cost of making hole and shaft of a fit, relative to the cost of one of them in grade IT7.

    The cost is taken as inversely proportional to the width of the tolerance (the reciprocal model in K. W. Chase &
    W. H. Greenwood, *Design issues in mechanical tolerance analysis*, 1988), so that one grade finer costs some 1.6
    times as much.

    Parameters
    ----------
    fit
        Limits of hole and shaft, as returned by `linkframe.models.fit`.

    Returns
    -------
    float
        Relative cost, ``IT7 / hole's tolerance + IT7 / shaft's tolerance``.

    Examples
    --------
    >>> from linkframe.models import fit
    >>> round(relative_cost(fit(0.025, "H7/g6")), 3)  # 21/21 + 21/13
    2.615
    """
    standard = tolerance_grade(fit.hole.size, 7)
    return sum(standard / (part.upper - part.lower) for part in (fit.hole, fit.shaft))
