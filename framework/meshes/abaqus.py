"""Line meshes of Abaqus input files: nodes, elements and their sets, as written for one part."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import chain, pairwise
from pathlib import Path

import numpy as np

from ..errors import FrameError
from .lines import Index, LineMesh, in_space

# Elements that are lines, with the number of their nodes along the line.
_LINES = {"B21": 2, "B22": 3, "B23": 2, "B31": 2, "B32": 3, "B33": 2, "T2D2": 2, "T2D3": 3, "T3D2": 2, "T3D3": 3}
_LINES |= {"CONN2D2": 2, "CONN3D2": 2, "PIPE21": 2, "PIPE22": 3, "PIPE31": 2, "PIPE32": 3}
# What may follow the name of an element: hybrid, offset section, coupled temperature.
_VARIANTS = "HOS"
# Keywords that make nodes and elements out of others.
_GENERATING = ("NGEN", "NFILL", "NCOPY", "NMAP", "ELGEN", "ELCOPY", "SYMMETRIC MODEL GENERATION")
# Keywords whose data may stand in another file.
_WITH_INPUT = ("NODE", "ELEMENT", "NSET", "ELSET")


@dataclass
class _Content:
    """Content of an Abaqus file, by the labels of nodes and elements."""

    nodes: dict[str, list[str]] = field(default_factory=dict)
    elements: dict[str, list[str]] = field(default_factory=dict)
    node_sets: dict[str, list[str]] = field(default_factory=dict)
    element_sets: dict[str, list[str]] = field(default_factory=dict)
    others: set[str] = field(default_factory=set)
    instances: int = 0


def read_abaqus(path: Path) -> LineMesh:
    """Read beams, trusses and connectors of an Abaqus input file, with its sets of nodes and elements.

    A set may list others and grow by several keywords; elements of second order are cut at their middle nodes.

    Raises
    ------
    FrameError
        If the file holds several parts, no line, or an element with an unknown node.
    """
    content = _Content()
    for keyword, options, rows in _blocks(path):
        _take(content, keyword, options, rows, path.name)
    if not content.elements:
        kinds = ", ".join(sorted(content.others)) or "none"
        raise FrameError(f"{path.name} holds no lines (its elements: {kinds}): give a mesh of beams or trusses")
    return _mesh(content, path.name)


def _blocks(path: Path) -> Iterator[tuple[str, dict[str, str], list[list[str]]]]:
    """Keyword, its options and its rows of data, one after the other."""
    keyword, options = "", dict[str, str]()
    rows: list[list[str]] = []
    for line in chain(path.read_text(encoding="utf-8", errors="replace").splitlines(), ["*END"]):
        if line.startswith("**") or not line.strip():
            continue
        if line.startswith("*"):
            if keyword:
                yield keyword, options, rows
            words = [word.strip() for word in line[1:].rstrip(", ").split(",")]
            keyword, rows = words[0].upper(), []
            pairs = [word.partition("=") for word in words[1:]]
            options = {name.strip().upper(): value.strip().strip('"') for name, _, value in pairs}
        else:
            rows.append([word.strip() for word in line.rstrip(", \t").split(",")])


def _take(content: _Content, keyword: str, options: dict[str, str], rows: list[list[str]], source: str) -> None:
    _check_read(content, keyword, options, rows, source)
    if keyword == "NODE":
        labels = [row[0] for row in rows]
        if clash := content.nodes.keys() & set(labels):
            raise FrameError(f"{source}: node {min(clash)} is there twice: give the file of one part")
        content.nodes.update(zip(labels, (row[1:4] for row in rows), strict=True))
        _grow(content.node_sets, options.get("NSET"), labels)
    elif keyword == "ELEMENT":
        kind = options.get("TYPE", "").upper()
        count = _LINES.get(kind) or _LINES.get(kind.rstrip(_VARIANTS))
        if count is None:
            content.others.add(kind)
            return
        if wrong := next((row for row in rows if len(row) != count + 1), None):
            raise FrameError(f"{source}: element {', '.join(wrong)} does not have the {count} nodes of {kind}")
        labels = [row[0] for row in rows]
        if clash := content.elements.keys() & set(labels):
            raise FrameError(f"{source}: element {min(clash)} is there twice: give the file of one part")
        content.elements.update(zip(labels, (row[1:] for row in rows), strict=True))
        _grow(content.element_sets, options.get("ELSET"), labels)
    elif keyword in ("NSET", "ELSET"):
        sets = content.node_sets if keyword == "NSET" else content.element_sets
        _grow(sets, options.get(keyword), _listed(rows, "GENERATE" in options, sets))


def _check_read(content: _Content, keyword: str, options: dict[str, str], rows: list[list[str]], source: str) -> None:
    """Refuse included files, generated nodes or elements, coordinates in other axes, and several instances."""
    if keyword == "INCLUDE" or (keyword in _WITH_INPUT and "INPUT" in options):
        raise FrameError(
            f"{source} includes {options.get('INPUT', 'another file')}: put its lines into the file itself"
        )
    if keyword in _GENERATING:
        raise FrameError(f"{source} has *{keyword}, which makes nodes or elements of others: list them all in the file")
    moved = keyword in ("SYSTEM", "INSTANCE") and rows
    if moved or (keyword == "NODE" and options.get("SYSTEM", "R").upper() != "R"):
        raise FrameError(
            f"{source} has *{keyword} with places in axes of its own: write the coordinates of nodes in global axes"
        )
    content.instances += keyword == "INSTANCE"
    if content.instances > 1:
        raise FrameError(f"{source} has several instances of parts: give the file of one")


def _grow(sets: dict[str, list[str]], name: str | None, labels: list[str]) -> None:
    if name:
        sets.setdefault(name, []).extend(labels)


def _listed(rows: list[list[str]], generate: bool, sets: dict[str, list[str]]) -> list[str]:
    """Labels that the rows of a set list, those of sets that they name among them."""
    if generate:
        steps = [[_whole(word) for word in row if word] for row in rows]
        given = [str(k) for first, last, *step in steps for k in range(first, last + 1, *(step or [1]))]
    else:
        upper = {name.upper(): of for name, of in sets.items()}
        given = [label for row in rows for word in row for label in upper.get(word.upper(), [word])]
    return given


def _whole(word: str) -> int:
    try:
        return int(word)
    except ValueError as error:
        raise FrameError(f"a set is generated from {word!r}: give whole numbers, first, last and step") from error


def _mesh(content: _Content, source: str) -> LineMesh:
    number = {label: k for k, label in enumerate(content.nodes)}
    lines: list[tuple[int, int]] = []
    labels: list[str] = []
    place: dict[str, list[int]] = {}
    for label, nodes in content.elements.items():
        if missing := next((node for node in nodes if node not in number), None):
            raise FrameError(f"{source}: element {label} has the node {missing}, which the file does not hold")
        place[label] = list(range(len(lines), len(lines) + len(nodes) - 1))
        labels += [label] if len(nodes) == 2 else [f"{label}.{k}" for k in range(len(nodes) - 1)]
        lines += [(number[a], number[b]) for a, b in pairwise(nodes)]
    try:
        points = np.array([[float(x) for x in [*of, "0", "0"][:3]] for of in content.nodes.values()])
    except ValueError as error:
        raise FrameError(f"{source}: a node has the coordinates of no number ({error})") from error
    return LineMesh(
        source,
        in_space(points, source),
        np.array(lines, dtype=np.int64),
        _sets(content.element_sets, place),
        _sets(content.node_sets, {label: [k] for label, k in number.items()}),
        point_labels=list(number),
        line_labels=labels,
    )


def _sets(labels: dict[str, list[str]], place: dict[str, list[int]]) -> dict[str, Index]:
    """Sets by numbers, without parts that are no lines or nodes here, such as solids, and without empty sets."""
    found = {name: dict.fromkeys(k for label in of for k in place.get(label, [])) for name, of in labels.items()}
    return {name: np.array(list(numbers), dtype=np.int64) for name, numbers in found.items() if numbers}
