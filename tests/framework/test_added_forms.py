"""Forms of scikit-fem's on members: against closed forms, scikit-fem's assembly and the same thing said otherwise."""

from __future__ import annotations

import pickle
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import skfem
from linkframe.elements import ArcLengthMapping, Beam, Circle, ElementLineFrame, Material, Rectangle, Section, Spring
from linkframe.framework import Frame, FrameError
from linkframe.models import Linkage
from numpy.testing import assert_allclose
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
E, DENSITY, WIDTH, DEPTH, LENGTH, FORCE = 210e9, 7850.0, 0.04, 0.06, 4.0, 1000.0
AREA, INERTIA = WIDTH * DEPTH, WIDTH * DEPTH**3 / 12.0
BAR, STEEL = Rectangle(y=DEPTH, z=WIDTH), Material(E=E, nu=0.3, density=DENSITY)


@skfem.BilinearForm
def foundation(u: Any, v: Any, w: Any) -> Any:
    return w.k * u[1] * v[1]


@skfem.BilinearForm
def carried(u: Any, v: Any, w: Any) -> Any:
    return w.m * (u[0] * v[0] + u[1] * v[1] + u[2] * v[2])


@skfem.BilinearForm
def curved(u: Any, v: Any, w: Any) -> Any:
    return w.EI * u.grad[5] * v.grad[5]


@skfem.LinearForm
def heat(v: Any, w: Any) -> Any:
    return w.force * v.grad[0]


def footing(modulus: ArrayLike, segments: int = 16) -> Frame:
    """A beam on two halves of foundation, pushed down in its middle."""
    frame = Frame()
    for name, x in {"A": 0.0, "B": LENGTH / 2, "C": LENGTH}.items():
        frame.node(name, (x, 0.0, 0.0))
    beam = Beam(BAR, STEEL, segments=segments)
    frame.add("AB", beam, "A", "B")
    frame.add("BC", beam, "B", "C")
    frame.fix("A", "ux", "uz", "rx", "ry")
    frame.load("B", fy=-FORCE)
    frame.add_form(foundation, on="beam", k=modulus)
    return frame


def hetenyi(modulus: ArrayLike) -> Array:
    """Deflection below the load (Hetényi, *Beams on Elastic Foundation*, 1946, ch. III)."""
    k = np.asarray(modulus)
    rate = (k / (4.0 * E * INERTIA)) ** 0.25
    z = rate * LENGTH
    return np.asarray(FORCE * rate / (2.0 * k) * (np.cosh(z) + np.cos(z) + 2.0) / (np.sinh(z) + np.sin(z)))


@pytest.mark.parametrize("method", ["broadcast", "banded", "sparse", "iterative"])
def test_foundation(method: str) -> None:
    solution = footing(2e5).solve(method)
    assert_allclose(-solution.displacement("B")[1], hetenyi(2e5), rtol=1e-6)
    off = np.abs(solution.displacement("B") - solution.refined("B")[0])
    assert (off <= solution.error_bound("B")).all()
    assert (solution.error_bound("B") < 1e-9 * np.abs(solution.displacement("B")).max()).all()


def test_foundation_over_a_batch() -> None:
    modulus = np.geomspace(1e5, 1e6, 6000)
    solution = footing(modulus, segments=4).solve()
    assert_allclose(-solution.displacement("B")[:, 1], hetenyi(modulus), rtol=1e-3)
    for entry in (0, -1):
        alone = footing(modulus[entry], segments=4).solve()
        bound = solution.error_bound("B")[entry] + alone.error_bound("B")
        assert (np.abs(solution.displacement("B")[entry] - alone.displacement("B")) <= bound).all()


