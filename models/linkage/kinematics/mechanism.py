"""A linkage compiled: the programs for position, closure and rates of what was written down."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable
from functools import cached_property
from itertools import chain
from threading import RLock
from typing import Any, TypeVar

import numpy as np

from ....framework.batch import Array
from ....framework.cache import COMPILED, FORMULAS, alike
from ....framework.program.source import Functions
from ..description.linkage_description import LinkageDescription
from ..description.parts import Pair
from .dimensions import Dimensions
from .formulas import Formulas
from .terms import Scalar, Value

Found = TypeVar("Found")
# Formulas are written down by one thread at a time: what a program is made of is added to them.
_WRITING = RLock()


class Mechanism(Dimensions):
    """A linkage with its programs, each made when it is first asked for, and what has been found of it.

    Parameters
    ----------
    linkage, counted
        As of `Dimensions`.

    Attributes
    ----------
    rows, acting, active, pattern, acting_places
        The closing equations, as of `ClosingEquations`.
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
        self._checked = False
        equations = self.found("equations", lambda formulas: formulas.equations)
        self.rows, self.acting, self.active, self.pattern, self.acting_places = equations

    def __getstate__(self) -> dict[str, object]:
        """What another process needs; it writes the formulas down anew."""
        return {name: value for name, value in vars(self).items() if name not in ("formulas", "_known")}

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
            self._counting[joint] = Mechanism(self.linkage, joint)
        return self._counting[joint]

    # -- programs ---------------------------------------------------------------------------------------------------

    @cached_property
    def formulas(self) -> Formulas:
        """What the programs are made of, written down for this linkage where one is missing."""
        return Formulas(self)

    @cached_property
    def _known(self) -> dict[Hashable, Any]:
        """What has been made of these formulas, for whichever linkage that has them."""
        known: dict[Hashable, Any] = FORMULAS.found(self.formula_key(), dict, len(self.linkage.joints) + 1)
        return known

    def found(self, key: Hashable, make: Callable[[Formulas], Found]) -> Found:
        """What depends on the formulas alone, made once for all linkages that have them."""
        if key not in self._known:
            with _WRITING:
                self._known.setdefault(key, make(self.formulas))
        made: Found = self._known[key]
        return made

    def program(self, key: Hashable, outputs: Callable[[Formulas], Iterable[Scalar]]) -> Functions:
        """(state, parameters) to `outputs` of the formulas; (state, parameters, v, dv/dt) where these come in.

        Parameters
        ----------
        key
            Name of the program, and all else that `outputs` depends on.
        outputs
            What it makes.
        """
        return self.found(key, lambda formulas: formulas.program(outputs(formulas)))

    @cached_property
    def newton(self) -> Functions:
        """(state, parameters) to active residuals, then the Jacobian of the active rows by the unknowns."""
        return self.program("newton", lambda formulas: chain(*formulas.closing[:2]))

    @cached_property
    def full(self) -> Functions:
        """As `newton`, with the Jacobian of the active rows by the drives behind."""
        return self.program("full", lambda formulas: chain(*formulas.closing))

    @cached_property
    def residual(self) -> Functions:
        """(state, parameters) to the residuals of all rows."""
        return self.program("residual", lambda formulas: formulas.residual)

    @cached_property
    def all_entries(self) -> Functions:
        """(state, parameters) to the Jacobian of all rows by all velocity coordinates."""
        return self.program("all entries", lambda formulas: chain(*formulas.jacobian))

    @cached_property
    def acting_closure(self) -> Functions:
        """(state, parameters) to the residuals of the rows in `acting`, then the entries at `acting_places`."""
        return self.program("acting closure", lambda formulas: formulas.acting_closure)

    def pose_of(self, link: str) -> Functions:
        """(state, parameters) to reference point and axes, twelve numbers, of a link."""
        return self.program(("pose", link), lambda formulas: formulas.pose_of([link]))

    def point_of(self, link: str, kept: tuple[int, ...]) -> Functions:
        """(state, parameters, arm and size) to a place of a link, three numbers in the ground's axes.

        The arm leads there from the link's reference point; it has the components `kept`, along the link's axes.
        """
        return self.program(("point", link, kept), lambda formulas: formulas.point_of(link, kept))

    @property
    def joint_points(self) -> Functions:
        """(state, parameters) to the points of all joints on their first links, by name."""
        names = sorted(self.linkage.joints)
        return self.program("joint points", lambda formulas: chain(*(formulas.frames[name][1] for name in names)))

    def joint_axes(self, pair: Pair) -> Functions:
        """(state, parameters) to the axes x y z, nine numbers, of a joint that closes a loop, on its first link."""
        name = pair.first if pair.first in self.tree.twins else pair.name
        return self.program(("joint axes", name), lambda formulas: chain(*formulas.frames[name][0]))

    def rates_of(self, link: str) -> Functions:
        """(state, parameters, v, dv/dt) to ω, velocity of the reference point, α and its acceleration, of a link."""
        return self.program(("rates", link), lambda formulas: formulas.rates_of([link]))

    @property
    def poses(self) -> Functions:
        """As `pose_of`, of all links in the order of the linkage."""
        return self.program("poses", lambda formulas: formulas.pose_of(self.linkage.links))

    @property
    def rates(self) -> Functions:
        """As `rates_of`, of all links in the order of the linkage."""
        return self.program("all rates", lambda formulas: formulas.rates_of(self.linkage.links))

    @cached_property
    def bias(self) -> Functions:
        """(state, parameters, v, dv/dt) to the second time derivative of the active rows."""
        return self.program("bias", lambda formulas: formulas.bias)

    def jacobian(self, state: Array) -> Array:
        """Jacobian of all closing rows by all velocity coordinates, (..., rows, columns), at states (..., n)."""
        entries = self.all_entries[1](tuple(np.moveaxis(state, -1, 0)), tuple(self.parameters))
        return stacked(entries).reshape(*stacked(entries).shape[:-1], len(self.rows), len(self.columns))


def stacked(entries: tuple[Value, ...]) -> Array:
    """Entries, which broadcast, along a last axis."""
    if not entries:
        return np.zeros(0)
    return np.stack(np.broadcast_arrays(*entries), axis=-1)


def compiled(linkage: LinkageDescription) -> Mechanism:
    """The linkage's mechanism, compiled once for as long as its description stays the same."""
    last: tuple[tuple[object, ...], Mechanism] | None = COMPILED.get(linkage)
    version = linkage.version
    if last is None or not alike(last[0], version):
        last = version, Mechanism(linkage.alike())
        COMPILED.put(linkage, last)
    return last[1]
