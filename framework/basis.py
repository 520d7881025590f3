"""Members of a frame as a basis of scikit-fem's, over their own shape functions."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from skfem import Basis

from .batch import Array
from .description import Description
from .errors import FrameError
from .protocol import LineElement
from .scikit_fem.arc_length import ArcLengthMapping
from .scikit_fem.line_frame import ElementLineFrame
from .structure.topology import Topology


def frame_basis(frame: Description, on: str | Sequence[str], intorder: int) -> Any:
    """Basis over members at the first batch entry; see `Frame.basis`."""
    topology = Topology.of(frame.copy(), cut=True)
    members = frame.members_on(on, "basis")
    numbers = np.concatenate([np.array(topology.pieces_of[name]) for name in members])
    pieces = [topology.pieces[number] for number in numbers.tolist()]
    elements: dict[object, tuple[str, LineElement]] = {}
    for piece in pieces:
        elements.setdefault(piece.element.kind, (piece.member, piece.element))
    if len(elements) > 1:
        text = ", ".join(dict.fromkeys(name for name, _ in elements.values()))
        raise FrameError(
            f"basis: members on {on!r} are of {len(elements)} kinds, first in {text}: ask for a basis of each kind "
            "(each segment of a taper is of its own: give it one segment)"
        )
    ((_, element),) = elements.values()
    mesh = topology.mesh
    return Basis(
        mesh, ElementLineFrame(_at_first(element)), ArcLengthMapping(mesh), elements=numbers, intorder=intorder
    )


def _at_first(element: LineElement) -> LineElement:
    """The element at its first batch entry."""

    def first(array: Array, trailing: int) -> Array:
        taken: Array = array.reshape(-1, *array.shape[array.ndim - trailing :])[0]
        return taken

    return element.cut(first) if element.shape else element
