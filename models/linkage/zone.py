"""Probability that a point of a linkage leaves its zone."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Collection, Mapping
from dataclasses import replace
from functools import cached_property
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...framework.batch import Array
from ...framework.error_bounds.sensitivity import weighed_sum
from ...framework.errors import FrameError, expected_mechanisms
from ..distributions import Distribution, Uncertain
from ..failure.reliability import Reliability, reliability
from ..given_distributions import distributions_of
from ..quantiles import at_scores
from .derivatives.built import DescribedBeside, DescribedNumbers, along_inputs
from .derivatives.displacement_sensitivity import check
from .derivatives.loaded_place import LoadedPlace
from .derivatives.position_sensitivity import position_sensitivity
from .description.parts import Pair
from .graphics.reaction_plots import over_first_drive
from .poses.coordinates import some_coordinates
from .poses.kinematics import Kinematics
from .statics.accuracy import accuracy, nodes_of_links
from .statics.frame import FramedPoses, is_even

# Number of starting points of the search for design points: the gradient is zero at the middle of the zone, and failure
# is possible in all directions.
STARTS = 5
# Step of the differences of the description by the inputs, as a share of their deviation.
STEP = 0.01
# Option for derivatives by adjoints, and number of inputs above which adjoints take less time than differences of
# solutions under load: a further solution in a batch takes about a hundredth of the adjoints' time.
ADJOINT, MANY = "adjoint", 100


class Movable(DescribedNumbers, Protocol):
    """A linkage that can be moved."""

    def move(self, drives: Mapping[str, ArrayLike], /) -> FramedPoses:
        """Motion at values of the drives."""


Build = Callable[..., Movable]


def check_build(build: object, names: Collection[str]) -> None:
    """Refuse a function that cannot be called with inputs of these names."""
    given = ", ".join(names)
    if not callable(build):
        raise FrameError(f"build is {build!r}: give a function of {given} that returns the linkage")
    try:
        inspect.signature(build).bind(**dict.fromkeys(names))
    except ValueError:  # functions that are not written in Python may have no signature
        return
    except TypeError as error:
        raise FrameError(
            f"build takes {inspect.signature(build)}, but is called with {given} by name ({error}): name them alike"
        ) from None


def built(build: Build, dimensions: Mapping[str, Array]) -> Movable:
    """The linkage that `build` returns for some dimensions, checked."""
    found = build(**dimensions)
    if not hasattr(found, "move"):
        raise FrameError(f"build returned {found!r}: return the linkage that it describes")
    return found


def reliability_of(
    motion: FramedPoses,
    point: str,
    limit: float,
    build: Build,
    distributions: Mapping[str, Uncertain],
    compliance: bool,
    **options: Any,
) -> Reliability:
    """Probability that a point leaves a ball about its nominal position; see `Motion.reliability`."""
    margin = _Margin(motion, point, limit, build, distributions, compliance)
    own = {"starts": STARTS, "gradient": margin.gradient, **options}
    if own["gradient"] == ADJOINT:
        own["gradient"] = margin.by_adjoint()
    found = reliability(margin, distributions, poses=motion.shape[0] if motion.shape else None, **own)
    if not motion.shape:
        return found
    values, label, _ = over_first_drive(motion, np.arange(motion.shape[0]), "m")
    return replace(found, along=values, along_label=label)


def check_radius(point: str, limit: float) -> None:
    """Refuse a radius of a zone that is not positive and finite."""
    if not (np.ndim(limit) == 0 and np.isfinite(limit) and limit > 0.0):
        raise FrameError(f"limit of point {point!r} is {limit!r}: give the radius of its zone, a length above zero")


def check_zone(motion: FramedPoses, point: str, limit: float, compliance: bool) -> None:
    """Refuse a zone whose radius is not valid, or that has no middle at some pose."""
    if len(motion.shape) > 1:
        raise FrameError(f"reliability of a motion of shape {motion.shape}: give it one axis of poses")
    check_radius(point, limit)
    lost = np.flatnonzero(np.isnan(np.atleast_2d(motion.position(point))).any(axis=-1))
    if lost.size:
        raise FrameError(
            f"the nominal motion has no position of {point!r} at pose number {lost[0]}, where it cannot be assembled: "
            "leave that pose out"
        )
    if not compliance:
        return
    lost = np.flatnonzero(np.isnan(np.atleast_2d(loaded_position(motion, point))).any(axis=-1))
    if lost.size:
        raise FrameError(
            f"the nominal motion under its loads has no displacement of {point!r} at pose number {lost[0]}: "
            "leave that pose out, or ask for the rigid position with compliance=False"
        )


def loaded_position(motion: FramedPoses, point: str) -> Array:
    """Position of a point displaced by the linkage's loads, with compliance and clearance, (..., 3)."""
    found = accuracy(motion, point, None, {}, inertia=False)
    with expected_mechanisms():
        return np.asarray(found.rigid + found.total[..., :3])


