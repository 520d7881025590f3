"""Joints that a user writes: a law of their own is followed or refused, and so is what their methods return."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
import pytest
from linkframe.elements import Beam, Joint, Material, Rectangle
from linkframe.framework import Frame, FrameError
from linkframe.framework.joint_protocol import JointElement
from numpy.testing import assert_allclose
from numpy.typing import NDArray
from reference.own_elements import RewrittenJoint

Array = NDArray[Any]
BEAM = Beam(Rectangle(y=0.1, z=0.1), Material(E=200e9, nu=0.3))
SOFT, CUBIC, SIDE = 1e4, 1e10, 1e9


class Bushing(Joint):
    """Rubber across the axis: ``k y + c y^3`` along y."""

    cubic: Array

    def __init__(self, cubic: Any = CUBIC, soft: Any = SOFT, **given: Any) -> None:
        stiffness = np.full((*np.shape(soft), 6), 1e9)
        stiffness[..., 1] = soft
        super().__init__(stiffness, **given)
        object.__setattr__(self, "cubic", np.asarray(cubic, dtype=np.float64))

    @property
    def shape(self) -> tuple[int, ...]:
        return np.broadcast_shapes(super().shape, self.cubic.shape)

    def resistance(self, displacement: Array, pick: Any) -> tuple[Array, Array, Array]:
        k, cubic = pick(self.stiffness, 1), pick(self.cubic, 0)
        y = displacement[:, 1]
        energy = 0.5 * np.sum(k * displacement**2, axis=-1) + 0.25 * cubic * y**4
        force = k * displacement
        force[:, 1] += cubic * y**3
        tangent = (k + 0.0 * displacement)[:, :, None] * np.eye(6)
        tangent[:, 1, 1] += 3.0 * cubic * y**2
        return energy, force, tangent


class Wedge(Bushing):
    """A bushing that is pushed along z, too, by what moves it along y."""

    def resistance(self, displacement: Array, pick: Any) -> tuple[Array, Array, Array]:
        energy, force, tangent = super().resistance(displacement, pick)
        y, z = displacement[:, 1], displacement[:, 2]
        force[:, 1] += 2.0 * SIDE * y * z
        force[:, 2] += SIDE * y**2
        tangent[:, 1, 1] += 2.0 * SIDE * z
        tangent[:, 1, 2] += 2.0 * SIDE * y
        tangent[:, 2, 1] += 2.0 * SIDE * y
        return energy + SIDE * y**2 * z, force, tangent


def _stub(joint: JointElement, force: Any = 100.0) -> Frame:
    """A beam that only the joint holds, pushed along y at the joint."""
    frame = Frame()
    for name, x in {"A": 0.0, "B": 0.0, "C": 1.0}.items():
        frame.node(name, (x, 0.0, 0.0))
    frame.add("rubber", joint, "A", "B")
    frame.add("BC", BEAM, "B", "C")
    frame.fix("A")
    frame.load("B", fy=force)
    return frame


@dataclass(frozen=True, eq=False)
class Hardening(Joint):
    """A hinge about z that hardens, ``k t + c t^3``: a dataclass as the elements of one's own are."""

    cubic: Any = 0.0

    def resistance(self, displacement: Array, pick: Any) -> tuple[Array, Array, Array]:
        energy, force, tangent = super().resistance(displacement, pick)
        t, cubic = displacement[:, 5], pick(np.asarray(self.cubic), 0)
        force[:, 5] += cubic * t**3
        tangent[:, 5, 5] += 3.0 * cubic * t**2
        return energy + 0.25 * cubic * t**4, force, tangent


class HardeningBatch(Hardening):
    @property
    def shape(self) -> tuple[int, ...]:
        return np.broadcast_shapes(super().shape, np.shape(self.cubic))


def _root(force: Array, cubic: Array | float = CUBIC) -> Array:
    """Displacement at which ``k y + c y^3`` balances a force, by bisection."""
    low, high = np.zeros_like(force * cubic), np.asarray(force * np.ones_like(cubic) / SOFT)
    for _ in range(80):
        middle = 0.5 * (low + high)
        more = SOFT * middle + cubic * middle**3 < force
        low, high = np.where(more, middle, low), np.where(more, high, middle)
    return np.asarray(0.5 * (low + high))


def test_a_joint_of_its_own_law_may_be_a_dataclass() -> None:
    """A stiff arm on a hardening hinge turns until ``k t + c t^3`` balances the moment of the load on its end."""
    cubic, frame = np.array([0.0, 100.0, 1000.0]), Frame()
    for name, x in {"A": 0.0, "B": 0.0, "C": 1.0}.items():
        frame.node(name, (x, 0.0, 0.0))
    frame.add("hinge", HardeningBatch((np.inf,) * 5 + (50.0,), cubic=cubic), "A", "B")
    frame.add("arm", Beam(Rectangle(y=0.1, z=0.1), Material(E=200e12, nu=0.3)), "B", "C")
    frame.fix("A")
    frame.load("C", fy=30.0)
    turn = frame.solve(large=True).joint_displacement("hinge")[:, 5]
    assert_allclose(50.0 * turn + cubic * turn**3, 30.0 * np.cos(turn), rtol=1e-6)
    assert np.ptp(turn) > 0.2
    assert_allclose(frame.solve().joint_displacement("hinge")[:, 5], 0.6, rtol=1e-9)


