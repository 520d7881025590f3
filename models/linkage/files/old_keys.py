"""Old spellings of keys in files: they still work for one release, with a warning that names the new ones."""

from __future__ import annotations

import re
import warnings
from collections.abc import Iterator
from typing import Any

Path = tuple[str | int, ...]

# New name by the table and the old one; these tables hold tables by name, or lists of tables.
RENAMED = {("joints", "at"): "reference", ("loads", "follows"): "follower", ("tolerances", "law"): "distribution"}
_ENTRY = re.compile(r"^(joints\..+)\.at(?=\.|$)")


def renew(data: dict[str, Any]) -> dict[Path, Path]:
    """Give old keys their new names.

    Parameters
    ----------
    data
        Tables of the file; they are changed in place.

    Returns
    -------
    dict
        Old paths of keys, as written in the file, by the new ones.
    """
    written: dict[Path, Path] = {}
    for (name, old), new in RENAMED.items():
        for key, table in _tables(data.get(name)):
            if old in table and new not in table:
                table[new] = table.pop(old)
                written[name, key, new] = (name, key, old)
                warnings.warn(
                    f"{name}.{key}.{old} is now called {new}: the old name goes with the next release",
                    FutureWarning,
                    stacklevel=4,
                )
    for _, table in _tables(data.get("tolerances")):
        if isinstance(table.get("of"), list):
            table["of"] = [_ENTRY.sub(r"\1.reference", of) if isinstance(of, str) else of for of in table["of"]]
    return written


def _tables(found: object) -> Iterator[tuple[str | int, dict[str, Any]]]:
    """Tables by their name, or by their index in a list; none if `found` is something else."""
    entries = found.items() if isinstance(found, dict) else enumerate(found) if isinstance(found, list) else ()
    for key, entry in entries:
        if isinstance(entry, dict):
            yield key, entry
