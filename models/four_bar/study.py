"""Monte Carlo of the four-bar's accuracy: samples of every uncertain parameter, all poses, one solve."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...framework.batch import finite
from ...framework.errors import FrameError
from ..job.parts import Parts, cuts
from ..moments import checked_policy
from ..sampling import Distribution, Sampler, Seed, draw
from ..spread import SampleStatistics, Spread
from .description import LOADS, PerJoint
from .displacement import OPEN_LOOP, Accuracy, accuracy
from .four_bar import FourBar
from .tolerances import LENGTHS, check_names, check_overwritten, per_joint, toleranced

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Study(SampleStatistics):
    """Displacement of the coupler point P from its nominal position, sampled; made by `monte_carlo`.

    The statistics are those of `total`; each part of it has its own, as a `Spread` of samples (poses, n, 3). Poses
    whose `status` is not regular have NaN.

    Attributes
    ----------
    nominal
        Accuracy of the linkage without uncertainty, (poses,).
    parts
        Results of the samples at the poses in `kept`, (poses kept, n).
    inputs
        Samples of the uncertain parameters, (n,) each.
    kept
        Where samples were taken, (poses,): the nominal linkage is regular, and so is every sample, or with the policy
        ``"omit"`` some.
    valid
        Samples that can be assembled and are not singular, (poses kept, n); the others are NaN.
    excluded
        Status of the poses at which not every sample is valid, (poses,).
    n
        Number of samples.
    exact
        Whether `total` takes the exact clearance displacement, or that of first order.
    nan_policy
        Whether statistics ``"omit"`` samples that are NaN, ``"propagate"`` them, or ``"raise"``.
    """

    nominal: Accuracy
    parts: Parts
    inputs: Mapping[str, Array]
    kept: NDArray[np.bool_]
    valid: NDArray[np.bool_]
    excluded: NDArray[np.str_]
    n: int
    exact: bool
    nan_policy: str = "omit"

    @property
    def theta(self) -> Array:
        """Nominal drive angles, radians, (poses,)."""
        return self.nominal.motion.theta

    @property
    def rigid(self) -> Array:
        """Nominal position of P, (poses, 3)."""
        return self.nominal.rigid

    @property
    def sampled(self) -> Accuracy:
        """Accuracy of all samples at the poses in `kept`, (poses kept, n)."""
        return self.some(slice(None))

    def some(self, cut: slice) -> Accuracy:
        """Accuracy of some of the samples at the poses in `kept`, (poses kept, some).

        Parameters
        ----------
        cut
            Range of the sample numbers.

        Returns
        -------
        Accuracy
            Displacements, (poses kept, some, 3), computed when read.
        """
        found = self.parts.make(cut)
        assert isinstance(found, Accuracy)
        return found

    # -- the parts --------------------------------------------------------------------------------------------------

    @cached_property
    def geometry(self) -> Spread:
        """Displacement by deviations of the lengths and the drive angle."""
        return self._spread(self.parts.taken("rigid") - self.rigid[self.kept, None])

    @cached_property
    def compliance(self) -> Spread:
        """Displacement by the load on links and joints."""
        return self._spread(self.parts.taken("compliance"))

    @cached_property
    def clearance(self) -> Spread:
        """Displacement by clearance, to first order."""
        return self._spread(self.parts.taken("clearance"))

    @cached_property
    def clearance_exact(self) -> Spread:
        """Displacement by clearance, the loop closed again."""
        return self._spread(self.parts.taken("clearance_exact"))

    @cached_property
    def total(self) -> Spread:
        """Sum of geometry, compliance and clearance."""
        clearance = self.clearance_exact if self.exact else self.clearance
        return Spread(self.geometry.samples + self.compliance.samples + clearance.samples, self.nan_policy)

    # -- the statistics of the total --------------------------------------------------------------------------------

    @cached_property
    def samples(self) -> Array:  # type: ignore[override]
        """Displacement of P from its nominal position, (poses, n, 3)."""
        return self.total.samples

    # -- status -----------------------------------------------------------------------------------------------------

    @cached_property
    def status(self) -> NDArray[np.str_]:
        """``"regular"``, or why the pose has no statistics, or samples without a result, (poses,)."""
        status = self.excluded.astype(object)
        lost = {"mechanism": self.compliance.samples + self.clearance.samples}
        if self.exact:
            lost[OPEN_LOOP] = self.clearance_exact.samples
        for why, samples in lost.items():
            count = np.count_nonzero(np.isnan(samples[..., 0]), axis=-1)
            for pose in np.flatnonzero(self.kept & (count > 0) & (status == "regular")):
                status[pose] = f"{why} in {count[pose]} of {self.n} samples"
        return status.astype(np.str_)

    @cached_property
    def kappa(self) -> Array:
        """2-norm condition number of the nominal stiffness matrix as the paper assembles it, (poses,)."""
        return self.nominal.condition_number()

    @cached_property
    def kappa_scaled(self) -> Array:
        """Scaled condition number of the nominal linkage in joint-relative coordinates, (poses,)."""
        return self.nominal.scaled_condition_number()

    def _spread(self, samples: Array) -> Spread:
        if self.kept.all() and self.valid.all():
            return Spread(samples, self.nan_policy)
        everywhere = np.full((self.kept.size, self.n, 3), np.nan)
        everywhere[self.kept] = np.where(self.valid[..., None], samples, np.nan)
        return Spread(everywhere, self.nan_policy)


@dataclass(frozen=True, eq=False)
class SampledAccuracy:
    """Accuracy of samples by their numbers, which any process can compute.

    Attributes
    ----------
    four_bar
        The nominal linkage.
    theta
        Drive angles, (poses, n), or (poses, 1) where they are the same for all samples.
    inputs
        Samples of the uncertain parameters, (n,) each.
    load, clearance, contact
        Nominal values as for `accuracy`.
    """

    four_bar: FourBar
    theta: Array
    inputs: Mapping[str, Array]
    load: tuple[ArrayLike, ArrayLike, ArrayLike]
    clearance: PerJoint
    contact: PerJoint | str

    def __call__(self, cut: slice) -> Accuracy:
        """Accuracy of some of the samples, (poses, some)."""
        drawn, contact = part_of(self.inputs, cut), self.contact
        return accuracy(
            toleranced(self.four_bar, drawn),
            self.theta if self.theta.shape[1] == 1 else self.theta[:, cut],
            load=tuple(drawn.get(name, value) for name, value in zip(LOADS, self.load, strict=True)),  # type: ignore[arg-type]
            clearance=per_joint(self.clearance, "clearance", drawn),
            contact=contact if isinstance(contact, str) else per_joint(contact, "contact", drawn),
        )


def monte_carlo(
    four_bar: FourBar,
    theta: ArrayLike,
    distributions: Mapping[str, Distribution],
    *,
    load: tuple[ArrayLike, ArrayLike, ArrayLike] = (0.0, 0.0, 0.0),
    clearance: PerJoint = 0.0,
    contact: PerJoint | str = 0.0,
    n: int = 100,
    rng: Seed = None,
    sampler: Sampler = "random",
    exact: bool = False,
    nan_policy: str = "omit",
) -> Study:
    """Sample the uncertain parameters (12) of a four-bar and solve all poses and samples at once.

    What has no distribution keeps its nominal value, from `four_bar`, `load`, `clearance` and `contact`. The same seed
    gives the same bits, and an input that is added does not change the samples of the others. All samples are held at
    once; for more than memory holds, `propagate` a function that calls `accuracy`: it draws the same ones.

    Parameters
    ----------
    four_bar
        The nominal linkage, without batch.
    theta
        Drive angles, radians, (poses,).
    distributions
        Frozen `scipy.stats` distributions, of which each input draws its own stream:

        * ``"crank"``, ``"coupler"``, ``"rocker"``, ``"ground"``: lengths;
        * ``"drive"``: deviation of the drive angle from `theta`, radians;
        * ``"fx"``, ``"fy"``, ``"mz"``: load on P;
        * ``"E"``: Young's modulus of all links, the shear modulus with it; ``"E.crank"`` ... of one;
        * ``"stiffness"``: every spring of the joints that is neither free nor ideal; ``"ktx"`` ... ``"krz"``: one
          component; ``"clearance"``, ``"contact"``: ε and γ, radians (11). Each is shared by the joints; with
          ``".B"``, ``".D"``, ``".E"`` behind it, that joint's own. The more specific name takes precedence.
    load, clearance, contact
        Nominal values as for `accuracy`, numbers without batch.
    n
        Number of samples.
    rng
        Seed, as in SciPy.
    sampler
        ``"random"``, ``"sobol"``, ``"lhs"``, ``"halton"``, or an engine of `scipy.stats.qmc`.
    exact
        Take the exact clearance displacement into the total. Near a singular pose a clearance may leave the loop
        open; the sample then has no result.
    nan_policy
        What to do with samples that have no result at a pose where others have: ``"omit"`` them, so that the
        statistics are those of the others; ``"propagate"``: the pose has no statistics; ``"raise"``. The status of the
        pose tells why and how many they are.

    Returns
    -------
    Study
        Samples (poses, n, 3) and statistics of the displacement of P, computed when read.

    Raises
    ------
    FrameError
        If a name is no parameter, a sample is out of its range (a negative clearance, say), one distribution would
        stand in place of different values, the nominal linkage cannot be assembled at a pose, all poses are singular,
        or a sample has no result and the policy is to raise.

    Examples
    --------
    >>> import numpy as np
    >>> from scipy import stats
    >>> study = monte_carlo(FourBar(), np.radians([30.0, 60.0]), {"fy": stats.norm(100.0, 5.0)}, n=50, rng=0)
    >>> bool(np.all(abs(study.std[:, 1] / study.mean[:, 1] - 0.05) < 0.02))
    True
    """
    angles = np.atleast_1d(finite(theta, "drive angle theta"))
    if angles.ndim != 1 or not angles.size:
        raise FrameError(f"drive angle theta has shape {angles.shape}: give one axis of poses")
    check_names(distributions)
    checked_policy(nan_policy)
    if isinstance(contact, str) and any(name.startswith("contact") for name in distributions):
        raise FrameError(f"contact is {contact!r} and has a distribution, too: give one of the two")
    check_overwritten(distributions, four_bar, clearance, contact)
    inputs = draw(distributions, n, rng, sampler)
    nominal = accuracy(four_bar, angles, load=load, clearance=clearance, contact=contact)
    if shape := accuracy(four_bar, angles[0], load=load, clearance=clearance, contact=contact).shape:
        raise FrameError(f"the nominal linkage has batch shape {shape}: give numbers, and arrays only as theta")

    # A drive angle that is certain keeps one sample, so that what depends on the pose alone is computed once a pose.
    at = angles[:, None] + inputs.get("drive", np.zeros(1))
    kept, good, excluded = _sorted_out(*_assembling(four_bar, at, inputs, n), nominal, n, nan_policy)
    angle = _assembled(at, kept, good)

    sampled = SampledAccuracy(four_bar, angle, inputs, load, clearance, contact)
    # Samples that are out of their range are so at every pose, and told at once.
    replace(sampled, theta=angle[:1])(slice(None))
    parts = Parts(sampled, (int(kept.sum()), n), soon=contact == "equilibrium", greatest=("error_bound",))
    return Study(nominal, parts, inputs, kept, good[kept], excluded, n, exact, nan_policy)


def part_of(inputs: Mapping[str, Array], cut: slice) -> dict[str, Array]:
    """Some of the samples of the inputs."""
    return {name: values[cut] for name, values in inputs.items()}


def _assembling(
    four_bar: FourBar, at: Array, inputs: Mapping[str, Array], n: int
) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Which samples can be assembled, and which are singular, (poses, n) each: lengths and drive angle tell."""
    lengths = {name: values for name, values in inputs.items() if name in LENGTHS}
    closes, singular = (np.empty((len(at), n), dtype=bool) for _ in range(2))
    for cut in cuts(len(at), n) if lengths or at.shape[1] > 1 else [slice(n)]:
        varied, angle = toleranced(four_bar, part_of(lengths, cut)), at if at.shape[1] == 1 else at[:, cut]
        closes[:, cut], singular[:, cut] = varied.assembles(angle), varied.singular(angle)
    return closes, singular


