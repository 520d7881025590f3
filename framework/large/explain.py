"""What a solution at large displacement will do, in plain words."""

from __future__ import annotations

import numpy as np

from ..clearances.clearance import joints_with_clearance
from ..listing import Explanation
from .elimination import LARGE
from .newton_program import choice
from .planar_model import PlanarModel
from .results import LargeResults

_PLANES = {5: "xy", 4: "xz", 3: "yz"}


def explain(solution: LargeResults, steps: int) -> str:
    """What is built and solved; nothing is computed for it."""
    model, frame = solution.model, solution.frame
    count = int(np.prod(frame.shape, dtype=np.int64))
    absent = 0 if frame.absent is None else int(np.broadcast_to(frame.absent, frame.shape).sum())
    inside = f"is kept to the {_PLANES[model.components[-1]]} plane" if len(model.components) == 3 else "moves in space"
    factors = "one factorisation for all" if model.free <= LARGE else "sparse factors of one entry after another"
    names = joints_with_clearance(frame) if model.clearance else []
    lines = [
        f"Large displacement: batch shape {frame.shape}, {count} entries"
        + (f", of which {absent} are left out." if absent else "."),
        f"Members are cut into {len(model.topology.pieces)} corotational pieces; the frame {inside}.",
        f"Coordinates: {model.free} unknown, {len(model.prescribed)} given; {len(model.joints)} joints, links and "
        f"supports carry nodes along, {len(model.loops)} close loops.",
        _clearances(solution, names),
        f"Load steps: {steps}. In each, Newton's method ({factors}) for the entries that it has not yet solved; "
        "where it fails, smaller steps, the way out of a saddle along its mode, and the descent of the energy.",
        f"Newton's method is done {choice(PlanarModel(model) if PlanarModel.suits(model) else model).reason}.",
    ]
    return Explanation("\n".join(lines))


def _clearances(solution: LargeResults, names: list[str]) -> str:
    if not names:
        return "No joint moves in a clearance."
    edges = solution.model.edges
    rigid = [str(edges[number].edge.name) for number in solution.model.contacts]
    exact = f"; rigid contact in {', '.join(rigid)}: its force is found, with no stiffness" if rigid else ""
    return f"Clearances: {', '.join(names)}, by the law of each joint{exact}."
