"""Numbers of twice double precision, each an array over many models (Dekker, Numer. Math. 18 (1971) 224-242)."""

from __future__ import annotations

from typing import Any

import numpy as np

Array = np.ndarray[Any, np.dtype[Any]]

_SPLIT = 134217729.0  # 2^27 + 1


class DoubleDouble:
    """``high + low`` with ``|low|`` no more than half a unit in the last place of ``high``."""

    __slots__ = ("high", "low")

    def __init__(self, high: Any, low: Any = 0.0) -> None:
        self.high, self.low = np.asarray(high, dtype=np.float64), np.asarray(low, dtype=np.float64)

    def __add__(self, other: Any) -> Any:
        if _none(other):
            return self
        high, low = _parts(other)
        s, e = _two_sum(self.high, high)
        t, f = _two_sum(self.low, low)
        s, e = _quick(s, e + t)
        return DoubleDouble(*_quick(s, e + f))

    __radd__ = __add__

    def __neg__(self) -> DoubleDouble:
        return DoubleDouble(-self.high, -self.low)

    def __sub__(self, other: Any) -> Any:
        return self + (-other)

    def __rsub__(self, other: Any) -> Any:
        return (-self) + other

    def __mul__(self, other: Any) -> Any:
        if _none(other):
            return 0.0
        high, low = _parts(other)
        p, e = _two_product(self.high, high)
        return DoubleDouble(*_quick(p, e + (self.high * low + self.low * high)))

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> DoubleDouble:
        divisor = other if isinstance(other, DoubleDouble) else DoubleDouble(other)
        first = DoubleDouble(self.high / divisor.high)
        rest = self - divisor * first
        second = DoubleDouble(rest.high / divisor.high)
        rest = rest - divisor * second
        out: DoubleDouble = first + second + DoubleDouble(rest.high / divisor.high)
        return out

    def __rtruediv__(self, other: Any) -> DoubleDouble:
        return DoubleDouble(other) / self

    def __eq__(self, other: object) -> bool:
        difference = self - other
        return bool(np.all(difference.high == 0.0)) if isinstance(difference, DoubleDouble) else difference == 0.0

    __hash__ = None  # type: ignore[assignment]


def square_root(x: DoubleDouble) -> DoubleDouble:
    """By one step of Newton's method."""
    root = DoubleDouble(np.sqrt(x.high))
    rest = x - root * root
    out: DoubleDouble = root + DoubleDouble(rest.high / (2.0 * root.high))
    return out


def number(value: Any) -> Any:
    """A number of this kind; an exact zero stays a float, and costs nothing."""
    if isinstance(value, DoubleDouble):
        return value
    return 0.0 if _none(value) else DoubleDouble(value)


def _none(value: Any) -> bool:
    return isinstance(value, int | float) and value == 0


def _parts(value: Any) -> tuple[Any, Any]:
    return (value.high, value.low) if isinstance(value, DoubleDouble) else (value, 0.0)


def _two_sum(a: Any, b: Any) -> tuple[Any, Any]:
    s = a + b
    v = s - a
    return s, (a - (s - v)) + (b - v)


def _quick(a: Any, b: Any) -> tuple[Any, Any]:
    s = a + b
    return s, b - (s - a)


def _halves(a: Any) -> tuple[Any, Any]:
    t = _SPLIT * a
    high = t - (t - a)
    return high, a - high


def _two_product(a: Any, b: Any) -> tuple[Any, Any]:
    p = a * b
    (c, d), (e, f) = _halves(a), _halves(b)
    return p, ((c * e - p) + c * f + d * e) + d * f
