"""Tolerances of a file's numbers, which are drawn from distributions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from ....framework.batch import Array
from ....framework.errors import FrameError
from ...given_deviations import Deviation, deviation, distributed
from ...given_distributions import is_known
from ..files.read import Described, linkage_of
from ..files.source import Source
from ..files.toml import Path
from .targets import entry_name, numbers_at
from .units import unit_of

if TYPE_CHECKING:
    from ...distributions import Distribution, Uncertain


@dataclass(frozen=True, eq=False)
class Tolerance:
    """Numbers of the file that share one random draw.

    Attributes
    ----------
    of
        Paths of the entries that the tolerance names.
    nominal
        By path: nominal values of the numbers that vary.
    distribution
        Their distribution; if `relative`, that of the deviation as a share of the nominal value.
    relative
        Whether the draw is a deviation that scales each number, rather than the number itself.
    description
        The distribution in words.
    names
        The entries as the file calls them, such as ``points.B.y``.
    unit
        Unit of the draw.
    """

    of: tuple[Path, ...]
    nominal: Mapping[Path, float]
    distribution: Distribution
    relative: bool
    description: str
    names: tuple[str, ...] = ()
    unit: str = ""

    def samples(self, place: Path, draws: Array) -> Array:
        """Samples (n,) of the number at a path, from the draws (n,)."""
        return self.nominal[place] * (1.0 + draws) if self.relative else draws


def tolerances(source: Source) -> dict[str, Tolerance]:
    """Read and check all tolerances of a file, by name."""
    found = {name: tolerance(source, name) for name in source.names(("tolerances",))}
    check_owners(source, found)
    return found


def check_owners(source: Source, found: Mapping[str, Tolerance]) -> None:
    """Refuse two tolerances of one number.

    Raises
    ------
    FrameError
        If a number is in two tolerances; the message names both.
    """
    owners: dict[Path, str] = {}
    for name, each in found.items():
        for place in each.nominal:
            if place in owners:
                source.fail(
                    ("tolerances", name, "of"),
                    f"{entry_name(source, place)} is in tolerance {owners[place]!r}, too: let one distribution draw it",
                )
            owners[place] = name


def varied(
    source: Source, distributions: Mapping[str, Tolerance], draws: Mapping[str, Array], kind: type[Described]
) -> Described:
    """The linkage of a file with samples (n,) in place of the numbers that the tolerances name."""
    samples: dict[Path, Array] = {}
    by: dict[Path, Path] = {}
    for name, values in draws.items():
        for place in distributions[name].nominal:
            samples[place] = distributions[name].samples(place, values)
            by[place] = ("tolerances", name)
    return linkage_of(source.with_samples(samples, by), kind)


def tolerance(source: Source, name: str) -> Tolerance:
    """Read and check one of the file's tolerances: a table, or a deviation under the name of a single number."""
    path = ("tolerances", name)
    found = source.get(path)
    if isinstance(found, str | int | float):
        with source.at(*path):
            return toleranced(source, name, found)
    if not isinstance(found, dict) or "of" not in found or ("distribution" in found) == ("tolerance" in found):
        source.fail(
            path, "give a table with of, distribution and its numbers, or with of and a tolerance such as '± 5 %'"
        )
    of = [((*path, "of", index), text) for index, text in enumerate(source.texts((*path, "of")))]
    if "tolerance" in found:
        source.table(path, ("of", "tolerance"))
        with source.at(*path):
            return _in_words(source, path, of, source.text_at((*path, "tolerance")))
    given = _distribution(source, path)
    places, nominal = _numbers_of(source, of, relative=given.relative)
    return _checked(source, path, places, nominal, given)