@dataclass(frozen=True, eq=False)
class Rated(Joint):
    """A joint with a number of its own, whose shape is kept once it is known."""

    rating: Array = field(default_factory=lambda: np.ones(3), kw_only=True)

    @cached_property
    def shape(self) -> tuple[int, ...]:
        return np.broadcast_shapes(self.stiffness.shape[:-1], self.rating.shape)


def test_a_joint_may_keep_a_shape_of_its_own() -> None:
    """The joint itself writes none where Python would look for that first."""
    assert Rated(np.full(6, 1e8)).shape == (3,)


def test_a_joint_is_replaced_like_any_dataclass() -> None:
    loose = Joint((1e9,) * 5 + (0.0,), clearance=1e-3, pitch=0.2)
    other = replace(loose, clearance=[1e-3, 2e-3])
    assert (other.clearance_directions, other.shape, float(other.pitch)) == ((0, 1), (2,), 0.2)
    assert replace(Hardening((1.0,) * 6, cubic=2.0), cubic=3.0).cubic == 3.0
    assert Hardening((1.0,) * 6, None, 2.0).cubic == 2.0
    assert Hardening((1.0,) * 5 + (0.0,), clearance=1e-3).clearance_directions == (0, 1)
    tight = Joint((1e9,) * 5 + (0.0,))
    assert replace(tight, pitch=0.1).clearance_directions == ()
    with pytest.raises(FrameError, match=r"clearance, but in no direction; name components, .* or None"):
        replace(tight, clearance=1e-3)
    assert replace(tight, clearance=1e-3, clearance_directions=None).clearance_directions == (0, 1)


@pytest.mark.parametrize("names", [np.array(["ux", "uy"]), np.array(["uy"]), (1, 0), np.array([1, 0])])
def test_names_and_numbers_of_directions_may_be_arrays(names: Any) -> None:
    assert Joint((1e9,) * 6, clearance_directions=names).clearance_directions == (0, 1)[-len(names) :]


@pytest.mark.parametrize("name", [6, -1, 1.5, "x"])
def test_a_direction_that_is_none_is_named(name: Any) -> None:
    with pytest.raises(FrameError, match=f"component {name!r} is unknown"):
        Joint((1e9,) * 6, clearance_directions=(name,))


def test_a_parameter_beyond_the_shape_of_a_joint_is_named() -> None:
    frame = Frame()
    for name in "AB":
        frame.node(name, (0.0, 0.0, 0.0))
    with pytest.raises(
        FrameError, match=r"joint 'hinge'.*: resistance takes .* batch shape \(2,\), and its shape is \(\)"
    ):
        frame.add("hinge", Hardening((1.0,) * 6, cubic=np.ones(2)), "A", "B")


@pytest.mark.parametrize("steps", [1, 3])
def test_a_law_is_followed_without_clearance(steps: int) -> None:
    force = np.array([1.0, 100.0, 1000.0])
    solution = _stub(Bushing(), force).solve(large=True, steps=steps)
    assert solution.status.tolist() == ["stable"] * 3
    assert_allclose(solution.displacement("B")[:, 1], _root(force), rtol=1e-9)
    assert_allclose(solution.joint_force("rubber")[:, 1], force, rtol=1e-9)


def test_a_law_is_followed_whether_clearances_are_left_out_or_not() -> None:
    for clearance in (True, False):
        moved = _stub(Bushing()).solve(large=True, clearance=clearance).displacement("B")[1]
        assert_allclose(moved, 0.002, rtol=1e-9)


def test_a_law_of_a_batch() -> None:
    cubic = np.geomspace(1e8, 1e12, 7)
    found = _stub(Bushing(cubic), np.array(100.0)).solve(large=True).displacement("B")[:, 1]
    assert_allclose(found, _root(np.array(100.0), cubic), rtol=1e-9)


def test_a_law_beside_joints_with_clearance() -> None:
    """Below the bushing a journal is thrown across its play first."""
    frame = _stub(Bushing())
    frame.node("D", (1.0, 0.0, 0.0))
    frame.add("loose", Joint((1e9, 1e9, 1e9, 1e9, 1e9, 1e9), clearance=1e-3, clearance_directions="uz"), "C", "D")
    frame.load("D", fz=1e-3)
    solution = frame.solve(large=True)
    assert_allclose(solution.displacement("B")[1], 0.002, rtol=1e-6)
    assert_allclose(solution.joint_displacement("loose")[2], 1e-3, rtol=1e-6)


