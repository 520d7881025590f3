"""The motion of a linkage over a batch of poses, and its methods."""

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
from .export import save
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

# Largest number of poses whose singular ones are counted in the printed form; of more poses only assembled ones are.
COUNTED = 100_000


@dataclass(frozen=True, eq=False, repr=False)
class Motion(DrawnMotion, MeasuredMotion):
    """Motion of a linkage over a batch of poses; made by `Linkage.move`.

    Poses that cannot be assembled have the status ``"not assembled: ..."`` and NaN in all results, as do those in
    another assembly mode than the reference configuration unless ``other_modes`` was given.

    Attributes
    ----------
    linkage
        Description of the linkage.
    mechanism
        Its compiled form.
    drives
        Values, rates and accelerations of the drives.
    assembly
        The closed states of the mechanism.
    """

    def __repr__(self) -> str:
        many = int(np.prod(self.shape)) > COUNTED
        states = closure_states(self.assembly.reached, self.assembly.other) if many else self.state
        return f"<Motion of shape {self.shape} of {self.linkage!r}: {counted(states, PoseState)}>"

    def __getstate__(self) -> dict[str, object]:
        """State for another process, without the frames that are in use in this one."""
        return {name: value for name, value in vars(self).items() if name != "frames"}

    def explain(self) -> str:
        """Explain how the poses were found: their number, and whether NumPy or machine code closes the loops.

        Returns
        -------
        str
            The method, its expected time, and why it was chosen.
        """
        count, left = self.assembly.reached.size, int((~self.assembly.reached).sum())
        beside = f", {left} of them not reached from the reference configuration" if left else ""
        return f"{count} poses{beside}\nNewton's method on the loops: {self.assembly.told}"

    def transmission_angle(self, joint: str) -> Array:
        """Transmission angle at a joint: best at π/2; at 0 the joint cannot transmit motion.

        It is the angle between the force that the joint transmits to its second link and the direction perpendicular to
        the motion of that link's half of the joint: 90° minus the pressure angle. For a four-bar at the joint between
        coupler and rocker it is the acute angle between the two (Norton, *Design of Machinery*, section 4.10); for a
        piston it is the angle between the connecting rod and the perpendicular to the slide. In general, with locked
        drives, the joint can transmit the forces that the links before it can take without moving, and its second link
        has the motions that it has without the joint; the sine of the angle is the largest cosine between a force and a
        motion of these.

        Parameters
        ----------
        joint
            Name of the joint, which transmits motion to its second link.

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
        In a square four-bar the angle is 90°.

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
        """The coordinates of a joint: the position of its second link relative to the first.

        Parameters
        ----------
        joint
            Name of the joint.

        Returns
        -------
        ndarray
            Lengths and radians in the order of the kind's coordinates, (..., f); in the reference configuration they
            are its ``reference``. Angles include the whole turns that the joint makes while the drives move to the pose
            from their reference values. Those of a spherical joint are the rotation vector, of length π at most.

        Raises
        ------
        FrameError
            If there is no such joint.

        Examples
        --------
        In a parallelogram the coupler turns relative to the crank by minus the crank angle.

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
            Lengths and radians per time, (..., f); for a spherical joint the angular velocity, in the joint's axes on
            its first link.

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
            Lengths and radians per time squared, (..., f); for a spherical joint the time derivatives of the components
            of `coordinate_rate`.

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
            Increasing times (or angles) of the poses, (poses,), for ParaView; their numbers if None.
        unit
            Unit of the coordinates, for the header of a ``.dxf``: m, cm, mm, in or ft.

        Raises
        ------
        FrameError
            If the name has another ending, the motion has several axes of poses, or the folder cannot be written.

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
        """Write an interactive page for a browser: one file, without a network or server.

        It shows the linkage, the path of a point, its displacement by loads, clearances and tolerances, the share of
        each contributor, and the forces in the joints. The drive, the load and every clearance and tolerance can be
        changed; the page updates all numbers, which are linear in these. Springs, gravity and, with rates of the
        drives, inertia act independently of the factor on the loads. Of very many poses it shows as many as fit, and
        says so.

        Parameters
        ----------
        path
            Page to write, ``name.html``.
        point
            Name of the point that the page is about.
        link
            The link on which it lies; the first that has it if None.
        title
            Heading of the page.
        drive
            The drive whose values label the poses; the first that moves if None.
        command
            Command that made the page, for its footer.
        units
            Units of length and force, for its table.
        **deviations
            Clearances and tolerances in addition to those of the description, as for `worst_case`.

        Raises
        ------
        FrameError
            If the motion does not have one axis of poses, a name is unknown, or the file cannot be written.

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
        """The page as a notebook widget, whose settings can be read and changed in Python (extra ``notebook``).

        Parameters
        ----------
        point, link
            The point that the page is about, and the link on which it lies.
        title, drive, units
            As for `page`.
        **deviations
            Clearances and tolerances in addition to those of the description, as for `worst_case`.

        Returns
        -------
        anywidget.AnyWidget
            Its traits follow the page and change it: ``pose``, the number of the pose; ``load``, the factor on the
            loads; ``factors``, one on each clearance and tolerance; and ``numbers``, the table by its headings, once it
            is shown. ``drives``, ``clearances`` and ``deviations`` are the values set on the page, as for
            `Linkage.move` and `worst_case`; ``observe`` calls a function when a trait changes.

        Raises
        ------
        FrameError
            If anywidget is not installed, or as for `page`.
        """
        worst = limits_of(self, point, link, deviations)
        return widget(self, point, link, worst, PageText(title, units=units), drive)

    def _repr_html_(self) -> str | None:
        """Page for a notebook, of the only loaded point or else the only one without a joint; None if there is none."""
        point = framed_point(self)
        if point is None:
            return None
        return framed(self, limits_of(self, point, None, {}), point)

    flexibility = RenamedAttribute("compliance_matrix")


def limits_of(motion: Motion, point: str, link: str | None, deviations: Mapping[str, Any]) -> WorstCase | None:
    """Worst case of a point under clearances and tolerances; None if nothing deviates."""
    has_clearance = any(pair.clearance is not None for pair in motion.linkage.joints.values())
    return motion.worst_case(point, link, **deviations) if deviations or has_clearance else None
