"""An MJCF file being read: its elements with the defaults of their classes, its angles and orientations."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import numpy as np

from ....framework import rotation
from ....framework.batch import Array
from ....framework.errors import FrameError

SAVED = "write the model out with mujoco.mj_saveLastXML, which resolves it, and read that file"
# What makes bodies out of others, or bodies that are not rigid.
REFUSED = ("composite", "replicate", "flexcomp", "attach", "flex", "plugin")
MAIN = "main"
Attributes = Mapping[str, str]


class MjcfSource:
    """An MJCF file.

    Parameters
    ----------
    file
        Where it is.

    Raises
    ------
    FrameError
        If it cannot be read, is no MJCF, or holds what is no rigid body.
    """

    def __init__(self, file: Path) -> None:
        self.file = file
        self.root = _parsed(file)
        if self.root.tag != "mujoco":
            raise FrameError(f"it begins with <{self.root.tag}>: give an MJCF file, which begins with <mujoco>")
        _include(self.root, file.parent, depth=0)
        for tag in REFUSED:
            if self.root.find(f".//{tag}") is not None:
                raise FrameError(f"it has <{tag}>, which generates bodies that the file does not list: {SAVED}")
        self.compiler: dict[str, str] = {}
        for element in self.root.findall("compiler"):
            self.compiler |= element.attrib
        self.degrees = self.compiler.get("angle", "degree") == "degree"
        self.defaults: dict[str, dict[str, dict[str, str]]] = {MAIN: {}}
        for element in self.root.findall("default"):
            self._default(element, element.get("class", MAIN), self.defaults[MAIN])

    def _default(self, element: Element, name: str, above: Mapping[str, dict[str, str]]) -> None:
        own = {tag: dict(given) for tag, given in above.items()}
        for child in element:
            if child.tag != "default":
                own[child.tag] = own.get(child.tag, {}) | child.attrib
        self.defaults[name] = own
        for child in element.findall("default"):
            self._default(child, child.get("class", MAIN), own)

    def section(self, name: str) -> Iterator[Element]:
        """Elements of all sections of a name, such as ``equality``."""
        for section in self.root.findall(name):
            yield from section

    def attributes(self, element: Element, childclass: str = MAIN) -> Attributes:
        """Attributes of an element, with those of its class where it has none of its own."""
        name = element.get("class", childclass)
        if name not in self.defaults:
            raise FrameError(f"{shown(element)} is of class {name!r}, which no <default> defines: define it")
        return self.defaults[name].get(element.tag, {}) | element.attrib

    def angle(self, value: float) -> float:
        """An angle of the file in radians."""
        return float(np.radians(value)) if self.degrees else value

    def orientation(self, given: Attributes, what: str) -> Array:
        """Rotation (3, 3) of a frame relative to the one around it."""
        if "quat" in given:
            return rotation.matrix(rotation.normalised(numbers(given, "quat", what, 4)))
        if "axisangle" in given:
            *axis, angle = numbers(given, "axisangle", what, 4)
            return _about(np.array(axis), self.angle(angle))
        if "euler" in given:
            return self._euler(numbers(given, "euler", what, 3))
        if "xyaxes" in given:
            six = numbers(given, "xyaxes", what, 6)
            x = six[:3] / np.linalg.norm(six[:3])
            y = six[3:] - (six[3:] @ x) * x
            y /= np.linalg.norm(y)
            return np.column_stack([x, y, np.cross(x, y)])
        if "zaxis" in given:
            z = numbers(given, "zaxis", what, 3)
            turn = np.cross([0.0, 0.0, 1.0], z)
            angle = float(np.arctan2(np.linalg.norm(turn), z[2]))
            return _about(turn if turn.any() else np.array([1.0, 0.0, 0.0]), angle)
        return np.eye(3)

    def _euler(self, angles: Array) -> Array:
        """Turns about the letters of ``eulerseq``: small ones move with the frame, capital ones stand still."""
        out = np.eye(3)
        for letter, angle in zip(self.compiler.get("eulerseq", "xyz"), angles.tolist(), strict=True):
            turn = _about(np.eye(3)["xyz".index(letter.lower())], self.angle(angle))
            out = out @ turn if letter.islower() else turn @ out
        return out


def _parsed(file: Path) -> Element:
    try:
        return ElementTree.fromstring(file.read_bytes())
    except OSError as error:
        raise FrameError(f"it cannot be read: {error.strerror or error}; give an MJCF file") from error
    except ElementTree.ParseError as error:
        raise FrameError(f"this is not XML: {error}") from error


def _include(element: Element, folder: Path, depth: int) -> None:
    """Put the content of other files in the place of ``<include file="..."/>``."""
    if depth > 30:
        raise FrameError("its files include one another without end: leave one of the <include> out")
    for index in reversed(range(len(element))):
        child = element[index]
        if child.tag == "include":
            other = _parsed(folder / child.get("file", ""))
            _include(other, folder, depth + 1)
            element[index : index + 1] = list(other)
        else:
            _include(child, folder, depth)


def _about(axis: Array, angle: float) -> Array:
    return rotation.matrix(rotation.exponential(angle * axis / np.linalg.norm(axis)))


def shown(element: Element) -> str:
    """An element as a message names it."""
    name = element.get("name")
    return f"<{element.tag}>" if name is None else f"{element.tag} {name!r}"


def numbers(given: Attributes, key: str, what: str, count: int | None = None, default: str | None = None) -> Array:
    """Numbers of an attribute.

    Raises
    ------
    FrameError
        If there are none, fewer than `count`, or something else.
    """
    text = given.get(key, default)
    try:
        out = np.array([float(part) for part in (text or "").split()])
    except ValueError:
        out = np.zeros(0)
    if not out.size or not np.isfinite(out).all() or (count is not None and len(out) < count):
        needed = "numbers" if count is None else f"{count} number{'s' if count > 1 else ''}"
        raise FrameError(f"{what}: {key} is {text!r}: give {needed}")
    return out if count is None else out[:count]