def test_foundation_in_all_else() -> None:
    """Modes of a beam afloat, buckling, sensitivity by differences; large displacement says why not."""
    frame, modulus, step = footing(2e5, segments=8), 2e5, 1e-5
    afloat = np.sqrt(modulus / (DENSITY * AREA)) / (2.0 * np.pi)
    assert np.abs(frame.modes(4).frequencies / afloat - 1.0).min() < 1e-4
    shares = footing(modulus, segments=2).solve().sensitivity("B", "uy").members["AB"]
    both = sum(
        footing(modulus, segments=2).solve().sensitivity("B", "uy").members[name][6:].sum() for name in ("AB", "BC")
    )
    up, down = (footing(modulus * (1.0 + s), 2).solve().displacement("B")[1] for s in (step, -step))
    assert len(shares) > 6
    assert_allclose(both, (up - down) / (2.0 * step), rtol=1e-6)
    with pytest.raises(FrameError, match=r"member 'AB' \(Beam with form 'foundation'\) resists rigid motion"):
        frame.solve(large=True).displacement("B")


def test_buckling_on_a_foundation() -> None:
    """A hinged bar on foundation: n^2 + a / n^2 half-waves times Euler's load (Timoshenko & Gere 1961, sec. 2.10)."""
    frame, a = Frame(), 20.0
    inertia = DEPTH * WIDTH**3 / 12.0
    modulus = a * np.pi**4 * E * inertia / LENGTH**4
    for name, x in {"A": 0.0, "B": LENGTH}.items():
        frame.node(name, (x, 0.0, 0.0))
    frame.add("AB", Beam(Rectangle(y=WIDTH, z=DEPTH), STEEL, segments=16), "A", "B")
    frame.fix("A", "ux", "uy", "uz", "rx", "ry")
    frame.fix("B", "uy", "uz", "rx", "ry")
    frame.load("B", fx=-1.0)
    frame.add_form(foundation, on="AB", k=modulus)
    loads = [np.pi**2 * E * inertia / LENGTH**2 * (n**2 + a / n**2) for n in (1, 2, 3)]
    assert_allclose(frame.buckling(1).factors, min(loads), rtol=1e-4)


@pytest.mark.parametrize("place", [(2.0, 0.0, 0.0), (1.0, 0.5, -0.3)])
def test_frame_has_the_matrices_that_scikit_fem_assembles(place: tuple[float, float, float]) -> None:
    """Stiffness with coupled terms, mass and load, tapered by their place on the member, on a taper as well."""

    @skfem.BilinearForm
    def coupled(u: Any, v: Any, w: Any) -> Any:
        across = (u[1] + 0.3 * u[2]) * (v[1] + 0.3 * v[2]) + 2.0 * u.grad[5] * v.grad[5]
        return w.k * across + 1e4 * (u[1] - 0.2 * u[5]) * (v[1] - 0.2 * v[5]) + u[3] * v[3] * w.k

    @skfem.LinearForm
    def pushed(v: Any, w: Any) -> Any:
        return w.q * v[2] + 3.0 * v[5] + 0.5 * v.grad[1] + 7.0 * v.grad[4]

    for beam in (Beam(BAR, STEEL), Beam(BAR, STEEL, end=Rectangle(y=0.03, z=0.05), shear=True)):
        frame = Frame()
        frame.node("A", (0.0, 0.0, 0.0))
        frame.node("B", place)
        frame.add("AB", beam, "A", "B")
        bare = frame.matrices()
        frame.add_form(coupled, on="AB", k=[3e5, 4e5])
        frame.add_form(carried, on="AB", into="mass", m=5.0)
        frame.add_form(pushed, on="AB", q=[30.0, 50.0])
        with_forms = frame.matrices(1)
        fractions, weights = beam.integration_points
        mesh = bare.mesh
        basis = skfem.Basis(
            mesh,
            ElementLineFrame(beam),
            ArcLengthMapping(mesh),
            quadrature=(np.ravel(fractions)[None], np.ravel(weights)),
        )
        for added, form in (
            (with_forms.K - bare.K, coupled.assemble(basis, k=4e5)),
            (with_forms.M - bare.M, carried.assemble(basis, m=5.0)),
        ):
            assert_allclose(added.toarray(), form.toarray(), atol=1e-12 * np.abs(form).max())
        assert_allclose(with_forms.f, pushed.assemble(basis, q=50.0), atol=1e-11)


