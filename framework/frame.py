"""The class `Frame`: a description of nodes, members, joints, supports and loads, with the analyses that solve it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, overload

# What solves takes longer to load than a description: a module that is imported as such is loaded when first used.
from . import basis, matrices, solution
from .bulk import InBulk
from .checked import switch
from .errors import FrameError
from .large import by_planes, path
from .results import buckling, modes
from .structure import topology

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
    """Frame of beams and joints, described part by part and then solved for a whole batch at once.

    Any number of the description may be an array that varies over the batch. The batch shape is the NumPy broadcast of
    all of them: 36 poses given as ``(36, 1)`` and 100 samples as ``(100,)`` make displacements ``(36, 100, 6)``.

    Attributes
    ----------
    shape
        Batch shape: the broadcast of all that has been described.
    bodies, nodes, members, joints, masses
        The description by name, in the order in which it was given.
    aliases
        Other names of nodes.
    node_sets, element_sets
        Names of the nodes, and of the members and joints, in each set of the mesh that the frame was made from.
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
        By member: line loads, point loads and loads by scikit-fem forms.
    weight
        Acceleration of gravity (..., 3).
    absent
        Batch entries that are left out, (...); None for none.
    made_from
        What the frame was made from, such as a motion. Where the motion is not regular, solutions of the frame carry
        its status.
    size
        Largest absolute coordinate of all nodes, by which it is judged whether two nodes coincide.
    tolerance
        Distance up to which the two nodes of a joint count as coincident; 0 allows for rounding alone.
    axes
        Names of the batch axes, such as ``("pose", "sample")``, aligned with the last axes of the batch; tables of
        results are labelled by them (`Solution.to_xarray`). Empty for axes without names.

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
        """Static solution of the whole batch; each result is computed when it is first read.

        Where joints have clearance, the contact state of each journal in its bearing is found together with the elastic
        displacements (see `linkframe.framework.clearances.clearance`); read it from ``solution.contact(joint)``.

        Parameters
        ----------
        method
            ``broadcast`` or ``banded`` (LAPACK, a band for each entry) for any batch; or for one large frame, whose
            stiffness does not vary, ``sparse`` (SuperLU), ``cholesky`` (CHOLMOD, with the extra ``fast``) or
            ``iterative`` (conjugate gradients). None chooses the method that is expected to be fastest; ``explain()``
            says which and why. The results agree to rounding.
        clearance
            Whether the joints' clearances are taken into account. With False only the compliance is left; the
            difference of the two is the displacement due to clearance.
        large
            Whether to find the equilibrium at finite displacement and rotation. Members are then divided into their
            ``segments``, and `method` must be None.
        steps
            For `large`, number of equal steps in which loads, offsets and prescribed displacements are applied.

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
        switch(clearance, "clearance in solve")
        switch(large, "large in solve")
        if not large and steps != 1:
            raise FrameError(f"solve was given steps={steps!r}, which a linear solution has not: add large=True")
        if large:
            return by_planes.solved(self, method, clearance, steps)
        return solution.Solution.of(self, method, clearance=clearance)

    def path(self, node: str, component: str, to: float, *, steps: int = 200, first: float = 0.05) -> EquilibriumPath:
        """Equilibrium path at large displacement, from the unloaded frame past limit points, by the arc-length method.

        Parameters
        ----------
        node, component
            Node and displacement component at which the path ends, such as ``"C"`` and ``"uy"``.
        to
            Value of that displacement at the end of the path, length or radians.
        steps
            Largest number of points.
        first
            Load factor of the first step; the length of later steps is adapted to the number of iterations.

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
        return path.follow(self, node, component, to, steps, first)

    def modes(self, count: int) -> Modes:
        """The lowest natural frequencies and mode shapes of the frame, its joints without clearance.

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
            If `count` is out of range, the frame has no mass, or it has fewer modes with mass than `count`.

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
        return modes.modes(self, count)

    def buckling(self, count: int) -> Buckling:
        """The lowest load factors at which the loaded frame buckles, its joints without clearance.

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
            If `count` is out of range, or the frame is a mechanism even without loads. Where only some entries of a
            batch are, their factors are NaN and a `MechanismWarning` says so.

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
        return buckling.buckling(self, count)

    @property
    def mesh(self) -> Any:
        """The first batch entry as a scikit-fem ``MeshLine1`` with 3-D points, members divided into their segments.

        Its subdomains are ``beam``, ``joint`` and, if there are any, ``rigid``; each member and joint by its name; and
        each body with the members on it. Its boundaries are the supported nodes. A basis on it needs the mapping
        `linkframe.elements.ArcLengthMapping`: scikit-fem's own is wrong for lines in space.
        """
        return self._numbered.mesh

    @property
    def dofs(self) -> Any:
        """Numbering of `mesh`, a scikit-fem ``Dofs``: ``ux uy uz rx ry rz`` by node, nodes in order of description."""
        return self._numbered.numbering

    def basis(self, on: str | Sequence[str] = "beam", *, intorder: int = 6) -> Any:
        """A scikit-fem ``Basis`` over members of one kind, on `mesh` and numbered as `dofs`.

        Its fields are displacements in the members' local axes, interpolated by their shape functions: ``u[0]`` to
        ``u[5]`` for ``ux uy uz rx ry rz``, and ``u.grad`` for the derivative along the member. The degrees of freedom
        are displacements of the nodes in global axes.

        Parameters
        ----------
        on
            A member, a body (all members on it), ``"beam"`` for all members, or several of these.
        intorder
            Order of the quadrature; 6 is exact for the product of two displacements of a prismatic beam.

        Returns
        -------
        skfem.Basis
            The basis at the first batch entry.

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
        return basis.frame_basis(self, on, intorder)

    @property
    def _numbered(self) -> Topology:
        return topology.Topology.of(self.copy(), cut=True)

    def matrices(self, entry: int | Sequence[int] = ()) -> FrameMatrices:
        """Stiffness, mass, geometric stiffness and loads at one batch entry, sparse, in scikit-fem's numbering.

        Parameters
        ----------
        entry
            Indices of the batch entry, one for each batch axis.

        Returns
        -------
        FrameMatrices
            Stiffness ``K``, mass ``M`` and loads ``f`` over all displacements; numbers ``D`` and values ``x`` of the
            supported ones; ``T`` and ``g`` of all constraints; geometric stiffness ``Kg``, computed when first read.

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
        return matrices.frame_matrices(self, entry)

    def explain(self, method: str | None = None, *, clearance: bool = True) -> str:
        """Report in words of what a linear solution computes, at which batch shapes, and what it skips and why.

        For large displacement: ``frame.solve(large=True).explain()``. The explanation of a solution that is there,
        ``solution.explain()``, is of how that was computed.

        Parameters
        ----------
        method, clearance
            As for `solve`.

        Returns
        -------
        str
            Lines of text: batch shapes, the method and why it was chosen, what is eliminated in which order.

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
        return self.solve(method, clearance=clearance).explain()
