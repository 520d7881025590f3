"""Which way a frame is solved, and why."""

from __future__ import annotations

from dataclasses import dataclass
from importlib.util import find_spec
from typing import TYPE_CHECKING

import numpy as np

from .errors import FrameError

if TYPE_CHECKING:
    from .plan import Plan

BROADCAST, SPARSE, CHOLESKY, ITERATIVE = METHODS = ("broadcast", "sparse", "cholesky", "iterative")

# Unknowns above which a frame that does not vary goes a sparse way.
LARGE = 100
# What was seen on one machine: operations a second of a factorisation; seconds that an iteration takes for an entry of
# the matrix; and iterations that a lattice needs. Only their ratios matter.
_RATE = {SPARSE: 5e9, CHOLESKY: 3e10}
_ITERATION = 0.5e-9
_ITERATIONS = 500


@dataclass(frozen=True)
class Method:
    """How a frame is solved.

    Attributes
    ----------
    name
        ``broadcast``, ``sparse``, ``cholesky`` or ``iterative``.
    reason
        Why so, in words.
    """

    name: str
    reason: str


def available() -> bool:
    """Whether cvxopt, and with it CHOLMOD, is installed."""
    return find_spec("cvxopt") is not None


def checked(name: str | None) -> str | None:
    """A method that is known and installed.

    Raises
    ------
    FrameError
        Where it is not.
    """
    if name is not None and name not in METHODS:
        raise FrameError(f"method {name!r} is unknown: use one of {', '.join(METHODS)}, or None to let the plan choose")
    if name == CHOLESKY and not available():
        raise FrameError("method 'cholesky' needs cvxopt: install linkframe[fast], or use 'sparse' or 'iterative'")
    return name


def choose(plan: Plan, asked: str | None) -> Method:
    """The way for a plan: the one asked for, or the one that promises to be fastest.

    Raises
    ------
    FrameError
        Where a sparse way is asked for and the stiffness varies over the batch.
    """
    if asked is not None:
        if asked != BROADCAST and not plan.constant:
            raise FrameError(
                f"method {asked!r} solves one matrix, but the stiffness varies over the batch {plan.frame.shape}: "
                "use 'broadcast', or give the entries frames of their own"
            )
        return Method(asked, f"{asked}, as asked for")
    if not plan.constant:
        return Method(BROADCAST, "broadcasting LDL^T, as the stiffness varies over the batch")
    if not plan.large:
        return Method(BROADCAST, f"broadcasting LDL^T, as {len(plan.unknowns)} unknowns are no more than {LARGE}")
    return _fastest(plan)


def _fastest(plan: Plan) -> Method:
    direct = CHOLESKY if available() else SPARSE
    factor = plan.graph.dissection
    cases = int(np.prod(plan.frame.shape, dtype=np.int64))
    # The test for mechanisms costs about half a load case.
    descent = (cases + 0.5) * _ITERATIONS * _ITERATION * plan.graph.entries
    told = f"a factor of about {factor.entries:.2g} entries takes {factor.operations:.2g} operations"
    if factor.operations / _RATE[direct] > descent:
        return Method(ITERATIVE, f"preconditioned conjugate gradients, as {told} and {cases} load cases iterate sooner")
    name = {CHOLESKY: "CHOLMOD in nested dissection order", SPARSE: "SuperLU in minimum degree order"}[direct]
    return Method(direct, f"{name}, as {told}")
