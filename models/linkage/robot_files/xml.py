"""Write XML, with one element a line and numbers that read back to the same bits."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

import numpy as np

from ....framework.batch import Array
from ....framework.errors import FrameError

Number = float | Sequence[float] | Array


def written(number: Number) -> str:
    """A number, or several separated by blanks, each with the fewest digits that read back to the same bits."""
    return " ".join(map(_written, np.atleast_1d(np.asarray(number, dtype=np.float64)).tolist()))


def _written(value: float) -> str:
    return repr(int(value)) if value.is_integer() and abs(value) < 1e15 else repr(value)


def add(parent: Element, tag: str, **attributes: str | Number) -> Element:
    """Add an element; numbers among its attributes are written so that they read back to the same bits."""
    texts = {key.rstrip("_"): value if isinstance(value, str) else written(value) for key, value in attributes.items()}
    return SubElement(parent, tag, texts)


def note(parent: Element, text: str) -> None:
    """Add a comment."""
    parent.append(ElementTree.Comment(f" {text.replace('--', '- -')} "))


def check_unique(names: Sequence[str], what: str) -> None:
    """Refuse names that are not unique.

    Raises
    ------
    FrameError
        If a name occurs twice; the message names it.
    """
    for name, count in Counter(names).items():
        if count > 1:
            raise FrameError(f"two {what} of the file would be called {name!r}: rename the link, joint or point")


def document(root: Element) -> str:
    """The text of a file."""
    ElementTree.indent(root)
    return f'<?xml version="1.0" encoding="utf-8"?>\n{ElementTree.tostring(root, encoding="unicode")}\n'
