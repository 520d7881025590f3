"""A linkage from the tables of a file."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from inspect import signature
from typing import Any, TypeVar

from ....elements import Beam, Circle, CrossSection, ISection, Material, Rectangle, Section, Tube
from ....framework.batch import rotation
from ....framework.dofs import FORCES
from ..description.joints import KINDS
from ..description.linkage_description import LinkageDescription
from ..description.parts import GROUND
from .source import Source, shown_value

Described = TypeVar("Described", bound=LinkageDescription)

SECTIONS: dict[str, type[CrossSection]] = {
    "rectangle": Rectangle,
    "circle": Circle,
    "tube": Tube,
    "i": ISection,
    "properties": Section,
}
# Keys that only one kind of joint has.
OWN = {"second": "universal", "pitch": "screw", "contact": "revolute"}
TABLES = (
    "title", "points", "links", "joints", "drives", "springs", "loads", "gravity", "beams", "sections", "materials",
)  # fmt: skip
# Tables of the job of `linkframe run`, which are no part of the linkage.
JOB = ("run", "tolerances", "choices", "measured")


def linkage_of(source: Source, kind: type[Described]) -> Described:
    """The linkage that a file describes, such as a `Linkage`."""
    for key in source.data:
        if key not in (*TABLES, *JOB):
            source.fail((key,), f"there is no such table: use one of {', '.join((*TABLES, *JOB))}")
    if "title" in source.data:
        source.text_at(("title",))
    linkage = kind()
    for name in source.names(("points",)):
        with source.at("points", name):
            linkage.point(name, source.numbers(("points", name)))
    materials = {name: _material(source, name) for name in source.names(("materials",))}
    sections = {name: _section(source, name) for name in source.names(("sections",))}
    beams = {name: _beam(source, name, sections, materials) for name in source.names(("beams",))}
    for name in source.names(("links",)):
        _link(source, linkage, name, beams)
    for name in source.names(("joints",)):
        _joint(source, linkage, name)
    if "drives" in source.data:
        _order_drives(source, linkage)
    for index in range(source.count(("springs",))):
        _spring(source, linkage, index)
    for index in range(source.count(("loads",))):
        _load(source, linkage, index)
    if "gravity" in source.data:
        with source.at("gravity"):
            linkage.gravity(source.numbers(("gravity",)))
    return linkage


def _material(source: Source, name: str) -> Material:
    path = ("materials", name)
    table = source.table(path, ("E",), ("nu", "G", "density"))
    with source.at(*path):
        return Material(**{key: source.numbers((*path, key)) for key in table})


def _section(source: Source, name: str) -> CrossSection:
    path = ("sections", name)
    if not isinstance(source.get(path), dict):
        source.fail(path, f"is {shown_value(source.get(path))}: give a table, [sections.{name}]")
    shape = SECTIONS[source.text_at((*path, "shape"), SECTIONS)]
    sizes = signature(shape).parameters.values()
    needed, further = ([each.name for each in sizes if (each.default is each.empty) == must] for must in (True, False))
    table = source.table(path, ("shape", *needed), tuple(further))
    numbers = {key: source.numbers((*path, key)) for key in table if key != "shape"}
    with source.at(*path):
        return shape(**numbers)


def _beam(source: Source, name: str, sections: Mapping[str, CrossSection], materials: Mapping[str, Material]) -> Beam:
    path = ("beams", name)
    table = source.table(path, ("section", "material"), ("end", "up", "shear", "segments", "release"))
    given: dict[str, Any] = {
        "section": sections[source.text_at((*path, "section"), sections)],
        "material": materials[source.text_at((*path, "material"), materials)],
    }
    if "end" in table:
        given["end"] = sections[source.text_at((*path, "end"), sections)]
    if "up" in table:
        given["up"] = source.numbers((*path, "up"))
    if "release" in table:
        given["release"] = tuple(source.texts((*path, "release")))
    for key, kind in (("shear", bool), ("segments", int)):
        if key in table:
            if type(table[key]) is not kind:
                source.fail(
                    (*path, key),
                    f"is {shown_value(table[key])}: give {'true or false' if kind is bool else 'a whole number'}",
                )
            given[key] = table[key]
    with source.at(*path):
        return Beam(**given)


def _link(source: Source, linkage: LinkageDescription, name: str, beams: Mapping[str, Beam]) -> None:
    path = ("links", name)
    table = source.table(path, ("points",), ("beam", "beams", "mass", "centre", "inertia", "length"))
    given: dict[str, Any] = {
        key: source.numbers((*path, key)) for key in ("mass", "centre", "inertia", "length") if key in table
    }
    if "beam" in table:
        given["beam"] = beams[source.text_at((*path, "beam"), beams)]
    if "beams" in table:
        given["beam"] = {}
        for index, entry in enumerate(table["beams"] if isinstance(table["beams"], list) else [None]):
            if not isinstance(entry, list) or len(entry) != 3:
                source.fail((*path, "beams"), f"has {shown_value(entry)}: give lists of two points and a beam")
            beam = source.text_at((*path, "beams", index, 2), beams)
            given["beam"][entry[0], entry[1]] = beams[beam]
    with source.at(*path):
        linkage.link(name, *source.texts((*path, "points")), **given)


def _joint(source: Source, linkage: LinkageDescription, name: str) -> None:
    path = ("joints", name)
    numbers = ("axis", "second", "pitch", "stiffness", "clearance", "contact", "reference", "axes")
    table = source.table(path, ("kind", "point", "links"), ("drive", *numbers))
    kind = source.text_at((*path, "kind"), KINDS)
    links = source.texts((*path, "links"))
    for key in table:
        if OWN.get(key, kind) != kind or (kind == "fixed" and key in ("reference", "drive")):
            source.fail((*path, key), f"a {kind} joint has no {key}")
    given = {key: source.numbers((*path, key)) for key in numbers if key in table and key != "axes"}
    if "axes" in table:
        given.setdefault("axis", source.numbers((*path, "axes"))[..., 2])
        if kind == "universal":
            given.setdefault("second", source.numbers((*path, "axes"))[..., 0])
    add: Callable[..., None] = getattr(linkage, kind)
    with source.at(*path):
        for needed, of in (
            ("axis", ("prismatic", "universal", "screw")),
            ("second", ("universal",)),
            ("pitch", ("screw",)),
        ):
            if kind in of and needed not in given:
                source.fail(path, f"a {kind} joint needs its {needed}: give it")
        if kind != "revolute" and len(links) != 2:
            source.fail((*path, "links"), f"names {len(links)} links: a {kind} joint joins two")
        add(source.text_at((*path, "point")), *links, name=name, **given)
        if "axes" in table:
            axes = rotation(source.numbers((*path, "axes")), f"axes of joint {name!r}")
            linkage.joints[name] = replace(linkage.joints[name], axes=axes)
        if "drive" in table:
            _drive(source, linkage, name)


def _drive(source: Source, linkage: LinkageDescription, joint: str) -> None:
    path = ("joints", joint, "drive")
    value = source.get(path)
    if isinstance(value, bool):
        if value:
            linkage.drive(joint)
        return
    if not isinstance(value, list):
        source.fail(path, f'is {shown_value(value)}: give true, or a list of coordinates, such as ["rz"]')
    with source.at(*path):
        linkage.drive(joint, *source.texts(path))


def _order_drives(source: Source, linkage: LinkageDescription) -> None:
    """Put the drives in the given order, which arrays of all drives follow; otherwise it is that of the joints."""
    order, driven = source.texts(("drives",)), linkage.drives
    if sorted(order) != sorted(driven):
        told = f"name each driven joint once, they are {', '.join(driven)}" if driven else "no joint has drive = true"
        source.fail(("drives",), f"is {', '.join(order)}: {told}")
    linkage.drives = {name: driven[name] for name in order}


def _spring(source: Source, linkage: LinkageDescription, index: int) -> None:
    path = ("springs", index)
    table = source.table(path, ("between", "stiffness", "length"), ("damping",))
    ends = table["between"]
    if not isinstance(ends, list) or len(ends) != 2:
        source.fail(
            (*path, "between"), f"is {shown_value(ends)}: give two ends, each a point or a list of link and point"
        )
    both = [end if isinstance(end, str) else tuple(source.texts((*path, "between", k))) for k, end in enumerate(ends)]
    for end in both:
        if len(end) != 2 and not isinstance(end, str):
            source.fail((*path, "between"), f"has {shown_value(list(end))}: give a point, or a list of link and point")
    with source.at(*path, "between"):
        first, second = (linkage.end(end, "spring") for end in both)  # type: ignore[arg-type]
    numbers: dict[str, Any] = {key: source.numbers((*path, key)) for key in table if key != "between"}
    with source.at(*path):
        linkage.spring(first, second, **numbers)


def _load(source: Source, linkage: LinkageDescription, index: int) -> None:
    path = ("loads", index)
    table = source.table(path, (), ("link", "point", "follower", *FORCES))
    force: dict[str, Any] = {key: source.numbers((*path, key)) for key in table if key in FORCES}
    if "follower" in table:
        if not isinstance(table["follower"], bool):
            source.fail((*path, "follower"), f"is {shown_value(table['follower'])}: give true or false")
        force["follower"] = table["follower"]
    if "point" not in table and "link" not in table:
        source.fail(path, "is nowhere: give a point, a link, or both")
    link = source.text_at((*path, "link"), (*linkage.links, GROUND)) if "link" in table else None
    with source.at(*path):
        if "point" in table:
            linkage.load(source.text_at((*path, "point"), linkage.points), link=link, **force)
            return
        assert link is not None
        if any(key in FORCES[:3] for key in force):
            source.fail(path, f"is a force on link {link!r} at no point: give the point, or moments only")
        linkage.torque(link, **force)
