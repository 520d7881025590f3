"""Accuracy of a loaded linkage: displacement of its points, compliance, natural frequencies and stress."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ....framework.batch import Array, aligned
from ....framework.batched.idle import released_masses
from ....framework.dofs import FORCES, values
from ....framework.errors import FrameError
from ....framework.frame import Frame
from ....framework.large.solution import LargeSolution
from ....framework.listing import number, text_table
from ....framework.results.modes import modes
from ....framework.results.validity import LINEAR, beyond_linear
from ....framework.solution import Solution
from ....framework.states import States
from ..derivatives.displacement_sensitivity import DisplacementSensitivity, displacement_sensitivity
from ..derivatives.thermal import Expansion, Temperature, expanded
from ..graphics.plane import plane
from .condition_numbers import ConditionNumbers
from .contact import has_contacts
from .frame import FramedPoses, frame
from .passing import passes
from .tangent import OF_LINKAGE, Tangent, elastic, is_loaded

# Stations along a member at which its stress is taken.
STATIONS = 13
# Ratio to the largest eigenvalue of the scaled compliance matrix below which a direction counts as rigid.
RIGID = 1e-13


@dataclass(frozen=True, eq=False)
class PointAccuracy(ConditionNumbers):
    """Displacement of a point of a loaded linkage with locked drives, split by cause; made by `Motion.accuracy`.

    Attributes
    ----------
    motion
        Motion of the linkage, which gives the poses.
    point
        Node of the point in the frame.
    load
        Load at the point in addition to the linkage's own loads, ``fx fy fz mx my mz`` by name, (...) each.
    inertia
        Whether the inertia forces of the rigid motion act as well.
    warmed
        Displacement and rotation by thermal expansion of the links, (..., 6); None if no temperature is given.
    """

    motion: FramedPoses
    point: str
    load: Mapping[str, ArrayLike]
    inertia: bool = False
    warmed: Array | None = None

    def __repr__(self) -> str:
        return f"<PointAccuracy of {self.point} in {self.motion!r}>"

    @property
    def shape(self) -> tuple[int, ...]:
        """Batch shape."""
        return self._closed.shape

    @cached_property
    def rigid(self) -> Array:
        """Position of the point with rigid links and no clearance, (..., 3); NaN where the pose is not assembled."""
        place = np.where(self.motion.is_assembled[..., None], self._closed.frame.position(self.point), np.nan)
        return np.broadcast_to(place, (*self.shape, 3))

    @cached_property
    def compliance(self) -> Array:
        """Displacement and rotation by the compliance of links and joints, without clearance, (..., 6)."""
        return self._closed.displacement(self.point)

    @cached_property
    def clearance(self) -> Array:
        """Displacement and rotation added by the clearances, (..., 6).

        Each joint is in contact at its given contact angle, or else where equilibrium puts the contact.
        """
        return self._open.displacement(self.point) - self.compliance

    @property
    def thermal(self) -> Array:
        """Displacement and rotation added by thermal expansion, through the loop closure, to first order, (..., 6)."""
        return np.broadcast_to(0.0 if self.warmed is None else self.warmed, (*self.shape, 6))

    @cached_property
    def total(self) -> Array:
        """Compliance, clearance and expansion together, (..., 6)."""
        found = self._open.displacement(self.point)
        return found if self.warmed is None else found + self.warmed

    @cached_property
    def large(self) -> Array:
        """Displacement and rotation by load and clearance at large displacement, (..., 6), also at singular poses.

        The stable equilibrium to which the load leads from the rigid position; NaN where none was found. All loads keep
        the direction that they have at the pose, even follower loads.
        """
        return self._large.displacement(self.point)

    @cached_property
    def large_passes(self) -> NDArray[np.bool_]:
        """Whether the linkage passes a singular configuration on the way to `large`, towards another mode, (...).

        Told by the sign of the closing equations' determinant there and at the pose, for each set of loops that close
        together; False at poses that are singular themselves.
        """
        return np.broadcast_to(passes(self.motion, self._large), self.shape)

    @property
    def error_bound(self) -> Array:
        """Bound on the numerical error of `total`, (..., 6); NaN where contacts are found in equilibrium."""
        if self._open.clearances is not None:
            return np.full((*self.shape, 6), np.nan)
        return self._open.error_bound(self.point)

    @property
    def status(self) -> NDArray[np.str_]:
        """Status of the frame's solution at each pose, (...)."""
        return self._open.status

    @property
    def state(self) -> States:
        """`status` as numbers, (...): see `linkframe.framework.SolutionState`."""
        return self._open.state

    @cached_property
    def plane(self) -> tuple[int, int] | None:
        """The two global axes of the plane in which the linkage moves; None if it does not move in such a plane."""
        return plane(self.motion)

    @property
    def _loaded_frame(self) -> Frame:
        return self._frame

    @property
    def _without_clearance(self) -> Solution:
        return self._closed

    @property
    def closed(self) -> Solution:
        """Solution of the loaded frame, without clearance."""
        return self._closed

    @property
    def solution(self) -> Solution:
        """Solution of the loaded frame, with clearance."""
        return self._open

    def sensitivity(self, *components: str) -> DisplacementSensitivity:
        """Differentiate the displacement by compliance by dimensions, sections, moduli, drives and loads.

        One adjoint solution for each component gives the derivatives by all inputs, directly and through the loop
        closure of the linkage.

        Parameters
        ----------
        *components
            Components of the displacement, such as ``"uy"``; ``ux uy uz`` if none is given.

        Returns
        -------
        DisplacementSensitivity
            Derivatives of the components, (..., k, n).

        Raises
        ------
        FrameError
            If a component is unknown, or the linkage has springs, loads that turn with links, inertia forces, given
            masses under gravity, or sliders on beams.

        Examples
        --------
        Tip deflection ``F L^3 / (3 E I)`` of an arm of 1 m under a transverse load: its derivatives by the arm's length
        and by the height of its section.

        >>> from linkframe.elements import Beam, Material, Rectangle
        >>> from linkframe.models import Linkage
        >>> linkage = Linkage(A=(0, 0), B=(1, 0))
        >>> linkage.link("arm", "A", "B", beam=Beam(Rectangle(y=0.02, z=0.01), Material(E=200e9, nu=0.3)))
        >>> linkage.revolute("A", "ground", "arm", drive=True)
        >>> by = linkage.move(A=0.0).accuracy("B", fy=10.0).sensitivity("uy")
        >>> float(by.lengths["arm"][0].round(9)), float(by.frame["uy"].sections["arm"]["y"].round(9))
        (0.0075, -0.375)
        """
        if self.inertia:
            raise FrameError("sensitivity of a displacement: inertia forces change with the pose: leave them out")
        named = nodes_of_links(self.motion)
        return displacement_sensitivity(self.motion, self._closed, named, self.point, components or ("ux", "uy", "uz"))

    @cached_property
    def _open(self) -> Solution:
        return self.motion.bare.solve(self._frame)

    @cached_property
    def _closed(self) -> Solution:
        has_play = any(np.any(joint.element.clearance) for joint in self._frame.joints.values())
        has_play = has_play or has_contacts(self.motion.linkage.joints)
        return self.motion.bare.solve(self._frame, clearance=False) if has_play else self._open

    @cached_property
    def _large(self) -> LargeSolution:
        return self._frame.solve(large=True)

    @cached_property
    def _frame(self) -> Frame:
        loaded = frame(self.motion, inertia=self.inertia)
        if self.load:
            loaded.load(self.point, **self.load)
        return loaded


