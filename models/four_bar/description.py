"""The four-bar linkage: lengths, coupler point, branch, and what its links and joints are made of."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...elements import Beam, Material, Rectangle
from ...elements.parameters import as_real
from ...framework.batch import finite, join, joined, numbers
from ...framework.errors import FrameError
from .closure import BRANCHES, Closure

Array = NDArray[np.float64]

PerJoint = ArrayLike | Mapping[str, ArrayLike]

LINKS = ("crank", "coupler", "rocker")
JOINTS = ("B", "D", "E")
# Components of the load on P.
LOADS = ("fx", "fy", "mz")


def known(kind: str, name: str, names: Iterable[str]) -> str:
    """The name of a point, link or joint, checked to be one of `names`."""
    if name not in names:
        raise FrameError(f"the four-bar has no {kind} {name!r}: choose one of {', '.join(names)}")
    return name


def check_joints(given: Iterable[str], what: str) -> None:
    """Check that all names are those of passive joints."""
    for joint in given:
        if joint not in JOINTS:
            raise FrameError(f"{what} of joint {joint!r}: the four-bar's passive joints are {', '.join(JOINTS)}")


def each_joint(given: PerJoint) -> dict[str, ArrayLike]:
    """By passive joint what is given for all of them at once, or for some by name; 0 for the others."""
    return {joint: given.get(joint, 0.0) if isinstance(given, Mapping) else given for joint in JOINTS}


@cache
def _bar() -> Beam:
    return Beam(Rectangle(y=12.7e-3, z=6.35e-3), Material(E=2e11, nu=0.3, density=7850.0))


@dataclass(frozen=True, eq=False)
class FourBarDescription:
    """Lengths, coupler point, branch, beams and joints of a four-bar; see `FourBar`."""

    crank: ArrayLike = 0.1
    coupler: ArrayLike = 0.2
    rocker: ArrayLike = 0.1
    ground: ArrayLike = 0.2
    point: tuple[ArrayLike, ArrayLike] = (0.1, 0.0)
    branch: str | None = None
    beam: Beam | Mapping[str, Beam] = field(default_factory=_bar)
    stiffness: ArrayLike | Mapping[str, ArrayLike] = (2e11, 2e11, 2e11, 2e11, 2e11, 0.0)

    def __post_init__(self) -> None:
        for name in (*LINKS, "ground"):
            value = finite(getattr(self, name), f"{name} of the four-bar")
            if np.any(value <= 0.0):
                raise FrameError(f"{name} of the four-bar is {value[value <= 0.0].flat[0]}: give a positive length")
            object.__setattr__(self, name, as_real(value))
        if not isinstance(self.point, tuple | list) or len(self.point) != 2:
            raise FrameError(f"point of the four-bar is {self.point!r}: give a pair (x, y) in the coupler's axes")
        point = (as_real(finite(v, f"point {axis}")) for axis, v in zip("xy", self.point, strict=True))
        object.__setattr__(self, "point", tuple(point))
        shapes: dict[str, tuple[int, ...]] = {}
        for name, shape in self._shapes().items():
            join(shapes, name, shape)
        a, b, c, d = self.lengths
        if self.branch is None:
            object.__setattr__(self, "branch", "parallel" if np.all(a == c) and np.all(b == d) else "open")
        if self.branch not in BRANCHES:
            raise FrameError(f"branch of the four-bar is {self.branch!r}: choose one of {', '.join(BRANCHES)}")
        for what, given, known in (("beam", self.beam, LINKS), ("stiffness", self.stiffness, JOINTS)):
            if isinstance(given, Mapping) and set(given) != set(known):
                raise FrameError(f"{what} of the four-bar is given for {sorted(given)}: give one for each of {known}")
        for link in LINKS:
            if not isinstance(beam := self.link_beam(link), Beam):
                raise FrameError(f"beam of the {link} is {beam!r}: give a Beam")
        if isinstance(self.stiffness, Mapping):
            each = {joint: _springs(self.stiffness[joint], f"stiffness of joint {joint!r}") for joint in JOINTS}
            object.__setattr__(self, "stiffness", each)
        else:
            object.__setattr__(self, "stiffness", _springs(self.stiffness, "stiffness of the joints"))

    def _shapes(self) -> dict[str, tuple[int, ...]]:
        shapes = {name: np.shape(getattr(self, name)) for name in (*LINKS, "ground")}
        return shapes | {f"point {axis}": np.shape(value) for axis, value in zip("xy", self.point, strict=True)}

    @property
    def lengths(self) -> tuple[Array, Array, Array, Array]:
        """Lengths of crank, coupler, rocker and ground, each (...)."""
        a, b, c, d = (np.asarray(getattr(self, name), dtype=np.float64) for name in (*LINKS, "ground"))
        return a, b, c, d

    def link_beam(self, link: str) -> Beam:
        """Cross-section, material and shear of a link, as given or the default.

        Parameters
        ----------
        link
            One of ``"crank"``, ``"coupler"`` and ``"rocker"``.

        Returns
        -------
        Beam
            Element of the link in the frame.

        Raises
        ------
        FrameError
            If there is no such link.
        """
        known("link", link, LINKS)
        return self.beam[link] if isinstance(self.beam, Mapping) else self.beam

    def joint_stiffness(self, joint: str) -> Array:
        """Six springs of a passive joint, as given or the default.

        Parameters
        ----------
        joint
            One of ``"B"``, ``"D"`` and ``"E"``.

        Returns
        -------
        ndarray
            ``ktx kty ktz krx kry krz``, (..., 6), force per length and moment per radian.

        Raises
        ------
        FrameError
            If there is no such joint.
        """
        known("passive joint", joint, JOINTS)
        return np.asarray(self.stiffness[joint] if isinstance(self.stiffness, Mapping) else self.stiffness)

    def _closure(self, theta: ArrayLike) -> Closure:
        angle = finite(theta, "drive angle theta")
        joined("drive angle theta", angle.shape, self._shapes())
        return Closure(*self.lengths, angle, str(self.branch))

    def gap(self, theta: ArrayLike) -> Array:
        """Distance that coupler and rocker lack to close the loop at drive angles; 0 where it closes.

        Parameters
        ----------
        theta
            Drive angles, radians, (...).

        Returns
        -------
        ndarray
            Length, (...).

        Examples
        --------
        >>> import numpy as np
        >>> from linkframe.models import FourBar
        >>> four_bar = FourBar(crank=3.0, coupler=1.0, rocker=1.0, ground=2.0)
        >>> four_bar.gap(np.radians([0.0, 180.0])).round(12).tolist()
        [0.0, 3.0]
        """
        return self._closure(theta).gap

    def assembles(self, theta: ArrayLike) -> NDArray[np.bool_]:
        """Whether the four-bar can be assembled at drive angles.

        Parameters
        ----------
        theta
            Drive angles, radians, (...).

        Returns
        -------
        ndarray
            True where it can, (...).

        Examples
        --------
        >>> import numpy as np
        >>> from linkframe.models import FourBar
        >>> FourBar(crank=3.0, coupler=1.0, rocker=1.0, ground=2.0).assembles(np.radians([0.0, 90.0])).tolist()
        [True, False]
        """
        return np.asarray(self.gap(theta) == 0.0)

    def singular(self, theta: ArrayLike) -> NDArray[np.bool_]:
        """Whether coupler and rocker lie in line at drive angles, so that the drive does not determine their motion.

        Parameters
        ----------
        theta
            Drive angles, radians, (...).

        Returns
        -------
        ndarray
            True where they do, (...).

        Examples
        --------
        The symmetric linkage of the accuracy paper is singular where its crank lies along the ground.

        >>> import numpy as np
        >>> from linkframe.models import FourBar
        >>> FourBar().singular(np.radians([0.0, 90.0, 180.0])).tolist()
        [True, False, True]
        """
        return self._closure(theta).singular


def _springs(given: ArrayLike, what: str) -> Array:
    """Stiffness of a joint, checked, (..., 6)."""
    value = numbers(given, what)
    if value.ndim == 0 or value.shape[-1] != 6 or np.isnan(value).any() or np.any(value < 0.0):
        raise FrameError(f"{what} is {given!r}: give six values between 0 and inf, (..., 6)")
    return value
