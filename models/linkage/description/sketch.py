"""Points and links of a linkage."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike

from ....framework.batch import Array, Shape, joined, vector
from ....framework.checked import above_zero, not_negative
from ....framework.errors import FrameError
from ....framework.protocol import LineElement
from .parts import GROUND, LinkageLink, LinkageSpring, Load, Pair, beams_of, inertia_of

End = str | tuple[str, str]


class Sketch:
    """Points and links of a linkage; see `Linkage`.

    Parameters
    ----------
    points
        Coordinates by name of the point, for names that are not Python identifiers.
    **named
        Coordinates of points by keyword.
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
        given = vector(place, f"point {name!r}", flat=True) + 0.0
        self._join({f"point {name!r}": given.shape[:-1]})
        # the compiled mechanism is reused as long as the description has the same arrays
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
            Names of its points, one or more; beams follow them in this order. Points on a straight line may be given in
            any order: if the line would run back over itself, there is one bar with all of them.
        beam
            Beam or other line element between successive points, or a mapping from pairs of points to such elements;
            None for a rigid link.
        beams
            Pairs of points between which beams run, if they do not follow the points.
        mass, centre, inertia
            Mass (...), centre of mass in the reference configuration (..., 2 or 3), and inertia about it in global axes
            in that configuration: a tensor (..., 3, 3), six numbers xx yy zz xy yz zx, or one number about z. By
            default, those of the beams.
        length
            Length (...) of a link of two points, if it is not their distance: the second point is then this far from
            the first. Assembly starts from the reference configuration.

        Raises
        ------
        FrameError
            If the name is taken, a point is unknown or given twice, or a number is not valid.

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
        true = None if length is None else above_zero(length, f"length of link {name!r}")
        if true is not None:
            if len(points) != 2:
                raise FrameError(f"link {name!r} has {len(points)} points: length= needs exactly two; move its points")
            if np.any(np.all(self.points[points[0]] == self.points[points[1]], axis=-1)):
                raise FrameError(f"link {name!r}: {points[0]} and {points[1]} coincide: draw them apart for length=")
        link = LinkageLink(
            name,
            points,
            beams_of(name, points, beam, beams, self.points),
            None if mass is None else not_negative(mass, f"mass of link {name!r}"),
            None if centre is None else vector(centre, f"centre of link {name!r}", flat=True),
            None if inertia is None else inertia_of(name, inertia),
            true,
        )
        if true is not None:
            self._join({f"length of link {name!r}": true.shape})
        self.links[name] = link

    # -- look-up ----------------------------------------------------------------------------------------------------

    def joint(self, name: str) -> Pair:
        """Look up a joint.

        Parameters
        ----------
        name
            Its name, by default that of its point.

        Returns
        -------
        Pair
            Kind, links, point and axes of the joint.

        Raises
        ------
        FrameError
            If there is no such joint.
        """
        if name not in self.joints:
            raise FrameError(f"the linkage has no joint {name!r}: {_known(self.joints, 'joints')}")
        return self.joints[name]

    def end(self, where: End, what: str = "the linkage") -> tuple[str, str]:
        """Link and point, from a point alone or from both.

        Parameters
        ----------
        where
            A point, on the first link that has it, or ``(link, point)``.
        what
            What needs it, for error messages.

        Returns
        -------
        tuple of str
            Link, ``"ground"`` if no link has the point, and point.

        Raises
        ------
        FrameError
            If there is no such point or link, or the link does not have the point.
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
        """Broadcast the batch shape with the shapes of one call; it stays unchanged if one of them does not fit.

        With `instead` they replace earlier shapes of the same names.
        """
        if not instead and not any(given.values()):  # as most often
            return
        known = {what: shape for what, shape in self._shapes.items() if not (instead and what in given)}
        whole = np.broadcast_shapes(*known.values()) if len(known) < len(self._shapes) else self._shape
        for what, shape in given.items():
            if shape:
                whole = joined(what, shape, known)
            known[what] = shape
        self._shape, self._shapes = whole, known


def _known(names: Iterable[str], kind: str) -> str:
    """The remedy for an unknown name."""
    text = ", ".join(names)
    return f"choose one of {text}" if text else f"no {kind} are defined yet"


def place(linkage: Sketch, link: str, point: str) -> Array:
    """Position of a point in its link's axes, (..., 3), which are the global ones in the reference configuration.

    It is the given position, except for the second point of a link with a given length.
    """
    reference_place, given = linkage.points[point], linkage.links.get(link)
    if given is None or given.length is None or point == given.points[0]:
        return reference_place
    start = linkage.points[given.points[0]]
    chord = reference_place - start
    return np.asarray(start + chord * (given.length / np.linalg.norm(chord, axis=-1))[..., None])


def places(linkage: Sketch, link: str) -> dict[str, Array]:
    """Reference positions of all points of a link, see `place`; for the ground, of all points of the linkage."""
    points = linkage.links[link].points if link in linkage.links else linkage.points
    return {point: place(linkage, link, point) for point in points}
