"""Vector algebra on lists of entries, each a number or an array; products with exact zeros are skipped."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from .terms import Value


def combined(axes: Sequence[Sequence[Value]], components: Sequence[Value]) -> list[Value]:
    """Vector with these components along three axes."""
    out: list[Value] = [0.0, 0.0, 0.0]
    for axis, x in zip(axes, components, strict=True):
        if not isinstance(x, float) or x != 0.0:
            for k, a in enumerate(axis):
                if not isinstance(a, float) or a != 0.0:
                    out[k] = out[k] + a * x
    return out


def _sum(pairs: Iterable[tuple[Value, Value]]) -> Value:
    total: Value = 0.0
    for a, b in pairs:
        if not (_is_zero(a) or _is_zero(b)):
            total = total + a * b
    return total


def _is_zero(x: Value) -> bool:
    return isinstance(x, float) and x == 0.0


def cross(a: Sequence[Value], b: Sequence[Value]) -> list[Value]:
    """Cross product of two vectors."""
    return [
        _sum([(a[1], b[2]), (_minus(a[2]), b[1])]),
        _sum([(a[2], b[0]), (_minus(a[0]), b[2])]),
        _sum([(a[0], b[1]), (_minus(a[1]), b[0])]),
    ]


def _minus(x: Value) -> Value:
    return x if _is_zero(x) else -x
