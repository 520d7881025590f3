"""The plan of a solution in plain words, as a database explains a query."""

from __future__ import annotations

from .block import CHUNK, steps
from .dofs import DISPLACEMENTS
from .order import Order
from .parts import Grid
from .plan import Plan


def explain(plan: Plan) -> str:
    """What will be built, at which batch shapes, and what is skipped and why."""
    return "\n".join([*_described(plan), *_coordinates(plan), *_components(plan), *_left_out()])


def _described(plan: Plan) -> list[str]:
    frame, grid = plan.frame, plan.grid
    interior = len(plan.topology.number) - len(frame.nodes)
    return [
        f"Frame: {len(frame.nodes)} nodes, {len(frame.members)} members, {len(frame.joints)} joints, "
        f"{len(frame.ties)} rigid links and ties; batch shape {grid.shape}, {grid.sizes[-1]} entries.",
        f"Members are cut into {len(plan.topology.pieces)} pieces ({interior} interior nodes), "
        f"evaluated as {len(plan.topology.groups)} stacks:",
        *(f"  {len(g.pieces)} pieces at batch shape {g.stiffness().shape[1:-2]}" for g in plan.topology.groups),
    ]


def _coordinates(plan: Plan) -> list[str]:
    tree = plan.tree
    ideal = sum(len(branch.edge.ideal) for branch in tree.branches)
    dependent = len(tree.elimination.rows)
    lines = [
        f"Joint-relative coordinates: {6 * len(plan.topology.number)} nodal displacements become {len(plan.unknowns)} "
        f"unknowns; {ideal} held components are absent"
        + (f", {dependent} more are eliminated because their joints close a loop." if dependent else "."),
        f"{len(tree.springs)} springs stand on the diagonal or close a loop.",
    ]
    return lines


def _components(plan: Plan) -> list[str]:
    lines = []
    for name in sorted(plan.components):
        unknowns = [k for k, component in plan.component.items() if component == name]
        if name not in plan.excited:
            why = "no load, offset or support motion reaches them"
            lines.append(f"Skipped: {len(unknowns)} unknowns ({_kinds(unknowns)}); {why}.")
            continue
        block = plan.block(name)
        lines.append(f"Solved: {len(unknowns)} unknowns ({_kinds(unknowns)}) by broadcasting LDL^T.")
        for title, order in zip(("in the links, condensed", "at the joints"), block.orders, strict=True):
            lines += _steps(title, order, plan.grid)
        chunks = _chunks(plan.grid)
        lines.append(f"  in {chunks} chunks along the longest axis." if chunks > 1 else "  in one go.")
    return lines


def _steps(title: str, order: Order, grid: Grid) -> list[str]:
    shapes: dict[int, int] = {}
    for k in order.pivots:
        shapes[order.masks[k]] = shapes.get(order.masks[k], 0) + 1
    told = ", ".join(f"{count} at {_shape(grid, mask)}" for mask, count in sorted(shapes.items()))
    if not told:
        return []
    spent, full = order.operations(grid), order.operations(grid, shared=False)
    return [
        f"  {len(order.pivots)} unknowns {title}: pivots {told}; {spent:.3g} operations, "
        f"{full:.3g} if each were done for every entry."
    ]


def _chunks(grid: Grid) -> int:
    axis, step = steps(grid, CHUNK)
    return -(-grid.shape[axis] // step) if grid.shape else 1


def _left_out() -> list[str]:
    return [
        "Reactions, end forces, stresses and condition numbers are computed when they are read; "
        "mass and geometric stiffness only for modes and buckling."
    ]


def _shape(grid: Grid, mask: int) -> str:
    return str(tuple(n if mask >> axis & 1 else 1 for axis, n in enumerate(grid.shape)))


def _kinds(unknowns: list[int]) -> str:
    present = {k % 6 for k in unknowns}
    return " ".join(name for k, name in enumerate(DISPLACEMENTS) if k in present)
