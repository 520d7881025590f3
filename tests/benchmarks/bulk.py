"""Benchmark 14: 10^5 beams in bulk: described by two calls, solved under one load and another, read, saved, bounded.

Errors: of the description its distance from the arrays; of solutions their bounds, relative; of what is read at once
the difference from one node and one member; of the file that of what meshio reads of it from the solution.
"""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from linkframe.elements import Beam, Material, Section
from linkframe.framework import Frame, Solution
from numpy.typing import NDArray

from .harness import Row, Target, least, least_each, main, write

BEAM = Beam(Section(A=1e-2, Iy=1e-5, Iz=2e-5, J=2e-5), Material(E=2e11, nu=0.3))
DESCRIBED, SAVED, SOLVED = "described", "saved as .vtu", "solved by iteration"
AGAIN = "solved under another load"
NODES, MEMBERS = "displacements of all nodes", "end forces of all members"
FIRST, FURTHER = "bound of a node", "bound of a further node"
# Seconds for 10^5 beams, and shares of the solution.
LIMITS = {DESCRIBED: 0.1, SAVED: 3.0, NODES: 0.3, MEMBERS: 0.3}
SHARES = {FIRST: 1.0, FURTHER: 0.1, AGAIN: 0.5}
WHY = {
    AGAIN: "the first solution has the condensed matrix and the test for mechanisms besides the iterations",
    FIRST: "the solution in extended precision, a correction of some digits, and the least eigenvalue",
    FURTHER: "five iterations for each of six components",
}
LARGE, QUICK = 33, 10

Array = NDArray[np.float64]


def run(out: Path, quick: bool) -> list[Target]:
    """A cube of beams, its nodes off their places by a tenth."""
    rows = measure(QUICK if quick else LARGE, 3 if quick else 5)
    write(out, "bulk", rows)
    return targets(rows)


def measure(size: int, repeats: int) -> list[Row]:
    """A row for each thing that is done with so many nodes along an edge."""
    points, pairs = cube(size)
    count = {"beams": len(pairs)}
    frame = described(points, pairs)
    seconds = {DESCRIBED: least(lambda: described(points, pairs), repeats)}
    errors = {DESCRIBED: apart(frame, points, pairs)}
    support(frame, points)
    top = str(len(points) - 1)
    begun()
    solution = frame.solve("iterative")
    seconds[SOLVED] = least(lambda: solution.displacement(top), 1)
    errors[SOLVED] = bound(solution, top)
    seconds[NODES] = least(solution.displacements, 1)
    errors[NODES] = float(np.abs(solution.displacements()[-1] - solution.displacement(top)).max())
    seconds[MEMBERS] = least(solution.all_end_forces, 1)
    first = next(iter(frame.members))
    errors[MEMBERS] = float(np.abs(solution.all_end_forces()[0] - solution.end_forces(first)).max())
    frame.set_load(top, fx=-200.0, fz=1e3)
    other = frame.solve("iterative")
    seconds[AGAIN] = least(lambda: other.displacement(top), 1)
    errors[AGAIN] = bound(other, top)
    seconds |= bounds(frame, [top, str(len(points) // 2 + size // 2), str(len(points) - size)])
    with TemporaryDirectory() as folder:
        path = Path(folder) / "cube.vtu"
        seconds[SAVED] = least_each({SAVED: lambda: solution.save(path)}, min(repeats, 2))[SAVED]
        errors[SAVED] = unlike(path, solution, top)
    return [{"what": what, **count, "seconds": spent, "error": errors.get(what, "")} for what, spent in seconds.items()]


def cube(size: int) -> tuple[Array, NDArray[np.int64]]:
    """Positions of nodes (n, 3), and pairs of their numbers."""
    grid = np.stack(np.meshgrid(*[np.arange(size)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    numbers = np.arange(size**3).reshape((size,) * 3)
    along = [(np.take(numbers, range(size - 1), k), np.take(numbers, range(1, size), k)) for k in range(3)]
    pairs = np.concatenate([np.stack([first.ravel(), last.ravel()], axis=-1) for first, last in along])
    return grid + 0.1 * np.random.default_rng(0).random(grid.shape), pairs


def described(points: Array, pairs: NDArray[np.int64]) -> Frame:
    """Nodes and members, by one call each."""
    frame = Frame()
    frame.add_nodes(len(points), points)
    frame.add_many(BEAM, pairs)
    return frame


def support(frame: Frame, points: Array) -> None:
    """Held where it stands, and loaded at a corner of its top."""
    frame.fix_many([str(k) for k in np.flatnonzero(points[:, 2] < 0.5)])
    frame.load(str(len(points) - 1), fx=1e3, fy=300.0, mz=20.0)


def apart(frame: Frame, points: Array, pairs: NDArray[np.int64]) -> float:
    """Distance of chords in the frame from those of the arrays."""
    ends = [frame.position(member.end) - frame.position(member.start) for member in list(frame.members.values())[::99]]
    return float(np.abs(np.array(ends) - (points[pairs[::99, 1]] - points[pairs[::99, 0]])).max())


def begun() -> None:
    """A small one, for all that is loaded once."""
    points, pairs = cube(3)
    frame = described(points, pairs)
    support(frame, points)
    frame.solve("iterative").error_bound("0")


def bounds(frame: Frame, nodes: list[str]) -> dict[str, float]:
    """Seconds of the first bound of a solution that has been read, and of further ones."""
    solution = frame.copy().solve("iterative")
    solution.displacement(nodes[0])
    first, *further = (least(lambda node=node: solution.error_bound(node), 1) for node in nodes)  # type: ignore[misc]
    return {FIRST: first, FURTHER: float(np.mean(further))}


def bound(solution: Solution, node: str) -> float:
    """Bound of the displacement of a node, relative."""
    return float(np.abs(solution.error_bound(node)).max() / np.abs(solution.displacement(node)).max())


def unlike(path: Path, solution: Solution, node: str) -> float:
    """Difference of the greatest displacement in a file from that of the solution, relative."""
    import meshio

    there = meshio.read(path)
    place = np.argmin(np.linalg.norm(there.points - solution.frame.position(node), axis=1))
    exact = solution.displacement(node)[:3]
    return float(np.abs(there.point_data["displacement"][place] - exact).max() / np.abs(exact).max())


def targets(rows: list[Row]) -> list[Target]:
    """Limits in seconds for 10^5 beams, and shares of the solution."""
    seconds, beams = {row["what"]: row["seconds"] for row in rows}, rows[0]["beams"]
    found = []
    for what, most in LIMITS.items():
        limit = most * beams / 1e5
        told = f"{seconds[what]:.3f} s"
        found.append(Target("14 bulk", f"{beams} beams {what}: below {limit:.2g} s", told, seconds[what] < limit))
    for what, share in SHARES.items():
        ratio = seconds[what] / seconds[SOLVED]
        told = f"{ratio:.2f} ({seconds[what]:.2f} s)"
        found.append(
            Target("14 bulk", f"{what}: at most {share:g} times the solution", told, ratio <= share, WHY[what])
        )
    return found


if __name__ == "__main__":
    main("bulk", run)
