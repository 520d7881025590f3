"""Tolerances of the command line, which replace or add to those of a file."""

from __future__ import annotations

import copy
from collections.abc import Iterable

from ..files.source import Source
from ..study.targets import numbers_at


def with_tolerances(source: Source, given: Iterable[tuple[str, str]]) -> Source:
    """The file with other tolerances.

    Parameters
    ----------
    source
        The file.
    given
        Names and deviations in words. A name is that of a tolerance of the file, which keeps its numbers, or of a
        number such as ``joints.B.clearance``, which is removed from other tolerances.

    Raises
    ------
    FrameError
        If there is neither a tolerance nor a number of that name.
    """
    clone = copy.copy(source)
    clone.data = {**source.data, "tolerances": dict(source.data.get("tolerances", {}))}
    clone.set_by = dict(source.set_by)
    for name, text in given:
        before = clone.data["tolerances"].get(name)
        clone.set_by = {**clone.set_by, ("tolerances", name): f"--tolerance {name}={text}"}
        of = before["of"] if isinstance(before, dict) and "of" in before else [name]
        if before is None:
            _leave_others(clone, name)
        clone.data["tolerances"][name] = {"of": of, "tolerance": text}
    return clone


def _leave_others(source: Source, name: str) -> None:
    """Remove a number from the tolerances of a file, and tolerances that become empty."""
    mine = numbers_at(source, ("tolerances", name), name, relative=False)[1].keys()
    for other in list(source.data["tolerances"]):
        path, table = ("tolerances", other), source.data["tolerances"][other]
        of = table.get("of") if isinstance(table, dict) else [other]
        if not isinstance(of, list) or not all(isinstance(each, str) for each in of):
            continue  # it is refused when it is read
        kept = [each for each in of if not mine >= numbers_at(source, path, each, relative=False)[1].keys()]
        if not kept:
            del source.data["tolerances"][other]
        elif kept != of:
            source.data["tolerances"][other] = {**table, "of": kept}
