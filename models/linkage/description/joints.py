"""The catalogue of joints: what each lets go and what it holds.

Most follows from the free components alone: mobility, constraints, springs and reactions. A new kind is an entry here,
a method of `description.joining`, what its coordinates do to its second link in `kinematics.joint_motion`, and one by
one in `robot_files.body_tree`, and in which directions it has clearance in `statics.frame`; if it slides, it is one of
`statics.nodes` too.
"""

from __future__ import annotations

from dataclasses import dataclass

COMPONENTS = ("ux", "uy", "uz", "rx", "ry", "rz")


@dataclass(frozen=True)
class Kind:
    """A kind of joint (kinematic pair), in the joint's axes x y z with z along its axis.

    Attributes
    ----------
    name
        Name of the kind.
    coordinates
        Free components in the order of the joint's coordinates.
    """

    name: str
    coordinates: tuple[str, ...]

    @property
    def freedom(self) -> int:
        """Number of coordinates."""
        return len(self.coordinates)

    @property
    def constrained(self) -> tuple[str, ...]:
        """Components that the joint constrains, of `COMPONENTS`; a screw also ties uz to rz."""
        return tuple(name for name in COMPONENTS if name not in self.coordinates)

    @property
    def rows(self) -> int:
        """Number of scalar constraints: 6 less the freedom."""
        return 6 - self.freedom


KINDS = {
    kind.name: kind
    for kind in (
        Kind("revolute", ("rz",)),
        Kind("prismatic", ("uz",)),
        Kind("cylindrical", ("uz", "rz")),
        Kind("spherical", ("rx", "ry", "rz")),
        Kind("universal", ("rz", "rx")),
        Kind("planar", ("ux", "uy", "rz")),
        Kind("screw", ("rz",)),
        Kind("fixed", ()),
    )
}