def toleranced(source: Source, name: str, given: Uncertain | float) -> Tolerance:
    """Tolerance of one of the source's numbers, given under the name of the number.

    Parameters
    ----------
    source
        The file with the number.
    name
        Name of the number, as for `numbers_at`.
    given
        A distribution as for `propagate`, a deviation from the nominal value in words such as ``"± 5 %"`` or
        ``"+0.2/-0.1"``, or the half width of the interval about the nominal value.
    """
    path = ("tolerances", name)
    return _in_words(source, path, [(path, name)], given)


def _in_words(
    source: Source, path: tuple[str, str], of: Sequence[tuple[Path, str]], given: Uncertain | float
) -> Tolerance:
    """Tolerance of numbers by a deviation in words; `of` are the paths at which they are named, and their names."""
    share = isinstance(given, str) and "%" in given and _deviation(source, path, 1.0, given).relative
    places, nominal = _numbers_of(source, of, relative=share)
    found = _deviation(source, path, next(iter(nominal.values())), given)
    return _checked(source, path, places, nominal, found)


def _deviation(source: Source, path: tuple[str, str], nominal: float, given: Uncertain | float) -> Deviation:
    """How a number deviates; errors of distributions do not name the number, so that its name is put before them."""
    try:
        return deviation(path[1], nominal, given)
    except FrameError as error:
        source.fail(path, f"{given!r} cannot be meant: {error}")


def _numbers_of(
    source: Source, of: Sequence[tuple[Path, str]], *, relative: bool
) -> tuple[tuple[Path, ...], dict[Path, float]]:
    """Paths of entries, and by path the numbers in them."""
    places: list[Path] = []
    nominal: dict[Path, float] = {}
    for path, text in of:
        place, numbers = numbers_at(source, path, text, relative=relative)
        for twice in numbers.keys() & nominal.keys():
            source.fail(path, f"names {entry_name(source, twice)} a second time: name it once")
        places.append(place)
        nominal |= numbers
    return tuple(places), nominal


def _checked(
    source: Source, path: tuple[str, str], places: tuple[Path, ...], nominal: dict[Path, float], found: Deviation
) -> Tolerance:
    """The tolerance, refused if its distribution cannot be meant for these numbers."""
    if not found.relative:
        _check_equal(source, path, nominal, found.description)
    place, value = next(iter(nominal.items()))
    try:
        found.require_near(value, entry_name(source, place))
    except FrameError as error:
        source.fail(path, str(error))
    names = tuple(entry_name(source, place) for place in places)
    units = dict.fromkeys(unit_of(source, each) for each in nominal)
    share = found.relative or "%" in found.description
    unit = "of each number" if share else ", ".join(filter(None, units))
    return Tolerance(places, nominal, found.distribution, found.relative, found.description, names, unit)


def _distribution(source: Source, path: tuple[str, str]) -> Deviation:
    """The distribution given by a table, with its parameters by name."""
    name, numbers = source.text_at((*path, "distribution")), {}
    if not is_known(name):
        source.fail(
            (*path, "distribution"), f"is {name!r}: give a continuous distribution of scipy.stats, such as norm"
        )
    for key in source.table(path, (), tuple(source.get(path))):
        if key not in ("of", "distribution"):
            value = source.get((*path, key))
            numbers[key] = value if isinstance(value, str) else source.number((*path, key))
    try:
        return distributed(name, numbers)
    except FrameError as error:
        key, _, told = str(error).partition(" ")
        source.fail((*path, key) if key in numbers else path, told if key in numbers else str(error))


def _check_equal(source: Source, path: tuple[str, str], nominal: Mapping[Path, float], description: str) -> None:
    """Refuse one absolute draw for numbers with different values, which would all become the same."""
    (first, value), *others = nominal.items()
    for place, other in others:
        if other != value:
            source.fail(
                (*path, "of"),
                f"{entry_name(source, first)} is {value:g} and {entry_name(source, place)} is {other:g}: one draw of "
                f"{description} would "
                "stand in "
                'place of both; give loc and scale in percent, such as scale = "5 %", to vary each about its own '
                "value, or give each a tolerance of its own",
            )
