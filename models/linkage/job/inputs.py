"""Inputs of ``linkframe run`` in a file: the linkage, its drives, points to report, and tolerances."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from ....framework.batch import Array
from ....framework.errors import FrameError
from ...job.measured import LEVEL, UNITS, DriveValues, MeasuredPoint
from ...measured.table import read_measured
from ...moments import NAN_POLICIES
from ...sampling import SAMPLERS, Distribution, goes_on
from ..description.joints import driven_name
from ..files.read import linkage_of
from ..files.source import Source, shown_value
from ..files.toml import Path as Place
from ..linkage import Linkage
from ..study.sampled import DrivenPoses
from ..study.single import check_single
from ..study.targets import numbers_at
from ..study.tolerances import Tolerance, tolerances, varied
from .effects import check_clearances, check_effects
from .measured import read_measured_point
from .overridden import with_tolerances

RUN = ("drives", "points", "branch", "tolerance", "samples", "rng", "sampler", "nan_policy", "pose", "magnify", "also")
# Further tables that a file may ask for.
ALSO = ("condition", "digits", "large")
MOST_POSES = 1_000_000
GREATEST = float(np.finfo(np.float64).max)


@dataclass(frozen=True, eq=False)
class Drive(DriveValues):
    """Motion of one driven coordinate.

    Attributes
    ----------
    rate, acceleration
        In its unit per time, and per time squared, () or (poses,).
    """

    rate: Array
    acceleration: Array

    def at(self, pose: int) -> Drive:
        """The drive at one of its poses; a single value is the same at all poses."""
        at = [np.atleast_1d(each) for each in (self.values, self.rate, self.acceleration)]
        values, rate, acceleration = (each[[min(pose, len(each) - 1)]] for each in at)
        return Drive(values, self.unit, rate, acceleration)


@dataclass(frozen=True, eq=False)
class RunInputs:
    """Inputs of a job; made by `read_inputs`.

    Attributes
    ----------
    source
        The file.
    linkage
        The linkage of the file.
    drives
        By driven joint, or by ``joint.coordinate`` if several coordinates of it are driven.
    points
        Points to report.
    branch, tolerance
        As for `Linkage.move`.
    tolerances
        Tolerances by name.
    samples, rng, sampler, nan_policy
        As for `propagate`.
    pose
        Value of the first drive at the pose that the figures show; if None, one is chosen.
    magnify
        Factor on displacements in the figures; if None, one is chosen.
    also
        Further tables, out of `ALSO`: condition numbers, certain digits, large displacement.
    choices
        By name of a choice: other values of numbers of the file, by their path.
    measured
        Measured positions of a point; None if there are none.
    """

    source: Source
    linkage: Linkage
    drives: Mapping[str, Drive]
    points: tuple[str, ...]
    branch: str = "keep"
    tolerance: float = 0.0
    tolerances: Mapping[str, Tolerance] = field(default_factory=dict)
    samples: int = 100
    rng: int = 0
    sampler: str = "random"
    nan_policy: str = "omit"
    pose: float | None = None
    magnify: float | None = None
    also: tuple[str, ...] = ()
    choices: Mapping[str, Mapping[Place, float]] = field(default_factory=dict)
    measured: MeasuredPoint | None = None

    def chosen(self, pose: int, most: int) -> Iterator[tuple[str, RunInputs]]:
        """The inputs at one pose with `most` samples or fewer: unchanged, and with each choice."""
        for name, numbers in {"this run": {}, **self.choices}.items():
            try:
                inputs = inputs_of(self.source.changed(numbers))
            except FrameError as error:
                self.source.fail(("choices", name), f"is refused: {error}")
            inputs = replace(inputs, samples=min(self.samples, most), sampler=self.sampler)
            yield name, inputs.at_pose(pose)

    def at_pose(self, pose: int) -> RunInputs:
        """The inputs at one of the poses, without further tables."""
        drives = {key: drive.at(pose) for key, drive in self.drives.items()}
        return replace(self, drives=drives, pose=None, choices={}, also=(), measured=None)

    def drawn_by(self, sampler: str) -> RunInputs:
        """The same inputs with another sampler; refused if there are no tolerances."""
        if not self.tolerances:
            raise FrameError(f"--sampler {sampler} has no effect, as the file has no tolerances: leave it out")
        return replace(self, sampler=sampler)

    def measured_by(self, path: Path) -> RunInputs:
        """The same inputs with another table of measured positions, of the first point if the file has none."""
        before = self.measured or MeasuredPoint(path, self.points[0], LEVEL, read_measured(path))
        return replace(self, measured=replace(before, file=path, table=read_measured(path)))

    def at_measured_poses(self) -> RunInputs:
        """The inputs for the measured point alone, at the drive values of its table, or else at the poses of the run.

        Raises
        ------
        FrameError
            If the table does not fit the drives, see `MeasuredPoint.drive_values`, or the rates of these vary with the
            pose.
        """
        assert self.measured is not None
        name, drives = self.measured.file.name, dict(self.drives)
        for key, values in self.measured.drive_values(self.drives).items():
            drive = self.drives[key]
            rate, gain = (_steady(name, key, each) for each in (drive.rate, drive.acceleration))
            drives[key] = Drive(values, drive.unit, rate, gain)
        points = (self.measured.point,)
        return replace(self, drives=drives, points=points, pose=None, also=(), choices={}, measured=None)

    @property
    def first(self) -> Drive:
        """The first drive, whose values name the poses."""
        return next(iter(self.drives.values()))

    @property
    def driven_poses(self) -> DrivenPoses:
        """Values, rates and accelerations of the drives, by joint."""
        parts = (lambda drive: drive.values), (lambda drive: drive.rate), (lambda drive: drive.acceleration)
        values, rates, gains = (self.numbers(part) for part in parts)
        return DrivenPoses(values, rates, gains, self.branch, self.tolerance)

    @property
    def uncertain(self) -> bool:
        """Whether there are samples."""
        return bool(self.tolerances)

    @property
    def about(self) -> dict[str, object]:
        """All inputs on which the samples depend, by table of the file.

        The number of samples is not among them if their sequence can be continued.
        """
        others = ("title", "run", "choices", "measured")
        tables = {f"[{name}]": table for name, table in self.source.data.items() if name not in others}
        measured = None if self.measured is None else self.measured.about
        of_run = {"[run.drives]": self.source.get(("run", "drives")), "points": self.points, "rng": self.rng}
        of_run |= {name: getattr(self, name) for name in ("branch", "tolerance", "sampler", "nan_policy")}
        if not goes_on(self.sampler):
            of_run["samples"] = self.samples
        return tables | of_run | {"digits": "digits" in self.also, "the measured poses": measured}

    @property
    def moves(self) -> bool:
        """Whether a rate or an acceleration is given, so that inertia forces act."""
        return any(np.any(drive.rate) or np.any(drive.acceleration) for drive in self.drives.values())

    @property
    def distributions(self) -> dict[str, Distribution]:
        """Distributions of the tolerances, by name."""
        return {name: tolerance.distribution for name, tolerance in self.tolerances.items()}

    @property
    def driven(self) -> list[tuple[str, str, str]]:
        """Joint, coordinate, and name in the tables, of each driven coordinate in the order of the linkage."""
        return [(j, c, driven_name(j, c, own)) for j, own in self.linkage.drives.items() for c in own]

    def numbers(self, what: Callable[[Drive], Array]) -> dict[str, Array]:
        """Values or rates of the drives by joint, as for `Linkage.move`: () or (poses,), or (..., f) for several."""
        out = {}
        for joint, driven in self.linkage.drives.items():
            own = [self.drives[driven_name(joint, name, driven)] for name in driven]
            each = np.broadcast_arrays(*(drive.factor * what(drive) for drive in own))
            out[joint] = np.stack(each, axis=-1) if len(driven) > 1 else each[0]
        return out

    def varied(self, draws: Mapping[str, Array]) -> Linkage:
        """The linkage with samples (n,) in place of the numbers that the tolerances name."""
        return varied(self.source, self.tolerances, draws, Linkage)


def read_inputs(path: Path, tolerances: Iterable[tuple[str, str]] = ()) -> RunInputs:
    """Read the file of a job, and check all of it.

    Parameters
    ----------
    path
        The file.
    tolerances
        Tolerances that replace those of the file or are added, as for `with_tolerances`.

    Raises
    ------
    FrameError
        If something is wrong; the message names the line and the key.
    """
    return inputs_of(with_tolerances(Source(path), tolerances) if tolerances else Source(path))


def inputs_of(source: Source) -> RunInputs:
    """Inputs of a file, checked; see `read_inputs`."""
    linkage = linkage_of(source, Linkage)
    if not isinstance(source.data.get("run", {}), dict):
        source.fail(("run",), "is not a table: give [run]")
    run = source.table(("run",), (), RUN) if "run" in source.data else {}
    for joint in linkage.drives:
        if joint not in source.names(("run", "drives")):
            source.fail(("run",), f"joint {joint!r} is driven: give its values in [run.drives.{joint}]")
    drives: dict[str, Drive] = {}
    for name in source.names(("run", "drives")):
        drives |= _drives(source, linkage, name)
    if not drives:
        source.fail(("run",), "moves nothing: drive a joint, and give its values in [run.drives.joint]")
    _check_lengths(source, drives)
    check_single(source, linkage, ("run",))
    points = tuple(source.texts(("run", "points"))) if "points" in run else _loaded(linkage)
    for index, point in enumerate(points):
        if point not in linkage.points:
            source.fail(("run", "points", index), f"there is no point {point!r}: choose of {', '.join(linkage.points)}")
        if not any(point in link.points for link in linkage.links.values()):
            source.fail(
                ("run", "points", index), f"no link has the point {point!r}: add it to the link that carries it"
            )
        if point in points[:index]:
            source.fail(("run", "points", index), f"names {point!r} a second time: name each point once")
    given: dict[str, Any] = {}
    for key, kind, wanted in (
        ("samples", int, "a whole number, 2 or more"),
        ("rng", int, "a whole number, 0 or more"),
        ("pose", float, "a value of the first drive"),
        ("tolerance", float, "a length, 0 or more"),
        ("magnify", float, "a number above zero"),
    ):
        if key in run:
            given[key] = _number(source, ("run", key), kind, wanted)
    for key, among in (("branch", ("keep", "switch")), ("sampler", SAMPLERS), ("nan_policy", NAN_POLICIES)):
        if key in run:
            given[key] = source.text_at(("run", key), among)
    if "also" in run:
        given["also"] = tuple(source.texts(("run", "also")))
        for index, each in enumerate(given["also"]):
            if each not in ALSO:
                source.fail(("run", "also", index), f"there is no further table {each!r}: choose of {', '.join(ALSO)}")
    given["choices"] = _choices(source)
    given["measured"] = read_measured_point(source, linkage, points)
    distributions = tolerances(source)
    check_effects(source, linkage, distributions)
    check_clearances(source, linkage)
    return RunInputs(source, linkage, drives, points, tolerances=distributions, **given)


def _drives(source: Source, linkage: Linkage, joint: str) -> dict[str, Drive]:
    """Drives of the coordinates of a joint, by their names in the tables."""
    path = ("run", "drives", joint)
    if joint not in linkage.drives:
        source.fail(path, f"the joint is not driven: the drives are {', '.join(linkage.drives) or 'none'}")
    driven = linkage.drives[joint]
    if len(driven) == 1:
        return {joint: _drive(source, path, driven[0])}
    source.table(path, driven)
    return {driven_name(joint, name, driven): _drive(source, (*path, name), name) for name in driven}


def _drive(source: Source, path: tuple[str, ...], coordinate: str) -> Drive:
    table = source.table(path, (), ("start", "stop", "steps", "values", "unit", "rate", "acceleration"))
    turns = coordinate.startswith("r")
    unit = source.text_at((*path, "unit"), UNITS if turns else ()) if "unit" in table else "rad" if turns else ""
    if "values" in table:
        values = np.atleast_1d(source.numbers((*path, "values")))
        if values.ndim > 1 or not values.size or not np.isfinite(values).all():
            source.fail((*path, "values"), f"is {shown_value(table['values'])}: give finite numbers, one a pose")
        for key in ("start", "stop", "steps"):
            if key in table:
                source.fail((*path, key), "has no effect beside values: give values, or start, stop and steps")
    else:
        for key in ("start", "stop", "steps"):
            if key not in table:
                source.fail(path, f"has no {key}: give start, stop and steps, or values")
        steps = int(_number(source, (*path, "steps"), int, "a whole number of poses, 1 or more"))
        start, stop = (float(_number(source, (*path, key), float, "a number")) for key in ("start", "stop"))
        if steps == 1 and start != stop:
            source.fail((*path, "steps"), f"is 1, a single pose from {start:g} to {stop:g}: give 2 or more, or values")
        values = np.linspace(start, stop, steps)
    speeds = []
    for key in ("rate", "acceleration"):
        speeds.append(source.numbers((*path, key)) if key in table else np.zeros(()))
        if not np.isfinite(speeds[-1]).all():
            source.fail((*path, key), f"is {shown_value(table[key])}: give finite numbers")
        if speeds[-1].shape not in ((), values.shape):
            source.fail((*path, key), f"has shape {speeds[-1].shape}: give one number, or {len(values)}, one a pose")
    return Drive(values, unit, *speeds)


def _steady(name: str, drive: str, rate: Array) -> Array:
    """A rate that is constant, and so known at measured poses, ()."""
    if rate.ndim and np.ptp(rate):
        raise FrameError(
            f"{name} has poses of its own, and drive {drive} a rate or acceleration for each pose of the run: give one "
            "number for all poses"
        )
    return rate.reshape(-1)[:1].reshape(())


def _check_lengths(source: Source, drives: Mapping[str, Drive]) -> None:
    counts = {name: len(drive.values) for name, drive in drives.items() if len(drive.values) > 1}
    for name, count in counts.items():
        first = next(iter(counts))
        if count != counts[first]:
            source.fail(("run", "drives", name), f"has {count} poses, but {first} has {counts[first]}: give as many")


def _number(source: Source, path: tuple[str | int, ...], kind: type, wanted: str) -> float:
    value = source.get(path)
    good = isinstance(value, int | float) and not isinstance(value, bool) and bool(abs(value) <= GREATEST)
    if kind is int:
        least = {"samples": 2, "steps": 1}.get(str(path[-1]), 0)
        good = good and isinstance(value, int) and value >= least
    if path[-1] == "steps" and good and value > MOST_POSES:
        source.fail(path, f"is {value}: give at most {MOST_POSES} poses")
    if not good or (path[-1] == "magnify" and value <= 0.0) or (path[-1] == "tolerance" and value < 0.0):
        source.fail(path, f"is {shown_value(value)}: give {wanted}")
    return kind(value)  # type: ignore[no-any-return]


def _choices(source: Source) -> dict[str, dict[Place, float]]:
    """By choice of a file: other values of its numbers, by their path."""
    found: dict[str, dict[Place, float]] = {}
    for name in source.names(("choices",)):
        table = source.get(("choices", name))
        if not isinstance(table, dict) or not table:
            source.fail(("choices", name), 'give a table of numbers, such as "sections.flat.y" = 0.00635')
        found[name] = {}
        for key in table:
            value = source.number(("choices", name, key))
            numbers = numbers_at(source, ("choices", name, key), key, relative=False)[1]
            found[name] |= dict.fromkeys(numbers, value)
    return found


def _loaded(linkage: Linkage) -> tuple[str, ...]:
    """Points with a load; if there are none, the last point of the last link."""
    loaded = dict.fromkeys(load.point for load in linkage.loads if load.point is not None)
    return tuple(loaded) or (next(reversed(linkage.links.values())).points[-1],)