def test_stiffening_is_a_stiffer_beam_anywhere() -> None:
    """A form of curvature, of which rigid motion is free: as a beam of greater inertia, also at large displacement."""

    @skfem.BilinearForm
    def stiffening(u: Any, v: Any, w: Any) -> Any:
        return w.EI * (u.grad[5] * v.grad[5] + u.grad[4] * v.grad[4])

    section = Circle(diameter=0.02)
    steel = Material(E=E, nu=0.3)
    found = []
    for factor in (1.0, 3.0):
        frame = Frame()
        frame.node("A", (0.0, 0.0, 0.0))
        frame.node("B", (0.3, 0.8, 0.2))
        area, inertia, twist = float(section.A), float(section.Iy), float(section.J)
        own = Section(A=area, Iy=inertia * factor, Iz=inertia * factor, J=twist)
        frame.add("AB", Beam(own, steel, segments=6), "A", "B")
        if factor == 1.0:
            frame.add_form(stiffening, on="AB", EI=2.0 * E * inertia)
        frame.fix("A")
        frame.load("B", fz=[-10.0, -300.0])
        found.append(frame)
    formed, plain = found
    assert_allclose(formed.solve().displacement("B"), plain.solve().displacement("B"), rtol=1e-9, atol=1e-15)
    large = [frame.solve(large=True).displacement("B") for frame in found]
    assert_allclose(*large, rtol=1e-7, atol=1e-12)


def test_added_mass() -> None:
    frame = footing(2e5, segments=4)
    before = frame.modes(2).frequencies
    frame.add_form(carried, on=["AB", "BC"], into="mass", m=[0.0, 3.0 * DENSITY * AREA])
    after = frame.modes(2).frequencies
    assert_allclose(after[0], before, rtol=1e-9)
    assert_allclose(after[1, 0], before[0] / 2.0, rtol=1e-3)


def test_heat() -> None:
    """Free, a bar grows and carries nothing; held, it pushes, and buckles at Euler's load."""
    frame = Frame()
    frame.node("A", (0.0, 0.0, 0.0))
    frame.node("B", (2.0, 1.0, 0.0))
    frame.add("AB", Beam(Rectangle(y=0.02, z=0.02), STEEL, segments=8), "A", "B")
    frame.fix("A")
    rise = np.array([1e-4, 2e-4])
    stiff = E * 0.02**2
    frame.add_form(heat, on="AB", force=stiff * rise)
    free = frame.solve()
    # across the bar a rounding of the load is multiplied by the square of its slenderness, 1.5e5
    moved, along = free.displacement("B")[:, :2], np.array([2.0, 1.0])
    assert_allclose(moved @ along, rise * 5.0, rtol=1e-15)
    assert (np.abs(moved - rise[:, None] * along) <= free.error_bound("B")[:, :2]).all()
    assert_allclose(free.forces("AB", [0.3, 1.0]), 0.0, atol=1e-9 * stiff * 1e-4)
    assert_allclose(free.displacement_along("AB", [np.sqrt(5.0) / 3.0])[:, 0, 0], rise * 2.0 / 3.0, rtol=1e-12)
    assert (np.abs(free.end_forces("AB")) <= free.error_bound("AB", "end_forces")).all()
    assert free.linear.all()
    assert_allclose(frame.solve(large=True).displacement("B"), free.displacement("B"), rtol=1e-9, atol=1e-12)
    frame.fix("B")
    held = frame.solve()
    assert_allclose(held.forces("AB", [0.3])[:, 0, 0], -stiff * rise, rtol=1e-12)
    assert_allclose(held.reaction("A")[:, :2], stiff * rise[:, None] * np.array([2.0, 1.0]) / np.sqrt(5.0), rtol=1e-12)
    euler = 4.0 * np.pi**2 * E * 0.02**4 / 12.0 / 5.0
    assert_allclose(frame.buckling(1).factors[:, 0], euler / (stiff * rise), rtol=1e-3)


