"""Elements that a user writes: a beam on Winkler foundation as fourteen springs, against closed forms and 50 digits."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass
from pathlib import Path

import mpmath as mp
import numpy as np
import pytest
import skfem
from linkframe.elements import Beam, Material, Rectangle
from linkframe.framework import Frame, FrameError
from numpy.testing import assert_allclose
from numpy.typing import ArrayLike, NDArray
from reference.own_elements import POINTS, WEIGHTS, Delegating, Winkler

Array = NDArray[np.float64]
E, NU, WIDTH, DEPTH = 200e9, 0.3, 0.05, 0.1
STEEL, BAR = Material(E=E, nu=NU, density=7850.0), Rectangle(y=DEPTH, z=WIDTH)
METHODS = ("broadcast", "banded", "sparse", "iterative")
LENGTH, FORCE = 4.0, 1000.0


def _footing(modulus: ArrayLike, segments: int = 1, E: float = E) -> Frame:
    """A beam on foundation along x, pushed along y at its start; nothing else holds it across."""
    frame = Frame()
    frame.node("A", (0.0, 0.0, 0.0))
    frame.node("B", (LENGTH, 0.0, 0.0))
    beam = Beam(BAR, Material(E=E, nu=NU, density=7850.0), segments=segments)
    frame.add("AB", Winkler(beam, np.asarray(modulus, dtype=np.float64)), "A", "B")
    frame.fix("A", "ux", "rx")
    frame.load("A", fy=FORCE)
    return frame


def _hetenyi(modulus: Array | float) -> tuple[Array, Array]:
    """Deflection at the loaded and at the other end (Hetényi, *Beams on Elastic Foundation*, 1946, sec. 21)."""
    inertia = WIDTH * DEPTH**3 / 12.0
    rate = (np.asarray(modulus) / (4.0 * E * inertia)) ** 0.25
    s, c, sh, ch = (f(rate * LENGTH) for f in (np.sin, np.cos, np.sinh, np.cosh))
    scale = 2.0 * FORCE * rate / modulus / (sh**2 - s**2)
    return scale * (sh * ch - s * c), -scale * (ch * s - sh * c)


def _corner(modulus: float) -> Frame:
    """Two members on foundation at an angle, held by nothing else."""
    frame = Frame()
    for name, place in _PLACES.items():
        frame.node(name, place)
    for name, (start, end) in _MEMBERS.items():
        frame.add(name, Winkler(Beam(BAR, STEEL), np.array(modulus)), start, end)
    for name, force in _LOADS.items():
        frame.load(name, **dict(zip(("fx", "fy", "fz", "mx", "my", "mz"), force, strict=True)))
    return frame


_PLACES = {"A": (0.0, 0.0, 0.0), "B": (2.0, 0.3, 0.0), "C": (1.7, 1.9, 0.0)}
_MEMBERS = {"AB": ("A", "B"), "BC": ("B", "C")}
_LOADS = {"A": (10.0, -20.0, 5.0, 1.0, 0.5, -2.0), "C": (3.0, 7.0, -11.0, 0.3, 2.0, 1.0)}


def _fifty_digits(modulus: float) -> tuple[list[mp.mpf], dict[str, list[mp.mpf]]]:
    """Displacements of the nodes of `_corner`, and end forces, by the stiffness method."""
    nodes = list(_PLACES)
    whole, load = mp.zeros(18), mp.zeros(18, 1)
    parts = {}
    for name, ends in _MEMBERS.items():
        apart = [mp.mpf(_PLACES[ends[1]][k]) - mp.mpf(_PLACES[ends[0]][k]) for k in range(2)]
        length = mp.sqrt(apart[0] ** 2 + apart[1] ** 2)
        c, s = (each / length for each in apart)
        turn = mp.zeros(12)
        for block in range(4):
            for row, values in enumerate(((c, s, 0), (-s, c, 0), (0, 0, 1))):
                for column, value in enumerate(values):
                    turn[3 * block + row, 3 * block + column] = value
        local = _local(length, modulus)
        dofs = [6 * nodes.index(node) + k for node in ends for k in range(6)]
        matrix = turn.T * local * turn
        for i, a in enumerate(dofs):
            for j, b in enumerate(dofs):
                whole[a, b] += matrix[i, j]
        parts[name] = (local, turn, dofs)
    for name, force in _LOADS.items():
        for k, value in enumerate(force):
            load[6 * nodes.index(name) + k] = value
    found = mp.lu_solve(whole, load)
    ends_of = {
        name: list(local * turn * mp.matrix([found[k] for k in dofs])) for name, (local, turn, dofs) in parts.items()
    }
    return list(found), ends_of


def _local(length: mp.mpf, modulus: float) -> mp.matrix:
    """The beam's stiffness (Przemieniecki 1968, Eq. 5.116) and the foundation's at the Gauss points."""
    y, z, young = mp.mpf(DEPTH), mp.mpf(WIDTH), mp.mpf(E)
    out = mp.zeros(12)
    for dof, k in ((0, young * y * z / length), (3, young / (2 * (1 + mp.mpf(NU))) * mp.mpf(BAR.J) / length)):
        out[dof, dof] = out[dof + 6, dof + 6] = k
        out[dof, dof + 6] = out[dof + 6, dof] = -k
    for inertia, dofs, sign in ((z * y**3 / 12, (1, 5, 7, 11), 1), (y * z**3 / 12, (2, 4, 8, 10), -1)):
        bending, shear = [0, -1, 0, 1], [1, length / 2, -1, length / 2]
        springs = [(young * inertia / length, bending), (12 * young * inertia / length**3, shear)]
        for point, weight in zip(POINTS.tolist(), WEIGHTS.tolist(), strict=True):
            p = mp.mpf(point)
            row = [1 - 3 * p**2 + 2 * p**3, length * (p - 2 * p**2 + p**3), 3 * p**2 - 2 * p**3, length * (p**3 - p**2)]
            springs.append((mp.mpf(modulus) * length * mp.mpf(weight), row))
        for k, row in springs:
            for i, a in enumerate(dofs):
                for j, b in enumerate(dofs):
                    out[a, b] += k * row[i] * row[j] * (sign if i % 2 else 1) * (sign if j % 2 else 1)
    return out


# -- closed form ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("method", METHODS)
def test_hetenyi(method: str) -> None:
    frame = _footing(2e5, segments=24)
    solution = frame.solve(method)
    here, there = _hetenyi(2e5)
    assert str(solution.status) == "regular"
    assert_allclose(solution.displacement("A")[1], here, rtol=1e-6)
    assert_allclose(solution.displacement("B")[1], there, rtol=1e-6)
    off = np.abs(solution.displacement("A") - solution.refined("A")[0])
    assert (off <= solution.error_bound("A")).all()
    assert (solution.error_bound("A") < 1e-9 * here).all()


@pytest.mark.parametrize("count", [3, 500, 6000])
def test_a_batch_is_its_entries(count: int) -> None:
    """Short, long, and so long that members are assembled chunk by chunk."""
    modulus = np.geomspace(1e4, 1e6, count)
    solution = _footing(modulus, segments=3).solve()
    assert_allclose(solution.displacement("A")[:, 1], _hetenyi(modulus)[0], rtol=5e-3)
    for entry in (0, count - 1):
        alone = _footing(modulus[entry], segments=3).solve()
        for result in ("displacement", "end_forces"):
            name = "AB" if result == "end_forces" else "A"
            one, batch = getattr(alone, result)(name), getattr(solution, result)(name)[entry]
            assert_allclose(batch, one, rtol=1e-11, atol=1e-13 * np.abs(one).max())
            bound = solution.error_bound(name, result)[entry] + alone.error_bound(name, result)
            assert (np.abs(batch - one) <= bound).all()


# -- error bounds ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("modulus", [1e6, 1.0, 1e-4])
@pytest.mark.parametrize("method", METHODS)
def test_bounds_hold_without_any_support(method: str, modulus: float) -> None:
    """Down to a foundation that resists 1e-14 of what the members do, which takes extended precision."""
    with mp.workdps(50):
        moved, forces = _fifty_digits(modulus)
        solution = _corner(modulus).solve(method)
        assert str(solution.status) == "regular"
        for number, node in enumerate(_PLACES):
            _within(moved[6 * number : 6 * number + 6], *solution.refined(node))
            _within(moved[6 * number : 6 * number + 6], solution.displacement(node), solution.error_bound(node))
        for name, wanted in forces.items():
            _within(wanted, solution.end_forces(name), solution.error_bound(name, "end_forces"))
            _within(wanted, *solution.refined(name, "end_forces"))
    assert (solution.error_bound("A") <= 1e-2 * np.abs(solution.displacement("A")).max()).all()


@pytest.mark.parametrize("method", ["broadcast", "sparse"])
def test_bounds_hold_on_a_foundation_by_a_form(method: str) -> None:
    """The same by a form of scikit-fem's on plain beams, at the same points of quadrature."""
    form = skfem.BilinearForm(lambda u, v, w: w.k * (u[1] * v[1] + u[2] * v[2]))
    with mp.workdps(50):
        moved, forces = _fifty_digits(1.0)
        frame = _corner(1.0)
        for name, member in frame.members.items():
            frame.members[name] = member._replace(element=Beam(BAR, STEEL))
        frame.add_form(form, on="beam", k=1.0)
        solution = frame.solve(method)
        for number, node in enumerate(_PLACES):
            _within(moved[6 * number : 6 * number + 6], *solution.refined(node))
            _within(moved[6 * number : 6 * number + 6], solution.displacement(node), solution.error_bound(node))
        for name, wanted in forces.items():
            _within(wanted, solution.end_forces(name), solution.error_bound(name, "end_forces"))


