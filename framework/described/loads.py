"""Forces on nodes and members, and gravity."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike

from ..batch import Array, unvaried, vector
from ..dofs import FORCES, values
from ..errors import FrameError
from ..loads import LineLoad, PointLoad
from .supports import DescribedSupports


class DescribedLoads(DescribedSupports):
    """The part of a description that takes loads."""

    def load(self, node: str, **force: ArrayLike) -> None:
        """Apply a force or moment at a node, in global axes; loads add up.

        Parameters
        ----------
        node
            Name of the node.
        **force
            Values by component: force ``fx fy fz`` and moment ``mx my mz``; each may carry a batch, (...).

        Raises
        ------
        FrameError
            If the node or a component is unknown, a value is not finite, or shapes do not broadcast.

        Examples
        --------
        A force on the tip of a cantilever in five load cases, and its moment at the clamp.

        >>> import numpy as np
        >>> from linkframe.elements import Beam, Circle, Material
        >>> from linkframe.framework import Frame
        >>> frame = Frame()
        >>> for name, x in {"A": 0.0, "B": 0.5}.items():
        ...     frame.node(name, (x, 0.0, 0.0))
        >>> frame.add("AB", Beam(Circle(diameter=0.02), Material(E=200e9, nu=0.3)), "A", "B")
        >>> frame.fix("A"); frame.load("B", fy=np.linspace(0.0, 40.0, 5))
        >>> frame.solve().reaction("A")[:, 5].round(9).tolist()
        [0.0, -5.0, -10.0, -15.0, -20.0]
        """
        node = self._node(node, "load")
        given = values(f"load at {node!r}", force, FORCES)
        if any(value.ndim for value in given.values()):
            self._join({f"{FORCES[k]} at {node!r}": value.shape for k, value in given.items()})
        self.loads.setdefault(node, []).extend(given.items())

    def line_load(
        self, member: str, *, local: bool = False, span: tuple[float, float] | None = None, **force: ArrayLike
    ) -> None:
        """Apply a force per length to a member.

        Parameters
        ----------
        member
            Name of the member.
        local
            Components in the member's own axes instead of the global ones.
        span
            Distances from the member's start between which the load acts; the whole length where None.
        **force
            Force per length by component, ``fx fy fz``, (...); a tuple ``(start, end)`` varies linearly over the span.

        Raises
        ------
        FrameError
            If the member or a component is unknown, the span is not on the member, or shapes do not broadcast.

        Examples
        --------
        A cantilever of 1 m under 100 N/m, ``M = q L^2 / 2`` at the clamp (Timoshenko, *Strength of Materials* I), and
        under a load that falls to zero at the tip, ``M = q L^2 / 6``.

        >>> from linkframe.elements import Beam, Circle, Material
        >>> from linkframe.framework import Frame
        >>> def clamp(force):
        ...     frame = Frame()
        ...     for name, x in {"A": 0.0, "B": 1.0}.items():
        ...         frame.node(name, (x, 0.0, 0.0))
        ...     frame.add("AB", Beam(Circle(diameter=0.02), Material(E=200e9, nu=0.3)), "A", "B")
        ...     frame.fix("A"); frame.line_load("AB", fy=force)
        ...     return float(frame.solve().reaction("A")[5].round(6))
        >>> clamp(-100.0), clamp((-100.0, 0.0))
        (50.0, 16.666667)
        """
        member = self._member(member, "line load")
        pairs = {k: v if isinstance(v, tuple) and len(v) == 2 else (v, v) for k, v in force.items()}
        what = f"line load on {member!r}"
        start, end = (values(what, {k: pair[side] for k, pair in pairs.items()}, FORCES[:3]) for side in (0, 1))
        stretch = None if span is None else self._span(member, span)
        starts = {f"{FORCES[k]} at the start of the {what}": value.shape for k, value in start.items()}
        self._join(starts | {f"{FORCES[k]} at the end of the {what}": value.shape for k, value in end.items()})
        load = LineLoad(_stacked(start, 3), _stacked(end, 3), stretch, local)
        self.member_loads.setdefault(member, []).append(load)

    def point_load(self, member: str, *, at: float, local: bool = False, **force: ArrayLike) -> None:
        """Apply a force or moment to a point of a member.

        Parameters
        ----------
        member
            Name of the member.
        at
            Distance from the member's start, length, from 0 to that of the member.
        local
            Components in the member's own axes instead of the global ones.
        **force
            Values by component: force ``fx fy fz`` and moment ``mx my mz``, (...).

        Raises
        ------
        FrameError
            If the member or a component is unknown, `at` is not on the member, or shapes do not broadcast.

        Examples
        --------
        >>> from linkframe.elements import Beam, Circle, Material
        >>> from linkframe.framework import Frame
        >>> frame = Frame()
        >>> for name, x in {"A": 0.0, "B": 1.0}.items():
        ...     frame.node(name, (x, 0.0, 0.0))
        >>> frame.add("AB", Beam(Circle(diameter=0.02), Material(E=200e9, nu=0.3)), "A", "B")
        >>> frame.fix("A"); frame.point_load("AB", at=0.25, fy=-100.0)
        >>> float(frame.solve().reaction("A")[5].round(9))
        25.0
        """
        member = self._member(member, "point load")
        given = values(f"point load on {member!r}", force, FORCES)
        place = unvaried(at)
        if place is None or not 0.0 <= place <= self._least_length(member):
            raise FrameError(f"point load on {member!r} at {at!r}: give one distance within its length")
        self._join({f"{FORCES[k]} of the point load on {member!r}": value.shape for k, value in given.items()})
        self.member_loads.setdefault(member, []).append(PointLoad(float(place), _stacked(given, 6), local))

    def gravity(self, acceleration: ArrayLike) -> None:
        """Apply the weight of all members and masses.

        Parameters
        ----------
        acceleration
            Acceleration of gravity, global, (..., 3), length per time squared, such as ``(0, 0, -9.81)``.

        Raises
        ------
        FrameError
            If the acceleration is not three finite numbers, or shapes do not broadcast.

        Examples
        --------
        >>> from linkframe.elements import PointMass
        >>> from linkframe.framework import Frame
        >>> frame = Frame()
        >>> frame.node("A", (0.0, 0.0, 0.0)); frame.fix("A")
        >>> frame.add("block", PointMass(2.0), "A")
        >>> frame.gravity((0.0, 0.0, -9.81))
        >>> float(frame.solve().reaction("A")[2].round(9))
        19.62
        """
        weight = vector(acceleration, "gravity")
        self._join({"gravity": weight.shape[:-1]})
        self.weight = weight

    def _least_length(self, member: str) -> float:
        """Shortest length of a member over the batch, plus an allowance for rounding: loads must lie within it."""
        return float(self.length(member).min(initial=np.inf)) * (1.0 + 1e-12)

    def _span(self, member: str, span: tuple[float, float]) -> tuple[float, float]:
        ends, length = unvaried(span, (2,)), self._least_length(member)
        if ends is None or not 0.0 <= ends[0] < ends[1] <= length:
            wanted = f"two distances 0 <= x1 < x2 <= its length {length:.6g}"
            raise FrameError(f"line load on {member!r} spans {span!r}: give {wanted}")
        return float(ends[0]), float(ends[1])


def cubic_line_load(described: DescribedLoads, member: str, values: Sequence[Array]) -> None:
    """Apply a force per length that is a cubic along the whole of a member.

    Parameters
    ----------
    described
        The frame.
    member
        Name of the member.
    values
        Four vectors (..., 3): force per length in global axes at 0, 1/3, 2/3 and 1 of the member's length.

    Raises
    ------
    FrameError
        If the member is unknown, or shapes do not broadcast.
    """
    member = described._member(member, "line load")
    load = LineLoad.through(values)
    what = f"line load on {member!r}"
    described._join({f"the {name} of the {what}": vectors.shape[:-1] for name, vectors in load.parts.items()})
    described.member_loads.setdefault(member, []).append(load)


def _stacked(given: Mapping[int, Array], size: int) -> Array:
    """Values by component as one array (..., size), zero where none is given."""
    return np.stack(np.broadcast_arrays(*(given.get(k, np.zeros(())) for k in range(size))), axis=-1)
