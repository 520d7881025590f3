"""Parts whose numbers are known to be right, as those of a linkage at closed poses: added without being checked.

What a user gives goes through the verbs of the description, `body`, `node` and `add`, which check its numbers. Here
only names must be new, and shapes must broadcast. Arrays are not copied; they are read-only from then on.
"""

from __future__ import annotations

from ..batch import Array
from ..joint_protocol import JointElement
from ..names import new
from .members import DescribedMembers
from .parts import Body, JointLink


def add_body(frame: DescribedMembers, name: str, origin: Array, axes: Array) -> None:
    """Add a body whose axes (..., 3, 3) are known to be orthonormal and right-handed, its origin (..., 3) finite."""
    if origin.ndim > 1 or axes.ndim > 2:
        frame._join({f"origin of body {name!r}": origin.shape[:-1], f"axes of body {name!r}": axes.shape[:-2]})
    for array in (origin, axes):
        array.setflags(write=False)
    frame.bodies[new("body", name, frame.bodies)] = Body(origin, axes)


def add_node(frame: DescribedMembers, name: str, place: Array, body: str | None = None) -> None:
    """Add a node at a finite place (..., 3) on a body of the frame, or in global axes."""
    place.setflags(write=False)
    frame._put(new("node", name, frame.nodes, frame.aliases), place, None if body is None else str(body))


def add_joint(frame: DescribedMembers, name: str, element: JointElement, first: str, second: str) -> None:
    """Add a joint between nodes that are known to coincide; its element is proven and ideal at all entries or none."""
    name = new("element", name, frame.members, frame.joints, frame.masses)
    if shape := element.shape:
        frame._join({f"joint {name!r}": shape})
    frame.joints[name] = JointLink(element, str(first), str(second))
