"""LLVM code for the sine and cosine of a vector, without function calls, to 0.8 units in the last place.

The argument is reduced by multiples k of π/2, which three doubles represent to 159 bits (W. J. Cody and W. Waite,
*Software Manual for the Elementary Functions*, 1980); each product with k is subtracted without rounding by a fused
operation. The remainder, of at most π/4 and with a correction beyond double precision, goes into the polynomials of
fdlibm (k_sin.c, k_cos.c). The last two bits of k decide between sine and cosine, and the sign.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator

# For larger arguments, where neighbouring doubles are more than 2^-12 apart, the result is NaN.
FARTHEST = 2.0**40

_HALF_PI = (1.5707963267948966, 6.123233995736766e-17, -1.4973849048591698e-33)
_TWO_OVER_PI = 0.6366197723675814
# Adding and subtracting it rounds to the next integer; the last bits of the sum are those of the integer.
_WHOLE = 1.5 * 2.0**52
_SINE = (
    -1.66666666666666324348e-01,
    8.33333333332248946124e-03,
    -1.98412698298579493134e-04,
    2.75573137070700676789e-06,
    -2.50507602534068634195e-08,
    1.58969099521155010221e-10,
)
_COSINE = (
    4.16666666666666019037e-02,
    -1.38888888888741095749e-03,
    2.48015872894767294178e-05,
    -2.75573143513906633035e-07,
    2.08757232129817482790e-09,
    -1.13596475577881948265e-11,
)


def splat(value: float) -> str:
    """LLVM constant: a vector with a number in all lanes."""
    (bits,) = struct.unpack(">Q", struct.pack(">d", value))
    return f"splat (double 0x{bits:016X})"


def reduced(x: str, name: str, width: int) -> Iterator[str]:
    """Code for both polynomials at a vector `x` and the last bits of k; `name` is the prefix of the results."""
    v, n = f"<{width} x double>", f"%{name}"

    def fused(out: str, a: str, b: str, c: str) -> str:
        return f"  {n}{out} = call {v} @llvm.fma.v{width}f64({v} {a}, {v} {b}, {v} {c})"

    yield f"  {n}q = fmul {v} {x}, {splat(_TWO_OVER_PI)}"
    yield f"  {n}m = fadd {v} {n}q, {splat(_WHOLE)}"
    yield f"  {n}k = fsub {v} {n}m, {splat(_WHOLE)}"
    yield f"  {n}j = fneg {v} {n}k"
    yield fused("a", f"{n}j", splat(_HALF_PI[0]), x)
    yield f"  {n}pa = fmul {v} {n}k, {splat(_HALF_PI[1])}"
    yield f"  {n}pn = fneg {v} {n}pa"
    yield fused("pb", f"{n}k", splat(_HALF_PI[1]), f"{n}pn")
    yield f"  {n}r = fsub {v} {n}a, {n}pa"
    # the part of the difference that r has lost by rounding
    yield f"  {n}b = fsub {v} {n}a, {n}r"
    yield f"  {n}c = fsub {v} {n}b, {n}pa"
    yield f"  {n}ca = fsub {v} {n}c, {n}pb"
    yield fused("l", f"{n}j", splat(_HALF_PI[2]), f"{n}ca")
    yield f"  {n}z = fmul {v} {n}r, {n}r"
    for letter, those in (("s", _SINE[1:]), ("t", _COSINE)):
        last = splat(those[-1])
        for place, each in reversed(list(enumerate(those[:-1]))):
            yield fused(f"{letter}{place}", f"{n}z", last, splat(each))
            last = f"{n}{letter}{place}"
    yield f"  {n}w = fmul {v} {n}z, {n}r"
    yield f"  {n}h = fmul {v} {n}l, {splat(0.5)}"
    yield f"  {n}wn = fneg {v} {n}w"
    yield fused("u", f"{n}wn", f"{n}s0", f"{n}h")
    yield f"  {n}ln = fneg {v} {n}l"
    yield fused("d", f"{n}z", f"{n}u", f"{n}ln")
    yield fused("e", f"{n}wn", splat(_SINE[0]), f"{n}d")
    yield f"  {n}sin = fsub {v} {n}r, {n}e"
    yield f"  {n}f = fmul {v} {n}z, {splat(0.5)}"
    yield f"  {n}g = fsub {v} {splat(1.0)}, {n}f"
    yield f"  {n}i = fsub {v} {splat(1.0)}, {n}g"
    yield f"  {n}o = fsub {v} {n}i, {n}f"
    yield f"  {n}p = fmul {v} {n}z, {n}z"
    yield f"  {n}ra = fmul {v} {n}r, {n}ln"
    yield fused("rb", f"{n}p", f"{n}t0", f"{n}ra")
    yield f"  {n}rc = fadd {v} {n}o, {n}rb"
    yield f"  {n}cos = fadd {v} {n}g, {n}rc"
    yield f"  {n}bits = bitcast {v} {n}m to <{width} x i64>"
    yield f"  {n}size = call {v} @llvm.fabs.v{width}f64({v} {x})"
    yield f"  {n}near = fcmp ole {v} {n}size, {splat(FARTHEST)}"


def rotated(name: str, out: str, width: int, *, cosine: bool) -> Iterator[str]:
    """Code for the sine or cosine `out` from the results of `reduced`."""
    v, w, n, o = f"<{width} x double>", f"<{width} x i64>", f"%{name}", f"%{out}"
    quarter = f"{n}bits"
    if cosine:
        quarter = f"{o}n"
        yield f"  {o}n = add {w} {n}bits, splat (i64 1)"
    yield f"  {o}odd = and {w} {quarter}, splat (i64 1)"
    yield f"  {o}other = icmp ne {w} {o}odd, zeroinitializer"
    yield f"  {o}x = select <{width} x i1> {o}other, {v} {n}cos, {v} {n}sin"
    yield f"  {o}two = and {w} {quarter}, splat (i64 2)"
    yield f"  {o}sign = shl {w} {o}two, splat (i64 62)"
    yield f"  {o}y = bitcast {v} {o}x to {w}"
    yield f"  {o}z = xor {w} {o}y, {o}sign"
    yield f"  {o}f = bitcast {w} {o}z to {v}"
    yield f"  {o} = select <{width} x i1> {n}near, {v} {o}f, {v} {splat(float('nan'))}"
