"""The motion of a linkage: where it is, and what can be asked of it there."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ...framework.batch import Array
from ...framework.errors import FrameError
from ...framework.listing import counted
from ...framework.renamed import RenamedAttribute
from .graphics.drawn_motion import DrawnMotion
from .graphics.dxf import save_motion
from .graphics.units import SI, Units
from .measured_motion import MeasuredMotion
from .page.page import PageText, framed, framed_point, write_page
from .page.widget import widget
from .poses.coordinates import coordinate_of, rates_of_coordinate
from .poses.states import PoseState, closure_states
from .statics.transmission import transmission_angle
from .worst_case.worst_case import WorstCase

# Poses up to which what is printed of a motion tells singular ones; beyond, whether they are assembled.
COUNTED = 100_000


@dataclass(frozen=True, eq=False, repr=False)
class Motion(DrawnMotion, MeasuredMotion):
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

    # -- to look at and to save -----------------------------------------------------------------------------------

    def _drawn(self) -> Motion:
        return self

    def save(self, path: str | Path, times: ArrayLike | None = None, *, unit: str = "m") -> None:
        """Write the motion for ParaView or for CAD: links as lines.

        For ParaView points have their velocity and acceleration. With beams, ``motion.frame().solve().save(path)``
        shows them with their displacements and forces.

        Parameters
        ----------
        path
            File ``.pvd``; the poses are files in a folder beside it. Or ``.dxf``, with a layer for each link, a block
            for each pose on a layer of its own, and the paths of points (extra ``dxf``; see `Linkage.save`). Poses that
            are not assembled are left out.
        times
            Increasing times (or angles) of the poses, (poses,), for ParaView; their numbers where None.
        unit
            Unit of the coordinates, for the header of a ``.dxf``: m, cm, mm, in or ft.

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

        if Path(path).suffix == ".dxf":
            if times is not None:
                raise FrameError(
                    f"{Path(path).name} is a drawing, which has no times: save as .pvd for a series in time"
                )
            save_motion(self, Path(path), unit)
            return
        save(self, path, times)

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

        It shows the linkage, the path of a point, what its loads, clearances and tolerances do to it, the share of each
        contributor, and the forces in its joints. The drive, the load and every clearance and tolerance can be moved;
        all numbers follow, computed in the page from what is linear in them. Springs, gravity and, with rates of the
        drives, inertia act whatever the load's factor. Of very many poses it shows as many as fit, and says so.

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
        worst = limits_of(self, point, link, deviations)
        write_page(self, path, point, link, worst, PageText(title, command, units), drive=drive)

    def widget(
        self,
        point: str,
        link: str | None = None,
        *,
        title: str = "",
        drive: str | None = None,
        units: Units = SI,
        **deviations: Any,
    ) -> Any:
        """The page as a widget of a notebook, which gives back what is set on it (extra ``notebook``).

        Parameters
        ----------
        point, link
            The point that is looked at, and the link on which it is taken.
        title, drive, units
            As for `page`.
        **deviations
            Clearances and tolerances beside those of the description, as for `worst_case`.

        Returns
        -------
        anywidget.AnyWidget
            Its traits follow the page and move it: ``pose``, the number of the pose; ``load``, the factor on the loads;
            ``factors``, one on each clearance and tolerance; and ``numbers``, the table by its headings, once it is
            shown. ``drives``, ``clearances`` and ``deviations`` are the values that are set, as `Linkage.move` and
            `worst_case` take them; ``observe`` calls a function when one moves.

        Raises
        ------
        FrameError
            If anywidget is not installed, or as `page`.
        """
        worst = limits_of(self, point, link, deviations)
        return widget(self, point, link, worst, PageText(title, units=units), drive)

    def _repr_html_(self) -> str | None:
        """In a notebook: the page of the point that is loaded, or that alone lies off the joints; else nothing."""
        point = framed_point(self)
        if point is None:
            return None
        return framed(self, limits_of(self, point, None, {}), point)

    flexibility = RenamedAttribute("compliance_matrix")


def limits_of(motion: Motion, point: str, link: str | None, deviations: Mapping[str, Any]) -> WorstCase | None:
    """What clearances and tolerances let a point reach; None where nothing deviates."""
    has_clearance = any(pair.clearance is not None for pair in motion.linkage.joints.values())
    return motion.worst_case(point, link, **deviations) if deviations or has_clearance else None
