"""The joint element: six springs between two coincident nodes, with or without clearance."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from ..framework.batch import any_of, numbers, rotation
from ..framework.errors import FrameError
from ..framework.joint_protocol import JointElement
from ..framework.lazily import cached_property
from ..framework.protocol import Array, proven
from ..framework.renamed import RenamedAttribute, renamed_keywords
from .clearance_directions import checked_directions
from .parameters import common_shape, given_state, require, shape_of

# Default of clearance and pitch: zero.
_NONE = numbers(0.0, "Joint: clearance")


@proven
@dataclass(frozen=True, eq=False, init=False)
class Joint(JointElement):
    """Three springs and three rotational springs between two coincident nodes.

    With the relative displacement ``d = u2 - u1`` the joint exerts the force ``f = diag(stiffness) d`` on its first
    node, and -f on the second (Eq. 5 of the four-bar paper: ``[[k, -k], [-k, k]]``). With a `pitch` the spring along z
    acts on ``uz - pitch rz / (2 pi)``.

    With a clearance ε the displacement d in the `clearance_directions` is free inside a ball of radius ε (a circle
    where there are two, a stretch where there is one) and stiff beyond: in contact along the unit vector n,
    ``d = (ε + f/k) n`` with the force f n. There is no friction.

    At large displacement, displacements are measured along axes that follow the first node. The rotations with the
    least stiffness together form one rotation vector, about axes that are carried along by the stiffer rotations. Two
    free rotations therefore make a constant-velocity joint, which never twists about the third axis. A universal joint,
    whose cross turns about an axis of each of the two members, is two joints in series, each free about one axis, with
    a node for the cross between them.

    Parameters
    ----------
    stiffness : array_like
        Three springs and three rotational springs ``ktx kty ktz krx kry krz``, (..., 6), force per length and moment
        per radian, each from 0 (free) to inf (ideal).
    axes : array_like, optional
        Joint axes as columns, (..., 3, 3), in global components, orthonormal and right-handed;
        the global axes if not given.
    clearance : array_like
        Radial clearance ε, (...), length (angle where its directions are rotations); 0 for none.
    clearance_directions : str or sequence of str, optional
        Components ``ux uy uz`` or ``rx ry rz`` in which the joint has clearance, all of equal stiffness. If not given,
        the translations that the joint constrains, except along its axis if it turns about a single axis: ``ux uy`` for
        a revolute about z, all three for a spherical joint, ``uy uz`` for a slider along x.
    pitch : array_like
        Advance of the second node along z per turn about z, (...), length; positive for a right-handed screw.

    Raises
    ------
    FrameError
        If a stiffness is negative or NaN, if there are not six, if `axes` are not orthonormal, if a clearance is
        negative or not finite, a pitch is not finite, or if the `clearance_directions` are free, unequal, or of both
        kinds.

    Examples
    --------
    >>> revolute = Joint(stiffness=(2e11, 2e11, 2e11, 2e11, 2e11, 0.0))
    >>> revolute.matrix().shape
    (12, 12)
    >>> Joint(stiffness=(2e11, 2e11, 2e11, 2e11, 2e11, 0.0), clearance=1e-4).clearance_directions
    (0, 1)
    """

    stiffness: Array = field(metadata={"trailing": 1})
    axes: Array | None = field(default=None, metadata={"trailing": 2})
    clearance: Array = field(default_factory=lambda: _NONE, kw_only=True)
    clearance_directions: tuple[int, ...] = field(default=None, kw_only=True)  # type: ignore[arg-type]
    pitch: Array = field(default_factory=lambda: _NONE, kw_only=True)

    play = RenamedAttribute("clearance_directions")

    @renamed_keywords(play="clearance_directions")
    def __init__(
        self,
        stiffness: ArrayLike,
        axes: ArrayLike | None = None,
        *,
        clearance: ArrayLike = 0.0,
        clearance_directions: str | Sequence[str] | None = None,
        pitch: ArrayLike = 0.0,
    ) -> None:
        vars(self).update(
            stiffness=stiffness, axes=axes, clearance=clearance, clearance_directions=clearance_directions, pitch=pitch
        )
        self.__post_init__()

    # separate from __init__, so that a subclass can be a plain dataclass with further fields
    def __post_init__(self) -> None:
        springs = numbers(self.stiffness, "Joint: stiffness")
        if springs.shape[-1:] != (6,):
            raise FrameError(f"Joint: stiffness has shape {springs.shape}; give six springs, (..., 6)")
        require("Joint", "stiffness", springs, springs >= 0.0, "0 (free) to inf (ideal)")
        rotated = None if self.axes is None else rotation(self.axes, "Joint: axes")
        gap = advance = _NONE
        if not _is_zero(self.clearance):
            gap = numbers(self.clearance, "Joint: clearance")
            require("Joint", "clearance", gap, np.isfinite(gap) & (gap >= 0.0), "a length, zero or above")
        if not _is_zero(self.pitch):
            advance = numbers(self.pitch, "Joint: pitch")
            require("Joint", "pitch", advance, np.isfinite(advance), "finite; give the advance per turn")
        shape = _joined(springs, rotated, gap, advance)
        names = self.clearance_directions
        # a joint without clearance stores (), which dataclasses.replace passes on when a clearance is added
        none = names is None or (isinstance(names, tuple) and not names)
        directions = () if none and (gap is _NONE or not any_of(gap)) else checked_directions(springs, names)
        vars(self).update(
            stiffness=springs, axes=rotated, clearance=gap, clearance_directions=directions, pitch=advance
        )
        if type(self) is Joint:  # of a subclass it would hide a shape of its own
            vars(self).update(shape=shape)

    def __getstate__(self) -> dict[str, object]:
        return given_state(self)

    def along(self, axes: Array) -> Joint:
        """The joint with other axes.

        Parameters
        ----------
        axes
            Axes as columns in global components, (..., 3, 3), known to be orthonormal and right-handed; not copied.

        Returns
        -------
        Joint
            Joint with the same stiffness, clearance and pitch.

        Raises
        ------
        FrameError
            If their shapes do not broadcast.
        """
        if type(self) is Joint:
            return known_joint(self.stiffness, axes, self.clearance, self.clearance_directions, self.pitch)
        clone = object.__new__(type(self))
        vars(clone).update(given_state(self), axes=axes)
        _joined(self.stiffness, axes, self.clearance, self.pitch)
        return clone

    @cached_property
    def shape(self) -> tuple[int, ...]:
        """Batch shape: the broadcast of stiffness, axes, clearance and pitch."""
        axes = () if self.axes is None else self.axes.shape[:-2]
        return shape_of(self.stiffness.shape[:-1], axes, self.clearance.shape, self.pitch.shape)

    def matrix(self) -> Array:
        """Stiffness matrix of the two nodes, the clearance being ignored.

        Returns
        -------
        ndarray
            In global axes, first node before second, (..., 12, 12): force per length and moment per radian.

        Raises
        ------
        FrameError
            If a spring is infinite: an ideal component is a constraint, not a stiffness.
        """
        rigid = np.isinf(self.stiffness).reshape(-1, 6).any(axis=0)
        if rigid.any():
            name = ("ktx", "kty", "ktz", "krx", "kry", "krz")[int(rigid.argmax())]
            raise FrameError(f"Joint: {name} = inf has no stiffness matrix; give a finite spring")
        return self.springs_matrix()

    def typical(self) -> Joint:
        """A joint without clearance whose springs are the stiffest of the batch.

        Returns
        -------
        Joint
            Joint with a stiffness (6,) that does not vary over the batch, and with the same axes and pitch.
        """
        return Joint(self.stiffness.reshape(-1, 6).max(axis=0), self.axes, pitch=self.pitch)


def known_joint(
    stiffness: Array,
    axes: Array | None = None,
    clearance: Array = _NONE,
    clearance_directions: tuple[int, ...] = (),
    pitch: Array = _NONE,
) -> Joint:
    """A joint of numbers that are known to be right, as those of a linkage: neither checked nor copied.

    Parameters
    ----------
    stiffness, axes, clearance, clearance_directions, pitch
        As the attributes of `Joint`, read-only.

    Raises
    ------
    FrameError
        If their shapes do not broadcast.
    """
    made = object.__new__(Joint)
    vars(made).update(
        stiffness=stiffness,
        axes=axes,
        clearance=clearance,
        clearance_directions=clearance_directions,
        pitch=pitch,
        shape=_joined(stiffness, axes, clearance, pitch),
    )
    return made


def _joined(stiffness: Array, axes: Array | None, clearance: Array, pitch: Array) -> tuple[int, ...]:
    """Batch shape of a joint; a `FrameError` if the shapes of its numbers do not broadcast."""
    turned = () if axes is None else axes.shape[:-2]
    if not (turned or clearance.shape or pitch.shape):
        return stiffness.shape[:-1]
    shapes = {"stiffness": stiffness.shape[:-1], "axes": turned, "clearance": clearance.shape, "pitch": pitch.shape}
    return common_shape("Joint", shapes)


def _is_zero(value: ArrayLike) -> bool:
    """Whether a parameter is the Python float 0.0, as it is by default."""
    return type(value) is float and value == 0.0