def test_heat_that_depends_on_the_place() -> None:
    """A bar warmer towards its end, in segments: it grows by the integral."""
    frame = Frame()
    frame.node("A", (0.0, 0.0, 0.0))
    frame.node("B", (2.0, 0.0, 0.0))
    frame.node("C", (5.0, 0.0, 0.0))
    beam = Beam(BAR, STEEL, segments=3)
    frame.add("AB", beam, "A", "B")
    frame.add("BC", beam, "B", "C")
    frame.fix("A")
    warm = skfem.LinearForm(lambda v, w: w.force * w.x[0] * v.grad[0])
    frame.add_form(warm, on="beam", force=1e-4 * E * AREA)
    solution = frame.solve()
    assert_allclose(solution.displacement("B")[0], 1e-4 * 2.0**2 / 2.0, rtol=1e-12)
    assert_allclose(solution.displacement("C")[0], 1e-4 * (2.0**2 + 3.0**2) / 2.0, rtol=1e-12)
    assert_allclose(solution.displacement_along("BC", [1.3])[0, 0], 1e-4 * (2.0**2 + 1.3**2) / 2.0, rtol=1e-12)


def test_load_by_a_form_is_a_line_load() -> None:
    """Linear over the member: as the line load, in all that a solution has."""
    frames = []
    for by_form in (True, False):
        frame = Frame()
        frame.node("A", (0.0, 0.0, 0.0))
        frame.node("B", (2.0, 1.0, 0.5))
        frame.add("AB", Beam(BAR, STEEL, segments=2), "A", "B")
        frame.fix("A")
        frame.fix("B", "ux", "uy", "uz")
        length = float(frame.length("AB"))
        if by_form:
            ramp = skfem.LinearForm(lambda v, w: (w.q + 5.0 * w.x[0]) * v[1])
            frame.add_form(ramp, on="AB", q=np.array([3.0, 4.0]))
        else:
            q = np.array([3.0, 4.0])
            frame.line_load("AB", fy=(q, q + 5.0 * length), local=True)
        frames.append(frame)
    one, other = (frame.solve() for frame in frames)
    at = [0.4, 1.7]
    for result in ("forces", "displacement_along", "stress"):
        found, wanted = getattr(one, result)("AB", at), getattr(other, result)("AB", at)
        assert_allclose(found, wanted, atol=1e-11 * np.abs(wanted).max())
    assert_allclose(one.reaction("B"), other.reaction("B"), atol=1e-12)
    large = [frame.solve(large=True).displacement_along("AB", [1.0]) for frame in frames]
    assert_allclose(*large, rtol=1e-9, atol=1e-15)


def test_form_on_a_body() -> None:
    frame = footing(2e5)
    frame.body("table")
    frame.node("D", (0.0, 0.0, 0.0), body="table")
    frame.node("E", (1.0, 0.0, 0.0), body="table")
    frame.add("DE", Spring(stiffness=1e3), "D", "E")
    frame.add_form(foundation, on="table", k=1.0)
    assert "form" in frame.members["DE"].element.title
    assert frame.members["AB"].element.title.count("form") == 1


def test_forms_in_the_frame_of_a_motion() -> None:
    """On a link by its name, with a batch of its own beside that of poses; entries are those alone, with bounds."""
    bar = Beam(Rectangle(y=0.02, z=0.01), STEEL)
    linkage = Linkage(A=(0, 0), B=(0, 0.3), P=(0.2, 0.5), D=(0.5, 0.4), E=(0.5, 0))
    for name, points in {"crank": "AB", "coupler": "BPD", "rocker": "DE"}.items():
        linkage.link(name, *points, beam=bar)
    linkage.revolute("A", "ground", "crank", drive=True)
    for name, pair in {"B": ("crank", "coupler"), "D": ("coupler", "rocker"), "E": ("rocker", "ground")}.items():
        linkage.revolute(name, *pair)
    linkage.load("P", fy=-100.0)
    motion, stiffer = linkage.move(A=np.linspace(0.0, 0.5, 3)[:, None]), np.linspace(0.0, 1000.0, 400)
    plain = motion.frame().solve().displacement("P")
    frame = motion.frame()
    frame.add_form(curved, on="coupler", EI=stiffer)
    solution = frame.solve()
    found = solution.displacement("P")
    assert found.shape == (3, 400, 6)
    assert_allclose(found[:, :1], plain, rtol=1e-9, atol=1e-16)
    assert (np.diff(np.abs(found[..., 1]), axis=-1) < 0.0).all()
    alone = motion.frame()
    alone.add_form(curved, on=["coupler.1", "coupler.2"], EI=stiffer[-1])
    one = alone.solve()
    bound = one.error_bound("P") + solution.error_bound("P")[:, -1:]
    assert (np.abs(one.displacement("P") - found[:, -1:]) <= bound).all()
    again = pickle.loads(pickle.dumps(alone))
    assert_allclose(again.solve().displacement("P"), one.displacement("P"), rtol=1e-12)


