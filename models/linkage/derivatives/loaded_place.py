"""Derivatives of the position of a point under load by the inputs from which a function builds the linkage.

The position is that in the rigid linkage plus the displacement by compliance. For both, one adjoint solution for each
component gives the derivatives by the numbers of the description; these are summed and then multiplied by the
derivatives of the numbers by the inputs, found by describing the linkage with other inputs. If an input changes a
number for which the displacement has no derivatives, there are none by the inputs either.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, is_dataclass
from typing import Any

import numpy as np

from ....framework.batch import Array
from ....framework.error_bounds.sensitivity import Sensitivity
from ..description.parts import GROUND, LinkageLink, Load, about_first
from ..poses.classified import ClassifiedPoses
from .built import DescribedBeside, moved_by_numbers
from .displacement_sensitivity import through_loops
from .position_sensitivity import Place, position_sensitivity

# Parts of an element whose numbers have derivatives of their own.
SECTIONS, MATERIAL = ("section", "end"), "material"


@dataclass(frozen=True, eq=False)
class LoadedPlace:
    """Derivatives of a weighted sum of the position components of a point under load.

    Attributes
    ----------
    motion
        Motion of the linkage built from the inputs, (m,).
    point
        Name of the point.
    weight
        Weights of the components, (m, 3).
    frame
        Derivatives of the weighted sum of the displacement by compliance, by the quantities of the frame.
    members
        Names of the members of the frame by link, in the order of the link's beams.
    nodes
        Names of the nodes of the frame by link and point.
    """

    motion: ClassifiedPoses
    point: str
    weight: Array
    frame: Sensitivity
    members: Mapping[str, Sequence[str]]
    nodes: Mapping[Place, str]

    def along_inputs(self, beside: DescribedBeside) -> dict[str, Array] | None:
        """Derivatives (m,) by each input; None if one changes numbers for which the displacement has no derivatives.

        Parameters
        ----------
        beside
            The linkage described with lower and upper inputs.
        """
        if any(_changes(beside, each) for each in self._others(beside)):
            return None
        total = np.zeros(beside.widths.shape)
        if any(_changes(beside, each) for each in _places(beside)):
            displaced = through_loops(self.motion, self.nodes, {"sum": self.frame})
            total += moved_by_numbers(position_sensitivity(self.motion, self.point), self.weight, beside)
            total += moved_by_numbers(displaced, np.ones((len(self.weight), 1)), beside)
        for value, trailing, kind, key in self._of_frame(beside):
            number = np.asarray(value)
            if _changes(beside, number):
                slope = np.asarray(_derivative(self.frame, kind, key))
                total += beside.changed(number, trailing, slope.reshape(len(self.weight), -1))
        return beside.by_name(total)

    def _of_frame(self, beside: DescribedBeside) -> Iterator[tuple[Any, int, str, tuple[str, ...]]]:
        """Numbers of the frame, their trailing axes, and kind and names under which `frame` has the derivatives."""
        for name, pair in beside.description.joints.items():
            if pair.stiffness is not None:
                # the springs of a universal joint lie on both sides of its cross; each side is infinitely stiff where
                # the other has the spring, so that these derivatives are zero there
                for own in (name, about_first(pair)) if pair.kind.name == "universal" else (name,):
                    yield pair.stiffness, 1, "joints", (own,)
        for load in beside.description.loads:
            if load.link != GROUND:
                yield load.value, 1, "loads", (self._loaded(beside.description.links, load),)
        for member, element in self._elements(beside):
            for part in SECTIONS:
                for size, value in _sizes(element, part).items():
                    yield value, 0, "sections", (member, size if part == SECTIONS[0] else f"{part}.{size}")
            if (material := getattr(element, MATERIAL, None)) is not None:
                yield material.E, 0, "moduli", (member,)

    def _loaded(self, links: Mapping[str, LinkageLink], load: Load) -> str:
        return self.nodes[load.link, load.point or links[load.link].points[0]]

    def _elements(self, beside: DescribedBeside) -> Iterator[tuple[str, object]]:
        """Members of the frame with their elements in the description."""
        for name, link in beside.description.links.items():
            yield from zip(self.members.get(name, ()), link.beams.values(), strict=True)

    def _others(self, beside: DescribedBeside) -> Iterator[object]:
        """Everything else that the displacement depends on, without derivatives here."""
        described = beside.description
        yield from (pair.axes for pair in described.joints.values())
        yield described.weight
        for _, element in self._elements(beside):
            material = getattr(element, MATERIAL, None)
            yield getattr(material, "nu", None)
            if np.any(described.weight):
                yield getattr(material, "density", None)
            for part in SECTIONS:
                yield None if _sizes(element, part) else getattr(element, part, None)
            yield from (value for name, value in _parts(element) if name not in (*SECTIONS, MATERIAL))


def _sizes(element: object, part: str) -> Mapping[str, Any]:
    """Sizes of a section of an element by name; empty if it has no such section."""
    section: Any = getattr(element, part, None)
    return section.sizes() if hasattr(section, "sizes") else {}


def _derivative(found: Sensitivity, kind: str, key: tuple[str, ...]) -> Any:
    by: Any = getattr(found, kind)
    for name in key:
        by = by[name]
    return by


def _places(beside: DescribedBeside) -> Iterator[object]:
    """Numbers that determine the positions of the links."""
    described = beside.description
    yield from described.points.values()
    yield from (link.length for link in described.links.values())
    yield from (number for pair in described.joints.values() for number in (pair.pitch, pair.reference))


def _parts(value: object) -> list[tuple[str, object]]:
    """Numbers and other parts of an element, by name."""
    if is_dataclass(value):
        return [(each.name, getattr(value, each.name)) for each in fields(value)]
    return [*getattr(value, "__dict__", {}).items()]


def _changes(beside: DescribedBeside, value: object) -> bool:
    """Whether a number in a part of the description differs between the lower and upper value of some input."""
    if isinstance(value, np.ndarray):
        if value.shape[:1] != (beside.rows,) or value.dtype == object:
            return False
        below, above = beside.sides(value, value.ndim - 1)
        return bool(np.any(below != above))
    if isinstance(value, Mapping):
        return any(_changes(beside, each) for each in value.values())
    if isinstance(value, list | tuple):
        return any(_changes(beside, each) for each in value)
    return any(_changes(beside, each) for _, each in _parts(value))
