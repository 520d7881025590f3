"""What is drawn of a linkage: its points and links, and the springs and loads on them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike

from ....framework.batch import Array, Shape, finite, joined
from ....framework.dofs import FORCES
from ....framework.errors import FrameError
from ....framework.protocol import LineElement
from ....framework.renamed import renamed_keywords
from .parts import GROUND, LinkageLink, LinkageSpring, Load, Pair, beams_of, in_space, inertia_of

End = str | tuple[str, str]


class Sketch:
    """Points, links, springs and loads; see `Linkage`.

    Parameters
    ----------
    points
        Points by name, for names that are no Python identifiers.
    **named
        The same by keyword.
    """

    def __init__(self, points: Mapping[str, ArrayLike] | None = None, /, **named: ArrayLike) -> None:
        self.points: dict[str, Array] = {}
        self.links: dict[str, LinkageLink] = {}
        self.joints: dict[str, Pair] = {}
        self.drives: dict[str, tuple[str, ...]] = {}
        self.springs: list[LinkageSpring] = []
        self.loads: list[Load] = []
        self.weight: Array = np.zeros(3)
        self._shapes: dict[str, Shape] = {}
        self._shape: Shape = ()
        for name, place in {**(points or {}), **named}.items():
            self.point(name, place)

    @property
    def shape(self) -> Shape:
        """Batch shape of the description."""
        return self._shape

    # -- points and links -------------------------------------------------------------------------------------------

    def point(self, name: str, place: ArrayLike) -> None:
        """Add a point.

        Parameters
        ----------
        name
            Name by which links and joints refer to it.
        place
            Coordinates in the reference configuration, length, (..., 2) in the plane z = 0, or (..., 3).

        Raises
        ------
        FrameError
            If the name is taken, or `place` is not two or three finite numbers.

        Examples
        --------
        >>> from linkframe.models import Linkage
        >>> linkage = Linkage()
        >>> linkage.point("A", (0.0, 0.1))
        >>> linkage.points["A"].tolist()
        [0.0, 0.1, 0.0]
        """
        if name in self.points:
            raise FrameError(f"point {name!r} is there already: choose another name")
        given = in_space(place, f"point {name!r}") + 0.0
        self._join({f"point {name!r}": given.shape[:-1]})
        # what is compiled is taken up again while the description holds the same arrays
        given.setflags(write=False)
        self.points[name] = given

    def link(
        self,
        name: str,
        *points: str,
        beam: LineElement | Mapping[tuple[str, str], LineElement] | None = None,
        beams: Sequence[tuple[str, str]] | None = None,
        mass: ArrayLike | None = None,
        centre: ArrayLike | None = None,
        inertia: ArrayLike | None = None,
        length: ArrayLike | None = None,
    ) -> None:
        """Add a link: a body with points on it.

        Parameters
        ----------
        name
            Name by which joints refer to it.
        *points
            Names of its points, one or more; beams follow them in this order. Points of a straight stretch may come in
            any order: where the line would run back over itself, one bar has them all.
        beam
            Beam of each part, or any other line element, or a mapping from pairs of points to such; None for a rigid
            link.
        beams
            Pairs of points between which beams run, where they do not follow the points.
        mass, centre, inertia
            Mass (...), centre of mass in the reference configuration (..., 2 or 3), and inertia about it in global axes
            then: a tensor (..., 3, 3), six numbers xx yy zz xy yz zx, or one number about z. Where not given, those of
            the beams.
        length
            True length (...) of a link of two points where the points do not give it: the second point then lies
            this far from the first. Assembly starts from the reference configuration.

        Raises
        ------
        FrameError
            If the name is taken, a point is unknown or given twice, or a number is not what it should be.

        Examples
        --------
        A rigid triangle that weighs 2 kg, and a bar whose stiffness and weight are those of a beam.

        >>> from linkframe.elements import Beam, Circle, Material
        >>> from linkframe.models import Linkage
        >>> linkage = Linkage(A=(0, 0), B=(1, 0), C=(0, 1), D=(2, 0))
        >>> linkage.link("triangle", "A", "B", "C", mass=2.0, centre=(0.3, 0.3), inertia=0.1)
        >>> linkage.link("bar", "B", "D", beam=Beam(Circle(diameter=0.02), Material(E=200e9, nu=0.3, density=7850.0)))
        >>> list(linkage.links)
        ['triangle', 'bar']
        """
        if name in self.links or name == GROUND:
            raise FrameError(f"link {name!r} is there already: choose another name")
        if not points:
            raise FrameError(f"link {name!r} has no points: name the points that lie on it")
        for point in points:
            if not isinstance(point, str):
                raise FrameError(f"link {name!r}: {point!r} is not the name of a point: name the points one by one")
            self._point(point, f"link {name!r}")
        if len(set(points)) < len(points):
            raise FrameError(f"link {name!r} has points {', '.join(points)}: name each point once")
        true = None if length is None else self._above_zero(length, f"length of link {name!r}")
        if true is not None:
            if len(points) != 2:
                raise FrameError(f"link {name!r} has {len(points)} points: length= needs exactly two; move its points")
            if np.any(np.all(self.points[points[0]] == self.points[points[1]], axis=-1)):
                raise FrameError(f"link {name!r}: {points[0]} and {points[1]} coincide: draw them apart for length=")
        link = LinkageLink(
            name,
            points,
            beams_of(name, points, beam, beams, self.points),
            None if mass is None else self._not_negative(mass, f"mass of link {name!r}"),
            None if centre is None else in_space(centre, f"centre of link {name!r}"),
            inertia_of(name, inertia),
            true,
        )
        if true is not None:
            self._join({f"length of link {name!r}": true.shape})
        self.links[name] = link

    # -- springs and loads ------------------------------------------------------------------------------------------

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
        """Put a spring, with a damper beside it, between two points; several that differ act side by side.

        Parameters
        ----------
        first, second
            A point, or ``(link, point)`` where several links have it.
        stiffness
            Force per length, (...).
        length
            Length without force, (...).
        damping
            Force per speed, (...).
        replace
            Whether it takes the place of all springs between the same two ends.

        Raises
        ------
        FrameError
            If an end is unknown, both are the same, a number is below zero, or the same spring is there already.

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
        new = LinkageSpring(*ends, *(self._not_negative(v, f"{what} {between}") for what, v in numbers))
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
        """Load a point with a force and a moment, global; loads that differ add up.

        They act in all that is asked of the motion: reactions, drive forces, stress, accuracy, and in its frames.

        Parameters
        ----------
        point
            Name of the point.
        link
            The link that carries the load; the first that has the point where None.
        fx, fy, fz, mx, my, mz
            Components of force and moment, (...); with as many entries as the motion has poses, they differ from pose
            to pose.
        follower
            Whether they turn with the link, as the thrust of an engine does; their components are then
            those in the reference configuration.
        replace
            Whether they take the place of all loads on this point of the link.

        Raises
        ------
        FrameError
            If there is no such point, no link has it, or the same load is there already.

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
        """Load a link with a moment, global; moments that differ add up.

        Parameters
        ----------
        link
            Name of the link.
        mx, my, mz
            Components of the moment, (...).
        follower
            As for `load`.
        replace
            Whether it takes the place of all torques on the link.

        Raises
        ------
        FrameError
            If there is no such link, or the same torque is there already.

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
        """Let gravity act on all links.

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
        self.weight = in_space(acceleration, "gravity")

    def _act(self, new: Load, *, replace: bool) -> None:
        """Add a load, or put it in the place of those that act there."""
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

    # -- look-up ----------------------------------------------------------------------------------------------------

    def joint(self, name: str) -> Pair:
        """Look up a joint.

        Parameters
        ----------
        name
            Its name: that of its point, if none was given.

        Returns
        -------
        Pair
            Kind, links, point and axes of the joint.

        Raises
        ------
        FrameError
            If there is none.
        """
        if name not in self.joints:
            raise FrameError(f"the linkage has no joint {name!r}: {_known(self.joints, 'joints')}")
        return self.joints[name]

    def end(self, where: End, what: str = "the linkage") -> tuple[str, str]:
        """``(link, point)`` of a point, or of a link and a point.

        Parameters
        ----------
        where
            A point, which means the first link that has it, or ``(link, point)``.
        what
            Who asks, for the error.

        Returns
        -------
        tuple of str
            Link, ``"ground"`` where no link has the point, and point.

        Raises
        ------
        FrameError
            If there is no such point or link, or the link has it not.
        """
        if isinstance(where, str):
            self._point(where, what)
            return next((name for name, link in self.links.items() if where in link.points), GROUND), where
        link, point = where
        self._point(point, what)
        if link != GROUND and point not in self._link(link, what).points:
            raise FrameError(
                f"{what}: link {link!r} has no point {point!r}: it has {', '.join(self.links[link].points)}"
            )
        return link, point

    def _point(self, name: str, what: str) -> Array:
        if name not in self.points:
            raise FrameError(f"{what}: there is no point {name!r}: {_known(self.points, 'points')}")
        return self.points[name]

    def _link(self, name: str, what: str) -> LinkageLink:
        if name not in self.links:
            raise FrameError(f"{what}: there is no link {name!r}: {_known(self.links, 'links')}")
        return self.links[name]

    def _join(self, given: Mapping[str, Shape], *, instead: bool = False) -> None:
        """Widen the batch by the shapes of what one call gives: by all of them, or by none where one does not fit.

        With `instead` they take the place of what was given under the same names.
        """
        known = {what: shape for what, shape in self._shapes.items() if not (instead and what in given)}
        whole = np.broadcast_shapes(*known.values())
        for what, shape in given.items():
            whole = joined(what, shape, known)
            known[what] = shape
        self._shape, self._shapes = whole, known

    @staticmethod
    def _above_zero(value: ArrayLike, what: str) -> Array:
        given = finite(value, what)
        if np.any(given <= 0.0):
            raise FrameError(f"{what} is {given[given <= 0.0].flat[0]:g}: give a number above zero")
        return given

    @staticmethod
    def _not_negative(value: ArrayLike, what: str) -> Array:
        given = finite(value, what)
        if np.any(given < 0.0):
            raise FrameError(f"{what} is {given[given < 0.0].flat[0]:g}: give zero or above")
        return given


def _same(some: Sequence[Array], others: Sequence[Array]) -> bool:
    return all(np.array_equal(one, other) for one, other in zip(some, others, strict=True))


def _six(what: str, *components: ArrayLike) -> Array:
    given = {f"{name} of the {what}": finite(value, what) for name, value in zip(FORCES, components, strict=True)}
    known: dict[str, Shape] = {}
    for name, value in given.items():
        joined(name, value.shape, known)
        known[name] = value.shape
    return np.stack(np.broadcast_arrays(*given.values()), axis=-1)


def _known(names: Iterable[str], kind: str) -> str:
    """The remedy where a name is unknown."""
    text = ", ".join(names)
    return f"choose one of {text}" if text else f"no {kind} are defined yet"
