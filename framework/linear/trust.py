"""How far the results of a linear solution hold: error bounds, sensitivity, conditioning, linearity."""

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
    """Results with bounds on their error, their derivatives, and the measures of how well they are conditioned."""

    def error_bound(self, name: str, of: str = "displacement", components: Sequence[str] | None = None) -> Array:
        """Bound on the error of results against the exact solution of the frame as it is described.

        All rounding is included: lengths and axes of members, their stiffnesses, assembly, elimination, recovery. The
        numbers of the description are taken as exact.

        Parameters
        ----------
        name
            The node; or the joint or member where `of` says so.
        of
            ``displacement``, ``reaction``, ``joint_displacement``, ``joint_force`` or ``end_forces``.
        components
            Those that are asked for, such as ``("ux", "uy")``, each of which costs an adjoint solution, or of
            displacements of a large frame some iterations; all where None.

        Returns
        -------
        ndarray
            By component, of the shape of the result: (..., 6), or (..., 12) for ``end_forces``, or (..., m) for the m
            `components`. inf where the loads
            reach what can move, and where it is too close to that for any digit to be certain.

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
        """Result after one step of iterative refinement in extended precision, and the bound on its error.

        Worth it where `error_bound` is large: what is left is what rounding of the members' stiffnesses leaves open.

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
        """Derivative of one component of a result by every load, joint stiffness, offset, support, member and node.

        They come from one adjoint solve (Choi & Kim, *Structural Sensitivity Analysis and Optimization 1*, 2005, ch.
        2). Those by loads, offsets and supports do not depend on the load, and hold where there is none.

        Parameters
        ----------
        name
            The node or joint.
        component
            Such as ``uy``; such as ``fy`` where the result is a force.
        of
            ``displacement``, ``reaction``, ``joint_displacement`` or ``joint_force``.

        Returns
        -------
        Sensitivity
            By name, each (..., 6); NaN where what the result depends on is a mechanism, loaded or not. By coordinates
            of nodes, sizes of sections and Young's moduli when they are asked for.

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
        """Least singular value of the deformations by the unknowns, their columns scaled to length one, (...).

        Of what the loads reach; of the whole frame where there are none.

        With the stiffness as springs k on deformations B q it is that of ``sqrt(k) B``, the square root of the least
        eigenvalue of the scaled stiffness: rounding (1e-15) where nothing resists some motion. For a four-bar it falls
        in proportion to the angle from a singular pose.

        Returns
        -------
        ndarray
            From 0 to about 1, (...), without unit.

        Examples
        --------
        A low arch of two pinned bars: in proportion to its height.

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
        """Estimated relative error of the displacements by their being linear, (...).

        inf where the frame is a mechanism, and where its load exceeds a buckling load.

        From the forces out of balance in the displaced shape, that within clearances included, and its rotations; see
        `linkframe.framework.results.validity`. A contact that changes side on the way is not foreseen.

        Returns
        -------
        ndarray
            Zero or above, (...): 0.05 stands for displacements that are off by 5 %.

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
        """2-norm condition number of K, assembled in the usual way with joints as springs between nodes, (...).

        Returns
        -------
        ndarray
            Greatest over least singular value, (...); inf or huge where the frame is a mechanism.
        """
        return self._read("condition", lambda: usual(self.plan))

    def scaled_condition_number(self) -> Array:
        """2-norm condition number of K in joint-relative coordinates, scaled node by node, (...).

        One unit of length for the displacements of a node and one of angle for its rotations are such that the mean of
        their stiffness is one; in a joint, of what springs of the same stiffness resist. So it is the same in whatever
        axes the frame, its bodies or a joint of equal springs are described.

        Returns
        -------
        ndarray
            Greatest over least singular value, (...): about as many of 16 digits are at risk as it has; inf where
            nothing resists. The coordinates of a loop are those of the entry alone, and may be others where the joints
            of the loop are described in another order, or ideal ones that close it in other axes.
        """
        return self._read("scaled", lambda: scaled(self.plan))

    @cached_property
    def bounds(self) -> Bounds:
        """Estimates of the error of results."""
        return Bounds(self)

    def _asked(self, name: str, of: str) -> tuple[str, Array]:
        """The name in the description of what is asked for, and the result."""
        if self.clearances is not None:
            raise FrameError(
                "bounds, refinement and sensitivities are those of a linear solution, and this one has contacts in its "
                "joints' clearances: ask frame.solve(clearance=False), with frame.offset for the contact"
            )
        result: Array = getattr(self, checked_kind(of))(name)
        return self.frame.aliases.get(name, name) if of in ("displacement", "reaction") else name, result
