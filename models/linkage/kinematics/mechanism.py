"""A compiled linkage: its programs for positions, closure and rates, made from the recorded formulas on demand."""

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
# Formulas are recorded by one thread at a time, as making a program adds to the recording.
_WRITING = RLock()


class Mechanism(Dimensions):
    """A linkage with its programs, each made on first use, and results that are kept with it.

    Parameters
    ----------
    linkage, counted, common
        As in `Dimensions`.

    Attributes
    ----------
    rows, acting, active, pattern, acting_places
        The closing equations, as in `ClosingEquations`.
    begun
        Nominal dimensions, loops and closed reference configuration, stored here by the assembly once found, so that
        they live as long as the mechanism.
    starts
        Closed reference configurations of all members of the batch, stored likewise.
    usual_speeds
        Typical speeds of points and links by tolerance, point and link, stored likewise.
    framed
        The frame of the linkage at a single pose, with the inputs it was made from; frames at other poses are made of
        it.
    """

    def __init__(self, linkage: LinkageDescription, counted: str | None = None, *, common: bool = False) -> None:
        super().__init__(linkage, counted, common=common)
        self._common = common
        self.begun: tuple[list[float], Any, Any] | None = None
        self.starts: Any = None
        self.usual_speeds: dict[tuple[float, str | None, str], Array] = {}
        self.framed: Any = None
        self._counting: dict[str, Mechanism] = {}
        self._checked = False
        equations = self.found("equations", lambda formulas: formulas.equations)
        self.rows, self.acting, self.active, self.pattern, self.acting_places = equations

    def __getstate__(self) -> dict[str, object]:
        """State for another process, without formulas: they are recorded there again."""
        return {name: value for name, value in vars(self).items() if name not in ("formulas", "_known")}

    def check_free(self) -> None:
        """`LinkageDescription.check_free`, done once for the compiled linkage.

        Raises
        ------
        FrameError
            As there.
        """
        if not self._checked:
            self.linkage.check_free()
            self._checked = True

    def counting(self, joint: str) -> Mechanism:
        """The same mechanism with the coordinates of a joint in its state, so that its turns are counted."""
        if joint not in self._counting:
            self._counting[joint] = Mechanism(self.linkage, joint, common=self._common)
        return self._counting[joint]

    # -- programs ---------------------------------------------------------------------------------------------------

    @cached_property
    def formulas(self) -> Formulas:
        """The recorded formulas, made when a program is missing from the cache."""
        return Formulas(self)

    @cached_property
    def _known(self) -> dict[Hashable, Any]:
        """Programs made of these formulas, shared by all linkages that have them."""
        known: dict[Hashable, Any] = FORMULAS.found(self.formula_key(), dict, len(self.linkage.joints) + 1)
        return known

    def found(self, key: Hashable, make: Callable[[Formulas], Found]) -> Found:
        """A result that depends on the formulas alone, made once for all linkages that have them."""
        if key not in self._known:
            with _WRITING:
                self._known.setdefault(key, make(self.formulas))
        made: Found = self._known[key]
        return made

    def program(self, key: Hashable, outputs: Callable[[Formulas], Iterable[Scalar]]) -> Functions:
        """Program from (state, parameters), or (state, parameters, v, dv/dt), to outputs of the formulas.

        Parameters
        ----------
        key
            Name of the program, and everything that `outputs` depends on.
        outputs
            Function from the formulas to the outputs.
        """
        return self.found(key, lambda formulas: formulas.program(outputs(formulas)))

    @cached_property
    def newton(self) -> Functions:
        """(state, parameters) to active residuals, then the Jacobian of the active rows by the unknowns."""
        return self.program("newton", lambda formulas: chain(*formulas.closing[:2]))

    @cached_property
    def full(self) -> Functions:
        """As `newton`, followed by the Jacobian of the active rows by the drives."""
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
        """(state, parameters) to reference point and axes of a link, twelve numbers."""
        return self.program(("pose", link), lambda formulas: formulas.pose_of([link]))

    def point_of(self, link: str, kept: tuple[int, ...]) -> Functions:
        """(state, parameters, arm and size) to the position of a point of a link, three numbers in the ground's axes.

        The arm is the vector to it from the link's reference point; its nonzero components `kept` are along the link's
        axes.
        """
        return self.program(("point", link, kept), lambda formulas: formulas.point_of(link, kept))

    @property
    def joint_points(self) -> Functions:
        """(state, parameters) to the points of all joints on their first links, by name."""
        names = sorted(self.linkage.joints)
        return self.program("joint points", lambda formulas: chain(*(formulas.frames[name][1] for name in names)))

    def joint_axes(self, pair: Pair) -> Functions:
        """(state, parameters) to the axes x y z of a joint that closes a loop, on its first link, nine numbers."""
        name = pair.first if pair.first in self.tree.twins else pair.name
        return self.program(("joint axes", name), lambda formulas: chain(*formulas.frames[name][0]))

    def rates_of(self, link: str) -> Functions:
        """(state, parameters, v, dv/dt) to ω, v, α and a of a link, v and a those of its reference point."""
        return self.program(("rates", link), lambda formulas: formulas.rates_of([link]))

    @property
    def poses(self) -> Functions:
        """`pose_of` for all links, in the order of the linkage."""
        return self.program("poses", lambda formulas: formulas.pose_of(self.linkage.links))

    @property
    def rates(self) -> Functions:
        """`rates_of` for all links, in the order of the linkage."""
        return self.program("all rates", lambda formulas: formulas.rates_of(self.linkage.links))

    @cached_property
    def bias(self) -> Functions:
        """(state, parameters, v, dv/dt) to the second time derivatives of the active rows."""
        return self.program("bias", lambda formulas: formulas.bias)

    def jacobian(self, state: Array) -> Array:
        """Jacobian of all closing rows by all velocity coordinates, (..., rows, columns), at states (..., n)."""
        entries = self.all_entries[1](tuple(np.moveaxis(state, -1, 0)), tuple(self.parameters))
        return stacked(entries).reshape(*stacked(entries).shape[:-1], len(self.rows), len(self.columns))


def stacked(entries: tuple[Value, ...]) -> Array:
    """Entries, which broadcast, stacked along a last axis."""
    if not entries:
        return np.zeros(0)
    return np.stack(np.broadcast_arrays(*entries), axis=-1)


def compiled(linkage: LinkageDescription, *, common: bool = False) -> Mechanism:
    """The linkage's mechanism; compiled again only if the description has changed.

    Parameters
    ----------
    linkage
        The description.
    common
        Whether all members of the batch count lengths in the same unit, as for a gap that is accepted in all of them.
    """
    last: tuple[tuple[object, ...], Mechanism] | None = COMPILED.get(linkage)
    version = (*linkage.version, common)
    if last is None or not alike(last[0], version):
        last = version, Mechanism(linkage.alike(), common=common)
        COMPILED.put(linkage, last)
    return last[1]
