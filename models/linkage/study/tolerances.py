"""Tolerances in a file: numbers of it that are drawn from a distribution."""

from __future__ import annotations

import copy
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ....framework.batch import Array
from ....framework.errors import FrameError
from ...given_distributions import called, continuous, distribution_of
from ...given_distributions import tolerance as within
from ..files.read import Described, linkage_of
from ..files.source import Source
from ..files.toml import Path
from .targets import numbers_at

if TYPE_CHECKING:
    from ...distributions import Distribution, Uncertain

PERCENT = re.compile(r"\s*(±?)\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*%\s*(uniform|normal)?\s*")
# Of a distribution within limits, the nominal value may lie at one of them, but not further out than this.
MOST_DEVIATIONS = 3.0
ROUNDING = 1e-9


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
    """

    of: tuple[Path, ...]
    nominal: Mapping[Path, float]
    distribution: Distribution
    relative: bool
    description: str

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
                    f"{dotted(place)} is in tolerance {owners[place]!r}, too: let one distribution draw it",
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
    distribution, relative, description = _distribution(source, path)
    places, nominal = _numbers_of(source, of, relative=relative)
    return _checked(source, path, Tolerance(places, nominal, distribution, relative, description))


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
    if (table := _written_out(source, path, of, given)) is not None:
        return tolerance(table, path[1])
    share = PERCENT.fullmatch(given) if isinstance(given, str) else None
    places, nominal = _numbers_of(source, of, relative=share is not None)
    try:
        distribution, deviates = _given_distribution(path[1], given, next(iter(nominal.values())), share)
    except FrameError as error:
        # What refuses a distribution need not know of which number it was.
        source.fail(path, f"{given!r} cannot be meant: {error}")
    found = Tolerance(places, nominal, distribution, share is not None, str(given))
    return _checked(source, path, found, deviates=deviates)


def _written_out(
    source: Source, path: tuple[str, str], of: Sequence[tuple[Path, str]], given: Uncertain | float
) -> Source | None:
    """The file with a table in place of a distribution that is written as a call; None where it is not."""
    try:
        found = called(given) if isinstance(given, str) else None
    except FrameError as error:
        source.fail(path, str(error))
    if found is None:
        return None
    table = {"of": [text for _, text in of], "distribution": found[0], **found[1]}
    clone = copy.copy(source)
    clone.data = {**source.data, "tolerances": {**source.data.get("tolerances", {}), path[1]: table}}
    return clone


def _given_distribution(
    name: str, given: Uncertain | float, middle: float, share: re.Match[str] | None
) -> tuple[Distribution, bool]:
    """The distribution, and whether it was given by how far it deviates from the nominal value."""
    if share is not None:
        half = 0.01 * float(share[2])
        return within(0.0, f"± {half!r}", share[3] or "uniform"), True
    if isinstance(given, str) and given.strip().startswith(("±", "+")):
        words, _, kind = given.strip().rpartition(" ")
        named = kind in ("uniform", "normal")
        return within(middle, words if named else given, kind if named else "uniform"), True
    if isinstance(given, int | float | np.integer | np.floating) and not isinstance(given, bool):
        width = float(given)
        if not 0.0 < width < np.inf:
            raise FrameError("give a half width above zero, or leave the tolerance out where there is none")
        return distribution_of(name, (middle - width, middle + width)), True
    return distribution_of(name, given), False


def _numbers_of(
    source: Source, of: Sequence[tuple[Path, str]], *, relative: bool
) -> tuple[tuple[Path, ...], dict[Path, float]]:
    """Where entries stand, and the numbers in them by where these stand."""
    places: list[Path] = []
    nominal: dict[Path, float] = {}
    for path, text in of:
        place, numbers = numbers_at(source, path, text, relative=relative)
        for twice in numbers.keys() & nominal.keys():
            source.fail(path, f"names {dotted(twice)} a second time: name it once")
        places.append(place)
        nominal |= numbers
    return tuple(places), nominal


def _checked(source: Source, path: tuple[str, str], found: Tolerance, *, deviates: bool = False) -> Tolerance:
    """A tolerance that can be meant; one that is given by how far it deviates lies where it should."""
    if not found.relative:
        _check_equal(source, path, found.nominal, found.description)
    if not deviates:
        _check_middle(source, path, found.nominal, found.distribution, found.relative, found.description)
    return found


def dotted(place: Path) -> str:
    """A place in the file as it is written there."""
    return ".".join(map(str, place))


def _distribution(source: Source, path: tuple[str, str]) -> tuple[Distribution, bool, str]:
    """The distribution, whether it is relative, and how it reads."""
    distribution = source.text_at((*path, "distribution"))
    numbers, relative = _numbers(source, path)
    try:
        with np.errstate(all="ignore"):
            frozen = continuous(distribution, numbers)
            middle = np.nan if frozen is None else float(frozen.ppf(np.array(0.5)))
    except (TypeError, ValueError) as error:
        source.fail(path, f"{distribution} does not take {', '.join(numbers) or 'nothing'}: {error}")
    if frozen is None:
        source.fail(
            (*path, "distribution"),
            f"is {distribution!r}: give a continuous distribution of scipy.stats, such as norm or uniform",
        )
    if not np.isfinite(middle):
        source.fail(path, f"{distribution} with {numbers} is no distribution: check its numbers")
    if "scale" not in numbers:
        source.fail(
            path, f'has no scale: give one, such as the standard deviation of norm, or scale = "5 %" ({distribution})'
        )
    shown = [f"{key}={100.0 * value:g} %" if key in relative else f"{key}={value:g}" for key, value in numbers.items()]
    return frozen, bool(relative), f"{distribution}({', '.join(shown)})"


def _numbers(source: Source, path: tuple[str, str]) -> tuple[dict[str, float], tuple[str, ...]]:
    """The distribution's numbers by name, and which of them are shares of the nominal value."""
    numbers: dict[str, float] = {}
    relative: list[str] = []
    for key in source.table(path, (), tuple(source.get(path))):
        if key in ("of", "distribution"):
            continue
        value = source.get((*path, key))
        if not isinstance(value, str):
            numbers[key] = source.number((*path, key))
            continue
        share = PERCENT.fullmatch(value)
        if share is None or share[3] or key not in ("loc", "scale") or (share[1] and key == "loc"):
            source.fail((*path, key), f'is {value!r}: give a number, or loc and scale in percent, such as "5 %"')
        numbers[key] = 0.01 * float(share[2])
        relative.append(key)
    for key in ("loc", "scale"):
        if relative and key in numbers and key not in relative:
            source.fail(
                (*path, key),
                f"is {numbers[key]:g} beside {relative[0]} in percent: in percent both are deviations from the nominal "
                "value, so that loc may be left out",
            )
    return numbers, tuple(relative)


