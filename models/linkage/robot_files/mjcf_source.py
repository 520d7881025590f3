"""An MJCF file being read: its elements with the defaults of their classes, its angles and orientations."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import numpy as np

from ....framework import rotation
from ....framework.batch import Array
from ....framework.errors import FrameError

SAVED = "write the model out with mujoco.mj_saveLastXML, which resolves it, and read that file"
# Elements that generate bodies, or bodies that are not rigid.
REFUSED = ("composite", "replicate", "flexcomp", "attach", "flex", "plugin")
MAIN = "main"
# Options that change the masses in the file, if they are above zero or true.
CHANGES = ("settotalmass", "boundmass", "boundinertia", "balanceinertia")
ORIENTATIONS = ("quat", "axisangle", "euler", "xyaxes", "zaxis")
Attributes = Mapping[str, str]


class MjcfSource:
    """An MJCF file.

    Parameters
    ----------
    file
        Path of the file.

    Raises
    ------
    FrameError
        If it cannot be read, is not MJCF, or has bodies that are generated or not rigid.
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
        self._check_compiler()
        self.flags = {key: text for flag in self.root.findall("option/flag") for key, text in flag.attrib.items()}
        self.degrees = self.compiler.get("angle", "degree") == "degree"
        self.defaults: dict[str, dict[str, dict[str, str]]] = {MAIN: {}}
        for element in self.root.findall("default"):
            if element.get("class", MAIN) != MAIN:
                raise FrameError(f"the outermost <default> is of class {element.get('class')!r}: leave its class out")
            self._default(element, MAIN, self.defaults[MAIN])

    def _default(self, element: Element, name: str, above: Mapping[str, dict[str, str]]) -> None:
        own = {tag: dict(given) for tag, given in above.items()}
        for child in element:
            if child.tag != "default":
                own[child.tag] = own.get(child.tag, {}) | child.attrib
        self.defaults[name] = own
        for child in element.findall("default"):
            inner = child.get("class")
            if inner is None or inner in self.defaults:
                told = "has no class" if inner is None else f"is of class {inner!r}, as another one is"
                raise FrameError(f"a <default> within another {told}: give it one of its own")
            self._default(child, inner, own)

    def _check_compiler(self) -> None:
        for word in CHANGES:
            given = self.compiler.get(word, "false")
            if given != "false" and (given == "true" or numbers(self.compiler, word, "compiler", 1)[0] > 0.0):
                raise FrameError(
                    f"compiler: {word}={given!r} changes the masses that the file gives: leave it out, and write the "
                    "masses that bodies have"
                )
        for word, known in (("angle", r"degree|radian"), ("eulerseq", r"[xyzXYZ]{3}")):
            if word in self.compiler and not re.fullmatch(known, self.compiler[word]):
                one = "degree or radian" if word == "angle" else "three of the letters xyz and XYZ"
                raise FrameError(f"compiler: {word} is {self.compiler[word]!r}: give {one}")
        if self.compiler.get("coordinate", "local") != "local":
            raise FrameError(
                f"compiler: coordinate={self.compiler['coordinate']!r}: write places relative to the body around them"
            )

    def section(self, name: str) -> Iterator[Element]:
        """Elements of all sections of a name, such as ``equality``; none if a flag disables them."""
        if self.flags.get(name) == "disable":
            return
        for section in self.root.findall(name):
            yield from section

    def attributes(self, element: Element, childclass: str = MAIN, section: str = "") -> Attributes:
        """Attributes of an element, with the defaults of its class for those that it does not have.

        Defaults are found under its tag, or under the name of its `section` if that is given.
        """
        name = element.get("class", childclass)
        if name not in self.defaults:
            raise FrameError(f"{shown(element)} is of class {name!r}, which no <default> defines: define it")
        given = self.defaults[name].get(section or element.tag, {})
        if any(key in element.attrib for key in ORIENTATIONS):
            given = {key: text for key, text in given.items() if key not in ORIENTATIONS}
        return given | element.attrib

    def angle(self, value: float) -> float:
        """An angle of the file in radians."""
        return float(np.radians(value)) if self.degrees else value

    def placed(self, given: Attributes, what: str) -> tuple[Array, Array]:
        """Origin (3,) and rotation (3, 3) of a frame in its parent; with ``fromto``, z is from the end to the start."""
        if "fromto" not in given:
            return numbers(given, "pos", what, 3, "0 0 0"), self.orientation(given, what)
        if any(key in given for key in ("pos", *ORIENTATIONS)):
            raise FrameError(f"{what} has a place beside fromto={given['fromto']!r}: leave one or the other out")
        start, end = numbers(given, "fromto", what, 6).reshape(2, 3)
        return 0.5 * (start + end), _onto(start - end, f"{what}: fromto is {given['fromto']!r}: give two points")

    def orientation(self, given: Attributes, what: str) -> Array:
        """Rotation (3, 3) of a frame relative to its parent."""
        own = [key for key in ORIENTATIONS if key in given]
        if not own:
            return np.eye(3)
        if len(own) > 1:
            raise FrameError(f"{what} has {' and '.join(own)}: give one of them")
        (key,) = own
        message = f"{what}: {key} is {given[key]!r}: give a direction"
        if key == "euler":
            return self._euler(numbers(given, key, what, 3))
        if key == "axisangle":
            *axis, angle = numbers(given, key, what, 4)
            return _about(_direction(np.array(axis), message), self.angle(angle))
        if key == "quat":
            return rotation.matrix(_direction(numbers(given, key, what, 4), message))
        if key == "zaxis":
            return _onto(numbers(given, key, what, 3), message)
        six = numbers(given, key, what, 6)
        x = _direction(six[:3], message)
        y = _direction(six[3:] - (six[3:] @ x) * x, message)
        return np.column_stack([x, y, np.cross(x, y)])

    def _euler(self, angles: Array) -> Array:
        """Rotations about the axes of ``eulerseq``: small letters for axes of the moving frame, capitals for fixed."""
        out = np.eye(3)
        for letter, angle in zip(self.compiler.get("eulerseq", "xyz"), angles.tolist(), strict=True):
            turn = _about(np.eye(3)["xyz".index(letter.lower())], self.angle(angle))
            out = out @ turn if letter.islower() else turn @ out
        return out


