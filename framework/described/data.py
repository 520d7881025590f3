"""The data of a description: parts, supports and loads by name, and the batch shape of all that was given."""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from dataclasses import dataclass, field
from typing import Self

import numpy as np
from numpy.typing import NDArray

from ..batch import Array, Shape, joined
from ..errors import FrameError
from ..loads import MemberLoad
from ..names import found
from ..provenance import GivenStatus, HasStatus
from .parts import Body, JointLink, MassPoint, Member, Node, Tie

# Dimensions of results beside the batch axes.
TAKEN = ("node", "component", "support", "force", "joint", "status")

# What is kept by name and may grow under that name.
_GROWING = ("supports", "offsets", "loads", "member_loads")


@dataclass(eq=False, repr=False)
class DescriptionData:
    """Parts, supports and loads by name; every call that adds one widens the batch shape by that of its numbers.

    `linkframe.framework.Frame` tells of the attributes.
    """

    bodies: dict[str, Body] = field(default_factory=dict)
    nodes: dict[str, Node] = field(default_factory=dict)
    members: dict[str, Member] = field(default_factory=dict)
    joints: dict[str, JointLink] = field(default_factory=dict)
    masses: dict[str, MassPoint] = field(default_factory=dict)
    aliases: dict[str, str] = field(default_factory=dict)
    node_sets: dict[str, list[str]] = field(default_factory=dict)
    element_sets: dict[str, list[str]] = field(default_factory=dict)
    ties: list[Tie] = field(default_factory=list)
    supports: dict[str, dict[int, Array]] = field(default_factory=dict)
    offsets: dict[str, dict[int, Array]] = field(default_factory=dict)
    loads: dict[str, list[tuple[int, Array]]] = field(default_factory=dict)
    member_loads: dict[str, list[MemberLoad]] = field(default_factory=dict)
    weight: Array | None = None
    absent: NDArray[np.bool_] | None = None
    made_from: HasStatus | None = field(default=None, repr=False, compare=False)
    _shapes: dict[Shape, str] = field(default_factory=dict, repr=False)  # and what was given in it first
    _shape: Shape = ()
    _examined: dict[Hashable, str] = field(default_factory=dict, repr=False, compare=False)
    size: float = 0.0
    tolerance: float = 0.0
    axes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if self.axes:
            self._check_axes()

    def _check_axes(self) -> None:
        given = self.axes
        if not isinstance(given, tuple) or not all(isinstance(name, str) and name for name in given):
            raise FrameError(f'axes is {given!r}: give names of the batch axes, such as ("pose", "sample")')
        for name in given:
            if name in TAKEN or given.count(name) > 1:
                why = "is that of another dimension of results" if name in TAKEN else "stands twice"
                raise FrameError(f"axes is {given!r}, in which {name!r} {why}: give each batch axis a name of its own")

    @property
    def shape(self) -> Shape:
        """Batch shape: the broadcast of all that has been described."""
        return self._shape

    def copy(self) -> Self:
        """Independent copy.

        Returns
        -------
        same type
            The description as it is now; what is added to either later is not in the other. Arrays are shared.
        """
        clone = object.__new__(type(self))
        parts = clone.__dict__
        parts.update(vars(self))
        for name, value in vars(self).items():
            if isinstance(value, (dict, list)):
                parts[name] = value.copy()
        for name in _GROWING:
            if parts[name]:
                parts[name] = {key: each.copy() for key, each in parts[name].items()}
        return clone

    __copy__ = copy

    def __getstate__(self) -> dict[str, object]:
        """What another process needs."""
        made_from = None if self.made_from is None else GivenStatus(self.made_from.status, self.made_from.is_regular)
        return vars(self) | {"_examined": {}, "made_from": made_from}

    # -- names and shapes -------------------------------------------------------------------------------------------

    def _node(self, name: str, of: str = "") -> str:
        if type(name) is str and name in self.nodes:  # as most often; no alias is the name of a node
            return name
        return found(f"{of} node".strip(), name, self.nodes, self.aliases)

    def _member(self, name: str, of: str = "") -> str:
        return found(f"{of} member".strip(), name, self.members)

    def _join(self, given: Mapping[str, Shape]) -> None:
        """Widen the batch by the shapes of what one call gives: by all of them, or by none where one does not fit."""
        self._shape, self._shapes = self._widened(given)

    def _widened(self, given: Mapping[str, Shape]) -> tuple[Shape, dict[Shape, str]]:
        """The batch, and what was given in each shape, with the shapes of what one call gives."""
        whole, known = self._shape, self._shapes
        if not any(given.values()):
            return whole, known
        for name, shape in given.items():
            if shape and shape not in known:
                if self.axes and len(shape) > len(self.axes):
                    raise FrameError(
                        f"{name} has the shape {shape}, and {len(self.axes)} batch axes have names: {self.axes}"
                    )
                for other, what in known.items():
                    joined(name, shape, {what: other})
                whole, known = np.broadcast_shapes(whole, shape), {**known, shape: name}
        return whole, known