def _sorted_out(
    closes: NDArray[np.bool_], singular: NDArray[np.bool_], nominal: Accuracy, n: int, nan_policy: str
) -> tuple[NDArray[np.bool_], NDArray[np.bool_], NDArray[np.str_]]:
    """Which poses are sampled, (poses,), which samples are valid, (poses, n), and the poses' status, (poses,)."""
    good = closes & ~singular
    complete = ~nominal.motion.singular & good.all(axis=-1)
    status = nominal.motion.status.astype(object)
    for pose in np.flatnonzero(~complete & ~nominal.motion.singular):
        lost, stuck = n - np.count_nonzero(closes[pose]), np.count_nonzero(singular[pose])
        status[pose] = f"not assembled in {lost} of {n} samples" if lost else f"singular in {stuck} of {n} samples"
        if nan_policy == "raise":
            angle = np.degrees(nominal.motion.theta[pose])
            raise FrameError(f"at {angle:g} deg: {status[pose]}: choose the nan_policy 'omit' or 'propagate'")
    if not complete.any():
        first = np.degrees(nominal.motion.theta[0])
        raise FrameError(f"no pose is left to sample (at {first:g} deg: {status[0]}): give other poses")
    some = ~nominal.motion.singular & good.any(axis=-1)
    return some if nan_policy == "omit" else complete, good, status.astype(np.str_)


def _assembled(at: Array, kept: NDArray[np.bool_], good: NDArray[np.bool_]) -> Array:
    """Drive angles of the samples at the poses kept; samples that are not valid take those of a pose where all are."""
    if good[kept].all():
        return at[kept]
    complete = int(np.argmax(good.all(axis=-1)))
    return np.where(good, at, at[complete])[kept]