def loaded_slopes(motion: FramedPoses, point: str, weight: Array, beside: DescribedBeside) -> dict[str, Array] | None:
    """Derivatives (m,) of a weighted sum of the components of `loaded_position`, by each input.

    None if adjoints are not available: with clearances, springs or follower loads, if axes of joints, Poisson's ratio,
    gravity or densities under gravity depend on an input, or if a spherical joint of a rod between two of them is
    equally stiff in all directions at the inputs only, as its springs are along the rod otherwise.

    Parameters
    ----------
    motion
        Motion of the linkage built from the inputs, (m,).
    point
        Name of the point.
    weight
        Weights of the components, (m, 3).
    beside
        The linkage described with lower and upper inputs.
    """
    linkage, bare = motion.linkage, motion.bare
    if any(pair.clearance is not None and np.any(pair.clearance) for pair in linkage.joints.values()):
        return None
    members = {name: [member for member, *_ in pieces] for name, pieces in bare.pieces.items()}
    if any(len(members.get(name, ())) != len(link.beams) for name, link in linkage.links.items()):
        return None
    if any(_becomes_uneven(linkage.joint(name), beside.description.joints[name]) for name in bare.spins):
        return None
    try:
        check(linkage)
        with expected_mechanisms():
            found = accuracy(motion, point, None, {}, inertia=False)
            each = [found.closed.sensitivity(found.point, component) for component in ("ux", "uy", "uz")]
            along = weighed_sum(each, weight)
            return LoadedPlace(motion, point, weight, along, members, nodes_of_links(motion)).along_inputs(beside)
    except FrameError:  # some part of the linkage has no derivatives
        return None


def _becomes_uneven(pair: Pair, beside: Pair) -> bool:
    """Whether a spherical joint is equally stiff in all directions at the inputs, but not at lower or upper ones."""
    if pair.stiffness is None or beside.stiffness is None:
        return pair.stiffness is not beside.stiffness
    return is_even(pair.stiffness) and not is_even(beside.stiffness)


def share_left(
    motion: FramedPoses,
    point: str,
    limit: float,
    build: Build,
    distributions: Mapping[str, Uncertain],
    compliance: bool,
) -> tuple[Callable[..., Array], Callable[..., tuple[Array, dict[str, Array]]] | None]:
    """Limit state function divided by the radius of the zone, and that with its derivatives, None if there are none.

    It is dimensionless, as other programs compare it with absolute tolerances.
    """
    margin = _Margin(motion, point, limit, build, distributions, compliance)

    def share(samples: Mapping[str, Array], pose: NDArray[np.int64] | None = None) -> Array:
        return margin(samples, pose) / margin.limit

    def slopes(samples: Mapping[str, Array], pose: NDArray[np.int64] | None = None) -> tuple[Array, dict[str, Array]]:
        left, by_input = margin.with_gradient(samples, pose)
        return left / margin.limit, {name: values / margin.limit for name, values in by_input.items()}

    return share, slopes if margin.gradient else None


