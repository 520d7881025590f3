"""A frame as a user has it: the description of nodes, members, joints, supports and loads, and what it answers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, overload

from .bulk import InBulk
from .checked import switch
from .errors import FrameError

# What solves takes longer to load than all that describes a frame: it is loaded where it is first asked for.
if TYPE_CHECKING:
    from .large.path import EquilibriumPath
    from .large.solution import LargeSolution
    from .matrices import FrameMatrices
    from .results.buckling import Buckling
    from .results.modes import Modes
    from .solution import Solution
    from .structure.topology import Topology


@dataclass(eq=False, repr=False)
class Frame(InBulk):
    """Frame of beams and joints; what varies over a batch is given as arrays.

    The batch shape is the NumPy broadcast of everything that the description holds: 36 poses given as ``(36, 1)``
    and 100 samples as ``(100,)`` make displacements ``(36, 100, 6)``.

    Attributes
    ----------
    shape
        Batch shape: the broadcast of all that has been described.
    bodies, nodes, members, joints, masses
        The description by name, in the order in which it was given.
    aliases
        Other names of nodes.
    node_sets, element_sets
        Names of the nodes, and of the members and joints, in each set of the mesh that the frame is from.
    ties
        Rigid links and ties.
    supports
        By node: prescribed displacement, (...), by index of the component.
    offsets
        By joint: imposed relative displacement, (...), by index of the component in the joint's axes.
    idle
        By joint: a rotation that it constrains as long as nothing else resists it and no load works on it.
    loads
        By node: index of the component and value, (...), of each load.
    member_loads
        By member: line and point loads.
    weight
        Acceleration of gravity (..., 3).
    absent
        Batch entries that are left out, (...); None for none.
    made_from
        What the frame was made from, such as a motion: what its status says of entries that are not regular, solutions
        of the frame say too.
    size
        Largest coordinate, the measure of what coincides.
    tolerance
        Length up to which the two nodes of a joint may lie apart and count as one place.
    axes
        Names of the batch axes, such as ``("pose", "sample")``, the last of which is the last of the batch; tables of
        results have them (`Solution.to_xarray`). Empty where they have none.

    Examples
    --------
    >>> from linkframe.elements import Beam, Material, Rectangle
    >>> steel = Material(E=200e9, nu=0.3)
    >>> frame = Frame()
    >>> frame.node("A", (0.0, 0.0, 0.0))
    >>> frame.node("B", (1.0, 0.0, 0.0))
    >>> frame.add("AB", Beam(Rectangle(y=0.02, z=0.01), steel), "A", "B")
    >>> frame.fix("A")
    >>> frame.load("B", fy=[-10.0, -20.0])
    >>> frame.solve().displacement("B")[:, 1]
    array([-0.0025, -0.005 ])
    """

    @overload
    def solve(
        self, method: str | None = None, *, clearance: bool = True, large: Literal[False] = False
    ) -> Solution: ...

    @overload
    def solve(
        self, method: None = None, *, clearance: bool = True, large: Literal[True], steps: int = 1
    ) -> LargeSolution: ...

    def solve(
        self, method: str | None = None, *, clearance: bool = True, large: bool = False, steps: int = 1
    ) -> Solution | LargeSolution:
        """Static solution of the whole batch; lazy, so nothing is computed that nobody reads.

        Where joints have clearance, it is the equilibrium at which each journal rests in its bearing, found at once
        together with the compliance (see `linkframe.framework.clearances.clearance`); ``solution.contact(joint)``
        tells where.

        Parameters
        ----------
        method
            ``broadcast`` or ``banded`` (LAPACK, a band for each entry) for any batch; or for one large frame, whose
            stiffness does not vary, ``sparse`` (SuperLU), ``cholesky`` (CHOLMOD, with the extra ``fast``) or
            ``iterative`` (conjugate gradients). Where None, the plan takes what promises to be fastest; ``explain()``
            says what and why. The results are the same.
        clearance
            Whether the joints' clearances are taken into account; False leaves compliance alone, so that the
            difference is the displacement by clearance.
        large
            Equilibrium at finite displacement and rotation, to which `method` does not apply. Members are cut into
            their ``segments``.
        steps
            For `large`, number of equal steps in which loads, offsets and prescribed displacements grow.

        Returns
        -------
        Solution or LargeSolution
            Displacements, forces, stresses and their error bounds by name, each of the batch shape, computed when read;
            a `LargeSolution` where `large` is True.

        Raises
        ------
        FrameError
            Where the method is unknown, not installed, or not for this batch, or a switch is neither True nor False.

        Examples
        --------
        A cantilever of 1 m under 10 N at its tip, ``F L^3 = 3 E I uy`` (Timoshenko, *Strength of Materials* I), as a
        batch of two forces; and under a hundred times as much at large displacement, where the tip comes nearer to the
        wall (Mattiasson, Int. J. Numer. Methods Eng. 17 (1981) 145-153).

        >>> from linkframe.elements import Beam, Material, Rectangle
        >>> from linkframe.framework import Frame
        >>> frame = Frame()
        >>> for name, x in {"A": 0.0, "B": 1.0}.items():
        ...     frame.node(name, (x, 0.0, 0.0))
        >>> frame.add("AB", Beam(Rectangle(y=0.02, z=0.01), Material(E=200e9, nu=0.3), segments=8), "A", "B")
        >>> frame.fix("A"); frame.load("B", fy=[10.0, 1000.0])
        >>> frame.solve().displacement("B")[:, :2].round(6).tolist()
        [[0.0, 0.0025], [0.0, 0.25]]
        >>> frame.solve(large=True).displacement("B")[:, :2].round(4).tolist()
        [[-0.0, 0.0025], [-0.034, 0.2356]]
        """
        from .solution import Solution

        switch(clearance, "clearance in solve")
        switch(large, "large in solve")
        if not large and steps != 1:
            raise FrameError(f"solve was given steps={steps!r}, which a linear solution has not: add large=True")
        if large:
            from .large.by_planes import solved

            return solved(self, method, clearance, steps)
        return Solution.of(self, method, clearance=clearance)

    def path(self, node: str, component: str, to: float, *, steps: int = 200, first: float = 0.05) -> EquilibriumPath:
        """Equilibrium path at large displacement from rest on, past limit points where the load falls, by arc length.

        Parameters
        ----------
        node, component
            Displacement that tells where to end.
        to
            Its value there, length or radians.
        steps
            Largest number of points.
        first
            Load factor of the first step; later ones follow the number of iterations.

        Returns
        -------
        EquilibriumPath
            Points with their load ``factor`` (points, ...), ``displacement(node)`` (points, ..., 6), ``stable``
            (points, ...), the ``limits`` of the load factor, and where `to` was ``reached`` (...).

        Raises
        ------
        FrameError
            Where node or component are unknown, `to` is zero, or `steps` or `first` are not above zero.

        Warns
        -----
        PathWarning
            Where a path ends before `to`.

        Examples
        --------
        Two bars in line that are pushed through a low arch: the load rises to a limit point and falls again.

        >>> from linkframe.elements import Beam, Circle, Joint, Material
        >>> from linkframe.framework import Frame
        >>> rod, pin = Beam(Circle(diameter=0.02), Material(E=200e9, nu=0.3)), Joint(stiffness=(1e12,) * 5 + (0.0,))
        >>> frame = Frame()
        >>> for name, place in {"A": (0.0, 0.0, 0.0), "B": (1.0, 0.05, 0.0), "C": (1.0, 0.05, 0.0)}.items():
        ...     frame.node(name, place)
        >>> frame.add("AB", rod, "A", "B"); frame.add("pin", pin, "B", "C")
        >>> frame.fix("A", "ux", "uy", "uz", "rx", "ry"); frame.fix("C", "ux", "uz", "rx", "ry", "rz")
        >>> frame.load("C", fy=-1000.0)
        >>> path = frame.path("C", "uy", to=-0.1)
        >>> bool(path.reached), bool(path.factor.max() > 1.0), len(path.limits[0])
        (True, True, 2)
        """
        from .large.path import follow

        return follow(self, node, component, to, steps, first)

    def modes(self, count: int) -> Modes:
        """The lowest natural frequencies and mode shapes, of the frame with its joints in contact all round.

        Parameters
        ----------
        count
            Number of modes, from 1 to the number of unknowns.

        Returns
        -------
        Modes
            ``frequencies`` in Hz, (..., count), the lowest first, and ``shapes(node)``, (..., count, 6).

        Raises
        ------
        FrameError
            If `count` is not among these, the frame has no mass, or fewer modes with mass.

        Examples
        --------
        A clamped rod of 1 m, ``3.516 / (2 pi) sqrt(E I / m L^4)`` (Timoshenko, *Vibration Problems in Engineering*).

        >>> from linkframe.elements import Beam, Circle, Material
        >>> from linkframe.framework import Frame
        >>> frame = Frame()
        >>> for name, x in {"A": 0.0, "B": 1.0}.items():
        ...     frame.node(name, (x, 0.0, 0.0))
        >>> steel = Material(E=200e9, nu=0.3, density=7850.0)
        >>> frame.add("AB", Beam(Circle(diameter=0.02), steel, segments=8), "A", "B")
        >>> frame.fix("A")
        >>> float(frame.modes(1).frequencies[0].round(2))
        14.12
        """
        from .results.modes import modes

        return modes(self, count)

    def buckling(self, count: int) -> Buckling:
        """The lowest load factors at which the loaded frame buckles, with its joints in contact all round.

        Parameters
        ----------
        count
            Number of factors, from 1 to the number of unknowns.

        Returns
        -------
        Buckling
            ``factors``, (..., count), by which all loads may grow, the smallest positive first and inf where there are
            no more; and ``shapes(node)``, (..., count, 6).

        Raises
        ------
        FrameError
            If `count` is not among these, or the frame is a mechanism without its loads. In a batch of which some
            entries are, their factors are NaN, and a `MechanismWarning` tells so.

        Examples
        --------
        Euler's column, clamped at its foot: ``pi^2 E I / (4 L^2)`` (Timoshenko & Gere, *Theory of Elastic Stability*,
        ch. 2).

        >>> from linkframe.elements import Beam, Circle, Material
        >>> from linkframe.framework import Frame
        >>> frame = Frame()
        >>> for name, z in {"A": 0.0, "B": 1.0}.items():
        ...     frame.node(name, (0.0, 0.0, z))
        >>> frame.add("AB", Beam(Circle(diameter=0.02), Material(E=200e9, nu=0.3), segments=8), "A", "B")
        >>> frame.fix("A"); frame.load("B", fz=-1000.0)
        >>> float(frame.buckling(1).factors[0].round(3))
        3.876
        """
        from .results.buckling import buckling

        return buckling(self, count)

    @property
    def mesh(self) -> Any:
        """The first batch entry as a scikit-fem ``MeshLine1`` with 3-D points, members cut into their segments.

        Its subdomains are ``beam``, ``joint`` and, if there are any, ``rigid``; each member and joint by its name; and
        each body with the members on it. Its boundaries are the supported nodes. A basis on it needs the mapping
        `linkframe.elements.ArcLengthMapping`, as scikit-fem's own is for solids.
        """
        return self._numbered.mesh

    @property
    def dofs(self) -> Any:
        """Numbering of `mesh`, a ``Dofs``: six a node, ``ux uy uz rx ry rz``, nodes in the order of description."""
        return self._numbered.numbering

    def basis(self, on: str | Sequence[str] = "beam", *, intorder: int = 6) -> Any:
        """A scikit-fem ``Basis`` over members of one kind, on `mesh` and numbered as `dofs`.

        Its fields are the displacement by the members' own shape functions, in their own axes, ``u[0]`` to ``u[5]``
        for ``ux uy uz rx ry rz``, with the derivative along the member as ``u.grad``; the degrees of freedom are
        global.

        Parameters
        ----------
        on
            A member, a body (all members on it), ``"beam"`` for all members, or several of these.
        intorder
            Order of integration; 6 is exact for two displacements of a prismatic beam.

        Returns
        -------
        skfem.Basis
            Of the first batch entry.

        Raises
        ------
        FrameError
            If `on` names nothing, or members of several kinds.

        Examples
        --------
        >>> import skfem
        >>> from linkframe.elements import Beam, Material, Rectangle
        >>> frame = Frame()
        >>> for name, x in {"A": 0.0, "B": 3.0}.items():
        ...     frame.node(name, (x, 0.0, 0.0))
        >>> frame.add("AB", Beam(Rectangle(y=0.02, z=0.01), Material(E=200e9, nu=0.3)), "A", "B")
        >>> along = skfem.LinearForm(lambda v, w: 2.0 * v[0])
        >>> float(along.assemble(frame.basis("AB")).sum().round(9))
        6.0
        """
        from .basis import frame_basis

        return frame_basis(self, on, intorder)

    @property
    def _numbered(self) -> Topology:
        from .structure.topology import Topology

        return Topology.of(self.copy(), cut=True)

    def matrices(self, entry: int | Sequence[int] = ()) -> FrameMatrices:
        """Stiffness, mass, geometric stiffness and loads at one batch entry, sparse, in scikit-fem's numbering.

        Parameters
        ----------
        entry
            Indices of the batch entry, one for each batch axis.

        Returns
        -------
        FrameMatrices
            ``K M f`` over all displacements, supports as ``D x``, and ``T g`` of all that holds; ``Kg`` under the
            loads is found when it is asked for.

        Raises
        ------
        FrameError
            If the batch has no such entry.

        Examples
        --------
        >>> from linkframe.elements import Beam, Circle, Material
        >>> from linkframe.framework import Frame
        >>> frame = Frame()
        >>> for name, x in {"A": 0.0, "B": 1.0}.items():
        ...     frame.node(name, (x, 0.0, 0.0))
        >>> frame.add("AB", Beam(Circle(diameter=0.02), Material(E=200e9, nu=0.3)), "A", "B")
        >>> frame.fix("A"); frame.load("B", fy=[10.0, 20.0])
        >>> second = frame.matrices(1)
        >>> second.K.shape, float(second.f[7]), second.D.tolist()
        ((12, 12), 20.0, [0, 1, 2, 3, 4, 5])
        """
        from .matrices import frame_matrices

        return frame_matrices(self, entry)

    def explain(self) -> str:
        """What a linear solution will build, at which batch shapes, and what it skips and why, in plain words.

        For large displacement: ``frame.solve(large=True).explain()``.

        Returns
        -------
        str
            Lines for a reader: batch shapes, the method and why it was picked, what is eliminated in which order.

        Examples
        --------
        >>> from linkframe.elements import Beam, Circle, Material
        >>> from linkframe.framework import Frame
        >>> frame = Frame()
        >>> for name, x in {"A": 0.0, "B": 1.0}.items():
        ...     frame.node(name, (x, 0.0, 0.0))
        >>> frame.add("AB", Beam(Circle(diameter=0.02), Material(E=200e9, nu=0.3)), "A", "B")
        >>> frame.fix("A"); frame.load("B", fy=[10.0, 20.0])
        >>> "(2,)" in frame.explain()
        True
        """
        return self.solve().explain()
