"""Tolerance grades and limits of size by ISO 286-1:2010 for sizes to 500 mm, and the clearance of fits.

The tables are those printed in the standard, in micrometres, because its formulas do not give all of their values.
"""

from __future__ import annotations

import re
from bisect import bisect_left
from dataclasses import dataclass

from ...framework.errors import FrameError

# Upper limits of the ranges of size, mm; a range includes its upper limit.
SIZES = (3, 6, 10, 18, 30, 50, 80, 120, 180, 250, 315, 400, 500)

# Standard tolerances (table 1), µm.
GRADES = {
    1: (0.8, 1, 1, 1.2, 1.5, 1.5, 2, 2.5, 3.5, 4.5, 6, 7, 8),
    2: (1.2, 1.5, 1.5, 2, 2.5, 2.5, 3, 4, 5, 7, 8, 9, 10),
    3: (2, 2.5, 2.5, 3, 4, 4, 5, 6, 8, 10, 12, 13, 15),
    4: (3, 4, 4, 5, 6, 7, 8, 10, 12, 14, 16, 18, 20),
    5: (4, 5, 6, 8, 9, 11, 13, 15, 18, 20, 23, 25, 27),
    6: (6, 8, 9, 11, 13, 16, 19, 22, 25, 29, 32, 36, 40),
    7: (10, 12, 15, 18, 21, 25, 30, 35, 40, 46, 52, 57, 63),
    8: (14, 18, 22, 27, 33, 39, 46, 54, 63, 72, 81, 89, 97),
    9: (25, 30, 36, 43, 52, 62, 74, 87, 100, 115, 130, 140, 155),
    10: (40, 48, 58, 70, 84, 100, 120, 140, 160, 185, 210, 230, 250),
    11: (60, 75, 90, 110, 130, 160, 190, 220, 250, 290, 320, 360, 400),
    12: (100, 120, 150, 180, 210, 250, 300, 350, 400, 460, 520, 570, 630),
}

# Fundamental deviations of shafts (tables 4 and 5), µm: the upper one for d to h, the lower one for k to p.
UPPER = {
    "d": (-20, -30, -40, -50, -65, -80, -100, -120, -145, -170, -190, -210, -230),
    "e": (-14, -20, -25, -32, -40, -50, -60, -72, -85, -100, -110, -125, -135),
    "f": (-6, -10, -13, -16, -20, -25, -30, -36, -43, -50, -56, -62, -68),
    "g": (-2, -4, -5, -6, -7, -9, -10, -12, -14, -15, -17, -18, -20),
    "h": (0,) * 13,
}
LOWER = {
    "k": (0, 1, 1, 1, 2, 2, 2, 3, 3, 4, 4, 4, 5),
    "m": (2, 4, 6, 7, 8, 9, 11, 13, 15, 17, 20, 21, 23),
    "n": (4, 8, 10, 12, 15, 17, 20, 23, 27, 31, 34, 37, 40),
    "p": (6, 12, 15, 18, 22, 26, 32, 37, 43, 50, 56, 62, 68),
}
# Grades for which k has the deviation of the table; it is 0 for others.
K_GRADES = (4, 5, 6, 7)
# Finest grade of holes K to P, and for each letter the coarsest grade with the addition Δ, the difference between the
# tolerances of the grade and of the next finer one.
FINEST_HOLE, COARSEST = 3, {"k": 8, "m": 8, "n": 8, "p": 7}

CLASS = re.compile(r"(?P<letter>[A-Za-z]{1,2})(?P<grade>\d{1,2})")
MICRO = 1e-6


def tolerance_grade(size: float, grade: int) -> float:
    """Standard tolerance IT1 to IT12, for sizes to 500 mm.

    Parameters
    ----------
    size
        Nominal size, m.
    grade
        Number of the grade, from 1 to 12.

    Returns
    -------
    float
        Width of the tolerance, m.

    Raises
    ------
    FrameError
        If the size or the grade is not in the table.

    Examples
    --------
    >>> tolerance_grade(0.025, 7)  # IT7 of 25 mm: 21 micrometres
    2.1e-05
    """
    if grade not in GRADES:
        raise FrameError(f"tolerance grade IT{grade}: give one from 1 to {max(GRADES)}")
    return _micrometres(GRADES[grade][_range(size)])


@dataclass(frozen=True)
class LimitsOfSize:
    """Limits of size of a hole or shaft.

    Attributes
    ----------
    size
        Nominal size, m.
    lower, upper
        Lower and upper deviation from the nominal size, m.
    """

    size: float
    lower: float
    upper: float