def _within(exact: Sequence[mp.mpf], found: Array, bound: Array) -> None:
    assert all(abs(e - mp.mpf(float(f))) <= mp.mpf(float(b)) for e, f, b in zip(exact, found, bound, strict=True)), [
        float((e - mp.mpf(float(f))) / mp.mpf(float(b))) for e, f, b in zip(exact, found, bound, strict=True)
    ]


# -- all else -------------------------------------------------------------------------------------------------------


def test_sensitivity_is_that_of_differences() -> None:
    modulus, step = np.array([1e5, 4e5]), 1e-5
    found = _footing(modulus, segments=2).solve().sensitivity("A", "uy")

    def slope(frames: tuple[Frame, Frame]) -> Array:
        up, down = (frame.solve().displacement("A")[..., 1] for frame in frames)
        return np.asarray((up - down) / (2.0 * step))

    shares = found.members["AB"]
    assert shares.shape == (2, 14)
    whole = [slope((_footing(modulus * (1 + step), 2), _footing(modulus * (1 - step), 2))),
             slope((_footing(modulus, 2, E * (1 + step)), _footing(modulus, 2, E * (1 - step))))]  # fmt: skip
    assert_allclose(shares[:, 6:].sum(axis=-1), whole[0], rtol=1e-7)
    assert_allclose(shares[:, :6].sum(axis=-1), whole[1], rtol=1e-7)


