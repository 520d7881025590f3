"""Tolerances in a file: numbers of it that are drawn from a distribution."""

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
        Where the entries stand that the file names.
    nominal
        The numbers that vary, by where they stand.
    distribution
        Their distribution; where `relative`, that of the deviation as a share of the nominal value.
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
        """Samples (n,) of the number at a place, from the draws (n,)."""
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
        With the name of both.
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
    """Read and check one of the file's tolerances: a table, or of a single number by its name what it deviates by."""
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
    """A tolerance of one of the source's numbers that is given under the name of the number.

    Parameters
    ----------
    source
        Where the number stands.
    name
        Its name, as for `numbers_at`.
    given
        What `propagate` takes, a deviation from the nominal value in words such as ``"± 5 %"`` or ``"+0.2/-0.1"``, or
        the half width of the interval about the nominal value.
    """
    path = ("tolerances", name)
    return _in_words(source, path, [(path, name)], given)


def _in_words(
    source: Source, path: tuple[str, str], of: Sequence[tuple[Path, str]], given: Uncertain | float
) -> Tolerance:
    """A tolerance of numbers by where the file names them and their names."""
    try:
        share = isinstance(given, str) and "%" in given and deviation(path[1], 1.0, given).relative
        places, nominal = _numbers_of(source, of, relative=share)
        found = deviation(path[1], next(iter(nominal.values())), given)
    except FrameError as error:
        if str(error).startswith(f"{source.file}"):
            raise
        # What refuses a distribution need not know of which number it was.
        source.fail(path, f"{given!r} cannot be meant: {error}")
    return _checked(source, path, places, nominal, found)


def _numbers_of(
    source: Source, of: Sequence[tuple[Path, str]], *, relative: bool
) -> tuple[tuple[Path, ...], dict[Path, float]]:
    """Where entries stand, and the numbers in them by where these stand."""
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
    """A tolerance that can be meant."""
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
    """The distribution of a table, its numbers by name."""
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
    """Refuse one draw in place of different numbers: it would overwrite them by each other."""
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