def limits_of_size(size: float, tolerance_class: str) -> LimitsOfSize:
    """Look up the limits of size of a hole or shaft by its tolerance class.

    Parameters
    ----------
    size
        Nominal size, m, up to 0.5.
    tolerance_class
        Tolerance class, such as ``"H7"`` for a hole or ``"g6"`` for a shaft: letters d to h, js, k, m, n, p for shafts
        and D to H, JS, K, M, N, P for holes, with grades 1 to 12. Holes K to P have grades from 3 on; above 3 mm holes
        K have grades to 8.

    Returns
    -------
    LimitsOfSize
        Nominal size and deviations, m.

    Raises
    ------
    FrameError
        If the size or the class is not in the tables.

    Examples
    --------
    >>> limits_of_size(0.025, "g6")
    LimitsOfSize(size=0.025, lower=-2e-05, upper=-7e-06)
    """
    found = CLASS.fullmatch(tolerance_class)
    if found is None:
        raise FrameError(f"tolerance class {tolerance_class!r}: write it as 'H7' for a hole or 'g6' for a shaft")
    letter, grade, at = found["letter"], int(found["grade"]), _range(size)
    if grade not in GRADES:
        raise FrameError(f"tolerance class {tolerance_class!r}: give a grade from 1 to {max(GRADES)}")
    width, small = GRADES[grade][at], letter.lower()
    if small == "js" and letter in ("js", "JS"):
        return _limits(size, -0.5 * width, 0.5 * width)
    if letter in UPPER:
        return _limits(size, UPPER[letter][at] - width, UPPER[letter][at])
    if letter in LOWER:
        lower = 0 if letter == "k" and grade not in K_GRADES else LOWER[letter][at]
        return _limits(size, lower, lower + width)
    if letter.isupper() and small in UPPER:
        # The lower deviation of holes D to H is the negative of the upper deviation of shafts with the same letter.
        return _limits(size, -UPPER[small][at], -UPPER[small][at] + width)
    if letter.isupper() and small in LOWER:
        upper = _upper_of_hole(tolerance_class, small, grade, at)
        return _limits(size, upper - width, upper)
    raise FrameError(
        f"tolerance class {tolerance_class!r}: of shafts there are {', '.join([*UPPER, 'js', *LOWER])}, of holes "
        f"{', '.join([*(each.upper() for each in UPPER), 'JS', *(each.upper() for each in LOWER)])}"
    )


def _upper_of_hole(tolerance_class: str, small: str, grade: int, at: int) -> float:
    """Upper deviation of holes K to P, µm (table 3).

    It is the negative of the lower deviation of the shaft with the same letter, in the finer grades plus the difference
    between the tolerances of the grade and of the next finer one. Then the hole with a shaft h of the next finer grade
    has the same clearances as the hole H with the shaft of the same letter.
    """
    if grade < FINEST_HOLE or (small == "k" and grade > COARSEST["k"] and at > 0):
        raise FrameError(
            f"tolerance class {tolerance_class!r}: holes K to P have grades from {FINEST_HOLE} on, and K beyond 3 mm "
            f"to {COARSEST['k']}"
        )
    below = -float(LOWER[small][at])
    if at == 0:
        return below
    if grade > COARSEST[small]:
        return 0.0 if small == "n" else below
    if (small, grade, SIZES[at]) == ("m", 6, 315):
        return -9.0  # printed in the standard; the rule gives -11
    return below + GRADES[grade][at] - GRADES[grade - 1][at]


@dataclass(frozen=True)
class Fit:
    """Fit of a pin in a hole.

    Attributes
    ----------
    name
        Tolerance classes of hole and shaft, such as ``"H7/g6"``.
    hole, shaft
        Limits of size of the hole and of the shaft.
    """

    name: str
    hole: LimitsOfSize
    shaft: LimitsOfSize

    @property
    def least_clearance(self) -> float:
        """Smallest hole minus largest shaft, on the diameter, m; a negative value is an interference."""
        return _exact(self.hole.lower - self.shaft.upper)

    @property
    def greatest_clearance(self) -> float:
        """Largest hole minus smallest shaft, on the diameter, m."""
        return _exact(self.hole.upper - self.shaft.lower)

    @property
    def offset(self) -> float:
        """Largest distance of the pin's axis from the hole's axis, half the greatest clearance, m.

        This is the radial clearance that joints are given; 0 if there is only interference.
        """
        return 0.5 * max(self.greatest_clearance, 0.0)


def fit(size: float, name: str) -> Fit:
    """Fit with given tolerance classes of hole and shaft.

    Parameters
    ----------
    size
        Nominal diameter, m.
    name
        Tolerance classes of hole and shaft, such as ``"H7/g6"``.

    Returns
    -------
    Fit
        Limits of size and clearances, m.

    Raises
    ------
    FrameError
        If the name is not a fit of a hole and a shaft, or a size or class is not in the tables.

    Examples
    --------
    >>> found = fit(0.025, "H7/g6")
    >>> found.least_clearance, found.greatest_clearance
    (7e-06, 4.1e-05)
    """
    hole, _, shaft = (each.strip() for each in name.partition("/"))
    if not hole[:1].isupper() or not shaft[:1].islower():
        raise FrameError(f"fit {name!r}: write the hole's class before the shaft's, such as 'H7/g6'")
    return Fit(f"{hole}/{shaft}", limits_of_size(size, hole), limits_of_size(size, shaft))


def _range(size: float) -> int:
    millimetres = round(1e3 * float(size), 9)
    if not 0.0 < millimetres <= SIZES[-1]:
        raise FrameError(f"size {size!r} m: ISO 286 has tables for sizes above 0 up to {1e-3 * SIZES[-1]:g} m")
    return bisect_left(SIZES, millimetres)


def _limits(size: float, lower: float, upper: float) -> LimitsOfSize:
    return LimitsOfSize(float(size), _micrometres(lower), _micrometres(upper))


def _micrometres(value: float) -> float:
    """Micrometres in metres, rounded as a decimal literal is."""
    return float(f"{value}e-6")


def _exact(value: float) -> float:
    """A difference of table values in metres without rounding errors, rounded to a thousandth of a micrometre."""
    return float(f"{round(value / MICRO, 3)}e-6")