def _check_equal(source: Source, path: tuple[str, str], nominal: Mapping[Path, float], description: str) -> None:
    """Refuse one draw in place of different numbers: it would overwrite them by each other."""
    (first, value), *others = nominal.items()
    for place, other in others:
        if other != value:
            source.fail(
                (*path, "of"),
                f"{dotted(first)} is {value:g} and {dotted(place)} is {other:g}: one draw of {description} would "
                "stand in "
                'place of both; give loc and scale in percent, such as scale = "5 %", to vary each about its own '
                "value, or give each a tolerance of its own",
            )


def _check_middle(
    source: Source,
    path: tuple[str, str],
    nominal: Mapping[Path, float],
    distribution: Distribution,
    relative: bool,
    description: str,
) -> None:
    """Refuse a distribution whose mean is further from the nominal value than it spreads."""
    place, value = next(iter(nominal.items()))
    if relative:
        value = 0.0
    mean, spread, limits = _shape(distribution)
    off = abs(value - mean)
    within = limits[0] - ROUNDING * spread <= value <= limits[1] + ROUNDING * spread
    if off <= (1.0 + ROUNDING) * spread or (np.isfinite(limits).all() and within and off <= MOST_DEVIATIONS * spread):
        return
    if relative:
        source.fail(
            path,
            f"{description} deviates by {100.0 * mean:g} % on average, which is more than it spreads "
            f"({100.0 * spread:g} %): "
            "percentages are deviations from the nominal value, so that their mean should be near 0",
        )
    source.fail(
        path,
        f"{description} has the mean {mean:g} and spreads by {spread:g}, but {dotted(place)} is {value:g}: give the "
        "file the "
        "value about which it spreads, or loc and scale in percent, which are deviations from the nominal value",
    )


def _shape(distribution: Any) -> tuple[float, float, Array]:
    """Mean, standard deviation, and limits of a distribution; of one without moments, median and half quartiles."""
    if not all(callable(getattr(distribution, key, None)) for key in ("mean", "std", "support")):
        low, mean, high = (float(distribution.ppf(np.array(p))) for p in (0.25, 0.5, 0.75))
        limits = np.array([float(distribution.ppf(np.array(p))) for p in (0.0, 1.0)])
        return mean, 0.5 * (high - low), limits
    with np.errstate(all="ignore"):
        mean, spread = float(distribution.mean()), float(distribution.std())
        if not np.isfinite([mean, spread]).all():
            low, mean, high = (float(value) for value in distribution.ppf(np.array([0.25, 0.5, 0.75])))
            spread = 0.5 * (high - low)
        return mean, spread, np.asarray(distribution.support(), dtype=np.float64)
