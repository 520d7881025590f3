"""Tolerances of a file overridden or added to by the command line."""

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
        Names and what each deviates by. A name is that of a tolerance of the file, which goes on to vary what it did,
        or of a number such as ``joints.B.clearance``, which leaves the tolerances that it was in.

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
    """Take a number out of the tolerances of a file; one of which nothing is left goes."""
    mine = numbers_at(source, ("tolerances", name), name, relative=False)[1].keys()
    for other in list(source.data["tolerances"]):
        path, table = ("tolerances", other), source.data["tolerances"][other]
        of = table.get("of") if isinstance(table, dict) else [other]
        if not isinstance(of, list) or not all(isinstance(each, str) for each in of):
            continue  # what is wrong with it is told when it is read
        kept = [each for each in of if not mine >= numbers_at(source, path, each, relative=False)[1].keys()]
        if not kept:
            del source.data["tolerances"][other]
        elif kept != of:
            source.data["tolerances"][other] = {**table, "of": kept}
