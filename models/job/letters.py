"""Letters of names that the font of the figures does not have."""

from __future__ import annotations

import re
import warnings
from collections.abc import Iterator
from contextlib import contextmanager

GLYPH = re.compile(r"Glyph (\d+) .* missing from")


@contextmanager
def missing_letters() -> Iterator[list[str]]:
    """Fill a list with a sentence on the letters that are drawn as boxes in the body; other warnings go on."""
    notes: list[str] = []
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        yield notes
    letters: dict[str, None] = {}
    for each in caught:
        if found := GLYPH.match(str(each.message)):
            letters[chr(int(found[1]))] = None
        else:
            warnings.warn_explicit(each.message, each.category, each.filename, each.lineno)
    if letters:
        notes.append(
            f"The font of the figures has no {' '.join(letters)}: a box stands in place of each letter; tables, page "
            "and report have them."
        )