@pytest.mark.parametrize(
    ("act", "told"),
    [
        (lambda f: f.add_form(lambda u, v, w: u[0] * v[0], on="AB"), "give a skfem.BilinearForm"),
        (lambda f: f.add_form(foundation, on="XY", k=1.0), "add_form: on 'XY' is unknown"),
        (lambda f: f.add_form(foundation, on="AB"), "form 'foundation' failed: the form asks for w.k"),
        (lambda f: f.add_form(foundation, on="AB", k=-1.0), "form 'foundation' is not positive semidefinite"),
        (lambda f: f.add_form(foundation, on="AB", k=np.nan), "parameter k contains nan"),
        (lambda f: f.add_form(foundation, on="AB", into="load", k=1.0), "into='load' for a BilinearForm"),
        (lambda f: f.add_form(heat, on="AB", into="mass", force=1.0), "into='mass' for a LinearForm"),
        (lambda f: f.add_form(foundation, on="AB", intorder=-1, k=1.0), "intorder=-1"),
        (
            lambda f: f.add_form(skfem.BilinearForm(lambda u, v, w: u[1] * v[2]), on="AB"),
            "is not symmetric in u and v",
        ),
        (lambda f: f.add_form(foundation, on="AB", k=[1.0, 2.0, 3.0, 4.0]), "does not broadcast"),
    ],
)
def test_what_is_wrong_is_refused_at_the_call(act: Callable[[Frame], None], told: str) -> None:
    frame = footing([1e5, 2e5, 3e5], segments=1)
    before = frame.members["AB"].element, frame.shape
    with pytest.raises(FrameError, match=told):
        act(frame)
    assert (frame.members["AB"].element, frame.shape) == before


def test_forms_stay_on_a_member_that_is_changed() -> None:
    """Another beam, another place of its end: as if described so, with forms that depend on the place too."""
    slope = skfem.BilinearForm(lambda u, v, w: (1e4 + 1e3 * w.x[0]) * u[1] * v[1])
    warmed = skfem.LinearForm(lambda v, w: 1e3 * (1.0 + w.x[0]) * v.grad[0])

    def described(end: float, depth: float) -> Frame:
        frame = Frame()
        frame.node("A", (0.0, 0.0, 0.0))
        frame.node("B", (end, 0.0, 0.0))
        frame.add("AB", Beam(Rectangle(y=depth, z=WIDTH), STEEL, segments=4), "A", "B")
        frame.fix("A")
        frame.load("B", fy=-FORCE)
        frame.add_form(slope, on="AB")
        frame.add_form(warmed, on="AB", into="load")
        return frame

    changed = described(2.0, 0.06)
    changed.change("AB", Beam(Rectangle(y=0.08, z=WIDTH), STEEL, segments=4))
    changed.change("B", (3.0, 0.0, 0.0))
    assert_allclose(changed.solve().displacement("B"), described(3.0, 0.08).solve().displacement("B"), rtol=1e-14)
    before = changed.members["AB"]
    with pytest.raises(FrameError):
        changed.change("B", (0.0, 0.0, 0.0))
    assert changed.members["AB"] is before


def test_a_batch_of_a_form_that_varies_along_several_members() -> None:
    """Members have no batch of their own, so that theirs is not taken for that of the parameters."""
    growing = skfem.BilinearForm(lambda u, v, w: w.k * (1.0 + w.x[0]) * u[1] * v[1])

    def sunk(k: ArrayLike) -> Array:
        frame = Frame()
        for name, x in {"A": 0.0, "B": 1.0, "C": 3.0}.items():
            frame.node(name, (x, 0.0, 0.0))
        rod = Beam(Circle(diameter=0.05), STEEL)
        frame.add("AB", rod, "A", "B")
        frame.add("BC", rod, "B", "C")
        frame.fix("A")
        frame.add_form(growing, on=("AB", "BC"), k=k)
        frame.load("C", fy=-100.0)
        return frame.solve().displacement("C")

    batch = np.array([1e4, 2e4, 5e4])
    assert_allclose(sunk(batch), [sunk(k) for k in batch], rtol=1e-12)


