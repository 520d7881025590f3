"""The parts of a frame: bodies, nodes, members, joints, masses and ties."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..batch import Array
from ..dofs import DISPLACEMENTS
from ..errors import FrameError
from ..joint_protocol import JointElement
from ..lazily import cached_property
from ..protocol import LineElement, PointElement


@dataclass(frozen=True)
class Body:
    """A moving frame of reference: global position = origin + axes @ local position.

    Attributes
    ----------
    origin
        Global position of its origin, (..., 3).
    axes
        Its axes as columns in global components, (..., 3, 3).
    """

    origin: Array
    axes: Array

    @cached_property
    def far(self) -> float:
        """Largest absolute coordinate of its origin over the batch."""
        if self.origin.ndim == 1:
            return float(max(map(abs, self.origin.tolist())))
        return float(np.abs(self.origin).max(initial=0.0))


class Node(NamedTuple):
    """A point with six degrees of freedom; coordinates (..., 3) in the axes of `body`, global where it is None."""

    coordinates: Array
    body: str | None


class Member(NamedTuple):
    """A line element between two nodes."""

    element: LineElement
    start: str
    end: str


class JointLink(NamedTuple):
    """A joint element between two coincident nodes."""

    element: JointElement
    first: str
    second: str


class IdleRotation(NamedTuple):
    """Rotation of a body about a joint's z axis, which the joint constrains as long as nothing else resists it and no
    load does work on it.

    Attributes
    ----------
    body
        Name of the body.
    joints
        Names of the joints that connect it.
    constrained, free
        The joint's element with that rotation constrained and free; None for no joint at all.
    """

    body: str
    joints: tuple[str, ...]
    constrained: JointElement
    free: JointElement | None

    @property
    def axis(self) -> Array:
        """Direction of the joint's z, global, (..., 3)."""
        assert self.constrained.axes is not None
        return self.constrained.axes[..., 2]


class MassPoint(NamedTuple):
    """Inertia at a node."""

    element: PointElement
    node: str


@dataclass(frozen=True)
class Tie:
    """Components, 0 to 5, of the displacement of `slave` that equal those of `master`.

    Where `rigid`, they are all six, and both nodes move as one body.
    """

    master: str
    slave: str
    components: tuple[int, ...]
    rigid: bool


def check_ideal(what: str, stiffness: Array) -> None:
    """Refuse joint stiffnesses (..., 6) that are ideal (inf) at some batch entries only.

    Raises
    ------
    FrameError
        Naming the component, an entry at which it is ideal, and one at which it is not.
    """
    if stiffness.ndim == 1 or np.maximum.reduce(stiffness, axis=None, initial=0.0) < np.inf:
        return
    infinite = np.isinf(stiffness)
    mixed = infinite.reshape(-1, 6).any(axis=0) & ~infinite.reshape(-1, 6).all(axis=0)
    for k in np.flatnonzero(mixed)[:1].tolist():
        ideal, other = (np.argwhere(infinite[..., k] == which)[0].tolist() for which in (True, False))
        raise FrameError(
            f"{what} is ideal (inf) at some batch entries only, {DISPLACEMENTS[k]} at {ideal} and not at {other}: "
            "describe those entries apart, or give them a finite stiffness"
        )
