"""A linkage in Python as the tables of its file, which give its numbers names."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path as File
from typing import Any

from ....framework.errors import FrameError
from ..description.linkage_description import LinkageDescription
from ..files.parsing import parsed
from ..files.source import Source
from ..files.toml import Path, written
from ..files.write import tables
from .single import check_single
from .tolerances import Tolerance, check_owners, tolerance, toleranced


class DescribedLinkage(Source):
    """A linkage as the tables of its file.

    Parameters
    ----------
    linkage
        The linkage.
    given
        Its tolerances by name.

    Raises
    ------
    FrameError
        If the linkage has parts that a file cannot describe.
    """

    def __init__(self, linkage: LinkageDescription, given: Mapping[str, object]) -> None:
        try:
            text = written(tables(linkage))
        except FrameError as error:
            raise FrameError(f"a study varies the numbers that the file of a linkage has, and {error}") from error
        self.file, self.text = File("study"), ""
        self.data: dict[str, Any] = parsed(text)
        self.data["tolerances"] = {name: dict(each) for name, each in given.items() if isinstance(each, Mapping)}
        self.written, self.samples, self.by, self.set_by = {}, {}, {}, {}

    def place(self, path: Path) -> str:
        """Name of a key, in words."""
        return f"{self.file}, {'.'.join(map(str, path))}"


def described(
    linkage: LinkageDescription, given: Mapping[str, Any], *, some: bool = True
) -> tuple[Source, dict[str, Tolerance]]:
    """The linkage as a source, and its checked tolerances.

    Each tolerance is a table as in a file, or another value under the name of a number.

    Parameters
    ----------
    linkage
        The linkage.
    given
        The tolerances.
    some
        Whether at least one tolerance is required.

    Raises
    ------
    FrameError
        If there is no such number, a number is in two tolerances, or a value is not a tolerance.
    """
    if not isinstance(given, Mapping) or (some and not given):
        raise FrameError(
            f"study was given {given!r} for tolerances: give a mapping of numbers of the linkage to what they deviate "
            'by, such as {"joints.B.clearance": "± 5 %"}'
        )
    source = DescribedLinkage(linkage, given)
    check_single(source, linkage, ("linkage",))
    found = {
        name: tolerance(source, name) if isinstance(each, Mapping) else toleranced(source, name, each)
        for name, each in given.items()
    }
    check_owners(source, found)
    return source, found