@pytest.mark.parametrize("segments", [1, 3])
def test_heat_that_depends_on_the_place_counts_where_nodes_are_moved(segments: int) -> None:
    """A strain that grows from the start on lengthens a rod by ``F L^2 / (2 E A)``, by ``F L / (E A)`` a length."""
    frame = Frame()
    frame.node("A", (0.0, 0.0, 0.0))
    frame.node("B", (LENGTH, 0.0, 0.0))
    frame.add("AB", Beam(BAR, STEEL, segments=segments), "A", "B")
    frame.fix("A")
    frame.add_form(skfem.LinearForm(lambda v, w: w.force * w.x[0] * v.grad[0]), on="AB", force=5e4)
    solution = frame.solve()
    found = solution.sensitivity("B", "ux").nodes
    assert_allclose(solution.displacement("B")[0], 5e4 * LENGTH**2 / (2.0 * E * AREA), rtol=1e-12)
    assert_allclose([found["B"][0], -found["A"][0]], 5e4 * LENGTH / (E * AREA), rtol=1e-9)


@pytest.mark.parametrize("size", ["y", "end.z"])
def test_a_taper_on_a_foundation_by_the_sizes_of_its_ends(size: str) -> None:
    """Its parts have their shares of both ends: differences of solutions in one batch, of two members of one beam."""
    step = 1e-4 * np.array([0.0, 1.0, -1.0, 2.0, -2.0])
    start, end = {"y": DEPTH, "z": WIDTH}, {"y": DEPTH / 2.0, "z": WIDTH / 3.0}
    of, name = (end, size[-1]) if size.startswith("end") else (start, size)
    value = of[name]
    of[name] = value * (1.0 + step)
    frame = Frame()
    frame.node("A", (0.0, 0.0, 0.0))
    frame.node("B", (LENGTH, 0.3, 0.2))
    frame.node("C", (0.5 * LENGTH, LENGTH, 0.1))
    taper = Beam(Rectangle(**start), STEEL, end=Rectangle(**end), segments=2)
    frame.add("AB", taper, "A", "B")
    frame.add("CB", taper, "C", "B")
    frame.fix("A")
    frame.fix("C")
    frame.add_form(skfem.BilinearForm(lambda u, v, w: w.k * (u[1] * v[1] + u[2] * v[2])), on=("AB", "CB"), k=2e4)
    frame.load("B", fy=10.0, fz=30.0)
    solution = frame.solve()
    sections, moved = solution.sensitivity("B", "uz").sections, solution.displacement("B")[:, 2]
    found = sections["AB"][size][0] + sections["CB"][size][0]
    expected = (8.0 * (moved[1] - moved[2]) - (moved[3] - moved[4])) / (12.0 * step[1] * value)
    assert_allclose(found, expected, rtol=1e-8)


def test_a_form_on_a_batch_of_tapers_is_taken_whatever_its_last_digits() -> None:
    """What is summed along a taper differs in its last bit where less of the batch is summed at once."""
    rng = np.random.default_rng(0)
    for release in ((), "end ux", ("start rz", "start ry")):
        thick, thin = rng.uniform(0.02, 0.05, (2, 16))
        frame = Frame()
        frame.node("A", (0.0, 0.0, 0.0))
        frame.node("B", (1.0, 0.3, 0.2))
        frame.add("AB", Beam(Circle(diameter=thick), STEEL, end=Circle(diameter=thin), release=release), "A", "B")
        frame.fix("A")
        frame.add_form(carried, on="AB", into="mass", m=rng.uniform(1.0, 2.0, 16))
        assert frame.modes(1).frequencies.shape == (16, 1)
