"""Forces in joints for unit offsets in each: what the clearances of a frame are coupled by."""

from __future__ import annotations

import warnings

import numpy as np

from .batch import Array
from .dofs import DISPLACEMENTS
from .errors import MechanismWarning
from .frame import Frame
from .parts import total
from .plan import Plan
from .protocol import JointElement
from .resting import Play

# A stiffness against offsets below this share of the members' is the rounding of none.
_LOOSE = 1e-13


def against_offsets(frame: Frame, play: Play) -> tuple[Array, Array]:
    """How the frame resists offsets in its joints.

    Whether a force comes of an offset at all depends on the geometry, not on how stiff the springs are. So it is asked
    of a frame with one stiffness of joints for all samples first; where none does, nothing else is needed.

    Parameters
    ----------
    frame
        The frame.
    play
        Components of its joints.

    Returns
    -------
    stiffness, members
        Fall of the force in each component for a unit offset in each, (n, n, ...), zero where it is no more than the
        rounding of the members' stiffness; and that, (n, ...). All batch axes of the frame are there, of size one
        where nothing varies.
    """
    joints = {name: joint.element for name, joint in frame.joints.items()}
    if all(_alike(element) for element in joints.values()):
        typical = {name: element.typical() for name, element in joints.items()}
        stiffness, members = _answer(_bare(frame, typical), play, len(frame.shape))
        if not stiffness.any() or all(element.shape == typical[name].shape for name, element in joints.items()):
            return stiffness, members
    return _answer(_bare(frame, joints), play, len(frame.shape))


def _alike(element: JointElement) -> bool:
    """Whether each component is free at all batch entries or at none."""
    free = (element.stiffness == 0.0).reshape(-1, 6)
    return bool(np.all(free.all(axis=0) == free.any(axis=0)))


def _answer(bare: Frame, play: Play, ndim: int) -> tuple[Array, Array]:
    from .solution import Solution

    count = len(play.pairs)
    unit = np.eye(count).reshape(count, count, *(1,) * len(bare.shape))
    for index, (name, k) in enumerate(play.pairs):
        bare.offset(name, **{DISPLACEMENTS[k]: unit[index]})
    solution = Solution.of(bare)
    with warnings.catch_warnings():
        # An entry that is a mechanism has no forces; that of the frame under its loads tells.
        warnings.simplefilter("ignore", MechanismWarning)
        found = -np.stack([solution.joint_force(name)[..., k] for name, k in play.pairs])
    found = np.nan_to_num(0.5 * (found + np.swapaxes(found, 0, 1)))
    members = _members(solution.plan, play)
    root = np.sqrt(members)
    stiffness = np.where(np.abs(found) > _LOOSE * root[:, None] * root, found, 0.0)
    new = (1,) * (ndim + 2 - stiffness.ndim)
    return (
        stiffness.reshape(count, count, *new, *stiffness.shape[2:]),
        members.reshape(count, *new, *members.shape[1:]),
    )


def _bare(frame: Frame, joints: dict[str, JointElement]) -> Frame:
    """The frame with these joints, without loads, offsets and displacements of supports."""
    out = Frame()
    for name, body in frame.bodies.items():
        out.body(name, body.origin, body.axes)
    for name, node in frame.nodes.items():
        out.node(name, node.coordinates, node.body)
    for name, member in frame.members.items():
        out.add(name, member.element, member.start, member.end)
    for name, joint in frame.joints.items():
        out.add(name, joints[name], joint.first, joint.second)
    out.ties = list(frame.ties)
    for name, held in frame.supports.items():
        out.fix(name, *(DISPLACEMENTS[k] for k in held))
    return out


def _members(plan: Plan, play: Play) -> Array:
    """Largest stiffness of a member's end, against translation or rotation, by component, (n, ...)."""
    largest = [np.zeros((1,) * len(plan.grid.shape)), np.zeros((1,) * len(plan.grid.shape))]
    for a, row in plan.matrix.items():
        value = np.asarray(total(row.get(a, {}))[1], dtype=np.float64)
        largest[a % 6 // 3] = np.maximum(largest[a % 6 // 3], value)
    return np.stack([largest[k // 3][0] for k in play.component])
