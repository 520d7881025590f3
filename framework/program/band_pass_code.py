"""Banded solutions of many batch entries, from the stiffness of springs to refined displacements in one pass.

As `band_code` and `pair_code` do step by step for all entries, here all steps are done for a vector of entries before
the next one, so that their matrix stays in the processor's cache. Operations and their order are the same. It needs the
extra ``fast``.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .loop_text import VECTOR as _V
from .machine_code import compiled_kernel
from .machine_text import WIDTH
from .pair_code import Rows, SpringLoops

Array = NDArray[np.float64]
Index = NDArray[np.int64]
# Up to this width of the band loops over it are written out.
_WRITTEN_OUT = 12
_LANES = str(WIDTH)


class Cells(NamedTuple):
    """Entries of a banded matrix, column by column on and below the diagonal, as sums of springs with factors.

    Attributes
    ----------
    start
        Index at which the terms of each entry start, and at last where they end, (columns times width + 1).
    spring, factor
        Spring and factor of each term.
    """

    start: Index
    spring: Index
    factor: Array


class Refinement(NamedTuple):
    """When a solution is refined no further, see `linkframe.framework.solvers.stacked_refinement`.

    Attributes
    ----------
    rough
        Estimated relative error of a solution, times the square of the least pivot.
    safe, fine
        Safety factor on the estimated error, and the error to reach.
    lost
        Relative change above which a solution is not accepted.
    steps
        Largest number of steps.
    """

    rough: float
    safe: float
    fine: float
    lost: float
    steps: int


class BandPass:
    """The pass for matrices of one pattern.

    Parameters
    ----------
    cells
        The entries of the matrices.
    rows
        Deformations of the springs per unknown.
    size, width
        Number of columns, and of diagonals on and below the main one.
    refinement
        When to stop.
    """

    def __init__(self, cells: Cells, rows: Rows, size: int, width: int, refinement: Refinement) -> None:
        self._cells, self._rows, self._size, self._width = cells, rows, size, width
        self._scalars = np.array(refinement[:4])
        self._steps = refinement.steps
        self._function = _function(width if width <= _WRITTEN_OUT else 0)
        below = size + width
        band, root, load, u, v = (np.zeros((count, WIDTH)) for count in (below * width, below, below, size, size))
        root[:] = 1.0
        self._room = [band, root, load, u, v, load]  # forces of springs become loads in their place

    def run(self, stiffness: Array, forces: Array, wanted: Index, out: Array) -> tuple[Array, Array]:
        """Solve for m entries, at least `WIDTH`.

        Parameters
        ----------
        stiffness
            Stiffness of the springs, (springs, m), or (springs, 1) if it is the same for all.
        forces
            Forces on the unknowns, (size, m) or (size, 1).
        wanted
            Numbers of the unknowns that are asked for, (n,).
        out
            Their values, (n, m), which are written.

        Returns
        -------
        tuple
            The least diagonal entry of the factor of each matrix, at most one, (m,), NaN if one is; and the relative
            change by the last step, NaN where a change is.
        """
        count = out.shape[1]
        least, error = np.empty((2, count))
        (stiff, *of_stiff), (force, *of_force) = map(_strided, (stiffness, forces))
        sizes = np.array([*of_stiff, *of_force, out.strides[0] // out.itemsize, len(wanted), self._steps, self._width])
        arrays = [*self._rows[:2], *self._rows.numbers, stiff, force, *self._cells, *self._room]
        arrays += [wanted, out, least, error, sizes, self._scalars]
        assert out.strides[1] == out.itemsize
        table = np.array([each.ctypes.data for each in arrays])
        self._function(table.ctypes.data, len(self._rows.start) - 1, self._size, count, 0)
        return least, error


def _strided(array: Array) -> tuple[Array, int, int]:
    """An array (n, m), or (n, 1) widened to a vector, how far its rows lie apart, and 1 or 0 for its entries."""
    if array.shape[1] > 1:
        array = np.ascontiguousarray(array)
        return array, array.shape[1], 1
    return np.repeat(array, WIDTH, axis=1), WIDTH, 0


@cache
def _function(width: int) -> Callable[..., None]:
    return compiled_kernel(_PassText(width).whole())


class _PassText(SpringLoops):
    """LLVM code of the pass; loops over the band are written out where its width is given."""

    arrays = (
        *("start", "column", "large", "small", "stiffness", "forces", "cells", "spring", "factor"),
        *("band", "root", "load", "u", "v", "out", "wanted", "results", "least", "error", "sizes", "scalars"),
    )

    def __init__(self, width: int) -> None:
        super().__init__()
        self._written_out = width

    def _entries(self, first: str) -> None:
        names = ("stiff pitch", "stiff step", "force pitch", "force step", "pitch", "wanted", "steps", "width")
        self._sizes = {name: self._whole("sizes", str(k)) for k, name in enumerate(names)}
        self._width = str(self._written_out) if self._written_out else self._sizes["width"]
        self._first = first
        self._assemble()
        self._scale()
        self._loop("0", "%size", self._loaded)
        self._clear_below()
        self._factorise()
        self._back("%size")
        least = self._least()
        whole = self._greatest()
        self._loop("0", "%size", self._begin)
        rough = self._two("fdiv", self._every("scalars", "0"), self._two("fmul", least, least))
        infinite = f"<{', '.join(['double 0x7FF0000000000000'] * WIDTH)}>"
        going = f"<{', '.join(['double 1.0'] * WIDTH)}>"
        begin = [infinite, rough, going, "zeroinitializer"]
        error, _, _, lacking = self._carried(
            "0", self._sizes["steps"], begin, lambda _, values: self._step(values, whole)
        )
        self._store_lane("least", first, least)
        self._store_lane("error", first, self._two("fadd", error, lacking))
        self._loop("0", self._sizes["wanted"], self._result)

    # -- the matrix ---------------------------------------------------------------------------------------------------

    def _assemble(self) -> None:
        def cell(at: str) -> None:
            start, stop = self._whole("cells", at), self._whole("cells", self._int("add", at, "1"))

            def add(k: str, sums: list[str]) -> list[str]:
                spring = self._lane("stiffness", self._of("stiff", self._whole("spring", k)))
                return [self._two("fadd", sums[0], self._two("fmul", self._every("factor", k), spring))]

            self._put("band", at, self._carried(start, stop, ["zeroinitializer"], add)[0])

        self._loop("0", self._int("mul", "%size", self._width), cell)

    def _scale(self) -> None:
        """Scale the matrix to unit diagonal."""
        one = f"<{', '.join(['double 1.0'] * WIDTH)}>"

        def root(j: str) -> None:
            diagonal = self._get("band", self._int("mul", j, self._width))
            above = self._value("b", f"fcmp ogt {_V} {diagonal}, zeroinitializer")
            some = self._vector(f"select <{WIDTH} x i1> {above}, {_V} {diagonal}, {_V} {one}")
            self._put("root", j, self._two("fdiv", one, self._root(some)))

        def column(j: str) -> None:
            own, begin = self._get("root", j), self._int("mul", j, self._width)

            def entry(i: str) -> None:
                at = self._int("add", begin, i)
                scaled = self._two("fmul", self._get("band", at), self._get("root", self._int("add", j, i)))
                self._put("band", at, self._two("fmul", scaled, own))

            self._band("0", entry)

        self._loop("0", "%size", root)
        self._loop("0", "%size", column)

    def _factorise(self) -> None:
        """Overwrite the matrix with its factor, and eliminate forward."""

        def column(j: str) -> None:
            begin = self._int("mul", j, self._width)
            diagonal = self._root(self._get("band", begin))
            self._put("band", begin, diagonal)
            found = self._two("fdiv", self._get("load", j), diagonal)
            self._put("load", j, found)

            def divide(i: str) -> None:
                at = self._int("add", begin, i)
                factor = self._two("fdiv", self._get("band", at), diagonal)
                self._put("band", at, factor)
                self._subtract(j, i, factor, found)

            def take(i: str) -> None:
                factor = self._get("band", self._int("add", begin, i))
                after = self._int("mul", self._int("add", j, i), self._width)

                def entry(k: str) -> None:
                    taken = self._two("fmul", self._get("band", self._int("add", begin, k)), factor)
                    at = self._int("add", after, self._int("sub", k, i))
                    self._put("band", at, self._two("fsub", self._get("band", at), taken))

                self._band(i, entry)

            self._band("1", divide)
            self._band("1", take)

        self._loop("0", "%size", column)

    def _least(self) -> str:
        """The least diagonal entry of the factor, or one; NaN if one is."""
        one = f"<{', '.join(['double 1.0'] * WIDTH)}>"

        def entry(j: str, found: list[str]) -> list[str]:
            number = self._get("band", self._int("mul", j, self._width))
            return [self._least_of(number, found[0]), self._unknown(number, found[1])]

        return self._two("fadd", *self._carried("0", "%size", [one, "zeroinitializer"], entry))

    # -- the solution -------------------------------------------------------------------------------------------------

    def _loaded(self, j: str) -> None:
        force = self._lane("forces", self._of("force", j))
        self._put("load", j, self._two("fmul", force, self._get("root", j)))

    def _clear_below(self) -> None:
        below = self._int("add", "%size", self._width)
        self._loop("%size", below, lambda j: self._put("load", j, "zeroinitializer"))

    def _forward(self, size: str) -> None:
        def column(j: str) -> None:
            begin = self._int("mul", j, self._width)
            found = self._two("fdiv", self._get("load", j), self._get("band", begin))
            self._put("load", j, found)
            self._band("1", lambda i: self._subtract(j, i, self._get("band", self._int("add", begin, i)), found))

        self._loop("0", size, column)

    def _subtract(self, j: str, i: str, factor: str, found: str) -> None:
        below = self._int("add", j, i)
        taken = self._two("fmul", factor, found)
        self._put("load", below, self._two("fsub", self._get("load", below), taken))

    def _back(self, size: str) -> None:
        def column(k: str) -> None:
            j = self._int("sub", self._int("sub", size, "1"), k)
            begin = self._int("mul", j, self._width)

            def row(i: str, left: list[str]) -> list[str]:
                known, share = self._get("load", self._int("add", j, i)), self._get("band", self._int("add", begin, i))
                return [self._two("fsub", left[0], self._two("fmul", share, known))]

            left = [self._get("load", j)]
            if self._written_out:
                for i in range(1, self._written_out):
                    left = row(str(i), left)
            else:
                left = self._carried("1", self._width, left, row)
            self._put("load", j, self._two("fdiv", left[0], self._get("band", begin)))

        self._loop("0", size, column)

    def _greatest(self) -> str:
        """The greatest magnitude of the scaled solution."""
        return self._carried("0", "%size", ["zeroinitializer"], lambda j, found: [self._more(j, found[0])])[0]

    def _more(self, j: str, found: str) -> str:
        size = self._vector(f"call {_V} @llvm.fabs.v{WIDTH}f64({_V} {self._get('load', j)})")
        more = self._value("b", f"fcmp ogt {_V} {size}, {found}")
        return self._vector(f"select <{WIDTH} x i1> {more}, {_V} {size}, {_V} {found}")

    def _begin(self, j: str) -> None:
        self._put("u", j, self._two("fmul", self._get("load", j), self._get("root", j)))
        self._put("v", j, "zeroinitializer")

    # -- refinement ---------------------------------------------------------------------------------------------------

    def _step(self, values: list[str], whole: str) -> list[str]:
        """One step of refinement, of entries that are still going; nothing is done where none is."""
        error, contraction, going, lacking = values
        on = self._value("b", f"fcmp ogt {_V} {going}, zeroinitializer")
        lanes = self._value("n", f"bitcast <{WIDTH} x i1> {on} to i{WIDTH}")
        some = self._value("b", f"icmp ne i{WIDTH} {lanes}, 0")
        size = self._value("n", f"select i1 {some}, i64 %size, i64 0")
        springs = self._value("n", f"select i1 {some}, i64 %springs, i64 0")
        self._residual(size, springs)
        self._forward(size)
        self._back(size)
        moved, unknown = self._added(size, on)
        lacking = self._two("fadd", lacking, unknown)
        return [*self._judged(moved, whole, error, contraction, going, on), lacking]

    def _residual(self, size: str, springs: str) -> None:
        def place(name: str, row: str) -> str:
            return self._of("stiff", row) if name == "stiffness" else self._int("mul", row, _LANES)

        def leave(j: str) -> None:
            left = self._two("fsub", self._lane("forces", self._of("force", j)), self._get("out", j))
            self._put("load", j, self._two("fmul", left, self._get("root", j)))

        self._loop("0", size, lambda j: self._put("out", j, "zeroinitializer"))
        self._loop("0", springs, lambda spring: self._spring(spring, place))
        self._loop("0", size, leave)
        self._clear_below()

    def _added(self, size: str, on: str) -> list[str]:
        """Add the changes; the greatest of them, and NaN where one is."""

        def one(j: str, found: list[str]) -> list[str]:
            scaled = self._vector(f"select <{WIDTH} x i1> {on}, {_V} {self._get('load', j)}, {_V} zeroinitializer")
            self._put("load", j, scaled)
            whole, lost = self._sum(self._get("u", j), self._two("fmul", scaled, self._get("root", j)))
            self._put("u", j, whole)
            self._put("v", j, self._two("fadd", lost, self._get("v", j)))
            return [self._more(j, found[0]), self._unknown(scaled, found[1])]

        return self._carried("0", size, ["zeroinitializer"] * 2, one)

    def _judged(self, moved: str, whole: str, error: str, contraction: str, going: str, on: str) -> list[str]:
        """Error, contraction and whether entries are going on, after a step that moved them so far."""
        kind = f"<{WIDTH} x i1>"

        def select(mask: str, one: str, other: str) -> str:
            return self._vector(f"select {kind} {mask}, {_V} {one}, {_V} {other}")

        def compare(how: str, one: str, other: str) -> str:
            return self._value("b", f"fcmp {how} {_V} {one}, {other}")

        infinite = f"<{', '.join(['double 0x7FF0000000000000'] * WIDTH)}>"
        share = select(compare("ogt", moved, "zeroinitializer"), self._two("fdiv", moved, whole), "zeroinitializer")
        faster = select(compare("ogt", share, contraction), share, contraction)
        begun = compare("oeq", error, infinite)
        contraction = select(begun, faster, self._two("fdiv", share, error))
        error = select(on, share, error)
        left = self._two("fmul", self._two("fmul", self._every("scalars", "1"), share), contraction)
        done = self._value(
            "b",
            f"and {kind} {compare('ole', left, self._every('scalars', '2'))}, "
            f"{compare('ole', share, self._every('scalars', '3'))}",
        )
        return [error, contraction, select(done, "zeroinitializer", going)]

    def _result(self, k: str) -> None:
        j = self._whole("wanted", k)
        at = self._int("add", self._int("mul", k, self._sizes["pitch"]), self._first)
        self._store_lane("results", at, self._two("fadd", self._get("u", j), self._get("v", j)))

    # -- how it is written --------------------------------------------------------------------------------------------

    def _band(self, start: str, body: Callable[[str], None]) -> None:
        """Do something for the diagonals from `start` on."""
        if self._written_out:
            for i in range(int(start), self._written_out):
                body(str(i))
        else:
            self._loop(start, self._width, body)

    def _of(self, kind: str, row: str) -> str:
        """Where the numbers of a row of stiffnesses or forces lie."""
        own = self._int("mul", self._first, self._sizes[f"{kind} step"])
        return self._int("add", self._int("mul", row, self._sizes[f"{kind} pitch"]), own)

    def _get(self, name: str, row: str) -> str:
        return self._load(self._at[name], row)

    def _put(self, name: str, row: str, value: str) -> None:
        self._store(self._at[name], row, value)

    def _root(self, value: str) -> str:
        return self._vector(f"call {_V} @llvm.sqrt.v{WIDTH}f64({_V} {value})")

    def _least_of(self, number: str, found: str) -> str:
        less = self._value("b", f"fcmp olt {_V} {number}, {found}")
        return self._vector(f"select <{WIDTH} x i1> {less}, {_V} {number}, {_V} {found}")

    def _unknown(self, number: str, found: str) -> str:
        """What was found, or NaN where the number is."""
        unknown = self._value("b", f"fcmp uno {_V} {number}, {number}")
        return self._vector(f"select <{WIDTH} x i1> {unknown}, {_V} {number}, {_V} {found}")
