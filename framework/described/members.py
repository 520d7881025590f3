"""Members, joints, masses and scikit-fem forms of a description."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..added_forms import AddedForm, FormLoad
from ..batch import Array, aligned, all_of, any_of, distinct, finite, norms
from ..errors import FrameError
from ..examination import examine_mass, examine_member
from ..formed import FormedElement
from ..joint_examination import examine_joint
from ..joint_protocol import JointElement
from ..names import found, new, plain
from ..protocol import LineElement, PointElement, is_proven
from .nodes import DescribedNodes
from .parts import JointLink, MassPoint, Member, check_ideal

# Two nodes of a joint coincide when their distance is below this share of the frame's size.
COINCIDENT = 1e-9
# Lengths of members between which the powers of them that a stiffness has are within the range of floats.
SHORTEST, LONGEST = 1e-100, 1e100

# Rounded up.
SQUARE_ROOT_OF_3 = 1.7320508075688776

# The name that stands for all members.
_ALL = "beam"


class DescribedMembers(DescribedNodes):
    """The part of a description that takes members, joints, masses and scikit-fem forms."""

    def add(self, name: str, element: LineElement | JointElement | PointElement, *nodes: str) -> None:
        """Add a beam between two nodes, a joint between two coincident nodes, or a mass at one node.

        Parameters
        ----------
        name
            Name of the member, joint or mass.
        element
            A `linkframe.elements.Beam`, `Joint`, `Spring` or `PointMass`, or an element of your own, whose matrices and
            shape functions are then checked; its parameters may carry a batch.
        *nodes
            Names of its nodes, start (first) before end (second).

        Raises
        ------
        FrameError
            If the name is taken, a node is unknown or named twice, a member has no length, a joint's nodes do not
            coincide, or an element of one's own does not return what the protocol asks.

        Examples
        --------
        Two rods with a hinge about z between them, and a flywheel.

        >>> from linkframe.elements import Beam, Circle, Joint, Material, PointMass
        >>> from linkframe.framework import Frame
        >>> rod = Beam(Circle(diameter=0.02), Material(E=200e9, nu=0.3))
        >>> frame = Frame()
        >>> for name, x in {"A": 0.0, "B": 1.0, "C": 1.0, "D": 2.0}.items():
        ...     frame.node(name, (x, 0.0, 0.0))
        >>> frame.add("AB", rod, "A", "B"); frame.add("CD", rod, "C", "D")
        >>> frame.add("hinge", Joint(stiffness=(1e9, 1e9, 1e9, 1e6, 1e6, 0.0)), "B", "C")
        >>> frame.add("flywheel", PointMass(2.0, inertia=(0.1, 0.1, 0.2)), "D")
        >>> sorted(frame.members), sorted(frame.joints), sorted(frame.masses)
        (['AB', 'CD'], ['hinge'], ['flywheel'])
        """
        name = new("element", name, self.members, self.joints, self.masses)
        if not isinstance(element, (LineElement, JointElement, PointElement)):
            raise FrameError(f"element {name!r} is {element!r}: give a beam, a joint or a mass, such as Beam(...)")
        wanted = 1 if isinstance(element, PointElement) else 2
        if len(nodes) != wanted:
            kind = type(element).__name__
            raise FrameError(f"{name!r} was given {len(nodes)} nodes {nodes}: a {kind} takes {wanted}")
        nodes = self._nodes(nodes, f"{name!r}")
        if wanted == 2 and nodes[0] == nodes[1]:
            raise FrameError(f"{name!r} begins and ends at node {nodes[0]!r}: give two different nodes")
        kinds: dict[Hashable, str] = {}
        parts: dict[str, Any]
        part: Any
        if isinstance(element, LineElement):
            element.check(self._check_length(name, *nodes))
            kinds = self._examine(name, element, nodes)
            sort, parts, part = "member", self.members, Member(element, *nodes)
        elif isinstance(element, JointElement):
            self._check_coincident(name, *nodes)
            if not is_proven(element):
                examine_joint(name, element)
            check_ideal(f"joint {name!r}", element.stiffness)
            sort, parts, part = "joint", self.joints, JointLink(element, *nodes)
        else:
            if not is_proven(element):
                examine_mass(name, element)
            sort, parts, part = "mass", self.masses, MassPoint(element, *nodes)
        if shape := element.shape:
            self._join({f"{sort} {name!r}": shape})
        parts[name] = part
        self._examined |= kinds

    def add_form(
        self,
        form: object,
        on: str | Sequence[str],
        *,
        into: str | None = None,
        intorder: int | None = None,
        **parameters: ArrayLike,
    ) -> None:
        """Add a scikit-fem form to members: an elastic foundation, an added mass, a strain by heat, a load.

        The form is integrated over the shape functions of each member. It sees the displacement in the member's own
        axes, ``u[0]`` to ``u[5]`` for ``ux uy uz rx ry rz``, its derivative along the member, ``u.grad[0]`` to
        ``u.grad[5]``, and in ``w`` the parameters, the distance ``w.x[0]`` from the member's start and the length
        ``w.h`` of its segment. It applies to the members that exist when it is added, and takes part in statics, modes,
        buckling, error bounds and sensitivity; in large displacement only if a rigid motion costs it no energy.

        Parameters
        ----------
        form
            ``skfem.BilinearForm``, symmetric and positive semidefinite at each point, or ``skfem.LinearForm``.
        on
            A member, a body or a link (all members on it), ``"beam"`` for all members, or several of these.
        into
            Matrix to which the form is added: ``stiffness`` (the default for a bilinear form) or ``mass``; ``load`` for
            a linear form. Gravity does not act on such a mass.
        intorder
            Order of the quadrature along each segment, as in scikit-fem; None takes that of the member's own matrices.
        **parameters
            Parameters that the form reads from ``w``, each a number or a batch of numbers, (...).

        Raises
        ------
        FrameError
            If `on` names nothing, if the form fails, is not symmetric or not positive semidefinite, or if a parameter
            is no finite number or does not fit the batch.

        Examples
        --------
        A beam on an elastic foundation, pushed down evenly: it sinks by the load over the modulus.

        >>> import skfem
        >>> from linkframe.elements import Beam, Material, Rectangle
        >>> from linkframe.framework import Frame
        >>> frame = Frame()
        >>> for name, x in {"A": 0.0, "B": 2.0}.items():
        ...     frame.node(name, (x, 0.0, 0.0))
        >>> frame.add("AB", Beam(Rectangle(y=0.02, z=0.01), Material(E=200e9, nu=0.3)), "A", "B")
        >>> frame.fix("A", "ux", "uz", "rx", "ry")
        >>> foundation = skfem.BilinearForm(lambda u, v, w: w.k * u[1] * v[1])
        >>> frame.add_form(foundation, on="AB", k=[1e4, 2e4])
        >>> frame.line_load("AB", fy=-30.0)
        >>> frame.solve().displacement("B")[:, 1].round(9)
        array([-0.003 , -0.0015])
        """
        names = self.members_on(on, "add_form")
        lengths = {name: self.length(name) for name in names}
        values = {name: finite(value, f"add_form: parameter {name}") for name, value in parameters.items()}
        ndim = max(each.ndim for each in (*lengths.values(), *values.values()))
        stacked = np.stack(np.broadcast_arrays(*(aligned(length, ndim) for length in lengths.values())))
        widened = self._widened({f"parameter {name} of a form": value.shape for name, value in values.items()})
        added = AddedForm.of(form, into, stacked, values, intorder)
        apart = added.placed and added.strains
        members = [self.members[name] for name in names]
        leaders, which = distinct([member.element for member in members])
        if apart:
            leaders, which = list(range(len(names))), np.arange(len(names))
        made: list[LineElement] = []
        examined: set[object] = set()
        for k in leaders:
            member = members[k]
            made.append(FormedElement.of(member.element, added, lengths[names[k]] if apart else None))
            # a form that suits one proven element suits all elements of its class
            kind = type(member.element) if is_proven(member.element) else k
            if made[-1] is not member.element and kind not in examined:
                examine_member(names[k], made[-1], self._chord(member.start, member.end))
                examined.add(kind)
        self.shape, self._shapes = widened
        for name, member, number in zip(names, members, which.tolist(), strict=True):
            self.members[name] = member._replace(element=made[number])
            if added.pushes:
                self.member_loads.setdefault(name, []).append(FormLoad(added))

    def members_on(self, on: str | Sequence[str], what: str = "members_on") -> list[str]:
        """List the members that the given names of members and bodies refer to, each once.

        Parameters
        ----------
        on
            Name of a member, of a body (all members on it), ``"beam"`` for all members, or several of these.
        what
            Name of the caller, for error messages.

        Returns
        -------
        list of str
            Names of the members.

        Raises
        ------
        FrameError
            If a name is unknown, or a body has no members on it.
        """
        chosen: dict[str, None] = {}
        for each in [on] if isinstance(on, str) else on:
            name = plain(f"{what}: on", each)
            if name in self.members:
                chosen[name] = None
                continue
            if name != _ALL:
                found(f"{what}: on", name, [*self.members, *self.bodies, _ALL])
            for key, member in self.members.items():
                if name == _ALL or self.nodes[member.start].body == name == self.nodes[member.end].body:
                    chosen[key] = None
        if not chosen:
            raise FrameError(f"{what}: there is no member on {on!r}: add members first")
        return list(chosen)

    # -- checks -----------------------------------------------------------------------------------------------------

    def _examine(self, name: str, element: LineElement, nodes: tuple[str, ...]) -> dict[Hashable, str]:
        """Check an element that is not marked as proven, once for each kind; the kind with the member's name if it was
        checked now, else nothing.
        """
        if is_proven(element):
            return {}
        kind = type(element), element.kind
        try:
            known = kind in self._examined
        except TypeError:  # the kind cannot be hashed, which the check below refuses
            known = False
        if not known:
            examine_member(name, element, self._chord(nodes[0], nodes[1]))
        return {} if known else {kind: name}

    def _check_length(self, name: str, start: str, end: str) -> Array:
        """Vector from the start of a member to its end, (..., 3).

        Raises
        ------
        FrameError
            Where it has zero length, or one whose powers are beyond the range of floats.
        """
        chord = self._chord(start, end)
        if chord.size == 3 and SHORTEST < max(map(abs, chord.reshape(-1).tolist())) < LONGEST:
            return chord
        # most are long along one of the first axes, and none is longer than the frame is large
        if self.size < LONGEST / 4.0 and any(all_of(np.abs(chord[..., k]) > SHORTEST) for k in (0, 1)):
            return chord
        length = np.abs(chord).max(axis=-1)
        wrong = ~((length > SHORTEST) & (length < LONGEST))
        if np.any(wrong):
            where = f" at batch entry {np.argwhere(wrong)[0].tolist()}" if length.ndim else ""
            worst = float(length[wrong][0])
            if worst == 0.0:
                raise FrameError(f"member {name!r} has zero length{where}: nodes {start!r} and {end!r} coincide")
            raise FrameError(
                f"member {name!r} is {worst:.3g} long{where}: describe the frame in a unit in which its lengths lie "
                f"between {SHORTEST:g} and {LONGEST:g}"
            )
        return chord

    def _check_coincident(self, name: str, first: str, second: str) -> None:
        apart = self._chord(first, second)
        if not any_of(apart):
            return
        limit = max(COINCIDENT * self.size, self.tolerance)
        # no distance is longer than the components allow, which is told in a third of the time
        if self.absent is None and SQUARE_ROOT_OF_3 * float(np.abs(apart).max(initial=0.0)) <= limit:
            return
        gaps = norms(apart)
        # Entries that are left out need no coincident nodes.
        gap = float(np.max(gaps if self.absent is None else np.where(self.absent, 0.0, gaps), initial=0.0))
        if gap > limit:
            raise FrameError(
                f"joint {name!r} joins nodes {first!r} and {second!r}, which are {gap:.6g} apart: "
                "place them at one point, or put a rigid link or a beam between them"
            )
