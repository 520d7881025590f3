"""Where the coupler closes the loop, and how that moves with the drive angle: the closed form."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..planar import Complex

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
Jet = tuple[Array, Array, Array]

EPS = float(np.finfo(np.float64).eps)

# Side of the diagonal on which the pin lies: fixed, or with the crank pin as it crosses the ground line.
BRANCHES = {"open": 1.0, "crossed": -1.0, "parallel": 1.0, "antiparallel": -1.0}
FOLLOWING = ("parallel", "antiparallel")


@dataclass(frozen=True, eq=False)
class Closure:
    """The triangle of coupler, rocker and diagonal over the drive angle θ.

    With e = d − a exp(iθ) the diagonal from the crank pin B to the rocker's pivot E, s = |e|, and X twice the signed
    area of the triangle B E D, the coupler is the vector

        u = q / conj(e),    q = (s² + b² − c²)/2 + i X,    2 X = f₁ f₂

        f₁² = (b+c)² − s² = (b+c−a−d)(b+c+a+d) + 4 a d cos²(θ/2)
        f₂² = s² − (b−c)² = (a−d−b+c)(a−d+b−c) + 4 a d sin²(θ/2)

    Nothing cancels in f₁ and f₂, so that the half chord X/s keeps all its digits through a change point (where the
    bars fall into one line), and there f₁ or f₂ is itself smooth: 2 √(ad) cos(θ/2) or 2 √(ad) sin(θ/2), with its
    sign. Derivatives by θ follow from u conj(e) = q. Lengths that satisfy the change-point condition to within their
    own rounding are taken to satisfy it.

    Parameters
    ----------
    crank, coupler, rocker, ground
        Lengths a, b, c, d, (...).
    theta
        Drive angle, radians, (...).
    branch
        Key of `BRANCHES`.
    """

    crank: Array
    coupler: Array
    rocker: Array
    ground: Array
    theta: Array
    branch: str

    # -- the diagonal -----------------------------------------------------------------------------------------------

    @cached_property
    def _half(self) -> tuple[Array, Array]:
        return np.cos(0.5 * self.theta), np.sin(0.5 * self.theta)

    @cached_property
    def diagonal(self) -> Complex:
        """Vector e from the crank pin to the rocker's pivot, (...)."""
        cos, sin = self._half
        lift = 2.0 * self.crank * sin
        e: Complex = (self.ground - self.crank) + lift * sin - 1j * (lift * cos)
        return e

    @cached_property
    def crank_vector(self) -> Complex:
        """Vector from the drive to the crank pin, (...)."""
        pin: Complex = self.crank * (np.cos(self.theta) + 1j * np.sin(self.theta))
        return pin

    @cached_property
    def _square(self) -> Array:
        """s², (...)."""
        square: Array = (self.crank - self.ground) ** 2 + self._product * self._half[1] ** 2
        return square

    # -- the two factors --------------------------------------------------------------------------------------------

    @cached_property
    def _product(self) -> Array:
        return 4.0 * self.crank * self.ground

    @cached_property
    def _total(self) -> Array:
        return self.crank + self.coupler + self.rocker + self.ground

    def _excess(self, value: Array) -> Array:
        return np.where(np.abs(value) <= 2.0 * EPS * self._total, 0.0, value)

    @cached_property
    def _excesses(self) -> tuple[Array, Array]:
        """What f₁² and f₂² have besides the half-angle terms; zero for a linkage with that change point, (...)."""
        a, b, c, d = self.crank, self.coupler, self.rocker, self.ground
        stretched = self._excess((b - d) + (c - a)) * self._total
        folded = self._excess((a - d) - (b - c)) * self._excess((a - d) + (b - c))
        return stretched, folded

    @cached_property
    def _factors(self) -> tuple[Array, Array]:
        """f₁² and f₂², (...)."""
        (stretched, folded), (cos, sin) = self._excesses, self._half
        return stretched + self._product * cos**2, folded + self._product * sin**2

    @cached_property
    def _resolution(self) -> tuple[Array, Array]:
        """How far f₁² and f₂² are from being told apart from zero, given the rounding of θ and of the lengths."""
        step = 4.0 * EPS * np.maximum(1.0, np.abs(self.theta))
        turn = self._product * (0.5 * np.abs(np.sin(self.theta)) * step + 0.25 * step**2)
        stretched, folded = (np.where(excess == 0.0, 0.0, 4.0 * EPS * self._total**2) for excess in self._excesses)
        return stretched + turn, folded + turn

    @cached_property
    def gap(self) -> Array:
        """Distance that coupler and rocker lack to close the loop, (...); 0 where it closes."""
        s = np.sqrt(self._square)
        excess = np.maximum(s - (self.coupler + self.rocker), np.abs(self.coupler - self.rocker) - s)
        closes = np.logical_and(*(f >= -r for f, r in zip(self._factors, self._resolution, strict=True)))
        return np.where(closes, 0.0, np.maximum(excess, EPS * self._total))

    @cached_property
    def singular(self) -> Mask:
        """Where coupler and rocker lie in one line, so that the drive does not determine their motion, (...)."""
        in_line = (np.abs(f) <= r for f, r in zip(self._factors, self._resolution, strict=True))
        found: Mask = np.logical_or(*in_line)
        return found

    @cached_property
    def _smooth(self) -> Mask:
        """Where the motion has derivatives: not at a dead point, nor where a fixed side makes the rocker reverse."""
        vanishing = [np.abs(f) <= r for f, r in zip(self._factors, self._resolution, strict=True)]
        passes = [~v | (excess == 0.0) for v, excess in zip(vanishing, self._excesses, strict=True)]
        follows = passes[0] & passes[1] & (self.branch in FOLLOWING) & (self._square > self._resolution[1])
        return np.asarray(~self.singular | follows)

    @cached_property
    def _roots(self) -> tuple[Array, Array]:
        """f₁ and f₂, signed as their half-angle terms, (...)."""
        first, second = (
            np.copysign(np.sqrt(np.maximum(square, 0.0)), term)
            for square, term in zip(self._factors, self._half, strict=True)
        )
        return first, second

    def _root(self, index: int) -> Jet:
        """f and its first and second derivative by θ, signed as its half-angle term h.

        From f² = g + 4 a d h²:  f' = 4 a d h' r with r = h/f, and r' = g h'/f³.
        """
        g, product = self._excesses[index], self._product
        cos, sin = self._half
        h, dh, ddh = (cos, -0.5 * sin, -0.25 * cos) if index == 0 else (sin, 0.5 * cos, -0.25 * sin)
        f = self._roots[index]
        with np.errstate(divide="ignore", invalid="ignore"):
            r = np.where(g == 0.0, 1.0 / np.sqrt(product), h / f)
            dr = np.where(g == 0.0, 0.0, g * dh / f**3)
        return f, product * dh * r, product * (ddh * r + dh * dr)

    @cached_property
    def _side(self) -> Array:
        """Sign that the smooth area takes, (...)."""
        sign = BRANCHES[self.branch]
        if self.branch in FOLLOWING:
            return np.full(np.shape(self.theta), sign)
        cos, sin = self._half
        return sign * np.copysign(1.0, cos) * np.copysign(1.0, sin)

    @cached_property
    def area(self) -> Array:
        """X, twice the area of the triangle B E D, positive where D is to the left of B → E, (...)."""
        area: Array = self._side * 0.5 * self._roots[0] * self._roots[1]
        return area

    @cached_property
    def _areas(self) -> tuple[Array, Array]:
        """First and second derivative of X by θ, (...)."""
        f, df, ddf = self._root(0)
        g, dg, ddg = self._root(1)
        half = 0.5 * self._side
        return half * (df * g + f * dg), half * (ddf * g + 2.0 * df * dg + f * ddg)

    # -- the coupler ------------------------------------------------------------------------------------------------

    @cached_property
    def coupler_vector(self) -> Complex:
        """Vector u from crank pin to rocker pin, (...); NaN where the loop does not close."""
        b, c = self.coupler, self.rocker
        q = 0.5 * (self._square + (b - c) * (b + c)) + 1j * self.area
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            u = q / np.conj(self.diagonal)
        # A rhombus or kite whose crank pin lies on the rocker's pivot: the limit of the same formula.
        u = np.where(self._square == 0.0, BRANCHES[self.branch] * b, u)
        return np.where(self.gap == 0.0, u, complex(np.nan, np.nan))

    @cached_property
    def coupler_derivatives(self) -> tuple[Complex, Complex]:
        """First and second derivative of u by θ, (...); NaN where the motion has none."""
        u, bar, turn = self.coupler_vector, np.conj(self.diagonal), np.conj(self.crank_vector)
        first, second = self._areas
        ds = 0.5 * self._product * np.sin(self.theta)
        dds = 0.5 * self._product * np.cos(self.theta)
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            du = (0.5 * ds + 1j * first - u * (1j * turn)) / bar
            ddu = (0.5 * dds + 1j * second - 2.0 * du * (1j * turn) - u * turn) / bar
        nowhere = complex(np.nan, np.nan)
        return np.where(self._smooth, du, nowhere), np.where(self._smooth, ddu, nowhere)
