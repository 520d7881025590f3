"""The reference's stiffness method in 50 digits for long structures: eliminated along their length, in the band.

`reference.stiffness_method` adds its elements into one dense matrix. Here the same elements go into a sparse one,
whose unknowns are eliminated in the order of the nodes, so that a chain of two hundred links takes seconds.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from reference.stiffness_method import EXACT, deformation, gap, mp
from reference.structure import COMPONENTS, Structure

Number = Any


def displacements(structure: Structure) -> dict[str, NDArray[np.float64]]:
    """Displacements ``ux uy uz rx ry rz`` of every node, rounded to double precision at the very end."""
    start = {name: 6 * k for k, name in enumerate(structure.nodes)}
    held = {start[node] + COMPONENTS.index(name) for node, names in structure.supports.items() for name in names}
    matrix: dict[int, dict[int, Number]] = {}
    pieces = [(m.start, m.end, *deformation(m, structure, EXACT)) for m in structure.members.values()]
    pieces += [(j.first, j.second, *gap(j, EXACT)) for j in structure.joints.values()]
    for first, second, k, relative in pieces:
        dofs = [*range(start[first], start[first] + 6), *range(start[second], start[second] + 6)]
        _add(matrix, [-1 if dof in held else dof for dof in dofs], k, relative)
    load = {start[node] + k: mp.mpf(f) for node, six in structure.loads.items() for k, f in enumerate(six) if f != 0}
    found = _solved(matrix, {dof: f for dof, f in load.items() if dof not in held})
    return {name: np.array([float(found.get(at + k, 0.0)) for k in range(6)]) for name, at in start.items()}


def _add(matrix: dict[int, dict[int, Number]], dofs: list[int], k: NDArray[Any], relative: NDArray[Any]) -> None:
    """Add the element of stiffness k (6, 6) on deformations relative (6, 12)."""
    rows = [{dof: b for dof, b in zip(dofs, row, strict=True) if b != 0 and dof >= 0} for row in relative]
    for i, row in enumerate(rows):
        for j, other in enumerate(rows):
            if k[i, j] != 0:
                for a, left in row.items():
                    into = matrix.setdefault(a, {})
                    for b, right in other.items():
                        into[b] = into.get(b, 0) + left * k[i, j] * right


def _solved(matrix: dict[int, dict[int, Number]], load: dict[int, Number]) -> dict[int, Number]:
    """Solve by LDL^T in the order of the unknowns; those that nothing pushes are left out."""
    matrix = {a: matrix[a] for a in _reached(matrix, set(load))}
    steps = []
    for pivot in sorted(matrix):
        row = matrix.pop(pivot)
        diagonal = row.pop(pivot)
        pushed = load.pop(pivot, 0)
        for a, value in row.items():
            factor = value / diagonal
            target = matrix[a]
            del target[pivot]
            for b, other in row.items():
                target[b] = target.get(b, 0) - factor * other
            load[a] = load.get(a, 0) - factor * pushed
        steps.append((pivot, diagonal, row, pushed))
    found: dict[int, Number] = {}
    for pivot, diagonal, row, pushed in reversed(steps):
        found[pivot] = (pushed - sum(value * found[a] for a, value in row.items())) / diagonal
    return found


def _reached(matrix: dict[int, dict[int, Number]], loaded: set[int]) -> set[int]:
    """Unknowns that are coupled with the loaded ones."""
    found, waiting = set(loaded), list(loaded)
    while waiting:
        for b, value in matrix[waiting.pop()].items():
            if value != 0 and b not in found:
                found.add(b)
                waiting.append(b)
    return found