def _parsed(file: Path, what: str = "it") -> Element:
    try:
        return ElementTree.fromstring(file.read_bytes())
    except OSError as error:
        raise FrameError(f"{what} cannot be read: {error.strerror or error}; give an MJCF file") from error
    except ElementTree.ParseError as error:
        raise FrameError(f"{'this' if what == 'it' else what} is not XML: {error}") from error


def _include(element: Element, folder: Path, depth: int) -> None:
    """Replace ``<include file="..."/>`` by the content of the other file."""
    if depth > 30:
        raise FrameError("its files include one another without end: leave one of the <include> out")
    for index in reversed(range(len(element))):
        child = element[index]
        if child.tag == "include":
            if "file" not in child.attrib:
                raise FrameError("an <include> has no file: give one")
            other = _parsed(folder / child.attrib["file"], f"<include file={child.attrib['file']!r}>")
            _include(other, folder, depth + 1)
            element[index : index + 1] = list(other)
        else:
            _include(child, folder, depth)


def _direction(given: Array, message: str) -> Array:
    """A unit vector, (3,) or (4,)."""
    length = float(np.linalg.norm(given))
    if not length > 1e-14:
        raise FrameError(message)
    return given / length


def _onto(axis: Array, message: str) -> Array:
    """The smallest rotation that takes z to an axis (3,), as a matrix (3, 3)."""
    z = _direction(axis, message)
    turn = np.cross([0.0, 0.0, 1.0], z)
    sine = float(np.linalg.norm(turn))
    return _about(turn / sine if sine > 0.0 else np.array([1.0, 0.0, 0.0]), float(np.arctan2(sine, z[2])))


def _about(axis: Array, angle: float) -> Array:
    """Rotation matrix (3, 3) about a unit vector (3,) by an angle in radians."""
    return rotation.matrix(rotation.exponential(angle * axis))


def shown(element: Element) -> str:
    """Name of an element for messages."""
    name = element.get("name")
    return f"<{element.tag}>" if name is None else f"{element.tag} {name!r}"


def numbers(given: Attributes, key: str, what: str, count: int | None = None, default: str | None = None) -> Array:
    """Numbers of an attribute.

    Raises
    ------
    FrameError
        If there are none, fewer or more than `count`, or something else.
    """
    text = given.get(key, default)
    needed = "numbers" if count is None else f"{count} number{'s' if count > 1 else ''}"
    if text is None:
        raise FrameError(f"{what} has no {key}: give {needed}")
    try:
        out = np.array([float(part) for part in text.split()])
    except ValueError:
        out = np.zeros(0)
    if not out.size or not np.isfinite(out).all() or (count is not None and len(out) != count):
        raise FrameError(f"{what}: {key} is {text!r}: give {needed}")
    return out
