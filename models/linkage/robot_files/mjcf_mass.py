"""Mass and inertia of a body of MJCF, as given or of its geoms."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from xml.etree.ElementTree import Element

import numpy as np

from ....framework.batch import Array
from ....framework.errors import FrameError
from .mjcf_source import Attributes, MjcfSource, numbers, shown
from .placed import BodyMass

WATER = "1000"
# Kinds of geoms whose shape stands in another file.
OF_FILES = ("mesh", "hfield", "sdf")
FULL = np.array([[0, 3, 4], [3, 1, 5], [4, 5, 2]])


def given_mass(source: MjcfSource, body: Element) -> BodyMass | None:
    """Given mass of a body, in its own axes; None if there is none."""
    element = body.find("inertial")
    return None if element is None else _inertial(source, element, f"inertial of {shown(body)}")


def together(parts: Sequence[BodyMass]) -> BodyMass:
    """Mass, centre of mass and inertia of several parts together."""
    whole = sum(part.mass for part in parts)
    moment = sum((part.mass * part.centre for part in parts), np.zeros(3))
    centre = moment / whole if whole > 0.0 else parts[0].centre
    tensor = sum((part.tensor + part.mass * _steiner(part.centre - centre) for part in parts), np.zeros((3, 3)))
    return BodyMass(whole, centre, tensor, any(part.is_own for part in parts))


def _steiner(arm: Array) -> Array:
    return np.asarray((arm @ arm) * np.eye(3) - np.outer(arm, arm))


def _inertial(source: MjcfSource, element: Element, what: str) -> BodyMass:
    given = element.attrib
    mass = float(numbers(given, "mass", what, 1)[0])
    centre = numbers(given, "pos", what, 3, "0 0 0")
    turn = source.orientation(given, what)
    if "fullinertia" in given:
        tensor = numbers(given, "fullinertia", what, 6)[FULL]
    else:
        tensor = np.diag(numbers(given, "diaginertia", what, 3, "0 0 0"))
    if np.array_equal(turn, np.eye(3)):
        return BodyMass(mass, centre, tensor, True)
    return BodyMass(mass, centre, turn @ tensor @ turn.T, True)


def geom_mass(source: MjcfSource, given: Attributes, what: str) -> BodyMass | None:
    """Mass of a geom in the axes of its body or frame; None if it has none."""
    kind = given.get("type", "sphere")
    first, last = numbers(source.compiler, "inertiagrouprange", "compiler", 2, "0 5")
    if not first <= float(numbers(given, "group", what, 1, "0")[0]) <= last:
        return None
    mass, density = (numbers(given, key, what, 1, default)[0] for key, default in (("mass", "1"), ("density", WATER)))
    if kind == "plane" or mass == 0.0 or density == 0.0:
        return None
    if kind not in (*SHAPES, *OF_FILES):
        raise FrameError(f"{what} is of type {kind!r}: give one of {', '.join((*SHAPES, *OF_FILES, 'plane'))}")
    if kind in OF_FILES:
        raise FrameError(
            f"{what} is a {kind}, whose mass is given by another file: give the body an <inertial> with its mass"
        )
    if given.get("shellinertia") == "true" or "mesh" in given:
        raise FrameError(f"{what} is a shell, or as large as a mesh: give the body an <inertial> with its mass")
    centre, turn, size = _placed(source, given, what, kind)
    volume, moments = SHAPES[kind](*size)
    whole = float(mass if "mass" in given else density * volume)
    return BodyMass(whole, centre, whole * (turn * np.array(moments)) @ turn.T, True)


def _placed(source: MjcfSource, given: Attributes, what: str, kind: str) -> tuple[Array, Array, list[float]]:
    """Centre (3,), axes (3, 3) and sizes of a geom; ``fromto`` gives those and the length by two points."""
    along = "fromto" in given
    count = 1 if along else {"sphere": 1, "capsule": 2, "cylinder": 2}.get(kind, 3)
    size = numbers(given, "size", what)[:count].tolist()
    if len(size) < count or min(size) <= 0.0:
        many = f"{count} sizes" if count > 1 else "a size"
        raise FrameError(f"{what}: size of a {kind} is {given['size']!r}: give {many} above zero")
    if not along:
        return numbers(given, "pos", what, 3, "0 0 0"), source.orientation(given, what), size
    ends = numbers(given, "fromto", what, 6).reshape(2, 3)
    chord = ends[1] - ends[0]
    axis = " ".join(map(repr, chord.tolist()))
    half = float(np.linalg.norm(chord)) / 2.0
    if half == 0.0:
        raise FrameError(f"{what}: fromto is {given['fromto']!r}: give two points")
    sizes = [size[0], half] if kind in ("capsule", "cylinder") else [size[0], size[0], half]
    return ends.mean(axis=0), source.orientation({"zaxis": axis}, what), sizes


Moments = tuple[float, tuple[float, float, float]]


def _ellipsoid(a: float, b: float, c: float) -> Moments:
    return 4.0 / 3.0 * np.pi * a * b * c, ((b * b + c * c) / 5.0, (a * a + c * c) / 5.0, (a * a + b * b) / 5.0)


def _box(a: float, b: float, c: float) -> Moments:
    return 8.0 * a * b * c, ((b * b + c * c) / 3.0, (a * a + c * c) / 3.0, (a * a + b * b) / 3.0)


def _cylinder(radius: float, half: float) -> Moments:
    across = radius**2 / 4.0 + half**2 / 3.0
    return 2.0 * np.pi * radius**2 * half, (across, across, radius**2 / 2.0)


def _capsule(radius: float, half: float) -> Moments:
    """A cylinder between two hemispheres, whose centres of mass are at 3/8 of the radius."""
    whole, (across, _, along) = _cylinder(radius, half)
    ball = 4.0 / 3.0 * np.pi * radius**3
    both = whole + ball
    off = half + 3.0 / 8.0 * radius
    ball_across = (2.0 / 5.0 - 9.0 / 64.0) * radius**2 + off**2
    turned = (whole * across + ball * ball_across) / both
    return both, (turned, turned, (whole * along + ball * 2.0 / 5.0 * radius**2) / both)


# Volume, and moments of inertia per mass, by the sizes of MJCF.
SHAPES: dict[str, Callable[..., Moments]] = {
    "sphere": lambda radius: _ellipsoid(radius, radius, radius),
    "ellipsoid": _ellipsoid,
    "box": _box,
    "cylinder": _cylinder,
    "capsule": _capsule,
}
