"""Series for ParaView: named blocks of each pose, with the names of their parts, and the collection of all poses."""

from __future__ import annotations

import base64
import sys
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

import numpy as np

from .guide import write_guide
from .scene import Part
from .vtu import write_grid

# What stands in an attribute of XML for letters that end it, begin a tag, or are read as blanks; as in
# xml.sax.saxutils, which loads all that opens web pages.
_ESCAPED = str.maketrans(
    {"&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;", "\n": "&#10;", "\r": "&#13;", "\t": "&#9;"}
)


def write_series(path: Path, parts: Sequence[Part], times: Sequence[float], names: Mapping[str, Sequence[str]]) -> None:
    """Write a .pvd, and beside it, in a folder of its name, its poses.

    Parameters
    ----------
    path
        The .pvd, which lists for each time a .vtm.
    parts
        Blocks of a pose, each a .vtu.
    times
        Time of each pose.
    names
        Names of the ``member``, ``link`` and ``joint`` of each number, which each .vtm holds as the strings
        ``member_names`` and so on.
    """
    digits = max(3, len(str(len(times) - 1)))
    folder = path.parent / path.stem
    folder.mkdir()
    fields = [_strings(f"{kind}_names", of) for kind, of in names.items() if of]
    rows = []
    for pose, time in enumerate(times):
        blocks = {part.name: f"{part.name}_{pose:0{digits}d}.vtu" for part in parts}
        for part in parts:
            write_grid(folder / blocks[part.name], [part], pose)
        file = f"pose_{pose:0{digits}d}.vtm"
        _write_blocks(folder / file, blocks, fields)
        rows.append((time, f"{path.stem}/{file}"))
    write_guide(folder, path.name, parts, names)
    write_collection(path, rows)


def write_collection(path: Path, files: Iterable[tuple[float, str]]) -> None:
    """Write a .pvd that lists `files`: time, path relative to the .pvd."""
    rows = [
        f'<DataSet timestep="{time!r}" group="" part="0" file="{file.translate(_ESCAPED)}"/>' for time, file in files
    ]
    lines = ['<?xml version="1.0"?>', '<VTKFile type="Collection" version="0.1">', "<Collection>", *rows]
    path.write_text("\n".join([*lines, "</Collection>", "</VTKFile>", ""]), encoding="utf-8")


def _write_blocks(path: Path, blocks: Mapping[str, str], fields: Sequence[str]) -> None:
    """Write a .vtm of named blocks, with arrays of strings."""
    order = "LittleEndian" if sys.byteorder == "little" else "BigEndian"
    kind = f'type="vtkMultiBlockDataSet" version="1.0" byte_order="{order}" header_type="UInt32"'
    rows = [f'<DataSet index="{k}" name="{name}" file="{file}"/>' for k, (name, file) in enumerate(blocks.items())]
    lines = ['<?xml version="1.0"?>', f"<VTKFile {kind}>", "<vtkMultiBlockDataSet>", *rows, "</vtkMultiBlockDataSet>"]
    path.write_text("\n".join([*lines, "<FieldData>", *fields, "</FieldData>", "</VTKFile>", ""]), encoding="utf-8")


def _strings(name: str, values: Sequence[str]) -> str:
    """An array of strings as VTK reads it: each ended by a zero, all behind their number of bytes."""
    data = b"".join(value.encode() + b"\0" for value in values)
    text = base64.b64encode(np.uint32(len(data)).tobytes() + data).decode()
    return f'<Array type="String" Name="{name}" NumberOfTuples="{len(values)}" format="binary">{text}</Array>'
