"""Poses by what is special about them: regular, singular, in another assembly mode, or not assembled."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ....framework.batch import Array
from ....framework.states import States, among
from ..description.parts import GROUND
from ..kinematics.terms import cross
from .kinematics import Kinematics
from .singular import conditioning, pose_states
from .states import PoseState


@dataclass(frozen=True, eq=False, repr=False)
class ClassifiedPoses(Kinematics):
    """Kinematics of a linkage with the state of each pose, and how firmly the drives hold it; see `Motion`."""

    @cached_property
    def status(self) -> NDArray[np.str_]:
        """What is special about each pose, (...).

        * ``"regular"``
        * ``"near dead point"``: see `conditioning`
        * ``"singular (direct-kinematic, type II; dead point of ...)"``: with the drives locked, joints move. Of these
          one is named that the locked drives constrain on neither side.
        * ``"singular (inverse-kinematic, type I; joint ... is stationary)"``, with several drives ``"... joint ...
          loses a degree of freedom"``, in which they move its point, or the link that slides in it, at other poses: as
          the pin of a rocker at the end of its swing. Positions and velocities are good as ever.
        * ``"other assembly mode; not reachable from the reference configuration"``: the linkage can be assembled, but
          not on the straight path of the drives from the reference configuration; results are NaN, but with
          ``other_modes=True`` those of the position that was found.
        * ``"not assembled: gap ... at joint ..."``: results are NaN.
        """
        return np.broadcast_to(self._states[1], self.shape)

    @cached_property
    def state(self) -> States:
        """The same as numbers, (...): see `linkframe.models.PoseState`."""
        return np.broadcast_to(self._states[0], self.shape)

    @property
    def is_regular(self) -> NDArray[np.bool_]:
        """Where nothing is special about the pose, (...)."""
        return np.asarray(self.state == PoseState.REGULAR)

    @property
    def is_singular(self) -> NDArray[np.bool_]:
        """Where the pose is singular, of either type, (...)."""
        return among(self.state, PoseState.SINGULAR_DIRECT, PoseState.SINGULAR_INVERSE)

    @cached_property
    def _states(self) -> tuple[States, NDArray[np.str_]]:
        return pose_states(self, self.conditioned)

    @property
    def conditioning(self) -> Array:
        """How firmly the drives hold each pose, (...): from 0, where something moves with the drives locked, towards 1.

        Least over greatest singular value of the loop closure by the coordinates that are not driven, with lengths in
        units of the linkage's extent; idle (passive) degrees of freedom do not count.
        """
        return np.broadcast_to(self.conditioned[0], self.shape)

    @cached_property
    def conditioned(self) -> tuple[Array, Array]:
        """Conditioning, (...), and at singular poses the motions of unknown velocity coordinates that nothing holds."""
        return conditioning(self)

    def free_velocity(self, point: str, link: str | None = None) -> Array:
        """Velocity of a point in the motion that the locked drives let pass at a dead point.

        Parameters
        ----------
        point
            Name of the point.
        link
            The link on which it is taken; the first that has it where None.

        Returns
        -------
        ndarray
            Its direction, and its size beside those of other points, (..., 3); of several such motions that which is
            resisted least. Zero at poses that the drives hold.

        Raises
        ------
        FrameError
            If there is no such point or link, or the link has it not.

        Examples
        --------
        A slider-crank that its piston drives, at the end of the stroke: the crank pin moves across, and nothing else.

        >>> from linkframe.models import Linkage
        >>> linkage = Linkage(A=(0, 0), B=(0, 1), C=(8**0.5, 0))
        >>> linkage.link("crank", "A", "B"); linkage.link("rod", "B", "C"); linkage.link("piston", "C")
        >>> linkage.revolute("A", "ground", "crank"); linkage.revolute("B", "crank", "rod")
        >>> linkage.revolute("C", "rod", "piston")
        >>> linkage.prismatic("C", "ground", "piston", axis=(1, 0, 0), reference=8**0.5, name="slide", drive=True)
        >>> motion = linkage.move(slide=[3.0, 4.0])
        >>> abs(motion.free_velocity("B")).round(6).tolist()[0], motion.is_singular.tolist()
        ([0.0, 0.0, 0.0], [False, True])
        >>> way = motion.free_velocity("B")[1]
        >>> bool(abs(way[1]) > 0.1), abs(way[[0, 2]]).round(6).tolist()
        (True, [0.0, 0.0])
        >>> abs(motion.free_velocity("C")).round(6).tolist()[1]
        [0.0, 0.0, 0.0]
        """
        name, place = self._on(point, link)
        if name == GROUND:
            return np.zeros((*self.shape, 3))
        least, count = self.conditioned[1][..., -1], len(self.mechanism.columns)
        velocities: list[Any] = [0.0] * count
        for number, k in enumerate(self.mechanism.unknown):
            velocities[k] = least[..., number]
        speed = self._run(self.mechanism.rates_of(name), self.assembly.state, velocities, [0.0] * count)
        arm = self._arm(name, self._pose(name)[1], place)
        there = [x + y for x, y in zip(speed[3:6], cross(speed[:3], arm), strict=True)]
        return self._global(there, self.mechanism.size)