def test_a_law_that_pushes_across_a_plane_leaves_it() -> None:
    solution = _stub(Wedge()).solve(large=True)
    y, z = solution.displacement("B")[[1, 2]]
    assert_allclose(SOFT * y + CUBIC * y**3 + 2.0 * SIDE * y * z, 100.0, rtol=1e-6)
    assert_allclose(z, -SIDE * y**2 / 1e9, rtol=1e-6)
    assert z < -1e-6


def test_linear_solutions_take_the_stiffness_at_rest_and_tell_where_it_does_not_hold() -> None:
    solution = _stub(Bushing(), np.array([1e-3, 100.0])).solve()
    assert_allclose(solution.displacement("B")[:, 1], [1e-7, 1e-2], rtol=1e-12)
    assert solution.linear.tolist() == [True, False]
    assert_allclose(solution.nonlinearity()[1], CUBIC * 1e-2**2 / SOFT, rtol=1e-6)
    assert_allclose(_stub(Joint(Bushing().stiffness)).solve().nonlinearity(), 0.0, atol=1e-6)


def test_a_law_that_linear_solutions_cannot_follow_is_refused() -> None:
    class Stiff(Bushing):
        def resistance(self, displacement: Array, pick: Any) -> tuple[Array, Array, Array]:
            return tuple(2.0 * part for part in super().resistance(displacement, pick))  # type: ignore[return-value]

    for ask in (lambda f: f.solve(), lambda f: f.modes(1), lambda f: f.buckling(1)):
        with pytest.raises(FrameError, match="joint 'rubber': Stiff has a law of its own, resistance, that is not its"):
            ask(_stub(Stiff()))
    with pytest.raises(FrameError, match=r"Bushing has a law of its own, resistance, and clearance"):
        _stub(Bushing(clearance=1e-3, clearance_directions="uy")).solve()
    with pytest.raises(FrameError, match="joint 'rubber' has a law of its own, which contains its clearance"):
        _stub(Bushing(clearance=1e-3, clearance_directions="uy")).solve(large=True, clearance=False)
    assert_allclose(_stub(Stiff()).solve(large=True).joint_force("rubber")[1], 100.0, rtol=1e-9)


@pytest.mark.parametrize(
    ("name", "value", "told"),
    [
        ("stiffness", np.ones(5), r"stiffness has shape \(5,\): give \(..., 6\)"),
        ("stiffness", [1.0] * 6, "give an array of floats"),
        ("stiffness", -np.ones(6), "stiffness is -1"),
        ("stiffness", np.full(6, np.nan), "stiffness contains nan"),
        ("stiffness", np.ones((4, 6)), r"within its shape \(\)"),
        ("axes", 2.0 * np.eye(3), "axes are not right-handed and orthonormal"),
        ("clearance", np.array(-1.0), "clearance is -1"),
        ("clearance", np.array(1.0), "clearance is given and clearance_directions are empty"),
        ("clearance_directions", (0, 4), "clearance_directions are"),
        ("clearance_directions", (0, 1), "free or of unequal stiffness"),
        ("pitch", np.array(np.inf), "pitch contains nan or inf"),
    ],
)
def test_what_a_joint_holds_is_examined(name: str, value: Any, told: str) -> None:
    joint = RewrittenJoint(Joint((1.0, 2.0, 3.0, 1.0, 1.0, 1.0)))
    setattr(joint, name, value)
    with pytest.raises(FrameError, match=rf"RewrittenJoint of joint 'rubber': .*{told}"):
        _stub(joint)


def test_what_a_joint_lacks_is_named() -> None:
    joint = RewrittenJoint(Joint((1.0,) * 6))
    del joint.pitch
    with pytest.raises(FrameError, match="RewrittenJoint of joint 'rubber' has no pitch"):
        _stub(joint)


def test_what_a_joint_returns_is_examined() -> None:
    class Coupled(Joint):
        def matrix(self) -> Array:
            return super().matrix() + np.kron([[1.0, -1.0], [-1.0, 1.0]], np.eye(6)[::-1])

    class Free(Joint):
        def typical(self) -> Joint:
            return Joint((0.0,) * 6)

    class Flat(Bushing):
        def resistance(self, displacement: Array, pick: Any) -> tuple[Array, Array, Array]:
            energy, force, tangent = super().resistance(displacement, pick)
            return energy, force, tangent[0]

    springs = (1.0, 2.0, 3.0, 1.0, 1.0, 1.0)
    with pytest.raises(FrameError, match="Coupled of joint 'rubber': matrix is not what its stiffness"):
        _stub(Coupled(springs))
    with pytest.raises(FrameError, match="Free of joint 'rubber': typical returned"):
        _stub(Free(springs))
    with pytest.raises(FrameError, match="Flat of joint 'rubber': resistance returned shapes"):
        _stub(Flat())