def accuracy(
    motion: FramedPoses,
    point: str,
    link: str | None,
    load: Mapping[str, ArrayLike],
    *,
    inertia: bool,
    temperature: Temperature | None = None,
    expansion: Expansion | None = None,
) -> PointAccuracy:
    """See `Motion.accuracy`."""
    if load:
        values(f"load at {point!r}", load, FORCES)
    if temperature is None and expansion is not None:
        raise FrameError("expansion= has no effect without temperature=: give the rise of temperature as well")
    warmed = None if temperature is None else expanded(motion, point, link, temperature, expansion)
    return PointAccuracy(motion, node_of(motion, point, link), load, inertia, warmed)


def marked_status(motion: FramedPoses, solution: Solution) -> NDArray[np.str_]:
    """Status of the poses, or where these are regular that of the frame, marked where linear results do not hold.

    Parameters
    ----------
    motion
        The poses, (...).
    solution
        Their loaded frame solved, (...).
    """
    frame = np.broadcast_to(solution.status, motion.shape)
    moved = np.where(motion.is_regular, frame, motion.status)
    off = np.broadcast_to(solution.nonlinearity(), motion.shape)
    text = np.array([beyond_linear(each) for each in off.flat]).reshape(off.shape)
    marked = np.where(moved == "regular", text, np.char.add(np.char.add(moved, "; "), text))
    solved = (frame == "regular") | (frame == motion.status)
    return np.where(solved & ~(off < LINEAR), marked, moved)


def node_of(motion: FramedPoses, point: str, link: str | None) -> str:
    """Node of a point on a link; if `link` is None, on the first link that has the point."""
    return motion.bare.nodes.of(*motion.linkage.end(point if link is None else (link, point), "the frame"))


def nodes_of_links(motion: FramedPoses) -> dict[tuple[str, str], str]:
    """Nodes of the frame by link and point."""
    nodes, links = motion.bare.nodes, motion.linkage.links
    return {(name, point): nodes.of(name, point) for name, link in links.items() for point in link.points}


