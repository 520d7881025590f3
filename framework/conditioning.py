"""Condition numbers, of the usual assembly and of the one that is solved."""

from __future__ import annotations

import numpy as np

from . import dense
from .batch import Array, aligned
from .errors import FrameError
from .plan import Plan


def usual(plan: Plan) -> Array:
    """2-norm condition number of K as structural programs assemble it, (...).

    Every node has its six global displacements, joints are 12 x 12 springs between duplicate nodes, held components
    are struck out.

    Raises
    ------
    FrameError
        Where a joint is ideal or a tie would need a penalty.
    """
    frame, topology = plan.frame, plan.topology
    if frame.ties:
        raise FrameError("condition_number: rigid links and ties have no usual assembly: use scaled_condition_number()")
    stacks = []
    for group in topology.groups:
        local = group.element.stiffness_matrix(group.length)
        turn = np.zeros((*group.level.shape[:-2], 12, 12))
        for block in range(4):
            turn[..., 3 * block : 3 * block + 3, 3 * block : 3 * block + 3] = group.level
        stacks.append((group, np.swapaxes(turn, -1, -2) @ local @ turn))
    matrix = dense.nodal(plan, stacks)
    for name, joint in frame.joints.items():
        if np.isinf(joint.element.stiffness).any():
            raise FrameError(f"condition_number: joint {name!r} is ideal (inf): use scaled_condition_number()")
        matrix = _with_joint(plan, matrix, name)
    held = {6 * topology.number[node] + k for node, parts in frame.supports.items() for k in parts}
    free = [k for k in range(matrix.shape[-1]) if k not in held]
    return _ratio(plan, matrix[..., free, :][..., :, free])


def scaled(plan: Plan) -> Array:
    """2-norm condition number of K in joint-relative coordinates with unit diagonal, (...)."""
    return _ratio(plan, dense.scaled(dense.stiffness(plan))[0])


def _with_joint(plan: Plan, matrix: Array, name: str) -> Array:
    link = plan.frame.joints[name]
    ndim = len(plan.frame.shape)
    stiffness = aligned(link.element.stiffness, ndim, 1)
    axes = np.eye(3) if link.element.axes is None else aligned(link.element.axes, ndim, 2)
    block = np.zeros((*np.broadcast_shapes(stiffness.shape[:-1], axes.shape[:-2]), 6, 6))
    for at in (slice(0, 3), slice(3, 6)):
        block[..., at, at] = (axes * stiffness[..., None, at]) @ np.swapaxes(axes, -1, -2)
    out = np.array(np.broadcast_to(matrix, (*np.broadcast_shapes(matrix.shape[:-2], block.shape[:-2]), *matrix.shape[-2:])))
    first, second = (slice(6 * k, 6 * k + 6) for k in (plan.topology.number[link.first], plan.topology.number[link.second]))
    for a, b, sign in ((first, first, 1.0), (second, second, 1.0), (first, second, -1.0), (second, first, -1.0)):
        out[..., a, b] += sign * block
    return out


def _ratio(plan: Plan, matrix: Array) -> Array:
    if matrix.shape[-1] == 0:
        return np.ones(plan.frame.shape)
    values = np.abs(np.linalg.eigvalsh(matrix))
    with np.errstate(divide="ignore"):
        ratio = values.max(axis=-1) / values.min(axis=-1)
    return np.array(np.broadcast_to(ratio, plan.frame.shape))
