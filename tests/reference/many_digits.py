"""Numbers of 64 digits: Gauss's rule, and the solution of sparse equations that are neither definite nor scaled."""

from __future__ import annotations

from functools import cache
from typing import Any

import mpmath
import numpy as np

Row = dict[int, Any]

mp = mpmath.MPContext()
mp.dps = 64

# What elimination leaves of an entry that is zero.
_NONE = 1e-45


@cache
def gauss(count: int) -> list[tuple[Any, Any]]:
    """Points and weights of Gauss's rule on (0, 1), by Newton's method on Legendre's polynomial."""
    out = []
    for guess in np.polynomial.legendre.leggauss(count)[0]:
        x = mp.mpf(float(guess))
        for _ in range(4):
            before, value = mp.mpf(1), x
            for n in range(2, count + 1):
                before, value = value, ((2 * n - 1) * x * value - (n - 1) * before) / n
            slope = count * (x * value - before) / (x * x - 1)
            x -= value / slope
        out.append(((1 + x) / 2, 1 / ((1 - x * x) * slope * slope)))
    return out


def eliminated(rows: dict[int, Row], right: dict[int, Any], held: dict[int, Any]) -> dict[int, Any]:
    """Solution of the equations, those of the `held` left out, the shortest row first for its greatest entry."""
    found = dict(held)
    work = {i: {j: v for j, v in row.items() if j not in held} for i, row in rows.items() if i not in held}
    left = {i: right[i] - sum((v * held[j] for j, v in rows[i].items() if j in held), mp.mpf(0)) for i in work}
    within: dict[int, set[int]] = {}
    for i, row in work.items():
        for j in row:
            within.setdefault(j, set()).add(i)
    order = []
    given = {i: max((abs(v) for v in row.values()), default=mp.mpf(0)) for i, row in work.items()}
    waiting = set(work)
    while waiting:
        i = min(waiting, key=lambda i: (len(work[i]), i))
        waiting.discard(i)
        row, size = work[i], max((abs(v) for v in work[i].values()), default=mp.mpf(0))
        # of what is not small the one in the fewest rows
        able = [j for j, v in row.items() if abs(v) * 1000 > size]
        j = min(able, key=lambda j: (len(within[j]), j), default=None)
        if j is None or size <= _NONE * given[i]:
            raise ZeroDivisionError("singular")
        order.append((i, j))
        pivot = row[j]
        for other in within[j] & waiting:
            factor = work[other].pop(j) / pivot
            target = work[other]
            for k, v in row.items():
                if k == j:
                    continue
                new = target.get(k)
                if new is None:
                    target[k] = -factor * v
                    within[k].add(other)
                else:
                    target[k] = new - factor * v
            left[other] -= factor * left[i]
    for i, j in reversed(order):
        row = work[i]
        found[j] = (left[i] - sum((v * found[k] for k, v in row.items() if k != j), mp.mpf(0))) / row[j]
    return found