def compliance_matrix(motion: FramedPoses, point: str, link: str | None) -> Array:
    """Displacement of a point by unit loads on it, (..., 6, 6); see `Motion.compliance_matrix`."""
    node = node_of(motion, point, link)
    if is_loaded(motion):
        return Tangent(motion, cut=False).compliance_matrix(node)
    cases = frame(motion, loads=False)
    units = np.eye(6).reshape(6, *(1,) * len(cases.shape), 6)
    cases.load(node, **{name: units[..., k] for k, name in enumerate(FORCES)})
    found = np.moveaxis(motion.bare.solve(cases, clearance=False).displacement(node), 0, -1)
    # what has no bound under a moment is one of many under a force
    return np.where(np.isnan(np.swapaxes(found, -1, -2)), np.nan, found)


def stiffness(motion: FramedPoses, point: str, link: str | None) -> Array:
    """Inverse of the compliance matrix, (..., 6, 6); see `Motion.stiffness`."""
    compliance = compliance_matrix(motion, point, link)
    compliance = 0.5 * (compliance + np.swapaxes(compliance, -1, -2))
    known = np.asarray(np.isfinite(compliance).all(axis=(-2, -1)))
    # displacements and rotations are scaled to like size before the rank is judged
    size = np.sqrt(np.abs(np.diagonal(compliance, axis1=-2, axis2=-1)))
    size = np.where(size > 0.0, size, 1.0)
    scaled = compliance / size[..., :, None] / size[..., None, :]
    scaled[~known] = np.eye(6)
    least = np.abs(np.linalg.eigvalsh(scaled)).min(axis=-1)
    if np.any(least <= RIGID):
        raise FrameError(
            f"point {point!r} cannot deflect in every direction, links and joints between it and the ground are rigid: "
            "its stiffness is infinite there; ask for its compliance matrix, or give them beams or springs"
        )
    inverse = np.linalg.inv(scaled) / size[..., :, None] / size[..., None, :]
    return np.where(known[..., None, None], inverse, np.nan)


def frequencies(motion: FramedPoses, count: int) -> Array:
    """The lowest natural frequencies, Hz, (..., count); see `Motion.frequencies`."""
    if is_loaded(motion):
        return Tangent(motion, cut=True).frequencies(count)
    built = frame(motion, loads=False)
    free = released_masses(built)
    idle = len(built.idle) - len(free.idle)
    return elastic(modes(free, count + idle, OF_LINKAGE).frequencies, idle)


@dataclass(frozen=True, eq=False, repr=False)
class Stress:
    """Stress along the members of a link over a motion; made by `Motion.stress`.

    Attributes
    ----------
    members
        Members of the link, m of them.
    fractions
        Stations as fractions of each member's length, (k,).
    values
        Least and greatest normal stress and greatest von Mises stress, (..., m, k, 3).
    """

    members: tuple[str, ...]
    fractions: Array
    values: Array

    def __repr__(self) -> str:
        """Extremes of each member over all poses as a short table."""
        rows = [
            [name, *(number(float(v)) for v in (part[:, 0].min(), part[:, 1].max(), part[:, 2].max()))]
            for name, part in zip(self.members, self.envelope, strict=True)
        ]
        title = f"Stress of shape {self.values.shape[:-3]}: extremes over all poses, force per area"
        return text_table(title, ["member", "least", "greatest", "von Mises"], rows)

    @property
    def least(self) -> Array:
        """Least normal stress in the link at each pose, (...)."""
        return np.asarray(self.values[..., 0].min(axis=(-2, -1)))

    @property
    def greatest(self) -> Array:
        """Greatest normal stress in the link at each pose, (...)."""
        return np.asarray(self.values[..., 1].max(axis=(-2, -1)))

    @property
    def von_mises(self) -> Array:
        """Greatest von Mises stress in the link at each pose, (...)."""
        return np.asarray(self.values[..., 2].max(axis=(-2, -1)))

    @cached_property
    def envelope(self) -> Array:
        """Extremes over all poses along the members, (m, k, 3); poses without results do not count."""
        flat = self.values.reshape(-1, *self.values.shape[-3:])
        there = flat[np.isfinite(flat).all(axis=(1, 2, 3))]
        if not len(there):
            return np.full(flat.shape[1:], np.nan)
        return np.concatenate([there[..., :1].min(axis=0), there[..., 1:].max(axis=0)], axis=-1)


def stress(motion: FramedPoses, link: str) -> Stress:
    """Stress in a link under the linkage's loads and inertia; see `Motion.stress`."""
    built = frame(motion, inertia=True)
    if link not in motion.linkage.links:
        raise FrameError(f"stress: there is no link {link!r}: choose one of {', '.join(motion.linkage.links)}")
    members = tuple(name for name, *_ in motion.bare.pieces.get(link, []))
    if not members:
        raise FrameError(f"link {link!r} is rigid: give it a beam")
    solution = motion.bare.solve(built, clearance=False)
    fractions = np.linspace(0.0, 1.0, STATIONS)
    each = [
        solution.stress(name, aligned(built.length(name), len(built.shape))[..., None] * fractions) for name in members
    ]
    return Stress(members, fractions, np.stack(each, axis=-3))
