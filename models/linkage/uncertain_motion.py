"""Effects of dimensions, clearances and tolerances on a moving linkage."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from numpy.typing import ArrayLike

from ..distributions import Uncertain
from ..failure.adapters import OpenTURNSProblem, PystraProblem, to_openturns, to_pystra
from ..failure.reliability import Reliability
from .derivatives.position_sensitivity import PositionSensitivity, position_sensitivity
from .loaded_motion import LoadedMotion
from .worst_case.allocation import FITS, Costs, FitAllocation, allocate_fits
from .worst_case.fuzzy import FuzzyReach, fuzzy_reach
from .worst_case.limits import Given, given_of
from .worst_case.worst_case import WorstCase, worst_case
from .zone import Build, reliability_of, share_left


@dataclass(frozen=True, eq=False, repr=False)
class UncertainMotion(LoadedMotion):
    """Derivatives, worst cases and probabilities of a motion; see `Motion`."""

    def sensitivity(self, point: str, link: str | None = None) -> PositionSensitivity:
        """Differentiate the position of a point by dimensions, drives and displacements in the joints.

        One equilibrium of the rigid linkage for each component gives the derivatives by all dimensions, by virtual
        work: a unit load at the point does as much work as the joint forces that balance it do on displacements in the
        joints.

        Parameters
        ----------
        point
            Name of the point.
        link
            The link on which it lies; the first that has it if None.

        Returns
        -------
        PositionSensitivity
            Derivatives of ``ux uy uz rx ry rz``, (..., 6, n) by n components each.

        Raises
        ------
        FrameError
            If there is no such point or link, or the link does not have the point.

        Examples
        --------
        Derivatives of the end of an arm of 2 m along y, by its drive and by a shift of its pivot.

        >>> import numpy as np
        >>> from linkframe.models import Linkage
        >>> linkage = Linkage(A=(0, 0), B=(2, 0))
        >>> linkage.link("arm", "A", "B")
        >>> linkage.revolute("A", "ground", "arm", drive=True)
        >>> by = linkage.move(A=np.radians(90.0)).sensitivity("B")
        >>> by.drives["A"][:2, 0].round(12).tolist()
        [-2.0, 0.0]
        >>> (by.places["ground", "A"][:2, 0].round(12) + 0.0).tolist()
        [1.0, 0.0]
        """
        return position_sensitivity(self, point, link)

    def worst_case(
        self,
        point: str,
        link: str | None = None,
        *,
        clearances: Mapping[str, ArrayLike] | None = None,
        journals: Mapping[str, ArrayLike] | None = None,
        end_play: Mapping[str, ArrayLike] | None = None,
        lengths: Mapping[str | tuple[str, str, str], ArrayLike] | None = None,
        places: Mapping[tuple[str, str], ArrayLike] | None = None,
        drives: Mapping[str, ArrayLike] | None = None,
    ) -> WorstCase:
        """Worst case of clearances and tolerances for a point and the orientation of its link, at every pose.

        Links and joints are rigid, and the drives locked. Each deviation e_j is a vector in an interval, a disc or a
        ball of radius eps_j, and displaces the point by ``J_j e_j``. In a direction n the point then reaches
        ``h(n) = sum eps_j |J_j^T n|``, exactly to first order: the support function of its reachable region (Voglewede
        & Ebert-Uphoff, *Journal of Mechanical Design* 126, 2004, on clearances).

        Parameters
        ----------
        point
            Name of the point.
        link
            The link on which it lies; the first that has it if None.
        clearances
            Radial clearance by joint, (...), instead of that of the description: of a pin, slider or screw
            perpendicular to its axis, of a spherical joint in all directions, of a planar joint along its normal.
        journals
            Bearing length by joint, (...), of pins, sliders and screws that can tilt: each end of the journal can be
            anywhere within the clearance. For a universal joint that of both pins of its cross, or a tuple of the one
            on the first link and the one on the second.
        end_play
            Largest displacement of a pin, or of a nut on its thread, along its axis to either side, by joint, (...);
            for a universal joint that of both pins, or a tuple.
        lengths
            Tolerance by link of two points, or by (link, point, point) on a link or the ``"ground"``: half width (...),
            or a pair of a lower and an upper deviation.
        places
            Radius of the zone in which a point of a link lies on its link, by (link, point), (...).
        drives
            Tolerance of the values of drives by joint, as for `lengths`.

        Returns
        -------
        WorstCase
            Reachable region, largest displacement and its direction, largest rotation, contributors, envelope.

        Raises
        ------
        FrameError
            If a name is unknown, a limit is negative, or nothing deviates.

        Examples
        --------
        The end of an arm of 2 m whose pin has 0.1 mm of clearance and whose drive has a tolerance of 0.2 mrad.

        >>> from linkframe.models import Linkage
        >>> linkage = Linkage(A=(0, 0), B=(2, 0))
        >>> linkage.link("arm", "A", "B")
        >>> linkage.revolute("A", "ground", "arm", drive=True, clearance=1e-4)
        >>> worst = linkage.move().worst_case("B", drives={"A": 2e-4})
        >>> round(float(worst.greatest), 12), worst.direction.round(6).tolist()
        (0.0005, [0.0, 1.0, 0.0])
        """
        given = Given(clearances or {}, journals or {}, end_play or {}, lengths or {}, places or {}, drives or {})
        return worst_case(self, point, link, given)

    def fuzzy(
        self, point: str, link: str | None = None, *, levels: int | ArrayLike = 11, **deviations: Mapping[Any, Any]
    ) -> FuzzyReach:
        """Reachable region of a point at each level of membership of fuzzy clearances and tolerances, to first order.

        Cuts of the deviations give cuts of the position, each the `worst_case` of that level; no pose is solved again.
        `propagate_fuzzy` finds cuts beyond first order by search.

        Parameters
        ----------
        point
            Name of the point.
        link
            The link on which it lies; the first that has it if None.
        levels
            Number of evenly spaced levels, or the levels, (a,), which increase from 0 to 1.
        **deviations
            ``clearances``, ``journals``, ``end_play``, ``lengths``, ``places``, ``drives`` as for `worst_case`; any of
            them may be a `FuzzyNumber`, a triangle (low, peak, high), or the four corners of a trapezium: that of the
            deviation for lengths and drives, of the size for the others.

        Returns
        -------
        FuzzyReach
            The worst case of each level, and cuts of the displacement in any direction.

        Raises
        ------
        FrameError
            If a name is unknown, a limit is negative, or nothing deviates.

        Examples
        --------
        The end of an arm of 2 m whose drive is most likely exact, and at most 0.2 mrad behind or 0.1 mrad ahead.

        >>> from linkframe.models import Linkage
        >>> linkage = Linkage(A=(0, 0), B=(2, 0))
        >>> linkage.link("arm", "A", "B")
        >>> linkage.revolute("A", "ground", "arm", drive=True)
        >>> found = linkage.move().fuzzy("B", levels=3, drives={"A": (-2e-4, 0.0, 1e-4)}).along((0, 1))
        >>> found.lower.round(12).tolist(), found.upper.round(12).tolist()
        ([-0.0004, -0.0002, 0.0], [0.0002, 0.0001, 0.0])
        """
        return fuzzy_reach(self, point, link, levels, deviations)

    def allocate(
        self,
        point: str,
        limit: float,
        link: str | None = None,
        *,
        diameters: Mapping[str, float],
        fits: Sequence[str] = FITS,
        costs: Costs | None = None,
        combine: str = "worst case",
        **deviations: Mapping[Any, ArrayLike],
    ) -> FitAllocation:
        """Choose the cheapest fits of the joints that keep a point in its zone at every pose.

        Parameters
        ----------
        point
            Name of the point.
        limit
            Radius of its zone, a ball about the nominal position, a length.
        link
            The link on which it lies; the first that has it if None.
        diameters
            Diameter of the pin of each joint whose fit is to be chosen, m.
        fits
            Fits of ISO 286 that each joint may have.
        costs
            Cost by name of the fit, or a function of the `Fit`. By default the costs of hole and shaft are inverse to
            their tolerances, in units of that of grade IT7: a finer grade costs some 1.6 times as much.
        combine
            ``"worst case"``: the largest effects of all deviations are added. ``"statistical"``: the root of the sum of
            their squares.
        **deviations
            Deviations in addition to the clearances to be chosen: ``clearances`` of other joints, ``journals``,
            ``end_play``, ``lengths``, ``places``, ``drives`` as for `worst_case`.

        Returns
        -------
        FitAllocation
            The cheapest fits, with the critical poses and joints. They keep the limit in all directions, to a millionth
            of it.

        Raises
        ------
        FrameError
            If no fits keep the limit, a name is unknown, a fit can have an interference, a pose is singular, or
            clearances open redundant constraints.

        Examples
        --------
        The end of two arms in series: one of their pins may have a loose fit, but not both.

        >>> from linkframe.models import Linkage
        >>> linkage = Linkage(A=(0, 0), B=(1, 0), C=(2, 0))
        >>> linkage.link("crank", "A", "B")
        >>> linkage.link("arm", "B", "C")
        >>> linkage.revolute("A", "ground", "crank", drive=True)
        >>> linkage.revolute("B", "crank", "arm", drive=True)
        >>> linkage.move().allocate("C", 60e-6, diameters={"A": 0.01, "B": 0.02}, fits=("H7/g6", "H8/f7", "H9/d9"))
        <FitAllocation: A H8/f7, B H7/g6; cost 4.297; worst case: 4.55e-05 of 6e-05 used (joint A 55 %, joint B 45 %)>
        """
        given = given_of(deviations)
        return allocate_fits(self, point, limit, link, diameters, fits, costs, combine, given)

    def reliability(
        self,
        point: str,
        limit: float,
        build: Build,
        distributions: Mapping[str, Uncertain],
        *,
        compliance: bool = False,
        **options: Any,
    ) -> Reliability:
        """Probability that a point leaves its zone, for uncertain dimensions and, optionally, under load.

        Design points are searched at all poses together, with one batch of motions in each iteration, whose size does
        not increase with the number of inputs: `sensitivity` gives the derivatives by points, lengths, axes, pitches
        and drives, and `build` the dependence of these on the inputs, without another solution.

        Parameters
        ----------
        point
            Name of the point.
        limit
            Radius of its zone, a ball about its position in this motion, a length.
        build
            Function of samples of the inputs by name, (m,) each, as keywords, which returns the linkage with them, with
            the same drives. Samples that cannot be assembled count as failures.
        distributions
            By name of the input: a frozen `scipy.stats` distribution, an interval or a tolerance, as for `propagate`.
        compliance
            Whether the point is displaced by the loads of the linkage: by compliance and clearance of links and joints,
            with locked drives. Anything in the linkage of `build` may then be uncertain: sections, moduli, stiffness
            and clearance of joints, loads. Derivatives are differences of solutions, all in one batch, or by adjoints
            (see `options`). The middle of the zone is still the rigid position in this motion.
        **options
            Those of `reliability`: ``method``, ``anywhere``, ``correlation``, ``accuracy``, ``samples``, ``rng`` ...;
            ``gradient=None`` takes differences of solutions, ``gradient="adjoint"`` exact derivatives, under load too,
            with one solution for each point of the search however many inputs there are. That is the default for a
            hundred inputs or more; with fewer, differences take less time. Adjoints under load are not available with
            clearances, springs and follower loads, nor if axes of joints, Poisson's ratio, gravity or density under
            gravity are uncertain.

        Returns
        -------
        Reliability
            Probability of failure at each pose, (poses,), or with ``anywhere=True`` of failing at one of them, ();
            its `plot()` shows that of each pose over the first drive.

        Raises
        ------
        FrameError
            If the motion has more than one axis, a pose or displacement is missing, adjoints are asked for and not
            available, or as for `reliability`.

        Examples
        --------
        A crank whose length alone is uncertain, ``P = 2 Φ(-limit / deviation)`` (A. M. Hasofer & N. C. Lind, 1974).

        >>> import numpy as np
        >>> from scipy import stats
        >>> from linkframe.models import Linkage
        >>> def crank(length):
        ...     places = np.stack(np.broadcast_arrays(length, 0.0, 0.0), axis=-1)
        ...     linkage = Linkage(A=(0, 0), P=places)
        ...     linkage.link("crank", "A", "P")
        ...     linkage.revolute("A", "ground", "crank", drive=True)
        ...     return linkage
        >>> motion = crank(0.2).move(A=[0.3, 1.0])
        >>> found = motion.reliability("P", 5e-5, crank, {"length": stats.norm(0.2, 1e-5)}, method="form")
        >>> bool(abs(found.probability / (2.0 * stats.norm.sf(5.0)) - 1.0).max() < 1e-6)
        True
        """
        return reliability_of(self, point, limit, build, distributions, compliance, **options)

    def to_openturns(
        self,
        point: str,
        limit: float,
        build: Build,
        distributions: Mapping[str, Uncertain],
        *,
        compliance: bool = False,
        **options: Any,
    ) -> OpenTURNSProblem:
        """State the problem whether a point leaves its zone for OpenTURNS.

        Parameters
        ----------
        point, limit, build, distributions, compliance
            As for `Motion.reliability`. The gradient is zero at the middle of the zone: start searches elsewhere.
        **options
            Those of `to_openturns`: ``anywhere``, ``correlation`` ...

        Returns
        -------
        OpenTURNSProblem
            The function, whose result at each pose is ``1 - (off / limit)²`` with the distance ``off`` from the middle
            of the zone; the distribution of its inputs, and the failure events.

        Raises
        ------
        FrameError
            If OpenTURNS is not installed, or as for `Motion.reliability`.
        """
        left, slopes = share_left(self, point, limit, build, distributions, compliance)
        own = {"gradient": slopes, **options}
        return to_openturns(left, distributions, poses=self.shape[0] if self.shape else None, **own)

    def to_pystra(
        self,
        point: str,
        limit: float,
        build: Build,
        distributions: Mapping[str, Uncertain],
        *,
        compliance: bool = False,
        **options: Any,
    ) -> PystraProblem:
        """State the problem whether a point leaves its zone for Pystra.

        Parameters
        ----------
        point, limit, build, distributions, compliance
            As for `Motion.reliability`. The gradient is zero at the middle of the zone: start searches elsewhere.
        **options
            Those of `to_pystra`: ``anywhere``, ``correlation`` ...

        Returns
        -------
        PystraProblem
            The limit state of each pose, the stochastic model of the inputs, and options of an analysis.

        Raises
        ------
        FrameError
            If Pystra is not installed, or as for `Motion.reliability`.
        """
        left, slopes = share_left(self, point, limit, build, distributions, compliance)
        own = {"gradient": slopes, **options}
        return to_pystra(left, distributions, poses=self.shape[0] if self.shape else None, **own)