class _Margin:
    """Limit state function ``(limit² - off²) / limit`` of the distance ``off``, smooth at the middle of the zone."""

    def __init__(
        self,
        motion: FramedPoses,
        point: str,
        limit: float,
        build: Build,
        distributions: Mapping[str, Uncertain],
        compliance: bool = False,
    ) -> None:
        check_zone(motion, point, limit, compliance)
        self.compliance = compliance
        self.point, self.limit, self.build = point, float(limit), build
        self.nominal = motion.position(point)
        self.drives = {name: driven_values(motion, name) for name in motion.linkage.drives}
        self.distributions = distributions_of(distributions)
        self.reach = {name: _reach(distribution) for name, distribution in self.distributions.items()}
        check_build(build, self.reach)

    def __call__(self, samples: Mapping[str, Array], pose: NDArray[np.int64] | None = None) -> Array:
        return self._margin(self._off(self._moved(samples, pose), pose))

    @property
    def gradient(self) -> Callable[..., tuple[Array, dict[str, Array]]] | None:
        """`with_gradient`; None if differences of solutions take less time, or adjoints are not available."""
        if self.compliance and (len(self.reach) < MANY or not self._offered):
            return None
        return self.with_gradient

    def by_adjoint(self) -> Callable[..., tuple[Array, dict[str, Array]]]:
        """`with_gradient`, refused if adjoints are not available."""
        if self.compliance and not self._offered:
            raise FrameError(
                f"gradient={ADJOINT!r}: the displacement of {self.point!r} has no adjoint derivatives by all inputs, "
                "as with clearances, springs, loads that turn with links, or axes of joints, Poisson's ratio or "
                "gravity that vary: leave gradient out, so that differences of solutions are taken"
            )
        return self.with_gradient

    @cached_property
    def _offered(self) -> bool:
        """Whether adjoints give the derivatives at the medians of the inputs."""
        median = {name: np.atleast_1d(at_scores(each, np.zeros(1))) for name, each in self.distributions.items()}
        pose = np.zeros(1, dtype=np.int64) if self.nominal.ndim > 1 else None
        return self._linearised(median, pose)[1] is not None

    def with_gradient(
        self, samples: Mapping[str, Array], pose: NDArray[np.int64] | None = None
    ) -> tuple[Array, dict[str, Array]]:
        """Limit state function (m,) and its derivatives by the inputs, with one motion for each of m samples."""
        left, slopes = self._linearised(samples, pose)
        return left, self._differences(samples, pose) if slopes is None else slopes

    def _linearised(
        self, samples: Mapping[str, Array], pose: NDArray[np.int64] | None
    ) -> tuple[Array, dict[str, Array] | None]:
        """Limit state function (m,) and its derivatives by adjoints, None if these are not available."""
        motion, ends = self._moved(samples, pose), self._ends(samples)
        off = self._off(motion, pose)
        weight = np.broadcast_to(-2.0 * off / self.limit, (len(next(iter(samples.values()))), 3))
        if not self.compliance:
            by = position_sensitivity(motion, self.point)
            return self._margin(off), along_inputs(by, weight, self.build, samples, ends)
        return self._margin(off), loaded_slopes(
            motion, self.point, weight, DescribedBeside.of(self.build, samples, ends)
        )

    def _differences(self, samples: Mapping[str, Array], pose: NDArray[np.int64] | None) -> dict[str, Array]:
        """Derivatives by the inputs from differences of solutions."""
        out = {}
        for name, (lower, upper) in self._ends(samples).items():
            below, above = (self({**samples, name: end}, pose) for end in (lower, upper))
            out[name] = (above - below) / np.where(upper > lower, upper - lower, 1.0)
        return out

    def _moved(self, samples: Mapping[str, Array], pose: NDArray[np.int64] | None) -> FramedPoses:
        at = () if pose is None else pose
        drives = {name: values[at] for name, values in self.drives.items()}
        if self.compliance and pose is None:
            # one pose for each sample, even if no input changes the motion
            count = len(next(iter(samples.values())))
            drives = {name: np.broadcast_to(values, (count, *values.shape)) for name, values in drives.items()}
        return built(self.build, samples).move(drives)

    def _off(self, motion: FramedPoses, pose: NDArray[np.int64] | None) -> Array:
        place = loaded_position(motion, self.point) if self.compliance else motion.position(self.point)
        return np.asarray(place - self.nominal[() if pose is None else pose])

    def _margin(self, off: Array) -> Array:
        left: Array = self.limit - np.sum(off * off, axis=-1) / self.limit
        return left

    def _ends(self, samples: Mapping[str, Array]) -> dict[str, tuple[Array, Array]]:
        """Values a little below and above the samples, within the range of the inputs, (m,) each."""
        out = {}
        for name, values in samples.items():
            deviation, low, high = self.reach[name]
            step = STEP * deviation
            out[name] = np.maximum(values - step, low), np.minimum(values + step, high)
        return out


def _reach(distribution: Distribution) -> tuple[float, float, float]:
    """Deviation of an input, half the distance of its values at scores -1 and 1, and its least and largest value."""
    lower, upper = np.asarray(at_scores(distribution, np.array([-1.0, 1.0])), dtype=np.float64)
    least, greatest = np.asarray(distribution.ppf(np.array([0.0, 1.0])), dtype=np.float64)
    return float(0.5 * (upper - lower)), float(least), float(greatest)


def driven_values(motion: Kinematics, name: str) -> Array:
    """Values of a drive as for `Linkage.move`, (...) or (..., f)."""
    values = some_coordinates(motion, name, motion.linkage.drives[name])
    return values[..., 0] if values.shape[-1] == 1 else values
