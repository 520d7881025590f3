"""Solutions at large displacement of batches whose entries keep to different planes, each as if it were alone."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields
from functools import cached_property
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..batch import Array
from ..batched.idle import released_at_rest
from ..checked import whole_number
from ..clearances.clearance import joints_with_clearance
from ..clearances.contact import Contact
from ..description import Description, excluding
from ..errors import FrameError
from ..listing import Explanation
from ..states import States
from .accuracy import in_space
from .equations import EquilibriumEquations
from .solution import LargeSolution
from .state import DisplacedState, Mask

_T = TypeVar("_T", bound=np.generic)


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

    def displacement(self, node: str) -> Array:
        return self._joined(lambda part: part.displacement(node))

    def displacement_along(self, member: str, at: ArrayLike) -> Array:
        return self._joined(lambda part: part.displacement_along(member, at))

    def joint_displacement(self, joint: str) -> Array:
        return self._joined(lambda part: part.joint_displacement(joint))

    def end_forces(self, member: str) -> Array:
        return self._joined(lambda part: part.end_forces(member))

    def forces(self, member: str, at: ArrayLike) -> Array:
        return self._joined(lambda part: part.forces(member, at))

    def stress(self, member: str, at: ArrayLike) -> Array:
        return self._joined(lambda part: part.stress(member, at))

    def reaction(self, node: str) -> Array:
        return self._joined(lambda part: part.reaction(node))

    def joint_force(self, joint: str) -> Array:
        return self._joined(lambda part: part.joint_force(joint))

    def section_axes_at(self, fractions: ArrayLike) -> Array:
        return self._joined(lambda part: part.section_axes_at(fractions))

    def joint_global(self, joint: str, vectors: Array) -> Array:
        return self._joined(lambda part: part.joint_global(joint, vectors))

    def contact(self, joint: str) -> Contact:
        found = [part.contact(joint) for part in self.parts]
        values: dict[str, Any] = {
            each.name: self._of([getattr(contact, each.name) for contact in found])
            for each in fields(Contact)
            if each.name != "joint"
        }
        return Contact(joint=found[0].joint, **values)

    @cached_property
    def state(self) -> States:
        return self._joined(lambda part: part.state)

    @cached_property
    def stable(self) -> NDArray[np.bool_]:
        return self._joined(lambda part: part.stable)

    @cached_property
    def neutral(self) -> NDArray[np.bool_]:
        return self._joined(lambda part: part.neutral)

    @cached_property
    def converged(self) -> NDArray[np.bool_]:
        return self._joined(lambda part: part.converged)

    @property
    def iterations(self) -> NDArray[np.int64]:
        return self._joined(lambda part: part.iterations)

    @cached_property
    def residual(self) -> Array:
        return self._joined(lambda part: part.residual)

    def error_bound(self, node: str) -> Array:
        return self._joined(lambda part: part.error_bound(node))

    @property
    def load_factor(self) -> Array:
        return self.parts[0].load_factor

    @property
    def strain_energy(self) -> Array:
        return self._joined(lambda part: part.strain_energy, leading=1)

    @property
    def work(self) -> Array:
        return self._joined(lambda part: part.work, leading=1)

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

    def _joined(self, result: Callable[[LargeSolution], NDArray[_T]], leading: int = 0) -> NDArray[_T]:
        """A result of every part where its entries are, the batch behind so many axes."""
        return self._of([result(part) for part in self.parts], leading)

    def _of(self, results: list[NDArray[_T]], leading: int = 0) -> NDArray[_T]:
        out = results[0].copy()
        for mask, values in zip(self.masks[1:], results[1:], strict=True):
            at = (slice(None),) * leading + (mask,)
            out[at] = values[at]
        return out
