"""Members of a batch of dimensions: which of them may start from the poses of the leading member.

Each member must arrive at the poses that it would reach alone. Where its path runs beside that of the leading member,
Newton's method from the leading member's poses finds the same.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ....framework.batch import Array, Shape
from ..kinematics.blocks import members_of
from ..kinematics.loop_coordinates import FIRST_STEP
from ..kinematics.loops import Loops
from ..kinematics.nearest import nearest, open_by
from ..kinematics.terms import Value
from .follow import Guide
from .interpolation import weights
from .predictor_corrector import BEYOND, OPEN

Mask = NDArray[np.bool_]
CLOSED = 1e-12
# A member accompanies the leading one as far as its determinants are at least this share of the leading member's at all
# poses where these are least or the path is most curved.
SHARE = 0.5
# Distance within which change points of two members are in the same place.
SAME_PLACE = 1e-7


@dataclass(frozen=True, eq=False)
class Starts:
    """Reference configurations of all members, each closed from the points as described.

    Attributes
    ----------
    state
        Entries of their states, of the linkage's batch shape.
    determinants
        Determinants of the blocks of equations.
    closed
        Whether each member can be assembled.
    """

    state: list[Value]
    determinants: list[Value]
    closed: Mask


def own_starts(loops: Loops, parameters: Sequence[Value], shape: Shape) -> Starts:
    """Close each member of the batch at the reference values of the drives, from the points as described."""
    reference_state: list[Value] = [np.full(shape, x) for x in loops.reference_state]
    found = loops.close_all(reference_state, parameters)
    state, closed = [np.broadcast_to(x, shape).copy() for x in found.state], np.array(found.trusted)
    determinants = [np.broadcast_to(x, shape).copy() for x in found.determinants]
    bad = ~closed
    if bad.any():
        own = members_of(parameters, bad)
        best, gap = nearest(loops, [np.full(int(bad.sum()), x) for x in loops.reference_state], own)
        polished = loops.close_all(best, own)
        for whole, x in zip(state, polished.state, strict=True):
            whole[bad] = x
        for whole, x in zip(determinants, polished.determinants, strict=True):
            whole[bad] = x
        closed[bad] = (gap < max(CLOSED, loops.tolerance)) & polished.trusted
    error = open_by(loops, state, parameters)
    return Starts(list(state), list(determinants), closed & (error < max(CLOSED, loops.tolerance)))


def accompanied(
    loops: Loops, guide: Guide, parameters: Sequence[Value], nominal: Sequence[float], starts: Starts, s: Array
) -> Array:
    """How far back and ahead each member accompanies the leading path, (2, ...) of the linkage's batch shape.

    It is tested where the leading path comes nearest to a singular pose or is most curved: there Newton's method must
    reach the member from the leading one in few steps, on the same side of its singular poses and not much nearer to
    them. It passes a change point together with the leading path if it has one in the same place. Only poses on the way
    to the lengths s are tested.
    """
    shape = starts.closed.shape
    limits = np.stack([np.full(shape, -np.inf), np.full(shape, np.inf)])
    # How far idle degrees of freedom have moved depends on the whole path, so each member must follow its own.
    limits[:, ~_begin_alike(guide, starts) if loops.determined else slice(None)] = 0.0
    low, high = min(float(np.min(s, initial=0.0)), 0.0), max(float(np.max(s, initial=0.0)), 0.0)
    for k in _turning(guide):
        if low < guide.s[k] < high:
            _limit(limits, float(guide.s[k]), _beside(loops, guide.states[k], parameters, nominal, shape))
    for where in guide.crossings:
        before = float(where - np.sign(where) * BEYOND)
        if low < before < high:
            _limit(limits, before, _crosses(loops, guide, float(where), parameters, shape))
    return limits


def _begin_alike(guide: Guide, starts: Starts) -> Mask:
    """Whether each member starts near the leading one, and about as far from singular poses, (...)."""
    zero = int(np.argmin(np.abs(guide.s)))
    same = starts.closed.copy()
    for own, lead in zip(starts.state, guide.states[zero], strict=True):
        same &= np.abs(own - lead) < FIRST_STEP
    for own, lead in zip(starts.determinants, guide.determinants[zero], strict=True):
        same &= np.asarray(own) / lead > SHARE
    return same


def _limit(limits: Array, s: float, good: Mask) -> None:
    if s > 0.0:
        limits[1] = np.where(good, limits[1], np.minimum(limits[1], s))
    else:
        limits[0] = np.where(good, limits[0], np.maximum(limits[0], s))


def _turning(guide: Guide) -> list[int]:
    """Indices of nodes where a determinant has a local minimum, or the greatest rate a local maximum."""
    found: set[int] = set()
    firm = np.abs(guide.determinants)
    for values in (*firm.T, -np.abs(guide.rates).max(axis=1)):
        least = (values[1:-1] <= values[:-2]) & (values[1:-1] < values[2:])
        found |= set((1 + np.flatnonzero(least)).tolist())
    aside = np.abs(guide.s[:, None] - guide.crossings).min(axis=1, initial=np.inf)
    return [k for k in sorted(found) if aside[k] > BEYOND]


def _beside(loops: Loops, state: Array, parameters: Sequence[Value], nominal: Sequence[float], shape: Shape) -> Mask:
    """Whether each member is near the leading one at one of its poses, (...)."""
    leads = loops.close_all([np.full((1,) * len(shape), x) for x in state], nominal)
    found = loops.close_all([np.full(shape, x) for x in state], parameters)
    good = np.array(np.broadcast_to(found.trusted, shape))
    for determinant, lead in zip(found.determinants, leads.determinants, strict=True):
        good &= np.asarray(determinant) / lead > SHARE
    return good


def _crosses(loops: Loops, guide: Guide, where: float, parameters: Sequence[Value], shape: Shape) -> Mask:
    """Whether each member has a change point at `where`, (...).

    Its smooth branch closes there, and the determinants vanish there that change their sign on the leading path; some
    determinant where none does, as at a double zero.
    """
    spacing = 0.03
    knots = where + spacing * np.array([-4, -3, -2, -1, 1, 2, 3, 4])
    if not guide.reached(knots).all():
        return np.zeros(shape, dtype=bool)
    at = guide.at(knots)
    begin: list[Value] = [np.broadcast_to(x.reshape(-1, *(1,) * len(shape)), (len(knots), *shape)).copy() for x in at.T]
    found = loops.close_all(begin, parameters)
    middle = weights(knots, np.array([where]))[:, 0]
    state = loops.unit([np.tensordot(middle, np.broadcast_to(x, (len(knots), *shape)), 1) for x in found.state])
    gap = open_by(loops, state, parameters)
    good = np.asarray(found.trusted.all(axis=0) & (gap < max(OPEN, loops.tolerance)))
    own = np.stack([np.broadcast_to(x, (len(knots), *shape)) for x in found.determinants])
    there, beside = np.einsum("k,bk...->b...", middle, own), np.abs(own[:, 3:5]).min(axis=1)
    vanish = np.abs(there) * spacing < SAME_PLACE * beside
    after = int(np.searchsorted(guide.s, where))
    change = guide.determinants[after - 1] * guide.determinants[after] < 0.0
    meets = vanish[change].all(axis=0) if change.any() else vanish.any(axis=0)
    return np.asarray(good & meets)
