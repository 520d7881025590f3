"""Springs, forces, torques and gravity on the points and links of a linkage."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from ....framework.batch import Array, Shape, finite, join, vector
from ....framework.checked import not_negative
from ....framework.dofs import FORCES
from ....framework.errors import FrameError
from ....framework.renamed import renamed_keywords
from .parts import GROUND, LinkageSpring, Load
from .sketch import End, Sketch


class LoadedSketch(Sketch):
    """Points and links with springs and loads; see `Linkage`."""

    def spring(
        self,
        first: End,
        second: End,
        *,
        stiffness: ArrayLike,
        length: ArrayLike,
        damping: ArrayLike = 0.0,
        replace: bool = False,
    ) -> None:
        """Add a spring with a parallel damper between two points; several different ones act in parallel.

        Parameters
        ----------
        first, second
            A point, or ``(link, point)`` if several links have it.
        stiffness
            Force per length, (...).
        length
            Unstretched length, (...).
        damping
            Force per speed, (...).
        replace
            Whether it replaces all springs between the same two ends.

        Raises
        ------
        FrameError
            If an end is unknown, both are the same, a number is negative, or the same spring exists already.

        Examples
        --------
        A spring of 100 N/m that is stretched by 0.2 m pulls a level arm of 1 m downwards.

        >>> from linkframe.models import Linkage
        >>> linkage = Linkage(A=(0, 0), B=(1, 0), C=(1, -0.5))
        >>> linkage.link("arm", "A", "B")
        >>> linkage.revolute("A", "ground", "arm", drive=True)
        >>> linkage.spring("B", ("ground", "C"), stiffness=100.0, length=0.3)
        >>> linkage.move().reactions().drive("A").round(9).tolist()
        [20.0]
        """
        ends = self.end(first, "spring"), self.end(second, "spring")
        if ends[0] == ends[1]:
            raise FrameError(f"spring: both ends are {ends[0][1]!r} on {ends[0][0]!r}: give two points")
        between = f"of the spring {ends[0][1]}-{ends[1][1]}"
        numbers = (("stiffness", stiffness), ("length", length), ("damping", damping))
        new = LinkageSpring(*ends, *(not_negative(v, f"{what} {between}") for what, v in numbers))
        there = [old for old in self.springs if {old.first, old.second} == set(ends)]
        if replace:
            self.springs = [old for old in self.springs if old not in there]
        elif any(
            _same((old.stiffness, old.length, old.damping), (new.stiffness, new.length, new.damping)) for old in there
        ):
            raise FrameError(
                f"the spring {ends[0][1]}-{ends[1][1]} is there already: give replace=True to put this one in its "
                "place, or one spring of twice the stiffness"
            )
        self.springs.append(new)

    @renamed_keywords(follows="follower")
    def load(
        self,
        point: str,
        *,
        link: str | None = None,
        fx: ArrayLike = 0.0,
        fy: ArrayLike = 0.0,
        fz: ArrayLike = 0.0,
        mx: ArrayLike = 0.0,
        my: ArrayLike = 0.0,
        mz: ArrayLike = 0.0,
        follower: bool = False,
        replace: bool = False,
    ) -> None:
        """Load a point with a force and a moment, global; different loads add up.

        They act in all results of the motion: reactions, drive forces, stress, accuracy, and in its frames.

        Parameters
        ----------
        point
            Name of the point.
        link
            The link that carries the load; the first that has the point if None.
        fx, fy, fz, mx, my, mz
            Components of force and moment, (...); with as many entries as the motion has poses, they differ from pose
            to pose.
        follower
            Whether they rotate with the link, as the thrust of an engine does; their components are then those in the
            reference configuration. They rotate as the link does in the rigid motion: a further rotation by deflection,
            in stiffness under load and at large displacement, does not rotate them.
        replace
            Whether they replace all loads on this point of the link.

        Raises
        ------
        FrameError
            If there is no such point, no link has it, or the same load exists already.

        Examples
        --------
        A weight of 10 N at the end of a level arm of 2 m takes a drive torque of 20 N m.

        >>> from linkframe.models import Linkage
        >>> linkage = Linkage(A=(0, 0), B=(2, 0))
        >>> linkage.link("arm", "A", "B")
        >>> linkage.revolute("A", "ground", "arm", drive=True)
        >>> linkage.load("B", fy=-10.0)
        >>> linkage.move().reactions().drive("A").round(9).tolist()
        [20.0]
        """
        where = self.end(point if link is None else (link, point), "load")
        if link is None and where[0] == GROUND:
            raise FrameError(f"load: no link has point {point!r}: add it to the link that is loaded")
        self._act(Load(*where, _six(f"load on {point!r}", fx, fy, fz, mx, my, mz), follower), replace=replace)

    @renamed_keywords(follows="follower")
    def torque(
        self,
        link: str,
        *,
        mx: ArrayLike = 0.0,
        my: ArrayLike = 0.0,
        mz: ArrayLike = 0.0,
        follower: bool = False,
        replace: bool = False,
    ) -> None:
        """Load a link with a moment, global; different moments add up.

        Parameters
        ----------
        link
            Name of the link.
        mx, my, mz
            Components of the moment, (...).
        follower
            As for `load`.
        replace
            Whether it replaces all torques on the link.

        Raises
        ------
        FrameError
            If there is no such link, or the same torque exists already.

        Examples
        --------
        >>> from linkframe.models import Linkage
        >>> linkage = Linkage(A=(0, 0), B=(2, 0))
        >>> linkage.link("arm", "A", "B")
        >>> linkage.revolute("A", "ground", "arm", drive=True)
        >>> linkage.torque("arm", mz=3.0)
        >>> linkage.move().reactions().drive("A").round(9).tolist()
        [-3.0]
        """
        self._link(link, "torque")
        self._act(Load(link, None, _six(f"torque on {link!r}", 0.0, 0.0, 0.0, mx, my, mz), follower), replace=replace)

    def gravity(self, acceleration: ArrayLike) -> None:
        """Apply gravity to all links.

        Parameters
        ----------
        acceleration
            Acceleration of gravity, global, (..., 2 or 3), length per time squared.

        Raises
        ------
        FrameError
            If these are not two or three finite numbers.

        Examples
        --------
        >>> from linkframe.models import Linkage
        >>> linkage = Linkage(A=(0, 0), B=(2, 0))
        >>> linkage.link("arm", "A", "B", mass=3.0)
        >>> linkage.revolute("A", "ground", "arm", drive=True)
        >>> linkage.gravity((0.0, -9.81))
        >>> linkage.move().reactions().drive("A").round(9).tolist()
        [29.43]
        """
        self.weight = vector(acceleration, "gravity", flat=True)

    def _act(self, new: Load, *, replace: bool) -> None:
        """Add a load, or replace those at the same point or link."""
        there = [old for old in self.loads if (old.link, old.point) == (new.link, new.point)]
        if replace:
            self.loads = [old for old in self.loads if old not in there]
        elif any(old.follower == new.follower and _same((old.value,), (new.value,)) for old in there):
            what = f"load on {new.point!r}" if new.point else f"torque on {new.link!r}"
            raise FrameError(
                f"the same {what} is there already: give replace=True to put this one in its place, or one load of "
                "twice the value"
            )
        self.loads.append(new)


def _same(some: Sequence[Array], others: Sequence[Array]) -> bool:
    return all(np.array_equal(one, other) for one, other in zip(some, others, strict=True))


def _six(what: str, *components: ArrayLike) -> Array:
    given = {f"{name} of the {what}": finite(value, what) for name, value in zip(FORCES, components, strict=True)}
    known: dict[str, Shape] = {}
    for name, value in given.items():
        if value.shape:
            join(known, name, value.shape)
    return np.stack(np.broadcast_arrays(*given.values()), axis=-1)
