"""The contact of a joint with clearance as a result, and the force law of such a joint."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..batch import Array
from ..errors import FrameError
from ..states import ClearanceState, States, words


@dataclass(frozen=True, eq=False)
class Contact:
    """Contact in a joint at equilibrium; from ``solution.contact(joint)``.

    Attributes
    ----------
    joint
        Name of the joint.
    state
        State of each batch entry as a number of `ClearanceState`, (...); `status` has it in words.
    normal
        Unit vector from the first node towards the second at contact, also the direction of the force on the first
        node, (..., 3) in global axes; an axis of rotation if the clearance is in rotations; zero where not closed.
    force
        Magnitude of the contact force (or moment), (...).
    gap
        Distance (or angle) to contact, (...); 0 where closed.
    offset
        Displacement within the clearance in the joint's axes, (..., 3): of the magnitude of the clearance, in the
        direction of `normal`, where closed.

    Examples
    --------
    >>> from linkframe.elements import Beam, Joint, Material, Rectangle
    >>> from linkframe.framework import Frame
    >>> frame = Frame()
    >>> for name, x in {"A": 0.0, "B": 1.0, "C": 1.0}.items():
    ...     frame.node(name, (x, 0.0, 0.0))
    >>> frame.add("AB", Beam(Rectangle(y=0.02, z=0.01), Material(E=200e9, nu=0.3)), "A", "B")
    >>> frame.add("stop", Joint(stiffness=(0.0, 1e9, 0.0, 0.0, 0.0, 0.0), clearance=1e-3), "B", "C")
    >>> frame.fix("A"); frame.fix("C")
    >>> frame.load("B", fy=[1.0, 10.0, 100.0])
    >>> contact = frame.solve().contact("stop")
    >>> contact.status.tolist()
    ['open', 'closed', 'closed']
    >>> contact.force.round(3).tolist()
    [0.0, 6.0, 96.0]
    """

    joint: str
    state: States
    normal: Array = field(repr=False)
    force: Array = field(repr=False)
    gap: Array = field(repr=False)
    offset: Array = field(repr=False)

    @property
    def status(self) -> NDArray[np.str_]:
        """State of each batch entry in words, (...), such as ``closed``; see `ClearanceState`."""
        return words(self.state, ClearanceState)

    @property
    def closed(self) -> NDArray[np.bool_]:
        """Whether the joint is in contact, (...)."""
        return np.asarray(self.state == ClearanceState.CLOSED)

    @property
    def angle(self) -> Array:
        """Direction of `normal` in the global xy plane from x, radians, (...); NaN where not closed."""
        return np.where(self.closed, np.arctan2(self.normal[..., 1], self.normal[..., 0]), np.nan)

    def jumps(self, axis: int = -1, turn: float = np.pi / 2.0) -> NDArray[np.bool_]:
        """Whether contact is lost, made or changes side between neighbours along a batch axis.

        If a reaction passes through zero between two poses, the contact is on the other side afterwards: the journal
        has crossed the clearance.

        Parameters
        ----------
        axis
            Batch axis, such as that of the poses.
        turn
            Angle between the normals of neighbours, radians, above which the contact counts as having changed side.

        Returns
        -------
        ndarray
            True at k for a jump between k and k + 1, (...) but with one entry less along `axis` than the batch.

        Raises
        ------
        FrameError
            If the batch has no such axis.
        """
        ndim = self.force.ndim
        if not -ndim <= axis < ndim:
            raise FrameError(f"jumps of contact {self.joint!r} along axis {axis}: the batch has {ndim} axes")
        closed, normal = np.moveaxis(self.closed, axis, 0), np.moveaxis(self.normal, axis % ndim, 0)
        cosine = np.sum(normal[1:] * normal[:-1], axis=-1)
        changed = closed[1:] & closed[:-1] & (cosine < np.cos(turn))
        return np.moveaxis((closed[1:] != closed[:-1]) | changed, 0, axis)


def law(displacement: ArrayLike, clearance: ArrayLike, stiffness: ArrayLike) -> tuple[Array, Array, Array]:
    """Force, tangent and energy of a joint in its clearance directions.

        W(δ) = k/2 max(|δ| − ε, 0)²,  f = k (|δ| − ε) n,  df/dδ = k n nᵀ + (|f|/|δ|) (1 − n nᵀ),  n = δ/|δ|

    Parameters
    ----------
    displacement
        δ of the second node relative to the first, (..., n).
    clearance
        Radius ε of the free ball, (...).
    stiffness
        Contact stiffness k, (...), finite.

    Returns
    -------
    force, tangent, energy
        f (..., n) on the first node, df/dδ (..., n, n), W (...); all zero inside the ball.

    Raises
    ------
    FrameError
        If a stiffness is not finite: a rigid contact has no force for a displacement.

    Examples
    --------
    >>> force, tangent, energy = law((0.0, 3.0), 1.0, 10.0)
    >>> force.tolist(), tangent.tolist(), float(energy)
    ([0.0, 20.0], [[6.666666666666667, 0.0], [0.0, 10.0]], 20.0)
    """
    delta, radius, spring = (np.asarray(value, dtype=np.float64) for value in (displacement, clearance, stiffness))
    if not np.isfinite(spring).all():
        raise FrameError(f"contact stiffness is {spring[~np.isfinite(spring)].flat[0]}: give a finite one to the law")
    length = np.linalg.norm(delta, axis=-1)
    penetration = np.maximum(length - radius, 0.0)
    touched = penetration > 0.0
    normal = delta / np.where(touched, length, 1.0)[..., None]
    dyad = normal[..., :, None] * normal[..., None, :]
    across = spring * penetration / np.where(touched, length, 1.0)
    tangent = across[..., None, None] * np.eye(delta.shape[-1]) + (spring - across)[..., None, None] * dyad
    tangent = np.where(touched[..., None, None], tangent, 0.0)
    return (spring * penetration)[..., None] * normal, tangent, 0.5 * spring * penetration**2
