"""The motion of a linkage: where it is, and what can be asked of it there."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import ArrayLike

from ...framework.batch import Array
from ...framework.frame import Frame
from ...framework.listing import counted
from ...framework.renamed import RenamedAttribute
from ..distributions import Uncertain
from ..failure.reliability import Reliability
from ..measured.calibration import Calibration
from ..measured.comparison import Comparison
from ..measured.table import Measured
from .derivatives.position_sensitivity import PositionSensitivity, position_sensitivity
from .graphics.pictures import movie, picture, show
from .graphics.plots import GHOSTS, SI, Units, animate_motion, plot_motion
from .measured import calibration_of, comparison_of
from .page.page import PageText, framed, framed_point, write_page
from .poses.coordinates import coordinate_of, rates_of_coordinate
from .poses.states import PoseState, closure_states
from .statics.accuracy import PointAccuracy, Stress, accuracy, compliance_matrix, frequencies, stiffness, stress
from .statics.actions import kinetic_energy
from .statics.frame import FramedPoses, frame
from .statics.free import free_accelerations
from .statics.reactions import Reactions, reactions
from .statics.transmission import transmission_angle
from .worst_case.allocation import FITS, Costs, FitAllocation, allocate_fits
from .worst_case.fuzzy import FuzzyReach, fuzzy_reach
from .worst_case.limits import Given, given_of
from .worst_case.worst_case import WorstCase, worst_case
from .zone import Build, reliability_of

if TYPE_CHECKING:
    from matplotlib.animation import FuncAnimation
    from matplotlib.axes import Axes

# Poses up to which what is printed of a motion tells singular ones; beyond, whether they are assembled.
COUNTED = 100_000


class LoadsWarning(UserWarning):
    """What is asked of a motion does not contain the loads that one of its frames was given."""


@dataclass(frozen=True, eq=False, repr=False)
class Motion(FramedPoses):
    """Motion of a linkage over a batch of poses; made by `Linkage.move`.

    Poses that cannot be assembled have the status ``"not assembled: ..."`` and NaN throughout, as have those in another
    assembly mode than the reference configuration unless these were asked for.

    Attributes
    ----------
    linkage
        The description.
    mechanism
        Its compiled form.
    drives
        Values, rates and accelerations of the drives.
    assembly
        The closed states.
    """

    def __repr__(self) -> str:
        many = int(np.prod(self.shape)) > COUNTED
        states = closure_states(self.assembly.reached, self.assembly.other) if many else self.state
        return f"<Motion of shape {self.shape} of {self.linkage!r}: {counted(states, PoseState)}>"

    def __getstate__(self) -> dict[str, object]:
        """What another process needs; frames that are in use in this one are not known there."""
        return {name: value for name, value in vars(self).items() if name != "frames"}

    def explain(self) -> str:
        """How the poses were found: how many there are, and whether NumPy or machine code closes their loops.

        Returns
        -------
        str
            What is done, what that is expected to take, and why it is not done otherwise.
        """
        count, left = self.assembly.reached.size, int((~self.assembly.reached).sum())
        beside = f", {left} of them not reached from the reference configuration" if left else ""
        return f"{count} poses{beside}\nNewton's method on the loops: {self.assembly.told}"

    def transmission_angle(self, joint: str) -> Array:
        """Angle of transmission at a joint: best at π/2, none at 0.

        The angle between the force that the joint passes on to its second link and the direction square to the motion
        of that link's half of the joint; 90° less the pressure angle. For a four-bar at the joint between coupler and
        rocker it is the angle between the two, acute (Norton, Design of Machinery, section 4.10); between a connecting
        rod and its piston it is the angle between the rod and the line square to the slide. In general, with drives
        held, the joint can pass on those forces that the links before it take without moving, and its second link can
        move as it can without the joint: the angle of transmission has the sine of the best of them.

        Parameters
        ----------
        joint
            The joint; its second link is the one that is driven.

        Returns
        -------
        ndarray
            Radians in [0, π/2], (...).

        Raises
        ------
        FrameError
            If there is no such joint, or its second link is the ground.

        Examples
        --------
        A square four-bar passes its force on at a right angle.

        >>> import numpy as np
        >>> from linkframe.models import Linkage
        >>> linkage = Linkage(A=(0, 0), B=(0, 1), C=(1, 1), D=(1, 0))
        >>> for link in ("AB", "BC", "CD"):
        ...     linkage.link(link, *link)
        >>> linkage.revolute("A", "ground", "AB", drive=True); linkage.revolute("B", "AB", "BC")
        >>> linkage.revolute("C", "BC", "CD"); linkage.revolute("D", "CD", "ground")
        >>> float(np.degrees(linkage.move(A=0.0).transmission_angle("C")).round(5))
        90.0
        """
        return transmission_angle(self, joint)

    # -- joints -----------------------------------------------------------------------------------------------------

    def coordinate(self, joint: str) -> Array:
        """Relative position of the two links of a joint: its coordinates, of the second relative to the first.

        Parameters
        ----------
        joint
            Name of the joint.

        Returns
        -------
        ndarray
            In the order of the kind's coordinates, lengths and radians, (..., f); ``reference`` in the reference
            configuration. Angles go on beyond a turn: they count the turns that the joint makes while the drives go to
            the pose from their reference values. Of a ball: the rotation vector, of length at most π.

        Raises
        ------
        FrameError
            If there is no such joint.

        Examples
        --------
        A parallelogram: the pin between crank and coupler turns back as the crank turns on.

        >>> import numpy as np
        >>> from linkframe.models import Linkage
        >>> linkage = Linkage(A=(0, 0), B=(0, 1), C=(2, 1), D=(2, 0))
        >>> for link in ("AB", "BC", "CD"):
        ...     linkage.link(link, *link)
        >>> linkage.revolute("A", "ground", "AB", drive=True); linkage.revolute("B", "AB", "BC")
        >>> linkage.revolute("C", "BC", "CD"); linkage.revolute("D", "CD", "ground")
        >>> np.degrees(linkage.move(A=np.radians([0.0, 30.0])).coordinate("B")).round(9).tolist()
        [[0.0], [-30.0]]
        """
        return coordinate_of(self, self.linkage.joint(joint))

    def coordinate_rate(self, joint: str) -> Array:
        """Time derivative of a joint's coordinates.

        Parameters
        ----------
        joint
            Name of the joint.

        Returns
        -------
        ndarray
            Lengths and radians per time, (..., f); of a ball the angular velocity, in the joint's axes on its first
            link.

        Raises
        ------
        FrameError
            If there is no such joint.
        """
        return rates_of_coordinate(self, self.linkage.joint(joint), 0)

    def coordinate_acceleration(self, joint: str) -> Array:
        """Second time derivative of a joint's coordinates.

        Parameters
        ----------
        joint
            Name of the joint.

        Returns
        -------
        ndarray
            Lengths and radians per time squared, (..., f); of a ball the rate of the components that `coordinate_rate`
            gives.

        Raises
        ------
        FrameError
            If there is no such joint.
        """
        return rates_of_coordinate(self, self.linkage.joint(joint), 1)

    # -- derivatives ------------------------------------------------------------------------------------------------

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
            then lie anywhere within the clearance.
        end_play
            How far a pin can go along its axis, to either side, by joint, (...).
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

    # -- forces, compliance and clearance -----------------------------------------------------------------------------

    def reactions(self) -> Reactions:
        """Joint reactions and drive forces of the rigid linkage, by the Newton-Euler equations of all links.

        Inertia forces (Eq. 1 and 2 of the accuracy paper), gravity, loads, springs and dampers are in equilibrium with
        what the joints hold and the drives push. Where equilibrium alone does not tell all reactions, those follow
        from the compliance of links and joints; if these are rigid, the reactions with the least sum of squares are
        given (moments divided by half of what the linkage spans). ``.method`` says which.

        Loads that were given to a frame of the motion alone are not among them.

        Returns
        -------
        Reactions
            Force and moment in every joint, (..., 6), and of every drive, (..., f); NaN where no finite forces keep
            the linkage in equilibrium.

        Raises
        ------
        FrameError
            If masses, loads, springs or gravity do not broadcast with the motion.

        Warns
        -----
        LoadsWarning
            Where a frame of the motion was given loads.

        Examples
        --------
        >>> from linkframe.models import Linkage
        >>> arm = Linkage(A=(0, 0), B=(2, 0))
        >>> arm.link("arm", "A", "B", mass=3.0)
        >>> arm.revolute("A", "ground", "arm", drive=True)
        >>> arm.gravity((0, -10))
        >>> round(float(arm.move(A=0.0).reactions().drive("A")[0]), 9)
        30.0
        """
        self._check_frames("reactions()")
        return reactions(self)

    def kinetic_energy(self) -> Array:
        """Kinetic energy of all links at the motion's rates.

        The sum of ``m v^2 / 2 + w I w / 2`` over the links, v of the centre of mass and w the angular velocity
        (Featherstone, *Rigid Body Dynamics Algorithms*, 2008, ch. 2).

        Returns
        -------
        ndarray
            Energy, (...); zero where no link has a mass.

        Raises
        ------
        FrameError
            If masses do not broadcast with the motion.

        Examples
        --------
        A mass of 3 kg that goes round at 2 m with 5 rad/s.

        >>> from linkframe.models import Linkage
        >>> linkage = Linkage(A=(0, 0), B=(2, 0))
        >>> linkage.link("arm", "A", "B", mass=3.0, centre=(2, 0), inertia=0.0)
        >>> linkage.revolute("A", "ground", "arm", drive=True)
        >>> float(linkage.move(A=0.0, rates={"A": 5.0}).kinetic_energy().round(9))
        150.0
        """
        return kinetic_energy(self)

    def free_accelerations(self, forces: Mapping[str, ArrayLike] | None = None) -> dict[str, Array]:
        """Acceleration of each drive under given drive forces, at the motion's poses and rates.

        With the rates as they are, the drive forces of `reactions` are linear in the accelerations,
        ``M a + h``; this solves ``M a = f - h`` (Featherstone, Rigid Body Dynamics Algorithms, 2008, ch. 6).

        Parameters
        ----------
        forces
            Force or moment by driven joint, (...), or (..., f) where f coordinates are driven; zero where not given.

        Returns
        -------
        dict of ndarray
            By driven joint, (..., f), length or radians per time squared.

        Raises
        ------
        FrameError
            If a joint is not driven, or the linkage has no inertia against one of its drives.

        Examples
        --------
        A pendulum let go from the level, its mass at its end: ``g / l`` (Featherstone 2008).

        >>> from linkframe.models import Linkage
        >>> linkage = Linkage(A=(0, 0), B=(2, 0))
        >>> linkage.link("arm", "A", "B", mass=3.0, centre=(2, 0), inertia=0.0)
        >>> linkage.revolute("A", "ground", "arm", drive=True)
        >>> linkage.gravity((0, -10))
        >>> linkage.move(A=0.0).free_accelerations()["A"].round(9).tolist()
        [-5.0]
        """
        return free_accelerations(self, forces or {})

    def frame(self, *, clearance: bool = True, loads: bool = True, inertia: bool = False) -> Frame:
        """The linkage at every pose as a frame of beams, joints and springs, held at its drives.

        Each link is a body, in whose own axes its nodes do not move, so that its stiffness is computed once for all
        poses. A point that only one link has gives the node of its name; where joints part it each link has its own,
        ``point.link``, and the bare name means that of the first link. Members are called as their link, or
        ``link.1``, ``link.2``, ...; joints by their names; springs ``spring.1``, ...

        A slider loads the link that carries it where it is at each pose: on any of the beams along which its slot
        runs, at a point of the link, or, where it is beyond them all, on a rigid prolongation of the nearest end. A
        beam counts where it leans from the slot by less than 0.01 radians and is off it by less than a hundredth of
        its length. Where the slot runs along no beam, as that of a yoke, the slider stands on a rigid arm from the
        joint's point. Where it changes from seat to seat with the pose, each seat is a joint ``joint.link.on.seat``
        between the link and the slider's node, rigid at the poses at which the slider stands there and free else.

        A mass that was given sits, rigid, on the link's point nearest to its centre, and its beams weigh nothing.

        The frame is linear about the linkage without loads: its links, joints and springs resist with their stiffness
        alone, and what springs exert at rest is one of the loads. That forces turn with the links, joints and springs
        that carry them (geometric stiffness) is in `compliance_matrix`, `stiffness` and `frequencies` of the motion,
        and of the frame in ``buckling`` and ``solve(large=True)``, where springs pull along their line wherever they
        are.

        Parameters
        ----------
        clearance
            Give the joints their clearance.
        loads
            Apply what the linkage was loaded with: loads, torques, gravity, and the forces of springs and dampers.
            What the frame is loaded with later acts in it alone, and neither in `reactions` nor in `stress`.
        inertia
            Apply the inertia forces of the rigid motion.

        Returns
        -------
        Frame
            The frame, batch shape (...) and that of beams, stiffnesses and loads. Poses that are not assembled are
            left out: their status is ``absent``.

        Examples
        --------
        >>> import numpy as np
        >>> from linkframe.elements import Beam, Material, Rectangle
        >>> from linkframe.models import Linkage
        >>> linkage = Linkage(A=(0, 0), B=(1, 0))
        >>> linkage.link("arm", "A", "B", beam=Beam(Rectangle(y=0.02, z=0.01), Material(E=200e9, nu=0.3)))
        >>> linkage.revolute("A", "ground", "arm", drive=True)
        >>> frame = linkage.move(A=np.radians([0.0, 90.0])).frame()
        >>> frame.load("B", fy=10.0)
        >>> frame.solve().displacement("B")[:, 1].round(9).tolist()
        [0.0025, 2.5e-07]
        """
        built = frame(self, clearance=clearance, loads=loads, inertia=inertia)
        self.frames[built] = loads_of(built)
        return built

    @cached_property
    def frames(self) -> WeakKeyDictionary[Frame, tuple[object, ...]]:
        """Frames that were made of the motion and are still in use, and how many loads they then had."""
        return WeakKeyDictionary()

    def _check_frames(self, what: str) -> None:
        """Warn where a frame of the motion was given loads, which what is asked of the motion does not contain."""
        if any(loads_of(frame) != before for frame, before in self.frames.items()):
            warnings.warn(
                f"motion.{what} does not contain the loads that were given to a frame of this motion: loads given by "
                "linkage.load(...) act in both",
                LoadsWarning,
                stacklevel=3,
            )

    def save(self, path: str | Path, times: ArrayLike | None = None) -> None:
        """Write the motion for ParaView: links as lines, with the velocity and acceleration of their points.

        With beams, ``motion.frame().solve().save(path)`` shows them with their displacements and forces.

        Parameters
        ----------
        path
            File ``.pvd``; the poses are files in a folder beside it. Poses that are not assembled are left out.
        times
            Increasing times (or angles) of the poses, (poses,); their numbers where None.

        Raises
        ------
        FrameError
            If the name ends otherwise, the motion is not one row of poses, or the folder cannot be written.

        Examples
        --------
        >>> from pathlib import Path
        >>> from tempfile import TemporaryDirectory
        >>> import numpy as np
        >>> from linkframe.models import Linkage
        >>> linkage = Linkage(A=(0, 0), B=(2, 0))
        >>> linkage.link("arm", "A", "B")
        >>> linkage.revolute("A", "ground", "arm", drive=True)
        >>> with TemporaryDirectory() as folder:
        ...     linkage.move(A=np.radians([0.0, 90.0])).save(Path(folder) / "arm.pvd")
        ...     sorted(path.name for path in Path(folder).iterdir())
        ['arm', 'arm.pvd']
        """
        from .export import save  # what it writes with takes long to load

        save(self, path, times)

    # -- to look at -------------------------------------------------------------------------------------------------

    def plot(
        self,
        ax: Axes | None = None,
        *,
        pose: int | tuple[int, ...] | None = None,
        trace: str | Sequence[str] = (),
        band: ArrayLike | None = None,
        magnify: float | None = None,
        ghosts: int = GHOSTS,
        names: bool = True,
        loads: bool = True,
        units: Units = SI,
    ) -> Axes:
        """Draw one pose, others faintly behind it, and the paths of points.

        Parameters
        ----------
        ax
            Axes of matplotlib to draw on, in space for a motion in space; new ones where None.
        pose
            Index of the pose; the first that can be assembled where None.
        trace
            Point, or points, whose paths over the longest batch axis are drawn.
        band
            Displacements of the one point traced, length, whose envelope is drawn about its path: of samples, (poses,
            samples, 2 or more), or a `Spread` of them; or half widths by pose, (poses, 2 or more).
        magnify
            Factor on these displacements; a round one that shows them where None. It stands above the figure.
        ghosts
            About how many other poses are drawn; 0 for none.
        names, loads
            Whether points are named, and forces drawn.
        units
            Units of length and force, for the labels.

        Returns
        -------
        matplotlib.axes.Axes
            What was drawn on, in the linkage's own lengths.

        Raises
        ------
        FrameError
            If no pose is assembled, there is no such pose or point, or the band does not fit the poses.

        Examples
        --------
        >>> import matplotlib; matplotlib.use("Agg")
        >>> import numpy as np
        >>> from linkframe.models import Linkage
        >>> linkage = Linkage(A=(0, 0), B=(2, 0))
        >>> linkage.link("arm", "A", "B")
        >>> linkage.revolute("A", "ground", "arm", drive=True)
        >>> half = np.full((20, 2), 0.01)
        >>> linkage.move(A=np.linspace(0.0, 1.0, 20)).plot(trace="B", band=half).get_title(loc="left")
        'displacements of B × 5'
        """
        traced = (trace,) if isinstance(trace, str) else tuple(trace)
        return plot_motion(self, ax, pose, traced, band, magnify, ghosts, names, loads, units)

    def animate(
        self,
        ax: Axes | None = None,
        *,
        trace: str | Sequence[str] = (),
        interval: float = 50.0,
        names: bool = True,
        units: Units = SI,
    ) -> FuncAnimation:
        """Let the poses along the longest batch axis follow each other.

        Parameters
        ----------
        ax
            Axes of matplotlib to draw on, in space for a motion in space; new ones where None.
        trace
            Point, or points, whose paths are drawn.
        interval
            Milliseconds from pose to pose.
        names
            Whether points are named.
        units
            Units of length and force, for the labels.

        Returns
        -------
        matplotlib.animation.FuncAnimation
            To be kept while it is shown: ``.save("motion.gif")``, or ``.to_jshtml()`` in a notebook.

        Raises
        ------
        FrameError
            If no pose is assembled, or there is no such point.
        """
        return animate_motion(self, ax, (trace,) if isinstance(trace, str) else tuple(trace), interval, names, units)

    def picture(
        self,
        path: str | Path,
        *,
        pose: int | tuple[int, ...] | None = None,
        names: bool = True,
        size: tuple[int, int] = (1600, 1000),
        units: Units = SI,
    ) -> None:
        """Render one pose in space: links with their sections, joints by kind, drives in orange, ground, forces.

        ``motion.frame().solve()`` with ``linkframe.framework.picture`` shows it deformed, coloured by its stress.

        Parameters
        ----------
        path
            Image to write, ``.png`` or ``.jpg``.
        pose
            Index of the pose; the first that can be assembled where None.
        names
            Whether points are named.
        size
            Width and height in pixels.
        units
            Units of length and force, for the labels.

        Raises
        ------
        RenderingError
            If this machine cannot render; the message says what to install.
        FrameError
            If the name ends otherwise, there is no such pose, or the folder cannot be written.
        """
        picture(self, path, pose, names, size, units)

    def movie(
        self,
        path: str | Path,
        *,
        names: bool = False,
        size: tuple[int, int] = (960, 608),
        rate: int = 12,
        units: Units = SI,
    ) -> None:
        """Render the poses along the longest batch axis one after the other, as `picture` does one.

        Parameters
        ----------
        path
            Movie to write, ``.gif`` or ``.mp4``; needs the extra ``movie``.
        names
            Whether points are named.
        size
            Width and height in pixels.
        rate
            Poses a second.
        units
            Units of length and force, for the labels.

        Raises
        ------
        RenderingError
            If this machine cannot render or the extra is not installed; the message says what to install.
        FrameError
            If the name ends otherwise, no pose is assembled, or the folder cannot be written.
        """
        movie(self, path, names, size, rate, units)

    def show(self, *, pose: int | tuple[int, ...] | None = None, names: bool = True, units: Units = SI) -> object:
        """Open a window on the motion in space, to turn and to zoom, with a slider for the pose.

        Parameters
        ----------
        pose
            Index of the pose that it begins with; the first that can be assembled where None.
        names
            Whether points are named.
        units
            Units of length and force, for the labels.

        Returns
        -------
        object
            What PyVista gives: in a notebook the view, in a terminal None once the window is closed.

        Raises
        ------
        FrameError
            If no pose is assembled, or there is no such pose.
        """
        return show(self, pose, names, units)

    def accuracy(
        self, point: str, link: str | None = None, *, inertia: bool = False, **load: ArrayLike
    ) -> PointAccuracy:
        """Where a point of the loaded linkage really goes: by compliance, by clearance, and in total.

        Parameters
        ----------
        point
            Name of the point.
        link
            The link on which it is taken; the first that has it where None.
        inertia
            Let the inertia forces of the rigid motion act as well.
        **load
            Forces and moments on the point beside the linkage's own loads, ``fx fy fz mx my mz``, global, (...).

        Returns
        -------
        PointAccuracy
            Displacements ``ux uy uz rx ry rz`` by ``compliance``, by ``clearance`` and in ``total``, (..., 6) each,
            length and radians, computed when read.

        Raises
        ------
        FrameError
            If there is no such point or link, the link has it not, or a component of the load is unknown.

        Examples
        --------
        An arm of 1 m on a pin with 0.1 mm of clearance, loaded across: its compliance ``F L^3 / (3 E I)`` (Timoshenko,
        *Strength of Materials* I), and what the pin gives.

        >>> from linkframe.elements import Beam, Material, Rectangle
        >>> from linkframe.models import Linkage
        >>> linkage = Linkage(A=(0, 0), B=(1, 0))
        >>> linkage.link("arm", "A", "B", beam=Beam(Rectangle(y=0.02, z=0.01), Material(E=200e9, nu=0.3)))
        >>> linkage.revolute("A", "ground", "arm", drive=True, clearance=1e-4)
        >>> found = linkage.move(A=0.0).accuracy("B", fy=10.0)
        >>> float(found.compliance[1].round(9)), float(found.clearance[1].round(9))
        (0.0025, 0.0001)
        """
        return accuracy(self, point, link, load, inertia=inertia)

    def page(
        self,
        path: str | Path,
        point: str,
        link: str | None = None,
        *,
        title: str = "",
        drive: str | None = None,
        command: str = "",
        units: Units = SI,
        **deviations: Any,
    ) -> None:
        """Write a page that opens in a browser and follows what is dragged: one file, without a network or server.

        It shows the linkage, the path of a point, what its loads, clearances and tolerances do to it, who is to blame,
        and the forces in its joints. The drive, the load and every clearance and tolerance can be moved; all numbers
        follow, computed in the page from what is linear in them. Springs, gravity and, with rates of the drives,
        inertia act whatever the load's factor. Of very many poses it shows as many as fit, and says so.

        Parameters
        ----------
        path
            ``name.html``.
        point
            Name of the point that is looked at.
        link
            The link on which it is taken; the first that has it where None.
        title
            Its heading.
        drive
            The drive whose values name the poses; the first that moves where None.
        command
            What made it, for its foot.
        units
            Units of length and force, for its table.
        **deviations
            Clearances and tolerances beside those of the description, as for `worst_case`.

        Raises
        ------
        FrameError
            If the motion has not one axis of poses, a name is unknown, or the file cannot be written.

        Examples
        --------
        >>> from pathlib import Path
        >>> from tempfile import TemporaryDirectory
        >>> import numpy as np
        >>> from linkframe.models import Linkage
        >>> linkage = Linkage(A=(0, 0), B=(2, 0))
        >>> linkage.link("arm", "A", "B")
        >>> linkage.revolute("A", "ground", "arm", drive=True, clearance=1e-4)
        >>> with TemporaryDirectory() as folder:
        ...     linkage.move(A=np.linspace(0.0, 1.0, 11)).page(f"{folder}/arm.html", "B")
        ...     "<svg" in Path(folder, "arm.html").read_text(encoding="utf-8")
        True
        """
        has_clearance = any(pair.clearance is not None for pair in self.linkage.joints.values())
        worst = self.worst_case(point, link, **deviations) if deviations or has_clearance else None
        write_page(self, path, point, link, worst, PageText(title, command, units), drive=drive)

    def _repr_html_(self) -> str | None:
        """In a notebook: the page of the point that is loaded, or that alone lies off the joints; else nothing."""
        point = framed_point(self)
        if point is None:
            return None
        has_clearance = any(pair.clearance is not None for pair in self.linkage.joints.values())
        return framed(self, self.worst_case(point) if has_clearance else None, point)

    def reliability(
        self, point: str, limit: float, build: Build, distributions: Mapping[str, Uncertain], **options: Any
    ) -> Reliability:
        """Probability that a point leaves its zone, for uncertain dimensions of the linkage.

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
        **options
            Those of `reliability`: ``method``, ``anywhere``, ``correlation``, ``accuracy``, ``samples``, ``rng`` ...

        Returns
        -------
        Reliability
            Probability of failure at each pose, (poses,), or with ``anywhere=True`` of failing at one of them, ().

        Raises
        ------
        FrameError
            If the motion has more than one axis or lacks a pose, or as `reliability`.

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
        return reliability_of(self, point, limit, build, distributions, **options)

    def compare(self, point: str, measured: Measured, *, deviation: ArrayLike = 0.0, level: float = 0.95) -> Comparison:
        """Compare where a point is with where it was measured.

        Parameters
        ----------
        point
            Name of the point.
        measured
            Its measured positions at the poses of this motion, with their uncertainty; see `read_measured`.
        deviation
            Standard deviation of the prediction, (poses, 3) or what broadcasts to it, a length, such as that of the
            tolerances.
        level
            Probability with which a pose should lie within its band.

        Returns
        -------
        Comparison
            Residuals, their sum of squares, and the poses outside.

        Raises
        ------
        FrameError
            If the motion is at other poses than the measurement, or neither has an uncertainty.
        """
        return comparison_of(self, point, measured, deviation, level)

    def calibrate(
        self,
        point: str,
        measured: Measured,
        build: Build,
        start: Mapping[str, float],
        *,
        scales: Mapping[str, float] | None = None,
    ) -> Calibration:
        """Find the dimensions with which a point goes where it was measured.

        Parameters
        ----------
        point
            Name of the point.
        measured
            Its measured positions at the poses of this motion.
        build
            Called with dimensions by name, (m, 1) each, as keywords; returns the linkage with them.
        start
            Where to begin, by name: the dimensions of this motion.
        scales
            Sizes by which they may change; see `calibrate`.

        Returns
        -------
        Calibration
            Dimensions with their covariance, and the combinations of them that the data cannot tell.

        Raises
        ------
        FrameError
            If the motion is at other poses than the measurement, or as `calibrate`.

        Examples
        --------
        The length of a crank, from two places that its end was seen at.

        >>> import numpy as np
        >>> from linkframe.models import Linkage, Measured
        >>> def crank(length):
        ...     places = np.stack(np.broadcast_arrays(length, 0.0, 0.0), axis=-1)
        ...     linkage = Linkage(A=(0, 0), P=places)
        ...     linkage.link("crank", "A", "P")
        ...     linkage.revolute("A", "ground", "crank", drive=True)
        ...     return linkage
        >>> seen = Measured([[0.2001, 0.0, np.nan], [0.0, 0.2003, np.nan]], 1e-4, {"A": np.radians([0.0, 90.0])})
        >>> found = crank(0.2).move(seen.drives).calibrate("P", seen, crank, {"length": 0.2})
        >>> round(found.values["length"], 9)
        0.2002
        """
        return calibration_of(self, point, measured, build, start, scales)

    def compliance_matrix(self, point: str, link: str | None = None) -> Array:
        """Displacement and rotation of a point by unit forces and moments on it, drives locked, clearances closed.

        About the pose under the linkage's springs, loads and weights: these make links stiffer or softer as they turn
        (geometric stiffness), rigid ones as well. On a linkage of one degree of freedom whose drive has a stiffness k
        it is ``1 / (k + V'')`` with the potential V of springs, loads and weights (Thompson & Hunt, *A General Theory
        of Elastic Stability*, 1973).

        Parameters
        ----------
        point
            Name of the point.
        link
            The link on which it is taken; the first that has it where None.

        Returns
        -------
        ndarray
            ``ux uy uz rx ry rz`` by ``fx fy fz mx my mz``, global, (..., 6, 6); symmetric. Length per force, and
            radians per moment.

        Examples
        --------
        The tip of an arm of 1 m, ``L^3 / (3 E I)``.

        >>> from linkframe.elements import Beam, Material, Rectangle
        >>> from linkframe.models import Linkage
        >>> linkage = Linkage(A=(0, 0), B=(1, 0))
        >>> linkage.link("arm", "A", "B", beam=Beam(Rectangle(y=0.02, z=0.01), Material(E=200e9, nu=0.3)))
        >>> linkage.revolute("A", "ground", "arm", drive=True)
        >>> float(linkage.move(A=0.0).compliance_matrix("B")[1, 1].round(12))
        0.00025
        """
        return compliance_matrix(self, point, link)

    flexibility = RenamedAttribute("compliance_matrix")

    def stiffness(self, point: str, link: str | None = None) -> Array:
        """Force and moment at a point by unit displacements and rotations of it: the inverse of `compliance_matrix`.

        Parameters
        ----------
        point
            Name of the point.
        link
            The link on which it is taken; the first that has it where None.

        Returns
        -------
        ndarray
            ``fx fy fz mx my mz`` by ``ux uy uz rx ry rz``, global, (..., 6, 6); NaN where nothing holds the point in
            some direction. Force per length, and moment per radian.

        Raises
        ------
        FrameError
            If links and joints are rigid on the way to the point, so that it cannot deflect in some direction.

        Examples
        --------
        The tip of an arm of 1 m while it does not rotate, ``12 E I / L^3`` (Przemieniecki 1968, Eq. 5.116).

        >>> from linkframe.elements import Beam, Material, Rectangle
        >>> from linkframe.models import Linkage
        >>> linkage = Linkage(A=(0, 0), B=(1, 0))
        >>> linkage.link("arm", "A", "B", beam=Beam(Rectangle(y=0.02, z=0.01), Material(E=200e9, nu=0.3)))
        >>> linkage.revolute("A", "ground", "arm", drive=True)
        >>> float(linkage.move(A=0.0).stiffness("B")[1, 1].round(6))
        16000.0
        """
        return stiffness(self, point, link)

    def frequencies(self, count: int) -> Array:
        """The lowest natural frequencies at every pose, under springs, loads and weights; drives locked, no clearances.

        Parameters
        ----------
        count
            Number of frequencies, from 1 to the number of unknowns of the frame.

        Returns
        -------
        ndarray
            Hz, (..., count); NaN where the pose is unstable.

        Examples
        --------
        A clamped arm of 1 m, ``3.516 / (2 pi) sqrt(E I / m L^4)`` (Timoshenko, *Vibration Problems in Engineering*).

        >>> from linkframe.elements import Beam, Circle, Material
        >>> from linkframe.models import Linkage
        >>> steel = Material(E=200e9, nu=0.3, density=7850.0)
        >>> linkage = Linkage(A=(0, 0), B=(1, 0))
        >>> linkage.link("arm", "A", "B", beam=Beam(Circle(diameter=0.02), steel, segments=8))
        >>> linkage.revolute("A", "ground", "arm", drive=True)
        >>> linkage.move(A=0.0).frequencies(1).round(2).tolist()
        [14.12]
        """
        return frequencies(self, count)

    def stress(self, link: str) -> Stress:
        """Stress along the members of a link under the linkage's loads and its inertia, clearances closed.

        Loads that were given to a frame of the motion alone are not among them.

        Parameters
        ----------
        link
            Name of the link.

        Returns
        -------
        Stress
            At stations along the members of the link, (..., members, stations, 3), its extremes by pose, and the
            envelope over all poses, force per area.

        Raises
        ------
        FrameError
            If there is no such link, or it is rigid.

        Examples
        --------
        An arm of 1 m under 10 N across, ``s = M / W`` with ``W = b h^2 / 6`` (Timoshenko, *Strength of Materials* I).

        >>> from linkframe.elements import Beam, Material, Rectangle
        >>> from linkframe.models import Linkage
        >>> linkage = Linkage(A=(0, 0), B=(1, 0))
        >>> linkage.link("arm", "A", "B", beam=Beam(Rectangle(y=0.02, z=0.015), Material(E=200e9, nu=0.3)))
        >>> linkage.revolute("A", "ground", "arm", drive=True)
        >>> linkage.load("B", fy=10.0)
        >>> float((linkage.move(A=0.0).stress("arm").greatest / 1e6).round(6))
        10.0
        """
        self._check_frames("stress()")
        return stress(self, link)


def loads_of(frame: Frame) -> tuple[object, ...]:
    """How many loads a frame has at nodes and on members, and which weight."""
    given = (frame.loads, frame.member_loads)
    weight = None if frame.weight is None else (frame.weight.shape, frame.weight.tobytes())
    return *(sum(map(len, loads.values())) for loads in given), weight
