"""Many structures of one topology at once in double-double numbers: what a million results are compared with.

The members are those of the reference in 50 digits; the second node of a joint is ``u2 = u1 + A^-T d``, so that a stiff
spring stands alone on its own unknown, and 106 bits are plenty. Tests compare it with the 50 digits.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from reference.stiffness_method import Arithmetic, deformation
from reference.structure import COMPONENTS, Structure

from .double_double import DoubleDouble, number, square_root

Array = np.ndarray[Any, np.dtype[Any]]


def eliminate(matrix: Array, right: Array) -> Array:
    """Solve a symmetric positive definite system by L D L^T without pivoting."""
    size = len(right)
    for k in range(size):
        below = [i for i in range(k + 1, size) if not _zero(matrix[k, i])]
        factors = {i: matrix[k, i] / matrix[k, k] for i in below}
        for at, i in enumerate(below):
            for j in below[at:]:
                matrix[i, j] = matrix[i, j] - factors[i] * matrix[k, j]
            right[i] = right[i] - factors[i] * right[k]
    for k in reversed(range(size)):
        rest = right[k]
        for j in range(k + 1, size):
            if not _zero(matrix[k, j]):
                rest = rest - matrix[k, j] * right[j]
        right[k] = rest / matrix[k, k]
    return right


def _zero(value: Any) -> bool:
    return not isinstance(value, DoubleDouble)


DOUBLE_DOUBLE = Arithmetic(number, square_root, object, eliminate)


def solve(structure: Structure) -> dict[str, Array]:
    """Displacements (6,) of all nodes, each an array over the models.

    Parameters
    ----------
    structure
        Numbers may be `DoubleDouble`; no rigid links; each joint has a second node of its own, or one that is clamped
        and a first node of its own; nodes are clamped or free.
    """
    moved = _substitution(structure)
    unknowns = sorted({name for row in moved.values() for name in row})
    at = {name: 6 * k for k, name in enumerate(unknowns)}
    size = 6 * len(unknowns)
    matrix: Array = np.full((size, size), 0.0, dtype=object)
    right: Array = np.full(size, 0.0, dtype=object)
    for member in structure.members.values():
        stiffness, map_ = deformation(member, structure, DOUBLE_DOUBLE)
        columns: Mapping[str, Array] = _sum(
            {name: map_[:, :6] @ part for name, part in moved[member.start].items()},
            {name: map_[:, 6:] @ part for name, part in moved[member.end].items()},
        )
        for one, left in columns.items():
            pulled = left.T @ stiffness
            for other, rest in columns.items():
                matrix[at[one] : at[one] + 6, at[other] : at[other] + 6] += pulled @ rest
    for name, joint in structure.joints.items():
        for k, stiffness in enumerate(joint.stiffness):
            matrix[at[name] + k, at[name] + k] = matrix[at[name] + k, at[name] + k] + number(stiffness)
    for node, load in structure.loads.items():
        for name, part in moved[node].items():
            right[at[name] : at[name] + 6] += part.T @ DOUBLE_DOUBLE.array(load)
    found = eliminate(matrix, right)
    zero: Array = np.full(6, 0.0, dtype=object)
    return {
        node: sum((part @ found[at[name] : at[name] + 6] for name, part in row.items()), zero)
        for node, row in moved.items()
    }


def _substitution(structure: Structure) -> dict[str, dict[str, Array]]:
    """By node: its displacement from those of free nodes and of joints, as matrices (6, 6)."""
    for held in structure.supports.values():
        assert set(held) == set(COMPONENTS), "nodes are clamped or free"
    hanging = {}
    for name, joint in structure.joints.items():
        if joint.second in structure.supports:
            hanging[joint.first] = (name, joint.second, -1.0)
        else:
            hanging[joint.second] = (name, joint.first, 1.0)
    unit = DOUBLE_DOUBLE.array(np.eye(6))
    out: dict[str, dict[str, Array]] = {}

    def row(node: str) -> dict[str, Array]:
        if node not in out:
            if node in structure.supports:
                out[node] = {}
            elif node in hanging:
                name, parent, sign = hanging[node]
                out[node] = {**row(parent), name: sign * _dual(structure.joints[name].axes)}
            else:
                out[node] = {node: unit}
        return out[node]

    for node in structure.nodes:
        row(node)
    return out


def _dual(axes: Any) -> Array:
    """A^-T twice on the diagonal (6, 6), for axes A that are orthonormal to rounding: A (I - E + E E)."""
    columns = DOUBLE_DOUBLE.array(axes)
    off = columns.T @ columns - DOUBLE_DOUBLE.array(np.eye(3))
    dual = columns - columns @ off + columns @ (off @ off)
    out: Array = np.full((6, 6), 0.0, dtype=object)
    out[:3, :3] = out[3:, 3:] = dual
    return out


def _sum(one: dict[str, Array], other: dict[str, Array]) -> dict[str, Array]:
    return {
        name: one[name] + other[name] if name in one and name in other else one.get(name, other.get(name))
        for name in {**one, **other}
    }
