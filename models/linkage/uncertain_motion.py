"""What dimensions, clearances and tolerances do to a moving linkage."""

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
        """How the position of a point depends on dimensions, drives and displacements in the joints, to first order.

        One equilibrium of the rigid linkage for each component serves all dimensions, at all poses at once: a unit load
        at the point works on its displacement as much as the forces in the joints work on theirs.

        Parameters
        ----------
        point
            Name of the point.
        link
            The link on which it is taken; the first that has it where None.

        Returns
        -------
        PositionSensitivity
            Derivatives of ``ux uy uz rx ry rz`` by each, (..., 6, n).

        Raises
        ------
        FrameError
            If there is no such point or link, or the link has it not.

        Examples
        --------
        Of an arm of 2 m that points along y: by its drive, and by a shift of its pivot.

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
        """The worst that clearances and tolerances can do to a point and the orientation of its link, at every pose.

        Links and joints are rigid, the drives locked. Each deviation e_j is a vector in an interval, a disc or a ball
        of radius eps_j, and displaces the point by ``J_j e_j``. In a direction n the point then reaches
        ``h(n) = sum eps_j |J_j^T n|``, exactly to first order: the support function of all that it can reach
        (Voglewede & Ebert-Uphoff, Journal of Mechanical Design 126, 2004, have the workspace of clearances).

        Parameters
        ----------
        point
            Name of the point.
        link
            The link on which it is taken; the first that has it where None.
        clearances
            Radial clearance by joint, (...), in place of those of the description: of a pin, slider or screw across its
            axis, of a ball in all directions, of a planar joint along its normal.
        journals
            Length of the bearing by joint, (...), of pins, sliders and screws that can tilt: both ends of the journal
            then lie anywhere within the clearance. Of a universal joint that of both pins of its cross, or a tuple of
            the one on the first link and the one on the second.
        end_play
            How far a pin, or a nut on its thread, can go along its axis, to either side, by joint, (...); of a
            universal joint both pins, or a tuple.
        lengths
            Tolerance by link of two points, or by (link, point, point) on a link or the ``"ground"``: half width (...),
            or a pair of a lower and an upper deviation.
        places
            Radius of the zone in which a point of a link lies, by (link, point), (...).
        drives
            Tolerance of the values of drives by joint, as for `lengths`.

        Returns
        -------
        WorstCase
            Reachable region, largest displacement and its direction, largest rotation, contributors, envelope.

        Raises
        ------
        FrameError
            If a name is unknown, a limit below zero, or nothing deviates.

        Examples
        --------
        The end of an arm of 2 m whose pin has 0.1 mm of clearance and whose drive is good to 0.2 mrad.

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
        """Where a point can be at each level of membership of fuzzy clearances and tolerances, to first order.

        Cuts of the deviations give cuts of the position, each the `worst_case` of that level; no pose is solved again.
        What lies beyond first order, `propagate_fuzzy` finds by search.

        Parameters
        ----------
        point
            Name of the point.
        link
            The link on which it is taken; the first that has it where None.
        levels
            Number of evenly spaced levels, or the levels, (a,), which rise from 0 to 1.
        **deviations
            ``clearances``, ``journals``, ``end_play``, ``lengths``, ``places``, ``drives`` as for `worst_case`; any of
            them may be a `FuzzyNumber`, a triangle (low, peak, high), or the four corners of a trapezium: of lengths
            and drives the deviation, of the others the size.

        Returns
        -------
        FuzzyReach
            The worst case of each level, and cuts of the displacement in any direction.

        Raises
        ------
        FrameError
            If a name is unknown, a limit below zero, or nothing deviates.

        Examples
        --------
        The end of an arm of 2 m whose drive is most likely right, and at most 0.2 mrad behind or 0.1 mrad ahead.

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
        """Choose the fits of the joints with which a point stays in its zone at every pose, and which cost least.

        Parameters
        ----------
        point
            Name of the point.
        limit
            Radius of its zone, a ball about the nominal position, a length.
        link
            The link on which it is taken; the first that has it where None.
        diameters
            Diameter of the pin of each joint whose fit is to be chosen, m.
        fits
            Fits of ISO 286 that each joint may have.
        costs
            Cost by name of the fit, or a function of the `Fit`. By default hole and shaft cost the inverse of
            their tolerance, in units of that of grade IT7: a grade finer some 1.6 times as much.
        combine
            ``"worst case"``: all deviations at once as bad as can be. ``"statistical"``: the root of the sum of their
            squares.
        **deviations
            What deviates beside the clearances that are chosen: ``clearances`` of other joints, ``journals``,
            ``end_play``, ``lengths``, ``places``, ``drives`` as for `worst_case`.

        Returns
        -------
        FitAllocation
            The cheapest fits, with the poses and the joints that bind. They hold the limit in all directions, to a
            millionth of it.

        Raises
        ------
        FrameError
            If no fits hold the limit, a name is unknown, a fit can have an interference, a pose is singular, or
            clearances open redundant constraints.

        Examples
        --------
        The end of two arms, one behind the other: one of their pins may be loose, and not both.

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
        """Probability that a point leaves its zone, for uncertain dimensions and, where asked for, displaced by loads.

        Likely failures are sought at all poses in one batch an iteration, whose size does not grow with the number of
        inputs: `sensitivity` tells the derivatives by points, lengths, axes, pitches and drives, and `build` how these
        depend on the inputs, without another solution.

        Parameters
        ----------
        point
            Name of the point.
        limit
            Radius of its zone, a ball about the position that it has in this motion, a length.
        build
            Called with samples of the inputs by name, (m,) each, as keywords; returns the linkage with them, with the
            same drives. What of it cannot be assembled has failed.
        distributions
            By name what `propagate` takes: frozen `scipy.stats` distributions, intervals or tolerances.
        compliance
            Whether the point is taken where the loads of the linkage displace it to: by compliance and clearance of
            links and joints, the drives locked. Anything that `build` makes of the inputs may then be uncertain:
            sections, moduli, stiffness and clearance of joints, loads. Derivatives are differences of solutions, all in
            one batch, or of adjoints (see `options`). The middle of the zone stays the rigid position in this motion.
        **options
            Those of `reliability`: ``method``, ``anywhere``, ``correlation``, ``accuracy``, ``samples``, ``rng`` ...;
            ``gradient=None`` takes differences of solutions, ``gradient="adjoint"`` exact derivatives also under load,
            of one solution for each point of the search however many the inputs. From a hundred inputs on it does so by
            itself; with fewer, differences take less time. Adjoints know the displacement without clearances, springs
            and loads that turn with links, by all numbers but axes of joints, Poisson's ratio, gravity and density.

        Returns
        -------
        Reliability
            Probability of failure at each pose, (poses,), or with ``anywhere=True`` of failing at one of them, ();
            its `plot()` shows that of each pose over the first drive.

        Raises
        ------
        FrameError
            If the motion has more than one axis or lacks a pose, or a displacement there, adjoints are asked for and
            do not tell all derivatives, or as `reliability`.

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
        """Hand the question whether a point leaves its zone to OpenTURNS.

        Parameters
        ----------
        point, limit, build, distributions, compliance
            As for `Motion.reliability`. The middle of the zone has no slope: let a search begin elsewhere.
        **options
            Those of `to_openturns`: ``anywhere``, ``correlation`` ...

        Returns
        -------
        OpenTURNSProblem
            The function, with a result for each pose, ``1 - (off / limit)²`` of the distance off; the distribution of
            its inputs, and the events of failure.

        Raises
        ------
        FrameError
            If OpenTURNS is not installed, or as `Motion.reliability`.
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
        """Hand the question whether a point leaves its zone to Pystra.

        Parameters
        ----------
        point, limit, build, distributions, compliance
            As for `Motion.reliability`. The middle of the zone has no slope: let a search begin elsewhere.
        **options
            Those of `to_pystra`: ``anywhere``, ``correlation`` ...

        Returns
        -------
        PystraProblem
            The limit state of each pose, the stochastic model of the inputs, and options of an analysis.

        Raises
        ------
        FrameError
            If Pystra is not installed, or as `Motion.reliability`.
        """
        left, slopes = share_left(self, point, limit, build, distributions, compliance)
        own = {"gradient": slopes, **options}
        return to_pystra(left, distributions, poses=self.shape[0] if self.shape else None, **own)
