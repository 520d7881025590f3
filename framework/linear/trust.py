"""Accuracy of a linear solution: error bounds, sensitivity, condition numbers, and whether linear theory holds."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..batch import Array
from ..error_bounds.bounds import Bounds
from ..error_bounds.requested import checked as checked_kind
from ..error_bounds.requested import numbered
from ..error_bounds.sensitivity import Sensitivity, sensitivity
from ..errors import FrameError
from ..results.conditioning import scaled, usual
from ..results.parts import node_of
from ..results.validity import LINEAR, nonlinearity
from .results import NamedResults


class ResultsWithBounds(NamedResults):
    """Results with error bounds, derivatives, condition numbers and an estimate of the error of linear theory."""

    def error_bound(self, name: str, of: str = "displacement", components: Sequence[str] | None = None) -> Array:
        """Bound on the rounding error of results, against the exact linear solution of the frame as described.

        All rounding is included: lengths and axes of members, their stiffnesses, assembly, elimination, recovery. The
        numbers of the description are taken as exact.

        Parameters
        ----------
        name
            The node; or the joint or member where `of` says so.
        of
            ``displacement``, ``reaction``, ``joint_displacement``, ``joint_force`` or ``end_forces``.
        components
            Components to bound, such as ``("ux", "uy")``; all where None. Each costs one adjoint solution, or some
            iterations for a displacement of a large frame.

        Returns
        -------
        ndarray
            Bounds by component, in the units of the result: (..., 6), or (..., 12) for ``end_forces``, or (..., m) for
            the m `components`. inf where a loaded part is a mechanism, or so close to one that no digit is certain.

        Raises
        ------
        FrameError
            Where the name, the kind of result or a component is unknown, or components of end forces are asked for.

        Examples
        --------
        The stated bound is above what differs from the exact 2.5 mm, and of the size of the last digit.

        >>> from linkframe.elements import Beam, Material, Rectangle
        >>> from linkframe.framework import Frame
        >>> frame = Frame()
        >>> for name, x in {"A": 0.0, "B": 1.0}.items():
        ...     frame.node(name, (x, 0.0, 0.0))
        >>> frame.add("AB", Beam(Rectangle(y=0.02, z=0.01), Material(E=200e9, nu=0.3)), "A", "B")
        >>> frame.fix("A"); frame.load("B", fy=10.0)
        >>> solution = frame.solve()
        >>> bound = solution.error_bound("B")[1]
        >>> bool(abs(solution.displacement("B")[1] - 2.5e-3) <= bound), bool(bound < 1e-15)
        (True, True)
        """
        if (own := self.part(node_of(self.frame, name, of))) is not self:
            return own.error_bound(name, of, components)
        name, computed = self._asked(name, of)
        some = None if components is None else numbered(of, components)
        chosen = computed if some is None else computed[..., list(some)]
        return self._read(
            ("bound", of, name, some),
            lambda: self._unknown(self.bounds.bound(name, of, chosen, some)),
            mask=np.inf,
        )

    def refined(self, name: str, of: str = "displacement") -> tuple[Array, Array]:
        """Result after one step of iterative refinement in extended precision, and a bound on its error.

        It helps where `error_bound` is large: only the effect of rounding in the members' stiffnesses remains.

        Parameters
        ----------
        name
            The node; or the joint or member where `of` says so.
        of
            As for `error_bound`.

        Returns
        -------
        tuple of ndarray
            Results and bounds, (..., 6), or (..., 12) for ``end_forces``.

        Raises
        ------
        FrameError
            Where the name or the kind of result is unknown.

        Examples
        --------
        >>> from linkframe.elements import Beam, Material, Rectangle
        >>> from linkframe.framework import Frame
        >>> frame = Frame()
        >>> for name, x in {"A": 0.0, "B": 1.0}.items():
        ...     frame.node(name, (x, 0.0, 0.0))
        >>> frame.add("AB", Beam(Rectangle(y=0.02, z=0.01), Material(E=200e9, nu=0.3)), "A", "B")
        >>> frame.fix("A"); frame.load("B", fy=10.0)
        >>> value, bound = frame.solve().refined("B")
        >>> bool(abs(value[1] - 2.5e-3) <= bound[1])
        True
        """
        if (own := self.part(node_of(self.frame, name, of))) is not self:
            return own.refined(name, of)
        name, computed = self._asked(name, of)
        values, bounds = self.bounds.refined(name, of)
        if self.consistent_mechanisms is not None:
            values = np.where(np.isinf(bounds), computed, values)
        return self._masked(values), self._masked(self._unknown(bounds), np.inf)

    def sensitivity(self, name: str, component: str, of: str = "displacement") -> Sensitivity:
        """Sensitivity of one component of a result to every load, joint stiffness, offset, support, member and node.

        All derivatives come from one adjoint solution (Choi & Kim, *Structural Sensitivity Analysis and Optimization
        1*, 2005, ch. 2). Those by loads, offsets and supports do not depend on the load; they exist for an unloaded
        frame as well.

        Parameters
        ----------
        name
            The node or joint.
        component
            Name of the component: ``ux`` to ``rz``, or ``fx`` to ``mz`` where the result is a force.
        of
            ``displacement``, ``reaction``, ``joint_displacement`` or ``joint_force``.

        Returns
        -------
        Sensitivity
            Derivatives by name, each (..., 6); NaN where the part on which the result depends is a mechanism, loaded or
            not. Those by coordinates of nodes, sizes of sections and moduli are computed when they are read.

        Raises
        ------
        FrameError
            Where the name, the component or the kind of result is unknown.

        Examples
        --------
        A deflection is in inverse proportion to Young's modulus: ``E du/dE = -u``, the sum over a member's stiffnesses.

        >>> from linkframe.elements import Beam, Material, Rectangle
        >>> from linkframe.framework import Frame
        >>> frame = Frame()
        >>> for name, x in {"A": 0.0, "B": 1.0}.items():
        ...     frame.node(name, (x, 0.0, 0.0))
        >>> frame.add("AB", Beam(Rectangle(y=0.02, z=0.01), Material(E=200e9, nu=0.3)), "A", "B")
        >>> frame.fix("A"); frame.load("B", fy=10.0)
        >>> found = frame.solve().sensitivity("B", "uy")
        >>> float(found.members["AB"].sum().round(12)), float(found.loads["B"][1].round(12))
        (-0.0025, 0.00025)
        >>> float(found.nodes["B"][0].round(12)), float(found.sections["AB"]["y"].round(9))
        (0.0075, -0.375)
        """
        if (own := self.part(node_of(self.frame, name, of))) is not self:
            return own.sensitivity(name, component, of)
        name, _ = self._asked(name, of)
        return sensitivity(self, name, component, of)

    def distance_to_singularity(self) -> Array:
        """Distance from a mechanism: the least singular value of the scaled deformation matrix, (...).

        With the stiffness as springs k on deformations ``B q`` of the unknowns q, the matrix is ``sqrt(k) B``, its
        columns scaled to length one; its least singular value is the square root of the least eigenvalue of the
        diagonally scaled stiffness. It is of the order of rounding (1e-15) for a mechanism, and for a four-bar
        proportional to the angle from a singular pose. It refers to the loaded parts of the frame, or to the whole
        frame where there are no loads.

        Returns
        -------
        ndarray
            From 0 to about 1, (...), without unit.

        Examples
        --------
        A low arch of two pinned bars: the distance is proportional to the height of the arch.

        >>> import numpy as np
        >>> from linkframe.elements import Beam, Circle, Joint, Material
        >>> from linkframe.framework import Frame
        >>> rod, pin = Beam(Circle(diameter=0.02), Material(E=200e9, nu=0.3)), Joint(stiffness=(np.inf,) * 5 + (0.0,))
        >>> height = np.array([1e-3, 1e-4, 1e-5])
        >>> frame = Frame()
        >>> for name, x in {"A": 0.0, "B": 1.0, "C": 1.0, "D": 2.0}.items():
        ...     frame.node(name, np.stack(np.broadcast_arrays(x, height if name in "BC" else 0.0, 0.0), axis=-1))
        >>> frame.add("AB", rod, "A", "B"); frame.add("CD", rod, "C", "D"); frame.add("pin", pin, "B", "C")
        >>> for foot in "AD":
        ...     frame.fix(foot, "ux", "uy", "uz", "rx", "ry")
        >>> frame.load("B", fy=-1.0)
        >>> distance = frame.solve().distance_to_singularity()
        >>> (distance / distance[0]).round(2).tolist()
        [1.0, 0.1, 0.01]
        """
        return self._read("distance", lambda: self.bounds.distance())

    def nonlinearity(self) -> Array:
        """Estimated relative error of linear theory in the displacements, (...).

        It is estimated from the forces that are out of balance in the displaced shape, displacements within clearances
        included, and from the rotations; see `linkframe.framework.results.validity`. Contacts that change side while
        the load grows are not taken into account.

        Returns
        -------
        ndarray
            Zero or above, (...): 0.05 stands for displacements that are off by 5 %; inf where the frame is a mechanism,
            or its load exceeds a buckling load.

        Examples
        --------
        A cantilever bent by a twentieth of its length, and by half of it.

        >>> from linkframe.elements import Beam, Material, Rectangle
        >>> from linkframe.framework import Frame
        >>> frame = Frame()
        >>> for name, x in {"A": 0.0, "B": 1.0}.items():
        ...     frame.node(name, (x, 0.0, 0.0))
        >>> frame.add("AB", Beam(Rectangle(y=0.02, z=0.01), Material(E=200e9, nu=0.3)), "A", "B")
        >>> frame.fix("A"); frame.load("B", fy=[200.0, 2000.0])
        >>> frame.solve().linear.tolist()
        [True, False]
        """
        return self._read("nonlinearity", lambda: nonlinearity(self))

    @property
    def linear(self) -> NDArray[np.bool_]:
        """Whether linear mechanics holds, (...): where `nonlinearity` is below 0.05."""
        return self.nonlinearity() < LINEAR

    def condition_number(self) -> Array:
        """2-norm condition number of the stiffness in the usual assembly, with joints as springs between nodes, (...).

        Returns
        -------
        ndarray
            Greatest over least singular value, (...); inf or huge where the frame is a mechanism.

        Raises
        ------
        FrameError
            If the frame has rigid links or ties, or joints that are ideal in some directions only: they have no usual
            assembly.
        """
        return self._read("condition", lambda: usual(self.plan))

    def scaled_condition_number(self) -> Array:
        """2-norm condition number of the stiffness in joint-relative coordinates, scaled node by node, (...).

        The three displacements of a node are scaled to a mean diagonal stiffness of one, and so are its three
        rotations; in a joint, the components whose springs have the same stiffness. The number is therefore the same
        in whatever axes the frame, its bodies or a joint of equal springs are described.

        Returns
        -------
        ndarray
            Greatest over least singular value, (...): its decimal logarithm is about the number of digits, out of 16,
            that rounding may cost; inf for a mechanism. In a frame with loops it may depend somewhat on the order in
            which joints are described, and on the axes of the ideal joints that close a loop.
        """
        return self._read("scaled", lambda: scaled(self.plan))

    @cached_property
    def bounds(self) -> Bounds:
        """The error bounds of all results, computed as they are read."""
        return Bounds(self)

    def _asked(self, name: str, of: str) -> tuple[str, Array]:
        """The name by which the node, joint or member is described, and its result of the kind `of`."""
        if self.clearances is not None:
            raise FrameError(
                "bounds, refinement and sensitivities are those of a linear solution, and this one has contacts in its "
                "joints' clearances: ask frame.solve(clearance=False), with frame.offset for the contact"
            )
        result: Array = getattr(self, checked_kind(of))(name)
        return self.frame.aliases.get(name, name) if of in ("displacement", "reaction") else name, result