def test_modes_on_a_foundation() -> None:
    """A free beam on foundation heaves at sqrt(k / m), and bends at sqrt((beta^4 EI + k) / m)."""
    frame = _footing(2e5, segments=16)
    mass, inertia = 7850.0 * WIDTH * DEPTH, WIDTH * DEPTH**3 / 12.0
    squared = ((4.730040744862704 / LENGTH) ** 4 * E * inertia + 2e5) / mass
    found = frame.modes(6).frequencies
    assert_allclose(found[:2], np.sqrt(2e5 / mass) / (2.0 * np.pi), rtol=1e-3)
    assert np.abs(found - np.sqrt(squared) / (2.0 * np.pi)).min() < 5e-3 * found[0]


def test_buckling_on_a_foundation() -> None:
    """A long hinged bar: n^2 + a / n^2 half-waves times Euler's load, a = k L^4 / pi^4 E I (Timoshenko & Gere 1961)."""
    frame = Frame()
    frame.node("A", (0.0, 0.0, 0.0))
    frame.node("B", (LENGTH, 0.0, 0.0))
    inertia = WIDTH * DEPTH**3 / 12.0
    a = 20.0
    modulus = a * np.pi**4 * E * inertia / LENGTH**4
    frame.add("AB", Winkler(Beam(BAR, STEEL, segments=16), np.array(modulus)), "A", "B")
    frame.fix("A", "ux", "uy", "uz", "rx")
    frame.fix("B", "uy", "uz")
    frame.load("B", fx=-1.0)
    weak = inertia * (WIDTH / DEPTH) ** 2
    loads = [
        np.pi**2 * E * i / LENGTH**2 * (n**2 + modulus * LENGTH**4 / (np.pi**4 * E * i) / n**2)
        for i in (inertia, weak)
        for n in (1, 2, 3, 4)
    ]
    assert_allclose(frame.buckling(1).factors, min(loads), rtol=2e-4)


