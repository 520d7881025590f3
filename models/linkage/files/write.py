"""A linkage as the tables of its TOML file."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ....elements import Beam, CrossSection, Material, Section
from ....framework.batch import Array
from ....framework.dofs import FORCES
from ....framework.errors import FrameError
from ....framework.protocol import LineElement
from ..description.linkage_description import LinkageDescription
from ..description.parts import LinkageLink, LinkageSpring, Load, Pair, joint_axes
from .read import SECTIONS
from .toml import written

Table = dict[str, Any]


def tables(linkage: LinkageDescription) -> Table:
    """The linkage as the tables of its file."""
    catalogue = Catalogue()
    out: Table = {"gravity": linkage.weight} if np.any(linkage.weight) else {}
    if list(linkage.drives) != [name for name in linkage.joints if name in linkage.drives]:
        out["drives"] = list(linkage.drives)
    out["points"] = {name: _point(place) for name, place in linkage.points.items()}
    out["links"] = {name: _link(link, catalogue) for name, link in linkage.links.items()}
    out["joints"] = {name: _joint(pair, linkage.drives.get(name)) for name, pair in linkage.joints.items()}
    out["springs"] = [_spring(spring) for spring in linkage.springs]
    out["loads"] = [_load(load) for load in linkage.loads]
    out |= {"beams": catalogue.beams, "sections": catalogue.sections, "materials": catalogue.materials}
    return {key: value for key, value in out.items() if len(value)}


class Catalogue:
    """Beams, sections and materials by name; equal ones have one name."""

    def __init__(self) -> None:
        self.beams: Table = {}
        self.sections: Table = {}
        self.materials: Table = {}

    def beam(self, beam: LineElement) -> str:
        """Name of a beam.

        Raises
        ------
        FrameError
            If it is not a Beam: a file cannot describe other elements.
        """
        if type(beam) is not Beam:
            raise FrameError(
                f"a file describes beams, and the linkage has a {beam.title}: keep it in Python, or give it a Beam"
            )
        table: Table = {"section": self._section(beam.section), "material": self._material(beam.material)}
        if beam.end is not None:
            table["end"] = self._section(beam.end)
        if beam.up is not None:
            table["up"] = beam.up
        if beam.shear:
            table["shear"] = True
        if beam.segments != 1:
            table["segments"] = int(beam.segments)
        if beam.release:
            table["release"] = list(beam.release)
        return _named("beam", self.beams, table)

    def _section(self, section: CrossSection) -> str:
        shape = next((name for name, kind in SECTIONS.items() if type(section) is kind), None)
        if shape is None:
            raise FrameError(
                f"a file describes sections of the shapes {', '.join(SECTIONS)}, and the linkage has a "
                f"{type(section).__name__}: keep it in Python, or give its properties by a Section"
            )
        table = {"shape": shape, **section.sizes()}
        if isinstance(section, Section) and section.fibres is not None:
            table["fibres"] = section.fibres
        return _named("section", self.sections, table)

    def _material(self, material: Material) -> str:
        # nu and G determine each other only to rounding: nu is written if it gives G back to the last bit
        ratio = np.asarray(material.nu)
        exact = _same(material.E / (2.0 * (1.0 + material.nu)), material.G) and np.all((ratio > -1.0) & (ratio < 0.5))
        key = "nu" if exact else "G"
        table = {"E": material.E, key: getattr(material, key), "density": material.density}
        return _named("material", self.materials, table)


def _named(kind: str, known: Table, table: Table) -> str:
    text = written({"": table})
    for name, other in known.items():
        if written({"": other}) == text:
            return name
    name = f"{kind}{len(known) + 1}"
    known[name] = table
    return name


def _same(one: object, other: object) -> bool:
    return np.array_equal(np.asarray(one), np.asarray(other))


def _point(place: Array) -> Array:
    return place if np.any(place[..., 2]) else place[..., :2]


def _link(link: LinkageLink, catalogue: Catalogue) -> Table:
    table: Table = {"points": list(link.points)}
    if link.beams:
        table["beams"] = [[*pair, catalogue.beam(beam)] for pair, beam in link.beams.items()]
    given: Mapping[str, Array | None] = {k: getattr(link, k) for k in ("mass", "centre", "inertia", "length")}
    return table | {key: value for key, value in given.items() if value is not None}


def _joint(pair: Pair, driven: tuple[str, ...] | None) -> Table:
    table: Table = {"kind": pair.kind.name, "point": pair.point, "links": [pair.first, pair.second]}
    table |= _axes(pair)
    if driven:
        table["drive"] = list(driven)
    if np.any(pair.reference):
        table["reference"] = pair.reference[..., 0] if pair.kind.freedom == 1 else pair.reference
    given = {"pitch": pair.pitch, "stiffness": pair.stiffness, "clearance": pair.clearance, "contact": pair.contact}
    return table | {key: value for key, value in given.items() if value is not None}


def _axes(pair: Pair) -> Table:
    """Axis and second axis, as given or of unit length, if they give the joint's axes to the last bit; else all."""
    universal = pair.kind.name == "universal"
    own = pair.axes[..., 2], pair.axes[..., 0]
    for axis, second in (own,) if pair.directions is None else (pair.directions, own):
        second = second if universal else None
        if _same(joint_axes(pair.name, axis, second), pair.axes):
            return {"axis": axis} if second is None else {"axis": axis, "second": second}
    return {"axes": pair.axes}


def _spring(spring: LinkageSpring) -> Table:
    ends = [list(spring.first), list(spring.second)]
    return {"between": ends, "stiffness": spring.stiffness, "length": spring.length, "damping": spring.damping}


def _load(load: Load) -> Table:
    where: Table = {"link": load.link} | ({} if load.point is None else {"point": load.point})
    where |= {"follower": True} if load.follower else {}
    return where | {name: load.value[..., k] for k, name in enumerate(FORCES) if np.any(load.value[..., k])}
