"""The plan of a solution as text, as a database explains a query, and the time that its stages took."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .batched.broadcast import BroadcastSolver
from .batched.chunks import large_masks, steps
from .batched.order import Order
from .batched.plan import Plan
from .clearances.joints import joints_with_clearance
from .description import Description
from .dofs import DISPLACEMENTS
from .listing import Explanation
from .results.linear import LinearResults
from .solvers.stacked import StackedSolver
from .states import ClearanceState
from .structure.parts import Grid

if TYPE_CHECKING:
    from .clearances.clearance import Clearances

# Operations a second of one core on arrays that its cache holds, as order of magnitude for the estimate.
RATE = 1e9
# Nodes of what is skipped that are named.
_NAMED = 4


def explain(solution: LinearResults, clearances: Clearances | None) -> str:
    """What will be built, at which batch shapes, what is skipped and why; and the times of what has been done."""
    plan, solver = solution.plan, solution.solver
    lines = [*_described(plan), *_coordinates(plan)]
    if isinstance(solver, BroadcastSolver):
        lines += [f"Method: {plan.method.reason}.", *_components(plan, solver)]
    elif isinstance(solver, StackedSolver):
        lines += _stacked(solver)
    else:
        lines.append(f"Solved: one large frame, {len(plan.unknowns)} unknowns: {solver.reason}.")
    lines += _mechanism_text(solution) + _clearances(solution.frame, clearances)
    return Explanation("\n".join([*lines, *_left_out(), *_times(plan)]))


def _described(plan: Plan) -> list[str]:
    frame, grid = plan.frame, plan.grid
    again = ["Nothing but loads has changed since the last solution: its plan is used again."] if plan.again else []
    stacks: dict[str, int] = {}
    for group in plan.topology.groups:
        later = ", chunk by chunk" if plan.unloaded.varies(group) else ""
        text = f"stiffness at batch shape {group.stiffness_shape}{later}"
        stacks[text] = stacks.get(text, 0) + len(group.pieces)
    interior = len(plan.topology.number) - len(frame.nodes)
    spared = sum(member.element.segments for member in frame.members.values()) - len(plan.topology.pieces)
    return [
        *again,
        f"Frame: {len(frame.nodes)} nodes, {len(frame.members)} members, {len(frame.joints)} joints, "
        f"{len(frame.ties)} rigid links and ties; batch shape {grid.shape}, {grid.sizes[-1]} entries.",
        f"Members are cut into {len(plan.topology.pieces)} pieces ({interior} interior nodes), "
        f"evaluated as {len(plan.topology.groups)} stacks"
        + (f"; {spared} more segments are skipped: in statics one piece of a member is exact:" if spared else ":"),
        *(f"  {count} pieces, {text}" for text, count in stacks.items()),
    ]


def _coordinates(plan: Plan) -> list[str]:
    tree = plan.tree
    ideal = sum(len(branch.edge.ideal) for branch in tree.branches)
    dependent, redundant = tree.elimination.count, len(tree.elimination.self_stresses)
    share = (
        f"Redundant: {redundant} ideal components of loops, whose share of the load statics leaves open: of all forces "
        "in equilibrium those are reported of which the sum of squares is least, in joints and supports."
    )
    return [
        f"Joint-relative coordinates: {6 * len(plan.topology.number)} nodal displacements become {len(plan.unknowns)} "
        f"unknowns; {ideal} constrained components are absent"
        + (f", {dependent} more are eliminated because their joints close a loop." if dependent else "."),
        f"{len(tree.springs) - len(tree.elimination.idle)} springs stand on the diagonal or close a loop.",
        *([share] if redundant else []),
    ]


def _components(plan: Plan, solver: BroadcastSolver) -> list[str]:
    lines, condensed = [], plan.condensed
    if condensed.chains:
        lines.append(
            f"{len(condensed.nodes)} nodes that only members in line are on are condensed before all others, once for "
            f"the whole batch: {len(condensed.chains)} chains, {condensed.operations} operations at most."
        )
    asked = {name for name in plan.excited if solver.solved(name)} or plan.excited
    for name in sorted(asked):
        unknowns, origin = plan.members_of(name), solver.origin(name)
        orders = plan.block(name).orders
        again = f", with {origin} of the last solution" if origin else ""
        lines.append(f"Solved: {len(unknowns)} unknowns ({_kinds(unknowns)}) by broadcasting LDL^T{again}.")
        for title, order in zip(("in the links, condensed", "at the joints"), orders, strict=True):
            lines += _steps(title, order, plan.grid)
        lines.append(_estimate(plan.grid, orders))
        ran = solver.ran(name)
        lines += [f"  The last reading took {ran}."] if ran else []
        negligible = solver.negligible(name)
        if negligible:
            lines.append(f"  {negligible} couplings turned out to be less than rounding and were skipped.")
    lines += _skipped(plan, plan.excited - asked, "nothing that was read depends on them")
    return lines + _skipped(plan, plan.components - plan.excited, "no load, offset or support motion reaches them")


def _stacked(solver: StackedSolver) -> list[str]:
    """Lines on banded factors of medium-sized frames."""
    skipped = set(solver.unknown[~solver.loaded].tolist())
    units = " units of the right-hand-side parameters" if solver.by_units else ""
    lines = [
        f"Method: {solver.reason}.",
        f"Solved: {int(solver.loaded.sum())} unknowns in {solver.count} matrices of one pattern, each for "
        f"{solver.columns}{units or ' load cases'}.",
    ]
    if skipped:
        why = "no load, offset or support motion reaches them"
        lines.append(f"Skipped: {len(skipped)} unknowns ({_kinds(skipped)}): {why}.")
    return lines


def _skipped(plan: Plan, names: set[int], why: str) -> list[str]:
    """Components left out; those of the same displacements, or at the same nodes, in one line."""
    kinds: dict[str, list[int]] = {}
    for k in sorted(plan.unknowns):
        if plan.component[k] in names:
            kinds.setdefault(_kinds(plan.members_of(plan.component[k])), []).append(k)
    places: dict[str, list[int]] = {}
    for unknowns in kinds.values():
        places.setdefault(_nodes(plan, unknowns), []).extend(unknowns)
    return [
        f"Skipped: {len(unknowns)} unknowns ({_kinds(set(unknowns))}) at {where}: {why}."
        for where, unknowns in places.items()
    ]


def _nodes(plan: Plan, unknowns: list[int]) -> str:
    names = [plan.topology.names[number] for number in sorted({k // 6 for k in unknowns})]
    more = len(names) - _NAMED
    return ", ".join(names[:_NAMED]) + (f" and {more} more nodes" if more > 0 else "")


def _steps(title: str, order: Order, grid: Grid) -> list[str]:
    shapes: dict[int, int] = {}
    for k in order.pivots:
        shapes[order.masks[k]] = shapes.get(order.masks[k], 0) + 1
    text = ", ".join(f"{count} at {_shape(grid, mask)}" for mask, count in sorted(shapes.items()))
    if not text:
        return []
    return [
        f"  {len(order.pivots)} unknowns {title}: pivots {text}; {order.operations(grid)} operations, "
        f"{order.operations(grid, shared=False)} if each were done for every entry."
    ]


def _estimate(grid: Grid, orders: tuple[Order, Order]) -> str:
    seconds = sum(order.operations(grid) for order in orders) / RATE
    axis, step = steps(grid, orders)
    chunks = -(-grid.shape[axis] // step) if any(large_masks(grid)) else 1
    where = f"in {chunks} chunks along axis {axis}" if chunks > 1 else "in one go"
    return f"  About {1e3 * seconds:.2g} ms of arithmetic, {where}."


def _mechanism_text(solution: LinearResults) -> list[str]:
    """Once it is known."""
    mechanisms = solution.known_consistent_mechanisms
    if mechanisms is None:
        return []
    return [
        f"Statically consistent mechanisms: {int(mechanisms.mask.sum())} entries, on whose free motions the load does "
        "no "
        f"work. They are solved anew, an unknown constrained for each of {len(mechanisms.motions([]))} free motions "
        "at most, "
        "which takes no force; what these move is NaN."
    ]


def _clearances(frame: Description, found: Clearances | None) -> list[str]:
    if found is None:
        names = joints_with_clearance(frame)
        return [f"Clearances of {len(names)} joints are left out: {', '.join(names)}."] if names else []
    lines = [f"Clearances: {_contact(found)}"]
    for name, state in zip(found.names, found.state, strict=True):
        kinds, counts = np.unique(state, return_counts=True)
        text = ", ".join(f"{ClearanceState(kind).text} at {count}" for kind, count in zip(kinds, counts, strict=True))
        lines.append(f"  joint {name}: {text} of {state.size} entries.")
    return lines


def _contact(found: Clearances) -> str:
    """Lines on how contact was found."""
    if found.determinate is not None and found.determinate.pressed:
        return (
            "above is the frame without them. No offset in a joint meets any stiffness, so that contact is along the "
            "joint forces, which are the work of the loads on the motions by unit offsets; displacements are those "
            "without clearances and a sum of these motions."
        )
    parts = f", for {found.parts} parts of the batch one after the other," if found.parts > 1 else ""
    return (
        f"above is the frame with each joint's offset in contact, found before{parts} from the joint forces without "
        "clearances"
        + (
            f" and their answer to a unit offset in each joint, at the minimum of energy: {found.tally}"
            if found.tally.how
            else "; no offset meets any stiffness, so that contact is along these forces."
        )
    )


def _left_out() -> list[str]:
    return [
        "Reactions, end forces, stresses and condition numbers are computed when they are read; "
        "mass and geometric stiffness only for modes and buckling."
    ]


def _times(plan: Plan) -> list[str]:
    if not plan.times:
        return ["Nothing has been computed yet."]
    return ["Times so far: " + ", ".join(f"{stage} {1e3 * t:.3g} ms" for stage, t in plan.times.items()) + "."]


def _shape(grid: Grid, mask: int) -> str:
    return str(tuple(n if mask >> axis & 1 else 1 for axis, n in enumerate(grid.shape)))


def _kinds(unknowns: set[int]) -> str:
    present = {k % 6 for k in unknowns}
    return " ".join(name for k, name in enumerate(DISPLACEMENTS) if k in present)
