"""The catalogue of joints: free and constrained components of each kind.

Mobility, motion, constraints, springs, reactions, nodes and files follow from an entry. A new kind is an entry here and
a method of `description.simple_joints` or `linkage_description`; its symbol in drawings is in
`framework.graphics.symbols`, and `worst_case.limits` lists the kinds with end play or a bearing length.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

COMPONENTS = ("ux", "uy", "uz", "rx", "ry", "rz")


@dataclass(frozen=True)
class Kind:
    """A kind of joint (kinematic pair), in the joint's axes x y z with z along its axis.

    A joint with one axis of rotation rotates about z.

    Attributes
    ----------
    name
        Name of the kind.
    coordinates
        Free components in the order of the joint's coordinates, displacements before rotations.
    clearance
        Components in which it can have clearance.
    tied
        Component that moves in proportion to the first coordinate, by the pitch of a thread; empty if there is none.
    moving
        All components that move, the tied one last.
    slides
        Whether the second link's point moves away from the joint's point on the first link.
    freedom
        Number of coordinates.
    constrained
        Components that it constrains, of `COMPONENTS`; a screw also ties uz to rz.
    """

    name: str
    coordinates: tuple[str, ...]
    clearance: tuple[str, ...]
    tied: str = ""
    moving: tuple[str, ...] = field(init=False)
    slides: bool = field(init=False)
    freedom: int = field(init=False)
    constrained: tuple[str, ...] = field(init=False)

    def __post_init__(self) -> None:
        moving = (*self.coordinates, self.tied) if self.tied else self.coordinates
        object.__setattr__(self, "moving", moving)
        object.__setattr__(self, "slides", any(name[0] == "u" for name in moving))
        object.__setattr__(self, "freedom", len(self.coordinates))
        constrained = tuple(name for name in COMPONENTS if name not in self.coordinates)
        object.__setattr__(self, "constrained", constrained)

    def places_of(self, coordinates: Sequence[str]) -> list[int]:
        """Indices of some of its coordinates among all of them."""
        return [self.coordinates.index(name) for name in coordinates]

    @property
    def rows(self) -> int:
        """Number of scalar constraints: 6 less the freedom."""
        return 6 - self.freedom


KINDS = {
    kind.name: kind
    for kind in (
        Kind("revolute", ("rz",), ("ux", "uy")),
        Kind("prismatic", ("uz",), ("ux", "uy")),
        Kind("cylindrical", ("uz", "rz"), ("ux", "uy")),
        Kind("spherical", ("rx", "ry", "rz"), ("ux", "uy", "uz")),
        Kind("universal", ("rz", "rx"), ("ux", "uy", "uz")),
        Kind("planar", ("ux", "uy", "rz"), ("uz",)),
        Kind("screw", ("rz",), ("ux", "uy"), tied="uz"),
        Kind("fixed", (), ("ux", "uy", "uz")),
    )
}


def driven_name(joint: str, coordinate: str, driven: Sequence[str]) -> str:
    """Name of a driven coordinate in tables, figures and pages: ``joint``, or ``joint.coordinate`` of several."""
    return joint if len(driven) == 1 else f"{joint}.{coordinate}"