def test_what_ends_do_not_tell_is_refused(tmp_path: Path) -> None:
    solution = _footing(2e5, segments=2).solve()
    ends = solution.forces("AB", [0.0, LENGTH / 2, LENGTH])
    assert_allclose(ends[0], -solution.end_forces("AB")[:6], atol=1e-9)
    assert_allclose(ends[0, 1], -FORCE, rtol=1e-9)
    assert_allclose(ends[2], 0.0, atol=1e-9)
    with pytest.raises(FrameError, match=r"member 'AB' \(Winkler\) resists rigid motion"):
        solution.forces("AB", [0.3])
    with pytest.raises(FrameError, match=r"member 'AB' \(Winkler\) resists rigid motion"):
        _footing(2e5).solve(large=True).displacement("A")
    solution.save(tmp_path / "footing.vtu")


def test_a_row_of_members_is_condensed() -> None:
    """Forty members in line, whose nodes nothing else is on, against one of forty segments."""
    frame = Frame()
    frame.node("n0", (0.0, 0.0, 0.0))
    element = Winkler(Beam(BAR, STEEL), np.array(2e5))
    for k in range(1, 41):
        frame.node(f"n{k}", (LENGTH * k / 40, 0.0, 0.0))
        frame.add(f"m{k}", element, f"n{k - 1}", f"n{k}")
    frame.fix("n0", "ux", "rx")
    frame.load("n0", fy=FORCE)
    solution = frame.solve("broadcast")
    assert len(solution.plan.condensed.nodes) == 39
    assert_allclose(solution.displacement("n0")[1], _hetenyi(2e5)[0], rtol=1e-6)
    assert (solution.error_bound("n20") < 1e-10 * np.abs(solution.displacement("n0")).max()).all()


@dataclass(frozen=True, eq=False)
class Labelled(Delegating):
    """A beam with a number of its own in each batch entry that does not change its stiffness."""

    inner: Beam
    label: Array

    @property
    def shape(self) -> tuple[int, ...]:
        return self.label.shape

    @property
    def kind(self) -> Hashable:
        return self


@pytest.mark.parametrize("count", [3, 6000])
def test_a_batch_that_leaves_the_stiffness_as_it_is(count: int) -> None:
    found = []
    for element in (Labelled(Beam(BAR, STEEL), np.arange(float(count))), Beam(BAR, STEEL)):
        frame = Frame()
        for name, place in {"A": (0, 0, 0), "B": (2, 0.3, 0), "C": (1.7, 1.9, 0)}.items():
            frame.node(name, place)
        frame.add("AB", Beam(BAR, STEEL), "A", "B")
        frame.add("CB", element, "C", "B")
        frame.fix("A")
        frame.fix("C")
        frame.load("B", fx=10.0, fy=3.0, fz=1.0)
        found.append(frame.solve().displacement("B"))
    assert_allclose(found[0], np.broadcast_to(found[1], found[0].shape), rtol=1e-12)
