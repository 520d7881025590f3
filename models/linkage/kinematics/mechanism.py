"""A linkage compiled: the programs for position, closure and rates of what was written down."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ....framework.batch import Array
from ....framework.cache import COMPILED, alike
from ....framework.program.recording import Term
from ....framework.program.source import Functions
from ..description.linkage_description import LinkageDescription
from ..description.parts import Pair
from .closure import closing_bias
from .linear import Pattern
from .rates import Rates, rates_of
from .terms import Scalar, Value, Vector, plus, times
from .written_mechanism import CHANGES, FURTHER, VELOCITIES, WrittenMechanism


class Mechanism(WrittenMechanism):
    """A linkage with its programs, each made when it is first asked for, and what has been found of it.

    Parameters
    ----------
    linkage, counted
        As of `WrittenMechanism`.

    Attributes
    ----------
    begun
        Nominal dimensions, loops and closed reference configuration, once they have been found. The assembly finds them
        and puts them here, so that they live as long as the mechanism.
    starts
        Closed reference configurations of all members of the batch, likewise.
    usual_speeds
        How fast points and links move in general, likewise, by tolerance, point and link.
    framed
        The frame of the linkage at a single pose, and what it was made with, from which those at others are made.
    """

    def __init__(self, linkage: LinkageDescription, counted: str | None = None) -> None:
        super().__init__(linkage, counted)
        self.begun: tuple[list[float], Any, Any] | None = None
        self.starts: Any = None
        self.usual_speeds: dict[tuple[float, str | None, str], Array] = {}
        self.framed: Any = None
        self._counting: dict[str, Mechanism] = {}
        self._described = linkage.alike()
        self._checked = False
        self._poses: dict[str, Functions] = {}
        self._rates: dict[str, Functions] = {}
        self._on_links: dict[tuple[str, tuple[int, ...]], Functions] = {}

    def check_free(self) -> None:
        """`LinkageDescription.check_free` of what was compiled: looked at once.

        Raises
        ------
        FrameError
            As there.
        """
        if not self._checked:
            self.linkage.check_free()
            self._checked = True

    def counting(self, joint: str) -> Mechanism:
        """The linkage as it was compiled, with the coordinates of a joint among its state."""
        if joint not in self._counting:
            self._counting[joint] = Mechanism(self._described, joint)
        return self._counting[joint]

    # -- programs ---------------------------------------------------------------------------------------------------

    def program(self, outputs: Iterable[Scalar]) -> Functions:
        """(state, parameters) to `outputs`; (state, parameters, v, dv/dt) where these come in."""
        terms = [x if isinstance(x, Term) else self.recording.constant(x) for x in outputs]
        program, given = self.recording.program(terms)
        return Functions.of(program, tuple(self._places[k] for k in given))

    @cached_property
    def closing(self) -> tuple[list[Scalar], list[Scalar], list[Scalar]]:
        """Active residuals, and the entries of their Jacobian by the unknowns and by the drives, row by row."""
        rows = self.active
        return (
            [self._residual[i] for i in rows],
            [self._jacobian[i][k] for i in rows for k in self.unknown],
            [self._jacobian[i][k] for i in rows for k in self.driven],
        )

    @cached_property
    def acting(self) -> list[int]:
        """Rows that some coordinate acts on; the others hold by construction, or not at all."""
        return [i for i, row in enumerate(self._jacobian) if any(map(_acts, row))]

    @cached_property
    def active(self) -> list[int]:
        """Rows that some unknown acts on; the others hold by construction, or not at all."""
        return [i for i, row in enumerate(self._jacobian) if any(_acts(row[k]) for k in self.unknown)]

    @cached_property
    def pattern(self) -> Pattern:
        """Which unknown acts on which active row, (rows, unknowns)."""
        acts = [_acts(self._jacobian[i][k]) for i in self.active for k in self.unknown]
        return np.array(acts, dtype=bool).reshape(len(self.active), len(self.unknown))

    @cached_property
    def newton(self) -> Functions:
        """(state, parameters) to active residuals, then the Jacobian of the active rows by the unknowns."""
        residual, jacobian, _ = self.closing
        return self.program([*residual, *jacobian])

    @cached_property
    def full(self) -> Functions:
        """As `newton`, with the Jacobian of the active rows by the drives behind."""
        residual, jacobian, drives = self.closing
        return self.program([*residual, *jacobian, *drives])

    @cached_property
    def residual(self) -> Functions:
        """(state, parameters) to the residuals of all rows."""
        return self.program(self._residual)

    @cached_property
    def all_entries(self) -> Functions:
        """(state, parameters) to the Jacobian of all rows by all velocity coordinates."""
        return self.program([entry for row in self._jacobian for entry in row])

    @cached_property
    def acting_places(self) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """Row, counted among those in `acting`, and column of each entry of their Jacobian that is not always zero."""
        places = [(i, k) for i, row in enumerate(self.acting) for k, x in enumerate(self._jacobian[row]) if _acts(x)]
        rows, columns = np.array(places, dtype=np.intp).reshape(-1, 2).T
        return rows, columns

    @cached_property
    def acting_closure(self) -> Functions:
        """(state, parameters) to the residuals of the rows in `acting`, then the entries at `acting_places`."""
        entries = [self._jacobian[self.acting[i]][k] for i, k in zip(*self.acting_places, strict=True)]
        return self.program([*(self._residual[i] for i in self.acting), *entries])

    def pose_of(self, link: str) -> Functions:
        """(state, parameters) to reference point and axes, twelve numbers, of a link."""
        if link not in self._poses:
            body = self.bodies[link]
            self._poses[link] = self.program([x for v in (body.origin, *body.axes) for x in v])
        return self._poses[link]

    def point_of(self, link: str, kept: tuple[int, ...]) -> Functions:
        """(state, parameters, arm and size) to a place of a link, three numbers in the ground's axes.

        The arm leads there from the link's reference point; it has the components `kept`, along the link's axes.
        """
        if (link, kept) not in self._on_links:
            body, given = self.bodies[link], [self._later(FURTHER, k) for k in range(len(kept) + 1)]
            there: Vector = [0.0, 0.0, 0.0]
            for k, x in zip(kept, given, strict=False):
                there = plus(there, times(x, body.axes[k]))
            self._on_links[link, kept] = self.program(times(given[-1], plus(body.origin, there)))
        return self._on_links[link, kept]

    @cached_property
    def joint_points(self) -> Functions:
        """(state, parameters) to the points of all joints on their first links, by name."""
        return self.program([x for name in sorted(self.linkage.joints) for x in self.frames[name][1]])

    def joint_axes(self, pair: Pair) -> Functions:
        """(state, parameters) to the axes x y z, nine numbers, of a joint that closes a loop, on its first link."""
        axes, _, _, _ = self._joined(pair)
        return self.program([x for axis in axes for x in axis])

    def rates_of(self, link: str) -> Functions:
        """(state, parameters, v, dv/dt) to ω, velocity of the reference point, α and its acceleration, of a link."""
        if link not in self._rates:
            _, rates = self._moving
            own = rates[link]
            values = [x for v in (own.omega, own.v, own.alpha, own.a) for x in v]
            self._rates[link] = self.program(values)
        return self._rates[link]

    @cached_property
    def poses(self) -> Functions:
        """As `pose_of`, of all links in the order of the linkage."""
        bodies = (self.bodies[link] for link in self.linkage.links)
        return self.program([x for body in bodies for v in (body.origin, *body.axes) for x in v])

    @cached_property
    def rates(self) -> Functions:
        """As `rates_of`, of all links in the order of the linkage."""
        _, rates = self._moving
        moves = (rates[link] for link in self.linkage.links)
        values = [x for own in moves for v in (own.omega, own.v, own.alpha, own.a) for x in v]
        return self.program(values)

    @cached_property
    def relative(self) -> dict[str, Functions]:
        """By joint: (state, parameters) to axes x y z and point on the first link, axes and point on the second."""
        return {
            name: self.program([x for v in (*first, here, *second, there) for x in v])
            for name, (first, here, second, there) in self.frames.items()
        }

    @cached_property
    def bias(self) -> Functions:
        """(state, parameters, v, dv/dt) to the second time derivative of the active rows."""
        bias, _ = self._moving
        return self.program([bias[i] for i in self.active])

    @cached_property
    def _moving(self) -> tuple[list[Scalar], dict[str, Rates]]:
        v, w = ([self._later(group, k) for k in range(len(self.columns))] for group in (VELOCITIES, CHANGES))
        rates = rates_of(self.tree, self.bodies, self.frames, self._columns, self.velocities, v, w)
        bias = [
            x
            for pair in self.tree.cuts
            for x in closing_bias(pair, self._joined(pair), rates[pair.first], rates[pair.second])
        ]
        return bias, rates

    def jacobian(self, state: Array) -> Array:
        """Jacobian of all closing rows by all velocity coordinates, (..., rows, columns), at states (..., n)."""
        entries = self.all_entries[1](tuple(np.moveaxis(state, -1, 0)), tuple(self.parameters))
        return stacked(entries).reshape(*stacked(entries).shape[:-1], len(self.rows), len(self.columns))


def stacked(entries: tuple[Value, ...]) -> Array:
    """Entries, which broadcast, along a last axis."""
    if not entries:
        return np.zeros(0)
    return np.stack(np.broadcast_arrays(*entries), axis=-1)


def _acts(entry: Scalar) -> bool:
    return isinstance(entry, Term) or entry != 0.0


def compiled(linkage: LinkageDescription) -> Mechanism:
    """The linkage's mechanism, compiled once for as long as its description stays the same."""
    last: tuple[tuple[object, ...], Mechanism] | None = COMPILED.get(linkage)
    version = linkage.version
    if last is None or not alike(last[0], version):
        last = version, Mechanism(linkage.alike())
        COMPILED.put(linkage, last)
    return last[1]
