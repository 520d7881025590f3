"""Numbers with their units, as they stand in figures and tables."""

from __future__ import annotations

import math

PREFIXES = {9: "G", 6: "M", 3: "k", 0: "", -3: "m", -6: "µ", -9: "n"}
# Units that take prefixes: a thousand metres more are no kilometres in a drawing of a machine.
PREFIXED = ("N", "N m", "Pa", "Hz")


def stress_unit(units: tuple[str, str]) -> str:
    """Unit of a stress from those of length and force.

    Parameters
    ----------
    units
        Units of length and force.

    Returns
    -------
    str
        Such as ``Pa`` of ``("m", "N")`` and ``MPa`` of ``("mm", "N")``.
    """
    length, force = units
    return {("m", "N"): "Pa", ("mm", "N"): "MPa"}.get(units, f"{force}/{length}²")


def moment_unit(units: tuple[str, str]) -> str:
    """Unit of a moment from those of length and force, such as ``N m``."""
    return f"{units[1]} {units[0]}"


def scaled(greatest: float, unit: str) -> tuple[float, str]:
    """Factor that brings the greatest of some numbers between 1 and 1000, and their unit after multiplication.

    Parameters
    ----------
    greatest
        The greatest of them, without its sign.
    unit
        Their unit; those that take no prefix stay, and metres become smaller alone.

    Returns
    -------
    factor : float
        A power of a thousand.
    unit : str
        With its prefix.
    """
    if unit == "m" and 0.0 < greatest < 1.0:
        return (1e3, "mm") if greatest >= 1e-3 else (1e6, "µm")
    if unit not in PREFIXED or not math.isfinite(greatest) or greatest <= 0.0:
        return 1.0, unit
    power = min(9, max(-9, 3 * math.floor(math.log10(greatest * (1.0 + 1e-9)) / 3.0)))
    return 10.0**-power, PREFIXES[power] + unit


def quantity(value: float, unit: str) -> str:
    """A number with its unit, such as ``50 kN``."""
    factor, text = scaled(abs(value), unit)
    return f"{value * factor:.4g} {text}".replace("-", "−")
