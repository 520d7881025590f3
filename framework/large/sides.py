"""To which side an unstable equilibrium is left, where its free mode leads down to both.

To the side to which the first little share of the loads moves the frame: there it goes on when it is loaded bit by bit.
Where that is neither, as along the axis of a straight column, the two ways are mirror images and the choice is
arbitrary; it is then told by how the described nodes move, so that it does not depend on what the frame is made of: of
the largest displacements, or rotations times the size of the frame, the first in the order of nodes is positive.
"""

from __future__ import annotations

import numpy as np

from .. import rotation
from ..batch import Array
from ..elementwise import contracted
from .limits import NEITHER
from .newton import Newton
from .protocols import Balance, Index, Place

# Amount of a mode that shows how nodes move, in radians or sizes of the frame; displacements, as a share of the
# largest, that are as large.
_AMOUNT, _ALIKE = 1e-6, 0.999
# Difference of eigenvalues, beside a unit diagonal, within which any mixture of their modes is a mode.
_EQUAL = 1e-9


def amount(newton: Newton, balance: Balance, state: Place, mode: Array) -> Array:
    """Component of a mode (n, m) that is seen most, in radians or sizes of the frame, (m,).

    Positive where the mode as it stands leads to the side to which `state` is to be left.
    """
    free = newton.model.free
    scale = balance.scale[:free]
    weighted = mode * scale
    size: Array = np.abs(weighted).max(axis=0)
    size = np.where(size > 0.0, size, 1.0)
    load, compliance = _at_rest(newton, balance, scale * weighted)
    along = contracted("im,im->m", load, compliance)
    load = np.divide(load, scale, out=np.zeros_like(load), where=scale > 0.0)
    most = np.abs(load).max(axis=0, initial=0.0) * np.abs(scale * compliance).max(axis=0, initial=0.0)
    pushed = np.abs(along) > NEITHER * most
    seen = _seen(newton, balance, state, mode / size)
    side: Array = np.where(pushed, np.sign(along), np.where(seen < 0.0, -1.0, 1.0))
    return side * size


def softest(values: Array, vectors: Array, root: Array) -> Array:
    """The softest mode (n, m) of a spectrum; where several are as soft, one that depends on no rounding.

    That is the shadow of a fixed vector on all of them: which of them the spectrum has is arbitrary.
    """
    alike = np.where(values <= values[:, :1] + _EQUAL, 1.0, 0.0)
    fixed = 1.0 / np.arange(1.0, vectors.shape[1] + 1.0)
    share = alike * (vectors * fixed[:, None]).sum(axis=1)
    size = np.sqrt((share * share).sum(axis=1, keepdims=True))
    clear = (size > NEITHER) & (alike.sum(axis=1, keepdims=True) > 1.0)
    share = np.where(clear, share / np.where(clear, size, 1.0), np.arange(values.shape[1]) == 0)
    out: Array = ((vectors * share[:, None, :]).sum(axis=2) * root).T
    return np.ascontiguousarray(out)


def _at_rest(newton: Newton, balance: Balance, weights: Array) -> tuple[Array, Array]:
    """Loads at rest (free, m), and by how much they change a weighed sum of the displacements; zero where singular."""
    start, free = newton.start(weights.shape[-1]), newton.model.free
    at = balance.linearised(start)
    load, prescribed_residual = -at.forces[:free], balance.prescribed_residual(start)
    if len(prescribed_residual):
        load = load - newton.elimination.prescribed_forces(at.values, prescribed_residual)
    # what a free motion resists with is rounding, of either sign: a little more makes it positive
    stiffer = newton.elimination.raised(at.values, np.full(weights.shape[-1], newton.free))
    with np.errstate(all="ignore"):
        change = newton.elimination.factor(stiffer, symmetric=newton.model.symmetric).solve(weights)
    return load, np.where(np.isfinite(change).all(axis=0), change, 0.0)


def _seen(newton: Newton, balance: Balance, state: Place, mode: Array) -> Array:
    """Of the largest displacements and rotations of the described nodes in a mode, the first (m,)."""
    each = node_motion(newton, balance, state, mode)
    each[3:] *= balance.lengths
    # displacements of all nodes before rotations
    each = each.reshape(2, 3, *each.shape[1:]).swapaxes(1, 2).reshape(-1, mode.shape[-1])
    first: Index = (np.abs(each) >= _ALIKE * np.abs(each).max(axis=0)).argmax(axis=0)
    out: Array = each[first, np.arange(each.shape[-1])]
    return out


def node_motion(newton: Newton, balance: Balance, state: Place, mode: Array) -> Array:
    """Displacements and rotations of the described nodes by a little of a mode (n, m), global, (6, nodes, m)."""
    step = np.zeros((newton.model.size, mode.shape[-1]))
    step[: newton.model.free] = _AMOUNT * mode
    before, after = newton.space(state), newton.space(balance.advanced(state, step))
    count = len(newton.model.frame.nodes)
    displacements = (after.displacements - before.displacements)[:, :count]
    back = rotation.conjugate(before.rotations[:, :count])
    rotations = rotation.logarithm(rotation.product(after.rotations[:, :count], back))
    return np.concatenate([displacements, rotations])
