"""The assembled equations of one connected component of a batch."""

from __future__ import annotations

from dataclasses import dataclass

from ..structure.parts import Grid, Matrix, Parts, Row, Value
from ..structure.varying import Varying
from .order import Masks, Order, Springs
from .stage import Forces


@dataclass(frozen=True)
class Block:
    """The assembled equations of one connected component; see the terms in `linkframe.framework.batched`.

    Attributes
    ----------
    grid
        Shape of the batch, and its size for each mask.
    orders
        Elimination orders of the interior unknowns and of the joint-relative ones.
    masks
        Batch axes over which `rows` and `springs` vary.
    matrix, scale, forces
        Stiffness of the members, scale of its diagonal, and loads, in the nodes' axes.
    rows
        By number of the displacement of a node on joints: its row over joint-relative unknowns and right-hand-side
        parameters.
    springs
        Row and stiffness of each joint spring.
    rhs_parameters
        Values of the right-hand-side parameters.
    varying
        Stiffness that varies so much that each chunk assembles it; None where there is none.
    """

    grid: Grid
    orders: tuple[Order, Order]
    masks: Masks
    matrix: Matrix
    scale: dict[int, Parts]
    forces: Forces
    rows: dict[int, Row]
    springs: Springs
    rhs_parameters: list[Value]
    varying: Varying | None = None
