"""Built-in elements written anew by a user give the same results everywhere; wrong answers are refused by name."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from linkframe.elements import Beam, Circle, Joint, Material, PointMass, Rectangle, Spring
from linkframe.framework import Frame, FrameError
from linkframe.framework.protocol import LineElement
from numpy.testing import assert_allclose, assert_array_equal
from numpy.typing import NDArray
from reference.as_frame import as_frame
from reference.own_elements import (
    POINTS,
    WEIGHTS,
    Delegating,
    Rewritten,
    RewrittenJoint,
    RewrittenMass,
    Winkler,
    rebuilt,
)
from reference.random_structures import random_constrained, random_frame, random_linkage

Array = NDArray[Any]
STEEL, BAR = Material(E=200e9, nu=0.3, density=7850.0), Rectangle(y=0.02, z=0.01)
BEAM = Beam(BAR, STEEL)
COMMON = np.array([0.6, 1.0, 1.7])


# -- the same as the built-in ones ----------------------------------------------------------------------------------


def _read(frame: Frame) -> dict[str, Array]:
    """All linear results of a frame."""
    solution = frame.solve()
    out = {f"displacement {node}": solution.displacement(node) for node in frame.nodes}
    out |= {f"reaction {node}": solution.reaction(node) for node in frame.supports}
    for name in frame.members:
        stations = frame.length(name)[..., None] * np.array([0.0, 0.3, 1.0])
        out[f"ends {name}"] = solution.end_forces(name)
        out[f"forces {name}"] = solution.forces(name, stations)
        out[f"along {name}"] = solution.displacement_along(name, stations)
        out[f"end bound {name}"] = solution.error_bound(name, "end_forces")
    for name in frame.joints:
        out[f"joint {name}"] = solution.joint_displacement(name)
        out[f"force {name}"] = solution.joint_force(name)
    first = next(iter(frame.loads))
    found = solution.sensitivity(first, "uy")
    for kind in ("loads", "joints", "offsets", "supports"):
        out |= {f"sensitivity {kind} {name}": value for name, value in getattr(found, kind).items()}
    out["bound"], out["refined"] = solution.error_bound(first), solution.refined(first)[0]
    out["nonlinearity"] = solution.nonlinearity()
    out["condition"] = solution.scaled_condition_number()
    return out


def _loaded(seed: int) -> Frame:
    """A random frame or linkage, with weight, loads on members and a mass, in a batch of three moduli or none."""
    rng = np.random.default_rng(seed)
    structure = (random_frame, random_constrained, random_linkage)[seed % 3](seed)
    frame = as_frame(structure)
    batch = COMMON if seed % 2 else np.ones(())
    for name, member in frame.members.items():
        assert isinstance(member.element, Beam)
        material = Material(E=batch * member.element.material.E, G=member.element.material.G, density=7850.0)
        frame.members[name] = member._replace(element=replace(member.element, material=material))
    if seed % 2:
        frame.load(next(iter(frame.loads)), fx=np.array([1.0, 2.0, 3.0]))
    name = next(iter(frame.members))
    frame.line_load(name, fy=(10.0, float(rng.normal())))
    frame.gravity((0.0, 1.0, -9.81))
    frame.add("mass", PointMass(2.0), next(iter(frame.nodes)))
    return frame


@given(st.integers(0, 10**6))
@settings(max_examples=4)
def test_an_element_written_anew_gives_the_same_bits(seed: int) -> None:
    """Where those of a family are not evaluated together, which sums the same numbers in another order."""
    frame = _loaded(seed)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Beam, "family", None)
        wanted, found = _read(frame), _read(rebuilt(frame, halved=-1))
    assert wanted.keys() == found.keys()
    for key, value in wanted.items():
        assert_array_equal(found[key], value, err_msg=key)


@given(st.integers(0, 10**6))
@settings(max_examples=3)
def test_springs_in_any_order_and_number(seed: int) -> None:
    """Six springs in the other order, two of them as halves: the same but for rounding, which the bounds know."""
    frame = _loaded(seed)
    one, other = frame.solve(), rebuilt(frame).solve()
    for kind, names in (("displacement", frame.nodes), ("end_forces", frame.members), ("joint_force", frame.joints)):
        for name in names:
            apart = np.abs(getattr(one, kind)(name) - getattr(other, kind)(name))
            assert (apart <= one.error_bound(name, kind) + other.error_bound(name, kind)).all(), (kind, name)
            size = np.abs(getattr(one, kind)(name)).max()
            assert (other.error_bound(name, kind) <= 4.0 * one.error_bound(name, kind) + 1e-14 * size).all()
    first = next(iter(frame.loads))
    built_in, own = (each.sensitivity(first, "uy").members for each in (one, other))
    for name, six in built_in.items():
        whole = own[name][..., [5, 4, 3, 2, 1, 0]]
        whole[..., :2] += own[name][..., 6:]
        assert_allclose(whole, six, rtol=1e-8, atol=1e-11 * np.abs(six).max())


def _portal(beam: LineElement, joint: Joint | RewrittenJoint) -> Frame:
    frame = Frame()
    for name, place in {"A": (0, 0, 0), "B": (0, 1, 0), "C": (0, 1, 0), "D": (1, 1, 0), "E": (1, 0, 0)}.items():
        frame.node(name, place)
    frame.add("AB", beam, "A", "B")
    frame.add("pin", joint, "B", "C")
    frame.add("CD", beam, "C", "D")
    frame.add("DE", beam, "D", "E")
    frame.fix("A")
    frame.fix("E")
    frame.load("B", fx=[100.0, 4000.0], fy=-500.0)
    return frame


def test_modes_buckling_large_displacement_and_contact() -> None:
    beam = Beam(BAR, STEEL, segments=2)
    for joint in (
        Joint((1e7, 1e7, 1e7, 1e5, 1e5, 10.0), clearance=1e-3),
        Joint((np.inf,) * 5 + (0.0,), clearance=1e-3),
    ):
        frames = _portal(beam, joint), _portal(Rewritten(beam), RewrittenJoint(joint))
        modes, factors, shapes, moved, force = zip(
            *(
                (
                    frame.modes(4).frequencies,
                    frame.buckling(2).factors,
                    frame.solve(large=True).displacement_along("CD", [0.3]),
                    frame.solve().displacement("D"),
                    frame.solve(large=True).joint_force("pin"),
                )
                for frame in frames
            ),
            strict=True,
        )
        for one, other in (modes, factors, shapes, moved, force):
            assert_allclose(other, one, rtol=1e-8, atol=1e-9 * np.abs(one).max())


@pytest.mark.parametrize("method", ["broadcast", "banded", "sparse", "iterative"])
def test_large_frames(method: str) -> None:
    found = []
    for beam in (BEAM, Rewritten(BEAM)):
        frame = Frame()
        for k in range(20):
            frame.node(f"n{k}", (0.1 * k, 0.2 * (k % 2), 0.01 * k))
            if k:
                frame.add(f"m{k}", beam, f"n{k - 1}", f"n{k}")
        frame.fix("n0")
        frame.load("n19", fy=1.0, fz=2.0)
        frame.load("n13", fx=3.0)
        solution = frame.solve(method)
        found.append((solution.displacement("n12"), solution.error_bound("n12"), solution.end_forces("m7")))
    assert (np.abs(found[0][0] - found[1][0]) <= found[0][1] + found[1][1]).all()
    assert_allclose(found[1][2], found[0][2], rtol=1e-9, atol=1e-10)


def test_many_entries_of_bare_springs() -> None:
    """One spring of its own, of a shape that has no batch of the lengths, in a batch that is cut in chunks."""
    stiffness = np.linspace(1.0, 2.0, 6000)
    found = []
    for element in (Spring(stiffness), _String(stiffness)):
        frame = Frame()
        frame.node("A", (0.0, 0.0, 0.0))
        frame.node("B", (1.0, 0.0, 0.0))
        frame.add("AB", element, "A", "B")
        frame.fix("A")
        frame.fix("B", "uy", "uz", "rx", "ry", "rz")
        frame.load("B", fx=3.0)
        solution = frame.solve()
        found.append(solution.displacement("B"))
        assert (solution.error_bound("B")[:, 0] < 1e-13).all()
    assert_array_equal(found[1], found[0])
    assert_allclose(found[0][:, 0], 3.0 / stiffness, rtol=1e-14)


@dataclass(frozen=True, eq=False)
class _String(Delegating):
    """One spring k (..., 1), whatever the length."""

    stiffness: Array

    @property
    def inner(self) -> LineElement:  # type: ignore[override]
        return Spring(self.stiffness)

    def springs(self, length: Array) -> tuple[Array, Array]:
        row = np.zeros((1, 12))
        row[0, 0], row[0, 6] = -1.0, 1.0
        return self.stiffness[:, None], row


# -- what belongs together ------------------------------------------------------------------------------------------


class _Stiff(Beam):
    """A beam of double stiffness, which inherits the kind of the plain one."""

    def stiffness_matrix(self, length: Array | float) -> Array:
        return 2.0 * super().stiffness_matrix(length)

    def springs(self, length: Array | float) -> tuple[Array, Array]:
        k, rows = super().springs(length)
        return 2.0 * k, rows

    def end_forces(self, length: Array | float, displacement: Array) -> Array:
        return 2.0 * super().end_forces(length, displacement)


def test_a_subclass_is_not_of_the_kind_of_its_base() -> None:
    frame = Frame()
    for name, y in {"A": 0.0, "C": 1.0}.items():
        frame.node(name, (0.0, y, 0.0))
        frame.node(name + "1", (1.0, y, 0.0))
        frame.fix(name)
        frame.load(name + "1", fy=1.0)
    frame.add("plain", BEAM, "A", "A1")
    frame.add("stiff", _Stiff(BAR, STEEL), "C", "C1")
    solution = frame.solve()
    assert_allclose(solution.displacement("A1"), 2.0 * solution.displacement("C1"), rtol=1e-12)


class _OneKind(Winkler):
    """A kind that tells nothing apart."""

    @property
    def kind(self) -> Hashable:
        return "foundation"


def test_unlike_elements_of_one_kind_are_refused() -> None:
    frame = Frame()
    for k in range(3):
        frame.node(f"n{k}", (float(k), 0.0, 0.0))
    frame.add("first", _OneKind(BEAM, np.array(1e5)), "n0", "n1")
    frame.add("second", _OneKind(BEAM, np.array(2e5)), "n1", "n2")
    frame.load("n0", fy=1.0)
    with pytest.raises(FrameError, match=r"'second' and _OneKind of member 'first' are of equal kind and not the same"):
        frame.solve().displacement("n0")


def test_equal_elements_of_one_kind_are_not() -> None:
    frame = Frame()
    for k in range(3):
        frame.node(f"n{k}", (float(k), 0.0, 0.0))
        if k:
            frame.add(f"m{k}", _OneKind(Beam(BAR, STEEL), np.array(1e5)), f"n{k - 1}", f"n{k}")
    frame.fix("n0", "ux", "rx")
    frame.load("n0", fy=1.0)
    assert str(frame.solve().status) == "regular"


# -- wrong answers --------------------------------------------------------------------------------------------------


def _add(element: LineElement) -> Frame:
    frame = Frame()
    frame.node("A", (0.0, 0.0, 0.0))
    frame.node("B", (1.0, 0.5, 0.0))
    frame.add("AB", element, "A", "B")
    return frame


def _answering(**answers: Callable[..., Any]) -> LineElement:
    """A beam written anew, some of whose methods answer otherwise; each is given the element and its arguments."""
    kind: Any = type("Own", (Rewritten,), dict(answers))
    built: LineElement = kind(BEAM)
    return built


def _wrong(method: str, change: Callable[[Any], Any]) -> LineElement:
    def answer(self: Rewritten, *given: Any) -> Any:
        return change(getattr(Rewritten, method)(self, *given))

    return _answering(**{method: answer})


def _rounded(self: Rewritten, length: Array) -> tuple[Array, Array]:
    return Rewritten.springs(self, np.asarray(length, dtype=np.float64))


def _silent(self: Rewritten, *given: Any) -> Any:
    raise NotImplementedError


@pytest.mark.parametrize(
    ("element", "told"),
    [
        (_wrong("axes", lambda a: a[..., :2, :]), "axes returned shape .* give numbers of shape \\(..., 3, 3\\)"),
        (_wrong("axes", lambda a: 2.0 * a), "axes returned rows that are not"),
        (_wrong("axes", lambda a: a[..., [1, 2, 0], :]), "x axis that is not along the member"),
        (_wrong("axes", lambda a: a.astype(np.float64)), "axes are off by .* in extended precision"),
        (_wrong("springs", lambda s: s[0]), "give stiffnesses and deformations"),
        (_wrong("springs", lambda s: (s[0][..., :3], s[1])), "springs \\(stiffnesses\\) returned shape"),
        (_wrong("springs", lambda s: (s[0], s[1][..., :6])), "springs \\(deformations\\) returned shape"),
        (_wrong("springs", lambda s: (np.nan * s[0], s[1])), "springs \\(stiffnesses\\) returned nan: give finite"),
        (_wrong("springs", lambda s: (s[0][:, None] + np.zeros((5, 1)), s[1])), "batch axes .* do not broadcast"),
        (_wrong("springs", lambda s: (2.0 * s[0], s[1])), "stiffness_matrix is not the sum of its springs"),
        (_answering(springs=_rounded), "springs rounds its deformations"),
        (_wrong("stiffness_matrix", lambda k: k[..., :6, :6]), "stiffness_matrix returned shape"),
        (_wrong("end_forces", lambda f: -f), "end_forces is not its stiffness times the displacement"),
        (_wrong("mass_matrix", lambda m: m + np.eye(12, k=1)), "mass_matrix returned a matrix that is not symmetric"),
        (_wrong("geometric_matrix", lambda g: g + np.eye(12)), "geometric_matrix is not proportional"),
        (_wrong("shape_functions", lambda n: n[..., ::-1]), "shape_functions at the start do not give"),
        (_wrong("section_flexibility", lambda f: f[..., 0]), "section_flexibility returned shape"),
        (_wrong("mass_per_length", lambda m: "heavy"), "mass_per_length returned a str"),
        (_wrong("stress", lambda s: s[..., 0]), "stress returned shape"),
        (_answering(segments=property(lambda self: 0)), "segments is 0"),
        (_answering(quadrature=property(lambda self: 2.5)), "quadrature is 2.5"),
        (_answering(roundings=property(lambda self: -1.0)), "roundings is -1.0"),
        (_answering(kind=property(lambda self: [])), "kind is \\[\\], which cannot be hashed"),
        (_answering(releases=property(lambda self: ((2, 0),))), "releases is"),
        (_answering(shape=property(lambda self: 3)), "shape is 3"),
        (_answering(segments=property(lambda self: self.number)), "has no segments"),
        (_wrong("mass_per_length", lambda m: float("heavy")), "mass_per_length failed for arrays of shape .* 'heavy'"),
    ],
)
def test_wrong_answers_are_refused_where_the_element_is_added(element: LineElement, told: str) -> None:
    with pytest.raises(FrameError, match=rf"Own of member 'AB'.*{told}"):
        _add(element)


def test_a_method_left_out_is_missed_only_where_it_is_asked_for() -> None:
    frame = _add(_answering(mass_matrix=_silent, stress=_silent))
    frame.fix("A")
    frame.load("B", fy=1.0)
    wanted = _add(BEAM)
    wanted.fix("A")
    wanted.load("B", fy=1.0)
    assert_allclose(frame.solve().displacement("B"), wanted.solve().displacement("B"), rtol=1e-12)
    with pytest.raises(FrameError, match="Own of member 'AB' has no mass_matrix"):
        frame.modes(1)
    with pytest.raises(FrameError, match="Own of member 'AB' has no stress"):
        frame.solve().stress("AB", [0.5])


@dataclass(frozen=True, eq=False)
class _Listed(Delegating):
    """A batch of moduli hidden in a list."""

    moduli: list[float]

    @property
    def inner(self) -> LineElement:  # type: ignore[override]
        return Beam(BAR, Material(E=np.array(self.moduli), nu=0.3))


@dataclass(frozen=True, eq=False)
class _Sampled(Winkler):
    """Its Gauss points in fields of which nothing tells that they are no batch."""

    points: Array = field(default_factory=lambda: POINTS)
    weights: Array = field(default_factory=lambda: WEIGHTS)


@dataclass(frozen=True, eq=False)
class _Centred(Delegating):
    """Its torsion, the softest in a wire, by the mean modulus of the batch, of which a few entries know nothing."""

    inner: Beam
    stiffness_matrix = LineElement.stiffness_matrix
    end_forces = LineElement.end_forces

    def springs(self, length: Array) -> tuple[Array, Array]:
        k, rows = self.inner.springs(length)
        moduli = np.asarray(self.inner.material.E)
        return k * np.where(np.arange(6) == 3, moduli.mean() / moduli[..., None], 1.0), rows


@dataclass(frozen=True, eq=False)
class _Padded(Delegating):
    """With a spring without stiffness where there are many entries."""

    inner: Beam

    def springs(self, length: Array) -> tuple[Array, Array]:
        k, rows = self.inner.springs(length)
        more = int(np.size(self.inner.material.E) > 3)
        k = np.pad(k, [(0, 0)] * (k.ndim - 1) + [(0, more)])
        return k, np.pad(rows, [(0, 0)] * (rows.ndim - 2) + [(0, more), (0, 0)])


class _Undivided(Delegating):
    """No dataclass."""

    def __init__(self, inner: LineElement) -> None:
        self.inner = inner


@pytest.mark.parametrize(
    ("element", "told"),
    [
        (_Listed(np.linspace(1e11, 2e11, 6000).tolist()), "cut left shape \\(6000,\\)"),
        (_Sampled(BEAM, np.linspace(1e5, 2e5, 6000)), "Sampled of member 'AB'"),
        (_Sampled(BEAM, np.linspace(1e5, 2e5, 4)), "Sampled of member 'AB'"),
        (
            _Centred(Beam(Circle(diameter=5e-5), Material(E=np.linspace(1e11, 2e11, 4), nu=0.3))),
            "cut to a few .* \\(3, 3\\)",
        ),
        (_Padded(Beam(BAR, Material(E=np.linspace(1e11, 2e11, 6000), nu=0.3))), "cut to a few .* other springs"),
        (_Undivided(Beam(BAR, Material(E=np.linspace(1e11, 2e11, 6000), nu=0.3))), "holds a batch but is no dataclass"),
    ],
)
def test_a_batch_that_cannot_be_cut_is_refused(element: LineElement, told: str) -> None:
    with pytest.raises(FrameError, match=told):
        _add(element)


def test_no_cut_is_asked_of_what_does_not_vary() -> None:
    frame = Frame()
    frame.node("A", (0.0, 0.0, 0.0))
    length = np.linspace(1.0, 2.0, 6000)
    frame.node("B", np.stack([length, 0.0 * length, 0.0 * length], axis=-1))
    frame.add("AB", _Undivided(BEAM), "A", "B")
    frame.fix("A")
    frame.load("B", fy=1.0)
    inertia = 0.01 * 0.02**3 / 12.0
    assert_allclose(frame.solve().displacement("B")[:, 1], length**3 / (3.0 * 200e9 * inertia), rtol=1e-12)


class _Growing(Rewritten):
    """Its second half has two springs more."""

    def part(self, index: int, count: int) -> LineElement:
        return Rewritten(self.inner.part(index, count), 2 * index)


def test_parts_of_different_springs() -> None:
    """They are one member all the same; only its sensitivity has no common springs."""
    found = []
    for beam in (Beam(BAR, STEEL, segments=2), _Growing(Beam(BAR, STEEL, segments=2))):
        frame = _add(beam)
        frame.fix("A")
        frame.load("B", fy=1.0)
        found.append(np.concatenate([frame.solve().displacement("B"), frame.modes(2).frequencies]))
    assert_allclose(found[1], found[0], rtol=1e-10, atol=1e-15)


def test_refused_elements_leave_no_trace() -> None:
    frame = Frame()
    frame.node("A", (0.0, 0.0, 0.0))
    frame.node("B", (1.0, 0.0, 0.0))
    before = repr(frame.copy().__getstate__()), dict(frame._examined)
    with pytest.raises(FrameError):
        frame.add("AB", _wrong("axes", lambda a: 2.0 * a), "A", "B")
    frame.node("C", np.ones((3, 1)) * (0.0, 0.0, 1.0))
    before = repr(frame.copy().__getstate__()), dict(frame._examined)
    with pytest.raises(FrameError, match="does not broadcast"):
        frame.add("AB", Rewritten(Beam(BAR, Material(E=np.full(4, 2e11), nu=0.3))), "A", "B")
    assert (repr(frame.copy().__getstate__()), dict(frame._examined)) == before


def test_masses_are_examined() -> None:
    class Lopsided(RewrittenMass):
        def mass_matrix(self) -> Array:
            return super().mass_matrix() + np.eye(6, k=1)

    frame = Frame()
    frame.node("A", (0.0, 0.0, 0.0))
    with pytest.raises(FrameError, match="Lopsided of mass 'm': mass_matrix returned a matrix that is not symmetric"):
        frame.add("m", Lopsided(PointMass(1.0)), "A")
