"""Joints of any kind between the links of a sketch, with their checks and drives."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from ....framework.batch import Array, all_of, any_of, finite, numbers, vector
from ....framework.checked import not_negative
from ....framework.described.parts import check_ideal
from ....framework.errors import FrameError
from .acting import LoadedSketch
from .joints import COMPONENTS, KINDS, Kind
from .parts import GROUND, Pair, axes_along

# Direction of an axis where none is given.
Z = (0.0, 0.0, 1.0)
ALONG_Z = vector(Z, "axis")


class JoinedSketch(LoadedSketch):
    """Points, links and loads with joints; see `Linkage`."""

    def drive(self, joint: str, *coordinates: str) -> None:
        """Drive a joint of the linkage.

        Parameters
        ----------
        joint
            Name of the joint.
        *coordinates
            The driven coordinates, such as ``"rz"``; all if none is given.

        Raises
        ------
        FrameError
            If there is no such joint or coordinate.

        Examples
        --------
        >>> from linkframe.models import Linkage
        >>> linkage = Linkage(A=(0, 0), B=(2, 0))
        >>> linkage.link("arm", "A", "B")
        >>> linkage.revolute("A", "ground", "arm")
        >>> linkage.drive("A")
        >>> linkage.drives
        {'A': ('rz',)}
        """
        self.drives[joint] = driven_coordinates(joint, self.joint(joint).kind, coordinates or True)

    def check_free(self) -> None:
        """Check that no infinite stiffness constrains a free coordinate of a joint.

        Raises
        ------
        FrameError
            If a stiffness is inf on a coordinate that is free and not driven.
        """
        for name, pair in self.joints.items():
            for coordinate in set(pair.kind.coordinates) - set(self.drives.get(name, ())):
                if np.any(np.isinf(pair.full_stiffness[..., COMPONENTS.index(coordinate)])):
                    raise FrameError(
                        f"stiffness of joint {name!r} is inf on {coordinate}, which a {pair.kind.name} joint leaves "
                        "free: give 0 there, or the stiffness of a spring, or drive it, or take a joint that "
                        "constrains it"
                    )

    # -- adding -----------------------------------------------------------------------------------------------------

    def _add(
        self,
        kind_name: str,
        point: str,
        links: tuple[str, ...],
        axis: ArrayLike,
        drive: bool | Sequence[str],
        stiffness: ArrayLike | None,
        clearance: ArrayLike | None,
        name: str | None,
        replace: bool,
        reference: ArrayLike = 0.0,
        *,
        second_axis: ArrayLike | None = None,
        pitch: ArrayLike = 0.0,
        contact: ArrayLike | None = None,
    ) -> None:
        kind = KINDS[kind_name]
        name = self._joint_name(name, point, kind, links, replace=replace)
        what = f"joint {name!r}"
        self._check_links(what, point, links)
        driven = driven_coordinates(name, kind, drive)
        if driven and len(links) > 2:
            raise FrameError(f"{what} joins {len(links)} links: drive one of its joints by name, drive({name!r})")
        second = None if second_axis is None else vector(second_axis, f"second axis of {what}", flat=True)
        given = ALONG_Z if axis is Z else vector(axis, f"axis of {what}", flat=True), second
        axes = axes_along(name, *given)
        angles = self._coordinates(what, kind.freedom, reference)
        turn = finite(pitch, f"pitch of {what}") if kind_name == "screw" else None
        springs = None if stiffness is None else _springs(what, kind, stiffness)
        gap = None if clearance is None else not_negative(clearance, f"clearance of {what}")
        touch = None if contact is None else finite(contact, f"contact of {what}")
        if touch is not None and gap is None:
            raise FrameError(f"{what} has a contact angle and no clearance: give its clearance, too")
        shapes = {"axis": axes.shape[:-2], "reference": angles.shape[:-1], "pitch": () if turn is None else turn.shape}
        names = [name if index == 0 else f"{name}.{other}" for index, other in enumerate(links[1:])]
        taken = [own for own in names if own in self.joints]
        if taken and not replace:
            raise FrameError(f"joint {taken[0]!r} is there already: give this one another name=")
        self._join({f"{of} of {what}": shape for of, shape in shapes.items()}, instead=replace)
        for own, other in zip(names, links[1:], strict=True):
            self.joints[own] = Pair(own, kind, point, links[0], other, axes, angles, springs, gap, turn, touch, given)
            self.drives.pop(own, None)
        if driven:
            self.drives[name] = driven

    def _joint_name(self, name: str | None, point: str, kind: Kind, links: tuple[str, ...], *, replace: bool) -> str:
        choices = [point, f"{point}.{kind.name}"] if name is None else [name]
        if replace and name is not None:
            return name
        if name is None and (existing := self._between(kind, point, links)) is not None:
            if replace:
                return existing.name
            raise FrameError(
                f"joint {existing.name!r} joins {existing.first!r} and {existing.second!r} by a {kind.name} joint at "
                f"{point!r} "
                "already: give replace=True to put this one in its place, or name= to have both"
            )
        for choice in choices:
            if choice not in self.joints:
                return choice
        raise FrameError(
            f"joint {choices[-1]!r} is there already: give this one another name=, or replace=True to put it there"
        )

    def _between(self, kind: Kind, point: str, links: tuple[str, ...]) -> Pair | None:
        """A joint of a kind at a point between the first and any other of the links."""
        first, *others = links
        for own in self.joints.values():
            forth = own.first == first and own.second in others
            if (forth or (own.second == first and own.first in others)) and own.point == point and own.kind == kind:
                return own
        return None

    def _check_links(self, what: str, point: str, links: tuple[str, ...]) -> None:
        if len(links) < 2:
            raise FrameError(f"{what} joins only {links[0]!r}: name the links that it joins, such as 'ground'")
        if len(set(links)) < len(links):
            raise FrameError(f"{what} joins {' and '.join(links)}: name different links")
        for link in links:
            if link != GROUND and point not in self._link(link, what).points:
                self._point(point, what)
                raise FrameError(
                    f"{what}: link {link!r} has no point {point!r}: add it to the link, which has "
                    f"{', '.join(self.links[link].points)}"
                )

    def _coordinates(self, what: str, freedom: int, reference: ArrayLike) -> Array:
        given = finite(reference, f"reference value of {what}")
        if freedom == 1:
            given = given[..., None]
        if given.ndim == 0:
            given = np.full(freedom, given)
        if given.shape[-1:] != (freedom,):
            raise FrameError(
                f"reference value of {what} has shape {given.shape}: its last axis must hold {freedom} coordinates"
            )
        return given


def driven_coordinates(joint: str, kind: Kind, names: bool | Sequence[str]) -> tuple[str, ...]:
    """Driven coordinates of a joint: those named, or all or none for True or False.

    Raises
    ------
    FrameError
        If the joint has no such coordinate.
    """
    free = kind.coordinates
    if isinstance(names, (bool, np.bool_)):
        named = free if names else ()
    elif isinstance(names, (str, list, tuple)):
        named = (names,) if isinstance(names, str) else tuple(names)
    else:
        raise FrameError(f"drive of joint {joint!r} is {names!r}: give True, or coordinates of {', '.join(free)}")
    if not free and (named or names):
        raise FrameError(f"joint {joint!r} is fixed: drive another, or make it a joint with a coordinate")
    wrong = [name for name in named if name not in free]
    if wrong:
        raise FrameError(f"joint {joint!r} has no coordinate {wrong[0]!r}: choose of {', '.join(free)}")
    return tuple(name for name in free if name in named)


def _springs(what: str, kind: Kind, value: ArrayLike) -> Array:
    springs = numbers(value, f"stiffness of {what}")
    if springs.shape[-1:] != (6,) or not all_of(springs >= 0.0):  # NaN is not
        raise FrameError(f"stiffness of {what} is {springs.tolist()}: give six springs ux uy uz rx ry rz, 0 to inf")
    if springs.ndim > 1 and any_of(np.isinf(springs)):
        # an infinite stiffness on a free coordinate has a message of its own, see `check_free`
        check_ideal(what, np.where([name not in kind.coordinates for name in COMPONENTS], springs, 0.0))
    return springs
