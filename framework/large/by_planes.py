"""Batches whose entries keep to different planes: each plane is solved for itself, and the results are joined."""

from __future__ import annotations

from dataclasses import fields
from functools import cached_property, wraps
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..batch import Array
from ..batched.idle import released_at_rest
from ..checked import whole_number
from ..clearances.contact import Contact
from ..clearances.joints import joints_with_clearance
from ..description import Description, excluding
from ..errors import FrameError
from ..listing import Explanation
from .accuracy import in_space
from .equations import EquilibriumEquations
from .solution import LargeSolution
from .state import DisplacedState, Mask


def solved(frame: Description, method: str | None, clearance: bool, steps: int) -> LargeSolution:
    """Solution of a frame; later changes of the frame do not reach it."""
    if method is not None:
        raise FrameError(f"method {method!r} is for linear solutions: leave it out where large=True")
    whole_number(steps, "steps", 1)
    by_own_law = [name for name in joints_with_clearance(frame) if frame.joints[name].element.has_law]
    if by_own_law and not clearance:
        raise FrameError(
            f"joint {by_own_law[0]!r} has a law of its own, which contains its clearance: leave out clearance=False, "
            "or give it a clearance of 0"
        )
    whole = LargeSolution(released_at_rest(frame, "large displacement").copy(), int(steps), clearance)
    parts = whole.model.planes.split()
    if len(parts) < 2:
        return whole
    masks = [np.broadcast_to(part, frame.shape) for part in parts]
    return SolutionByPlanes(whole.frame, int(steps), masks, clearance)


def _of_parts(name: str) -> Any:
    """A method of solutions by its name, which asks all parts."""

    @wraps(getattr(LargeSolution, name))
    def method(self: SolutionByPlanes, *given: Any, **named: Any) -> NDArray[Any]:
        return self.joined([getattr(part, name)(*given, **named) for part in self.parts])

    return method


def _value_of_parts(name: str, leading: int = 0) -> Any:
    """A property of solutions by its name, likewise."""

    def value(self: SolutionByPlanes) -> NDArray[Any]:
        return self.joined([getattr(part, name) for part in self.parts], leading)

    value.__doc__ = getattr(LargeSolution, name).__doc__
    return cached_property(value)


class SolutionByPlanes(LargeSolution):
    """A solution of which entries keep to different planes, or to none: those of each are solved apart.

    Parameters
    ----------
    frame
        The description.
    steps
        Number of load steps.
    masks
        Entries of each part (...), which together are all that were not left out.
    clearance
        Whether the joints' clearances are taken into account.
    """

    def __init__(self, frame: Description, steps: int, masks: list[Mask], clearance: bool = True) -> None:
        super().__init__(frame, steps, clearance)
        self.masks = masks
        self.parts = [LargeSolution(excluding(frame, ~mask), steps, clearance) for mask in masks]

    displacement = _of_parts("displacement")
    displacement_along = _of_parts("displacement_along")
    joint_displacement = _of_parts("joint_displacement")
    end_forces = _of_parts("end_forces")
    forces = _of_parts("forces")
    stress = _of_parts("stress")
    reaction = _of_parts("reaction")
    joint_force = _of_parts("joint_force")
    section_axes_at = _of_parts("section_axes_at")
    joint_global = _of_parts("joint_global")
    error_bound = _of_parts("error_bound")
    state = _value_of_parts("state")
    stable = _value_of_parts("stable")
    neutral = _value_of_parts("neutral")
    converged = _value_of_parts("converged")
    iterations = _value_of_parts("iterations")
    residual = _value_of_parts("residual")
    strain_energy = _value_of_parts("strain_energy", leading=1)
    work = _value_of_parts("work", leading=1)

    def contact(self, joint: str) -> Contact:
        found = [part.contact(joint) for part in self.parts]
        values: dict[str, Any] = {
            each.name: self.joined([getattr(contact, each.name) for contact in found])
            for each in fields(Contact)
            if each.name != "joint"
        }
        return Contact(joint=found[0].joint, **values)

    @property
    def load_factor(self) -> Array:
        return self.parts[0].load_factor

    def explain(self) -> str:
        lines = [f"Entries keep to {len(self.parts)} planes, or to none, and are solved plane by plane."]
        return Explanation("\n".join([*lines, *(part.explain() for part in self.parts)]))

    @cached_property
    def displaced(self) -> DisplacedState:
        """Where everything is, all entries in space."""
        out = DisplacedState.start(self.model, self._load_stepping.count)
        for mask, part in zip(self.masks, self.parts, strict=True):
            index = np.flatnonzero(mask)
            inside = EquilibriumEquations(part.model, part.model.where(index), len(index))
            out.put(index, in_space(self.model, inside, part.displaced.taken(index)))
        return out

    def joined(self, results: list[NDArray[Any]], leading: int = 0) -> NDArray[Any]:
        """Results of the parts, each where its entries are; the batch comes behind so many axes."""
        out = results[0].copy()
        for mask, values in zip(self.masks[1:], results[1:], strict=True):
            at = (slice(None),) * leading + (mask,)
            out[at] = values[at]
        return out
